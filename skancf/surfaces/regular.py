"""Where a surface has a tangent plane."""

from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.surfaces.protocol import Surface, parameters

# Sine of the angle between X_x and X_y, and the area of a parameter cell over the square of the extent. Derivatives by
# differences have errors of 1e-12; a strip of aspect ratio 1e6 has an area of 1e-6.
NO_ANGLE = 1e-9
NO_AREA = 1e-12
# |X_x x X_y| over its value in the middle: below this a point is a pole.
POLE = 1e-9


def normal(surface: Surface, x: Any, y: Any) -> np.ndarray:
    r"""Unit normal :math:`\mathbf X_{,x} \times \mathbf X_{,y} / |\mathbf X_{,x} \times \mathbf X_{,y}|`, shape (3, ...).

    At a pole of a surface with bounds (the centre of a disc, the top of a sphere), where the product vanishes, its limit
    from the middle of the surface: the direction of its derivative towards there.

    Raises
    ------
    InputError
        Where neither exists; the point is named.
    """
    x, y = parameters(x, y)
    n = np.cross(*surface.derivatives(x, y), axis=0)
    flat = _length(n) <= POLE * _middle_area(surface)
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
    """
    x, y = parameters(x, y)
    x_slope, y_slope = surface.derivatives(x, y)
    area, x_length, y_length = _length(np.cross(x_slope, y_slope, axis=0)), _length(x_slope), _length(y_slope)
    wrong = ~(area > NO_ANGLE * x_length * y_length)
    if x.size:
        dx, dy = np.ptp(x), np.ptp(y)
        wrong |= area * dx * dy < NO_AREA * max(x_length.max() * dx, y_length.max() * dy) ** 2
    if wrong.any():
        raise _irregular(surface, x[wrong][0], y[wrong][0], f" ({wrong.sum()} such points)")


def _limit(surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Derivative of X_x x X_y towards the middle of the surface, shape (3, n)."""
    if not hasattr(surface, "bounds"):
        raise _irregular(surface, x[0], y[0])
    dx, dy = (sum(interval) / 2 - at for interval, at in zip(surface.bounds, (x, y), strict=True))
    x_slope, y_slope = surface.derivatives(x, y)
    xx, xy, yy = surface.second_derivatives(x, y)
    n = np.cross(xx * dx + xy * dy, y_slope, axis=0) + np.cross(x_slope, xy * dx + yy * dy, axis=0)
    wrong = ~(_length(n) > POLE * _middle_area(surface))
    if wrong.any():
        raise _irregular(surface, x[wrong][0], y[wrong][0])
    return n


def _middle_area(surface: Surface) -> float:
    """|X_x x X_y| in the middle of the bounds; 0 without bounds."""
    if not hasattr(surface, "bounds"):
        return 0.0
    x, y = (sum(interval) / 2 for interval in surface.bounds)
    return float(_length(np.cross(*surface.derivatives(x, y), axis=0)))


def _length(v: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt((v * v).sum(axis=0)))


def _irregular(surface: Surface, x: float, y: float, more: str = "") -> InputError:
    place = ", ".join(f"{c:.6g}" for c in surface.position(x, y))
    return InputError(f"the surface has no tangent plane at (x, y) = ({x:.6g}, {y:.6g}), in space ({place}){more}: X_x and "
                      "X_y are parallel or vanish there (a fold, or no area); choose other parameters or bounds")
