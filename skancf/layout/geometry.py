"""A mesh on a surface for a theory: undeformed nodal coordinates, local vectors, where things are."""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem

from skancf.arguments import having
from skancf.elements.nodal import nodal_jacobian, require_aligned
from skancf.elements.quad_ancf import gauss
from skancf.elements.reference import CORNERS
from skancf.errors import InputError, vector
from skancf.kernels.constants import FUNCTIONS, VECTORS
from skancf.layout.hanging import Hanging
from skancf.layout.maps import Map, local_maps
from skancf.layout.places import Places
from skancf.layout.points import IntegrationPoints, Own
from skancf.layout.ties import find_ties
from skancf.meshes.check import check_mesh_on
from skancf.meshes.finder import Finder, element_finder
from skancf.surfaces import Surface, check_regular, normal
from skancf.surfaces.contradictions import check_derivatives
from skancf.theories import Theory
from skancf.tolerances import ONE_PLACE, ROOT, SAME_POINT, VANISHED

TURNED_OVER = -0.6
"""A cosine of the angle between normals half an element or one element apart that no usable mesh has."""


class Geometry(Places):
    """Everything about a mesh on a surface that does not depend on material, supports or loads.

    Attributes
    ----------
    ties : Ties
        Which nodes of the mesh are one.
    hanging : Hanging
        Which nodes of the mesh have no unknowns of their own.
    of_nodes : Map
        Of the vectors of all nodes of the mesh from those of the nodes with unknowns.
    nodes : (n_elements, n) int array
        The nodes with the unknowns that an element depends on, some of them twice. Its corners are ``mesh.t``.
    points : (2, n_nodes) array
        Nodes in the parameter plane.
    undeformed : (n_nodes, 4, 3) array
        Nodal coordinates of the undeformed surface: r, r_x, r_y and r_z or r_xy; at a pole r and two tangents.
    side : (n_elements,) array
        1 where corners are numbered counter-clockwise, else -1.
    maps : Maps
        From nodal coordinates to local vectors.
    integration : IntegrationPoints
        The Gauss points of the theory, or own ones of some elements.
    """

    def __init__(self, mesh: skfem.MeshQuad, surface: Surface, theory: Theory, own_points: Own | None = None):
        check_mesh_on(mesh, getattr(surface, "bounds", None))
        check_derivatives(surface, mesh)
        if theory.continuity:
            require_aligned(mesh)
            having("surface", surface, ("second_derivatives",), "one with second_derivatives, which theory 'kirchhoff' "
                   "needs; sk.MappedSurface makes them of a position")  # fmt: skip
        self.mesh, self.surface, self.theory = mesh, surface, theory
        self.integration = IntegrationPoints(mesh.t.shape[1], theory.quadrature, own_points)
        check_regular(surface, *self.parameters(self.integration.local).reshape(2, -1))
        self.ties = find_ties(mesh, surface, theory)
        self.hanging = Hanging.of(mesh, theory)
        self.points = mesh.p[:, self.ties.representative]
        jacobian = nodal_jacobian(mesh)
        self.side = np.sign(np.linalg.det(np.moveaxis(jacobian[:, :, 0], -1, 0)))
        self.of_nodes = Map.of_mesh(self.ties, self.hanging)
        self.maps = local_maps(mesh, jacobian, theory, self.of_nodes)
        self.nodes = self.maps.nodes
        self.undeformed = self._undeformed()
        self._check_fold()

    def _check_fold(self) -> None:
        """InputError where the surface turns over between two elements, or within one."""
        centre, inside = np.array([[0.5], [0.5]]), np.array([[0.1, 0.9, 0.5, 0.5, 0.5], [0.5, 0.5, 0.1, 0.9, 0.5]])
        n = normal(self.surface, *self.parameters(inside))
        within = np.einsum("iep,ie->ep", n[:, :, :4], n[:, :, 4]).min(axis=1)
        first, second = self.mesh.f2t[:, self.mesh.f2t[1] >= 0]
        across = (n[:, first, 4] * n[:, second, 4]).sum(axis=0)
        for elements, cosine in ((np.arange(self.n_elements), within), (first, across)):
            if (cosine < TURNED_OVER).any():
                element = int(elements[np.argmin(cosine)])
                place = self.surface.position(*self.parameters(centre, np.array([element]))[:, 0])[:, 0]
                raise InputError(
                    f"the surface folds at element {element}, near ({', '.join(f'{v:.4g}' for v in place)}): its normal "
                    "turns over there; end the surface at the fold, or take smaller elements where it bends that much"
                )

    def _undeformed(self) -> np.ndarray:
        x, y = self.points
        vectors = [self.surface.position(x, y), *self.surface.derivatives(x, y), self.theory.fourth(self.surface, x, y)]
        nodal = np.ascontiguousarray(np.stack(vectors).transpose(2, 0, 1))
        for node, tangents in self.ties.poles.items():
            nodal[node, 1:3] = tangents
            nodal[node, 3] = self._normal_at_pole(node, tangents) if self.theory.directors else 0.0
        return nodal

    def _normal_at_pole(self, node: int, tangents: np.ndarray) -> np.ndarray:
        """The normal there, on the side of those next to it."""
        element, _ = self.corner_of(node)
        beside = normal(self.surface, *self.parameters(np.array([[0.5], [0.5]]), np.array([element]))[:, 0])[:, 0]
        n = np.cross(*tangents)
        return np.asarray(n / np.linalg.norm(n) * np.sign(n @ beside))

    @cached_property
    def scales(self) -> np.ndarray:
        """What each of the 12 coordinates at a node counts in, (n_nodes, 12), powers of two: of the size of the surface, of
        the undeformed slopes, and of a fourth vector made of them or of one, whatever the units."""
        extent = np.ptp(self.undeformed[:, 0], axis=0).max()
        slopes = np.linalg.norm(self.undeformed[:, 1:3], axis=2)
        fourth = self.theory.fourth_factor(np.einsum("ij,ni->ijn", np.eye(2), slopes / [1.0, extent]))
        sizes = np.column_stack([np.full(self.n_nodes, extent), slopes, fourth])
        return np.repeat(np.exp2(np.round(np.log2(sizes))), 3, axis=1)

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
        out = np.zeros((len(elements), 16, 3), q.dtype)
        np.add.at(out, (index, row), value[:, None] * q[node, kind])
        return out

    def nodal(self, local: np.ndarray, elements: np.ndarray) -> np.ndarray:
        """Nodal forces (n_nodes, 4, 3) of forces on local vectors (n, 16, 3): the transpose of :meth:`local`."""
        index, row, node, kind, value = self._triples(np.asarray(elements))
        out = np.zeros((self.n_nodes, 4, 3))
        np.add.at(out, (node, kind), value[:, None] * local[index, row])
        return out

    def at_mesh_nodes(self, q: np.ndarray) -> np.ndarray:
        """r, r_x, r_y and the fourth vector at every node of the mesh, (n_mesh_nodes, 4, 3)."""
        return self.of_nodes(q)

    def corner_of(self, node: int) -> tuple[int, int]:
        """An element and its corner at a node."""
        corner, element = np.argwhere(self.mesh.t == self.ties.representative[node])[0]
        return int(element), int(corner)

    def undeformed_at(self, mesh_node: int) -> np.ndarray:
        """r, r_x, r_y and the fourth vector of the undeformed surface at a node of the mesh, (4, 3)."""
        return np.asarray(self.ties.mix[mesh_node] @ self.undeformed[self.ties.node_of[mesh_node]])

    def normal_at(self, mesh_node: int) -> np.ndarray:
        """Unit normal of the undeformed surface at a node of the mesh, (3,)."""
        normal: np.ndarray = self._normals[mesh_node]
        return normal

    @cached_property
    def _normals(self) -> np.ndarray:
        """Those of all, (n_mesh_nodes, 3)."""
        return normal(self.surface, *self.mesh.p).T

    def normal_slopes_at(self, mesh_node: int) -> np.ndarray:
        """Its derivatives n_x and n_y, (2, 3); zero at a pole, where they have no meaning."""
        slopes: np.ndarray = self._normal_slopes[mesh_node]
        return slopes

    @cached_property
    def _normal_slopes(self) -> np.ndarray:
        """Those of all, (n_mesh_nodes, 2, 3)."""
        slopes = np.stack(self.surface.derivatives(*self.mesh.p)).transpose(2, 0, 1)
        xx, xy, yy = (np.einsum("in,ni->n", v, self._normals) for v in self.surface.second_derivatives(*self.mesh.p))
        bending = np.array([[xx, xy], [xy, yy]]).transpose(2, 0, 1)
        metric = slopes @ slopes.swapaxes(1, 2)
        out = np.zeros_like(slopes)
        # A slope is zero at a pole, relative to what it is elsewhere: the two have units of their own.
        lengths = np.linalg.norm(slopes, axis=2).max(axis=0)
        relative = metric / np.outer(lengths, lengths)
        regular = np.linalg.det(relative) >= VANISHED**2 * np.trace(relative, axis1=1, axis2=2) ** 2
        out[regular] = -bending[regular] @ np.linalg.solve(metric[regular], slopes[regular])
        return out

    @property
    def at_poles(self) -> np.ndarray:
        """Which elements have a corner at a pole, (n_elements,)."""
        return np.asarray(np.isin(self.ties.node_of[self.mesh.t], list(self.ties.poles)).any(axis=0))

    def dense_map(self, element: int) -> np.ndarray:
        """From the vectors of an element's nodes, one after another, to its local vectors: (16, 4 n)."""
        maps = self.maps
        out = np.zeros((FUNCTIONS, VECTORS * self.nodes.shape[1]))
        part = slice(maps.pointer[element], maps.pointer[element + 1])
        np.add.at(out, (maps.rows[part], VECTORS * maps.corners[part] + maps.kinds[part]), maps.values[part])
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

    def local_entries(self, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """How the local vectors of elements (n,) come from the nodal ones: place in the list, local vector, nodal vector of
        4 n_nodes, and weight of each contribution."""
        index, row, node, kind, value = self._triples(elements)
        return index, row, 4 * node.astype(int) + kind, value

    def position_rows(self, elements: np.ndarray, local: np.ndarray) -> sp.csr_matrix:
        """Weights (n, 4 n_nodes) of nodal vectors that make positions at local points (n, 2) of elements (n,)."""
        table = self.theory.position_table(local.T)[0]
        point, row, column, value = self.local_entries(elements)
        shape = (len(elements), VECTORS * self.n_nodes)
        return sp.csr_matrix((value * table[row, point], (point, column)), shape=shape)

    @cached_property
    def local_matrix(self) -> sp.csr_matrix:
        """From nodal vectors to the local vectors of all elements: (16 n_elements, 4 n_nodes)."""
        index, row, column, value = self.local_entries(np.arange(self.n_elements))
        shape = (16 * self.n_elements, 4 * self.n_nodes)
        return sp.csr_matrix((value, (16 * index + row, column)), shape=shape)

    @cached_property
    def undeformed_local(self) -> np.ndarray:
        return self.local(self.undeformed)

    def jets(self, local: np.ndarray) -> np.ndarray:
        """Jets (5, 3, n_elements, 16) of the local vectors of all elements at their integration points."""
        return self.integration.gathered(lambda points, e: self.theory.jets(local[e], points), axis=2)

    def parameters(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Parameters (2, n_elements, n) of local points (2, n), or of those of each element, (n_elements, 2, n)."""
        xi, eta = points.reshape(-1, *points.shape[-2:]).swapaxes(0, 1)
        bilinear = np.stack([np.where(a, xi, 1 - xi) * np.where(b, eta, 1 - eta) for a, b in CORNERS])
        corners = self.mesh.p[:, self.mesh.t if elements is None else self.mesh.t[:, elements]]
        return np.einsum("dce,cen->den", corners, bilinear)

    def tangents(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Tangent along the parameter x at local points (2, n): (3, n_elements, n)."""
        return self.surface.derivatives(*self.parameters(points, elements))[0]

    @cached_property
    def _finder(self) -> Finder:
        return element_finder(self.mesh)

    def locate(self, at: Any) -> tuple[int, np.ndarray]:
        """The element that holds a point of the parameter plane, and the point's local coordinates (2,).

        Across the seam of a closed parameter it goes on at the other end.
        """
        elements, local = self.locate_all(vector("point", at, 2)[:, None])
        return int(elements[0]), local[0]

    def locate_all(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The elements (n,) that hold points (2, n) of the parameter plane, and local coordinates (n, 2)."""
        points = self.within(points)
        try:
            elements = np.asarray(self._finder(*points))
        except ValueError as error:
            outside = next((k for k, point in enumerate(points.T) if self._found(point) < 0), 0)
            raise self._outside(points[:, [outside]]) from error
        local = _inverse_bilinear(self.mesh.p[:, self.mesh.t[:, elements]], points)
        wrong = ((local < -SAME_POINT) | (local > 1 + SAME_POINT)).any(axis=0)
        if wrong.any():
            raise self._outside(points[:, wrong])
        return elements, np.clip(local, 0.0, 1.0).T

    def locate_inside(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which points (2, n) the surface holds, (n,) bool, and the elements and local coordinates of those."""
        points = self.within(points)
        try:
            elements = np.asarray(self._finder(*points)) if points.size else np.empty(0, dtype=int)
        except ValueError:
            elements = np.array([self._element_at(point) for point in points.T])
        inside = elements >= 0
        elements = elements[inside]
        return inside, elements, self.local_in(elements, points[:, inside, None])[:, :, 0]

    def _element_at(self, point: np.ndarray) -> int:
        """The element that holds a point (2,), rounding allowed for; -1 outside."""
        low, high = self.mesh.p.min(axis=1), self.mesh.p.max(axis=1)
        slack = ONE_PLACE * (high - low)
        if ((point < low - slack) | (point > high + slack)).any():
            return -1
        around = (self._found(point + slack * way) for way in ((0, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)))
        return next((element for element in around if element >= 0), -1)

    def _found(self, point: np.ndarray) -> int:
        try:
            return int(self._finder(*point[:, None])[0])
        except ValueError:
            return -1

    def local_in(self, elements: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Local coordinates (m, 2, n) of points (2, m, n) of the parameter plane that lie in elements (m,)."""
        corners = np.repeat(self.mesh.p[:, self.mesh.t[:, elements]], points.shape[2], axis=2)
        local = _inverse_bilinear(corners, points.reshape(2, -1)).reshape(points.shape)
        return np.clip(local, 0.0, 1.0).swapaxes(0, 1)

    def _outside(self, points: np.ndarray) -> InputError:
        which = f"point {tuple(points[:, 0].tolist())} lies" if points.shape[1] == 1 else "a point lies"
        return InputError(
            f"{which} outside the surface; in the parameter plane the mesh "
            f"spans {self.mesh.p.min(axis=1).tolist()} to {self.mesh.p.max(axis=1).tolist()}"
        )

    def within(self, points: np.ndarray) -> np.ndarray:
        """The same points (2, ...) of the surface, closed parameters within their bounds."""
        out = points.copy()
        for axis, (low, high) in self.closed_bounds().items():
            outside = (out[axis] < low) | (out[axis] > high)
            out[axis] = np.where(outside, low + (out[axis] - low) % (high - low), out[axis])
        return out

    def whole_turns(self, apart: np.ndarray) -> np.ndarray:
        """Whole turns of closed parameters in differences (2, ...) of points; zero along others."""
        out = np.zeros_like(apart)
        for axis, (low, high) in self.closed_bounds().items():
            out[axis] = (high - low) * np.round(apart[axis] / (high - low))
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
        """Elements (m,), local points (m, 2, n) and weights times length of the surface itself (m, n) of boundary facets."""
        elements = self.mesh.f2t[0, facets]
        points, _, w = self.edge_points(facets, n)
        ends = self.mesh.p[:, self.mesh.facets[:, facets]]
        slopes = np.stack(self.surface.derivatives(*self.parameters(points, elements)))
        along = np.einsum("dm,dimn->imn", ends[:, 1] - ends[:, 0], slopes)
        return elements, points, w * np.linalg.norm(along, axis=0)


def _inverse_bilinear(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Local coordinates (2, n) of points (2, n) in quads (2, 4, n) by Newton's method."""
    local = np.full(points.shape, 0.5)
    for _ in range(30):
        xi, eta = local
        shape = np.stack([(1 - xi) * (1 - eta), xi * (1 - eta), xi * eta, (1 - xi) * eta])
        slopes = np.stack([np.stack([eta - 1, 1 - eta, eta, -eta]), np.stack([xi - 1, -xi, xi, 1 - xi])])
        jacobian = np.einsum("icn,jcn->nij", corners, slopes)
        step = np.linalg.solve(jacobian, (points - np.einsum("icn,cn->in", corners, shape)).T[:, :, None])[:, :, 0].T
        local = local + step
        if np.abs(step).max(initial=0.0) < ROOT:
            break
    return local
