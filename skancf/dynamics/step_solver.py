"""One implicit step: Newton's method that keeps its factors as long as they converge."""

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from skancf.dynamics.acceleration import Anderson
from skancf.dynamics.first_guess import advanced
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.dynamics.turning import TurningFactors
from skancf.errors import SingularMatrix
from skancf.history import Case
from skancf.linear import BlockMatrix, DirectSolver
from skancf.statics.stopping import ROUNDING
from skancf.system.system import System

MAX_ITERATIONS = 25
EASY = 4
"""A step that takes no more iterations with new factors may be tried with them again."""
SLOW = 0.5
"""Factors of an earlier step are given up where a correction is not this much smaller than the one before."""
STALLED = 0.5
"""Where corrections are no more than this smaller, and tiny, rounding is what is left of them."""
TINY = 1e-20
"""Energy of such corrections, relative to that of the motion."""
DIVERGED = 1e6
"""Times the energy of the first correction, at which an iteration is given up."""
SMALL = 1e-7
"""Change of coordinates, in sizes of the body, over which the residual is differenced."""
HARDLY, DEGREE = 0.9, 4
"""Vibrations are hardly resolved whose inertia is less than this part of inertia and stiffness over a step; 15 % of their
error is taken for resolved."""
INNER, VECTORS = 0.1, 4
"""How far, and with how many vectors, GMRES goes in each iteration."""


class Effort(IntEnum):
    """How often a step factors its tangent: never, at first and where the iteration becomes slow, or at each iteration."""

    KEEP = 0
    ANEW = 1
    EACH = 2


@dataclass(frozen=True)
class StepOutcome:
    """The increment and the state at the end of a step; both are none of a step that is not ``ok``."""

    ok: bool
    end: State
    u: np.ndarray
    iterations: int
    factorisations: int
    message: str = ""

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
        self.factors = TurningFactors(self.linear, system.constraints, system.layout.moves)
        self.sizes = system.layout.scales.ravel()
        self.factored_dt = 0.0
        self.effort = Effort.KEEP
        self.energy = 0.0
        self.rounding = 0.0

    def close(self) -> None:
        self.linear.close()

    def reached(self, state: State) -> None:
        """Newton's method measures by the largest kinetic energy of the motion, not of steps that were rejected."""
        self.energy = max(self.energy, self.system.kinetic_energy(state.v))

    def state(self) -> dict[str, Any]:
        """All but the factors."""
        return {"energy": self.energy, "effort": int(self.effort), "rounding": self.rounding}

    def restore(self, state: dict[str, Any]) -> None:
        self.energy, self.effort, self.rounding = state["energy"], Effort(state["effort"]), state["rounding"]
        self.forget()

    def forget(self) -> None:
        """Factor anew at the next step, as a run that starts there does."""
        self.factored_dt = 0.0

    def initial_acceleration(self, q: np.ndarray, v: np.ndarray, time: float, driven: np.ndarray) -> np.ndarray:
        """M a = external - internal force and damping on the free coordinates, ``driven`` (n_dofs,) on the others."""
        self.linear.factor(self.system.mass)
        self.forget()
        self.energy = max(self.energy, self.system.kinetic_energy(v))
        return driven + self.linear.solve(self.system.net_force(q, v, Case(time=time)) - self.system.mass @ driven)

    def jump(self, impulse: np.ndarray) -> np.ndarray:
        """The change of the rates by an impulse (n_dofs,), M^-1 of it on the free coordinates."""
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

    def residual(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Inertia, damping and internal force less the loads."""
        rule, system = self.rule, self.system
        out = system.mass @ rule.acceleration(u, start, dt) + rule.internal_force(system, u, start, dt)
        if system.viscous is not None:
            out += system.viscous @ rule.rate(u, start, dt)
        at, time = rule.at_stage(u, start, dt)
        return out - system.applied_force(at, Case(time=time), rule.rate(u, start, dt))

    def step(self, start: State, dt: float) -> StepOutcome:
        """One step of length dt: at first with the factors at hand, and where these do not do, with new ones throughout."""
        with np.errstate(over="ignore", invalid="ignore"):  # a step that diverges is told of by its outcome
            return self._step(start, dt)

    def _step(self, start: State, dt: float) -> StepOutcome:
        efforts = [effort for effort in Effort if effort >= self.effort and (effort > Effort.KEEP or self.factored_dt == dt)]
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
        u, before = self._first_guess(start, dt, effort is Effort.KEEP)
        step = u - before  # what the first guess deforms counts as a correction of a rigid motion
        history, factorisations, last, first, message, fresh = Anderson(), 0, np.inf, 0.0, "", False
        for iteration in range(1, MAX_ITERATIONS + 1):
            residual = self.residual(u, start, dt)
            if not np.isfinite(residual).all():
                message = "values that are not finite"
                break
            change, energy, was_fresh = np.empty(0), np.inf, fresh
            if effort is Effort.KEEP and iteration == 1:
                self.factors.turn_to(*self.rule.tangent_at(u, start))
            if effort is Effort.KEEP or (effort is Effort.ANEW and iteration > 1):
                change, energy = self.factors.solve(-residual)
            slow = energy > SLOW**2 * last
            fresh = effort is Effort.EACH or (effort is Effort.ANEW and (iteration == 1 or (slow and not was_fresh)))
            if fresh:
                try:
                    self._factor(u, start, dt, self.rule.stresses(self.system, before, start, dt, step))
                except SingularMatrix as singular:
                    return StepOutcome(False, start, u, iteration, factorisations, str(singular))
                factorisations += 1
                history.restart()
                change, energy = self.factors.solve(-residual)
            first = first or energy
            if not energy <= DIVERGED * first:
                message = "corrections that grow"
                break
            if self._is_small(energy, first) or STALLED * last < energy < TINY * max(self.energy, first):
                return StepOutcome(True, self.rule.end(u + change, start, dt), u + change, iteration, factorisations)
            if slow and not fresh:
                message = "no convergence with factors of an earlier iteration"
                break
            before, last = u, energy
            each = effort is Effort.EACH
            step = self._with_skew_part(change, residual, u, start, dt) if each else history.step(change, residual)
            u = u + step
        else:
            message = f"no convergence in {MAX_ITERATIONS} iterations"
        self.forget()
        return StepOutcome(False, start, u, iteration, factorisations, f"{message} {self._place(residual)}")

    def _is_small(self, energy: float, first: float) -> bool:
        """Whether a correction may be the last: its scale is that of the motion, or of the first one, which cannot grow."""
        return energy <= self.rtol**2 * max(self.energy, first) + self.rounding

    def _first_guess(self, start: State, dt: float, easy: bool) -> tuple[np.ndarray, np.ndarray]:
        """An increment that meets the supports, and its rigid part."""
        u, rigid = advanced(self.system, start, dt, easy)
        target = self.system.undeformed + self.system.prescribed(Case(time=start.time + dt)) - start.q
        return u + self.system.constraints.fixed_part(target - u), rigid

    def _with_skew_part(
        self, change: np.ndarray, residual: np.ndarray, u: np.ndarray, start: State, dt: float
    ) -> np.ndarray:
        """The correction of the whole tangent, by GMRES on differences of the residual, preconditioned by the factors.

        In coordinates without units, whose norm means something.
        """
        if self.rule.symmetric:
            return change
        sizes, scaled = self.sizes, change / self.sizes

        def product(x: np.ndarray) -> np.ndarray:
            size = SMALL / max(float(np.abs(x).max()), 1e-300)
            return self.factors.solve((self.residual(u + size * sizes * x, start, dt) - residual) / size)[0] / sizes

        operator = LinearOperator((u.size, u.size), matvec=product, dtype=np.float64)
        return sizes * np.asarray(gmres(operator, scaled, x0=scaled, rtol=INNER, atol=0.0, restart=VECTORS, maxiter=1)[0])

    def _factor(self, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> None:
        rule, system = self.rule, self.system
        tangent = rule.stiffness(system, u, start, dt, stresses)
        values = tangent.values
        values += rule.mass_factor(dt) * system.mass.values
        if system.viscous is not None:
            values += rule.damping_factor(dt) * system.viscous.values
        self.factors.factor(BlockMatrix(tangent.pattern, values), rule.tangent_at(u, start)[0])
        self.factored_dt = dt
        # The energy that rounding of the coordinates puts into a correction.
        self.rounding = ROUNDING**2 * float(np.abs(tangent.diagonal()) @ (start.q + u) ** 2)

    def _place(self, residual: np.ndarray) -> str:
        """Where in the plate the residual is largest."""
        sizes = self.system.layout.blocks(np.nan_to_num(np.abs(residual), nan=np.inf)).max(axis=1)
        block, geometry = int(np.argmax(sizes)), self.system.geometry
        if block >= geometry.n_nodes:
            return f"in {self.system.layout.name_of(block)}"
        x, y = geometry.points[:, block]
        return f"near the node at (x, y) = ({x:.4g}, {y:.4g})"
