"""Conditions on the nodal vectors at a place.

A place is the name of a boundary, a list of names, a point (x, y) of the parameter plane or a list of them (nodes must be
there), or a function of (x, y) that is true at the nodes meant. Names are those of the mesh (``"left"``), ``"boundary"`` for
the outer boundary, which the edges of openings are no part of, ``"openings"`` for those, ``"opening 1"`` and so on for one
of them, in the order of their lowest x and then y, and ``"corners"``. An opening that reaches the outer boundary is a notch,
and its edges are part of that.

Points are single points, however many there are: between them slopes are free, and of three or more in a row along an edge
:class:`~skancf.OutOfDepth` is warned by supports that hold positions. A name means edges, and so does a function
of (x, y) where it is true at both ends of one: slopes along them are held too. A function that is true along edges and at
nodes inside as well, as one with a wide tolerance is, is warned of too, unless it is true everywhere.
"""

from typing import Any, ClassVar, NamedTuple

import numpy as np

from skancf.errors import InputError
from skancf.kernels.constants import R_X, R_Y, R
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, at_place
from skancf.showing import short
from skancf.terms.protocols import Assembly
from skancf.theories.rows import Row, condition
from skancf.tolerances import ONE_LINE
from skancf.vectors import cross


class Support:
    """What a problem knows of a support: conditions, springs or dashpots.

    Attributes
    ----------
    holds : tuple of str
        What it holds where it has a place ``where``, the kinds of a :class:`~skancf.supports.Singularity`: positions in all
        directions, in part, normals.

    Examples
    --------
    >>> class Grip(sk.supports.Support):
    ...     where = "left"
    ...     def rows(self, geometry):
    ...         return sk.Clamp("left").rows(geometry)
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[Grip()], loads=[sk.Gravity()])
    >>> solution = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff"))
    >>> print(f"{solution.reactions('left')[2]:.2f} N")
    76.98 N
    """

    holds: ClassVar[tuple[str, ...]] = ("part",)

    @property
    def histories(self) -> tuple[Any, ...]:
        """Functions of time of the values of its conditions; None is one that is constant."""
        return (getattr(self, "history", None),)

    def rows(self, geometry: Geometry) -> list[Row]:
        """The conditions on a given mesh."""
        return []

    def springs(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        """Elements (m,) and symmetric matrices (m, 48, 48) of their local vectors, component by component."""
        return []

    def dashpots(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        """The same of forces in proportion to velocities."""
        return []

    def singularities(self, geometry: Geometry) -> list[Singularity]:
        """What it does that is not smooth; by default what it ``holds`` at its place ``where``, if it has one, and with a
        ``kind`` of ``"hard"`` the tilt along its edges."""
        if not hasattr(self, "where"):
            return []
        kinds = self.holds + ("tilt",) * (getattr(self, "kind", None) == "hard")
        name = type(self).__name__
        return at_place(geometry, self.where, kinds, f"{'an' if name[0] in 'AEIOU' else 'a'} {name}")


Edges = dict[int, list[np.ndarray]]
"""For each mesh node of a place the directions, in the parameter plane, of its boundary edges there."""


def edges(geometry: Geometry, where: Any) -> Edges:
    """For each mesh node of a place the directions, in the parameter plane, of its boundary edges there.

    Hanging nodes are left out: they follow the ends of the larger edge, which belongs to the place as a whole.
    """
    nodes, facets = geometry.points_and_facets(where)
    node_of = geometry.ties.node_of
    ends = geometry.mesh.facets[:, facets]
    hanging, times = np.unique(ends[node_of[ends] < 0], return_counts=True)
    if (times < 2).any():
        place = tuple(geometry.mesh.p[:, hanging[times < 2][0]].tolist())
        raise InputError(f"support on {where!r}: the line ends at {place}, where a node hangs in the middle of a larger "
                         "element's edge and cannot be held by itself; refine the mesh around it")  # fmt: skip
    found: dict[int, list[tuple[float, float, np.ndarray]]] = {int(n): [] for n in ends.ravel()}
    directions = geometry.facet_directions(facets)
    compared = geometry.in_extents(directions)
    for pair, along, (x, y) in zip(ends.T.tolist(), directions.T, compared.T.tolist(), strict=True):
        for node in pair:
            if all(abs(x * known_y - y * known_x) > ONE_LINE for known_x, known_y, _ in found[node]):
                found[node].append((x, y, along))
    out = {node: [along for _, _, along in known] for node, known in found.items() if node_of[node] >= 0}
    alone = np.setdiff1d(nodes, node_of[list(out)] if out else [])
    return {**out, **{int(n): [] for n in np.flatnonzero(np.isin(node_of, alone))}}


def held_along(place: Edges, directions: np.ndarray) -> list[Row]:
    """Positions held in some directions of space, with the slopes along the edges of the place."""
    rows = []
    known: dict[bytes, np.ndarray] = {}  # nodes along a straight edge are alike
    for node, tangents in place.items():
        key = b"".join(t.tobytes() for t in tangents)
        if key not in known:
            kinds = [{R: 1.0}, *[{R_X: t[0], R_Y: t[1]} for t in tangents]]
            known[key] = np.array([condition(kind, direction) for direction in directions for kind in kinds])
        rows += [Row(node, a) for a in known[key]]
    return rows


def single_points(geometry: Geometry, place: Edges) -> list[int]:
    """A mesh node for each node of a place that is on none of its edges."""
    alone = [node for node, tangents in place.items() if not tangents]
    return alone if not alone else [alone[k] for k in np.unique(geometry.ties.node_of[alone], return_index=True)[1]]


def slopes_or_tangents(geometry: Geometry, node: int) -> tuple[np.ndarray, bool]:
    """The slopes r_x and r_y at a mesh node, or the two tangents that a pole has of its own (then True): (2, 3)."""
    pole = geometry.ties.poles.get(int(geometry.ties.node_of[node]))
    return (geometry.undeformed_at(node)[[R_X, R_Y]], False) if pole is None else (pole, True)


def space_tangent(geometry: Geometry, node: int, along: np.ndarray) -> np.ndarray:
    """Unit vector in space of a direction of the parameter plane at a mesh node."""
    tangent = along @ geometry.undeformed_at(node)[[R_X, R_Y]]
    return np.asarray(tangent / np.linalg.norm(tangent))


class SpotOfMesh(NamedTuple):
    """The undeformed surface at a node of a mesh: see :class:`skancf.theories.rows.Spot`."""

    geometry: Geometry
    node: int

    def __repr__(self) -> str:
        return short(self)

    @property
    def normal(self) -> np.ndarray:
        return self.geometry.normal_at(self.node)

    @property
    def normal_slopes(self) -> np.ndarray:
        return self.geometry.normal_slopes_at(self.node)

    @property
    def slopes(self) -> np.ndarray:
        return np.asarray(self.geometry.undeformed_at(self.node)[[R_X, R_Y]])

    @property
    def vectors(self) -> np.ndarray:
        return slopes_or_tangents(self.geometry, self.node)[0]

    @property
    def own(self) -> bool:
        return slopes_or_tangents(self.geometry, self.node)[1]

    def tangent(self, along: np.ndarray) -> np.ndarray:
        return space_tangent(self.geometry, self.node, along)


def no_tilt_along(geometry: Geometry, place: Edges) -> list[Row]:
    """The normal does not tilt along the edge."""
    spots = [(SpotOfMesh(geometry, node), tangents) for node, tangents in place.items()]
    return [row for spot, tangents in spots for along in tangents for row in geometry.theory.no_tilt(spot, along)]


def no_turn_about(geometry: Geometry, place: Edges) -> list[Row]:
    """The normal does not turn about the edge; at single points not at all."""
    nodes = [(node, tangents) for node, tangents in place.items() if tangents]
    nodes += [(node, []) for node in single_points(geometry, place)]
    return [row for node, tangents in nodes for row in geometry.theory.no_turn(SpotOfMesh(geometry, node), tangents)]


def no_drilling(geometry: Geometry, place: Edges) -> list[Row]:
    r"""The surface does not turn about its normal at the single points of a place; its strain there is free.

    With orthonormal tangents t1 and t2 of the undeformed surface, and derivatives along them,
    :math:`t_2 \cdot r_{,1} - t_1 \cdot r_{,2} = 0`: where the normal is held, the stretch is symmetric then.
    """
    rows = []
    for node in single_points(geometry, place):
        slopes, own = slopes_or_tangents(geometry, node)
        t1 = slopes[0] / np.linalg.norm(slopes[0])
        t2 = cross(geometry.normal_at(node), t1)
        to_frame = np.linalg.inv(slopes @ np.stack([t1, t2]).T)  # r_,1 and r_,2 of r_x and r_y
        x, y = to_frame[0, :, None] * t2 - to_frame[1, :, None] * t1
        rows.append(Row(node, condition({R_X: x, R_Y: y}, t1), own=own))
    return rows
