"""Derivatives of a surface that are those of another one."""

from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.surfaces.protocol import Surface

# Over the extent: errors of central differences are of its square, and rounding over it.
STEP = 1e-4
# Of the largest value.
MISTAKE = 1e-3
# Of slopes over the extent: the noise of second derivatives that are differences themselves.
NOISE = 1e-4
# Places that are looked at.
PLACES = 9


def check_derivatives(surface: Surface, places: np.ndarray, extent: np.ndarray) -> None:
    r"""InputError where derivatives of a surface contradict central differences of what they are derivatives of.

    .. math:: X_{,x} \approx \frac{X(x + h, y) - X(x - h, y)}{2 h}, \qquad
        X_{,xx} \approx \frac{X_{,x}(x + h, y) - X_{,x}(x - h, y)}{2 h}

    with h = 1e-4 of the extent. Surfaces of the library are right by their tests and are not looked at.

    Parameters
    ----------
    places : (2, n) array
        Places within the surface, farther than h from its bounds.
    extent : (2,) array
        Lengths of the mesh in x and y.
    """
    if type(surface).__module__.startswith("skancf."):
        return
    some = np.unique(np.linspace(0, places.shape[1] - 1, PLACES).round().astype(int))
    x, y = places[:, some]
    h = STEP * extent
    around_x = np.stack([x + h[0], x - h[0], x, x])
    around_y = np.stack([y, y, y + h[1], y - h[1]])
    position = np.asarray(surface.position(around_x.ravel(), around_y.ravel())).reshape(3, 4, -1)
    given = [np.asarray(v) for v in surface.derivatives(x, y)]
    rounding = 1e-14 * np.abs(position).max() / h
    slopes = [np.abs(v).max() for v in given]
    for axis, name in enumerate(("X_x", "X_y")):
        near = (position[:, 2 * axis] - position[:, 2 * axis + 1]) / (2 * h[axis])
        _compare(name, "derivatives", given[axis], near, x, y, MISTAKE * np.abs(near).max() + rounding[axis])
    if not hasattr(surface, "second_derivatives"):
        return
    second: Any = [np.asarray(v) for v in surface.second_derivatives(x, y)]
    around = [np.asarray(v).reshape(3, 4, -1) for v in surface.derivatives(around_x.ravel(), around_y.ravel())]
    for name, value, of, axis in zip(("X_xx", "X_xy", "X_yy"), second, (0, 0, 1), (0, 1, 1), strict=True):
        near = (around[of][:, 2 * axis] - around[of][:, 2 * axis + 1]) / (2 * h[axis])
        slack = MISTAKE * np.abs(near).max() + NOISE * slopes[of] / extent[axis]
        _compare(name, "second_derivatives", value, near, x, y, slack)


def _compare(
    name: str, method: str, given: np.ndarray, near: np.ndarray, x: np.ndarray, y: np.ndarray, slack: float
) -> None:
    given = np.broadcast_to(given, near.shape)
    off = np.abs(given - near).max(axis=0)
    if not (off <= slack).all():
        k = int(np.argmax(np.where(np.isnan(off), np.inf, off)))
        raise InputError(f"surface: its {method} give {name} = {given[:, k]} at (x, y) = ({x[k]:.6g}, {y[k]:.6g}), but "
                         f"differences give {near[:, k]}; correct one of them, or give the position to sk.MappedSurface, "
                         "which makes its derivatives")  # fmt: skip
