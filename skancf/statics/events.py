"""Limit points and bifurcation points between two points of a path."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skancf.equality import by_value
from skancf.showing import in_brackets, summary
from skancf.solution import Solution
from skancf.statics.critical import critical_mode
from skancf.statics.points import Follower, Point, interpolate
from skancf.tolerances import ROUNDED_PRODUCT, ZERO_IN_BRACKET

LIMIT, BIFURCATION = "limit point", "bifurcation"
REFINEMENTS = 8
# Of the step in which an event was found: the error of the last, linear extrapolation is its square.
CLOSE = 1e-3


@by_value
@dataclass(frozen=True)
class Event:
    """A point of the path where its tangent stiffness is singular; its symmetric part, for a bifurcation.

    Attributes
    ----------
    kind : str
        "limit point", where the load factor has a maximum or a minimum, or "bifurcation", where another branch crosses.
    load_factor : float
    solution : Solution
        The equilibrium there; interpolated where ``refined`` is false.
    mode : (n_dofs,) array
        The motion without stiffness, of unit modal mass.
    refined : bool
        Whether the search found it, to a millionth of the step in which it lies.

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
    >>> event = sk.trace(system, until=1.0, progress=False).events[0]
    >>> print(event.kind, f"{event.load_factor:.2f}", event.refined)
    limit point 0.74 True
    """

    kind: str
    load_factor: float
    solution: Solution
    mode: np.ndarray
    refined: bool

    __repr__ = in_brackets

    @summary
    def __str__(self) -> str:
        return f"{self.kind} at load factor {self.load_factor:.5g}"


def events_between(follower: Follower, a: Point, b: Point, length: float) -> list[Event]:
    """Events in a step, in the order of the path.

    At a limit point the rate of the load factor changes its sign; pivots that change beyond that are bifurcations.
    """
    limit = a.rate * b.rate < 0
    found = []
    if limit:
        found.append(_search(follower, a, b, length, LIMIT, _limit_search(follower, a, b, length)))
    if abs(b.pivots - a.pivots) != limit:
        found.append(_search(follower, a, b, length, BIFURCATION, _pivot_search(follower, a, b, length, limit)))
    return [event for _, event in sorted(found, key=lambda pair: pair[0])]


def _search(
    follower: Follower, a: Point, b: Point, length: float, kind: str,
    search: tuple[Callable[[], float], Callable[[Point, float], None]],
) -> tuple[float, Event]:  # fmt: skip
    """Asks ``search`` for a place and tells it the point found there, until the places hardly move."""
    place, tell = search
    nearest, at, refined = (0.0, a), place(), False
    for _ in range(REFINEMENTS):
        found = follower.between(a, b, length, at)
        if found is None:  # the tangent may be exactly singular there
            at += CLOSE / 2 * length * (1 if at < length / 2 else -1)
            found = follower.between(a, b, length, at)
        if found is None:
            break
        nearest = at, found
        tell(found, at)
        last, at = at, place()
        refined = bool(abs(at - last) <= CLOSE * length)
        if refined:
            break
    solution = _extrapolated(follower, a, nearest, at) if refined else _interpolated(follower, a, b, length, at)
    mode = critical_mode(follower.system, follower.solver, solution).shape
    return at, Event(kind, solution.load_factor, solution, mode, refined)


def _extrapolated(follower: Follower, a: Point, nearest: tuple[float, Point], at: float) -> Solution:
    """Linearly from a point very near."""
    way = (at - nearest[0]) * follower.slopes(a, nearest[1])
    point = nearest[1]
    multipliers = None if point.multipliers is None else point.multipliers + way * point.pulled
    return Solution(
        follower.system, point.q + way * point.direction, load_factor=point.load_factor + way * point.rate,
        multipliers=multipliers,
    )  # fmt: skip


def _interpolated(follower: Follower, a: Point, b: Point, length: float, at: float) -> Solution:
    q, load_factor = interpolate(follower, a, b, length, at)
    return Solution(follower.system, q, load_factor=load_factor, multipliers=a.multipliers)


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
        inside = [float(t.real) for t in roots if abs(t.imag) < ROUNDED_PRODUCT and 0 <= t.real <= 1]
        return s0 + h * (inside[0] if inside else d0 / (d0 - d1))

    def tell(point: Point, at: float) -> None:
        nonlocal left, right
        news = (at, point.load_factor, point.rate * follower.slopes(a, point))
        left, right = (news, right) if point.rate * left[2] > 0 else (left, news)

    return place, tell


def _pivot_search(
    follower: Follower, a: Point, b: Point, length: float, limit: bool
) -> tuple[Callable[[], float], Callable[[Point, float], None]]:
    """The zero of the eigenvalue nearest to zero in a bracket of the place where the number of pivots changes.

    With a limit point in the same step, motions on which the load does work are left out.
    """

    def soft(point: Point) -> tuple[float, int]:
        mode = critical_mode(follower.system, follower.solver, point, without_work=limit)
        return mode.eigenvalue, mode.negative

    value, before = soft(a)
    left, right = (0.0, value), (length, soft(b)[0])

    def place() -> float:
        (s0, y0), (s1, y1) = left, right
        # Of one sign: two modes, so halve the bracket; or one end is the zero up to rounding, so take that.
        zero = min(abs(y0), abs(y1)) <= ZERO_IN_BRACKET * max(abs(y0), abs(y1))
        share = abs(y0) / (abs(y0) + abs(y1) or 1.0) if y0 * y1 < 0 or zero else 0.5
        return s0 + (s1 - s0) * share

    def tell(point: Point, at: float) -> None:
        nonlocal left, right
        value, negative = soft(point)
        left, right = ((at, value), right) if negative == before else (left, (at, value))

    return place, tell
