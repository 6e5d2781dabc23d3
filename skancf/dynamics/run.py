"""The loop in time: integrator, step control, meshes and output are separate objects."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from skancf.arguments import flag
from skancf.atomic import reason
from skancf.checks import Check, failures
from skancf.dynamics.conditioned_solver import step_solver
from skancf.dynamics.error import Measure
from skancf.dynamics.impulses import LoadImpulses, Missed
from skancf.dynamics.ledger import LedgerRecorder, MeshEvent
from skancf.dynamics.log import Log
from skancf.dynamics.motion import Motion, Step
from skancf.dynamics.motion_checks import MOMENTA, checks_of
from skancf.dynamics.named_state import HasState, flat, nested
from skancf.dynamics.recorder import Recorder
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.dynamics.step_solver import StepOutcome
from skancf.dynamics.steps import FADING, Attempt, StepControl
from skancf.errors import InputError, SkancfError, positive
from skancf.functions import called
from skancf.history import Case, knots_of
from skancf.progress import Bar
from skancf.showing import short
from skancf.solving import End, Status, run_steps
from skancf.system.system import System
from skancf.tolerances import ABOVE_ZERO, ROUNDED_TIME

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class NewMesh:
    """A change of the mesh: the system to go on with, the state there, and what that changed.

    The time of the state is the present one, or that of the last check, to which the run then goes back; ``raised`` is the
    energy that it gained (J).
    """

    system: System
    state: State
    event: MeshEvent
    raised: float = 0.0

    __repr__ = short


class MeshPolicy(Protocol):
    """Decides on meshes, at regular intervals of steps, and carries states over."""

    @property
    def every(self) -> int:
        """Accepted steps from check to check."""

    def check(self, system: System) -> None:
        """InputError for a system whose mesh cannot follow."""

    def change(self, system: System, before: State, now: State, end: float, energy: float, again: bool) -> NewMesh | None:
        """A change of the mesh, from the states at the last check and now; None to go on with this one.

        ``end`` is that of the run (s), ``energy`` the largest strain energy so far, ``again`` whether the run may go back
        to the last check.
        """


@dataclass(frozen=True)
class Settings:
    """What a run is asked for, but for its system and its first state."""

    rule: Rule
    control: StepControl
    begin: float
    end: float
    newton_rtol: float | None = None
    balance: float | None = None
    follow: MeshPolicy | None = None
    backend: str = "auto"

    @property
    def span(self) -> float:
        return self.end - self.begin


OWN = ("dt", "shortest", "farthest", "hardest", "origin", "tries")
"""What a run remembers besides its parts."""


class Run:
    """State of one run; everything it keeps is usable whenever it stops.

    ``struck``: the first state is the one after what happened at its time.
    """

    def __init__(
        self, system: System, settings: Settings, recorder: Recorder, q: np.ndarray, v: np.ndarray, struck: bool = False
    ):  # fmt: skip
        self.settings, self.recorder = settings, recorder
        self._on(system)
        self.now = self.solver.begin(settings.begin, q, v, self._moment(settings.begin))
        self.steps, self.tries = Log(Step), 0
        self.origin, self.least, self.hardest = q, self.measure.least(q), 0.0
        self.farthest = self.least
        self.impulses = LoadImpulses(system, settings.begin, settings.span)
        self.dt = positive("steps.first", called("steps.first", settings.control.first, settings.span / FIRST_STEP), "s")
        self.shortest = self.dt * positive("steps.smallest", settings.control.smallest)
        self.ledger = LedgerRecorder()
        self.logs = logs_of(self.steps, recorder, self.ledger)
        self.ledger.begin(system, self.now)
        recorder.begin(system, self.now)
        recorder.keep(self.now)
        times = [time for time, _ in system.loads.impulses() if settings.begin <= time <= settings.end]
        self.strikes = [time for time in times if time > settings.begin or not struck]
        self.knots = knots_of(system.histories())
        self.since_check = 0
        self.refused = ""
        """The last step that a law had no stress for, in words."""
        self.set_rollback()

    def _on(self, system: System) -> None:
        self.system = system
        self.solver = step_solver(system, self.settings.rule, self.settings.newton_rtol, self.settings.backend)
        self.measure = Measure(system)

    @property
    def parts(self) -> dict[str, HasState]:
        """What remembers something from step to step."""
        settings = self.settings
        parts = {
            "solver": self.solver, "ledger": self.ledger, "recorder": self.recorder, "impulses": self.impulses,
            "terms": self.system.terms, "rule": settings.rule, "steps": settings.control, "follow": settings.follow,
        }  # fmt: skip
        return {name: part for name, part in parts.items() if isinstance(part, HasState)}

    def state(self) -> dict[str, Any]:
        """All that the steps to come depend on, besides what was asked for, and how long the logs are."""
        own = {name: getattr(self, name) for name in OWN} | {"strikes": np.array(self.strikes), "now": self.now.state()}
        own["counts"] = {name: len(log) for name, log in self.logs.items()}
        return own | {name: part.state() for name, part in self.parts.items()}

    def restore(self, state: dict[str, Any]) -> None:
        """Go to where :meth:`state` was given, on the mesh of the last segment; ValueError for vectors of another one."""
        if self.recorder.systems[-1] is not self.system:
            self.solver.close()
            self._on(self.recorder.systems[-1])
        for name in OWN:
            setattr(self, name, state[name])
        self.strikes, self.now = state["strikes"].tolist(), State(**state["now"])
        vectors = (self.origin, *(value for name, value in state["now"].items()
                                  if isinstance(value, np.ndarray) and name != "multipliers"))  # fmt: skip
        if any(vector.size != self.system.n_dofs for vector in vectors):
            raise ValueError(f"vectors of other sizes than {self.system.n_dofs}, that of the mesh")
        for name, log in self.logs.items():
            del log[state["counts"][name] :]
        for name, part in self.parts.items():
            if name in state:
                part.restore(state[name])

    def close(self) -> None:
        self.solver.close()

    def motion(self, status: Status, message: str) -> Motion:
        """What the run left behind; one that reached its end with momenta out of balance has not finished."""
        ledger, settings = self.ledger.as_ledger(), self.settings
        checks: tuple[Check, ...] = ()
        if self.steps:
            size = float(np.abs(self.system.layout.positions(self.now.q)).max())
            checks = checks_of(ledger, mass=self.measure.mass, size=size, missed=self.impulses.part, noise=self._noise,
                               balance=settings.balance, rtol=getattr(settings.control, "rtol", None))  # fmt: skip
        out_of_balance = failures(check for check in checks if MOMENTA in check.name)
        if status.ok and out_of_balance:
            status, message = Status.UNBALANCED, out_of_balance
        recorder = self.recorder
        return Motion(recorder.segments, tuple(self.steps), ledger, recorder.records, status, message, checks=checks)

    def go(
        self, bar: Bar, after_step: Callable[["Run"], None] = lambda run: None,
        at_end: Callable[[], None] = lambda: None,
    ) -> End:  # fmt: skip
        """Run to the end, or until it stops; ``after_step`` follows every accepted step, ``at_end`` the last one."""
        try:
            return run_steps(
                lambda: self._step(bar, after_step, at_end), lambda: f" at t = {self.now.time:.6g} s", self._failed, logger,
            )  # fmt: skip
        finally:
            self.recorder.end(self.now)

    def _failed(self, error: Exception) -> str | None:
        said = f"stopped at t = {self.now.time:.6g} s, what was computed is kept: {_words(error)}"
        return said if self.steps else None

    def _step(self, bar: Bar, after_step: Callable[["Run"], None], at_end: Callable[[], None]) -> End | None:
        settings = self.settings
        tiny = ROUNDED_TIME * settings.span
        while self.strikes and self.strikes[0] <= self.now.time + tiny:
            self._strike(self.strikes.pop(0))
        if self.now.time >= settings.end - tiny:
            self.recorder.end(self.now)
            at_end()
            return Status.FINISHED, ""
        knot = next((time for time in self.knots if time > self.now.time + tiny), settings.end)
        stop = min(knot, settings.end, *self.strikes[:1])
        left = stop - self.now.time
        step = left if self.dt > left - tiny else self.dt
        outcome, accepted = self._attempt(step)
        news = self._news(outcome, step)
        logger.log(logging.INFO if accepted else logging.DEBUG, "%s%s", news, "" if accepted else ": not accepted")
        bar.at(self.now.time - settings.begin, news)
        if self.dt < self.shortest:
            return Status.STEP_TOO_SMALL, self._too_small(outcome)
        if accepted:
            if settings.balance is not None and self._is_unbalanced(settings.balance):
                return Status.UNBALANCED, self._unbalanced()
            self._check_mesh()
            after_step(self)
        return None

    def _attempt(self, step: float) -> tuple[StepOutcome, bool]:
        """One step; whether it was accepted. Sets the length of the next."""
        settings, start, control, measure = self.settings, self.now, self.settings.control, self.measure
        outcome = self.solver.step(start, step)
        if not outcome.ok and (said := self.system.assembly.refusal()):
            self.refused = f"; a step to t = {start.time + step:.6g} s failed because {said}"
        error = imbalance = np.inf
        farthest, over, accepted = self.farthest, 0.0, False
        missed: tuple[Missed, ...] = ()
        if outcome.ok:
            error = measure.error(self.solver, start, outcome.end, settings.span)
        if np.isfinite(error):
            sums, n_rows, before, known = self.ledger.state(), len(self.ledger.rows), self.ledger.left, self.ledger.turnover
            self.ledger.step(self.system, settings.rule, start, outcome.u, outcome.end,
                           lambda: self.solver.residual(outcome.u, start, step, outcome.end.multipliers))  # fmt: skip
            imbalance = (self.ledger.left - before) / max(self.ledger.turnover, self._noise)
            done = (outcome.end.time - settings.begin) / settings.span
            farthest = max(farthest, measure.size(outcome.end.q - self.origin))
            missed = self.impulses.step(start.time, step)
            attempt = Attempt(
                step, settings.span, error if farthest > self.least else 0.0, outcome.iterations, farthest,
                farthest - self.farthest, measure.rounding,
                begins=farthest > SUDDEN * self.farthest and 2 * measure.size(start.a) < measure.size(outcome.end.a),
                impulses=missed, hardest=self.hardest, imbalance=imbalance, young=self.ledger.turnover > 2 * known,
                total=self.ledger.imbalance / done,
            )  # fmt: skip
            accepted = flag("steps.accepts", called("steps.accepts", control.accepts, attempt))
            over = getattr(control, "over", _unmeasured)(attempt)
            # A step cut to end at a given time says nothing against the length that was meant.
            cut = step < self.dt and accepted
            following = positive("steps.next_step", called("steps.next_step", control.next_step, attempt), "s")
            if not accepted and not following < step:
                raise InputError(f"steps.next_step = {following} s after a step of {step} s that was not accepted; a step "
                                 "that is tried again must be shorter")  # fmt: skip
            self.dt = max(self.dt, following) if cut else following
            if not accepted:
                self.ledger.restore(sums)
                del self.ledger.rows[n_rows:]
        else:
            self.dt = step / 2
        self.steps.append(Step(start.time + step, step, error / max(farthest, ABOVE_ZERO), outcome.iterations,
                               outcome.factorisations, accepted, imbalance, self.system.n_dofs))  # fmt: skip
        if accepted:
            self.recorder.step(start, outcome.end)
            self.now, self.farthest, self.hardest = outcome.end, farthest, max(over, FADING * self.hardest)
            self.solver.reached(self.now)
            self.system.terms.reached(self.now.q, self.now.v, Case(time=self.now.time))
            self.impulses.add(missed)
            self.recorder.keep(self.now)
        return outcome, accepted

    @property
    def _noise(self) -> float:
        """Energy that is rounding (J): of coordinates alone, and of their product with a strain in the energy."""
        rounding = NOISE * self.solver.factors.rounding
        return max(rounding, ABOVE_ZERO) + (rounding * self.ledger.turnover) ** 0.5

    def _is_unbalanced(self, tolerance: float) -> bool:
        """The first steps of a load that jumps cannot be balanced; nor can rounding."""
        return abs(self.ledger.left) > tolerance * self.ledger.turnover + self._noise and len(self.steps) > FIRST

    def _moment(self, time: float) -> float:
        """Over twice this (s) prescribed motions are differenced, after a time of the run; before its end."""
        moment = SHORT * self.settings.span
        return -moment if time + 2 * moment > self.settings.end else moment

    def _strike(self, time: float) -> None:
        """Velocities jump by the impulse of a time, on the present mesh."""
        system, start = self.system, self.now
        self.recorder.end(start)
        moment = self._moment(start.time)
        jump = self.solver.jump(start, dict(system.loads.impulses())[time], moment)
        self.now = self.solver.begin(start.time, start.q, start.v + jump, moment)
        self.ledger.jump(system, start, self.now)
        self.recorder.begin(system, self.now)
        self.set_rollback()

    def _check_mesh(self) -> None:
        """Ask the policy of meshes, at regular intervals of accepted steps."""
        follow = self.settings.follow
        if follow is None:
            return
        self.since_check += 1
        if self.since_check < follow.every or self.now.time >= self.settings.end * (1 - ROUNDED_TIME):
            return
        most, again, energy = self.ledger.most_strain, self.tries < TRIES, self.solver.energy
        new = follow.change(self.system, self.rollback, self.now, self.settings.end, most, again)
        tries = 0
        if new is not None:
            logger.info("t = %.4g s: from %d to %d elements%s", new.event.time, new.event.before, new.event.after,
                        ", and again from there" * new.event.again)  # fmt: skip
            if new.event.again:
                tries = self.tries + 1
                self._roll_back()
            self.recorder.end(self.now)
            undeformed = np.array_equal(self.origin, self.system.undeformed)
            self.solver.close()
            self._on(new.system)
            self.solver.energy = energy
            self.now = self.solver.taken(new.state, self._moment(new.state.time))
            # Displacements since the start are not known on another mesh, unless it began undeformed.
            self.origin = new.system.undeformed if undeformed else new.state.q
            self.ledger.remeshed(new.event, new.system, self.now)
            self.recorder.begin(new.system, self.now)
        self.set_rollback(tries)

    def set_rollback(self, tries: int = 0) -> None:
        """Where the run may go back to, from the next check of the mesh; ``tries`` counts how often it did."""
        self.since_check, self.tries = 0, tries
        self.rollback, self.saved = self.now, flat(self.state())

    def _roll_back(self) -> None:
        """Back to the last rollback, but for the policy, which has just decided it; steps since then count as rejected."""
        back = nested(self.saved, self.state())
        back.pop("follow", None)
        since = [replace(step, accepted=False) for step in self.steps[back["counts"]["steps"] :]]
        self.restore(back)
        self.steps += since

    def _news(self, outcome: StepOutcome, step: float) -> str:
        elements = f", {self.system.geometry.n_elements} elements" if self.settings.follow else ""
        return f"t = {self.now.time:.4g} s, step {step:.2g} s, {outcome.iterations} iterations{elements}"

    def _too_small(self, outcome: StepOutcome) -> str:
        last = self.steps[-1]
        found = f"local error {last.error:.1e}, energy without a source {last.imbalance:.1e} of the largest"
        reason = outcome.message if not outcome.ok else found + self.refused
        return (
            f"the run stopped at t = {self.now.time:.6g} s: its step fell to {self.dt:.1e} s ({reason}); "
            "what was computed is kept. Look for a mechanism, an element that folds, or a load that jumps."
        )

    def _unbalanced(self) -> str:
        ledger, rule = self.ledger, type(self.settings.rule).__name__
        way = "gained" if ledger.imbalance > 0 else "lost"
        return (
            f"the run stopped at t = {self.now.time:.6g} s: the integration has {way} {abs(ledger.imbalance):.1%} of the "
            f"largest energy, {ledger.turnover:.4g} J; the tolerance is {self.settings.balance:.1%}. What was computed is "
            f"kept. Take shorter steps (a smaller rtol or dt) than {rule} had here, or rule=EnergyMomentum(), which keeps "
            "energy; balance=None does not look"
        )


def logs_of(steps: Log, recorder: Recorder, ledger: LedgerRecorder) -> dict[str, Log]:
    """What only grows in a run."""
    return {"steps": steps, **recorder.logs, **ledger.logs}


def _words(error: Exception) -> str:
    """What went wrong, with the kind of error where its text does not say what it is about."""
    if isinstance(error, SkancfError):
        return str(error)
    return reason(error) if isinstance(error, OSError) else repr(error)


def _unmeasured(attempt: Attempt) -> float:
    """What controls without an asked error say of a step."""
    return 0.0


FIRST_STEP = 50
"""Part of the run that is tried at first; what is too long is rejected, and costs little."""
SUDDEN = 4
"""Where the displacement grows by more than this factor in a step, and the acceleration doubles, the motion only begins."""
TRIES = 2
"""How often a run goes back to the same check."""
NOISE = 1e3
"""Times the energy of rounding of the coordinates: what many steps of it come to."""
FIRST = 10
"""Steps before the balance is judged: the first one of a load that jumps cannot be balanced."""
SHORT = 1e-4
"""Of the run, for the second difference of a prescribed motion: rounding, 1e-16 over its square, is below it."""
