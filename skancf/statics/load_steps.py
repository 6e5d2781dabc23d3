"""Statics under growing load: steps that are halved where Newton's method fails and grow where it is easy."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import whole
from skancf.assembly.system import System
from skancf.errors import DidNotConverge, InputError, number, positive, shown
from skancf.linear import DirectSolver
from skancf.progress import Progress
from skancf.solution import Solution, require_same_mesh
from skancf.statics.asked import check_asked
from skancf.statics.causes import cause, require_support
from skancf.statics.controls import ArcLength
from skancf.statics.depth import warn_if_thick
from skancf.statics.newton import NewtonResult, Status, newton
from skancf.statics.path import limit_ahead, trace
from skancf.statics.tangents import SYMMETRIC_ONLY, is_skew

UNSTABLE = (
    "the equilibrium is not stable: its tangent has {} negative eigenvalue(s), and the first one came between load factor "
    "{:.4g} and {:.4g}. The structure would buckle there; a small disturbing load shows the way, and trace(system, "
    "ArcLength()) the place"
)


@dataclass(frozen=True)
class HalveAndGrow:
    """Step control: a failed step is divided by ``cut``; an easy one, at most ``easy`` iterations, is followed by a
    ``growth`` times longer one."""

    first: float = 1.0
    smallest: float = 1e-4
    cut: float = 2.0
    growth: float = 2.0
    easy: int = 5

    def __post_init__(self) -> None:
        whole("easy", self.easy, floats=True)
        for name in ("first", "smallest", "cut", "growth"):
            positive(name, getattr(self, name))
        if not self.cut > 1:
            raise InputError(f"cut = {self.cut}: a failed step must become shorter, give a number greater than one")
        if not self.growth >= 1:
            raise InputError(f"growth = {self.growth}: an easy step must not become shorter, give at least one")

    def next_step(self, step: float, result: NewtonResult) -> float:
        if not result.converged:
            return step / self.cut
        return step * self.growth if len(result.residual_norms) <= self.easy else step


@dataclass(frozen=True)
class StaticResult:
    """Outcome of :func:`solve`.

    Attributes
    ----------
    solution : Solution
        The last equilibrium found; the asked one if ``status`` is converged.
    status : Status
    path : tuple of Solution
        Every equilibrium on the way.
    attempts : tuple of (load factor, NewtonResult)
        Every solve, failed ones too, with its residual history. The few short steps along the path by which the cause of
        a failure is looked for are not among them.
    message : str
        Why it stopped, if it did; or that the equilibrium is not stable, by ``negative_pivots``.
    """

    solution: Solution
    status: Status
    path: tuple[Solution, ...]
    attempts: tuple[tuple[float, NewtonResult], ...]
    message: str = ""

    @property
    def iterations(self) -> int:
        """Newton iterations of all attempts."""
        return sum(len(result.residual_norms) for _, result in self.attempts)

    @property
    def negative_pivots(self) -> int:
        """Negative eigenvalues of the tangent in the last solve; a stable equilibrium has none.

        Of its symmetric part, where loads follow a free edge: then an equilibrium that has none may still flutter.
        """
        return self.attempts[-1][1].negative_pivots if self.attempts else 0

    def unwrap(self) -> Solution:
        """The solution, or :class:`~skancf.DidNotConverge`."""
        if self.status is not Status.CONVERGED:
            raise DidNotConverge(self.message, self.attempts[-1][1].residual_norms if self.attempts else ())
        return self.solution


def solve(
    system: System,
    *,
    load_factor: float = 1.0,
    control: HalveAndGrow | None = None,
    start: Solution | None = None,
    rtol: float = 1e-7,
    max_iterations: int = 30,
    mixed: bool = True,
    follow: bool = False,
    backend: str = "auto",
    progress: bool = False,
) -> StaticResult:
    """Equilibrium under the loads, by load steps from the undeformed state or from ``start``.

    Parameters
    ----------
    load_factor : float
        Factor of all loads and prescribed displacements, which are taken at their full amplitude.
    control
        Step control; by default the whole load is tried at once.
    rtol : float
        Newton's method ends when the energy norm of its residual has fallen by this factor.
    mixed : bool
        False for the plain Newton method.
    follow : bool
        Where load steps end, at a limit point for one, go on along the path by arc length until the load is reached; the
        message then names the limit points that were passed. A structure under that load would snap there.
    backend : str
        Linear solver: "auto", "mkl", "rslab" or "superlu".

    Returns
    -------
    StaticResult
        Also when it fails: then the last equilibrium, the reason, and all residuals.

    Raises
    ------
    InputError
        When a rigid motion is free.
    """
    check_asked(system, backend, start=start, rtol=rtol, counts={"max_iterations": max_iterations}, mixed=mixed,
                follow=follow, progress=progress)  # fmt: skip
    number("load_factor", load_factor)
    if control is not None and not isinstance(control, HalveAndGrow):
        raise InputError(f"control = {shown(control)}: give a HalveAndGrow, or call trace for paths by another control")
    if start is not None:
        require_same_mesh(system, start)
    require_support(system)
    result = equilibrium(
        system, load_factor, control=control, start=start, rtol=rtol, max_iterations=max_iterations, mixed=mixed,
        follow=follow, backend=backend, progress=progress,
    )  # fmt: skip
    warn_if_thick(result.solution)
    return result


def equilibrium(
    system: System, load_factor: float = 1.0, *, control: HalveAndGrow | None = None, start: Solution | None = None,
    rtol: float = 1e-7, max_iterations: int = 30, mixed: bool = True, follow: bool = False, backend: str = "auto",
    progress: bool = False,
) -> StaticResult:  # fmt: skip
    """:func:`solve` for a system that is known to be supported, without a judgement of its theory."""
    solver = DirectSolver(system.pattern, system.constraints, backend)
    with Progress("statics", 1.0, shown=progress) as bar, solver:
        run = _Run(system, solver, start or Solution(system, system.undeformed.copy(), load_factor=0.0))
        try:
            result = run.go(load_factor, control or HalveAndGrow(), bar, rtol=rtol, max_steps=max_iterations, mixed=mixed)
            if follow and result.status in FOLLOWED:
                result = _followed(result, load_factor, rtol=rtol, mixed=mixed, backend=backend, progress=progress)
            return result
        except KeyboardInterrupt:
            at = run.path[-1]
            return run.result(Status.INTERRUPTED, f"interrupted from the keyboard at load factor {at.load_factor:.6g}")


FOLLOWED = (Status.LIMIT_POINT, Status.BIFURCATION, Status.STEP_TOO_SMALL, Status.FOLDED)
"""Ends of load steps from which the path may go on."""


def _followed(stuck: StaticResult, load_factor: float, **options: Any) -> StaticResult:
    """The rest of the way by arc length."""
    at = stuck.solution
    first = ArcLength().first * (load_factor - at.load_factor)
    found = trace(at.system, ArcLength(first=first), until=load_factor, start=at, **options)
    attempts = stuck.attempts + tuple((result.load_factor, result) for result in found.attempts)
    passed = ", ".join(f"{event.kind} at {event.load_factor:.4g}" for event in found.events)
    message = f"load steps ended at {at.load_factor:.6g}; by arc length from there: {passed or 'no limit point'}"
    if found.status is not Status.CONVERGED:
        message = f"{message}; {found.message}"
    return StaticResult(found.solution, found.status, stuck.path + found.solutions[1:], attempts, message)


class _Run:
    """State of one run; everything it keeps is usable whenever it stops."""

    def __init__(self, system: System, solver: DirectSolver, start: Solution) -> None:
        self.system, self.solver = system, solver
        self.path = [start]
        self.attempts: list[tuple[float, NewtonResult]] = []

    def result(self, status: Status, message: str = "") -> StaticResult:
        return StaticResult(self.path[-1], status, tuple(self.path), tuple(self.attempts), message)

    def go(self, load_factor: float, control: HalveAndGrow, bar: Progress, **options: Any) -> StaticResult:
        at = self.path[0]
        begin, span = at.load_factor, load_factor - at.load_factor
        step, done, failed = min(1.0, control.first), 0.0, False
        while done < 1.0:
            aim = min(1.0, done + step)
            factor = begin + aim * span
            result = newton(self.system, at.q, self.solver, load_factor=factor, **options)
            self.attempts.append((factor, result))
            if result.converged:
                done = aim
                at = Solution(self.system, result.q, load_factor=factor)
                self.path.append(at)
            following = control.next_step(step, result)
            # A step that is as long as one that has just failed would fail as well.
            step = min(step, following) if failed else following
            failed = not result.converged
            bar.at(done, f"load factor {at.load_factor:.4g}, {len(result.residual_norms)} iterations")
            if step < control.smallest and done < 1.0:
                def ahead(at: Solution = at) -> float | None:
                    return limit_ahead(self.system, at, control.smallest * span)

                return self.result(*cause(self.system, self.solver, self.path, factor, result, ahead))
        return self.result(Status.CONVERGED, self._unstable())

    def _unstable(self) -> str:
        """That the last equilibrium is not stable, and since when; nothing where it is."""
        reached = [(factor, result.negative_pivots) for factor, result in self.attempts if result.converged]
        if not (reached and reached[-1][1]):
            return ""
        stable = [k for k, (_, pivots) in enumerate(reached) if not pivots]
        first = stable[-1] + 1 if stable else 0
        message = UNSTABLE.format(reached[-1][1], self.path[first].load_factor, reached[first][0])
        at = self.path[-1]
        skew = is_skew(self.system, self.system.tangent(at.q, factor=at.load_factor), at.q, at.load_factor)
        return f"{message}. {SYMMETRIC_ONLY}" if skew else message


def solve_linear(system: System, *, backend: str = "auto") -> Solution:
    """Small-deflection answer: one solve with the tangent of the undeformed state.

    Raises
    ------
    InputError
        When a rigid motion is free.
    """
    check_asked(system, backend)
    require_support(system)
    return warn_if_thick(small_deflection(system, backend=backend))


def small_deflection(system: System, load_factor: float = 1.0, *, backend: str = "auto") -> Solution:
    """:func:`solve_linear` for a system that is known to be supported, without a judgement of its theory."""
    change = load_factor * system.linear_change(backend)
    if not np.isfinite(change).all():
        raise DidNotConverge("the linear answer is not finite")
    return Solution(system, system.undeformed + change, load_factor=load_factor, linear=True)
