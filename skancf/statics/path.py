"""The equilibrium path, with the load factor as an unknown: through limit points, snap-through and snap-back."""

import logging

import numpy as np

from skancf.checks import Check, failures
from skancf.errors import InputError, SingularMatrix, SkancfError, shown
from skancf.history import Case
from skancf.linear import DirectSolver
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.solution import Solution
from skancf.solving import End, Status, run_steps
from skancf.states import StateLike
from skancf.statics.arguments import check_arguments
from skancf.statics.conditioned import at_rest, is_loaded
from skancf.statics.contradictions import contradiction_ahead
from skancf.statics.controls import ArcLength, DisplacementControl, DisplacementReached, end_of_path
from skancf.statics.critical import turning_estimate
from skancf.statics.diagnosis import NEAR, require_support
from skancf.statics.events import LIMIT, Event, events_between
from skancf.statics.newton import NewtonResult, largest_turn
from skancf.statics.path_result import PathResult
from skancf.statics.points import Follower, Point
from skancf.statics.validity import warn_without_time
from skancf.statics.verify import Balance, checks_of
from skancf.system.system import System
from skancf.tolerances import ONE_PLACE, ROUNDED_COORDINATE

FIRST_TURN = 0.5
"""Largest change of a slope in the first step by arc length, relative to the slope's length."""
LOOK_BACK = 12
"""Attempts among which a law that had no stress is named when the smallest step failed for another reason, and points that
went as far as a contradiction of conditions is looked for ahead."""
UNMOVED = (
    "the load strains the structure and does not move it, as heat does to what is held all round, so there is no way to "
    "follow: solve(system) finds the state under the load, also one that buckled"
)
CROSSED = (
    "the asked end lies between load factors {:.6g} and {:.6g}, but even in the smallest step its equilibrium was not "
    "found; allow a smaller step (StepLength) or more iterations"
)

logger = logging.getLogger(__name__)


def trace(
    system: System,
    control: ArcLength | DisplacementControl | None = None,
    *,
    until: float | DisplacementReached | None = None,
    steps: int = 200,
    start: StateLike | None = None,
    rtol: float = 1e-7,
    max_iterations: int = 15,
    mixed: bool = True,
    backend: str = "auto",
    progress: ShowProgress = True,
) -> PathResult:
    r"""Equilibrium path from the undeformed state or from ``start``.

    Each step solves :math:`R(q, \lambda) = 0` together with one linear equation that the control gives, by two solves with
    one factor. The first tangent of a step has the stresses of the last equilibrium, extrapolated along the path (Magisano,
    Leonetti and Garcea, 2017), which lets thin structures take long steps.

    Parameters
    ----------
    control
        :class:`ArcLength` (default) or :class:`DisplacementControl`.
    until : float or DisplacementReached, optional
        The path ends where it reaches this load factor, or a displacement.
    steps : int
        Or after this number of steps.
    rtol, max_iterations, mixed, backend, progress
        As for :func:`solve`.

    Returns
    -------
    PathResult
        Also when it fails or is interrupted: then what was computed, and why it stopped.

    Raises
    ------
    InputError
        When a rigid motion is free, nothing loads the structure, or the controlled displacement does not move with the load.

    Examples
    --------
    >>> quarter = sk.CylinderSector(radius=2540.0, length=254.0, angle=0.1, start=np.pi / 2 - 0.1)
    >>> crown = (254.0, np.pi / 2)
    >>> roof = sk.Problem(
    ...     quarter, 12.7, sk.Isotropic(young=3102.75, poisson=0.3, density=1.2e-9),
    ...     supports=[sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
    ...     loads=[sk.PointForce(crown, (0.0, 0.0, -750.0))],
    ... )
    >>> system = roof.on(sk.meshes.uniform(quarter, 4, 4), "kirchhoff")
    >>> path = sk.trace(system, sk.ArcLength(first=0.1), until=1.0, progress=False)
    >>> print([(event.kind, round(event.load_factor, 2)) for event in path.events])
    [('limit point', 0.74), ('limit point', 0.17)]
    """
    counts = {"max_iterations": max_iterations, "steps": steps}
    start = check_arguments(system, backend, start=start, rtol=rtol, counts=counts, mixed=mixed)
    check_progress(progress)
    require_support(system)
    warn_without_time(system)
    return traced(
        system, control, until=until, steps=steps, start=start, rtol=rtol, max_iterations=max_iterations, mixed=mixed,
        backend=backend, progress=progress,
    )  # fmt: skip


def traced(
    system: System, control: ArcLength | DisplacementControl | None = None, *,
    until: float | DisplacementReached | None = None, steps: int = 200, start: Solution | None = None, rtol: float = 1e-7,
    max_iterations: int = 15, mixed: bool = True, backend: str = "auto", progress: ShowProgress = False,
) -> PathResult:  # fmt: skip
    """:func:`trace` for a system that is known to be supported, and arguments that are checked."""
    at = start or at_rest(system)
    control = ArcLength() if control is None else control
    if not isinstance(control, ArcLength | DisplacementControl):
        raise InputError(f"control = {shown(control)}: give an ArcLength or a DisplacementControl")
    if not is_loaded(system, at.q, at.load_factor):
        raise InputError("no path: nothing loads the structure; give a load or a prescribed displacement")
    most = steps if until is None else None
    with DirectSolver(system.pattern, system.constraints, backend) as solver, Bar("path", most, progress) as bar:
        follower = Follower(system, solver, float(rtol), int(max_iterations), mixed)
        return _Run(system, control, follower, until, int(steps), bar).go(at)


class _Run:
    """State of one run; everything it keeps is usable whenever it stops."""

    def __init__(
        self, system: System, control: ArcLength | DisplacementControl, follower: Follower,
        until: float | DisplacementReached | None, steps: int, bar: Bar,
    ) -> None:  # fmt: skip
        self.system, self.control, self.follower = system, control, follower
        self.end = None if until is None else end_of_path(system, until, system.undeformed)
        self.steps, self.bar = steps, bar
        self.points: list[Point] = []
        self.events: list[Event] = []
        self.first, self.length = 0.0, 1.0

    def go(self, start: Solution) -> PathResult:
        status, message = run_steps(
            lambda: self._step() if self.points else self._begin(start), lambda: "", self._failed, logger
        )
        points = self.points or [Point(start.q, start.load_factor, 0, np.zeros_like(start.q), 0.0, start.multipliers)]
        checks = self._checks(points)
        if status.ok and (failed := failures(checks)):
            status, message = Status.UNBALANCED, failed
        if not status.ok:
            reached = f"load factor {points[-1].load_factor:.6g} after {len(points) - 1} steps"
            message = f"the path stopped at {reached}: {message}"
        return PathResult(
            tuple(Solution(self.system, p.q, load_factor=p.load_factor, multipliers=p.multipliers) for p in points),
            np.array([point.pivots for point in points]), tuple(self.events), status, tuple(self.follower.attempts), message,
            checks,
        )  # fmt: skip

    def _checks(self, points: list[Point]) -> tuple[Check, ...]:
        """Of the last point; by the balance of the whole body alone, since its tangent may be singular there."""
        last = points[-1]
        if len(points) < 2 or not hasattr(self.system, "strain_energy"):
            return ()
        sizes = np.abs(self.system.tangent(last.q, Case(last.load_factor)).diagonal())
        balance = Balance.of_state(self.system, last.q, last.load_factor, points[0].q, last.multipliers)
        return checks_of(balance.measured(sizes))

    def _failed(self, error: Exception) -> str | None:
        wrong_input = isinstance(error, InputError) or len(self.points) < 2
        return None if wrong_input else f"what was computed is kept: {error!r}"

    def _begin(self, start: Solution) -> End | None:
        """The first point, and the length of the first step."""
        self.follower.measure = measure = self.control.on(self.system, start.q)
        try:
            point = self.follower.first_point(start.q, start.load_factor, start.multipliers)
        except SingularMatrix as singular:
            return Status.MECHANISM, f"the state at the start has no stiffness against some motion: {singular}"
        self.points.append(point)
        along = point.direction / (point.rate or 1.0)
        self.first = self.control.first_length(measure, along, point.q)
        if not (np.isfinite(self.first) and self.first):
            return Status.NOT_FINITE, f"the load moves the structure by {self.first} at the start; look at its size"
        if isinstance(self.control, ArcLength):
            if not _moves(self.system, along):
                return Status.STEP_TOO_SMALL, UNMOVED
            # A held film is a thousand times stiffer once it has moved a little than the tangent at the start says.
            self.first /= max(1.0, largest_turn(self.system, self.first * point.direction) / FIRST_TURN)
        return None

    def _step(self) -> End | None:
        """One step, or a shorter one to be tried next; ``length`` is that of the next, in units of the first."""
        follower, lengths, point, first = self.follower, self.control.steps, self.points[-1], self.first
        if len(self.points) > self.steps:
            return self._out_of_steps(point)
        length = min(self.length * first, follower.measure.left(point.q))
        result, following, sharp = follower.step(point, length)
        if following is None:
            self.length = length / first / lengths.cut
            return self._stuck(result, sharp, length) if self.length < lengths.smallest else None
        events: list[Event] = []
        share = self._crossing(point, following)
        if share is None:
            events = events_between(follower, point, following, length)
            share = self._crossing_before_limit(point, events, length)
            if share is None and (said := self._turned_by_conditions(point, following, events)):
                return Status.CONTRADICTORY, said
        if share is not None and self.end is not None:
            found = follower.at_condition(point, following, self.end, share)
            if found is None:
                self.length = length / first / lengths.cut
                crossed = CROSSED.format(point.load_factor, following.load_factor)
                return (Status.NOT_REACHED, crossed) if self.length < lengths.smallest else None
            following, length = found
            events = events_between(follower, point, following, length)
        self.events += events
        self.points.append(following)
        left, iterations = follower.measure.left(following.q), len(result.residual_norms)
        logger.info("step %d: load factor %.6g, %d iterations, %d negative pivots",
                    len(self.points) - 1, following.load_factor, iterations, following.pivots)  # fmt: skip
        for event in events:
            logger.info("%s at load factor %.6g", event.kind, event.load_factor)
        self.bar.at(len(self.points) - 1, f"load factor {following.load_factor:.4g}, {iterations} iterations")
        if share is not None or left <= ONE_PLACE * first:
            return Status.CONVERGED, ""
        self.length = lengths.after(length / first if np.isinf(left) else self.length, iterations)
        return None

    def _out_of_steps(self, last: Point) -> End:
        if self.end is not None or np.isfinite(self.follower.measure.left(last.q)):
            return Status.NOT_REACHED, "these were all the steps; ask for more, or go on from there with start=solution"
        return Status.CONVERGED, ""

    def _beyond(self, q: np.ndarray, load_factor: float) -> float:
        """What changes its sign where the path ends."""
        assert self.end is not None
        return float(self.end.row @ q) + self.end.factor * load_factor - self.end.value

    def _crossing(self, a: Point, b: Point) -> float | None:
        """Where the path ends between two points, as a share of the step, by a straight line; None where it does not."""
        if self.end is None:
            return None
        before, after = (self._beyond(p.q, p.load_factor) for p in (a, b))
        return before / (before - after) if before and before * after <= 0 else None

    def _crossing_before_limit(self, a: Point, events: list[Event], length: float) -> float | None:
        """The same for a step that goes beyond the end and back, by a parabola through the limit point in it."""
        limit = next((event for event in events if event.kind == LIMIT), None)
        if self.end is None or limit is None:
            return None
        before, most = self._beyond(a.q, a.load_factor), self._beyond(limit.solution.q, limit.load_factor)
        if before * most >= 0:
            return None
        way = float(self.follower.measure.row(a.direction) @ (limit.solution.q - a.q))
        return way / length * (1 - np.sqrt(most / (most - before)))

    def _turned_by_conditions(self, a: Point, b: Point, events: list[Event]) -> str | None:
        """Why a path does not go on beyond a limit point in a step, where beyond it no state meets the conditions."""
        limit = next((event.load_factor for event in events if event.kind == LIMIT), None)
        if limit is None:
            return None
        way = max(abs(limit - a.load_factor), abs(limit - b.load_factor))
        return contradiction_ahead(self.system, a.q, a.load_factor, limit + np.sign(a.rate) * way)

    def _stuck(self, result: NewtonResult, sharp: bool, length: float) -> End:
        before, last = self.points[-LOOK_BACK:][0], self.points[-1]
        way = max(abs(last.load_factor - before.load_factor), NEAR * abs(length * last.rate))
        to = last.load_factor + np.sign(last.rate) * way
        if said := contradiction_ahead(self.system, last.q, last.load_factor, to):
            return Status.CONTRADICTORY, said
        if isinstance(self.control, DisplacementControl) and (sharp or self._turning(length)):
            return Status.TURNED_BACK, (
                "the controlled displacement has its turning point here; follow the path by ArcLength()"
            )
        if not sharp:
            tail = ", ".join(f"{r:.1e}" for r in result.residual_norms[-3:])
            said = f", {result.message}" if result.message else self._refused()
            return Status.STEP_TOO_SMALL, (
                f"the smallest step failed, {result.status.value}{said}; last residuals {tail or 'none'}. Allow "
                "a smaller step (StepLength), or look for a mechanism or a folded element"
            )
        return Status.TURNED_BACK, (
            "even the smallest step leaves the path in another direction than it came; start from a point before it with a "
            "smaller first step, or add a small disturbing load where branches cross"
        )

    def _refused(self) -> str:
        """What a longer one of the last steps met, where it met what is no number."""
        last = self.follower.attempts[-LOOK_BACK:]
        met = [each.message for each in last if each.status is Status.NOT_FINITE and each.message]
        return f", and a longer one, {Status.NOT_FINITE.value}, {met[-1]}" if met else ""

    def _turning(self, length: float) -> bool:
        """Does the controlled displacement turn back about a step ahead, by its rate along the path?"""
        if len(self.points) < 2:
            return False
        before, last = self.points[-2:]
        rates = 1.0 / self.follower.size(before.direction), 1.0 / self.follower.size(last.direction)
        way = self.follower.distance(before, last)
        return turning_estimate((0.0, way), rates) - way <= NEAR * length


def _moves(system: System, along: np.ndarray) -> bool:
    """Does a unit of the load move the body by more than rounding of its coordinates?"""
    mass, at = system.mass, system.undeformed
    return bool(along @ (mass @ along) > ROUNDED_COORDINATE**2 * (at @ (mass @ at)))


def limit_ahead(system: System, start: Solution, first: float, steps: int = 6) -> float | None:
    """Load factor of a limit point that a few steps along the path from a state find, or None.

    ``first`` is the first step as a load factor, with its sign.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            found = trace(system, ArcLength(first=first), start=start, steps=steps, progress=False)
    except SkancfError:
        return None
    return next((event.load_factor for event in found.events if event.kind == LIMIT), None)
