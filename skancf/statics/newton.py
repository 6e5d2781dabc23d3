r"""Newton's method with the mixed-integration-point tangent.

The tangent is taken with the stresses extrapolated linearly along the last step,
:math:`\sigma_{j+1} = C(\varepsilon(q_j) + B(q_j)\,\delta q_j)`, instead of those of the present state; the residual is the
exact one (Magisano, Leonetti and Garcea, 2017).
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from skancf.errors import DidNotConverge, SingularMatrix
from skancf.linear import BlockMatrix, Constraints, DirectSolver


class System(Protocol):
    """All that Newton's method knows of a model."""

    constraints: Constraints
    undeformed: np.ndarray

    def internal_force(self, q: np.ndarray) -> np.ndarray: ...
    def external_force(self, q: np.ndarray, time: float | None = None) -> np.ndarray: ...
    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray: ...
    def tangent(
        self, q: np.ndarray, stresses: np.ndarray | None = None, time: float | None = None, factor: float = 1.0
    ) -> BlockMatrix: ...
    def prescribed(self, time: float | None = None) -> np.ndarray: ...


class Status(Enum):
    """How a solve ended."""

    CONVERGED = "converged"
    STEPS_SPENT = "iteration limit reached"
    DIVERGED = "residual grew"
    NOT_FINITE = "residual is not finite"
    SINGULAR = "tangent is singular"
    STEP_TOO_SMALL = "load step became too small"


@dataclass(frozen=True)
class NewtonResult:
    """Outcome of one solve.

    ``residual_norms`` are energy norms of the residual, sqrt(R . K^-1 R), relative to the largest one met.
    """

    q: np.ndarray
    status: Status
    residual_norms: tuple[float, ...]
    negative_pivots: int = 0
    message: str = ""

    @property
    def converged(self) -> bool:
        return self.status is Status.CONVERGED

    def unwrap(self) -> np.ndarray:
        """q, or :class:`~skancf.DidNotConverge`."""
        if not self.converged:
            tail = ", ".join(f"{r:.1e}" for r in self.residual_norms[-3:])
            raise DidNotConverge(f"newton: {self.status.value}; residual ... {tail}. {self.message}", self.residual_norms)
        return self.q


ROUNDING = 1e-15


def work(change: np.ndarray, force: np.ndarray) -> float:
    """|change . force|; infinite or NaN where it does not fit a float, without a warning."""
    with np.errstate(over="ignore", invalid="ignore"):
        return abs(float(change @ force))


def newton(
    system: System,
    q: np.ndarray,
    solver: DirectSolver,
    *,
    load_factor: float = 1.0,
    rtol: float = 1e-7,
    max_steps: int = 30,
    mixed: bool = True,
    watch: Callable[[int, float], None] | None = None,
) -> NewtonResult:
    """Equilibrium under ``load_factor`` times the loads and prescribed displacements, from a first guess.

    A step whose energy, the residual's work on it, is less than ``rtol**2`` of the largest one is the last one; that
    measure feels no rounding of the membrane forces in very thin plates.

    Parameters
    ----------
    q : (n_dofs,) array
        First guess.
    mixed : bool
        Mixed-integration-point tangent; False is the plain method.
    watch : callable, optional
        Called with the step's number and the relative norm.
    """
    target = system.undeformed + load_factor * system.prescribed()
    stresses = None
    energies: list[float] = []

    def result(status: Status, message: str = "") -> NewtonResult:
        largest = max(energies, default=1.0) or 1.0
        norms = tuple(float(np.sqrt(e / largest)) for e in energies)
        pivots = solver.negative_pivots if energies and status is not Status.SINGULAR else 0
        return NewtonResult(q, status, norms, pivots, message)

    for step in range(max_steps):
        residual = system.internal_force(q) - load_factor * system.external_force(q)
        if not np.isfinite(residual).all():
            return result(Status.NOT_FINITE, _where(system, residual))
        matrix = system.tangent(q, stresses, factor=load_factor)
        moved = system.constraints.fixed_part(target - q)
        try:
            solver.factor(matrix)
        except SingularMatrix as singular:
            return result(Status.SINGULAR, str(singular))
        rhs = -(residual + matrix @ moved) if moved.any() else -residual
        free = solver.solve(rhs)
        energies.append(work(free, rhs))
        if watch:
            watch(step, float(np.sqrt(energies[-1] / max(energies))) if energies[-1] else 0.0)
        if not np.isfinite(energies[-1]):
            energies.pop()
            return result(Status.NOT_FINITE, _where(system, free))
        change = free + moved
        floor = ROUNDING**2 * float(np.abs(matrix.diagonal()) @ (q * q))
        if energies[-1] <= rtol**2 * max(energies) + floor and (step > 0 or energies[-1] <= floor):
            q = q + change
            return result(Status.CONVERGED)
        if step > 3 and energies[-1] > 1e8 * energies[0] + floor:
            return result(Status.DIVERGED)
        stresses = system.stresses(q, change) if mixed else None
        q = q + change
    return result(Status.STEPS_SPENT)


def _where(system: System, values: np.ndarray) -> str:
    node = int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf))) // 12
    x, y, z = system.undeformed.reshape(-1, 12)[node, :3]
    return f"first at the node that was at ({x:.4g}, {y:.4g}, {z:.4g})"
