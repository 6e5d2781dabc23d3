"""Polynomials through what elements around each element say where it is most accurate: in their middles."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.tolerances import OPEN_FIT

STENCIL = np.array([[0.5, 0.0, 1.0, 0.5, 0.5], [0.5, 0.5, 0.5, 0.0, 1.0]])
"""Points (2, 5) of every element at which a field is asked for: its middle, and those of its edges."""
SLOPES = 1e-2
"""Weight of the slopes of a field against its values: they decide only what the values leave open."""
STAYS = 5.0
"""How much more a step counts that stays in an element than one across an edge: what is near tells most."""
FACTORS = np.array([1.0, SLOPES, SLOPES])


class Cuts(NamedTuple):
    """Where polynomials end.

    Attributes
    ----------
    facets : (m,) int array
        Of the mesh, which none reaches across.
    nodes : (n,) int array
        Of the mesh: no two elements there are in one patch.
    """

    facets: np.ndarray
    nodes: np.ndarray

    def __repr__(self) -> str:
        return short(self)


@dataclass(frozen=True)
class Patches:
    r"""Polynomials in the parameters about elements, quadratic ones with :math:`x^2 y` and :math:`x y^2`, of least squares,

    .. math::
        \sum_{k} w_k (P(x_k) - f_k)^2 + \epsilon^2 \sum_{k, a} (\Delta_a P - \Delta_a f)_k^2 \to \min,

    with the values :math:`f_k` in the middles of the elements up to three edges away, weighted by the number of ways that
    lead there, and the differences :math:`\Delta_a` from edge to edge of each of them. These rule only what the values leave
    open, as across a single row of elements. Along a divided edge directors are linear from end to end, so that only the
    mean of the two elements there is good: they count by their mean, and patches with such reach one edge further.

    Attributes
    ----------
    geometry : Geometry
    elements : (m,) int array
        Those with a polynomial.
    members, starts : (n_pairs,) and (m,) int arrays
        The elements of each patch, one patch after the other, and where each begins.
    weights : (n_pairs, 8, 3) array
        Coefficients per value and slopes of a member.
    scale : (2, m) array
        Reach of a patch along x and y, in which the coefficients count.
    means : (n_elements, n_elements) sparse array
        Means over those that share hanging nodes.
    """

    geometry: Geometry
    elements: np.ndarray
    members: np.ndarray
    starts: np.ndarray
    weights: np.ndarray
    scale: np.ndarray
    means: sp.csr_matrix

    __repr__ = short

    @classmethod
    def about(cls, geometry: Geometry, cuts: Cuts, elements: np.ndarray | None = None) -> "Patches":
        """Those of some elements, by default of all, which end at cuts."""
        elements = np.arange(geometry.n_elements) if elements is None else np.asarray(elements)
        near, means = neighbours(geometry, cuts.facets), means_beside_hanging_nodes(geometry)
        around = sp.csr_matrix(near[elements] @ near @ near)
        wider = (around @ (np.diff(means.indptr) > 1) > 0).astype(float)
        around = sp.csr_matrix(sp.diags(1 - wider) @ around + sp.diags(wider) @ around @ near)
        around = _not_about(geometry, cuts.nodes, around, elements)
        around.eliminate_zeros()
        members, starts = around.indices, around.indptr[:-1]
        patch = np.repeat(np.arange(len(elements)), np.diff(around.indptr))
        rows, scale = _rows(geometry, means, elements, members, patch, starts)
        weighted = rows * np.stack([around.data, *np.ones((2, around.nnz))], axis=1)[:, None]
        inverse = np.linalg.pinv(np.add.reduceat(weighted @ rows.swapaxes(1, 2), starts), rcond=OPEN_FIT, hermitian=True)
        return cls(geometry, elements, members, starts, inverse[patch] @ weighted, scale, means)

    def coefficients(self, field: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
        """Of the polynomials (m, k, 8) of a field (n_elements, k, 5) at the stencil of every element; of those at some
        places in the list of elements, of a field at the stencil of what they :meth:`need`."""
        said = _functionals(field) * FACTORS
        if places is None:
            said = (self.means @ said.reshape(len(said), -1)).reshape(said.shape)
            return np.asarray(np.add.reduceat(said[self.members] @ self.weights.swapaxes(1, 2), self.starts))
        pairs, first = self._pairs(places)
        members = np.unique(self.members[pairs])
        means = self.means[members][:, self.need(places)]
        said = (means @ said.reshape(len(said), -1)).reshape(len(members), *said.shape[1:])
        at = np.searchsorted(members, self.members[pairs])
        return np.asarray(np.add.reduceat(said[at] @ self.weights[pairs].swapaxes(1, 2), first))

    def need(self, places: np.ndarray) -> np.ndarray:
        """The elements on which polynomials at some places in the list of elements depend, ascending."""
        return np.unique(self.means[np.unique(self.members[self._pairs(places)[0]])].indices)

    def _pairs(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Members of the patches at some places, one patch after the other, and where each begins."""
        sizes = np.diff(self.starts, append=len(self.members))[places]
        first = np.cumsum(sizes) - sizes
        return np.repeat(self.starts[places] - first, sizes) + np.arange(sizes.sum()), first

    def values(self, field: np.ndarray, points: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
        """Polynomials of a field (n_elements, k, 5) at local points (2, n) of elements, or of those at some places in the
        list of elements, of a field (n, k, 5) in those that they :meth:`need`: (m, k, n)."""
        some = slice(None) if places is None else places
        return np.asarray(self.coefficients(field, places) @ self._at(points, some))

    def transposed(self, points: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What weights (m, k, n) of the values make of a field at the stencil: elements (l,), weights there (l, k, 5)."""
        of_coefficients = weights @ self._at(points).swapaxes(1, 2)
        patch = np.repeat(np.arange(len(self.starts)), np.diff([*self.starts, len(self.members)]))
        said = of_coefficients[patch] @ self.weights * FACTORS
        out = np.stack([said[..., 0], -said[..., 1], said[..., 1], -said[..., 2], said[..., 2]], axis=-1)
        to = sp.csr_matrix(self.means[self.members].T)
        members = np.flatnonzero(np.diff(to.indptr))
        return members, np.asarray(to[members] @ out.reshape(len(out), -1)).reshape(len(members), *out.shape[1:])

    def _at(self, points: np.ndarray, some: Any = slice(None)) -> np.ndarray:
        """Powers at local points (2, n) of the elements: (m, 8, n)."""
        middle = self.geometry.parameters(STENCIL[:, :1], self.elements[some])
        away = self.geometry.parameters(points, self.elements[some]) - middle
        return _powers(away / self.scale[:, some, None])


def _rows(
    geometry: Geometry, means: sp.csr_matrix, elements: np.ndarray, members: np.ndarray, patch: np.ndarray,
    starts: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """What is asked of the powers about an element for each member of its patch, (n_pairs, 8, 3), and their scale (2, m)."""
    at, middle = geometry.parameters(STENCIL), geometry.parameters(STENCIL[:, :1], elements)
    # Each pair as often as its member has elements in its mean.
    sizes = np.diff(means.indptr)[members]
    pair = np.repeat(np.arange(len(members)), sizes)
    entry = means.indptr[members][pair] + np.arange(len(pair)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    away = at[:, means.indices[entry]] - middle[:, patch[pair]]
    away -= geometry.whole_turns(away[:, :, :1])
    first = np.cumsum(sizes) - sizes
    scale = np.maximum.reduceat(np.abs(away).max(axis=2), first[starts], axis=1)
    wanted = _functionals(_powers(away / scale[:, patch[pair], None])) * FACTORS
    return np.add.reduceat(wanted * means.data[entry][:, None, None], first), scale


def _not_about(geometry: Geometry, nodes: np.ndarray, around: sp.csr_matrix, elements: np.ndarray) -> sp.csr_matrix:
    """Patches (m, n_elements) without the elements that share one of the nodes with the element they are about."""
    own = averaging_nodes(geometry)
    corner, element = np.nonzero(np.isin(own[geometry.mesh.t], own[nodes]))
    there = own[geometry.mesh.t[corner, element]]
    touch = sp.csr_matrix((np.ones(len(there)), (element, there)), shape=(geometry.n_elements, len(own)))
    pairs = sp.csr_matrix(touch[elements] @ touch.T).tocoo()
    other = pairs.col != elements[pairs.row]
    shared = sp.csr_matrix((np.ones(other.sum()), (pairs.row[other], pairs.col[other])), shape=around.shape)
    return sp.csr_matrix(around - around.multiply(shared > 0))


def means_beside_hanging_nodes(geometry: Geometry) -> sp.csr_matrix:
    """Weights (n_elements, n_elements) of means over the elements that share hanging nodes, some quarters of one element;
    all others stand for themselves."""
    mesh, n = geometry.mesh, geometry.n_elements
    corner, element = np.nonzero(np.isin(mesh.t, geometry.hanging.nodes))
    node = mesh.t[corner, element]
    touch = sp.csr_matrix((np.ones(len(node)), (element, node)), shape=(n, mesh.p.shape[1]))
    group = connected_components(touch @ touch.T, directed=False)[1]
    member = sp.csr_matrix((np.ones(n), (np.arange(n), group)), shape=(n, group.max() + 1))
    return sp.csr_matrix(member @ sp.diags(1.0 / np.bincount(group)) @ member.T)


def neighbours(geometry: Geometry, cut: np.ndarray) -> sp.csr_matrix:
    """Ones for elements and those across an edge, divided ones and those of a seam too, that is not one of the facets
    ``cut``; :data:`STAYS` for an element itself: (n_elements, n_elements)."""
    mesh, n = geometry.mesh, geometry.n_elements
    edge = edge_numbers(geometry)
    used = np.ones(edge.max() + 1, dtype=bool)
    used[edge[cut]] = False
    facets, elements = mesh.t2f.ravel(), np.tile(np.arange(n), 4)
    share = used[edge[facets]]
    borders = sp.csr_matrix((np.ones(share.sum()), (elements[share], edge[facets[share]])), shape=(n, len(used)))
    out = sp.csr_matrix(borders @ borders.T)
    out.setdiag(STAYS)
    return out


def edge_numbers(geometry: Geometry) -> np.ndarray:
    """A number for each facet of the mesh, (n_facets,): equal at both ends of a seam, and of the two parts of an edge and
    the whole. At a pole edges are those of the mesh."""
    mesh, hanging, own = geometry.mesh, geometry.hanging, averaging_nodes(geometry)
    n = len(own)
    ends = own[mesh.facets]
    whole = np.full((2, n), -1)
    whole[:, hanging.nodes] = own[hanging.ends]
    for one in (0, 1):
        parts = whole[0, ends[one]] >= 0
        ends[:, parts] = whole[:, ends[one, parts]]
    ends.sort(axis=0)
    return np.asarray(np.unique(ends[0] * np.int64(n) + ends[1], return_inverse=True)[1])


def averaging_nodes(geometry: Geometry) -> np.ndarray:
    """For each node of the mesh the one that gathers the values of the elements around it, (n_mesh_nodes,)."""
    ties = geometry.ties
    own = ties.representative[ties.node_of]
    own[geometry.hanging.nodes] = geometry.hanging.nodes
    # At a pole the frames turn from one element to the next: those of one node of the mesh only.
    at_pole = np.isin(ties.node_of, list(ties.poles))
    own[at_pole] = np.flatnonzero(at_pole)
    return np.asarray(own)


def _functionals(at_stencil: np.ndarray) -> np.ndarray:
    """Value in the middle and differences from edge to edge, (..., 3), of what is at the stencil, (..., 5)."""
    middle, left, right, low, high = np.moveaxis(at_stencil, -1, 0)
    return np.stack([middle, right - left, high - low], axis=-1)


def _powers(offsets: np.ndarray) -> np.ndarray:
    """1, x, y, xx, xy, yy, xxy, xyy of offsets (2, m, n): (m, 8, n)."""
    x, y = offsets
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y, x * x * y, x * y * y], axis=1)


def averages_at_nodes(geometry: Geometry, values: np.ndarray) -> np.ndarray:
    """Averages (n_mesh_nodes, k) of values (n_elements, 4, k) at corners; at a hanging node of its edge's ends."""
    own, corners, hanging = averaging_nodes(geometry), geometry.mesh.t.T, geometry.hanging
    out = np.zeros((len(own), values.shape[2]))
    np.add.at(out, own[corners], values)
    out = (out / np.maximum(np.bincount(own[corners].ravel(), minlength=len(own)), 1)[:, None])[own]
    out[hanging.nodes] = out[hanging.ends].mean(axis=0)
    return out
