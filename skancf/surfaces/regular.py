"""Where a surface has a tangent plane."""

from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.surfaces.protocol import Surface, parameters
from skancf.tolerances import NO_AREA, ONE_PLACE, PARALLEL, VANISHED
from skancf.vectors import cross


def normal(surface: Surface, x: Any, y: Any) -> np.ndarray:
    r"""Unit normal :math:`\mathbf X_{,x} \times \mathbf X_{,y} / |\mathbf X_{,x} \times \mathbf X_{,y}|`, shape (3, ...).

    At a pole on a bound of the surface (the centre of a disc, the top of a sphere), where the product vanishes, its limit
    from inside: the direction of its derivative towards the middle of the surface.

    Raises
    ------
    InputError
        Where there is neither, such as on a fold; the point is named.

    Examples
    --------
    >>> print(sk.surfaces.normal(sk.CylinderSector(0.5, 1.0, np.pi), 0.5, np.pi / 2).round(3) + 0.0)
    [0. 0. 1.]
    """
    x, y = parameters(x, y)
    n = cross(*surface.derivatives(x, y))
    flat = _length(n) <= VANISHED * _largest_area(surface)
    if flat.any():
        n[:, flat] = _limit(surface, x[flat], y[flat])
    return np.asarray(n / _length(n))


def check_regular(surface: Surface, x: Any, y: Any) -> None:
    r"""The surface has area and a tangent plane at each of the points, such as the integration points of a mesh.

    Refused are points where :math:`\mathbf X_{,x}` and :math:`\mathbf X_{,y}` are parallel (a fold; relative to
    :math:`|\mathbf X_{,x}| |\mathbf X_{,y}|`) or where the area :math:`|\mathbf X_{,x} \times \mathbf X_{,y}|` vanishes
    against the square of the extent of all points. So poles are refused; integration points do not lie on them.

    Raises
    ------
    InputError
        Names the first such point by its parameters and its place in space.

    Examples
    --------
    >>> sk.surfaces.check_regular(sk.Rectangle(1.0, 1.0), np.array([0.5]), np.array([0.5]))
    """
    x, y = parameters(x, y)
    x_slope, y_slope = surface.derivatives(x, y)
    area, x_length, y_length = _length(cross(x_slope, y_slope)), _length(x_slope), _length(y_slope)
    wrong = ~(area > PARALLEL * x_length * y_length)
    dx, dy = (np.ptp(t) if t.size else 0.0 for t in (x, y))
    # A row of points has no extent across.
    if dx > 0 and dy > 0:
        wrong |= area * dx * dy < NO_AREA * max(x_length.max() * dx, y_length.max() * dy) ** 2
    if wrong.any():
        raise _irregular(surface, x[wrong][0], y[wrong][0], f" ({wrong.sum()} such points)")


def _limit(surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Derivative of X_x x X_y towards the middle of the surface, shape (3, n)."""
    if not hasattr(surface, "bounds"):
        raise _irregular(surface, x[0], y[0])
    (x_low, x_high), (y_low, y_high) = surface.bounds
    dx, dy = (x_low + x_high) / 2 - x, (y_low + y_high) / 2 - y
    inner = np.maximum(np.abs(dx) / (x_high - x_low), np.abs(dy) / (y_high - y_low)) < 0.5 - ONE_PLACE
    x_slope, y_slope = surface.derivatives(x, y)
    xx, xy, yy = surface.second_derivatives(x, y)
    n = cross(xx * dx + xy * dy, y_slope) + cross(x_slope, xy * dx + yy * dy)
    wrong = inner | ~(_length(n) > VANISHED * _largest_area(surface))
    if wrong.any():
        raise _irregular(surface, x[wrong][0], y[wrong][0])
    return n


def _largest_area(surface: Surface) -> float:
    """Largest |X_x x X_y| at a few places within the bounds; 0 without bounds."""
    if not hasattr(surface, "bounds"):
        return 0.0
    x, y = np.meshgrid(*(low + (high - low) * np.array([0.2, 0.5, 0.7]) for low, high in surface.bounds))
    return float(_length(cross(*surface.derivatives(x, y))).max())


def _length(v: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt((v * v).sum(axis=0)))


def _irregular(surface: Surface, x: float, y: float, more: str = "") -> InputError:
    place = ", ".join(f"{c:.6g}" for c in surface.position(x, y))
    return InputError(
        f"the surface has no tangent plane at (x, y) = ({x:.6g}, {y:.6g}), in space ({place}){more}: X_x and "
        "X_y are parallel or vanish there (a fold, or no area); choose other parameters or bounds"
    )
