"""States on the conditions of another mesh: the nearest in the mass norm, which changes no momentum of what floats."""

from functools import cached_property
from typing import Any

import numpy as np

from skancf.conditions.solver import conditions_in, solver_at
from skancf.dynamics.prescribed import RATE_STEP
from skancf.history import Case
from skancf.linear import ConditionedSolver, DirectSolver
from skancf.system.rigid import free_rigid_motions
from skancf.system.system import System

CLOSINGS = 5
"""Steps onto the conditions, at most; they converge as Newton's method does."""
TRANSLATION = "translation"


class Mass:
    """Accelerations of free coordinates by the mass, of motions that keep the conditions at q; factored when first used."""

    def __init__(self, system: System, q: np.ndarray, backend: str):
        self.system, self.q, self._backend = system, q, backend

    @cached_property
    def _direct(self) -> DirectSolver:
        return DirectSolver(self.system.pattern, self.system.constraints, self._backend)

    @cached_property
    def factors(self) -> Any:
        """A direct solver, or one with the conditions at q."""
        solver = solver_at(self.system, self._direct, self.q)
        solver.factor(self.system.mass)
        return solver

    def solve(self, force: np.ndarray) -> np.ndarray:
        return np.asarray(self.factors.solve(force))

    def nearest(self, values: np.ndarray) -> np.ndarray:
        """The smallest change that changes the conditions by so much, (n_dofs,)."""
        factors: ConditionedSolver = self.factors
        return factors.solve_both(np.zeros(self.system.n_dofs), values)[0]

    def close(self) -> None:
        if "_direct" in vars(self):
            self._direct.close()


def closed(system: System, q: np.ndarray, case: Case, backend: str) -> np.ndarray:
    """The state next to q that meets the conditions."""
    conditions = conditions_in(system)
    for _ in range(CLOSINGS if conditions else 0):
        values = conditions.value(q, case)
        if conditions.met(values):
            break
        mass = Mass(system, q, backend)
        try:
            q = q + mass.nearest(-values)
        finally:
            mass.close()
    return q


def kept(mass: Mass, q: np.ndarray, v: np.ndarray, time: float | None) -> np.ndarray:
    """The velocity next to v that keeps the conditions at q, which may move with time."""
    conditions = conditions_in(mass.system)
    if not conditions:
        return v
    rate = np.zeros(conditions.n)
    if time is not None:
        step = RATE_STEP * max(1.0, abs(time))
        soon, before = (conditions.value(q, Case(time=time + sign * step)) for sign in (1, -1))
        rate = (soon - before) / (2 * step)
    return v + mass.nearest(-(conditions.gradient(q) @ v + rate))


def floats(system: System) -> bool:
    """Whether supports, springs and conditions let a body move anywhere."""
    if system.foundation is not None or system.constraints.fixed.any():
        return False
    if not system.conditions:
        return True
    return sum(name.startswith(TRANSLATION) for name in free_rigid_motions(system)) == 3
