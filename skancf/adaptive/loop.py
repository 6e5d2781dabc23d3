"""The loop: solve, estimate, mark, refine, until a number is as accurate as asked."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
import skfem

from skancf.adaptive.analysis import Analysis, Answer, StaticAnalysis
from skancf.adaptive.arguments import INDICATORS, AdaptArguments, check, first_system, newton_rtol
from skancf.adaptive.assessment import assess
from skancf.adaptive.blunt import NOWHERE
from skancf.adaptive.estimate import Estimate, check_quantity
from skancf.adaptive.grow import DOERFLER, NEVER, Growth
from skancf.adaptive.interpolation import ancestors_in
from skancf.adaptive.marking import Below, Even, Marking, check_indicators
from skancf.adaptive.nested import Nested
from skancf.adaptive.quantities import Quantity
from skancf.adaptive.result import AdaptiveResult, Level
from skancf.adaptive.rings import NOTHING_KNOWN
from skancf.adaptive.singular import singular_points
from skancf.adaptive.start import starting_mesh
from skancf.adaptive.unbounded import why_without_limit
from skancf.arguments import MESH, instance
from skancf.errors import DidNotConverge, InputError, number, silenced
from skancf.functions import called
from skancf.kernels.constants import BLOCK
from skancf.meshes import MeshQuadTree, quadtree
from skancf.problem import Problem
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.showing import short
from skancf.solution import Solution
from skancf.solving import End, Status, run_steps
from skancf.system.system import System
from skancf.theories import Theory
from skancf.tolerances import ABOVE_ZERO

logger = logging.getLogger(__name__)

BELOW = Below(0.01)
EVEN = Even(0.65)
"""By default in theories of order two."""
FINER_STARTS = 2
"""How often the first mesh is quartered where it has no answer."""
WORSE = 10.0
"""Error bars of a finer mesh that are so much larger, and hold the value of a coarser one, say nothing against it."""
COST = 1.3
"""Seconds of a mesh grow with this power of its coordinates."""
T = TypeVar("T")


def adapt(
    problem: Problem,
    quantity: Quantity | Any,
    rtol: float = 1e-3,
    *,
    atol: float = 0.0,
    mesh: skfem.MeshQuad | None = None,
    theory: str | Theory = "kirchhoff",
    linear: bool = False,
    load_factor: float = 1.0,
    indicator: str | Callable[[Solution], np.ndarray] = "goal",
    marking: Marking | None = None,
    coarsening: Marking = BELOW,
    max_dofs: int = 150_000,
    max_seconds: float | None = None,
    max_levels: int = 50,
    backend: str = "auto",
    progress: ShowProgress = True,
) -> AdaptiveResult:
    r"""Refine a mesh until a quantity is as accurate as asked: :math:`|\eta| \le \max(\text{rtol} |J|, \text{atol})`.

    On each mesh the equilibrium is found, starting from that of the mesh before, and the error of the quantity is estimated
    by its dual weight (:func:`goal_estimate`); elements that contribute most are quartered, those that
    contribute next to nothing are merged. In nonlinear problems the dual weight belongs to the tangent at the solution.

    Parameters
    ----------
    problem : Problem
    quantity : Quantity
        :class:`Displacement`, :class:`Rotation`, :class:`SectionForce`, :class:`Reaction`,
        :class:`ConditionForce`, :class:`StrainEnergy`,
        :class:`Eigenfrequency`, :class:`BucklingLoad`, or an object with ``unit``, ``value`` and ``gradient``.
    rtol, atol : float
        The asked accuracy, relative to the value and absolute (in the unit of the quantity).
    mesh : skfem.MeshQuad, optional
        Where to begin. Default: some 16 elements over the bounds of the surface, with nodes at point loads and supports,
        and lines along the sides of a mean's rectangle.
    theory
        As in :meth:`Problem.on`.
    linear : bool
        Small deflections.
    load_factor : float
        Of all loads.
    indicator : {"goal", "residual", "recovery", "stress"} or callable
        By what elements are marked: their part in the error of the quantity; the energy of the residual in them; recovered
        against raw moments and membrane forces; the nodal stress at the faces (:func:`stress_indicator`); or a function of
        the state. The error bar is that of the quantity in each case.
    marking, coarsening : Marking
        Policies. Default: those elements are quartered that hold nine tenths of the error (:class:`Doerfler`), in theory
        `full` by ``"goal"`` all of them where it is spread evenly (:class:`Even`), and those merged that hold less than a
        hundredth of the mean. Where three meshes in a row have every element of the last one quartered, and their values go
        as they should, these tell the error, without a dual weight.
    max_dofs : int
        Most nodal coordinates of a mesh on which the quantity is computed. The estimate takes four to five times as many,
        and more on coarse meshes with many singular points.
    max_seconds : float, optional
        No mesh is begun that would end later, by what the last ones took. The first one is always finished.
    max_levels : int
    progress : bool or callable
        A bar, nothing, or a function that is told of each mesh; see :class:`~skancf.Progress`.

    Returns
    -------
    AdaptiveResult
        Also when the accuracy is not reached: the best answer with its error bar, and the reason. That is the one on the
        last mesh that was finished, also where it was interrupted from the keyboard; or on one before, where later ones have
        an error bar more than ten times as large that holds its value.

    Raises
    ------
    NoLimit
        For a number that has no limit as the mesh is refined; the message names the point, and a quantity that has one.
    InputError
        For a tolerance that is not positive, a place that is not on the surface, a budget too small for the first mesh.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> result = sk.adapt(plate, sk.Displacement(at=(0.5, 0.5)), rtol=1e-3, linear=True)
    >>> print(f"{1000 * result.value:.4f} mm", result.error_bar < 1e-3 * abs(result.value), result.status.value)
    -0.0658 mm True the asked accuracy is reached
    """
    check(problem, rtol, atol, indicator, (marking, coarsening), max_dofs, max_seconds, max_levels, backend,
          linear=linear)  # fmt: skip
    check_progress(progress)
    check_quantity(quantity, ("analysis",) if hasattr(quantity, "analysis") else ("value", "gradient"))
    if mesh is not None:
        instance("mesh", mesh, skfem.MeshQuad, MESH)
    rtol, atol = float(rtol), float(atol)
    statics = StaticAnalysis(quantity, linear, number("load_factor", load_factor), newton_rtol(rtol), backend)
    analysis = quantity.analysis(statics) if hasattr(quantity, "analysis") else statics
    first = quadtree(starting_mesh(problem, quantity) if mesh is None else mesh, problem.surface)
    arguments = AdaptArguments(rtol, atol, max_dofs, max_seconds, max_levels)
    with Bar("adapt", 1.0, progress) as bar:
        by = INDICATORS[indicator] if isinstance(indicator, str) else indicator
        system = first_system(problem, first, theory, quantity, analysis, max_dofs)
        even = indicator == "goal" and system.geometry.theory.order == 2
        blunt = analysis.blunt(system) if hasattr(analysis, "blunt") else NOWHERE
        growth = Growth((EVEN if even else DOERFLER) if marking is None else marking, coarsening, analysis.smallest, blunt)
        return _Run(system, quantity, analysis, growth, by, arguments, bar).go()


class _Found(NamedTuple):
    """A finished mesh."""

    level: Level
    answer: Answer
    estimate: Estimate

    def __repr__(self) -> str:
        return short(self)


@dataclass
class _Clock:
    """Seconds by the name of the work."""

    seconds: dict[str, float]

    __repr__ = short

    def take(self, name: str, work: Callable[..., T], *arguments: Any) -> T:
        begun = time.perf_counter()
        try:
            return work(*arguments)
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun


class _Run:
    """State of one run; what it keeps is usable whenever it stops."""

    def __init__(
        self, system: System, quantity: Any, analysis: Analysis, growth: Growth,
        indicator: Callable[[Solution], np.ndarray] | None, arguments: AdaptArguments, bar: Bar,
    ) -> None:  # fmt: skip
        self.system, self.quantity, self.analysis, self.growth = system, quantity, analysis, growth
        self.indicator, self.arguments, self.bar = indicator, arguments, bar
        self.levels: list[Level] = []
        self.best: _Found | None = None
        self.sound: _Found | None = None
        self.start: Solution | None = None
        self.merged, self.clock = 0, _Clock({})
        self.finer_starts, self.nested = 0, Nested(quantity)
        self.begun = time.perf_counter()

    def go(self) -> AdaptiveResult:
        status, message = run_steps(
            self._step, lambda: self._unless_first("; the last finished mesh is kept"), self._failed, logger
        )
        assert self.best is not None and self.sound is not None
        kept = self.best if status.ok else self.sound
        level, answer, estimate = kept
        if kept is not self.best:
            last = self.best.level
            message += (f". The answer is that on {level.n_elements} elements: on {last.n_elements} it is {last.value:.6g} "
                        f"+- {last.bar:.2g}, which says less")  # fmt: skip
        if not status.ok and abs(answer.value) < estimate.bar:
            message += ". The value is zero within its error bar: say by atol how near to zero is near enough"
        left_out = self.analysis.theory_error(answer) if hasattr(self.analysis, "theory_error") else None
        assess(answer.state, left_out, answer.found is None)
        return AdaptiveResult(
            answer.value, estimate.bar, answer.value + estimate.error, answer.state, tuple(self.levels), status,
            ". ".join(part for part in (message, self._met()) if part), self.quantity.unit, answer.checks, left_out,
        )  # fmt: skip

    def _met(self) -> str:
        """What the last solve that met something met."""
        noted = next((level for level in reversed(self.levels) if level.note), None)
        return f"On {noted.n_elements} elements: {noted.note}" if noted else ""

    def _unless_first(self, message: str) -> str | None:
        return None if self.best is None else message

    def _failed(self, error: Exception) -> str | None:
        return self._unless_first(f"after the mesh of {self.system.mesh.nelements} elements: {error}")

    def _step(self) -> End | None:
        """One mesh, and the system on the next one."""
        try:
            self._keep(self._on(self.system, self.start, self.merged, self.clock))
        except DidNotConverge as failed:
            if self.best is not None:
                raise
            self._start_finer(failed)
            return None
        assert self.best is not None
        level, answer, _ = self.best
        if end := self._end():
            return end
        at, clock = answer.state.system, self.clock
        mesh, end = clock.take("mark", self._next, at, self.best, singular_points(at, self.quantity))
        if end:
            return end
        self.merged, self.start, self.clock = _merged(level.mesh, mesh), answer.state, _Clock({})
        self.system = self.clock.take("assemble", at.problem.on, mesh, at.geometry.theory)
        return None

    def _start_finer(self, failed: DidNotConverge) -> None:
        """Go on with a mesh of quarters, where the first one is too coarse to have an answer; or with the failure."""
        mesh = self.system.mesh.refined()
        if BLOCK * mesh.p.shape[1] > self.arguments.max_dofs or self.finer_starts == FINER_STARTS:
            raise failed
        self.finer_starts += 1
        self.system = self.system.problem.on(mesh, self.system.geometry.theory)

    def _on(self, system: System, start: Solution | None, merged: int, clock: _Clock) -> _Found:
        # Of coarse meshes; the last one is judged.
        with silenced():
            answer = clock.take("solve", self.analysis.solve, system, start)
            halvings = self.best.estimate.halvings if self.best else NOTHING_KNOWN
            estimate = clock.take("estimate", lambda: self.nested.error(answer) or self.analysis.estimate(answer, halvings))
            indicators = estimate.indicators
            if self.indicator is not None:
                indicators = check_indicators(clock.take("mark", called, "indicator", self.indicator, answer.state))
                if len(indicators) != system.mesh.nelements:
                    raise InputError(f"indicator: it gives {len(indicators)} numbers for {system.mesh.nelements} elements; "
                                     "give one for each")  # fmt: skip
        if not np.isfinite([answer.value, estimate.bar]).all():
            raise DidNotConverge(f"the quantity is {answer.value} +- {estimate.bar} on {system.mesh.nelements} elements: it "
                                 "must be a finite number")  # fmt: skip
        level = Level(
            system.mesh, system.n_dofs, answer.value, estimate.error, indicators, answer.iterations, answer.restarted,
            merged, clock.seconds, note=answer.note, nested=estimate.nested, bar=estimate.bar,
        )  # fmt: skip
        self.nested.add(system.mesh, estimate)
        return _Found(level, answer, estimate)

    def _keep(self, found: _Found) -> None:
        """Take a mesh, or reject it where merging elements made the estimate worse; none are merged from then on."""
        level, best = found.level, self.best
        if best is not None and level.coarsened and abs(level.error) > abs(best.level.error):
            level = replace(level, rejected=True)
            self.growth = replace(self.growth, coarsen=NEVER)
        else:
            self.best = found
            if self.sound is None or not _says_less(found.level, self.sound.level):
                self.sound = found
        self.levels.append(level)
        wanted = self.arguments.tolerance(level.value) / max(found.estimate.bar, ABOVE_ZERO)
        note = f"{level.n_elements} elements: {level.value:.6g} +- {found.estimate.bar:.1g}"
        logger.info(
            "mesh %d: %d nodal coordinates, %s%s", len(self.levels), level.n_dofs, note, ", rejected" * level.rejected
        )
        self.bar.at(min(1.0, wanted) ** 0.5, note)

    def _end(self) -> End | None:
        """Why to stop after a mesh."""
        assert self.best is not None
        found, accepted = self.best, [level for level in self.levels if not level.rejected]
        level = found.level
        if found.estimate.bar <= self.arguments.tolerance(level.value):
            return Status.REACHED, ""
        if zero := self.arguments.zero(found.estimate):
            return Status.REACHED, zero
        if found.estimate.bar < 2 * found.estimate.rounding:
            return Status.ROUNDING, (f"rounding, {found.estimate.rounding:.1g}, is as large as the estimated error; a "
                                      "smaller tolerance cannot be met")  # fmt: skip
        if why := why_without_limit(accepted, singular_points(found.answer.state.system)):
            return Status.NO_LIMIT, why
        if stuck := self._in_smallest(found):
            return Status.ROUNDING, stuck
        if len(self.levels) >= self.arguments.max_levels:
            return Status.BUDGET, f"max_levels = {self.arguments.max_levels} meshes are spent"
        return None

    def _in_smallest(self, found: _Found) -> str:
        """That most of the error is in elements which may be no smaller; empty where it is not."""
        shares, geometry = found.estimate.indicators, found.answer.state.system.geometry
        full = ~self.growth.room(geometry.mesh.leaves, geometry.surface)
        if not shares[full].sum() > shares.sum() / 2:
            return ""
        why = ", or as the thickness about a point force" if self.growth.blunt.sizes.size else ""
        x, y = geometry.mesh.p[:, geometry.mesh.t[:, np.argmax(np.where(full, shares, 0.0))]].mean(axis=1)
        return (f"most of the error comes from elements at ({x:.6g}, {y:.6g}) that are as small as rounding lets them be"
                f"{why}: a smaller tolerance cannot be met, or the number has no limit there")  # fmt: skip

    def _next(self, system: System, found: _Found, points: np.ndarray) -> tuple[MeshQuadTree, End | None]:
        """The next mesh, and why not to begin with it; one of fewer elements where all of them are too many."""
        level, known = found.level, (found.level.indicators, points, found.estimate.halvings)
        mesh = self.growth.next_mesh(system, *known)
        end, part = self._too_much(level, mesh), getattr(self.growth.refine, "part", None)
        if end and part is not None:
            fewer = replace(self.growth, refine=part).next_mesh(system, *known)
            if not self._too_much(level, fewer):
                return fewer, None
        return mesh, end

    def _too_much(self, level: Level, mesh: MeshQuadTree) -> End | None:
        """Why not to begin with the next mesh."""
        arguments = self.arguments
        if np.array_equal(mesh.leaves.keys, level.mesh.leaves.keys):
            return Status.UNMARKED, "no element is marked; take another indicator, or a marking that takes more"
        n_dofs = BLOCK * (mesh.p.shape[1] - len(mesh.hanging))
        if n_dofs > arguments.max_dofs:
            return Status.BUDGET, f"max_dofs = {arguments.max_dofs}: the next mesh has {n_dofs} nodal coordinates"
        if arguments.max_seconds is not None:
            spent = time.perf_counter() - self.begun
            expected = level.total_seconds * (n_dofs / level.n_dofs) ** COST
            if spent + expected > arguments.max_seconds:
                return Status.BUDGET, (f"max_seconds = {arguments.max_seconds:g}: {spent:.2g} s are spent, and the next "
                                        f"mesh would take some {expected:.2g} s")  # fmt: skip
        return None


def _says_less(level: Level, before: Level) -> bool:
    """Than a coarser mesh: it is much less sure, and does not contradict it."""
    return level.bar > WORSE * before.bar and abs(level.value - before.value) <= level.bar


def _merged(old: MeshQuadTree, new: MeshQuadTree) -> int:
    """How many elements of a mesh are larger than those of another were."""
    return int((ancestors_in(old.leaves, new.leaves) < 0).sum())
