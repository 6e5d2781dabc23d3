"""One implicit step: Newton's method that keeps its factors as long as they converge."""

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.dynamics.first_guess import advanced
from skancf.dynamics.forces import net_force
from skancf.dynamics.prescribed import prescribed_acceleration
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import NONE, State
from skancf.dynamics.step_newton import Effort, Equations, KeptFactors, StepCriterion, StepTangents
from skancf.history import Case
from skancf.linear import DirectSolver
from skancf.showing import short
from skancf.solving import Status, iterate
from skancf.system.system import System

logger = logging.getLogger(__name__)

MAX_ITERATIONS = 25
EASY = 4
"""A step that takes no more iterations with new factors may be tried with them again."""
HARDLY, DEGREE = 0.9, 4
"""Vibrations are hardly resolved whose inertia is less than this part of inertia and stiffness over a step; 15 % of their
error is taken for resolved."""
WORDS = {
    Status.NOT_FINITE: "values that are not finite", Status.STEPS_SPENT: f"no convergence in {MAX_ITERATIONS} iterations",
}  # fmt: skip


@dataclass(frozen=True)
class StepOutcome:
    """The increment and the state at the end of a step, if it is ``ok``."""

    ok: bool
    end: State
    u: np.ndarray
    iterations: int
    factorisations: int
    message: str = ""

    __repr__ = short

    def after(self, spent: "StepOutcome") -> "StepOutcome":
        """This outcome with the iterations of an earlier attempt counted in."""
        return replace(
            self, iterations=self.iterations + spent.iterations,
            factorisations=self.factorisations + spent.factorisations,
        )  # fmt: skip


class StepSolver:
    """Solves the steps of a run; keeps matrix, factors and the step they belong to."""

    def __init__(self, system: System, rule: Rule, rtol: float | None = None, backend: str = "auto"):
        self.system, self.rule, self.rtol = system, rule, rule.newton_rtol if rtol is None else rtol
        self.linear = DirectSolver(system.pattern, system.constraints, backend)
        self.factors = self._kept()
        self.effort = Effort.KEEP
        self.energy = 0.0

    def _kept(self) -> KeptFactors:
        return KeptFactors(self.linear, self.system.constraints, self.system.layout.moves)

    def close(self) -> None:
        self.linear.close()

    def reached(self, state: State) -> None:
        """Newton's method measures by the largest kinetic energy of the motion, not of steps that were rejected."""
        self.energy = max(self.energy, self.system.kinetic_energy(state.v))

    def state(self) -> dict[str, Any]:
        """All but the factors."""
        return {"energy": self.energy, "effort": int(self.effort), "rounding": self.factors.rounding}

    def restore(self, state: dict[str, Any]) -> None:
        self.energy, self.effort, self.factors.rounding = state["energy"], Effort(state["effort"]), state["rounding"]
        self.forget()

    def forget(self) -> None:
        """Factor anew at the next step, as a run that starts there does."""
        self.factors.dt = 0.0

    def begin(self, time: float, q: np.ndarray, v: np.ndarray, moment: float) -> State:
        """A state that no step leads to, with its accelerations: those of prescribed coordinates over twice a ``moment``
        (s)."""
        driven = prescribed_acceleration(self.system, time, moment)
        return State(time, q, v, self.initial_acceleration(q, v, time, driven))

    def taken(self, state: State, moment: float) -> State:
        """A state that came from another mesh."""
        return state

    def initial_acceleration(self, q: np.ndarray, v: np.ndarray, time: float, driven: np.ndarray) -> np.ndarray:
        """M a = external - internal force and damping on the free coordinates, ``driven`` (n_dofs,) on the others."""
        self.linear.factor(self.system.mass)
        self.forget()
        self.energy = max(self.energy, self.system.kinetic_energy(v))
        return driven + self.linear.solve(net_force(self.system, q, v, Case(time=time)) - self.system.mass @ driven)

    def jump(self, start: State, impulse: np.ndarray, moment: float) -> np.ndarray:
        """The change of the rates of a state by an impulse (n_dofs,), M^-1 of it on the free coordinates."""
        self.linear.factor(self.system.mass)
        self.forget()
        return self.linear.solve(impulse, refinements=2)

    def slowed(self, e: np.ndarray, dt: float) -> np.ndarray:
        r"""F e, with :math:`F = (M + \beta \Delta t^2 K)^{-1} M` of the factored matrix: little of
        what a step does not resolve."""
        return self.factors.solve(self.rule.mass_factor(dt) * (self.system.mass @ e))[0]

    def resolved(self, error: np.ndarray, dt: float) -> np.ndarray:
        r"""The part of an error of frequencies that a step resolves.

        A polynomial of :meth:`slowed`, p(F): one where F is one, and as small as it can be where F is less than
        :data:`HARDLY`.
        """

        def scaled(e: np.ndarray) -> np.ndarray:
            return 2 / HARDLY * self.slowed(e, dt) - e

        x = 2 / HARDLY - 1
        before, now, size_before, size = error, scaled(error), 1.0, x
        for _ in range(DEGREE - 1):
            before, now = now, 2 * scaled(now) - before
            size_before, size = size, 2 * x * size - size_before
        return now / size

    def residual(self, u: np.ndarray, start: State, dt: float, multipliers: np.ndarray = NONE) -> np.ndarray:
        """Inertia, damping and internal force less the loads, (n_dofs,)."""
        return Equations(self.system, self.rule, start, dt).residual(u)

    def step(self, start: State, dt: float) -> StepOutcome:
        """One step of length dt: at first with the factors at hand, and where these do not do, with new ones throughout."""
        with np.errstate(over="ignore", invalid="ignore"):  # a step that diverges is told of by its outcome
            return self._step(start, dt)

    def _step(self, start: State, dt: float) -> StepOutcome:
        efforts = [effort for effort in Effort if effort >= self.effort and (effort > Effort.KEEP or self.factors.dt == dt)]
        outcome: StepOutcome | None = None
        for effort in efforts:
            spent, outcome = outcome, self._newton(start, dt, effort)
            # What takes few iterations with new factors may be tried with them again.
            easy = outcome.factorisations < 2 or (effort is Effort.EACH and outcome.iterations <= EASY)
            self.effort = Effort.KEEP if easy else effort
            if spent is not None:
                outcome = outcome.after(spent)
            if outcome.ok:
                break
        assert outcome is not None
        return outcome

    def _newton(self, start: State, dt: float, effort: Effort) -> StepOutcome:
        tangents, criterion, first = self._problem(start, dt, effort)
        found = iterate(first, tangents, criterion, MAX_ITERATIONS, logger)
        spent = found.iterations, tangents.factorisations
        if found.ok:
            end, u = self._end(found.x, start, dt)
            return StepOutcome(True, end, u, *spent)
        if found.status is Status.SINGULAR:
            return StepOutcome(False, start, found.x, *spent, found.message)
        self.forget()
        what = found.message or WORDS[found.status]
        return StepOutcome(False, start, found.x, *spent, f"{what} {self._place(found.residual)}")

    def _problem(self, start: State, dt: float, effort: Effort) -> tuple[StepTangents, StepCriterion, np.ndarray]:
        """What is iterated on in a step, when that ends, and where it begins."""
        u, before = self._first_guess(start, dt, effort is Effort.KEEP)
        # What the first guess deforms counts as a correction of a rigid motion.
        tangents = StepTangents(Equations(self.system, self.rule, start, dt), self.factors, effort, before, u - before)
        return tangents, StepCriterion(tangents, self.rtol, self.energy), u

    def _end(self, x: np.ndarray, start: State, dt: float) -> tuple[State, np.ndarray]:
        """The state at the end of a step, and its increment, of what was iterated on."""
        return self.rule.end(x, start, dt), x

    def _first_guess(self, start: State, dt: float, easy: bool) -> tuple[np.ndarray, np.ndarray]:
        """An increment that meets the supports, and its rigid part."""
        u, rigid = advanced(self.system, start, dt, easy)
        target = self.system.undeformed + self.system.prescribed(Case(time=start.time + dt)) - start.q
        return u + self.system.constraints.fixed_part(target - u), rigid

    def _place(self, residual: np.ndarray) -> str:
        """Where in the plate the residual is largest, or a law has no stress."""
        if said := self.system.assembly.refusal():
            return f"({said})"
        sizes = self.system.layout.blocks(np.nan_to_num(np.abs(residual), nan=np.inf)).max(axis=1)
        block, geometry = int(np.argmax(sizes)), self.system.geometry
        if block >= geometry.n_nodes:
            return f"in {self.system.layout.name_of(block)}"
        x, y = geometry.points[:, block]
        return f"near the node at (x, y) = ({x:.4g}, {y:.4g})"
