"""Corrections of Newton's method at states of rest, with the mixed tangent or the plain one."""

from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from skancf.history import FULL, Case
from skancf.linear import BlockMatrix, BlockPattern, Constraints, DirectSolver, SkewSolver
from skancf.statics.stopping import Constraint, Pull, work
from skancf.terms.shell import is_heated

NONE = np.zeros(0)
"""Multipliers of a system without conditions."""


def none() -> np.ndarray:
    """Multipliers of a system without conditions."""
    return NONE


class StaticSystem(Protocol):
    """All that statics knows of a model.

    A model may also have ``strain_energy(q, case)``, by which the end of a solve is judged; ``skew(q, case)``, the
    skew-symmetric part of its tangent as a sparse matrix or None; ``others``, sums over terms besides a shell; a ``layout``,
    by which it knows rigid motions; a ``shell``, which knows how far slopes turn and which elements folded; and
    ``conditions``.
    """

    constraints: Constraints
    undeformed: np.ndarray
    pattern: BlockPattern

    @property
    def mass(self) -> BlockMatrix: ...
    def internal_force(self, q: np.ndarray) -> np.ndarray: ...
    def external_force(self, q: np.ndarray, case: Case = FULL) -> np.ndarray: ...
    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray: ...
    def tangent(self, q: np.ndarray, case: Case = FULL, stresses: np.ndarray | None = None) -> BlockMatrix: ...
    def prescribed(self, case: Case = FULL) -> np.ndarray: ...


def skew_part(system: Any, q: np.ndarray, load_factor: float) -> sp.csr_matrix | None:
    """Skew-symmetric part of the tangent at (q, load factor); None without one."""
    hook: Any = getattr(system, "skew", None)
    return hook(q, Case(load_factor)) if hook and (load_factor or getattr(system, "others", None)) else None


def factored(
    system: StaticSystem, q: np.ndarray, load_factor: float, solver: DirectSolver, stresses: np.ndarray | None = None,
    pull: Pull | None = None,
) -> SkewSolver:  # fmt: skip
    """The tangent at (q, load factor), with ``stresses`` and that of a ``pull`` if given, and its solver.

    Raises
    ------
    SingularMatrix
    """
    matrix = system.tangent(q, Case(load_factor), stresses)
    if pull:
        matrix = matrix + pull.strength * pull.metric
    solver.factor(matrix)
    return SkewSolver(matrix, skew_part(system, q, load_factor), solver)


def internal_force(system: Any, q: np.ndarray, load_factor: float, stresses: Any = None) -> np.ndarray:
    """That of the structure; heat inside a law is in it, at a load factor. With ``stresses`` of :func:`stresses_along` of a
    law at points, that of the law linearised about them."""
    case = Case(load_factor) if is_heated(system) else FULL
    if getattr(stresses, "answer", None) is not None:
        force: np.ndarray = system.shell.mixed_force(q, stresses, case)
        return force + system.others.force(q, None, case) if system.others else force
    return np.asarray(system.internal_force(q, None, case) if is_heated(system) else system.internal_force(q))


def stresses_along(system: Any, q: np.ndarray, change: np.ndarray, load_factor: float) -> Any:
    """Stresses extrapolated along a change, at a load factor; of laws at points what these say of extrapolated strains."""
    if getattr(getattr(system, "shell", None), "at_points", False):
        return system.shell.extrapolated(q, change, Case(load_factor))
    return system.stresses(q, change)


def load_rate(system: Any, q: np.ndarray, load_factor: float) -> np.ndarray:
    """Derivative of the loads with respect to the load factor, with the forces of heat inside a law: (n_dofs,)."""
    force = system.external_force(q)
    return np.asarray(force + system.shell.load_rate(q, load_factor) if is_heated(system) else force)


def along_load(system: StaticSystem, q: np.ndarray, load_factor: float, tangent: SkewSolver) -> np.ndarray:
    """Derivative of q with respect to the load factor."""
    force, moved = load_rate(system, q, load_factor), system.prescribed()
    return tangent.solve(force - tangent.multiply(moved) if moved.any() else force) + moved


class Tangents:
    """The tangent of every state: the mixed one, of stresses extrapolated along the last step, or the plain one.

    The unknowns are q and the load factor, which only a constraint changes.
    """

    conditions: Any = None
    """Those of the system; None without any."""
    tangent: Any
    force: np.ndarray
    moved: np.ndarray
    pulled = NONE

    def __init__(
        self, system: StaticSystem, solver: DirectSolver, mixed: bool, stresses: np.ndarray | None, pull: Pull | None,
        constraint: Constraint | None,
    ) -> None:  # fmt: skip
        self.system, self.solver, self.mixed, self.stresses = system, solver, mixed, stresses
        self.pull, self.constraint, self.prescribed = pull, constraint, system.prescribed()
        self.n = system.undeformed.size
        self.along: np.ndarray | None = None

    def unknowns(self, q: np.ndarray, multipliers: np.ndarray | None, load_factor: float) -> np.ndarray:
        """All in one vector."""
        return np.append(q, load_factor)

    def unmet(self, x: np.ndarray) -> str:
        """Which condition a state does not meet, in words."""
        return ""

    def residual(self, x: np.ndarray) -> np.ndarray:
        q, load_factor = x[:-1], float(x[-1])
        self.force = load_factor * self.system.external_force(q)
        residual = internal_force(self.system, q, load_factor, self.stresses) - self.force
        return residual + self.pull.force(q) if self.pull else residual

    def correction(self, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        """By the work of the residual; with a constraint by that of the tangent on the correction."""
        q, load_factor, system = x[:-1], float(x[-1]), self.system
        self.tangent = tangent = factored(system, q, load_factor, self.solver, self.stresses, self.pull)
        self.moved = moved = system.constraints.fixed_part(system.undeformed + load_factor * self.prescribed - q)
        rhs = -(residual + tangent.multiply(moved)) if moved.any() else -residual
        free = tangent.solve(rhs)
        if self.constraint is None:
            return np.append(free + moved, 0.0), work(free, rhs)
        self.along = along = along_load(system, q, load_factor, tangent)
        change = free + moved
        more = self.constraint.correction(q + change, load_factor, along)
        change = change + more * along if np.isfinite(more) else np.full_like(q, np.inf)
        return np.append(change, more), work(change, tangent.multiply(change))

    def step(self, x: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        along = x[:-1], change[:-1], float(x[-1] + change[-1])
        self.stresses = stresses_along(self.system, *along) if self.mixed else None
        return x + change
