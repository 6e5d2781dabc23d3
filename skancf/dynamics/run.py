"""The loop in time: integrator, step control, meshes and output are objects beside it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from skancf.arguments import flag
from skancf.assembly.system import System
from skancf.atomic import reason
from skancf.dynamics.ledger import Book, MeshEvent
from skancf.dynamics.motion import MotionStatus, Step
from skancf.dynamics.prescribed import prescribed_acceleration
from skancf.dynamics.recorder import Recorder
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.dynamics.step_solver import StepOutcome, StepSolver
from skancf.dynamics.steps import Attempt, StepControl
from skancf.errors import InputError, SkancfError, positive
from skancf.functions import called
from skancf.progress import Progress


@dataclass(frozen=True)
class NewMesh:
    """A change of the mesh: the system to go on with, the state there, and what that changed.

    The time of the state is the present one, or that of the last look, to which the run then goes back; ``raised`` is the
    energy that it gained (J).
    """

    system: System
    state: State
    event: MeshEvent
    raised: float = 0.0


class MeshPolicy(Protocol):
    """Decides on meshes, every so many steps, and carries states over."""

    @property
    def every(self) -> int:
        """Accepted steps from look to look."""

    def check(self, system: System) -> None:
        """InputError for a system whose mesh cannot follow."""

    def change(
        self, system: System, before: State, now: State, end: float, energy: float, again: bool
    ) -> NewMesh | None:
        """A change of the mesh, from the states at the last look and now; None to go on with this one.

        ``end`` is that of the run (s), ``energy`` the largest strain energy so far, ``again`` whether the run may go back
        to the last look.
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


@dataclass(frozen=True)
class Mark:
    """Where a run can go back to."""

    tries: int
    state: State
    dt: float
    largest: float
    n_steps: int
    book: Any
    recorder: Any


class Run:
    """State of one run; everything it keeps is usable whenever it stops.

    ``struck``: the first state is the one after what happened at its time.
    """

    def __init__(
        self, system: System, settings: Settings, recorder: Recorder, q: np.ndarray, v: np.ndarray, struck: bool = False
    ):  # fmt: skip
        self.settings, self.recorder = settings, recorder
        self._on(system)
        a = self.solver.initial_acceleration(q, v, settings.begin, self._driven(settings.begin))
        self.state = State(settings.begin, q, v, a)
        self.steps: list[Step] = []
        thickness = system.problem.section.thickness
        self.largest = thickness
        guess = np.sqrt(2e-3 * thickness / max(self.size(a), 1e-300))
        first = called("steps.first", settings.control.first, min(float(guess), settings.span / 20))
        self.dt = positive("steps.first", first, "s")
        self.shortest = self.dt * positive("steps.smallest", settings.control.smallest)
        self.book = Book(system, self.state)
        recorder.begin(system, self.state)
        recorder.keep(self.state)
        times = [time for time, _ in system.impulses() if settings.begin <= time <= settings.end]
        self.impulses = [time for time in times if time > settings.begin or not struck]
        self.knots = system.knots()
        self.looked = 0
        self.mark_here()

    def _on(self, system: System) -> None:
        self.system = system
        self.solver = StepSolver(system, self.settings.rule, self.settings.newton_rtol, self.settings.backend)
        mass = np.abs(system.shares[:, 0])
        self.weights = mass / mass.sum()

    def close(self) -> None:
        self.solver.close()

    def size(self, u: np.ndarray) -> float:
        """Mass-weighted root mean square of positions."""
        r = u.reshape(-1, 4, 3)[:, 0]
        with np.errstate(over="ignore"):
            return float(np.sqrt(self.weights @ (r * r).sum(axis=1)))

    def go(
        self, bar: Progress, after_step: Callable[["Run"], None] = lambda run: None,
        at_end: Callable[[], None] = lambda: None,
    ) -> tuple[MotionStatus, str]:  # fmt: skip
        """Run to the end, or until it stops; ``after_step`` follows every accepted step, ``at_end`` the last one."""
        try:
            status, message = self._go(bar, after_step)
            if status is MotionStatus.FINISHED:
                self.recorder.end(self.state)
                at_end()
            return status, message
        except KeyboardInterrupt:
            return MotionStatus.INTERRUPTED, f"interrupted from the keyboard at t = {self.state.time:.6g} s"
        except Exception as error:  # whatever a load, a record, a disk or the machine raises, what was computed is kept
            if not self.steps:
                raise
            return MotionStatus.FAILED, f"stopped at t = {self.state.time:.6g} s, what was computed is kept: {_words(error)}"
        finally:
            self.recorder.end(self.state)

    def _go(self, bar: Progress, after_step: Callable[["Run"], None]) -> tuple[MotionStatus, str]:
        settings = self.settings
        tiny = 1e-12 * settings.span
        while True:
            while self.impulses and self.impulses[0] <= self.state.time + tiny:
                self._strike(self.impulses.pop(0))
            if self.state.time >= settings.end - tiny:
                return MotionStatus.FINISHED, ""
            knot = next((time for time in self.knots if time > self.state.time + tiny), settings.end)
            stop = min(knot, settings.end, *self.impulses[:1])
            left = stop - self.state.time
            step = left if self.dt > left - tiny else self.dt
            outcome, accepted = self._attempt(step)
            bar.at(self.state.time - settings.begin, self._news(outcome, step))
            if self.dt < self.shortest:
                return MotionStatus.STEP_TOO_SMALL, self._too_small(outcome)
            if not accepted:
                continue
            if settings.balance is not None and self._is_unbalanced(settings.balance):
                return MotionStatus.UNBALANCED, self._unbalanced()
            self._look()
            after_step(self)

    def _attempt(self, step: float) -> tuple[StepOutcome, bool]:
        """One step; whether it was accepted. Sets the length of the next."""
        settings, start, control = self.settings, self.state, self.settings.control
        outcome = self.solver.step(start, step)
        error = imbalance = np.inf
        accepted = False
        if outcome.converged:
            error = self._error(start, outcome.end)
        if np.isfinite(error):
            mark, before, known = self.book.mark(), self.book.left, self.book.turnover
            self.book.step(self.system, settings.rule, start, outcome.u, outcome.end,
                           lambda: self.solver.residual(outcome.u, start, step))  # fmt: skip
            imbalance = (self.book.left - before) / max(self.book.turnover, self._noise)
            young = self.book.turnover > 2 * known
            done = (outcome.end.time - settings.begin) / settings.span
            attempt = Attempt(step, settings.span, error, outcome.iterations, imbalance, young, self.book.imbalance / done)
            accepted = flag("steps.accepts", called("steps.accepts", control.accepts, attempt))
            # A step cut to end at a given time says nothing against the length that was meant.
            cut = step < self.dt and accepted
            following = positive("steps.next_step", called("steps.next_step", control.next_step, attempt), "s")
            if not accepted and not following < step:
                raise InputError(f"steps.next_step = {following} s after a step of {step} s that was not accepted; a step "
                                 "that is tried again must be shorter")  # fmt: skip
            self.dt = max(self.dt, following) if cut else following
            if not accepted:
                self.book.rewind(mark)
        else:
            self.dt = step / 2
        self.steps.append(Step(start.time + step, step, error, outcome.iterations, outcome.factorisations, accepted,
                               imbalance, self.system.n_dofs))  # fmt: skip
        if accepted:
            self.recorder.step(start, outcome.end)
            self.state = outcome.end
            self.solver.reached(self.state)
            self.largest = max(self.largest, self.thickness + self.size(self.state.q - self.system.undeformed))
            self.recorder.keep(self.state)
        return outcome, accepted

    def _error(self, start: State, end: State) -> float:
        """Error of a step, relative.

        The errors of vibrations that it hardly resolves do not add up: what is wrong of them is twice their amplitude at
        most, whatever the number of steps, so that each has its share of that.
        """
        rule = self.settings.rule
        error = rule.error(start, end)
        slow = self.solver.resolved(error, end.dt)
        amplitude = self.size(error - slow) / abs(rule.error_constant)
        return (self.size(slow) + 2 * amplitude * end.dt / self.settings.span) / self.largest

    @property
    def _noise(self) -> float:
        """Energy that is rounding (J)."""
        return max(NOISE * self.solver.rounding, 1e-300)

    def _is_unbalanced(self, tolerance: float) -> bool:
        """The first steps of a load that jumps cannot be balanced; nor can rounding."""
        return abs(self.book.left) > tolerance * max(self.book.turnover, self._noise) and len(self.steps) > FIRST

    @property
    def thickness(self) -> float:
        return float(self.system.problem.section.thickness)

    def _driven(self, time: float) -> np.ndarray:
        """Accelerations of prescribed coordinates, (n_dofs,), after a time of the run; before its end."""
        moment = SHORT * self.settings.span
        if time + 2 * moment > self.settings.end:
            moment = -moment
        return prescribed_acceleration(self.system, time, moment)

    def _strike(self, time: float) -> None:
        """Velocities jump by the impulse of a time, on the present mesh."""
        system, start = self.system, self.state
        self.recorder.end(start)
        jump = self.solver.jump(dict(system.impulses())[time])
        a = self.solver.initial_acceleration(start.q, start.v + jump, start.time, self._driven(start.time))
        self.state = State(start.time, start.q, start.v + jump, a)
        self.book.jump(system, start, self.state)
        self.recorder.begin(system, self.state)
        self.mark_here()

    def _look(self) -> None:
        """Ask the policy of meshes, every so many accepted steps."""
        follow = self.settings.follow
        if follow is None:
            return
        self.looked += 1
        if self.looked < follow.every or self.state.time >= self.settings.end * (1 - 1e-12):
            return
        most, again = self.book.most_strain, self.mark.tries < TRIES
        new = follow.change(self.system, self.mark.state, self.state, self.settings.end, most, again)
        tries = 0
        if new is not None:
            if new.event.again:
                tries = self.mark.tries + 1
                self._rewind()
            self.recorder.end(self.state)
            energy = self.solver.energy
            self.solver.close()
            self._on(new.system)
            self.solver.energy = energy
            self.state = new.state
            self.book.remeshed(new.event, new.system, self.state)
            self.recorder.begin(new.system, self.state)
        self.mark_here(tries)

    def mark_here(self, tries: int = 0) -> None:
        """Where the run may go back to, from the next look at the mesh; ``tries`` counts how often it did."""
        self.looked = 0
        self.mark = Mark(tries, self.state, self.dt, self.largest, len(self.steps), self.book.mark(), self.recorder.mark())

    def _rewind(self) -> None:
        """Back to the last mark; the steps since then count as rejected."""
        mark = self.mark
        self.state, self.dt, self.largest = mark.state, mark.dt, mark.largest
        self.steps[mark.n_steps :] = [replace(step, accepted=False) for step in self.steps[mark.n_steps :]]
        self.book.rewind(mark.book)
        self.recorder.rewind(mark.recorder)

    def _news(self, outcome: StepOutcome, step: float) -> str:
        elements = f", {self.system.geometry.n_elements} elements" if self.settings.follow else ""
        return f"t = {self.state.time:.4g} s, step {step:.2g} s, {outcome.iterations} iterations{elements}"

    def _too_small(self, outcome: StepOutcome) -> str:
        last = self.steps[-1]
        found = f"local error {last.error:.1e}, energy without a source {last.imbalance:.1e} of the largest"
        reason = outcome.message if not outcome.converged else found
        return (
            f"the run stopped at t = {self.state.time:.6g} s: its step fell to {self.dt:.1e} s ({reason}); "
            "what was computed is kept. Look for a mechanism, an element that folds, or a load that jumps."
        )

    def _unbalanced(self) -> str:
        book, rule = self.book, type(self.settings.rule).__name__
        way = "gained" if book.imbalance > 0 else "lost"
        return (
            f"the run stopped at t = {self.state.time:.6g} s: the integration has {way} {abs(book.imbalance):.1%} of the "
            f"largest energy, {book.turnover:.4g} J; the tolerance is {self.settings.balance:.1%}. What was computed is "
            f"kept. Take shorter steps (a smaller rtol or dt) than {rule} had here, or rule=EnergyMomentum(), which keeps "
            "energy; balance=None does not look"
        )


def _words(error: Exception) -> str:
    """What went wrong, with the kind of error where its text does not say what it is about."""
    if isinstance(error, SkancfError):
        return str(error)
    return reason(error) if isinstance(error, OSError) else repr(error)


TRIES = 2
"""How often a run goes back to the same look."""
NOISE = 1e3
"""Times the energy of rounding of the coordinates: what many steps of it come to."""
FIRST = 10
"""Steps before the balance is judged: the first one of a load that jumps cannot be balanced."""
SHORT = 1e-4
"""Of the run, for the second difference of a prescribed motion: rounding, 1e-16 over its square, is below it."""
