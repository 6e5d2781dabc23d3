"""Derivatives of a surface that are those of another one."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from skancf.errors import InputError, shown
from skancf.surfaces.mapped import check_seam
from skancf.surfaces.protocol import Surface, closed_directions
from skancf.tolerances import DIFFERENCED, ROUNDED_SUM

# Of the largest value of a component.
MISTAKE = 1e-3
# The longest step of differences, over the extent. They stay within the element: elsewhere the surface need not be defined.
LONGEST = 1e-2
# Parts of it that are tried: short ones for what varies fast, long ones for what is noisy.
STEPS = (0.1, 0.3, 1.0, 0.03, 1e-2, 1e-3)
# Places in the middle of an element, near its corners, and the step of each over its width.
MIDDLE, NEAR_CORNER = (0.5, 0.4), (0.1, 0.08)
MOST_PLACES = 3000
# Places along and across a seam.
SEAM = 6


def check_derivatives(surface: Surface, mesh: Any) -> None:
    r"""InputError where derivatives of a surface contradict central differences of what they are derivatives of.

    .. math:: X_{,x} \approx \frac{X(x + h, y) - X(x - h, y)}{2 h}, \qquad
        X_{,xx} \approx \frac{X_{,x}(x + h, y) - X_{,x}(x - h, y)}{2 h}

    in the middle of each element and near each node. Several steps h are tried, and one that agrees is enough; noise of a
    millionth is no contradiction. Surfaces of the library are right by their tests and are not looked at, unless they have
    derivatives that were given. Directions that are said to be closed must come back to where they began.
    """
    if type(surface).__module__.startswith("skancf.") and getattr(surface, "exact_derivatives", None) is None:
        return
    _check_seams(surface)
    places, steps = _places(mesh)
    extent = np.ptp(mesh.p, axis=1)
    position = partial(_position, surface)

    def slope(axis: int, at: np.ndarray) -> np.ndarray:
        return _several(surface, "derivatives", at)[axis]

    here, slopes = position(places), np.stack(_several(surface, "derivatives", places))
    size, rounding = np.ptp(here, axis=1).max(), ROUNDED_SUM * np.abs(here).max()
    for axis, name in enumerate(("X_x", "X_y")):
        slack = (DIFFERENCED * size + rounding) / steps[axis]
        _compare(name, "derivatives", slopes[axis], position, axis, places, steps, slack)
    if not hasattr(surface, "second_derivatives"):
        return
    second = _several(surface, "second_derivatives", places)
    for name, given, of, axis in zip(("X_xx", "X_xy", "X_yy"), second, (0, 0, 1), (0, 1, 1), strict=True):
        # Of the longest slope in either direction: where one of them vanishes, its noise does not.
        noise = DIFFERENCED * np.abs(slopes * extent[:, None, None]).max() / extent[of]
        _compare(name, "second_derivatives", given, partial(slope, of), axis, places, steps, noise / steps[axis])


def _position(surface: Any, at: np.ndarray) -> np.ndarray:
    return _components("position", surface.position(*at), at)


def _several(surface: Any, method: str, at: np.ndarray) -> list[np.ndarray]:
    """The derivatives of an order at places (2, n), each (3, n)."""
    found = getattr(surface, method)(*at)
    names = NAMES[method]
    if not isinstance(found, tuple | list | np.ndarray) or len(found) != len(names):
        raise InputError(f"surface: its {method} return {shown(found)}; they must return {', '.join(names)}")
    return [_components(f"{name} of {method}", value, at) for name, value in zip(names, found, strict=True)]


NAMES = {"derivatives": ("X_x", "X_y"), "second_derivatives": ("X_xx", "X_xy", "X_yy")}


def _components(what: str, found: Any, at: np.ndarray) -> np.ndarray:
    n = at.shape[1]
    if not isinstance(found, np.ndarray) or found.shape not in ((3, n), (3, 1)) or found.dtype.kind not in "biuf":
        shape = f"an array of shape {found.shape}" if isinstance(found, np.ndarray) else f"a {type(found).__name__}"
        raise InputError(f"surface: {what} is {shape} at x and y of shape {(n,)}; it must be an array of numbers of shape "
                         f"{(3, n)}, the three components of space first, as np.stack makes it")  # fmt: skip
    values = np.broadcast_to(found, (3, n))
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=0))
    if wrong.size:
        (x, y), value = at[:, wrong[0]], values[:, wrong[0]]
        raise InputError(f"surface: {what} is {value} at (x, y) = ({x:.6g}, {y:.6g}): it must be finite")
    return values


def _check_seams(surface: Any) -> None:
    """The two ends of closed directions are one curve with one tangent plane."""
    closed = closed_directions(surface)
    if not any(closed):
        return
    x, y = np.meshgrid(*[np.linspace(low, high, SEAM) for low, high in surface.bounds], indexing="ij")
    at = np.stack([x.ravel(), y.ravel()])
    jet = [values.reshape(3, *x.shape) for values in (_position(surface, at), *_several(surface, "derivatives", at))]
    for axis in (0, 1):
        if closed[axis]:
            check_seam(axis, jet)


def _places(mesh: Any) -> tuple[np.ndarray, np.ndarray]:
    """Places (2, n) in elements, and steps (2, n) along x and y that do not leave these."""
    corners = mesh.p[:, mesh.t]
    ahead = np.roll(corners, -1, axis=1) - corners
    area = np.abs(ahead[0, 0] * ahead[1, 1] - ahead[1, 0] * ahead[0, 1])
    width = (area / np.ptp(corners, axis=1))[::-1]
    _, first = np.unique(mesh.t, return_index=True)
    corner, element = np.unravel_index(first, mesh.t.shape)
    middle = corners.mean(axis=1)
    near = corners[:, corner, element]
    near = near + 2 * NEAR_CORNER[0] * (middle[:, element] - near)
    places = np.hstack([middle, near])
    steps = np.hstack([MIDDLE[1] * width, NEAR_CORNER[1] * width[:, element]])
    some = np.unique(np.linspace(0, places.shape[1] - 1, MOST_PLACES).round().astype(int))
    return places[:, some], np.minimum(steps, LONGEST * np.ptp(mesh.p, axis=1)[:, None])[:, some]


def _compare(
    name: str,
    method: str,
    given: np.ndarray,
    function: Callable[[np.ndarray], np.ndarray],
    axis: int,
    places: np.ndarray,
    steps: np.ndarray,
    slack: np.ndarray,
) -> None:
    """InputError where given derivatives (3, n) along an axis are not near to differences of a function, for any step."""
    left, wrong = np.arange(places.shape[1]), np.ones(given.shape, dtype=bool)
    scale: np.ndarray | None = None
    for part in STEPS:
        at, h = places[:, left], part * steps[axis, left]
        off = np.zeros(at.shape)
        off[axis] = h
        near = (function(at + off) - function(at - off)) / (2 * h)
        if scale is None:
            scale, shown = np.abs(near).max(axis=1, keepdims=True), near
        # Each component by any step: where one varies fast another may be noise alone.
        wrong[:, left] &= ~(np.abs(given[:, left] - near) <= MISTAKE * scale + slack[left])
        left = np.flatnonzero(wrong.any(axis=0))
        if not left.size:
            return
    x, y = places[:, left[0]]
    raise InputError(f"surface: its {method} give {name} = {given[:, left[0]]} at (x, y) = ({x:.6g}, {y:.6g}), but "
                     f"differences give {shown[:, left[0]]} ({left.size} such places); correct one of them, or give the "
                     "position to sk.MappedSurface, which makes its derivatives")  # fmt: skip
