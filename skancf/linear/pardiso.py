"""Intel's MKL Pardiso, called through ctypes from the wheel ``mkl``: threaded LDL^T on dense blocks.

The settings are those of the parameter ``iparm`` in the developer reference of oneMKL, counted from zero.
"""

import weakref
from typing import ClassVar

import numpy as np

from skancf.errors import NotEnoughMemory, SingularMatrix, SkancfError
from skancf.linear import mkl
from skancf.linear.pattern import BlockPattern
from skancf.memory import WAY_OUT

SYMMETRIC_INDEFINITE = -2
ANALYSE, FACTOR, SOLVE, RELEASE = 11, 22, 33, -1

# All other entries are zero. Zero at 10 and 12 switches off MKL's scaling and matching, which do not work on blocks and
# are not needed for a matrix with a unit diagonal.
SETTINGS = {
    0: 1,  # take these settings, not the defaults
    1: 2,  # METIS; a fifth faster than our nested dissection handed over, and the same as METIS in parallel (3)
    9: 13,  # replace pivots below 1e-13 times the norm
    34: 1,  # indices count from zero
}
PIVOTING, BLOCK, PERTURBED, NEGATIVE = 20, 36, 13, 22
# What the analysis finds, in kB.
FACTORS = 16
# A number of threads here makes sums the same from run to run, wherever arrays lie in memory; without it the last bits
# differ. It costs nothing that could be measured. Another number has other bits.
REPRODUCIBLE = 33
# Pivots 1 x 1 take three fifths of the time of the 1 x 1 and 2 x 2 pivots of Bunch and Kaufman, and do as well for
# tangents, which have few negative eigenvalues. Both variants leave the refinement to us.
DIAGONAL, BUNCH_KAUFMAN = 2, 3

ERRORS = {
    -1: "inconsistent input",
    -2: "not enough memory",
    -3: "no ordering found",
    -4: "zero pivot",
    -7: "singular diagonal",
}


class Pardiso:
    """MKL Pardiso behind :class:`skancf.linear.backend.Backend`."""

    name: ClassVar[str] = "mkl"
    advice: ClassVar[str] = "pip install 'skancf[fast]' (x86-64 Linux and Windows)"

    @classmethod
    def available(cls) -> bool:
        """Is there an MKL that loads?"""
        return mkl.load() is not None

    @classmethod
    def description(cls) -> str:
        """With the number of threads."""
        return f"{cls.name}, {mkl.n_threads()} threads"

    def symbolic(self, pattern: BlockPattern) -> None:
        """Order the nodes and lay out the factors."""
        self._handle = _Handle(pattern)
        self._finalizer = weakref.finalize(self, self._handle.release)
        self._handle.run(ANALYSE)
        self._needed = int(self._handle.settings[FACTORS])

    @property
    def memory(self) -> int:
        """Bytes of the factors."""
        return 1024 * self._needed

    def factor(self, values: np.ndarray, careful: bool = False) -> None:
        """Factor with 1 x 1 pivots; with those of Bunch and Kaufman if ``careful`` or if a pivot was too small."""
        self._handle.values = values
        self._handle.settings[PIVOTING] = BUNCH_KAUFMAN if careful else DIAGONAL
        self._handle.run(FACTOR)
        if self.perturbed_pivots and not careful:
            self.factor(values, careful=True)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b, shape (n,)."""
        x = np.empty(b.size)
        self._handle.run(SOLVE, np.ascontiguousarray(b, dtype=np.float64), x)
        return x

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the factors."""
        return int(self._handle.settings[NEGATIVE])

    @property
    def perturbed_pivots(self) -> int:
        """Number of pivots replaced in the last factorisation."""
        return int(self._handle.settings[PERTURBED])

    def close(self) -> None:
        """Give the factors back to MKL."""
        self._finalizer()


class _Handle:
    """The memory of one matrix inside MKL, and all arrays that have to outlive a call."""

    def __init__(self, pattern: BlockPattern) -> None:
        library = mkl.load()
        if library is None:
            raise SkancfError(f"MKL cannot be loaded: {Pardiso.advice}")
        self.pardiso = library.pardiso
        self.n_nodes = pattern.n_nodes
        self.indptr, self.indices = (np.ascontiguousarray(a, np.int32) for a in (pattern.indptr, pattern.indices))
        self.internal = np.zeros(64, np.int64)
        self.settings = np.zeros(64, np.int32)
        for entry, value in {**SETTINGS, BLOCK: pattern.block, REPRODUCIBLE: mkl.n_threads()}.items():
            self.settings[entry] = value
        self.values = self.unused = np.zeros(1)
        # In the order of MKL's arguments: zero, one, kind of matrix, phase, nodes, error.
        self.numbers = np.array([0, 1, SYMMETRIC_INDEFINITE, 0, self.n_nodes, 0], np.int32)
        self.zero, self.one, self.kind, self.phase, self.count, self.error = (
            _address(self.numbers) + k * self.numbers.itemsize for k in range(self.numbers.size)
        )
        arrays = (self.internal, self.indptr, self.indices, self.unused, self.settings)
        self.at_internal, self.at_indptr, self.at_indices, self.at_unused, self.at_settings = [_address(a) for a in arrays]

    def run(self, phase: int, b: np.ndarray | None = None, x: np.ndarray | None = None) -> None:
        """One call; raises for every error that MKL reports."""
        self.numbers[[3, 5]] = phase, 0
        self.pardiso(
            self.at_internal, self.one, self.one, self.kind, self.phase, self.count, _address(self.values), self.at_indptr,
            self.at_indices, self.at_unused, self.one, self.at_settings, self.zero,
            self.at_unused if b is None else _address(b), self.at_unused if x is None else _address(x), self.error,
        )  # fmt: skip
        error = int(self.numbers[5])
        if error == -2:
            raise NotEnoughMemory(f"{self.n_nodes * self.settings[BLOCK]} unknowns: MKL got no memory; {WAY_OUT}")
        if error:
            text = f"Pardiso, phase {phase}: {ERRORS.get(error, 'internal error')} ({error})"
            raise (SingularMatrix if error in (-4, -7) else SkancfError)(text)

    def release(self) -> None:
        self.run(RELEASE)


def _address(array: np.ndarray) -> int:
    address: int = array.__array_interface__["data"][0]
    return address
