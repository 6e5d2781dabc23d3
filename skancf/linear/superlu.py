"""SuperLU of scipy on the nodes in nested dissection order: the solver that is always there."""

from typing import ClassVar

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU as Factors
from scipy.sparse.linalg import splu

from skancf.errors import SingularMatrix
from skancf.linear.dissection import fill, nested_dissection
from skancf.linear.pattern import BlockPattern

# Relative to the unit diagonal; far above rounding, far below the eigenvalues whose signs are wanted.
SIGN_SHIFT = 1e-9
# Per entry of a factor, measured: two factors, row numbers, and what their arrays grow beyond them.
BYTES = 24


class SuperLU:
    """scipy's SuperLU behind :class:`skancf.linear.backend.Backend`."""

    name: ClassVar[str] = "superlu"
    advice: ClassVar[str] = "it comes with scipy"

    @classmethod
    def available(cls) -> bool:
        """Always there."""
        return True

    @classmethod
    def description(cls) -> str:
        """Its name."""
        return cls.name

    def symbolic(self, pattern: BlockPattern) -> None:
        """Order the nodes and find where each entry of the permuted matrix comes from."""
        order = nested_dissection(pattern)
        unknowns = (order[:, None] * pattern.block + np.arange(pattern.block)).ravel()
        self._order = unknowns
        self._fill = fill(pattern, order)
        sources = pattern.sources(order)
        self._sources = sources.data
        # Symmetric, so that its compressed rows are its compressed columns.
        self._matrix = sp.csc_matrix((np.zeros(sources.nnz), sources.indices, sources.indptr), shape=pattern.shape)
        self._matrix.has_canonical_format = True
        self._factors: Factors | None = None

    @property
    def memory(self) -> int:
        """Bytes of the factors and of the way there."""
        return int(BYTES * self._fill)

    def factor(self, values: np.ndarray, careful: bool = False) -> None:
        """Factor without leaving the diagonal where it is not zero; ``careful`` pivots of a tenth of the column.

        The signs of the pivots are counted only when they are asked for.
        """
        self._factors = None  # give the old ones back first
        self._negative: int | None = None
        np.take(values.ravel(), self._sources, out=self._matrix.data)
        self._factors = _factors(self._matrix, 0.1 if careful else 0.0)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b, shape (n,)."""
        x = np.empty(b.size)
        x[self._order] = self._current().solve(b[self._order])
        return x

    @property
    def negative_pivots(self) -> int:
        """Number of negative pivots, which is that of the negative eigenvalues."""
        if self._negative is None:
            self._negative = self._count_negative()
        return self._negative

    @property
    def perturbed_pivots(self) -> int:
        """SuperLU replaces none."""
        return 0

    def close(self) -> None:
        """Give the factors back."""
        self._factors = None

    def _count_negative(self) -> int:
        factors = self._current()
        if np.array_equal(factors.perm_r, factors.perm_c):
            return int(np.count_nonzero(factors.U.diagonal() < 0))
        # A pivot was exactly zero and a row was exchanged, so that the signs tell nothing. A slightly shifted diagonal
        # has no such zero and the same signs, unless an eigenvalue is smaller than the shift.
        shift = SIGN_SHIFT * np.random.default_rng(0).uniform(0.5, 1.0, self._matrix.shape[0])
        shifted = _factors((self._matrix + sp.diags(shift)).tocsc(), 0.0)
        return int(np.count_nonzero(shifted.U.diagonal() < 0))

    def _current(self) -> Factors:
        if self._factors is None:
            raise SingularMatrix("no factors: the last factorisation failed or the solver is closed")
        return self._factors


def _factors(matrix: sp.csc_matrix, threshold: float) -> Factors:
    try:
        return splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=threshold, options={"SymmetricMode": True})
    except RuntimeError as exact:
        raise SingularMatrix(f"SuperLU: {exact}") from exact
