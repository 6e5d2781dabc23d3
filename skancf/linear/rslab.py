"""The package rslab: threaded LDL^T on supernodes, in wheels for every platform; the solver of machines without MKL.

Its pivots, 1 x 1 and 2 x 2, are sought inside a supernode and never put off to the next. That does for tangents with their
unit diagonal. Where it does not, SuperLU takes over, which may exchange any two rows.
"""

import importlib
from functools import cache
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp

from skancf.linear import kernels
from skancf.linear.pattern import BlockPattern
from skancf.linear.superlu import SuperLU
from skancf.threads import n_threads

# Stands for a pivot that is zero, relative to the unit diagonal.
SMALLEST_PIVOT = 1e-13


@cache
def _module() -> Any:
    """The package, or None where it is not installed."""
    try:
        return importlib.import_module("rslab")
    except ImportError:
        return None


class Rslab:
    """rslab behind :class:`skancf.linear.backend.Backend`."""

    name: ClassVar[str] = "rslab"
    advice: ClassVar[str] = "pip install rslab"

    @classmethod
    def available(cls) -> bool:
        """Is it installed?"""
        return _module() is not None

    @classmethod
    def description(cls) -> str:
        """With its version; the bits are the same for every number of threads."""
        return f"{cls.name} {_module().__version__}"

    def symbolic(self, pattern: BlockPattern) -> None:
        """Order the unknowns and lay out the factors."""
        self._pattern = pattern
        indptr, indices = kernels.upper_pattern(pattern.indptr, pattern.indices, pattern.block)
        self._entries = np.ones(indices.size)
        # Compressed rows of the upper triangle are compressed columns of the lower one, which is what rslab takes.
        lower = sp.csc_matrix((self._entries, indices, indptr), shape=pattern.shape)
        lower.has_canonical_format = True
        self._symbolic = _module().analyze(lower, path="ldlt", threads=n_threads(), scaling="identity")
        self._values = np.empty(0)
        self._factors: Any = None
        self._careful: SuperLU | None = None

    @property
    def memory(self) -> int:
        """Bytes of the factors and of the way there."""
        return int(self._symbolic.memory_plan("float64")["peak_bytes"])

    def factor(self, values: np.ndarray, careful: bool = False) -> None:
        """Factor; with SuperLU if ``careful``."""
        self._values = values
        self._factors = self._careful = None  # give the old ones back first
        if careful:
            self._careful = self._with_exchanges()
            return
        kernels.upper_entries(self._pattern.indptr, values, self._entries)
        try:
            self._factors = self._symbolic.factor(self._entries)
        except RuntimeError:
            self._factors = self._symbolic.factor(self._entries, preconditioner=SMALLEST_PIVOT)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b, shape (n,)."""
        return self._careful.solve(b) if self._careful else self._factors.solve(np.ascontiguousarray(b))

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues; of other factors where a pivot of these was replaced."""
        if self._careful is None and self._factors.n_perturbed:
            self._careful = self._with_exchanges()
        return self._careful.negative_pivots if self._careful else int(self._factors.inertia[1])

    @property
    def perturbed_pivots(self) -> int:
        """Number of pivots that were zero and have been replaced."""
        return 0 if self._careful else int(self._factors.n_perturbed)

    def close(self) -> None:
        """Give the factors back."""
        self._factors = self._careful = None
        self._values = np.empty(0)

    def _with_exchanges(self) -> SuperLU:
        other = SuperLU()
        other.symbolic(self._pattern)
        other.factor(self._values, careful=True)
        return other
