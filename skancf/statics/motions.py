"""Motions among which eigenpairs are sought: all on the free coordinates, or those of them that meet conditions."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import null_space

from skancf.errors import InputError
from skancf.linear import BlockMatrix, ConditionedSolver, Constraints, DirectSolver
from skancf.statics.conditioned import conditions_in
from skancf.tolerances import DEPENDENT

STIFFNESS, PASSES = 2e7, 3
"""P of :mod:`skancf.linear.conditioned`, and passes for each step of Lanczos' method: they leave 1e-8 of an eigenvalue of
thin shells on fine meshes, and 1e-10 of others. A number of eigenvalues is one too large in a band next to each of them
whose width, relatively, is one over P."""


class Motions:
    """All on the free coordinates.

    Parameters
    ----------
    direct : DirectSolver
        Gets the factors.

    Attributes
    ----------
    solve : callable
        x, one of them, of A x = rhs for rhs (n_dofs,): (n_dofs,).
    """

    solve: Callable[[np.ndarray], np.ndarray]

    def __init__(self, direct: DirectSolver) -> None:
        self.direct, self.constraints = direct, direct.constraints
        self.solve = direct.solve

    @property
    def room(self) -> int:
        """Their dimension, or somewhat less."""
        return self.constraints.n_free

    def require(self, n: int) -> None:
        """InputError where there are fewer than n, which is no more than the free coordinates are."""

    def factor(self, matrix: BlockMatrix) -> None:
        """Factors of a matrix A.

        Raises
        ------
        SingularMatrix
        """
        self.direct.factor(matrix)

    @property
    def negative_pivots(self) -> int:
        """Negative eigenvalues of the matrix among them."""
        return self.direct.negative_pivots

    def directions(self) -> np.ndarray:
        """An orthonormal basis, (n, n_dofs)."""
        return free_directions(self.constraints)

    def correction(self, residual: np.ndarray, shape: np.ndarray) -> tuple[np.ndarray, float]:
        """What the residual (n_dofs,) of an eigenpair moves, (n_dofs,), and by how much its eigenvalue is off to first order
        as the shape (n_dofs,) is not quite one of these motions."""
        return self.direct.solve(residual), 0.0


class HeldMotions(Motions):
    r"""Those that meet conditions, :math:`G \phi = 0`.

    With multipliers l the residual :math:`r + G^T l` is the one among them. A gap :math:`G \phi` changes the eigenvalue by
    :math:`2 \, l \cdot G \phi`, to first order.

    Parameters
    ----------
    direct : DirectSolver
    gradient : (n, n_dofs) sparse array
        G.
    stiffness : BlockMatrix
        By which P is judged, whatever matrix is factored.
    """

    def __init__(self, direct: DirectSolver, gradient: sp.csr_matrix, stiffness: BlockMatrix) -> None:
        super().__init__(direct)
        self._stiffness = stiffness
        self._held = ConditionedSolver(direct, gradient, STIFFNESS)
        self._zero = np.zeros(gradient.shape[0])
        self.solve = lambda rhs: self._held.solve_both(rhs, self._zero, PASSES)[0]

    @property
    def room(self) -> int:
        return max(self.constraints.n_free - int(np.count_nonzero(~self._held.held)), 0)

    def require(self, n: int) -> None:
        if n > self.room and n > (most := len(self.directions())):
            raise InputError(f"n = {n}: give a whole number of modes, at most the {most} motions that meet the conditions")

    def factor(self, matrix: BlockMatrix) -> None:
        self._held.factor(matrix, sizes=self._stiffness)

    def directions(self) -> np.ndarray:
        free = free_directions(self.constraints)
        rows = self._held.gradient @ free.T
        sizes = np.linalg.norm(rows, axis=1)
        rows = rows[~self._held.held] / sizes[~self._held.held, None]
        return np.asarray(null_space(rows, rcond=DEPENDENT).T @ free)

    def correction(self, residual: np.ndarray, shape: np.ndarray) -> tuple[np.ndarray, float]:
        moved, multipliers = self._held.solve_both(residual, self._zero)
        return moved, 2 * float(np.abs(multipliers) @ np.abs(self._held.gradient @ shape))


def motions_of(system: Any, direct: DirectSolver, about: np.ndarray, stiffness: BlockMatrix) -> Motions:
    """Those of a system about a state (n_dofs,), in which it has a stiffness."""
    conditions = conditions_in(system)
    return HeldMotions(direct, conditions.gradient(about), stiffness) if conditions else Motions(direct)


def free_directions(constraints: Constraints) -> np.ndarray:
    """Unit vectors along the free coordinates, (n_free, n_dofs)."""
    numbers = np.flatnonzero(~constraints.fixed.ravel())
    return np.array([constraints.from_frame(e) for e in np.eye(constraints.fixed.size)[numbers]])
