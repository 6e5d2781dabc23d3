"""What a path leaves behind."""

from dataclasses import dataclass

import numpy as np

from skancf.checks import Check
from skancf.equality import by_value
from skancf.errors import DidNotConverge
from skancf.showing import FEW, counted, in_a_notebook, in_brackets, looked_at, of_state, passed, span, summary
from skancf.solution import Solution
from skancf.solving import Status
from skancf.statics.events import Event
from skancf.statics.newton import NewtonResult
from skancf.statics.tables import attempts_of, states_of
from skancf.tabular import Column, Columns, Tabular, of_objects


@by_value
@dataclass(frozen=True)
class PathResult(Tabular):
    """Outcome of :func:`trace`; as a table its equilibria, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    solutions : tuple of Solution
        Equilibria in the order of the path, each with its ``load_factor``.
    negative_pivots : (n,) int array
        Number of negative eigenvalues of each one's tangent, of its symmetric part where loads follow the surface: the
        directions in which it is not stable.
    events : tuple of Event
        Limit points and bifurcation points, in the order of the path; where loads follow a free edge, of the tangent's
        symmetric part, and flutter is not found.
    status : Status
        Converged where the asked end was reached, or all steps were done and no end was asked.
    attempts : tuple of NewtonResult
        Every solve of a step and of the end, failed ones too, with its residual history.
    message : str
        Why it stopped.
    checks : tuple of Check
        Of the last equilibrium; converged is only a path whose end passed them.

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
    >>> path = sk.trace(system, until=0.5, progress=False)
    >>> print(path.status.value, path.load_factors[-1], path.displacement(crown).shape[1])
    converged 0.5 3
    """

    solutions: tuple[Solution, ...]
    negative_pivots: np.ndarray
    events: tuple[Event, ...]
    status: Status
    attempts: tuple[NewtonResult, ...]
    message: str = ""
    checks: tuple[Check, ...] = ()

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    @summary
    def __str__(self) -> str:
        loads = [solution.load_factor for solution in self.solutions]
        found = f"{counted(len(loads), 'equilibrium', 'equilibria')}, load factors {span(min(loads), max(loads))}"
        met = "".join(f"; {event}" for event in self.events[:FEW]) + ("; ..." if len(self.events) > FEW else "")
        return f"PathResult: {self.status.value}, {found}; at the end: {of_state(self.solution)}{met}{passed(self.checks)}"

    def _table(self) -> dict[str, Column]:
        return {**states_of(self.solutions), "negative_pivots": (self.negative_pivots, "")}

    @property
    def event_table(self) -> Columns:
        """The limit points and bifurcation points, with their load factors."""
        return of_objects(self.events, kind="", load_factor="", refined="")

    @property
    def attempt_table(self) -> Columns:
        """Every solve, with its load factor, status, iterations and last residual."""
        return attempts_of((result.load_factor, result) for result in self.attempts)

    @property
    def load_factors(self) -> np.ndarray:
        """(n,)"""
        return np.array([solution.load_factor for solution in self.solutions])

    @property
    def solution(self) -> Solution:
        """The last equilibrium."""
        return self.solutions[-1]

    @property
    def iterations(self) -> int:
        """Newton iterations of all attempts."""
        return sum(len(result.residual_norms) for result in self.attempts)

    @property
    def ok(self) -> bool:
        """Whether the asked end was reached and passed its checks."""
        return self.status.ok

    def displacement(self, at: tuple[float, float]) -> np.ndarray:
        """Displacement of a point of the parameter plane along the path, (n, 3)."""
        return np.array([solution.displacement(at) for solution in self.solutions])

    def _as_solution(self) -> Solution:
        return self.unwrap().solution

    def unwrap(self) -> "PathResult":
        """This path, or :class:`~skancf.DidNotConverge`."""
        if not self.ok:
            raise DidNotConverge(self.message, self.attempts[-1].residual_norms if self.attempts else ())
        return self
