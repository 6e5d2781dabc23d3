r"""A distance that stays: pure functions of the vector d between two points.

.. math:: g = \frac{d \cdot d - L^2}{2 L}, \qquad \partial g = \frac{d \cdot \partial d}{L}

At :math:`|d| = L` the gradient is the unit vector along d, and the multiplier the force along it, positive if it pulls.
"""

import numpy as np


def value(d: np.ndarray, length: float) -> float:
    """g (m) of d (3,)."""
    return float(d @ d - length**2) / (2.0 * length)


def gradient(d: np.ndarray, length: float) -> np.ndarray:
    """Its derivative with respect to d, (3,)."""
    return np.asarray(d / length)


def curvature(length: float) -> np.ndarray:
    """Its second derivative, (3, 3)."""
    return np.eye(3) / length
