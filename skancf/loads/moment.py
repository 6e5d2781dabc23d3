"""Moments on edges."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.assembly import local
from skancf.assembly.geometry import Geometry
from skancf.assembly.protocols import Assembly
from skancf.errors import vector
from skancf.history import History, amplitude, check_history
from skancf.loads.acting import Acting
from skancf.theories.kirchhoff_point import R1, R2, dual, unit_normal
from skancf.vectors import cross

ROUNDING = 1e-12
"""A moment's part normal to the surface that is none, relative to the moment."""

@dataclass(frozen=True)
class EdgeMoment:
    r"""A moment per undeformed length (N) on boundary edges, about an axis that does not turn.

    Its virtual work is that on the spin of the director or normal, :math:`m \cdot (d \times \delta d) / d \cdot d`; in
    theory `full` summed over the nodes of the edge, in `kirchhoff` integrated along it. The part of m along the normal does
    no work.
    """

    where: Any
    moment: tuple[float, float, float]
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        vector("moment", self.moment, 3)

    def on(self, assembly: Assembly) -> Acting:
        geometry = assembly.geometry
        facets = geometry.facets_on(self.where)
        elements, points, lengths = geometry.edge_quadrature(facets)
        if geometry.theory.twist:
            moments = np.multiply.outer(self.moment, lengths)
            return MomentOnNormals(assembly, elements, points, moments, self.history)
        return MomentOnDirectors(assembly, *_on_nodes(geometry, facets, lengths.sum(axis=1), self.moment), self.history)


def _on_nodes(geometry: Geometry, facets: np.ndarray, lengths: np.ndarray, moment: Any) -> tuple[np.ndarray, np.ndarray]:
    """The nodes of an edge (m,) and the moment on each, (m, 3).

    The director of a hanging node is the mean of those at the ends of its edge, which share its part.
    """
    n, hanging = geometry.mesh.p.shape[1], geometry.hanging
    shares = np.bincount(geometry.mesh.facets[:, facets].ravel(), np.tile(lengths / 2, 2), n)
    shares += np.bincount(hanging.ends.ravel(), np.tile(shares[hanging.nodes] / 2, 2), n)
    shares[hanging.nodes] = 0.0
    meant = np.flatnonzero(shares)
    nodes, position = np.unique(geometry.ties.node_of[meant], return_inverse=True)
    return nodes, np.outer(np.bincount(position, shares[meant]), moment)


class MomentOnDirectors(Acting):
    """Moments (m, 3) on the directors of nodes (m,)."""

    def __init__(self, assembly: Assembly, nodes: np.ndarray, moments: np.ndarray, history: History | None):
        self.geometry, self.nodes, self.moments, self.history = assembly.geometry, nodes, moments, history
        found = [self.geometry.corner_of(node) for node in nodes]
        self.elements = np.array([element for element, _ in found])
        self.rows = np.array([self.geometry.theory.rows[corner, 3] for _, corner in found])

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        out, d = np.zeros_like(q), q[self.nodes, 3]
        out[self.nodes, 3] = np.cross(self.moments, d) / (d * d).sum(axis=1, keepdims=True)
        return np.asarray(amplitude(self.history, time) * out)

    def _blocks(self, q: np.ndarray, time: float | None) -> np.ndarray:
        """Minus the derivative of the force, (m, 3, 3)."""
        d, m = q[self.nodes, 3], amplitude(self.history, time) * self.moments
        square = (d * d).sum(axis=1)[:, None, None]
        against = np.cross(np.eye(3), m[:, None, :]).swapaxes(1, 2)  # columns e_j x m
        return np.asarray(2 * np.einsum("ni,nj->nij", np.cross(m, d), d) / square**2 + against / square)

    def _matrices(self, blocks: np.ndarray) -> np.ndarray:
        out = np.zeros((len(blocks), 3, 16, 3, 16))
        for k, row in enumerate(self.rows):
            out[k, :, row, :, row] = blocks[k]
        return out.reshape(-1, 48, 48)

    def add_stiffness(
        self, q: np.ndarray, time: float | None, factor: float, slots: np.ndarray, out: np.ndarray
    ) -> None:
        blocks = self._blocks(q, time)
        symmetric = self._matrices(factor * (blocks + blocks.swapaxes(1, 2)) / 2)
        local.add_local(self.elements, symmetric, self.geometry.maps, slots, out)

    def skew(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, np.ndarray]:
        blocks = self._blocks(q, time)
        return self.elements, self._matrices((blocks - blocks.swapaxes(1, 2)) / 2)


class MomentOnNormals(Acting):
    r"""Moments (3, m, n), times length, on the normals at local points (m, 2, n) of elements (m,).

    With :math:`c_\gamma = (m \times n) \cdot a^\gamma` the force on :math:`r_{,\gamma}` is :math:`-c_\gamma n`, and minus
    its derivative with respect to :math:`r_{,\lambda}` is

    .. math:: -(c_\lambda\, n \otimes a^\gamma + c_\gamma\, a^\lambda \otimes n) - m \cdot (a^\lambda \times a^\gamma)\,
        n \otimes n,

    of which the last part is skew: a moment about a fixed axis has no potential unless it stays in the surface.
    """

    def __init__(
        self, assembly: Assembly, elements: np.ndarray, points: np.ndarray, moments: np.ndarray, history: History | None
    ):
        self.geometry, self.elements, self.moments, self.history = assembly.geometry, elements, moments, history
        # (m, 2, 16, n): r_1 and r_2 of the local functions at each facet's points.
        self.slopes = np.stack([self.geometry.theory.slope_table(p) for p in points])
        self._seen: tuple[float | None, np.ndarray, tuple[np.ndarray, ...]] | None = None

    def _surface(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, ...]:
        """Normals, dual vectors, moments and c; of the last state they are kept, since force and stiffness ask in turn."""
        if self._seen is None or self._seen[0] != time or not np.array_equal(self._seen[1], q):
            jet = np.einsum("mgan,mai->gimn", self.slopes, self.geometry.local(q, self.elements))
            n, duals = unit_normal(jet), dual(jet)
            m = amplitude(self.history, time) * self.moments
            self._seen = time, q.copy(), (n, duals, m, np.einsum("imn,gimn->gmn", cross(m, n), duals))
        return self._seen[2]

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        n, _, _, c = self._surface(q, time)
        return self.geometry.nodal(-np.einsum("mgan,gmn,imn->mai", self.slopes, c, n), self.elements)

    def add_stiffness(
        self, q: np.ndarray, time: float | None, factor: float, slots: np.ndarray, out: np.ndarray
    ) -> None:
        n, duals, _, c = self._surface(q, time)
        # Sums over points as products of matrices; a sum of so many factors takes longer to plan than to do.
        left = np.einsum("mgan,gjmn->majn", self.slopes, duals).reshape(len(self.slopes), 48, -1)
        right = np.einsum("mlbn,lmn,imn->mibn", self.slopes, c, n).reshape(len(self.slopes), 48, -1)
        half = (left @ right.swapaxes(1, 2)).reshape(-1, 16, 3, 3, 16).transpose(0, 3, 1, 2, 4).reshape(-1, 48, 48)
        local.add_local(self.elements, -factor * (half + half.swapaxes(1, 2)), self.geometry.maps, slots, out)

    def skew(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, np.ndarray] | None:
        n, duals, m, _ = self._surface(q, time)
        spanned = cross(duals[R1], duals[R2])
        normal_part = np.einsum("imn,imn->mn", m, spanned)
        # A moment in the surface: the rest is rounding, and an unsymmetric solve costs as much as all else in an iteration.
        if not (np.abs(normal_part) > ROUNDING * np.abs(m).max() * np.abs(spanned).max()).any():
            return None
        # Along each normal, r_1 and r_2 of the functions: (m, 48, points), component by component.
        one, two = (np.einsum("man,imn->mian", self.slopes[:, g], n).reshape(len(self.slopes), 48, -1) for g in (0, 1))
        half = (normal_part[:, None] * one) @ two.swapaxes(1, 2)
        return self.elements, half - half.swapaxes(1, 2)
