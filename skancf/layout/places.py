"""Which nodes and edges of a mesh a place means: see :mod:`skancf.supports.conditions`."""

from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.sparse.csgraph import connected_components

from skancf.errors import InputError, shown, vector, warn
from skancf.functions import is_function, true_at
from skancf.layout.ties import Ties
from skancf.surfaces import Interval, Surface, closed_bounds
from skancf.tolerances import MOVED_OF_EDGE, ONE_PLACE, SAME_POINT, SEVEN_DIGITS, SINGLE_PRECISION

Found = tuple[np.ndarray, np.ndarray]
NONE = np.empty(0, dtype=int)
OPENINGS = "openings"
"""Name of the edges of all openings, those of one are ``"opening 1"`` and so on."""


def _is_row(where: Any) -> bool:
    if isinstance(where, np.ndarray):
        return where.ndim > 0
    return isinstance(where, Sequence) and not isinstance(where, bytes)


class Places:
    """The places of a mesh on a surface.

    Attributes
    ----------
    mesh : skfem.MeshQuad
    surface : Surface
    ties : Ties
        Which nodes of the mesh are one.
    """

    mesh: skfem.MeshQuad
    surface: Surface
    ties: Ties

    def nodes_on(self, where: Any) -> np.ndarray:
        """Numbers of the nodes that ``where`` means: see :class:`~skancf.supports.Support`."""
        return self._with_unknowns(self.points_and_facets(where)[0])

    def facets_on(self, where: Any) -> np.ndarray:
        """Numbers of the boundary facets that ``where`` means."""
        facets = self.points_and_facets(where)[1]
        if not len(facets):
            raise InputError(f"where = {shown(where)} means no edge of the boundary; known names: {self.names()}")
        if hint := self.strays(where):
            warn(f"where = {hint}, where nothing acts; narrow the function if one edge is meant and others are in it")
        return facets

    def strays(self, where: Any) -> str | None:
        """What is said of a function that is true along edges of the boundary and at nodes inside too, as one with a wide
        tolerance is; None for one that is true everywhere."""
        if not is_function(where):
            return None
        nodes, facets = self.points_and_facets(where)
        inside = np.setdiff1d(nodes, self.ends(self.mesh.boundary_facets()))
        if not (len(facets) and len(inside)) or len(nodes) == len(self.ties.representative):
            return None
        x, y = self.mesh.p[:, self.ties.representative[inside[0]]]
        return (f"{shown(where)} is true along {len(facets)} edges of the boundary and at {len(inside)} nodes inside the "
                f"surface too, ({x:.6g}, {y:.6g}) for one")  # fmt: skip

    def names(self) -> list[str]:
        """Names that this mesh has."""
        holes = [OPENINGS, *(f"opening {k + 1}" for k in range(len(self.openings)))] if self.openings else []
        return sorted({*(self.mesh.boundaries or {}), "boundary", "corners", *holes})

    def points_and_facets(self, where: Any) -> Found:
        """Nodes and boundary facets of a name, points, or a function of (x, y); never without a node.

        Raises
        ------
        InputError
            For a place of another kind, an unknown name, and a place without a node.
        """
        try:
            return self._meant(where)
        except InputError as wrong:
            raise InputError(f"where = {shown(where)}: {wrong}") from wrong

    def _meant(self, where: Any) -> Found:
        if isinstance(where, str):
            return self._named(where)
        if is_function(where):
            return self._where_true(where)
        if not (_is_row(where) and len(where)):
            raise InputError(f"place {shown(where)}: give the name of a boundary, one of {self.names()}, a point (x, y), a "
                             "list of names and points, or a function of (x, y)")  # fmt: skip
        if all(isinstance(x, Real | Decimal) for x in where):
            return np.array([self.node_at(where)]), NONE
        nodes, facets = zip(*[self._meant(place) for place in where], strict=True)
        return np.unique(np.concatenate(nodes)), np.unique(np.concatenate(facets))

    def _named(self, name: str) -> Found:
        boundaries = self.mesh.boundaries or {}
        if name in boundaries:
            facets = np.asarray(boundaries[name])
            if not facets.size:
                raise InputError(f"boundary {name!r} has no edge on this mesh; the mesh's own names are at fault")
            return self._with_unknowns(self.ends(facets)), facets[~self._at_a_pole(facets)]
        if name == "boundary":
            if not len(self.outline):
                raise InputError("place 'boundary': this surface has none, it is closed all around; give a point (x, y) or "
                                 "a function of (x, y)")  # fmt: skip
            return np.unique(self.ends(self.outline)), self.outline
        if name in (OPENINGS, *(f"opening {k + 1}" for k in range(len(self.openings)))):
            if not self.openings:
                raise InputError(f"place 'openings': this mesh has none; it has {self.names()}")
            facets = np.concatenate(self.openings) if name == OPENINGS else self.openings[int(name.split()[1]) - 1]
            return np.unique(self.ends(facets)), facets
        if name == "corners":
            if not len(self.corners):
                raise InputError("place 'corners': this surface has none, no node belongs to one element only; give a point "
                                 "(x, y) or a function of (x, y)")  # fmt: skip
            return self.corners, NONE
        raise InputError(f"no boundary {name!r} on this mesh; it has {self.names()}")

    def _where_true(self, function: Callable[[np.ndarray, np.ndarray], Any]) -> Found:
        """A node is meant where the function is true at any of its places in the parameter plane."""
        mask = true_at("where", function, self.mesh.p)
        if not mask.any():
            raise InputError("the function given as a place is true at no node; give a tolerance, as in "
                             "lambda x, y: abs(x) < 1e-9")  # fmt: skip
        nodes = self._with_unknowns(self.ties.node_of[mask])
        if not nodes.size:
            raise InputError("the function given as a place is true at hanging nodes only, which move with the larger "
                             "element's edge; refine the mesh there")  # fmt: skip
        boundary = self.boundary
        return nodes, boundary[mask[self.mesh.facets[:, boundary]].all(axis=0)]

    def _with_unknowns(self, nodes: np.ndarray) -> np.ndarray:
        """Each node once; hanging ones, which follow the ends of their edge, are left out."""
        found = np.unique(nodes)
        return np.asarray(found[found >= 0])

    def ends(self, facets: np.ndarray) -> np.ndarray:
        """Nodes at the ends of facets, (2, m)."""
        return np.asarray(self.ties.node_of[self.mesh.facets[:, facets]])

    def facet_directions(self, facets: np.ndarray) -> np.ndarray:
        """Directions of facets in the parameter plane, (2, m), of unit length."""
        ends = self.mesh.p[:, self.mesh.facets[:, facets]]
        along = ends[:, 1] - ends[:, 0]
        return along / np.linalg.norm(along, axis=0)

    def in_extents(self, along: np.ndarray) -> np.ndarray:
        """Directions (2, ...) of the parameter plane, of unit length where each parameter counts in its extent: two of them
        compare so whatever the units."""
        counted = (along.T / np.ptp(self.mesh.p, axis=1)).T
        return np.asarray(counted / np.linalg.norm(counted, axis=0))

    @cached_property
    def boundary(self) -> np.ndarray:
        """Facets on the boundary of the surface: of one element only, no seam and no pole."""
        facets = self.mesh.boundary_facets()
        inner = self._at_a_pole(facets)
        for axis, (low, high) in self.closed_bounds().items():
            at = self.mesh.p[axis, self.mesh.facets[:, facets]]
            for end in (low, high):
                inner |= (np.abs(at - end) <= ONE_PLACE * (high - low)).all(axis=0)
        return np.asarray(facets[~inner])

    @property
    def outline(self) -> np.ndarray:
        """Facets on the boundary that are on no opening."""
        inside = np.concatenate([NONE, *self.openings])
        return np.asarray(self.boundary[~np.isin(self.boundary, inside)])

    @cached_property
    def openings(self) -> list[np.ndarray]:
        """Facets around each opening: connected edges that reach no bound of the parameters, by their lowest x, y."""
        ends, p = self.mesh.facets[:, self.boundary], self.mesh.p
        numbers = np.where(self.ties.node_of >= 0, self.ties.node_of, self.ties.node_of.max() + 1 + np.arange(p.shape[1]))
        nodes = numbers[ends]
        size = int(numbers.max()) + 1
        graph = sp.coo_matrix((np.ones(nodes.shape[1]), nodes), shape=(size, size))
        part = connected_components(graph, directed=False)[1][nodes[0]]
        open_axes = [axis for axis in (0, 1) if axis not in self.closed_bounds()]
        low, high = p.min(axis=1), p.max(axis=1)
        found = []
        for k in np.unique(part):
            facets = self.boundary[part == k]
            at = p[:, self.mesh.facets[:, facets]].reshape(2, -1)
            slack = ONE_PLACE * (high - low)
            if all((at[a] > low[a] + slack[a]).all() and (at[a] < high[a] - slack[a]).all() for a in open_axes):
                found.append((tuple(np.round((at.min(axis=1) - low) / (high - low), 9)), facets))
        return [facets for _, facets in sorted(found, key=lambda item: item[0])]

    def closed_bounds(self) -> dict[int, Interval]:
        """Bounds of the parameters that are closed, by their number."""
        return closed_bounds(self.surface)

    def _at_a_pole(self, facets: np.ndarray) -> np.ndarray:
        one, two = self.ends(facets)
        return np.asarray(one == two)

    @cached_property
    def corners(self) -> np.ndarray:
        """Nodes of one element only, which is convex, so that the boundary turns there.

        Corners that several elements share are not found, such as those that point inwards.
        """
        quads = self.ties.node_of[self.mesh.t]
        return np.flatnonzero(np.bincount(quads[quads >= 0]) == 1)

    def node_at(self, at: Any) -> int:
        """The node at a point of the parameter plane."""
        point = vector("point", at, 2)
        extent = np.ptp(self.mesh.p, axis=1)
        distance = np.linalg.norm((self.mesh.p - point[:, None]) / extent[:, None], axis=0)
        nearest, next_one = np.argpartition(distance, 1)[:2].tolist()
        # Single precision may have moved it, by less than would mistake its neighbour for it.
        rounded = min(max(SEVEN_DIGITS, SINGLE_PRECISION * np.abs(point / extent).max()), MOVED_OF_EDGE * distance[next_one])
        if distance[nearest] > max(SAME_POINT, rounded):
            raise InputError(
                f"point {tuple(point.tolist())}: no node of the mesh is there, the nearest is at "
                f"{tuple(self.mesh.p[:, nearest].tolist())}; choose a mesh with a node at the point"
            )
        if self.ties.node_of[nearest] < 0:
            raise InputError(f"point {tuple(point.tolist())}: the node there hangs in the middle of a larger element's edge "
                             "and cannot be held by itself; refine the mesh around it")  # fmt: skip
        return int(self.ties.node_of[nearest])
