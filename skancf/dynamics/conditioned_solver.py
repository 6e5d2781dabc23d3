r"""Steps and states with conditions.

A state that no step leads to has velocities and accelerations that keep the conditions,

.. math::
    G v + \partial_t g = 0, \qquad M a + G^T \lambda = f, \qquad G a = -\dot G v - \partial_t^2 g .
"""

from dataclasses import replace

import numpy as np

from skancf.dynamics.conditioned_step import (
    ConditionedCriterion,
    ConditionedEquations,
    ConditionedFactors,
    ConditionedTangents,
)
from skancf.dynamics.forces import net_force
from skancf.dynamics.prescribed import prescribed_acceleration
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import NONE, State
from skancf.dynamics.step_newton import DIFFERENCE, Effort, KeptFactors, StepCriterion, StepTangents
from skancf.dynamics.step_solver import StepSolver
from skancf.errors import warn
from skancf.history import Case
from skancf.linear import ConditionedSolver, DirectSolver
from skancf.system.system import System
from skancf.tolerances import ABOVE_ZERO

AGAINST = 0.01
"""Of a velocity: a larger part of it that conditions do not allow is said."""


def step_solver(system: System, rule: Rule, rtol: float | None = None, backend: str = "auto") -> StepSolver:
    """Of a system with conditions or without."""
    return (ConditionedStepSolver if system.conditions else StepSolver)(system, rule, rtol, backend)


class ConditionedStepSolver(StepSolver):
    """Solves the steps of a run with conditions."""

    factors: ConditionedFactors

    def __init__(self, system: System, rule: Rule, rtol: float | None = None, backend: str = "auto") -> None:
        super().__init__(system, rule, rtol, backend)
        self.massive = DirectSolver(system.pattern, system.constraints, backend)

    def _kept(self) -> KeptFactors:
        system = self.system
        return ConditionedFactors(system.conditions, self.linear, system.constraints, system.layout.moves)

    def close(self) -> None:
        super().close()
        self.massive.close()

    def begin(self, time: float, q: np.ndarray, v: np.ndarray, moment: float) -> State:
        driven = prescribed_acceleration(self.system, time, moment)
        held, (rate, second) = self._inertia(q), self._driving(time, q, moment)
        kept = v - held.solve_both(np.zeros(v.size), held.gradient @ v + rate)[0]
        self._tell(v, kept)
        v = kept
        self.energy = max(self.energy, self.system.kinetic_energy(v))
        force = net_force(self.system, q, v, Case(time=time)) - self.system.mass @ driven
        a, multipliers = held.solve_both(force, -(self._turning(q, v) + second + held.gradient @ driven))
        return State(time, q, v, driven + a, multipliers=multipliers, acting=time)

    def _tell(self, v: np.ndarray, kept: np.ndarray) -> None:
        """Warn where velocities were against the conditions."""
        system = self.system
        lost, whole = (system.kinetic_energy(each) ** 0.5 for each in (v - kept, v))
        if lost > AGAINST * whole > 0.0:
            warn(
                f"velocity: {lost / whole:.2g} of it, in the norm of the mass, is against the conditions "
                f"({', '.join(map(repr, system.conditions.names))}). The run begins with the nearest one that keeps them"
            )

    def taken(self, state: State, moment: float) -> State:
        """With multipliers on this mesh, those that belong to its forces and velocities."""
        return replace(state, multipliers=self.begin(state.time, state.q, state.v, moment).multipliers)

    def jump(self, start: State, impulse: np.ndarray, moment: float) -> np.ndarray:
        """Velocities keep the conditions, whose impulses do no work."""
        held, (rate, _) = self._inertia(start.q), self._driving(start.time, start.q, moment)
        return held.solve_both(impulse, -(held.gradient @ start.v + rate))[0]

    def _inertia(self, q: np.ndarray) -> ConditionedSolver:
        return ConditionedSolver(self.massive, self.system.conditions.gradient(q)).factor(self.system.mass)

    def _driving(self, time: float, q: np.ndarray, moment: float) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivative of g with respect to time alone, over twice a ``moment`` (s)."""
        now, soon, later = (self.system.conditions.value(q, Case(time=time + k * moment)) for k in range(3))
        return (4 * soon - 3 * now - later) / (2 * moment), (later - 2 * soon + now) / moment**2

    def _turning(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The change of G with the motion, times v; exact where g is quadratic."""
        conditions = self.system.conditions
        step = DIFFERENCE**0.5 / max(float(np.abs(v / self.system.layout.scales.ravel()).max()), ABOVE_ZERO)
        after, before = (conditions.gradient(q + sign * step * v) @ v for sign in (1.0, -1.0))
        return np.asarray((after - before) / (2 * step))

    def slowed(self, e: np.ndarray, dt: float) -> np.ndarray:
        n, inertia = e.size, self.rule.mass_factor(dt) * (self.system.mass @ e)
        return self.factors.solve(np.concatenate([inertia, np.zeros(self.system.conditions.n)]))[0][:n]

    def residual(self, u: np.ndarray, start: State, dt: float, multipliers: np.ndarray = NONE) -> np.ndarray:
        """With the force of the conditions."""
        equations = ConditionedEquations(self.system, self.rule, start, dt)
        return equations.residual(np.concatenate([u, multipliers]))[: u.size]

    def _problem(self, start: State, dt: float, effort: Effort) -> tuple[StepTangents, StepCriterion, np.ndarray]:
        u, before = self._first_guess(start, dt, effort is Effort.KEEP)
        x, before = (np.concatenate([each, start.multipliers]) for each in (u, before))
        equations = ConditionedEquations(self.system, self.rule, start, dt)
        tangents = ConditionedTangents(equations, self.factors, effort, before, x - before)
        return tangents, ConditionedCriterion(tangents, self.rtol, self.energy), x

    def _end(self, x: np.ndarray, start: State, dt: float) -> tuple[State, np.ndarray]:
        u = x[: self.system.n_dofs].copy()
        multipliers, (_, acting) = x[self.system.n_dofs :].copy(), self.rule.at_stage(u, start, dt)
        return replace(self.rule.end(u, start, dt), multipliers=multipliers, acting=acting), u

    def _place(self, residual: np.ndarray) -> str:
        """Where the residual is largest, and which condition is missed where one is."""
        conditions, values = self.system.conditions, residual[self.system.n_dofs :]
        place = super()._place(residual[: self.system.n_dofs])
        missed = np.abs(values) / conditions.scales
        if conditions.met(values) or not np.isfinite(missed).all():
            return place
        row = int(np.argmax(missed))
        return f"{place}; {conditions.words(row)} is off by {values[row]:.3g}, {missed[row]:.1e} of its scale"
