"""Points of an equilibrium path, and steps from one to the next."""

from dataclasses import dataclass, field, replace

import numpy as np

from skancf.linear import DirectSolver
from skancf.showing import short
from skancf.statics.conditioned import along_both, tangent_at
from skancf.statics.controls import Measure
from skancf.statics.corrections import none, stresses_along
from skancf.statics.newton import NewtonResult, newton
from skancf.statics.stopping import Constraint
from skancf.system.system import System

# Cosine between an increment and the tangents at its ends, below which it is not trusted to lie on one smooth branch.
SHARP = 0.8
# Distance from the interpolated state, relative to the step, beyond which a point between two belongs to another branch.
STRAY = 0.1


@dataclass(frozen=True)
class Point:
    """An equilibrium with the tangent of the path: ``direction`` of q and ``rate`` of the load factor per length; with
    conditions their ``multipliers``, too, and what these are ``pulled`` by per length."""

    q: np.ndarray
    load_factor: float
    pivots: int
    direction: np.ndarray
    rate: float
    multipliers: np.ndarray | None = None
    pulled: np.ndarray = field(default_factory=none)

    __repr__ = short


class Follower:
    """Makes steps along a path; keeps every attempt."""

    measure: Measure

    def __init__(self, system: System, solver: DirectSolver, rtol: float, max_iterations: int, mixed: bool):
        self.system, self.solver = system, solver
        self.rtol, self.max_iterations, self.mixed = rtol, max_iterations, mixed
        self.attempts: list[NewtonResult] = []

    def first_point(self, q: np.ndarray, load_factor: float, multipliers: np.ndarray | None = None) -> Point:
        """The start with its tangent.

        Raises
        ------
        SingularMatrix
        """
        tangent = tangent_at(self.system, q, load_factor, self.solver, multipliers=multipliers)
        along, pulled = along_both(self.system, q, load_factor, tangent)
        scale = self.measure.unit(along, None)
        return Point(q, load_factor, self.solver.negative_pivots, scale * along, scale, multipliers, scale * pulled)

    def step(self, a: Point, length: float) -> tuple[NewtonResult, Point | None, bool]:
        """A step from ``a``: the solve, the point if it is on the path, and whether it was refused as too sharp."""
        constraint = self._constraint(a, length)
        result = self._solve(a, a.q + length * a.direction, a.load_factor + length * a.rate, constraint)
        self.attempts.append(result)
        if not result.ok:
            return result, None, False
        b = self._point(result, a)
        sharp = self._sharp(a, b)
        return result, None if sharp else b, sharp

    def between(self, a: Point, b: Point, length: float, at: float) -> Point | None:
        """The point of the path at a distance from ``a``, on the way to ``b`` at ``length``; None if it fails."""
        q, load_factor = interpolate(self, a, b, length, at)
        result = self._solve(a, q, load_factor, self._constraint(a, at))
        if not result.ok or self.size(result.q - q) > STRAY * self.size(b.q - a.q):
            return None  # it may be on a branch that crosses
        return self._point(result, a)

    def at_condition(self, a: Point, b: Point, end: Constraint, share: float) -> tuple[Point, float] | None:
        """The point between ``a`` and ``b`` that meets an equation, and its distance from ``a``; None if it fails."""
        length = self.distance(a, b)
        q, load_factor = interpolate(self, a, b, length, share * length)
        result = self._solve(a, q, load_factor, replace(end, origin=a.q))
        self.attempts.append(result)
        if not result.ok:
            return None
        point = self._point(result, a)
        return None if self._sharp(a, point) else (point, self.distance(a, point))

    def _sharp(self, a: Point, b: Point) -> bool:
        """Does the way from ``a`` to ``b`` turn so much from the tangent at either that it may not be one branch?"""
        increment = b.q - a.q
        row = self.system.mass @ increment
        cosines = [row @ v / (self.size(increment) * self.size(v)) for v in (a.direction, b.direction)]
        return bool(min(cosines) < SHARP)

    def distance(self, a: Point, b: Point) -> float:
        """Length of the step from ``a`` to ``b``."""
        return float(self.measure.row(a.direction) @ (b.q - a.q))

    def slopes(self, a: Point, b: Point) -> float:
        """Factor that turns the tangent at ``b`` into derivatives with respect to the distance from ``a``."""
        return 1.0 / float(self.measure.row(a.direction) @ b.direction)

    def size(self, change: np.ndarray) -> float:
        """Root mean square displacement of the body, up to a factor."""
        return float(np.sqrt(change @ (self.system.mass @ change)))

    def _constraint(self, a: Point, length: float) -> Constraint:
        row = self.measure.row(a.direction)
        return Constraint(row, 0.0, float(row @ a.q) + length, a.q)

    def _solve(self, a: Point, q: np.ndarray, load_factor: float, constraint: Constraint) -> NewtonResult:
        stresses = stresses_along(self.system, a.q, q - a.q, load_factor) if self.mixed else None
        return newton(
            self.system, q, self.solver, load_factor=load_factor, rtol=self.rtol, max_steps=self.max_iterations,
            mixed=self.mixed, constraint=constraint, stresses=stresses,
            multipliers=a.multipliers,
        )  # fmt: skip

    def _point(self, result: NewtonResult, a: Point) -> Point:
        assert result.along is not None
        scale = self.measure.unit(result.along, result.q - a.q)
        return Point(result.q, result.load_factor, result.negative_pivots, scale * result.along, scale,
                     result.multipliers if result.multipliers.size else None, scale * result.pulled)  # fmt: skip


def interpolate(follower: Follower, a: Point, b: Point, length: float, at: float) -> tuple[np.ndarray, float]:
    """Cubic through two points with their tangents: state and load factor at a distance from ``a``."""
    s, scale = at / length, follower.slopes(a, b)
    values = (1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2 * length, s**2 * (3 - 2 * s), s**2 * (s - 1) * length * scale
    q = values[0] * a.q + values[1] * a.direction + values[2] * b.q + values[3] * b.direction
    factor = values[0] * a.load_factor + values[1] * a.rate + values[2] * b.load_factor + values[3] * b.rate
    return q, factor
