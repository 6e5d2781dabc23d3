r"""Factors of a tangent that turn with the nodes.

Nodal vectors turn with the body, and so does its tangent: with the block-diagonal rotations R of the nodes from where P was
factored, :math:`R_2 P^{-1} R_1^T` is nearly the inverse of a tangent whose rows are taken at one state and whose columns at
another. What turns as a whole then keeps its factors.
"""

import numpy as np

from skancf.layout.layout import nodal
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.tolerances import ABOVE_ZERO, ROUNDED_PROJECTION


class TurningFactors:
    """A factored matrix and the rotations of the nodes since then.

    Parameters
    ----------
    linear : DirectSolver
    constraints : Constraints
    moves : (n_blocks,) bool array
        Blocks that have slopes or directors, by which their rotation is known.
    """

    def __init__(self, linear: DirectSolver, constraints: Constraints, moves: np.ndarray):
        self.linear = linear
        self.turns = (turning_vectors(constraints) & moves[:, None])[:, :, None]
        self.frames = self.rows = self.columns = np.empty(0)

    def factor(self, matrix: BlockMatrix, q: np.ndarray) -> None:
        """Factor a matrix that belongs to nodal coordinates q, (n_dofs,)."""
        self.linear.factor(matrix)
        self.frames = nodal_frames(q)
        self.turn_to(q, q)

    def turn_to(self, rows: np.ndarray, columns: np.ndarray) -> None:
        """Turn the factors to nodal coordinates of the rows and of the columns, (n_dofs,) each."""
        back = self.frames.swapaxes(1, 2)
        self.rows = nodal_frames(rows) @ back
        self.columns = self.rows if columns is rows else nodal_frames(columns) @ back

    def solve(self, force: np.ndarray) -> tuple[np.ndarray, float]:
        r"""The correction :math:`R_2 P^{-1} R_1^T f` and its energy :math:`(R_1^T f) \cdot P^{-1} (R_1^T f)`."""
        turned_back = self._turned(self.rows.swapaxes(1, 2), force)
        correction = self.linear.solve(turned_back, refinements=0)
        return self._turned(self.columns, correction), abs(float(correction @ turned_back))

    def _turned(self, rotations: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        blocks = nodal(vectors)
        return np.where(self.turns, blocks @ rotations.swapaxes(1, 2), blocks).ravel()


def nodal_frames(q: np.ndarray) -> np.ndarray:
    """Orthonormal frames of the nodes, (n_nodes, 3, 3): columns halfway between the slopes, across that, and the normal.

    They turn with a rigid rotation, and treat both slopes alike where these are sheared.
    """
    slopes = nodal(q)[:, 1:3]
    slopes = slopes / np.maximum(np.linalg.norm(slopes, axis=2, keepdims=True), ABOVE_ZERO)
    frames = np.empty((len(slopes), 3, 3))
    frames[:, :, 0], frames[:, :, 1] = slopes[:, 0] + slopes[:, 1], slopes[:, 1] - slopes[:, 0]
    frames[:, :, :2] /= np.maximum(np.linalg.norm(frames[:, :, :2], axis=1, keepdims=True), ABOVE_ZERO)
    frames[:, :, 2] = np.cross(frames[:, :, 0], frames[:, :, 1])
    return frames


def turning_vectors(constraints: Constraints) -> np.ndarray:
    """Nodal vectors that are free or held as a whole, (n_nodes, 4) bool: one of which a component is held does not turn."""
    held = constraints.of_vectors()
    free, whole = (np.abs(held - part).max(axis=(2, 3)) < ROUNDED_PROJECTION for part in (0.0, np.eye(3)))
    return np.asarray(free | whole)
