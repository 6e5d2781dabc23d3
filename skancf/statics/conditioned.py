"""Statics with conditions: multipliers are carried from correction to correction, as stresses of the mixed tangent are."""

from typing import Any

import numpy as np

from skancf.conditions.solver import conditions_in, curved, solver_at
from skancf.history import FULL, Case
from skancf.linear import BlockMatrix, ConditionedSolver, DirectSolver, SkewSolver
from skancf.solution import Solution
from skancf.statics.corrections import (
    NONE,
    StaticSystem,
    Tangents,
    along_load,
    factored,
    load_rate,
    skew_part,
    stresses_along,
)
from skancf.statics.stopping import Pull, work

PASSES = 1
"""Of the solve with conditions in a correction: the next correction mends what it leaves."""
Tangent = SkewSolver | ConditionedSolver


def tangent_at(
    system: Any, q: np.ndarray, load_factor: float, solver: DirectSolver, stresses: np.ndarray | None = None,
    multipliers: np.ndarray | None = None, pull: Pull | None = None,
) -> Tangent:  # fmt: skip
    """:func:`factored`, with conditions where a system has them.

    Raises
    ------
    SingularMatrix
    """
    if not conditions_in(system):
        return factored(system, q, load_factor, solver, stresses, pull)
    matrix = curved(system, system.tangent(q, Case(load_factor), stresses), q, multipliers)
    if pull:
        matrix = matrix + pull.strength * pull.metric
    held: ConditionedSolver = solver_at(system, solver, q)
    return held.factor(matrix, skew_part(system, q, load_factor))


def factored_about(system: Any, solver: DirectSolver, matrix: BlockMatrix, skew: Any, about: np.ndarray) -> Tangent:
    """A matrix and its skew part, with the conditions to first order about unknowns of the system where it has some.

    Raises
    ------
    SingularMatrix
    """
    if conditions_in(system):
        held: ConditionedSolver = solver_at(system, solver, about)
        return held.factor(matrix, skew)
    solver.factor(matrix)
    return SkewSolver(matrix, skew, solver)


def rows_of(tangent: Tangent, change: np.ndarray) -> np.ndarray:
    """What a change makes of the conditions of a tangent, (n,)."""
    return np.asarray(tangent.gradient @ change) if isinstance(tangent, ConditionedSolver) else NONE


def along_both(system: Any, q: np.ndarray, load_factor: float, tangent: Tangent) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of q and of the multipliers with respect to the load factor."""
    if not isinstance(tangent, ConditionedSolver):
        return along_load(system, q, load_factor, tangent), NONE
    force, moved, conditions = load_rate(system, q, load_factor), system.prescribed(), system.conditions
    rate = conditions.value(q, FULL) - conditions.value(q, Case(0.0))
    change, more = tangent.solve_both(force - tangent.multiply(moved), -(rate + tangent.gradient @ moved))
    return change + moved, more


def at_rest(system: Any) -> Solution:
    """The undeformed state without loads, from which statics begins."""
    conditions = conditions_in(system)
    multipliers = np.zeros(conditions.n) if conditions else None
    return Solution(system, system.undeformed.copy(), load_factor=0.0, multipliers=multipliers)


def is_loaded(system: Any, q: np.ndarray, load_factor: float = 0.0) -> bool:
    """Whether anything loads a system: a load in a state (n_dofs,), temperature, or a support or a condition that moves."""
    conditions = conditions_in(system)
    moves = conditions is not None and not conditions.met(conditions.value(system.undeformed))
    return bool(moves or system.prescribed().any() or load_rate(system, q, load_factor).any())


def solved(tangent: Tangent, rhs: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """A correction of q, that of the multipliers, and the energy of the first."""
    if not isinstance(tangent, ConditionedSolver):
        change = tangent.solve(rhs)
        return change, NONE, work(change, rhs)
    change, more = tangent.solve_both(rhs, values)
    return change, more, work(change, tangent.multiply(change))


def tangents_of(system: StaticSystem, *options: Any) -> Tangents:
    """The corrections of a system, with its conditions or without."""
    return (ConditionedTangents if conditions_in(system) else Tangents)(system, *options)


class ConditionedTangents(Tangents):
    """Those of a system with conditions: the unknowns are q, the multipliers and the load factor."""

    system: Any

    def __init__(self, system: Any, *options: Any) -> None:
        super().__init__(system, *options)
        self.conditions = system.conditions

    def unknowns(self, q: np.ndarray, multipliers: np.ndarray | None, load_factor: float) -> np.ndarray:
        return np.concatenate([q, np.zeros(self.conditions.n) if multipliers is None else multipliers, [load_factor]])

    def unmet(self, x: np.ndarray) -> str:
        return str(self.conditions.worst(x[: self.n], Case(float(x[-1]))))

    def residual(self, x: np.ndarray) -> np.ndarray:
        q, multipliers, case = x[: self.n], x[self.n : -1], Case(float(x[-1]))
        self.values = self.conditions.value(q, case)
        return super().residual(np.append(q, x[-1])) + self.conditions.force(q, multipliers)

    def correction(self, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        """By the work of the tangent on the correction."""
        q, multipliers, load_factor, system = x[: self.n], x[self.n : -1], float(x[-1]), self.system
        tangent: Any = tangent_at(system, q, load_factor, self.solver, self.stresses, multipliers, self.pull)
        self.tangent = tangent
        self.moved = moved = system.constraints.fixed_part(system.undeformed + load_factor * self.prescribed - q)
        rhs, values = -(residual + tangent.multiply(moved)), -(self.values + tangent.gradient @ moved)
        change, more = tangent.solve_both(rhs, values, PASSES)
        change, step = change + moved, 0.0
        if self.constraint is not None:
            self.along, self.pulled = along_both(system, q, load_factor, tangent)
            step = self.constraint.correction(q + change, load_factor, self.along)
            if not np.isfinite(step):
                return np.full_like(x, np.inf), np.inf
            change, more = change + step * self.along, more + step * self.pulled
        return np.concatenate([change, more, [step]]), work(change, tangent.multiply(change))

    def step(self, x: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        along = x[: self.n], change[: self.n], float(x[-1] + change[-1])
        self.stresses = stresses_along(self.system, *along) if self.mixed else None
        return x + change
