"""A symmetric matrix of small dense blocks."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.linear import kernels
from skancf.linear.pattern import BlockPattern


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """A symmetric matrix, of which the upper triangle of blocks is stored.

    Parameters
    ----------
    pattern : BlockPattern
    values : (n_blocks, block, block) float array
        Blocks in the order of the pattern, diagonal blocks full.
    """

    pattern: BlockPattern
    values: np.ndarray

    def __post_init__(self) -> None:
        expected = (self.pattern.n_blocks, self.pattern.block, self.pattern.block)
        if self.values.shape != expected or self.values.dtype != np.float64:
            raise InputError(
                f"values of shape {self.values.shape} and type {self.values.dtype}: give float64 {expected}"
            )

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the matrix."""
        return self.pattern.shape

    def __matmul__(self, vector: np.ndarray) -> np.ndarray:
        """A v, shape (n_nodes * block,)."""
        if np.shape(vector) != (self.shape[1],):
            raise InputError(f"a vector of shape {np.shape(vector)} times a matrix of shape {self.shape}")
        x = np.asarray(vector, dtype=np.float64).reshape(self.pattern.n_nodes, self.pattern.block)
        y = np.empty(x.shape)
        kernels.multiply(self.pattern.indptr, self.pattern.indices, self.values, x, y)
        return y.ravel()

    def __add__(self, other: "BlockMatrix") -> "BlockMatrix":
        if not isinstance(other, BlockMatrix):
            return NotImplemented
        if other.pattern is not self.pattern:
            raise InputError("the sum of two matrices needs one pattern: assemble both with the same one")
        return BlockMatrix(self.pattern, self.values + other.values)

    def __mul__(self, factor: float) -> "BlockMatrix":
        if not isinstance(factor, (int, float)):
            return NotImplemented
        return BlockMatrix(self.pattern, self.values * float(factor))

    __rmul__ = __mul__

    def diagonal(self) -> np.ndarray:
        """Diagonal entries, shape (n_nodes * block,)."""
        return np.einsum("kaa->ka", self.values[self.pattern.diagonal_slots]).ravel()

    def to_scipy(self) -> sp.csr_matrix:
        """The full matrix, both triangles."""
        sources = self.pattern.sources()
        entries = self.values.ravel()[sources.data]
        return sp.csr_matrix((entries, sources.indices, sources.indptr), shape=self.shape)
