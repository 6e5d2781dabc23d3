"""Products of vectors of three components, and rotations of them."""

import numpy as np

from skancf.tolerances import HALF_TURN


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector product over the first axis; `numpy.cross` takes longer to see that it has three components."""
    first = a[1] * b[2] - a[2] * b[1]
    out = np.empty((3, *np.shape(first)), first.dtype)
    out[0], out[1], out[2] = first, a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return out


def sum_of_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sum of the vector products of all rows, (..., 3) and (..., 3) to (3,)."""
    product = a.reshape(-1, 3).T @ b.reshape(-1, 3)
    return np.asarray((product - product.T)[[1, 2, 0], [2, 0, 1]])


def cross_matrix(a: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) of the vector product with a, (3,)."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(vector: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) of a rotation by a vector: its length is the angle (rad), its direction the axis."""
    angle, W = float(np.linalg.norm(vector)) / np.pi, cross_matrix(vector)
    return np.asarray(np.eye(3) + np.sinc(angle) * W + 0.5 * np.sinc(0.5 * angle) ** 2 * W @ W)


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """The vector of :func:`rotation` of a matrix (3, 3), of a length from 0 to pi."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = float(np.linalg.norm(axis)), 0.5 * (float(np.trace(R)) - 1)
    if sine > HALF_TURN:
        return np.asarray(np.arctan2(sine, cosine) / sine * axis)
    if cosine > 0:
        return axis
    square = 0.5 * (R + R.T) + np.eye(3)  # twice the square of the axis
    column = square[:, int(np.argmax(np.diag(square)))]
    return np.asarray(np.pi * column / np.linalg.norm(column))
