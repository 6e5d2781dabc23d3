r"""How wrong are the section forces? Those of the elements against smoother ones, recovered from them.

The section forces :math:`s = (N, M)` of a finite element answer jump between elements. A polynomial fitted to them around
each node, where they are best, is closer to the exact ones, so that the difference tells the error.
"""

import numpy as np
import scipy.sparse as sp

from skancf.elements.quad_ancf import square_quadrature
from skancf.elements.reference import CORNERS
from skancf.layout.geometry import Geometry
from skancf.layout.patches import averaging_nodes
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.states import StateLike, solution_of
from skancf.theories.kirchhoff.theory import legendre
from skancf.tolerances import SINGULAR_FIT


def recovery_indicator(solution: StateLike) -> np.ndarray:
    r"""Estimated error of each element, an energy (J): its section forces against recovered ones, (n_elements,).

    .. math::
        \eta_K^2 = \tfrac12 \int_K (s^* - s) \cdot C^{-1} (s^* - s) \, dA, \qquad
        s^* = \frac{\sum_c N_c P_c}{\sum_c N_c}

    with the section forces :math:`s = (N, M)` of the element, the stiffness C of the section and the area of the undeformed
    surface. The sum over the elements estimates the squared error in the energy norm, half of the quadratic form as the
    strain energy is. :math:`P_c` is the complete polynomial in the parameters that fits the values of the elements around a
    corner where they are best: a quadratic one through 2 x 2 Gauss points, for the moments of theory `full`, whose director
    is bilinear, a linear one through the middles. :math:`N_c` is bilinear, 1 at the corner. Only corners inside the surface
    count, as far as an element has such: around those at the boundary there is too little to fit. At a hanging node P is the
    mean of those at the ends of the edge that it divides.

    Shear forces are left out: their boundary layers would be taken for errors. Loads and supports along a line inside the
    surface, where moments have a kink or a jump, are taken for errors of the elements next to them. At borders of zones,
    where forces along them jump, each side has polynomials of its own.

    C is that of the undeformed state, with laws at points too: the second Piola-Kirchhoff stress of a stretched sheet of
    rubber hardly grows with the strain, and by the stiffness that it has there any error would be a large one. What tension
    does on errors of the slopes is not seen: of sheets that are stretched by more than a half, the estimate is too small, by
    a factor of ten on coarse meshes. :func:`residual_indicator` and :func:`goal_estimate` take the tangent of the state.

    Parameters
    ----------
    solution : Solution, or a result that stands for one
        Of either theory, of statics or dynamics, with large or small deflections.

    Returns
    -------
    (n_elements,) array
        :math:`\eta_K^2`, at least 0.

    Notes
    -----
    The mean of the elements' values at each node, extrapolated from 2 x 2 Gauss points, would not do in theory `kirchhoff`:
    along their own direction its moments are linear, and so is the mean between two nodes, with the same error to leading
    order. Its estimate falls short by a factor of order h.

    References
    ----------
    O. C. Zienkiewicz and J. Z. Zhu, A simple error estimator and adaptive procedure for practical engineering analysis, Int.
    J. Numer. Meth. Eng. 24 (1987) 337-357; The superconvergent patch recovery and a posteriori error estimates, 33 (1992)
    1331-1382. T. Blacker and T. Belytschko, Superconvergent patch recovery with equilibrium and conjoint interpolant
    enhancements, 37 (1994) 517-536: the blend of the polynomials.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(sk.recovery_indicator(sk.solve_linear(system)).shape)
    (36,)
    """
    solution = solution_of("solution", solution)
    geometry, (points, weights) = solution.system.geometry, square_quadrature(3)
    raw = solution.section_forces(points)
    bending = geometry.theory.order // 2
    section = solution.system.assembly.section
    sections = None if isinstance(section, Section) else section
    smoother = [recovered(geometry, part, degree, sections) for part, degree in ((raw[:, :3], 2), (raw[:, 3:], bending))]
    error = np.concatenate(smoother, axis=1) - raw
    jets = geometry.theory.jets(geometry.undeformed_local, geometry.inside(points))
    areas = np.linalg.norm(np.cross(jets[0], jets[1], axis=0), axis=0) * weights
    compliance = np.linalg.inv(section.at(geometry.inside(points)).abd())
    of = "ep" * (compliance.ndim > 2)
    return np.asarray(0.5 * np.einsum(f"eip,{of}ij,ejp,ep->e", error, compliance, error, areas, optimize=True))


def recovered(geometry: Geometry, raw: np.ndarray, degree: int, sections: SectionsOnMesh | None = None) -> np.ndarray:
    """Smoother values at the 3 x 3 Gauss points of every element, of values there: both (n_elements, k, 9).

    Polynomials of that degree, 1 or 2, fit the values at as many Gauss points in each direction, of elements in one zone of
    the sections.
    """
    points, mesh, patches = square_quadrature(3)[0], geometry.mesh, _Patches(geometry, sections)
    scale, coefficients = _fits(geometry, patches, raw, degree)
    element, corner, node, share = _blended(geometry)
    patch, trust = patches.about(node, element)
    most = np.zeros(geometry.n_elements, dtype=int)
    np.maximum.at(most, element, trust)
    use = trust == most[element]
    element, corner, node, share, patch = element[use], corner[use], node[use], share[use], patch[use]
    offsets = geometry.parameters(points)[:, element] - mesh.p[:, node, None]
    blend = share[:, None] * _bilinear(points)[corner]
    powers = _powers(offsets / scale[:, patch, None], degree).swapaxes(0, 1)
    values = coefficients[patch] @ powers * blend[:, None]
    return np.asarray(_summed(element, values, len(raw)) / _summed(element, blend, len(raw))[:, None])


class _Patches:
    """Elements around nodes, on one side of borders between zones.

    Attributes
    ----------
    of : (4 n_elements,) int array
        Number of the patch about each corner, corner by corner.
    n : int
        How many there are.
    """

    def __init__(self, geometry: Geometry, sections: SectionsOnMesh | None):
        self._own, n = averaging_nodes(geometry), geometry.n_elements
        self._zones = np.zeros(n, dtype=int) if sections is None else sections.zones
        borders = np.zeros(geometry.mesh.facets.shape[1], dtype=bool) if sections is None else sections.borders
        self._keys, self.of = np.unique(self._key(geometry.mesh.t, np.arange(n)).ravel(), return_inverse=True)
        self.n = len(self._keys)
        inner = _inner(geometry, self._own, borders)[self._keys // self._n_zones]
        self._trust = inner + (np.bincount(self.of, minlength=self.n) >= 3).astype(int)

    @property
    def _n_zones(self) -> int:
        return int(self._zones.max()) + 1

    def _key(self, node: np.ndarray, element: np.ndarray) -> np.ndarray:
        return np.asarray(self._own[node] * self._n_zones + self._zones[element])

    def about(self, node: np.ndarray, element: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Patches about nodes of the mesh in the zones of elements, and their trust: 2 for those with elements all around, 1
        for those of three elements at least, 0 for others; -1 where no element is there. Both (m,).

        Fewer elements are in a row, and do not tell a quadratic field from a linear one across it.
        """
        key = self._key(node, element)
        patch = np.minimum(np.searchsorted(self._keys, key), self.n - 1)
        return patch, np.where(self._keys[patch] == key, self._trust[patch], -1)


def _fits(geometry: Geometry, patches: _Patches, raw: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Polynomials of the patches: scales of x and y (2, n) and coefficients (n, k, n_powers)."""
    (points, weights), best, mesh = square_quadrature(3), square_quadrature(degree)[0], geometry.mesh
    # The part of this degree less one in each direction: the next Legendre polynomial vanishes at the best points.
    at_best = raw @ (weights[:, None] * legendre(points, (degree, degree)) @ legendre(best, (degree, degree)).T)
    patch, n = patches.of, patches.n
    offsets = (geometry.parameters(best)[:, None] - mesh.p[:, mesh.t, None]).reshape(2, len(patch), -1)
    scale = np.zeros((2, n))
    for s, reach in zip(scale, np.abs(offsets).max(axis=2), strict=True):
        np.maximum.at(s, patch, reach)
    powers = _powers(offsets / scale[:, patch, None], degree).swapaxes(0, 1)
    matrices = _summed(patch, powers @ powers.swapaxes(1, 2), n)
    sides = _summed(patch, np.tile(at_best, (4, 1, 1)) @ powers.swapaxes(1, 2), n)
    # Too few places leave a power undetermined; of the polynomials that fit, the smallest is taken.
    return scale, sides @ np.linalg.pinv(matrices, rcond=SINGULAR_FIT, hermitian=True)


def _blended(geometry: Geometry) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Which nodes' polynomials make up those at the corners of elements: elements, corners, nodes, shares, each (m,)."""
    mesh, hanging, ends = geometry.mesh, geometry.hanging.nodes, geometry.hanging.ends
    parents = np.tile(np.arange(mesh.p.shape[1]), (2, 1))
    parents[:, hanging] = ends
    corner, element = np.indices(mesh.t.shape).reshape(2, -1)
    return np.tile(element, 2), np.tile(corner, 2), parents[:, mesh.t].ravel(), np.full(2 * element.size, 0.5)


def _inner(geometry: Geometry, own: np.ndarray, borders: np.ndarray) -> np.ndarray:
    """Nodes with elements all around, on neither the boundary nor borders (n_facets,), (n_mesh_nodes,) bool."""
    mesh, inner = geometry.mesh, np.ones(len(own), dtype=bool)
    edges = mesh.facets[:, geometry.boundary]
    hanging, ends = geometry.hanging.nodes, geometry.hanging.ends
    # A divided edge and its halves have elements on both sides, whatever their number of neighbours says.
    divided = np.isin(edges, hanging).any(axis=0) | np.isin(_keys(edges, len(own)), _keys(ends, len(own)))
    inner[own[edges[:, ~divided]]] = False
    inner[own[mesh.facets[:, borders]]] = False
    inner[np.isin(geometry.ties.node_of, list(geometry.ties.poles))] = False
    return inner


def _keys(pairs: np.ndarray, n: int) -> np.ndarray:
    """One number for each pair of nodes (2, m), whatever their order."""
    return np.asarray(pairs.min(axis=0) * np.int64(n) + pairs.max(axis=0))


def _summed(place: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Sums (n, ...) of values (m, ...) by their places (m,)."""
    gather = sp.csr_matrix((np.ones(len(place)), (place, np.arange(len(place)))), shape=(n, len(place)))
    return np.asarray(gather @ values.reshape(len(place), -1)).reshape(n, *values.shape[1:])


def _powers(offsets: np.ndarray, degree: int) -> np.ndarray:
    """Powers 1, x, y and, of degree 2, xx, xy, yy: (2, ...) -> (3 or 6, ...)."""
    x, y = offsets
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y][: 3 * degree])


def _bilinear(points: np.ndarray) -> np.ndarray:
    """The four functions of the corners at points (2, n): (4, n)."""
    return np.abs(1 - CORNERS[:, :, None] - points).prod(axis=1)
