r"""Linear systems with conditions, whose multipliers stay outside of the matrix,

.. math::
   K x + G^T l = a, \qquad G x = b, \qquad A = K + G^T P G .

With the factors of A alone, which any direct solver has and whose diagonal has no zeros, each pass is

.. math:: \Delta x = A^{-1} (a' + G^T P b'), \qquad \Delta l = P (G \, \Delta x - b')

on what is left of both equations, a' and b'. How stiff P is does not change the answer; the stiffer, the more a pass gains,
up to rounding. Conditions that depend on each other are harmless, for A needs no independent rows.

References
----------
Powell (1969), in Optimization, ed. Fletcher, 283-298; Fortin and Glowinski (1983), Augmented Lagrangian Methods.
"""

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import lsqr

from skancf.errors import SingularMatrix, warn
from skancf.linear.constraints import Constraints
from skancf.linear.matrix import BlockMatrix
from skancf.linear.skew import SkewSolver
from skancf.linear.solver import DirectSolver
from skancf.showing import short
from skancf.tolerances import CONDITION_HELD, CONTRADICTION, PASSED, ROUNDED_LEAST_SQUARES, SOFTEST_OF_BLOCK

STIFFNESS = 1e3
"""Of P, over the stiffness that the matrix has against a row: so much a pass gains. With more, its rounding is more than the
bending stiffness of very thin shells."""
SOFTER = 1e-2
"""Of a P that is stiffer than that: what is tried next where a motion next to it looks like rounding."""
VECTOR = 3
MOST = 12
"""Passes of a linear solve; five to eight are the rule."""
SLOW = 0.5
"""A pass that leaves more of the correction before it gains nothing."""


class ConditionedSolver:
    """A direct solver with conditions: it is asked like one, and its answers meet G x = 0.

    Parameters
    ----------
    direct : DirectSolver
        Gets the factors of A.
    gradient : (n, n_dofs) sparse array
        G.
    times : float, optional
        P over the stiffness that the matrix has against a row. Default: :data:`STIFFNESS`.

    Attributes
    ----------
    matrix : BlockMatrix
        K, with the curvature of the conditions.
    stiffness : (n,) array
        The diagonal of P; zero for a row of which supports hold all.
    held : (n,) bool array
        Those rows.
    free : (n, n_dofs) sparse array
        G on the coordinates that no support prescribes.
    passes : int
        Of the last solve.
    lost : float
        What is left of its answer, relatively, where passes came to an end without it; zero elsewhere.

    Examples
    --------
    >>> from scipy.sparse import csr_matrix
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> row = np.zeros(system.n_dofs)
    >>> row[12 * 24 + 2] = 1.0  # z of the node in the middle
    >>> with sk.linear.DirectSolver(system.pattern, system.constraints) as direct:
    ...     solver = sk.linear.ConditionedSolver(direct, csr_matrix(row)).factor(system.tangent(system.undeformed))
    ...     change = solver.solve(system.external_force(system.undeformed, sk.Case()))
    >>> print(abs(row @ change) < 1e-12)
    True
    """

    matrix: BlockMatrix
    stiffness: np.ndarray
    _condensed: SkewSolver

    def __init__(self, direct: DirectSolver, gradient: sp.csr_matrix, times: float | None = None) -> None:
        self.direct, self.gradient, self.times = direct, gradient, STIFFNESS if times is None else times
        self.free = sp.csr_matrix(gradient @ direct.constraints.free_projection)
        self.held = _squares(self.free) <= CONDITION_HELD**2 * _squares(gradient)
        self.skew: Any = None
        self.passes, self.lost = 0, 0.0

    def factor(self, matrix: BlockMatrix, skew: Any = None, sizes: BlockMatrix | None = None) -> "ConditionedSolver":
        """Factors of A for K and, where there is one, a skew part (n_dofs, n_dofs) besides it; P is judged by ``sizes``, by
        default K, which may have lost its stiffness somewhere.

        Raises
        ------
        SingularMatrix
            For a motion that the matrix does not resist and no condition holds.
        """
        self.skew, times = skew, self.times
        while True:
            condensed = self.condensed(matrix, sizes, times)
            try:
                self.direct.factor(condensed)
                break
            except SingularMatrix:
                if times <= STIFFNESS:
                    raise
                # Beside a very stiff P a soft motion, or one that a shift made soft, looks like rounding.
                times = max(STIFFNESS, SOFTER * times)
        self._condensed = SkewSolver(condensed, skew, self.direct)
        return self

    def condensed(self, matrix: BlockMatrix, sizes: BlockMatrix | None = None, times: float | None = None) -> BlockMatrix:
        """A of K, see :meth:`factor`; with another stiffness of P, if given."""
        self.matrix = matrix
        times = self.times if times is None else times
        self.stiffness = times * row_stiffness(sizes or matrix, self.free, self.direct.constraints, self.held)
        return matrix + products(matrix, self.free, self.stiffness)

    def symmetric(self) -> "ConditionedSolver":
        """One without the skew part, by the same factors."""
        if self.skew is None:
            return self
        out = copy(self)
        out.skew, out._condensed = None, SkewSolver(self._condensed.matrix, None, self.direct)
        return out

    @property
    def negative_pivots(self) -> int:
        """Negative eigenvalues of K among motions that meet the conditions: those of A, which are no fewer, and no more but
        in a band next to a critical point, as wide as one over P."""
        return self.direct.negative_pivots

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """K x, with the skew part: (n_dofs,)."""
        product = self.matrix @ x
        return product if self.skew is None else product + self.skew @ x

    def solve(self, rhs: np.ndarray, refinements: int = 1) -> np.ndarray:
        """x of K x + G^T l = rhs, G x = 0 on the free coordinates: (n_dofs,)."""
        return self.solve_both(rhs, np.zeros(len(self.stiffness)))[0]

    def solve_both(self, rhs: np.ndarray, values: np.ndarray, passes: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """x (n_dofs,), zero on prescribed coordinates, and l (n,), zero for rows that supports hold.

        Parameters
        ----------
        rhs, values : (n_dofs,) and (n,) arrays
            a and b.
        passes : int, optional
            One in an iteration that will correct what it leaves. Default: until a pass changes nothing.
        """
        x, multipliers = np.zeros(len(rhs)), np.zeros(len(values))
        left, open_rows = rhs, np.where(self.held, 0.0, values)
        last, self.lost = np.inf, 0.0
        for self.passes in range(1, (passes or MOST) + 1):
            change = self._condensed.solve(left + self.free.T @ (self.stiffness * open_rows))
            more = self.stiffness * (self.free @ change - open_rows)
            x, multipliers = x + change, multipliers + more
            if self.passes == passes:
                break
            moved, pulled = self._size(change) / (self._size(x) or 1.0), self._pull(more) / (self._pull(multipliers) or 1.0)
            size = max(moved, pulled)
            # Rounding of K x is all that a pass finds where it gains no more: of multipliers more than of x.
            if size <= PASSED or self.passes == MOST or (self.passes > 2 and size > SLOW * last):
                self.lost = moved if moved > PASSED else 0.0
                break
            last = size
            left = rhs - self.multiply(x) - self.free.T @ multipliers
            open_rows = np.where(self.held, 0.0, values - self.free @ x)
        return x, multipliers

    def warn_if_lost(self) -> None:
        """A warning where passes of the last solve did not gain what is asked."""
        if self.lost > np.sqrt(PASSED):
            warn(
                f"conditions are met in a linear solve but for {self.lost:.1g} of its answer: after {self.passes} passes "
                "they gain no more. Two conditions may be nearly the same, as of points near each other: leave one out"
            )

    def _pull(self, multipliers: np.ndarray) -> float:
        """Size of multipliers, in the energy of their rows."""
        weights = np.divide(1.0, self.stiffness, out=np.zeros(len(multipliers)), where=self.stiffness > 0)
        return float(np.sqrt(weights @ (multipliers * multipliers)))

    def _size(self, x: np.ndarray) -> float:
        """In the energy of the diagonal, whatever the units."""
        return float(np.sqrt(np.abs(self.matrix.diagonal()) @ (x * x)))


def row_stiffness(matrix: BlockMatrix, free: sp.csr_matrix, constraints: Constraints, held: np.ndarray) -> np.ndarray:
    r"""What the diagonal of P is judged by, one over the compliance of each row if every nodal vector v moved by itself,

    .. math:: 1 \Big/ \sum_v G_{kv} |K_{vv}|^{-1} G_{kv}^T

    with the 3 x 3 blocks of K, in absolute eigenvalues and free directions; on a thin shell that has turned, an entry of the
    diagonal alone takes membrane stiffness for bending.
    """
    touched = np.unique(free.indices // VECTOR)
    compliance = _compliance(matrix, constraints, touched)
    place = np.full(matrix.shape[0] // VECTOR, -1)
    place[touched] = np.arange(len(touched))
    inverse = sp.bsr_matrix((compliance, touched, np.searchsorted(touched, np.arange(len(place) + 1))),
                            shape=matrix.shape)  # fmt: skip
    sums = np.asarray((free @ inverse).multiply(free).sum(axis=1)).ravel()
    return np.divide(1.0, sums, out=np.zeros(len(sums)), where=~held & (sums > 0))


def _compliance(matrix: BlockMatrix, constraints: Constraints, which: np.ndarray) -> np.ndarray:
    """Inverses (m, 3, 3) of the blocks of some nodal vectors, in their free directions."""
    per_node = matrix.pattern.block // VECTOR
    nodes, kinds = np.divmod(which, per_node)
    blocks = matrix.values[matrix.pattern.diagonal_slots[nodes]]
    blocks = blocks.reshape(-1, per_node, VECTOR, per_node, VECTOR)[np.arange(len(nodes)), kinds, :, kinds]
    loose = np.eye(VECTOR) - constraints.of_vectors()[nodes, kinds]
    sizes, axes = np.linalg.eigh(loose @ blocks @ loose)
    sizes = np.abs(sizes)
    largest = sizes.max(axis=1, keepdims=True)
    largest = np.where(largest > 0, largest, largest.max(initial=0.0) or 1.0)
    sizes = np.where(sizes > SOFTEST_OF_BLOCK * largest, sizes, largest)
    return np.asarray(np.einsum("nij,nj,nkj->nik", axes, 1.0 / sizes, axes))


def products(matrix: BlockMatrix, rows: sp.csr_matrix, stiffness: np.ndarray) -> BlockMatrix:
    """G^T P G on the pattern of a matrix, which couples what a row reaches; with a form where the matrix has one."""
    pattern = matrix.pattern
    weighted = sp.diags(np.sqrt(stiffness)) @ rows
    both = sp.bsr_matrix((weighted.T @ weighted).tocsr(), blocksize=(pattern.block, pattern.block))
    row = np.repeat(np.arange(pattern.n_nodes), np.diff(both.indptr))
    upper = row <= both.indices
    values = np.zeros((pattern.n_blocks, pattern.block, pattern.block))
    values[pattern.find(row[upper], both.indices[upper])] = both.data[upper]
    return BlockMatrix(pattern, values, None if matrix.form is None else _OfRows(rows, stiffness))


@dataclass(frozen=True, eq=False)
class _OfRows:
    """The form of G^T P G: of a motion that meets conditions it is zero, its entries leave P times their rounding."""

    rows: sp.csr_matrix
    stiffness: np.ndarray

    __repr__ = short

    def product(self, vector: np.ndarray) -> np.ndarray:
        return np.asarray(self.rows.T @ (self.stiffness * (self.rows @ vector)))

    def energy(self, vector: np.ndarray) -> float:
        return 0.5 * float(self.stiffness @ (self.rows @ vector) ** 2)


def contradiction(gradient: sp.csr_matrix, values: np.ndarray, scales: np.ndarray, constraints: Constraints) -> np.ndarray:
    """Rows (m,), the worst first, of which no change on the free coordinates meets G x = values together; none if one does.

    Rows are compared in their scales; what is left of the values by least squares is in the rows that contradict each other.
    """
    wanted = values / scales
    if not wanted.any():
        return np.empty(0, dtype=int)
    free = sp.csr_matrix(gradient @ constraints.free_projection)
    free = sp.diags((_squares(free) > CONDITION_HELD**2 * _squares(gradient)).astype(float)) @ free
    sizes = np.sqrt(_squares(gradient)) / scales
    even = np.divide(1.0, sizes, out=np.ones(len(sizes)), where=sizes > 0)  # lsqr likes rows of one size
    rows, wanted = sp.diags(even / scales) @ free, even * wanted
    found = lsqr(rows, wanted, atol=ROUNDED_LEAST_SQUARES, btol=ROUNDED_LEAST_SQUARES, iter_lim=20 * len(values) + 100)[0]
    left = np.abs(wanted - rows @ found)
    most = left.max()
    if most <= CONTRADICTION * np.abs(wanted).max():
        return np.empty(0, dtype=int)
    order = np.argsort(-left)
    return order[left[order] > 1e-3 * most]


def _squares(rows: sp.csr_matrix) -> np.ndarray:
    return np.asarray(rows.multiply(rows).sum(axis=1)).ravel()
