"""Equilibrium under the loads: the nonlinear one, that of small deflections, and that along the path."""

from skancf.arguments import instance
from skancf.errors import number, positive
from skancf.linear import DirectSolver
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.solution import Solution
from skancf.states import StateLike
from skancf.statics.arguments import check_arguments
from skancf.statics.cascade import Cascade, Settings
from skancf.statics.conditioned import at_rest
from skancf.statics.controls import ArcLength
from skancf.statics.diagnosis import require_support
from skancf.statics.path import traced
from skancf.statics.static_result import HalveAndGrow, StaticResult
from skancf.statics.validity import warn_if_loose, warn_if_thick, warn_without_time
from skancf.system.system import System


def solve(
    system: System,
    *,
    load_factor: float = 1.0,
    control: HalveAndGrow | None = None,
    start: StateLike | None = None,
    rtol: float = 1e-7,
    max_iterations: int = 30,
    mixed: bool = True,
    follow: bool = False,
    relax: bool = True,
    backend: str = "auto",
    progress: ShowProgress = True,
) -> StaticResult:
    """Stable equilibrium under the loads, from the undeformed state or from ``start``.

    The whole load is tried at once, then halved load steps. Where they end, at a limit point for one, the structure is
    relaxed at the full load (:mod:`skancf.statics.relax`) to a stable state downhill; where their answer is not stable, it
    is pushed along its softest motion and relaxed from there. The message says so. An answer that is not stable is returned
    where nothing stable is found downhill, and says so too. Nothing is called converged that fails its ``checks``.

    Parameters
    ----------
    load_factor : float
        Factor of all loads and prescribed displacements, which are taken at their full amplitude.
    control
        Step control; by default the whole load is tried at once.
    rtol : float
        Newton's method ends when the energy norm of its residual is less than this part of that of the strain.
    mixed : bool
        False for the plain Newton method.
    follow : bool
        Go along the path by arc length, with :func:`trace`, until the load is reached for the first time; the message then
        names the limit points that were passed, at which a structure under that load would snap.
    relax : bool
        False to stop where load steps end, and to return what they find though it is not stable.
    backend : str
        Linear solver: "auto", "mkl", "rslab" or "superlu".
    progress : bool or callable
        A bar, nothing, or a function that is told of each load step and Newton solve; see :class:`~skancf.Progress`.

    Returns
    -------
    StaticResult
        Also when it fails: then the last equilibrium, the reason, and all residuals.

    Raises
    ------
    InputError
        When a rigid motion is free.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> result = sk.solve(system)
    >>> print(result.status.value, result.iterations)
    converged 4
    >>> print(f"{1000 * result.unwrap().displacement((1.0, 0.05))[2]:.3f} mm")
    1.905 mm
    """
    start = check_arguments(system, backend, start=start, rtol=rtol, counts={"max_iterations": max_iterations}, mixed=mixed,
                            follow=follow, relax=relax)  # fmt: skip
    check_progress(progress)
    load_factor, rtol = number("load_factor", load_factor), positive("rtol", rtol)
    if control is not None:
        instance("control", control, HalveAndGrow, "a HalveAndGrow, or call trace for paths by another control")
    require_support(system)
    warn_without_time(system)
    result = equilibrium(
        system, load_factor, control=control, start=start, rtol=rtol, max_iterations=max_iterations, mixed=mixed,
        follow=follow, relax=relax, backend=backend, progress=progress,
    )  # fmt: skip
    warn_if_thick(result.solution)
    warn_if_loose(result.solution)
    return result


def equilibrium(
    system: System, load_factor: float = 1.0, *, control: HalveAndGrow | None = None, start: Solution | None = None,
    rtol: float = 1e-7, max_iterations: int = 30, mixed: bool = True, follow: bool = False, relax: bool = True,
    backend: str = "auto", progress: ShowProgress = False,
) -> StaticResult:  # fmt: skip
    """:func:`solve` for a system that is known to be supported, without a judgement of its theory."""
    begin = start or at_rest(system)
    if follow and begin.load_factor != load_factor:
        return _followed(begin, load_factor, rtol, mixed, backend, progress)
    solver = DirectSolver(system.pattern, system.constraints, backend)
    with Bar("statics", 1.0, progress) as bar, solver:
        settings = Settings(rtol, int(max_iterations), mixed, relax)
        return Cascade(system, solver, begin, load_factor, settings, bar).go(control or HalveAndGrow())


def _followed(
    start: Solution, load_factor: float, rtol: float, mixed: bool, backend: str, progress: ShowProgress
) -> StaticResult:
    """The whole way by arc length."""
    first = ArcLength().first * (load_factor - start.load_factor)
    found = traced(
        start.system, ArcLength(first=first), until=load_factor, start=start, rtol=rtol, mixed=mixed, backend=backend,
        progress=progress,
    )  # fmt: skip
    attempts = tuple((result.load_factor, result) for result in found.attempts)
    passed = ", ".join(f"{event.kind} at {event.load_factor:.4g}" for event in found.events)
    message = f"by arc length from {start.load_factor:.4g}: {passed or 'no limit point and no bifurcation'}"
    if found.negative_pivots[-1]:
        message += f"; the equilibrium is not stable, its tangent has {found.negative_pivots[-1]} negative eigenvalue(s)"
    if not found.ok:
        message = f"{message}; {found.message}"
    return StaticResult(found.solution, found.status, found.solutions, attempts, message, found.checks)
