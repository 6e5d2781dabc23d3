"""Supports that hold nodal coordinates."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.errors import InputError, shown, unit_vector, warn
from skancf.kernels.constants import R_X, R_Y, R
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.supports.alone import edges_or_points
from skancf.supports.conditions import SpotOfMesh, Support, edges, held_along, no_drilling, no_tilt_along, no_turn_about
from skancf.supports.plane import check_planes
from skancf.theories.rows import Row, across, condition
from skancf.vectors import cross


def checked_kind(kind: str) -> str:
    if not isinstance(kind, str) or kind not in ("soft", "hard"):
        raise InputError(f"kind = {shown(kind)}: a simple support is 'soft' (the director is free to tilt along the edge) "
                         "or 'hard' (it is not)")  # fmt: skip
    return kind


@by_value
@dataclass(frozen=True)
class Pin(Support):
    """Positions held, as by a hinge along an edge or a ball joint at a point; rotations are free.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, [sk.Pin("corners")], [sk.SurfaceLoad((0, 0, -1000.0))])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 4), "kirchhoff"))
    >>> print(solution.reactions("corners").round(6)[2], "N")
    1000.0 N
    """

    holds = ("position",)
    where: Any

    __repr__ = short

    def rows(self, geometry: Geometry) -> list[Row]:
        return held_along(edges_or_points("Pin", geometry, self.where), np.eye(3))


@by_value
@dataclass(frozen=True)
class Clamp(Support):
    """Positions and normals (directors) held along an edge.

    At single points the position, the normal and the rotation about it are held; the surface may stretch there.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> tip = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1000 * tip[2]:.4f} mm")  # F L^3 / 3 E I
    1.9048 mm
    """

    holds = ("position", "normal")
    where: Any

    __repr__ = short

    def rows(self, geometry: Geometry) -> list[Row]:
        place = edges_or_points("Clamp", geometry, self.where)
        return held_along(place, np.eye(3)) + no_turn_about(geometry, place) + no_drilling(geometry, place)


@by_value
@dataclass(frozen=True)
class NoRotation(Support):
    """The normal (director) does not turn about the edge, at single points not at all; positions are free.

    With :class:`Roller` a clamped edge that is free to slide in the surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> strip = sk.Problem(
    ...     sk.Rectangle(1.0, 0.1), 0.01, steel,
    ...     supports=[sk.Clamp("left"), sk.NoRotation("right")],
    ...     loads=[sk.EdgeLoad("right", (0, 0, 100.0))],
    ... )
    >>> tip = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1000 * tip[2]:.4f} mm")  # F L^3 / 12 E I
    0.4762 mm
    """

    holds = ("normal",)
    where: Any

    __repr__ = short

    def rows(self, geometry: Geometry) -> list[Row]:
        place = edges(geometry, self.where)
        if hint := geometry.strays(self.where):
            warn(f"NoRotation: where = {hint}; narrow the function if an edge alone is meant")
        return no_turn_about(geometry, place)


@by_value
@dataclass(frozen=True)
class SimpleSupport(Support):
    """A hinged edge: positions held, rotation about the edge free.

    Parameters
    ----------
    where
        Place.
    kind : {"soft", "hard"}
        ``"hard"`` also keeps the director from tilting along the edge, as a diaphragm does; most series solutions are for
        hard supports. ``"soft"`` leaves it free.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, [sk.SimpleSupport("boundary")])
    >>> modes = sk.modes(plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff"), 1)
    >>> print(f"{modes.frequencies[0]:.1f} Hz")
    49.2 Hz
    """

    holds = ("position",)
    where: Any
    kind: str = "soft"

    __repr__ = short

    def __post_init__(self) -> None:
        checked_kind(self.kind)

    def rows(self, geometry: Geometry) -> list[Row]:
        place = edges_or_points("SimpleSupport", geometry, self.where)
        rows = held_along(place, np.eye(3))
        return rows + no_tilt_along(geometry, place) if self.kind == "hard" else rows


IN_PLANE, ASKEW = 1e-3, 0.9
"""Cosines between a direction and the normal below which it lies in the surface, or does not hold the deflection alone."""


@by_value
@dataclass(frozen=True)
class Roller(Support):
    """Positions held in one direction of space only (by default z).

    Parameters
    ----------
    where
        Place.
    direction : (3,)
        Direction in which it is held.
    kind : {"soft", "hard"}
        As for :class:`SimpleSupport`.

    Raises
    ------
    InputError
        On a mesh: in theory `kirchhoff`, for a hard one in a direction that lies in the surface.

    Warns
    -----
    OutOfDepth
        On a mesh: there, for a hard one in a direction that is askew to the surface all along the place.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> pressed = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Roller("boundary"), sk.Roller("left", (1, 0, 0)), sk.Roller((0.0, 0.0), (0, 1, 0))],
    ...     loads=[sk.EdgeLoad("right", (-1e5, 0.0, 0.0))],
    ... )
    >>> buckled = sk.buckling(pressed.on(sk.meshes.uniform(pressed.surface, 6, 6), "kirchhoff"), 1)
    >>> print(f"{buckled.load_factors[0]:.2f}")
    7.59
    """

    where: Any
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    kind: str = "soft"

    __repr__ = short

    def __post_init__(self) -> None:
        checked_kind(self.kind)
        unit_vector("direction", self.direction, "a roller needs a direction in which it holds")

    def rows(self, geometry: Geometry) -> list[Row]:
        place, direction = edges_or_points("Roller", geometry, self.where), unit_vector("direction", self.direction)
        rows = held_along(place, direction[None])
        if self.kind != "hard":
            return rows
        upright = max((abs(geometry.normal_at(node) @ direction) for node in place), default=1.0)
        if not geometry.theory.shear and upright < ASKEW:
            said = f"Roller({self.where!r}, {self.direction}, kind='hard'): in theory 'kirchhoff' the normal tilts along an"
            way_out = "hold the deflection too, take kind='soft', or theory 'full'"
            if upright < IN_PLANE:
                raise InputError(f"{said} edge as the edge itself does, and this direction, in the surface, leaves the edge "
                                 f"free to bend: {way_out}")  # fmt: skip
            warn(
                f"{said} edge as the edge itself does, which this direction, askew to the surface, does not hold: the tilt "
                f"is held at nodes only, and the answer depends on how many there are; {way_out}",
            )
        return rows + no_tilt_along(geometry, place)


@by_value
@dataclass(frozen=True)
class Symmetry(Support):
    """The edge lies in a plane of symmetry of the undeformed body and stays in it; edges that meet in a corner have theirs.

    Raises
    ------
    InputError
        On a mesh: for a point, an edge that lies in no plane or along which the surface is not normal to it, and in the thin
        theory where lines of the parameters do not cross the edge at right angles.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> quarter = sk.Problem(
    ...     sk.Rectangle(0.5, 0.5), 0.01, steel,
    ...     supports=[sk.Clamp("left"), sk.Clamp("bottom"), sk.Symmetry("right"), sk.Symmetry("top")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> solution = sk.solve_linear(quarter.on(sk.meshes.uniform(quarter.surface, 6, 6), "kirchhoff"))
    >>> middle = solution.displacement((0.5, 0.5))
    >>> print(f"{1000 * middle[2]:.4f} mm")
    -0.0658 mm
    """

    holds = ("mirror",)
    where: Any

    __repr__ = short

    def rows(self, geometry: Geometry) -> list[Row]:
        rows = []
        check_planes(geometry, self.where)
        for node, tangents in edges(geometry, self.where).items():
            if not tangents:
                raise InputError(f"Symmetry({self.where!r}): a plane of symmetry needs an edge, not a point")
            for along in tangents:
                rows += self._rows_at(geometry, node, along)
        return rows

    def _rows_at(self, geometry: Geometry, node: int, along: np.ndarray) -> list[Row]:
        spot = SpotOfMesh(geometry, node)
        out = cross(spot.tangent(along), spot.normal)
        rows = [Row(node, condition({R: 1.0}, out)), Row(node, condition({R_X: along[0], R_Y: along[1]}, out))]
        held = geometry.theory.symmetric(spot, along)
        if held is None:
            raise InputError(f"Symmetry({self.where!r}): the lines of the parameter {'xy'[across(along) - 1]} do not cross "
                             "the edge at right angles; use a surface on which they do")  # fmt: skip
        return rows + held
