"""The order in which statics tries: load steps, relaxation where they end, a push where their answer is not stable."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from skancf.checks import Check, failures
from skancf.errors import SingularMatrix
from skancf.history import Case
from skancf.linear import DirectSolver
from skancf.progress import Bar
from skancf.solution import Solution
from skancf.solving import FOUND, End, Status, run_steps
from skancf.statics.diagnosis import diagnose
from skancf.statics.newton import NewtonResult, newton
from skancf.statics.path import limit_ahead
from skancf.statics.relax import Relaxation
from skancf.statics.static_result import HalveAndGrow, StaticResult
from skancf.statics.tangents import SYMMETRIC_ONLY, is_skew
from skancf.statics.verify import checks_of, verify
from skancf.system.system import System

UNSTABLE = (
    "the equilibrium is not stable: its tangent has {} negative eigenvalue(s), and the first one came between load factor "
    "{:.4g} and {:.4g}. The structure would buckle there; a small disturbing load shows the way, and trace(system, "
    "ArcLength()) the place"
)
SNAPPED = (
    "snapped: Newton's method got no further than load factor {:.4g}, and from there the structure was relaxed at the full "
    "load, to a stable state downhill; there may be others. trace(system) shows the path"
)
MOVED_ON = (
    "relaxed at the full load, because from the state it started from Newton's method found no equilibrium, to a stable "
    "state downhill; there may be others"
)
SLACK = (
    "relaxed at the full load from load factor {:.4g}, to a stable state downhill, because {}. A sheet so thin for its load "
    "may have several ways to wrinkle"
)

logger = logging.getLogger(__name__)
BUCKLED = (
    "buckled: the state to which load steps led had {} negative eigenvalue(s), so it was pushed along its softest motion "
    "and relaxed at the full load, to a stable state downhill; there may be others, such as a mirror image"
)
NOTHING = "Relaxation at the full load found no stable state from there either"
LOST = (
    "rounding of the nodal coordinates leaves up to {:.1e} of the loads or of the energy norm open: the body is so thin, or "
    "so lightly loaded, that its coordinates hardly hold the answer. Of small deflections solve_linear has more digits"
)
SHORTEST = 1 / 16
"""Load steps are halved so far, as a part of the whole load, before the structure is relaxed."""
FARTHEST = 10.0
"""A first correction that turns a slope by more is not followed; 6.3 is a full circle."""


@dataclass(frozen=True)
class Settings:
    """What all solves of a run have in common, and whether it may relax."""

    rtol: float = 1e-7
    max_steps: int = 30
    mixed: bool = True
    relax: bool = True


class Cascade:
    """One run; everything it keeps is usable whenever it stops."""

    def __init__(
        self, system: System, solver: DirectSolver, start: Solution, load_factor: float, settings: Settings, bar: Bar
    ) -> None:
        self.system, self.solver, self.load_factor, self.settings, self.bar = system, solver, load_factor, settings, bar
        self.begin, self.span = start.load_factor, load_factor - start.load_factor
        # A model without these hooks, of which only Newton's method needs to know, has load steps alone.
        self.relaxes = settings.relax and hasattr(system, "layout")
        self.path, self.pivots, self.multipliers = [start], [0], start.multipliers
        self.attempts: list[tuple[float, NewtonResult]] = []
        self.done, self.step, self.failed = 0.0, 1.0, False
        self.checks: tuple[Check, ...] = ()
        self.second_best: tuple[NewtonResult, tuple[Check, ...]] | None = None

    def go(self, control: HalveAndGrow) -> StaticResult:
        """Long load steps, relaxation, short load steps, relaxation; then why it stopped."""
        status, message = run_steps(
            lambda: self._go(control), lambda: f" at load factor {self.path[-1].load_factor:.6g}", lambda error: None, logger
        )
        return StaticResult(self.path[-1], status, tuple(self.path), tuple(self.attempts), message, self.checks)

    def _go(self, control: HalveAndGrow) -> End:
        self.step = min(1.0, control.first)
        tries = [(max(SHORTEST, control.smallest), FARTHEST), (control.smallest, np.inf)]
        for shortest, farthest in tries if self.relaxes else tries[1:]:
            wanted, last = self._load_steps(control, shortest, farthest)
            if self.done == 1.0:
                return self._arrived(last)
            if self.relaxes and (relaxed := self._relaxed(last)):
                return relaxed
        if self.second_best:
            found, self.checks = self.second_best
            self.attempts.append((self.load_factor, found))
            self._keep(found, self.load_factor)
            return self._ended(f"{self._unstable()}. {NOTHING}")
        at = self.path[-1]

        def ahead() -> float | None:
            return limit_ahead(self.system, at, control.smallest * self.span)

        status, message = diagnose(self.system, self.solver, self.path, wanted, last, ahead)
        return status, f"{message} {NOTHING}." if self.relaxes else message

    def _load_steps(self, control: HalveAndGrow, shortest: float, farthest: float) -> tuple[float, NewtonResult]:
        """Steps until the whole load is on or they are shorter than ``shortest``; the last solve and its load factor."""
        while True:
            aim = min(1.0, self.done + self.step)
            factor = self.begin + aim * self.span
            result = self._solve(self.path[-1].q, factor, farthest=farthest)
            if aim == 1.0:
                result = self._verified(result)
            reached = result.status in FOUND
            if reached:
                self.done = aim
                self._keep(result, factor)
            following = control.next_step(self.step, result)
            # A step that is as long as one that has just failed would fail as well.
            self.step = min(self.step, following) if self.failed else following
            self.failed = not reached
            hopeless = self.step < shortest or result.status is Status.TOO_FAR or not self.span
            if self.done == 1.0 or (hopeless and not reached) or self.step < control.smallest:
                return factor, result

    def _solve(self, q: np.ndarray, load_factor: float, **options: Any) -> NewtonResult:
        """Newton's method, of which account is kept."""
        common = {"rtol": self.settings.rtol, "max_steps": self.settings.max_steps, "mixed": self.settings.mixed}
        result = newton(
            self.system, q, self.solver, load_factor=load_factor, multipliers=self.multipliers, **(common | options)
        )
        if result.ok and result.multipliers.size:
            self.multipliers = result.multipliers
        self.attempts.append((load_factor, result))
        spent = sum(attempt.iterations for _, attempt in self.attempts)
        self.bar.at(self.done, f"load factor {self.path[-1].load_factor:.4g}, {spent} iterations")
        return result

    def _keep(self, result: NewtonResult, load_factor: float) -> None:
        multipliers = result.multipliers if result.multipliers.size else None
        self.path.append(Solution(self.system, result.q, load_factor=load_factor, multipliers=multipliers))
        self.pivots.append(result.negative_pivots)
        logger.info(
            "load factor %.6g: %d iterations, %d negative pivots", load_factor, result.iterations, result.negative_pivots
        )
        self.bar.at(self.done, f"load factor {load_factor:.4g}, {result.iterations} iterations")

    def _verified(self, result: NewtonResult) -> NewtonResult:
        """A solve at the whole load after its checks, which may take its promise away; the last attempt."""
        if result.status not in FOUND or not hasattr(self.system, "strain_energy"):
            return result
        rtol = self.settings.rtol
        found = verify(self.system, self.solver, result, rtol=rtol, origin=self.path[0].q)
        self.checks = checks_of(found.measured)
        status, message, bound = Status.CONVERGED, "", 0.0
        if found.unmet or result.status is Status.ROUNDING:
            bound = max([result.bound, *(one.rounding for one in found.unmet)])
            status, message = Status.ROUNDING, LOST.format(bound)
            if failed := failures(self.checks):
                status, message = Status.UNBALANCED, failed
        result = replace(
            result,
            q=found.q,
            status=status,
            message=message,
            bound=bound,
            negative_pivots=found.negative_pivots,
            multipliers=found.multipliers,
        )
        self.attempts[-1] = self.load_factor, result
        return result

    def _arrived(self, last: NewtonResult) -> End:
        """The end of load steps that reached the whole load; from a state that is not stable to one that is."""
        if not last.negative_pivots:
            return last.status, last.message
        if self.relaxes:
            checks = self.checks
            if self._downhill(lambda: self.relaxation.from_unstable(last, self.path[0].q)):
                return self._ended(BUCKLED.format(last.negative_pivots))
            self.checks = checks
            self.attempts.append((self.load_factor, last))
            return self._ended(f"{self._unstable()}. {NOTHING}")
        return self._ended(self._unstable())

    def _relaxed(self, last: NewtonResult) -> End | None:
        """The end by relaxation from the last equilibrium, if it is a stable one."""
        at = self.path[-1]
        if not self._downhill(lambda: self.relaxation.from_state(at.q, self.path[0].q)):
            return None
        if not self.span:
            return self._ended(MOVED_ON)
        too_far = last.status is Status.TOO_FAR
        return self._ended(SLACK.format(at.load_factor, last.message) if too_far else SNAPPED.format(at.load_factor))

    def _ended(self, message: str) -> End:
        """As the last attempt, with what it met on the way."""
        last = self.attempts[-1][1]
        return last.status, f"{message}. {last.message}" if last.message else message

    @cached_property
    def relaxation(self) -> Relaxation:
        return Relaxation(self.system, self.solver, self.load_factor, self._solve)

    def _downhill(self, relaxed: Callable[[], NewtonResult | None]) -> bool:
        """Relax, and keep what passes its checks and is stable; whether there was such a state.

        An equilibrium that is not stable is remembered, for the case that nothing else is found.
        """
        try:
            found = relaxed()
        except SingularMatrix:
            return False
        if found is None or (found := self._verified(found)).status not in FOUND:
            return False
        if found.negative_pivots:
            self.second_best = found, self.checks
            return False
        self.done = 1.0
        self._keep(found, self.load_factor)
        return True

    def _unstable(self) -> str:
        """That the last equilibrium is not stable, and since when."""
        stable = [k for k, pivots in enumerate(self.pivots) if not pivots]
        factors = [state.load_factor for state in self.path]
        first = min(stable[-1] + 1, len(factors) - 1)
        at = self.path[-1]
        message = UNSTABLE.format(self.pivots[-1], factors[first - 1], factors[first])
        skew = is_skew(self.system, self.system.tangent(at.q, Case(at.load_factor)), at.q, at.load_factor)
        return f"{message}. {SYMMETRIC_ONLY}" if skew else message
