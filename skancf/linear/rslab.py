"""The package rslab: threaded LDL^T on supernodes, in wheels for common platforms; the solver of machines without MKL.

Its pivots, 1 x 1 and 2 x 2, are sought inside a supernode and never put off to the next. That does for tangents with their
unit diagonal. Where it does not, SuperLU takes over, which may exchange any two rows.
"""

import importlib
from functools import cache
from typing import Any, ClassVar
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp

from skancf import memory
from skancf.errors import SingularMatrix
from skancf.linear import kernels
from skancf.linear.pattern import BlockPattern
from skancf.linear.superlu import SuperLU
from skancf.threads import n_threads

# Stands for a pivot that is zero, relative to the unit diagonal.
SMALLEST_PIVOT = 1e-13
# What is known of the patterns that are still in use. An analysis takes as long as one to three factorisations.
ANALYSES: WeakKeyDictionary[BlockPattern, Any] = WeakKeyDictionary()


@cache
def _module() -> Any:
    """The package, or None where it is not installed."""
    try:
        return importlib.import_module("rslab")
    except ImportError:
        return None


def _analysis(pattern: BlockPattern) -> Any:
    """Order of the unknowns and layout of the factors."""
    indptr, indices = kernels.upper_pattern(pattern.indptr, pattern.indices, pattern.block)
    # Compressed rows of the upper triangle are compressed columns of the lower one, which is what rslab takes.
    lower = sp.csc_matrix((np.ones(indices.size), indices, indptr), shape=pattern.shape)
    lower.has_canonical_format = True
    return _module().analyze(lower, path="ldlt", threads=n_threads(), scaling="identity")


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
        """Order the unknowns and lay out the factors, once for all solvers of a pattern."""
        self._pattern = pattern
        if pattern not in ANALYSES:
            ANALYSES[pattern] = _analysis(pattern)
        self._symbolic = ANALYSES[pattern]
        off = pattern.n_blocks - pattern.n_nodes
        self._entries = np.empty(off * pattern.block**2 + pattern.n_nodes * pattern.block * (pattern.block + 1) // 2)
        self._values = np.empty(0)
        self._factors: Any = None
        self._careful: SuperLU | None = None

    @property
    def memory(self) -> int:
        """Bytes of the factors and of the way there."""
        plan = self._symbolic.memory_plan("float64", threads=n_threads())
        return int(plan["peak_bytes"]) + self._entries.nbytes

    def factor(self, values: np.ndarray, careful: bool = False) -> None:
        """Factor; with SuperLU if ``careful``."""
        self._values = values
        self._factors = self._careful = None  # give the old ones back first
        if careful:
            self._careful = self._with_exchanges()
            return
        kernels.upper_entries(self._pattern.indptr, values, self._entries)
        try:
            self._factors = self._symbolic.factor(self._entries, threads=n_threads())
        except RuntimeError:
            try:
                self._factors = self._symbolic.factor(self._entries, threads=n_threads(), preconditioner=SMALLEST_PIVOT)
            except RuntimeError as none:
                raise SingularMatrix(f"rslab: {none}") from none

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
        memory.require(other.memory, f"{self._pattern.shape[0]} unknowns",
                       "a factorisation by superlu, for pivots of rslab that vanish,")  # fmt: skip
        other.factor(self._values, careful=True)
        return other
