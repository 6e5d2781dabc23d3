r"""Shape functions of plate elements on the reference square [0, 1] x [0, 1].

Corners are numbered (0, 0), (1, 0), (1, 1), (0, 1). An element's local vectors are values and derivatives with respect
to :math:`\xi, \eta`, so that these functions are the same for every element.
"""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any

import numpy as np

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

# One row for each end of the unit interval: coefficients of 1, s, s^2, s^3.
VALUE = ((1.0, 0.0, -3.0, 2.0), (0.0, 0.0, 3.0, -2.0))
SLOPE = ((0.0, 1.0, -2.0, 1.0), (0.0, 0.0, -1.0, 1.0))
LINEAR = ((1.0, -1.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
HERMITE, ALL = np.array([VALUE, SLOPE]), np.array([VALUE, SLOPE, LINEAR])
# Ends of the corners in xi and in eta.
END_XI, END_ETA = CORNERS.astype(int).T


def derivative(polynomials: np.ndarray, s: np.ndarray, order: int) -> np.ndarray:
    """The derivatives of that order at ``s`` (...) of polynomials (..., n_coefficients): all their axes first."""
    for _ in range(order):
        polynomials = polynomials[..., 1:] * np.arange(1, polynomials.shape[-1])
    first, *rest = np.moveaxis(polynomials[..., ::-1].reshape(*polynomials.shape, *[1] * s.ndim), polynomials.ndim - 1, 0)
    value = first + np.zeros_like(s)
    for coefficient in rest:
        value = value * s + coefficient
    return value


def of_points(table: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A table of points (2, n), and of arguments, that is remembered: the same few sets of points come again and again."""

    @lru_cache(maxsize=32)
    def computed(points: bytes, *arguments: Any) -> np.ndarray:
        return table(np.frombuffer(points).reshape(2, -1), *arguments)

    @wraps(table)
    def remembered(points: np.ndarray, *arguments: Any) -> np.ndarray:
        return computed(np.asarray(points, dtype=float).tobytes(), *arguments).copy()

    return remembered


def ancf_functions(xi: np.ndarray, eta: np.ndarray, order: tuple[int, int] = (0, 0)) -> np.ndarray:
    r"""Functions of the fully parameterised ANCF plate, differentiated ``order`` times in xi and eta.

    With the cubic Hermite functions H (value) and G (slope) and the linear L of an end a of the unit interval,

    .. math::
        N_r &= H_a(\xi) L_b(\eta) + L_a(\xi) H_b(\eta) - L_a(\xi) L_b(\eta), \\
        N_{r,\xi} &= G_a(\xi) L_b(\eta), \qquad N_{r,\eta} = L_a(\xi) G_b(\eta), \qquad N_d = L_a(\xi) L_b(\eta).

    The first three span the incomplete bicubic 1, x, y, xy, x2, y2, x2y, xy2, x3, y3, x3y, xy3; the last one carries
    the director d = r_z.

    Parameters
    ----------
    xi, eta : (...) array
        Points of the reference square.
    order : (int, int)
        Order of differentiation in xi and in eta.

    Returns
    -------
    (4, 4, ...) array
        First axis: corner. Second axis: r, r_xi, r_eta, d.

    References
    ----------
    Mikkola and Shabana (2003), Multibody System Dynamics 9, 283-309.
    """
    xi, eta = np.broadcast_arrays(np.asarray(xi, float), np.asarray(eta, float))
    m, n = order
    out = np.empty((4, 4, *xi.shape))
    value_x, slope_x, linear_x = derivative(ALL, xi, m)[:, END_XI]
    value_y, slope_y, linear_y = derivative(ALL, eta, n)[:, END_ETA]
    out[:, 0] = value_x * linear_y + linear_x * value_y - linear_x * linear_y
    out[:, 1], out[:, 2], out[:, 3] = slope_x * linear_y, linear_x * slope_y, linear_x * linear_y
    return out


def hermite_functions(xi: np.ndarray, eta: np.ndarray, order: tuple[int, int] = (0, 0)) -> np.ndarray:
    r"""Bicubic Hermite functions (Bogner, Fox and Schmit), differentiated ``order`` times in xi and eta.

    Products of the cubic Hermite functions H (value) and G (slope) of an end a of the unit interval,

    .. math::
        N_r = H_a(\xi) H_b(\eta), \quad N_{r,\xi} = G_a(\xi) H_b(\eta), \quad N_{r,\eta} = H_a(\xi) G_b(\eta), \quad
        N_{r,\xi\eta} = G_a(\xi) G_b(\eta).

    They span all products of cubics, and on aligned rectangles the field and its gradient are continuous.

    Parameters
    ----------
    xi, eta : (...) array
        Points of the reference square.
    order : (int, int)
        Order of differentiation in xi and in eta.

    Returns
    -------
    (4, 4, ...) array
        First axis: corner. Second axis: r, r_xi, r_eta, r_xieta.

    References
    ----------
    Bogner, Fox and Schmit (1965), Proc. Conf. Matrix Methods in Structural Mechanics, 397-443.
    """
    xi, eta = np.broadcast_arrays(np.asarray(xi, float), np.asarray(eta, float))
    m, n = order
    out = np.empty((4, 4, *xi.shape))
    along_xi, along_eta = derivative(HERMITE, xi, m)[:, END_XI], derivative(HERMITE, eta, n)[:, END_ETA]
    for kind in range(4):
        np.multiply(along_xi[kind % 2], along_eta[kind // 2], out=out[:, kind])
    return out
