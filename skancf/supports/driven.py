"""A support that moves as a rigid body."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import sin
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, shown, unit_vector, vector
from skancf.functions import called, is_function
from skancf.kernels.constants import VECTORS, R
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.supports.conditions import Support, edges
from skancf.theories.rows import Row, condition


@by_value
@dataclass(frozen=True)
class DrivenClamp(Support):
    r"""The nodes of a place are bonded to a rigid body that turns about a fixed axis and moves, as given in time.

    With the rotation :math:`R(\varphi)` about the axis, a point c of it, and the displacement u of the body,

    .. math:: r(t) = c + R(\varphi(t)) (X - c) + u(t), \qquad r_{,k}(t) = R(\varphi(t)) X_{,k},

    the same for :math:`r_{,xy}` and :math:`r_{,z}`, for any angle. The position at time t is R times the undeformed place: a
    run from rest begins with an angle and a displacement of zero.

    Statics has no time. It takes the body where it is at the time ``static``; without one it stands at the undeformed place,
    and :class:`~skancf.OutOfDepth` is warned once by ``solve``, ``solve_linear``, ``trace``, ``buckling``, ``adapt``, and
    ``modes`` without a state. Modes and buckling modes are about a body that stands still in any case.

    Unlike on the edge of a :class:`Clamp`, all nodal vectors follow, so the surface does not stretch at these nodes. The
    place may be an edge, single points, or a whole part of the surface, a hub for example.

    Parameters
    ----------
    where
        Place, as for other supports.
    axis : (3,)
        Direction of the axis; the angle is positive by the right hand.
    through : (3,)
        A point c of the axis in space (m).
    angle : callable, optional
        :math:`\varphi(t)` (rad). Default: the body does not turn.
    displacement : callable, optional
        u(t), three components (m). Default: none.
    static : float, optional
        The time (s) whose angle and displacement statics takes, at a load factor of one.

    Raises
    ------
    InputError
        For an axis that is no direction, an angle or displacement that is no function, and a body that neither turns nor
        moves; on a mesh, where another support holds a coordinate that the body moves; in a run, for values that are not
        finite.

    Examples
    --------
    >>> hub = sk.DrivenClamp("left", axis=(0.0, 0.0, 1.0), angle=lambda t: 3.0 * t**2)
    """

    holds = ("position", "normal")
    where: Any
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    through: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angle: Callable[[float], float] | None = None
    displacement: Callable[[float], Any] | None = None
    static: float | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        unit_vector("axis", self.axis, "a body turns about an axis; give its direction")
        vector("through", self.through, 3)
        if self.static is not None:
            number("static", self.static)
        for name, example in (("angle", "lambda t: 0.5 * t**2"), ("displacement", "lambda t: (0.0, 0.0, 0.1 * t**2)")):
            value = getattr(self, name)
            if value is not None and not is_function(value):
                raise InputError(f"{name} = {shown(value)}: give a function of time, as in {name}={example}")
        if self.angle is None and self.displacement is None:
            raise InputError("DrivenClamp without angle and displacement: give one of them, or use a Clamp")

    @cached_property
    def histories(self) -> tuple[Any, ...]:
        """cos - 1 and sin if it turns, and the displacements along x, y and z if it moves."""
        motion = RigidMotion(self.angle, self.displacement)
        return tuple(Component(motion, k, self.static) for k in self._components)

    @property
    def _components(self) -> list[int]:
        return [0, 1] * (self.angle is not None) + [2, 3, 4] * (self.displacement is not None)

    def rows(self, geometry: Geometry) -> list[Row]:
        rows, axis = [], unit_vector("axis", self.axis)
        node_of, representative = geometry.ties.node_of, geometry.ties.representative
        for node in sorted({int(node_of[mesh_node]) for mesh_node in edges(geometry, self.where)}):
            vectors = geometry.undeformed[node].copy()
            vectors[R] -= self.through
            turned = np.cross(axis, vectors)
            outwards = -np.cross(axis, turned)  # the part across the axis
            for kind in range(VECTORS):
                moved = np.eye(3) if kind == R else np.zeros((3, 3))
                values = np.column_stack([outwards[kind], turned[kind], moved])[:, self._components]
                rows += [
                    Row(int(representative[node]), condition({kind: 1.0}, direction), value, own=True)
                    for direction, value in zip(np.eye(3), values, strict=True)
                ]
        return rows


class RigidMotion:
    """cos - 1 and sin of an angle, and three displacements, at a time; the last ones are kept."""

    def __init__(self, angle: Callable[[float], float] | None, displacement: Callable[[float], Any] | None):
        self.angle, self.displacement = angle, displacement
        self._last: tuple[float, np.ndarray] | None = None

    def at(self, time: float) -> np.ndarray:
        if self._last is None or self._last[0] != time:
            out = np.zeros(5)
            if self.angle is not None:
                turn = number(f"angle at t = {time}", called("angle", self.angle, time))
                out[:2] = -2 * sin(turn / 2) ** 2, sin(turn)
            if self.displacement is not None:
                out[2:] = vector(f"displacement at t = {time}", called("displacement", self.displacement, time), 3)
            self._last = time, out
        return self._last[1]


class Component:
    """One of the functions of time of a rigid motion."""

    def __init__(self, motion: RigidMotion, number: int, static: float | None):
        self.motion, self.number, self.static = motion, number, static

    @property
    def at_rest(self) -> float:
        """What statics takes."""
        return 0.0 if self.static is None else self(self.static)

    @property
    def without_time(self) -> str | None:
        """What is said where it is asked for without a time; None where that is known."""
        if self.static is not None:
            return None
        return ("DrivenClamp: statics has no time, the body is taken at its undeformed place; say which time is meant by "
                "static=..., or take a Clamp or Prescribed")  # fmt: skip

    def __call__(self, time: float) -> float:
        return float(self.motion.at(time)[self.number])

    @property
    def name(self) -> str:
        """What the user calls it."""
        return "angle" if self.number < 2 else "displacement"

    @property
    def span(self) -> tuple[float, float] | None:
        """Times at which it is known, if it is a table's."""
        return getattr(getattr(self.motion, self.name), "span", None)

    @property
    def knots(self) -> tuple[float, ...]:
        """Times at which a step ends (s)."""
        return tuple(getattr(getattr(self.motion, self.name), "knots", ()))
