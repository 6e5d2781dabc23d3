"""Limit points and bifurcation points between two points of a path."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skancf.errors import SingularMatrix
from skancf.solution import Solution
from skancf.statics.newton import factored
from skancf.statics.points import Follower, Point

LIMIT, BIFURCATION = "limit point", "bifurcation"
REFINEMENTS = 6
# Of the step in which an event was found.
CLOSE = 1e-5


@dataclass(frozen=True)
class Event:
    """A point of the path where its tangent stiffness is singular.

    Attributes
    ----------
    kind : str
        "limit point", where the load factor has a maximum or a minimum, or "bifurcation", where another branch crosses.
    load_factor : float
    solution : Solution
        The equilibrium there, up to the accuracy of the search.
    mode : (n_dofs,) array or None
        The motion without stiffness, of unit modal mass; None where it was not found.
    refined : bool
        False where the search failed; then the place is interpolated between the ends of the step.
    """

    kind: str
    load_factor: float
    solution: Solution
    mode: np.ndarray | None
    refined: bool


def events_between(follower: Follower, a: Point, b: Point, length: float) -> list[Event]:
    """Events in a step, in the order of the path.

    At a limit point the rate of the load factor and one pivot change sign; pivots that change beyond that are bifurcations.
    """
    limit = a.rate * b.rate < 0
    found = []
    if limit:
        found.append(_search(follower, a, b, length, LIMIT, _limit_search(follower, a, b, length)))
    if abs(b.pivots - a.pivots) != limit:
        found.append(_search(follower, a, b, length, BIFURCATION, _pivot_search(follower, a, b, length)))
    return [event for _, event in sorted(found, key=lambda pair: pair[0])]


def _search(
    follower: Follower, a: Point, b: Point, length: float, kind: str,
    search: tuple[Callable[[], float], Callable[[Point, float], None]],
) -> tuple[float, Event]:  # fmt: skip
    """Asks ``search`` for a place and tells it the point found there, until the places hardly move."""
    place, tell = search
    at, point, refined = place(), None, False
    for _ in range(REFINEMENTS):
        found = follower.between(a, b, length, at)
        if found is None:
            break
        point = found
        tell(point, at)
        last, at = at, place()
        refined = abs(at - last) <= CLOSE * length
        if refined:
            break
    if point is None:
        point = a if at < length / 2 else b
    solution = Solution(follower.system, point.q, load_factor=point.load_factor)
    return at, Event(kind, point.load_factor, solution, softest_mode(follower, point)[1], refined)


def _limit_search(
    follower: Follower, a: Point, b: Point, length: float
) -> tuple[Callable[[], float], Callable[[Point, float], None]]:
    """The extremum of a cubic through the ends of a bracket, which shrinks."""
    left, right = (0.0, a.load_factor, a.rate), (length, b.load_factor, b.rate * follower.slopes(a, b))

    def place() -> float:
        (s0, y0, d0), (s1, y1, d1) = left, right
        h, rise = s1 - s0, (y1 - y0) / (s1 - s0)
        # y' = d0 + p t + r t^2 with t from 0 to 1, of opposite sign at the ends.
        p, r = 6 * rise - 4 * d0 - 2 * d1, 3 * (d0 + d1) - 6 * rise
        roots = np.roots([r, p, d0]) if r else np.array([-d0 / p])
        inside = [float(t.real) for t in roots if abs(t.imag) < 1e-12 and 0 <= t.real <= 1]
        return s0 + h * (inside[0] if inside else d0 / (d0 - d1))

    def tell(point: Point, at: float) -> None:
        nonlocal left, right
        news = (at, point.load_factor, point.rate * follower.slopes(a, point))
        left, right = (news, right) if point.rate * left[2] > 0 else (left, news)

    return place, tell


def _pivot_search(
    follower: Follower, a: Point, b: Point, length: float
) -> tuple[Callable[[], float], Callable[[Point, float], None]]:
    """The zero of the eigenvalue nearest to zero in a bracket of the place where the number of pivots changes."""
    left, right = (0.0, softest_mode(follower, a)[0]), (length, softest_mode(follower, b)[0])

    def place() -> float:
        (s0, y0), (s1, y1) = left, right
        share = y0 / (y0 - y1) if y0 * y1 < 0 else 0.5
        return s0 + (s1 - s0) * float(np.clip(share, 1e-3, 1 - 1e-3))

    def tell(point: Point, at: float) -> None:
        nonlocal left, right
        news = (at, softest_mode(follower, point)[0])
        left, right = (news, right) if point.pivots == a.pivots else (left, news)

    return place, tell


def softest_mode(follower: Follower, point: Point) -> tuple[float, np.ndarray | None]:
    """Eigenvalue of the tangent nearest to zero, against the mass, and its mode, by inverse iteration."""
    system = follower.system
    try:
        tangent = factored(system, point.q, point.load_factor, follower.solver)
    except SingularMatrix:
        return 0.0, None
    x = system.constraints.free_part(np.random.default_rng(0).standard_normal(point.q.size))
    for _ in range(12):
        x = follower.solver.solve(system.mass @ x)
        x /= np.sqrt(x @ (system.mass @ x))
    return float(x @ (tangent.matrix @ x)), x
