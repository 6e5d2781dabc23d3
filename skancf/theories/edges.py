r"""What nodal vectors in the middle of an edge are.

With the ends 0 and 1 of an edge of the parameter vector s, along which t is a direction of the parameter plane, the cubic
Hermite function of a field v with its slopes gives at the middle

.. math::
    v = \tfrac12 (v_0 + v_1) + \tfrac18 |s| (v_{,t0} - v_{,t1}), \qquad
    v_{,t} = \tfrac{3}{2 |s|} (v_1 - v_0) - \tfrac14 (v_{,t0} + v_{,t1}).
"""

import numpy as np

from skancf.kernels.constants import VECTORS


def no_weights(n: int) -> np.ndarray:
    """Weights (2, n, 4, 4), yet to be filled, from the four vectors at each end to those in the middle."""
    return np.zeros((2, n, VECTORS, VECTORS))


def set_cubic(weights: np.ndarray, way: np.ndarray, value: np.ndarray, slope: np.ndarray) -> None:
    """Sets those of a field and its slope along edges of signed lengths (m,), which are the vectors ``value`` and ``slope``
    there, (m,) each."""
    edge = np.arange(len(way))
    for end, sign in enumerate((1.0, -1.0)):
        weights[end, edge, value, value] = 0.5
        weights[end, edge, value, slope] = sign * way / 8
        weights[end, edge, slope, value] = -sign * 1.5 / way
        weights[end, edge, slope, slope] = -0.25


def set_mean(weights: np.ndarray, vector: np.ndarray) -> None:
    """Sets those of vectors (m,) that are the means of the ends'."""
    weights[:, np.arange(weights.shape[1]), vector, vector] = 0.5
