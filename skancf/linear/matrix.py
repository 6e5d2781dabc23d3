"""A symmetric matrix of small dense blocks."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.linear import kernels
from skancf.linear.pattern import BlockPattern
from skancf.showing import short


class Form(Protocol):
    """How a matrix is applied without its entries, where these have lost digits that the whole still has."""

    def product(self, vector: np.ndarray) -> np.ndarray:
        """A v, shape (n_nodes * block,)."""

    def energy(self, vector: np.ndarray) -> float:
        """Half of v . A v, with as many digits as its terms have if these are all positive."""


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """A symmetric matrix, of which the upper triangle of blocks is stored.

    Parameters
    ----------
    pattern : BlockPattern
    values : (n_blocks, block, block) float array
        Blocks in the order of the pattern, diagonal blocks full.
    form : Form, optional
        How products are made; by default of the entries. Factors are always those of the entries.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> stiffness = system.tangent(system.undeformed)
    >>> print(stiffness.values.shape[1:], abs(stiffness @ np.zeros(system.n_dofs)).max())
    (12, 12) 0.0
    """

    pattern: BlockPattern
    values: np.ndarray
    form: Form | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        expected = (self.pattern.n_blocks, self.pattern.block, self.pattern.block)
        if self.values.shape != expected or self.values.dtype != np.float64:
            raise InputError(f"values of shape {self.values.shape} and type {self.values.dtype}: give float64 {expected}")

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the matrix."""
        return self.pattern.shape

    def __matmul__(self, vector: np.ndarray) -> np.ndarray:
        """A v, shape (n_nodes * block,)."""
        if np.shape(vector) != (self.shape[1],):
            raise InputError(f"a vector of shape {np.shape(vector)} times a matrix of shape {self.shape}")
        if self.form is not None:
            return self.form.product(np.asarray(vector, dtype=np.float64))
        x = np.asarray(vector, dtype=np.float64).reshape(self.pattern.n_nodes, self.pattern.block)
        y = np.empty(x.shape)
        kernels.multiply(self.pattern.indptr, self.pattern.indices, self.values, x, y)
        return y.ravel()

    def __add__(self, other: "BlockMatrix") -> "BlockMatrix":
        if not isinstance(other, BlockMatrix):
            return NotImplemented
        if other.pattern is not self.pattern:
            raise InputError("the sum of two matrices needs one pattern: assemble both with the same one")
        whole = self.form is None and other.form is None
        return BlockMatrix(self.pattern, self.values + other.values, None if whole else _Sum(self, other))

    def __mul__(self, factor: float) -> "BlockMatrix":
        if not isinstance(factor, (int, float)):
            return NotImplemented
        form = None if self.form is None else _Multiple(self.form, float(factor))
        return BlockMatrix(self.pattern, self.values * float(factor), form)

    __rmul__ = __mul__

    def energy(self, vector: np.ndarray) -> float:
        """Half of v . A v."""
        return self.form.energy(vector) if self.form is not None else 0.5 * float(vector @ (self @ vector))

    def rounding(self, vector: np.ndarray, digits: float) -> float:
        """What an error of ``digits`` in the terms of v . A v makes of it, or in the strains of which they are squares."""
        if isinstance(self.form, _Sum):
            return self.form.one.rounding(vector, digits) + self.form.other.rounding(vector, digits)
        terms = float(np.abs(vector) @ (self.sizes() @ np.abs(vector)))
        return terms * (digits if self.form is None else digits**2)

    def sizes(self) -> "BlockMatrix":
        """The matrix of the absolute values of the entries."""
        return BlockMatrix(self.pattern, np.abs(self.values))

    def diagonal(self) -> np.ndarray:
        """Diagonal entries, shape (n_nodes * block,)."""
        return np.einsum("kaa->ka", self.values[self.pattern.diagonal_slots]).ravel()

    def to_scipy(self) -> sp.csr_matrix:
        """The full matrix, both triangles."""
        sources = self.pattern.sources()
        entries = self.values.ravel()[sources.data]
        return sp.csr_matrix((entries, sources.indices, sources.indptr), shape=self.shape)


@dataclass(frozen=True)
class _Sum:
    one: BlockMatrix
    other: BlockMatrix

    __repr__ = short

    def product(self, vector: np.ndarray) -> np.ndarray:
        return self.one @ vector + self.other @ vector

    def energy(self, vector: np.ndarray) -> float:
        return self.one.energy(vector) + self.other.energy(vector)


@dataclass(frozen=True)
class _Multiple:
    form: Form
    factor: float

    def product(self, vector: np.ndarray) -> np.ndarray:
        return self.factor * self.form.product(vector)

    def energy(self, vector: np.ndarray) -> float:
        return self.factor * self.form.energy(vector)
