"""A mesh on a surface for a theory: undeformed nodal coordinates, local vectors, where things are."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import skfem

from skancf.assembly.maps import local_maps
from skancf.assembly.ties import find_ties
from skancf.elements.nodal import nodal_jacobian, require_aligned
from skancf.elements.quad_ancf import gauss
from skancf.elements.reference import CORNERS
from skancf.errors import InputError, vector
from skancf.meshes import check_mesh
from skancf.surfaces import Surface, check_regular, closed_directions, normal
from skancf.theories import Theory


class Geometry:
    """Everything about a mesh on a surface that does not depend on material, supports or loads.

    Attributes
    ----------
    ties : Ties
        Which nodes of the mesh are one.
    nodes : (n_elements, 4) int array
        The nodes with the unknowns, of each element; those of the mesh are ``mesh.t``.
    points : (2, n_nodes) array
        Nodes in the parameter plane.
    undeformed : (n_nodes, 4, 3) array
        Nodal coordinates of the undeformed surface: r, r_x, r_y and r_z or r_xy; at a pole r and two tangents.
    side : (n_elements,) array
        1 where corners are numbered counter-clockwise, else -1.
    maps : Maps
        From nodal coordinates to local vectors.
    """

    def __init__(self, mesh: skfem.MeshQuad, surface: Surface, theory: Theory):
        check_mesh(mesh)
        if theory.twist:
            require_aligned(mesh)
        self.mesh, self.surface, self.theory = mesh, surface, theory
        self.ties = find_ties(mesh, surface, theory.twist)
        self.nodes = np.ascontiguousarray(self.ties.node_of[mesh.t].T, dtype=np.int32)
        self.points = mesh.p[:, self.ties.representative]
        jacobian = nodal_jacobian(mesh)
        self.side = np.sign(np.linalg.det(np.moveaxis(jacobian[:, :, 0], -1, 0)))
        self.maps = local_maps(mesh, jacobian, theory, self.ties.mix, self.nodes)
        self.undeformed = self._undeformed()
        check_regular(surface, *self.parameters(theory.quadrature[0]).reshape(2, -1))

    def _undeformed(self) -> np.ndarray:
        x, y = self.points
        vectors = [self.surface.position(x, y), *self.surface.derivatives(x, y), self.theory.fourth(self.surface, x, y)]
        nodal = np.ascontiguousarray(np.stack(vectors).transpose(2, 0, 1))
        for node, tangents in self.ties.poles.items():
            nodal[node, 1:3] = tangents
            nodal[node, 3] = 0.0 if self.theory.twist else self._normal_at_pole(node, tangents)
        return nodal

    def _normal_at_pole(self, node: int, tangents: np.ndarray) -> np.ndarray:
        """The normal there, on the side of those beside it."""
        element = int(np.flatnonzero((self.nodes == node).any(axis=1))[0])
        beside = normal(self.surface, *self.parameters(np.array([[0.5], [0.5]]), np.array([element]))[:, 0])[:, 0]
        n = np.cross(*tangents)
        return np.asarray(n / np.linalg.norm(n) * np.sign(n @ beside))

    @property
    def n_nodes(self) -> int:
        return self.points.shape[1]

    @property
    def n_elements(self) -> int:
        return len(self.nodes)

    def local(self, q: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Local vectors (n, 16, 3) of nodal coordinates (n_nodes, 4, 3)."""
        elements = np.arange(self.n_elements) if elements is None else np.asarray(elements)
        index, row, node, kind, value = self._triples(elements)
        out = np.zeros((len(elements), 16, 3))
        np.add.at(out, (index, row), value[:, None] * q[node, kind])
        return out

    def nodal(self, local: np.ndarray, elements: np.ndarray) -> np.ndarray:
        """Nodal forces (n_nodes, 4, 3) of forces on local vectors (n, 16, 3): the transpose of :meth:`local`."""
        index, row, node, kind, value = self._triples(np.asarray(elements))
        out = np.zeros((self.n_nodes, 4, 3))
        np.add.at(out, (node, kind), value[:, None] * local[index, row])
        return out

    def undeformed_at(self, mesh_node: int) -> np.ndarray:
        """r, r_x, r_y and the fourth vector of the undeformed surface at a node of the mesh, (4, 3)."""
        return np.asarray(self.ties.mix[mesh_node] @ self.undeformed[self.ties.node_of[mesh_node]])

    def normal_at(self, mesh_node: int) -> np.ndarray:
        """Unit normal of the undeformed surface at a node of the mesh, (3,)."""
        x, y = self.mesh.p[:, mesh_node]
        return np.asarray(normal(self.surface, np.array([x]), np.array([y]))[:, 0])

    def normal_slopes_at(self, mesh_node: int) -> np.ndarray:
        """Its derivatives n_x and n_y, (2, 3); zero at a pole, where they have no meaning."""
        x, y = self.mesh.p[:, mesh_node]
        slopes = np.stack(self.surface.derivatives(x, y))
        xx, xy, yy = self.surface.second_derivatives(x, y)
        bending = np.array([[xx, xy], [xy, yy]]) @ self.normal_at(mesh_node)
        metric = slopes @ slopes.T
        if np.linalg.det(metric) < 1e-18 * np.trace(metric) ** 2:
            return np.zeros((2, 3))
        return np.asarray(-bending @ np.linalg.solve(metric, slopes))

    def dense_map(self, element: int) -> np.ndarray:
        """From the nodal vectors of an element, corner by corner, to its local vectors: (16, 16)."""
        maps, out = self.maps, np.zeros((16, 16))
        part = slice(maps.pointer[element], maps.pointer[element + 1])
        out[maps.rows[part], 4 * maps.corners[part] + maps.kinds[part]] = maps.values[part]
        return out

    def inside(self, points: np.ndarray) -> np.ndarray:
        """Local points (2, n) where strains are wanted; a little inside where a pole would make the surface singular."""
        return 0.5 + 0.99 * (points - 0.5) if self.ties.poles else points

    def _triples(self, elements: np.ndarray) -> tuple[np.ndarray, ...]:
        maps = self.maps
        counts = np.diff(maps.pointer)[elements]
        index = np.repeat(np.arange(len(elements)), counts)
        triple = maps.pointer[elements][index] + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        node = self.nodes[elements[index], maps.corners[triple]]
        return index, maps.rows[triple], node, maps.kinds[triple], maps.values[triple]

    @cached_property
    def undeformed_local(self) -> np.ndarray:
        return self.local(self.undeformed)

    def parameters(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Parameters (2, n_elements, n) of local points (2, n)."""
        xi, eta = points
        bilinear = np.stack([np.where(a, xi, 1 - xi) * np.where(b, eta, 1 - eta) for a, b in CORNERS])
        corners = self.mesh.p[:, self.mesh.t if elements is None else self.mesh.t[:, elements]]
        return np.einsum("dce,cn->den", corners, bilinear)

    def tangents(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Tangent along the parameter x at local points (2, n): (3, n_elements, n)."""
        return self.surface.derivatives(*self.parameters(points, elements))[0]

    def nodes_on(self, where: Any) -> np.ndarray:
        """Numbers of the nodes that ``where`` means: see :class:`~skancf.supports.Support`."""
        return np.unique(self.points_and_facets(where)[0])

    def facets_on(self, where: Any) -> np.ndarray:
        """Numbers of the boundary facets that ``where`` means."""
        facets = self.points_and_facets(where)[1]
        if not len(facets):
            raise InputError(f"{where!r} means no edge of the boundary; known names: {self.names()}")
        return facets

    def names(self) -> list[str]:
        return sorted({*(self.mesh.boundaries or {}), "boundary", "corners"})

    def points_and_facets(self, where: Any) -> tuple[np.ndarray, np.ndarray]:
        """Nodes and boundary facets of a name, points, or a function of (x, y)."""
        none = np.empty(0, dtype=int)
        if not (callable(where) or (isinstance(where, (str, Sequence, np.ndarray)) and len(where))):
            raise InputError(f"place {where!r}: give the name of a boundary, one of {self.names()}, a point (x, y), a list "
                             "of names and points, or a function of (x, y)")  # fmt: skip
        if isinstance(where, str):
            facets = self._facets_named(where)
            return (self.corners, none) if facets is None else (np.unique(self.ends(facets)), facets)
        if callable(where):
            mask = np.broadcast_to(np.asarray(where(*self.points), dtype=bool), (self.n_nodes,))
            if not mask.any():
                raise InputError("the function given as a place is true at no node; give a tolerance, as in "
                                 "lambda x, y: abs(x) < 1e-9")  # fmt: skip
            boundary = self.boundary
            return np.flatnonzero(mask), boundary[mask[self.ends(boundary)].all(axis=0)]
        if all(isinstance(x, (int, float, np.number)) for x in where):
            return np.array([self.node_at(where)]), none
        parts = [self.points_and_facets(place) for place in where]
        return tuple(np.unique(np.concatenate(part)) for part in zip(*parts, strict=True))  # type: ignore

    def _facets_named(self, name: str) -> np.ndarray | None:
        boundaries = self.mesh.boundaries or {}
        if name in boundaries:
            facets = np.asarray(boundaries[name])
            if not facets.size:
                raise InputError(f"boundary {name!r} has no edge on this mesh; the mesh's own names are at fault")
            return facets
        if name == "boundary":
            return self.boundary
        if name == "corners":
            return None
        raise InputError(f"no boundary {name!r} on this mesh; it has {self.names()}")

    def ends(self, facets: np.ndarray) -> np.ndarray:
        """Nodes at the ends of facets, (2, m)."""
        return np.asarray(self.ties.node_of[self.mesh.facets[:, facets]])

    @cached_property
    def boundary(self) -> np.ndarray:
        """Facets on the boundary of the surface: of one element only, no seam and no pole."""
        facets = self.mesh.boundary_facets()
        ends = np.sort(self.ends(facets), axis=0)
        _, place, counts = np.unique(ends, axis=1, return_inverse=True, return_counts=True)
        return np.asarray(facets[(counts[place.ravel()] == 1) & (ends[0] != ends[1])])

    @cached_property
    def corners(self) -> np.ndarray:
        """Boundary nodes that belong to one element only, in which the boundary turns."""
        return np.flatnonzero(np.bincount(self.nodes.ravel(), minlength=self.n_nodes) == 1)

    def node_at(self, at: Any) -> int:
        """The node at a point of the parameter plane."""
        point = vector("point", at, 2)
        distance = np.linalg.norm(self.mesh.p - point[:, None], axis=0)
        nearest = int(np.argmin(distance))
        if distance[nearest] > 1e-8 * np.ptp(self.mesh.p, axis=1).max():
            raise InputError(
                f"point {tuple(point.tolist())}: no node of the mesh is there, the nearest is at "
                f"{tuple(self.mesh.p[:, nearest].tolist())}; choose a mesh with a node at the point"
            )
        return int(self.ties.node_of[nearest])

    @cached_property
    def _finder(self) -> Any:
        return self.mesh.element_finder()

    def locate(self, at: Any) -> tuple[int, np.ndarray]:
        """The element that holds a point of the parameter plane, and the point's local coordinates (2,).

        Across the seam of a closed parameter it goes on at the other end.
        """
        point = self._within(vector("point", at, 2))
        outside = InputError(
            f"point {tuple(point.tolist())} lies outside the surface; in the parameter plane the mesh "
            f"spans {self.mesh.p.min(axis=1).tolist()} to {self.mesh.p.max(axis=1).tolist()}"
        )
        try:
            element = int(self._finder(point[:1], point[1:])[0])
        except ValueError as error:
            raise outside from error
        local = _inverse_bilinear(self.mesh.p[:, self.mesh.t[:, element]], point)
        if np.any((local < -1e-8) | (local > 1 + 1e-8)):
            raise outside
        return element, np.clip(local, 0.0, 1.0)

    def _within(self, point: np.ndarray) -> np.ndarray:
        """The same point of the surface, closed parameters within their bounds."""
        out = point.copy()
        for axis, closed in enumerate(closed_directions(self.surface)):
            if closed:
                low, high = self.surface.bounds[axis]  # type: ignore[attr-defined]
                if not low <= point[axis] <= high:
                    out[axis] = low + (point[axis] - low) % (high - low)
        return out

    def edge_points(self, facets: np.ndarray, n: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gauss points (m, 2, n) of boundary facets in their elements, tangents (m, 2) in the reference square that run
        counter-clockwise there, and weights (n,)."""
        elements, (s, w) = self.mesh.f2t[0, facets], gauss(n)
        corners = [np.argmax(self.mesh.t[:, elements] == self.mesh.facets[k, facets], axis=0) for k in (0, 1)]
        swap = (corners[0] + 1) % 4 != corners[1]
        start, end = np.where(swap, corners[1], corners[0]), np.where(swap, corners[0], corners[1])
        tangents = CORNERS[end] - CORNERS[start]
        return CORNERS[start][:, :, None] + tangents[:, :, None] * s, tangents, w

    def edge_quadrature(self, facets: np.ndarray, n: int = 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Elements (m,), local points (m, 2, n) and weights times length (m, n) of boundary facets."""
        elements = self.mesh.f2t[0, facets]
        points, tangents, w = self.edge_points(facets, n)
        lengths = np.empty((len(facets), n))
        for k, e in enumerate(elements):
            along = self.theory.jets(self.undeformed_local[[e]], points[k])[:2, :, 0]
            lengths[k] = w * np.linalg.norm(np.tensordot(tangents[k], along, 1), axis=0)
        return elements, points, lengths

    def facet_directions(self, facets: np.ndarray) -> np.ndarray:
        """Directions of facets in the parameter plane, (2, m), of unit length."""
        ends = self.mesh.p[:, self.mesh.facets[:, facets]]
        along = ends[:, 1] - ends[:, 0]
        return along / np.linalg.norm(along, axis=0)


def _inverse_bilinear(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Local coordinates of a point in a quad (2, 4) by Newton's method."""
    local = np.array([0.5, 0.5])
    for _ in range(30):
        xi, eta = local
        shape = np.array([(1 - xi) * (1 - eta), xi * (1 - eta), xi * eta, (1 - xi) * eta])
        slopes = np.array([[eta - 1, 1 - eta, eta, -eta], [xi - 1, -xi, xi, 1 - xi]])
        step = np.linalg.solve(corners @ slopes.T, point - corners @ shape)
        local = local + step
        if np.abs(step).max() < 1e-14:
            break
    return local
