"""What statics returns, and how load steps are chosen."""

from dataclasses import dataclass

from skancf.arguments import plain, whole
from skancf.checks import Check
from skancf.equality import by_value
from skancf.errors import DidNotConverge, InputError, positive, warn
from skancf.showing import counted, in_a_notebook, in_brackets, looked_at, of_state, passed, summary
from skancf.solution import Solution
from skancf.solving import Status
from skancf.statics.newton import OPEN, NewtonResult
from skancf.statics.tables import attempts_of, states_of
from skancf.tabular import Column, Columns, Tabular


@dataclass(frozen=True)
class HalveAndGrow:
    """Step control: a failed step is divided by ``cut``; an easy one, at most ``easy`` iterations, is followed by a
    ``growth`` times longer one.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> result = sk.solve(system, control=sk.HalveAndGrow(first=0.25))
    >>> print([round(state.load_factor, 2) for state in result.path])
    [0.0, 0.25, 0.75, 1.0]
    """

    first: float = 1.0
    smallest: float = 1e-4
    cut: float = 2.0
    growth: float = 2.0
    easy: int = 5

    def __post_init__(self) -> None:
        plain(self)
        whole("easy", self.easy, floats=True)
        for name in ("first", "smallest", "cut", "growth"):
            positive(name, getattr(self, name))
        if not self.cut > 1:
            raise InputError(f"cut = {self.cut}: a failed step must become shorter, give a number greater than one")
        if not self.growth >= 1:
            raise InputError(f"growth = {self.growth}: an easy step must not become shorter, give at least one")

    def next_step(self, step: float, result: NewtonResult) -> float:
        if not result.ok:
            return step / self.cut
        return step * self.growth if result.iterations <= self.easy else step


@by_value
@dataclass(frozen=True)
class StaticResult(Tabular):
    """Outcome of :func:`solve`; as a table its path, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    solution : Solution
        The last equilibrium found; the asked one if ``ok``.
    status : Status
    path : tuple of Solution
        Every equilibrium on the way.
    attempts : tuple of (load factor, NewtonResult)
        Every solve, failed ones too, with its residual history. The few short steps along the path by which the cause of
        a failure is looked for are not among them.
    message : str
        Why it stopped, if it did; what it met on the way: that a state on it was not stable, or that it snapped; or that the
        equilibrium is not stable, by ``negative_pivots``.
    checks : tuple of Check
        Of the asked equilibrium, by its exact tangent and by sums over the whole body. Converged is only what passed them.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> result = sk.solve(system)
    >>> print(result.ok, result.status.value, len(result.path))
    True converged 2
    >>> print(all(check.passed for check in result.checks))
    True
    """

    solution: Solution
    status: Status
    path: tuple[Solution, ...]
    attempts: tuple[tuple[float, NewtonResult], ...]
    message: str = ""
    checks: tuple[Check, ...] = ()

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    @summary
    def __str__(self) -> str:
        steps = counted(len(self.path), "load step")
        said = f"{self.status.value}, {of_state(self.solution)}, {counted(self.iterations, 'iteration')} in {steps}"
        return f"StaticResult: {said}{passed(self.checks)}"

    def _table(self) -> dict[str, Column]:
        return states_of(self.path)

    @property
    def attempt_table(self) -> Columns:
        """Every solve, with its load factor, status, iterations and last residual."""
        return attempts_of(self.attempts)

    @property
    def iterations(self) -> int:
        """Newton iterations of all attempts."""
        return sum(result.iterations for _, result in self.attempts)

    @property
    def negative_pivots(self) -> int:
        """Negative eigenvalues of the tangent in the last solve; a stable equilibrium has none.

        Of its symmetric part, where loads follow a free edge: then an equilibrium that has none may still flutter.
        """
        return self.attempts[-1][1].negative_pivots if self.attempts else 0

    @property
    def bound(self) -> float:
        """Part of the loads or of the energy norm that rounding of the coordinates leaves open; zero where it is below the
        limits of the checks."""
        return self.attempts[-1][1].bound if self.attempts else 0.0

    @property
    def ok(self) -> bool:
        """Whether the asked equilibrium was found and passed its checks."""
        return self.status.ok

    def _as_solution(self) -> Solution:
        return self.unwrap()

    def unwrap(self) -> Solution:
        """The solution, or :class:`~skancf.DidNotConverge`.

        Where rounding leaves less than a hundredth open, it is the solution, with a warning (:class:`~skancf.OutOfDepth`).
        """
        if self.status is Status.ROUNDING and self.bound <= OPEN:
            warn(self.message)
        elif not self.ok:
            raise DidNotConverge(self.message, self.attempts[-1][1].residual_norms if self.attempts else ())
        return self.solution
