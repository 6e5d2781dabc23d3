"""Where the slope of a function jumps."""

from collections.abc import Callable

import numpy as np

from skancf.errors import InputError
from skancf.surfaces.protocol import Interval

# Places along a line, lines in each direction, and how often steps are divided by eight: 7.6e-6 of the range at the end.
PLACES = 257
LINES = 5
ZOOMS = 3
# Jump of a slope over the largest slope: half a degree. Single precision has 4e-3, four waves over the range 2e-4.
JUMP = 1e-2


def check_kinks(function: Callable[[np.ndarray, np.ndarray], np.ndarray], bounds: tuple[Interval, Interval]) -> None:
    r"""InputError where the slope of a function (x, y) -> (3, ...) jumps along one of a few lines in each direction.

    .. math:: J = \frac1h \max_t |X(t - h) - 2 X(t) + X(t + h)|

    falls with the step h where X is smooth, grows as h falls where X has noise, and stays between half the jump and all of
    it at a kink. Each place is looked at with smaller and smaller steps about its largest second difference.
    """
    for axis, (low, high) in enumerate(bounds):
        lines = np.linspace(*bounds[1 - axis], LINES + 2)[1:-1, None, None]

        def along(t: np.ndarray, axis: int = axis, lines: np.ndarray = lines) -> np.ndarray:
            t, fixed = np.broadcast_arrays(t, lines)
            return function(t, fixed) if axis == 0 else function(fixed, t)

        h = (high - low) / (PLACES - 1)
        places = np.linspace(low, high, PLACES)
        largest = np.linalg.norm(np.diff(along(places), axis=-1), axis=0).max() / h
        t = np.tile(places[1:-1], (LINES, 1))
        jumps = []
        for _ in range(ZOOMS):
            h /= 8
            near = np.clip(t[..., None] + h * np.arange(-8, 9), low, high)
            second = np.linalg.norm(np.diff(along(near), n=2, axis=-1), axis=0)
            jumps.append(second.max(axis=-1) / h)
            t = np.take_along_axis(near, 1 + second.argmax(axis=-1)[..., None], axis=-1)[..., 0]
        kink = (np.min(jumps, axis=0) > JUMP * largest) & (np.max(jumps, axis=0) < 3 * np.min(jumps, axis=0))
        if kink.any():
            where = np.where(kink, jumps[-1], 0.0)
            raise InputError(f"function: X_{'xy'[axis]} jumps by {where.max():.3g} at {'xy'[axis]} = "
                             f"{t.flat[where.argmax()]:.6g}, a kink; make two surfaces of it, or round it")  # fmt: skip
