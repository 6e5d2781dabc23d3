"""Products of vectors of three components."""

import numpy as np


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector product over the first axis; `numpy.cross` takes longer to see that it has three components."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def sum_of_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sum of the vector products of all rows, (..., 3) and (..., 3) to (3,)."""
    product = a.reshape(-1, 3).T @ b.reshape(-1, 3)
    return np.asarray((product - product.T)[[1, 2, 0], [2, 0, 1]])
