"""From a matrix in ordinary coordinates to one that a direct solver likes: constrained and with a unit diagonal."""

import numpy as np

from skancf.errors import InputError, SingularMatrix
from skancf.linear import kernels
from skancf.linear.constraints import Constraints
from skancf.linear.matrix import BlockMatrix, Form
from skancf.linear.pattern import BlockPattern
from skancf.tolerances import EPS


class ScaledSystem:
    r"""The matrix :math:`\hat A = S R A R^T S + F` and the vectors that belong to it.

    R turns into nodal frames. S is diagonal: :math:`|a_{ii}|^{-1/2}` for a free coordinate, zero for a fixed one, which
    takes its row and column out. F puts a one on the diagonal of fixed coordinates.

    Parameters
    ----------
    pattern : BlockPattern
    constraints : Constraints
    """

    def __init__(self, pattern: BlockPattern, constraints: Constraints) -> None:
        if constraints.fixed.shape != (pattern.n_nodes, pattern.block):
            raise InputError(
                f"constraints for {constraints.fixed.shape} coordinates, pattern for {(pattern.n_nodes, pattern.block)}"
            )
        self.pattern = pattern
        self.constraints = constraints
        self.form: Form | None = None
        self.values = np.empty((pattern.n_blocks, pattern.block, pattern.block))
        self.scale = np.zeros(constraints.fixed.shape)
        # Frame of each node; the identity follows the last frame.
        frame = np.full(pattern.n_nodes, len(constraints.frames))
        frame[constraints.frame_nodes] = np.arange(len(constraints.frames))
        self._frames = np.concatenate([constraints.frames, np.eye(pattern.block)[None]])
        left, right = frame[pattern.rows], frame[pattern.indices]
        self._rotated = np.minimum(left, right) < len(constraints.frames)
        self._turned = np.flatnonzero(self._rotated)
        self._left, self._right = left[self._turned], right[self._turned]

    def update(self, matrix: BlockMatrix) -> None:
        """Take over new values.

        Raises
        ------
        SingularMatrix
            For an entry that is not finite or a free coordinate with a zero on the diagonal.
        """
        if matrix.pattern is not self.pattern:
            raise InputError("the matrix has another pattern than the solver: make a new solver for a new pattern")
        self.form = matrix.form
        turned = matrix.values[self._turned]
        noise = self._rotation_noise(turned)
        self.values[self._turned] = self._frames[self._left] @ turned @ self._frames[self._right].transpose(0, 2, 1)
        self.scale = self._scale(matrix.values, noise)
        pattern = self.pattern
        wrong = kernels.scale_blocks(pattern.indptr, pattern.indices, matrix.values, self._rotated, self.scale, self.values)
        if wrong >= 0:
            raise SingularMatrix(
                f"the block of nodes {pattern.rows[wrong]} and {pattern.indices[wrong]} has entries that are not "
                "finite; look for a state far outside the range of the material law or for a distorted cell"
            )

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """Scaled matrix times a scaled vector, shape (n,)."""
        if self.form is None:
            return BlockMatrix(self.pattern, self.values) @ x
        return self.restrict(self.form.product(self.expand(x)))

    def multiply_sizes(self, x: np.ndarray) -> np.ndarray:
        """The same product of absolute values: how large the terms are of which the product is the sum."""
        return BlockMatrix(self.pattern, np.abs(self.values)) @ np.abs(x)

    def restrict(self, force: np.ndarray) -> np.ndarray:
        """S R f: a right-hand side, zero where coordinates are fixed."""
        return self.constraints.to_frame(force) * self.scale.ravel()

    def expand(self, x: np.ndarray) -> np.ndarray:
        """R^T S x: a solution in ordinary coordinates."""
        return self.constraints.from_frame(x * self.scale.ravel())

    def _scale(self, values: np.ndarray, noise: np.ndarray) -> np.ndarray:
        slots = self.pattern.diagonal_slots
        nodes = self.constraints.frame_nodes
        diagonal = np.einsum("kaa->ka", values[slots])
        diagonal[nodes] = np.einsum("kaa->ka", self.values[slots[nodes]])
        size = np.abs(diagonal)
        free = ~self.constraints.fixed
        strange = free & ~((size > noise) & np.isfinite(size))
        if strange.any():
            node, coordinate = (int(number) for number in np.argwhere(strange)[0])
            raise SingularMatrix(_no_pivot(node, coordinate, diagonal[node, coordinate], int(np.count_nonzero(strange))))
        return np.where(free, 1.0 / np.sqrt(np.where(free, size, 1.0)), 0.0)

    def _rotation_noise(self, turned: np.ndarray) -> np.ndarray:
        """Rounding that a turn into nodal frames leaves on the diagonal, (n_nodes, block); zero without a frame."""
        noise = np.zeros(self.scale.shape)
        if not self._turned.size:
            return noise
        own = self.pattern.rows[self._turned] == self.pattern.indices[self._turned]
        frames = np.abs(self._frames[self._left[own]])
        bound = np.einsum("kab,kbc,kac->ka", frames, np.abs(turned[own]), frames, optimize=True)
        noise[self.pattern.rows[self._turned[own]]] = self.pattern.block * EPS * bound
        return noise


def _no_pivot(node: int, coordinate: int, value: float, count: int) -> str:
    also = f" (and {count - 1} more)" if count > 1 else ""
    if not np.isfinite(value):
        return f"node {node}, coordinate {coordinate}{also}: diagonal entry {value}; the state is not finite there"
    return (
        f"node {node}, coordinate {coordinate}{also}: the diagonal entry is zero, nothing resists this motion. Look "
        "for a node without a cell, a cell without stiffness, or a coordinate that should be prescribed"
    )
