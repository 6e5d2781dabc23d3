r"""Shape functions of plate elements on the reference square [0, 1] x [0, 1].

Corners are numbered (0, 0), (1, 0), (1, 1), (0, 1). An element's local vectors are values and derivatives with respect
to :math:`\xi, \eta`, so that these functions are the same for every element.
"""

import numpy as np

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])

# One polynomial for each end of the unit interval: coefficients of 1, s, s^2, s^3.
HERMITE_VALUE = ((1.0, 0.0, -3.0, 2.0), (0.0, 0.0, 3.0, -2.0))
HERMITE_SLOPE = ((0.0, 1.0, -2.0, 1.0), (0.0, 0.0, -1.0, 1.0))
LINEAR = ((1.0, -1.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))


def derivative(polynomial: tuple[float, ...], s: np.ndarray, order: int) -> np.ndarray:
    """The derivative of that order at ``s``, shaped like ``s``."""
    for _ in range(order):
        polynomial = tuple(k * c for k, c in enumerate(polynomial))[1:]
    value = np.full(s.shape, polynomial[-1])
    for coefficient in reversed(polynomial[:-1]):
        value = value * s + coefficient
    return value


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
    for corner, (a, b) in enumerate(CORNERS.astype(int)):
        value_x, value_y = derivative(HERMITE_VALUE[a], xi, m), derivative(HERMITE_VALUE[b], eta, n)
        linear_x, linear_y = derivative(LINEAR[a], xi, m), derivative(LINEAR[b], eta, n)
        out[corner, 0] = value_x * linear_y + linear_x * value_y - linear_x * linear_y
        out[corner, 1] = derivative(HERMITE_SLOPE[a], xi, m) * linear_y
        out[corner, 2] = linear_x * derivative(HERMITE_SLOPE[b], eta, n)
        out[corner, 3] = linear_x * linear_y
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
    families = (HERMITE_VALUE, HERMITE_SLOPE)
    along_xi, along_eta = ([[derivative(f[end], s, k) for f in families] for end in (0, 1)] for s, k in ((xi, m), (eta, n)))
    for corner, (a, b) in enumerate(CORNERS.astype(int)):
        for kind in range(4):
            np.multiply(along_xi[a][kind % 2], along_eta[b][kind // 2], out=out[corner, kind])
    return out
