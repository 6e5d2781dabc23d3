"""Linear buckling: the load factors at which an undeformed structure loses its stiffness."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator

from skancf.arguments import choice
from skancf.checks import Check
from skancf.equality import by_value
from skancf.errors import InputError
from skancf.linear import BlockMatrix, DirectSolver
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.showing import in_a_notebook, in_brackets, looked_at, passed, some, summary
from skancf.solution import Solution
from skancf.statics.arguments import check_arguments
from skancf.statics.conditioned import curved, is_loaded
from skancf.statics.diagnosis import require_support
from skancf.statics.eigen_checks import (
    SAFETY,
    TRIES,
    count_check,
    gap_or_group,
    group_note,
    orthogonality_check,
    pair_check,
    warn_of_failures,
)
from skancf.statics.left_out import buckling_changes, warn_of_changes
from skancf.statics.linear import answer_by
from skancf.statics.modes import (
    check_tolerance,
    checked_count,
    lanczos,
    moved_along,
    nth,
    swung_along,
)
from skancf.statics.motions import Motions, motions_of
from skancf.statics.tangents import warn_if_skew
from skancf.statics.validity import warn_without_time
from skancf.system.linearised import Linearised, geometric_stiffness
from skancf.system.system import System
from skancf.system.unstressed import unstressed
from skancf.tabular import Column, Tabular
from skancf.tolerances import AT_REST, ZERO_EIGENVALUE

logger = logging.getLogger(__name__)

# A load factor that is this many times the smallest one of either sign counts as infinite.
NEVER = 1e4
# Membrane strains as they are may ask for this much more of the load before a mesh is called too coarse.
COARSE = 0.15


@by_value
@dataclass(frozen=True)
class BucklingResult(Tabular):
    r"""Outcome of :func:`buckling`; as a table the load factors, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    load_factors : (m,) array
        In the order of their size; fewer than were asked where no more exist. Those beyond 10^4 times the smallest of
        either sign count as infinite.
    shapes : (m, n_dofs) array
        Buckling modes with phi . K phi = 1, zero along prescribed coordinates.
    linear : Solution
        The linear answer to the whole load, of which the stresses were used.
    message : str
        That no load factor buckles the structure, if none does; or that the mesh is too coarse for a mode, where assumed
        membrane strains (theory `kirchhoff`) and those as they are do not agree in it.
    note : str
        That n cuts a group of equal or nearly equal load factors, and how many to ask for to have all of it.
    checks : tuple of Check
        A bound on the relative error of each load factor from its residual, the worst of them; products of the shapes; and
        whether any of the lowest is missing, by the signs of the pivots of :math:`K_0 + s K_\sigma`, s in the gap behind
        the last.

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
    >>> found = sk.buckling(system, 1)
    >>> print(found.load_factors.shape, found.shape(0, size=1.0).note)
    (1,) mode of arbitrary size
    """

    load_factors: np.ndarray
    shapes: np.ndarray
    linear: Solution
    message: str = ""
    note: str = ""
    checks: tuple[Check, ...] = ()

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    @summary
    def __str__(self) -> str:
        factors = f"load factors {some(self.load_factors)}" if len(self.load_factors) else self.message
        return f"BucklingResult: {factors}; {self.linear.system}{passed(self.checks)}"

    @property
    def ok(self) -> bool:
        """Whether what was asked for was found, and every check passed."""
        return all(check.passed for check in self.checks)

    @cached_property
    def theory_errors(self) -> np.ndarray:
        r"""By which part of itself transverse shear, which theory `kirchhoff` leaves out, would change each load factor.

        Shape (n,).

        .. math:: \frac{\lambda_{\text{with}}}{\lambda} - 1 \approx \frac{1}{1 + F(\phi, \phi)} - 1

        with the form F of :mod:`skancf.thinness.form`; zero in theory `full`.
        """
        return buckling_changes(self.linear, self.shapes)

    def _table(self) -> dict[str, Column]:
        return {"mode": (np.arange(len(self.load_factors)), ""), "load_factor": (self.load_factors, "")}

    def _as_solution(self) -> Solution:
        raise InputError("a buckling result has several shapes; give one of them, as result.shape(0)")

    def shape(self, i: int, size: float | None = None) -> Solution:
        """The undeformed structure moved along mode ``i``; ``size`` is the largest displacement of a node (m)."""
        return moved_along(self.start, nth(self.shapes, i), size)

    def swing(self, i: int, size: float | None = None, *, frames: int = 24) -> tuple[Solution, ...]:
        """Mode ``i`` to and fro, for films that repeat: see :meth:`Modes.swing`."""
        return swung_along(self.start, nth(self.shapes, i), size, frames)

    @property
    def start(self) -> Solution:
        """The undeformed structure, from which the modes lead away."""
        return Solution(self.linear.system, self.linear.system.undeformed.copy(), load_factor=0.0)


def buckling(
    system: System,
    n: int = 4,
    *,
    signs: str = "positive",
    tolerance: float = 1e-10,
    backend: str = "auto",
    progress: ShowProgress = True,
) -> BucklingResult:
    r"""Load factors :math:`\lambda` with :math:`(K_0 + \lambda K_\sigma)\,\phi = 0`.

    :math:`K_0` is the tangent of the undeformed state, and :math:`K_\sigma` the change of it by the stresses of the linear
    answer to the whole load, by the loads' own stiffness, and by the forces of conditions. It is exact where the structure
    hardly moves before it buckles; :func:`trace` finds the load in general. Lanczos' method solves
    :math:`-K_\sigma \phi = \lambda^{-1} K_0 \phi`.

    Parameters
    ----------
    n : int
        Number of load factors.
    signs : {"positive", "both"}
        With "both" the loads may also act the other way; then the smallest in size come first.
    tolerance : float
        Relative accuracy.
    backend : str
        Of the linear solver.
    progress : bool or callable
        A bar, nothing, or a function that is told of each solve; see :class:`~skancf.Progress`.

    Raises
    ------
    InputError
        When a rigid motion is free, nothing loads the structure, or its own terms strain it without a load.
    SingularMatrix
        When some part is a mechanism.

    Warns
    -----
    OutOfDepth
        Where loads follow a free edge: only the symmetric part of their stiffness is taken, and flutter is not found. Where
        a check fails, for example as load factors are missing that further searches did not find.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> critical = 4 * np.pi**2 * steel.young * 0.01**3 / 12 / (1 - steel.poisson**2)  # for sides of 1 m
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[
    ...         sk.Roller("boundary", kind="hard"), sk.Roller("left", (1, 0, 0)), sk.Roller((0.0, 0.0), (0, 1, 0)),
    ...     ],
    ...     loads=[sk.EdgeLoad("right", (-critical, 0.0, 0.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(f"{sk.buckling(system, 1).load_factors[0]:.3f}")
    1.000
    """
    check_arguments(system, backend)
    check_progress(progress)
    tolerance = check_tolerance(tolerance)
    choice("signs", signs, ("positive", "both"))
    n = checked_count(n, system.constraints)
    require_support(system)
    warn_without_time(system)
    start, constraints = system.undeformed, system.constraints
    if not is_loaded(system, start):
        raise InputError("no buckling: nothing loads the structure; give a load or a prescribed displacement")
    stiffness = system.stiffness()
    warn_if_skew(system, stiffness, start, 1.0)
    with Bar("buckling", None, progress) as bar, DirectSolver(system.pattern, constraints, backend) as solver:
        answer, multipliers = answer_by(system, solver)
        if not answer.any():
            raise InputError("no buckling: the supports take the whole load, nothing is strained; free the edges it acts on")
        motions = motions_of(system, solver, start, stiffness)
        motions.require(n)
        if multipliers is not None:
            motions.factor(stiffness)
        _require_rest(system, motions, answer)
        geometric = curved(system, geometric_stiffness(system, answer), start, multipliers)
        pencil = _Pencil(motions, stiffness, geometric, tolerance, bar)
        inverse, shapes, cut, count = pencil.lowest(n, signs)
        checks = (*pencil.checked(inverse[:n], shapes[:n]), count)
    logger.info("%d load factors; %d solves", len(inverse[:n]), bar.done)
    message = "no positive load factor buckles this structure; the load only stiffens it"
    if inverse.size:
        message = _coarse(system, stiffness, shapes[:n])
    note = group_note("load factor", 1.0 / np.abs(inverse), n, cut)
    warn_of_failures(checks)
    linear = Solution.of(Linearised(system), answer, multipliers=multipliers)
    result = BucklingResult(1.0 / inverse[:n], shapes[:n], linear, message, note, checks)
    warn_of_changes("buckling load", result.theory_errors)
    return result


def _require_rest(system: System, motions: Motions, answer: np.ndarray) -> None:
    """InputError where terms of the structure strain it before any load: their stresses do not grow with the load factor."""
    at_rest = getattr(system, "others", None)
    if not at_rest:
        return
    change = motions.solve(-at_rest.force(system.undeformed))
    if np.abs(change).max() > AT_REST * np.abs(answer).max():
        raise InputError("no buckling: terms of the structure have forces in its undeformed state, which do not grow with "
                         "the load factor. Where they belong to the loads, give them load=True; else follow the path with "
                         "sk.trace, which finds where it loses stability")  # fmt: skip


def _coarse(system: System, stiffness: BlockMatrix, shapes: np.ndarray) -> str:
    """That the mesh is too coarse for some shapes: assumed membrane strains and those as they are do not agree in them."""
    if not hasattr(system, "shell"):
        return ""
    plain = unstressed(system, plain=True)
    ratios = np.array([plain.energy(x) / stiffness.energy(x) for x in shapes])
    if ratios.max() < 1 + COARSE:
        return ""
    worst = int(np.argmax(ratios))
    return (
        f"the mesh is too coarse for the waves of mode {worst}: with membrane strains as they are it would need "
        f"{ratios[worst]:.3g} times the load, and finer meshes may have less than both; take one"
    )


class _Pencil:
    """Inverse load factors and their shapes: eigenpairs of minus the geometric stiffness against the elastic one."""

    def __init__(self, motions: Motions, stiffness: BlockMatrix, geometric: BlockMatrix, tolerance: float, bar: Bar) -> None:
        self.motions, self.stiffness, self.geometric, self.tolerance = motions, stiffness, geometric, tolerance
        self.bar = bar
        self.constraints = motions.constraints

    def lowest(self, n: int, signs: str) -> tuple[np.ndarray, np.ndarray, int, Check]:
        """Inverse load factors (m,) and shapes (m, n_dofs) of the lowest load factors, up to the first gap behind n of them;
        the number of those before the gap; and whether that number exists.

        Sylvester: each load factor between 0 and s makes one eigenvalue of K_0 + s K_sigma negative. So many are looked for
        in addition to what was found until the numbers agree.
        """
        which = "LA" if signs == "positive" else "LM"
        limit = NEVER / np.abs(self._more(1, "LM", (np.zeros(0), self._none))[0]).max()
        exist = self._within(limit, signs)
        values, shapes = np.zeros(0), self._none
        ask, lost, stuck, tries = min(n + 1, exist), exist + 1, 0, 0
        while True:
            if ask > 0:
                self.motions.factor(self.stiffness)
                values, shapes = self._more(ask, which, (values, shapes))
                # Those that never buckle are no load factors.
                order = np.argsort(-np.abs(values), kind="stable")
                order = order[np.abs(values[order]) * limit > 1]
                order = order[values[order] > 0] if which == "LA" else order
                values, shapes = values[order], shapes[order]
            tries += 1
            logger.debug("search %d: %d load factors", tries, len(values))
            factors, at, cut = 1.0 / np.abs(values), limit, len(values)
            if cut < exist:
                gap = gap_or_group(factors, n, tries)
                if gap is None:
                    ask = min(max(1, n + 1 - cut, cut // 2), exist - cut)
                    continue
                cut, at = gap, 0.5 * float(factors[gap - 1] + factors[gap])
            counted = exist if at == limit else self._within(at, signs)
            stuck = stuck + 1 if counted - cut >= lost else 0
            lost = counted - cut
            if lost <= 0 or stuck == TRIES:
                return values, shapes, cut, count_check(cut, counted, f"up to the load factor {at:.6g}")
            ask = min(lost + 1, max(exist - len(values), 1))

    @property
    def _none(self) -> np.ndarray:
        return np.zeros((0, self.stiffness.shape[0]))

    def _within(self, at: float, signs: str) -> int:
        """Number of load factors from 0 to ``at``, for both signs also of those from ``-at`` to 0."""
        count = 0
        for sign in (1.0, -1.0) if signs == "both" else (1.0,):
            self.motions.factor(self.stiffness + (sign * at) * self.geometric)
            count += self.motions.negative_pivots
        return count

    def checked(self, values: np.ndarray, shapes: np.ndarray) -> tuple[Check, Check]:
        r"""Bounds on relative errors, with :math:`r = -K_\sigma \phi - \mu K_0 \phi` and :math:`\mu = 1 / \lambda`: some
        :math:`\mu^*` has :math:`|\mu - \mu^*| \le \sqrt{r \cdot K_0^{-1} r}`; and products of the shapes."""
        if not len(values):
            return pair_check(values, values), orthogonality_check(np.zeros((0, 0)), "elastic stiffness")
        self.motions.factor(self.stiffness)
        elastic = np.array([self.constraints.free_part(self.stiffness @ v) for v in shapes])
        load = np.array([self.constraints.free_part(self.geometric @ v) for v in shapes])
        residuals = -load - values[:, None] * elastic
        moved = [(self.motions.correction(r, v), r) for r, v in zip(residuals, shapes, strict=True)]
        errors = np.array([np.sqrt(abs(float(r @ x))) + more for (x, more), r in moved]) / np.abs(values)
        sizes = self.stiffness.sizes()
        noise = ZERO_EIGENVALUE * np.array([np.abs(v) @ (sizes @ np.abs(v)) for v in shapes])
        products = shapes @ elastic.T
        return pair_check(errors, SAFETY * self.tolerance + noise), orthogonality_check(products, "elastic stiffness")

    def _more(
        self, n: int, which: str, known: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """The known ones and the n largest besides them, in size or as they are; of few coordinates all."""
        if 2 * (n + len(known[0])) >= self.motions.room:
            return _dense(self.stiffness, self.geometric, self.motions)
        new = self._lanczos(n, which, known[1])
        return np.append(known[0], new[0]), np.vstack([known[1], new[1]])

    def _lanczos(self, n: int, which: str, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The n largest, in size or as they are, besides the known ones."""
        shape = self.stiffness.shape
        elastic, load = (self._projected(matrix) for matrix in (self.stiffness, self.geometric))
        weights = np.array([elastic(v) for v in known]).reshape(known.shape)

        def apart(v: np.ndarray) -> np.ndarray:
            return v - known.T @ (weights @ v)

        def driving(v: np.ndarray) -> np.ndarray:
            force = -load(apart(v))
            return force - weights.T @ (known @ force)

        solve = self.bar.counting(self.motions.solve, f"solves for {n} load factors")
        start = apart(solve(np.random.default_rng(len(known)).standard_normal(shape[0])))
        values, vectors = lanczos(
            LinearOperator(shape, matvec=driving, dtype=np.float64), k=n, which=which, v0=start, tol=self.tolerance,
            M=LinearOperator(shape, matvec=elastic, dtype=np.float64),
            Minv=LinearOperator(shape, matvec=solve, dtype=np.float64),
            ncv=min(self.motions.room, max(2 * n + 1, 30)),
        )  # fmt: skip
        return values, np.array([self.constraints.free_part(v) for v in vectors])

    def _projected(self, matrix: BlockMatrix) -> Callable[[np.ndarray], np.ndarray]:
        keep = self.constraints.free_part
        return lambda v: keep(matrix @ keep(v))


def _dense(stiffness: BlockMatrix, geometric: BlockMatrix, motions: Motions) -> tuple[np.ndarray, np.ndarray]:
    """For so few coordinates that Lanczos' method has no room: the same, with full matrices."""
    free = motions.directions()
    elastic, load = (free @ matrix.to_scipy() @ free.T for matrix in (stiffness, geometric))
    values, vectors = eigh(-load, elastic)
    return values, vectors.T @ free
