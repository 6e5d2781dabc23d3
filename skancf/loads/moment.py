"""Moments on edges and at points."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, vector
from skancf.functions import is_function, values_at
from skancf.history import Case, History, check_history
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, at_place
from skancf.loads.acting import Acting
from skancf.showing import short
from skancf.terms.blocks import OnElements
from skancf.terms.protocols import Assembly
from skancf.theories.kirchhoff.point import R1, R2, dual, unit_normal
from skancf.tolerances import PARALLEL, ROUNDED_PRODUCT
from skancf.vectors import cross


@by_value
@dataclass(frozen=True)
class EdgeMoment:
    r"""A moment per undeformed length (N) on edges, about axes that do not turn.

    Its virtual work is that on the spin of the director or normal, :math:`m \cdot (d \times \delta d) / d \cdot d`; in
    theory `full` summed over the nodes of the edge, in `kirchhoff` integrated along it. The part of m along the normal does
    no work.

    Parameters
    ----------
    where
        Place, as for :class:`EdgeLoad`.
    moment : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).

    Raises
    ------
    InputError
        For entries that are not finite or of another number; on a mesh, for a place without an edge.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> bend = sk.EdgeMoment("right", (0.0, -100.0, 0.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[bend])
    >>> tip = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1000 * tip[2]:.3f} mm")  # M L^2 / 2 E I
    2.857 mm
    """

    where: Any
    moment: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        if not is_function(self.moment):
            vector("moment", self.moment, 3)

    def on(self, assembly: Assembly) -> Acting:
        geometry = assembly.geometry
        elements, points, moments = self.spread(assembly)
        moments = moments.swapaxes(0, 1)
        ends = at_place(geometry, self.where, "moment", "an EdgeMoment", single=False)
        if geometry.theory.directors:
            return MomentOnDirectors(assembly, *_on_nodes(geometry, elements, points, moments), self.history, ends)
        return EdgeMomentOnNormals(assembly, elements, points, moments, self, ends)

    def spread(self, assembly: Assembly) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Elements (m,), local points (m, 2, n) along the edges, and moments there (m, 3, n) (N m)."""
        geometry = assembly.geometry
        elements, points, lengths = geometry.edge_quadrature(geometry.facets_on(self.where))
        moments = values_at("moment", self.moment, geometry.parameters(points, elements), 3) * lengths
        return elements, points, moments.swapaxes(0, 1)


@by_value
@dataclass(frozen=True)
class PointMoment:
    r"""A moment (N m) at a point of the parameter plane, about an axis that does not turn.

    Its virtual work is that on the spin of the director or normal there, :math:`m \cdot (d \times \delta d) / d \cdot d`:
    the part of m along the normal does no work. The rotation under it has no limit as the mesh is refined, it grows with the
    logarithm of the element size; the displacement has one.

    Parameters
    ----------
    at : (2,)
        Point of the parameter plane.
    moment : (3,)
        About the axes of space.
    history : callable, optional
        Factor as a function of time.

    Raises
    ------
    InputError
        For entries that are not finite or of another number; on a mesh, for a point outside the surface, and for a moment
        along the normal there, which would do nothing.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> twist = sk.PointMoment((1.0, 0.05), (0.0, -10.0, 0.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[twist])
    >>> tip = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 8, 2), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1000 * tip[2]:.2f} mm")
    2.86 mm
    """

    at: tuple[float, float]
    moment: tuple[float, float, float]
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        vector("at", self.at, 2)
        vector("moment", self.moment, 3)

    def on(self, assembly: Assembly) -> Acting:
        geometry = assembly.geometry
        elements, points, _ = self.spread(assembly)
        moment = np.asarray(self.moment, float)
        n = geometry.theory.normals(geometry.undeformed_local[elements], points[0], geometry.side[elements])[0, :, 0]
        size = np.linalg.norm(moment)
        if size and np.linalg.norm(np.cross(moment, n)) < PARALLEL * size * np.linalg.norm(n):
            raise InputError(f"moment = {self.moment} at {self.at} is along the normal of the surface, about which it has "
                             "no stiffness; give a couple of forces instead")  # fmt: skip
        at = geometry.within(np.asarray(self.at, float)[:, None])
        singular = [Singularity("moment", at, "a PointMoment", moment)]
        if geometry.theory.directors:
            tables = geometry.theory.position_table(points[0])[1].T
            return MomentOnDirectors(assembly, elements, tables, moment[None], self.history, singular)
        return MomentOnNormals(assembly, elements, points, moment[:, None, None], self.history, singular)

    def spread(self, assembly: Assembly) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The element (1,), its local point (1, 2, 1), and the moment (1, 3, 1) (N m)."""
        element, local = assembly.geometry.locate(self.at)
        return np.array([element]), local[None, :, None], np.asarray(self.moment, float)[None, :, None]


def _on_nodes(
    geometry: Geometry, elements: np.ndarray, points: np.ndarray, moments: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elements, tables and moments of :class:`MomentOnDirectors` on the nodes of an edge.

    The director is linear along the edge. That of a hanging node is the mean of those at the ends of its edge, which share
    its part.
    """
    hanging, shares = geometry.hanging, np.zeros((geometry.mesh.p.shape[1], 3))
    for element, local_points, moment in zip(elements, points, moments.swapaxes(0, 1), strict=True):
        directors = geometry.theory.position_table(local_points)[1]
        np.add.at(shares, geometry.mesh.t[:, element], directors[geometry.theory.rows[:, 3]] @ moment.T)
    for ends in hanging.ends:
        np.add.at(shares, ends, shares[hanging.nodes] / 2)
    shares[hanging.nodes] = 0.0
    on_nodes = np.zeros((geometry.n_nodes, 3))
    kept = geometry.ties.node_of >= 0
    np.add.at(on_nodes, geometry.ties.node_of[kept], shares[kept])
    nodes = np.flatnonzero(on_nodes.any(axis=1))
    corners = np.array([geometry.corner_of(int(node)) for node in nodes], dtype=np.int64).reshape(-1, 2)
    tables = np.zeros((len(nodes), 16))
    tables[np.arange(len(nodes)), geometry.theory.rows[corners[:, 1], 3]] = 1.0
    return corners[:, 0], tables, on_nodes[nodes]


class MomentOnDirectors(Acting):
    """Moments (m, 3) on directors at points of elements (m,), where the local functions of r_z are ``tables`` (m, 16)."""

    def __init__(
        self, assembly: Assembly, elements: np.ndarray, tables: np.ndarray, moments: np.ndarray, history: History | None,
        singular: list[Singularity],
    ):  # fmt: skip
        self.geometry, self.elements, self.tables = assembly.geometry, elements, tables
        self.moments, self.history, self.singular = moments, history, singular

    def singularities(self, case: Case) -> list[Singularity]:
        return self.singular

    def _directors(self, q: np.ndarray) -> np.ndarray:
        return np.einsum("ma,mai->mi", self.tables, self.geometry.local(q, self.elements))

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        d = self._directors(q)
        on_d = case.amplitude(self.history) * np.cross(self.moments, d) / (d * d).sum(axis=1, keepdims=True)
        return self.geometry.nodal(np.einsum("ma,mi->mai", self.tables, on_d), self.elements)

    def _derivative(self, q: np.ndarray, case: Case) -> np.ndarray:
        """Minus the derivative of the force, (m, 3, 3)."""
        d, m = self._directors(q), case.amplitude(self.history) * self.moments
        square = (d * d).sum(axis=1)[:, None, None]
        against = np.cross(np.eye(3), m[:, None, :]).swapaxes(1, 2)  # columns e_j x m
        return np.asarray(2 * np.einsum("ni,nj->nij", np.cross(m, d), d) / square**2 + against / square)

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        on_d = self._derivative(q, case)
        blocks.add(self.elements, np.einsum("ma,mij,mb->miajb", self.tables, on_d, self.tables).reshape(-1, LOCAL, LOCAL))


class MomentOnNormals(Acting):
    r"""Moments (3, m, n), times length, on the normals at local points (m, 2, n) of elements (m,).

    With :math:`c_\gamma = (m \times n) \cdot a^\gamma` the force on :math:`r_{,\gamma}` is :math:`-c_\gamma n`, and minus
    its derivative with respect to :math:`r_{,\lambda}` is

    .. math:: -(c_\lambda\, n \otimes a^\gamma + c_\gamma\, a^\lambda \otimes n) - m \cdot (a^\lambda \times a^\gamma)\,
        n \otimes n,

    of which the last part is skew: a moment about a fixed axis has no potential unless it stays in the surface.
    """

    def __init__(
        self, assembly: Assembly, elements: np.ndarray, points: np.ndarray, moments: np.ndarray, history: History | None,
        singular: list[Singularity],
    ):  # fmt: skip
        self.singular = singular
        self.geometry, self.elements, self.moments, self.history = assembly.geometry, elements, moments, history
        # (m, 2, 16, n): r_1 and r_2 of the local functions at each facet's points.
        self.slopes = np.stack([self.geometry.theory.slope_table(p) for p in points])
        self._seen: tuple[Case, np.ndarray, tuple[np.ndarray, ...]] | None = None

    def singularities(self, case: Case) -> list[Singularity]:
        return self.singular

    def _surface(self, q: np.ndarray, case: Case) -> tuple[np.ndarray, ...]:
        """Normals, dual vectors, moments and c; of the last state they are kept, since force and stiffness ask in turn."""
        if self._seen is None or self._seen[0] != case or not np.array_equal(self._seen[1], q):
            jet = np.einsum("mgan,mai->gimn", self.slopes, self.geometry.local(q, self.elements))
            n, duals = unit_normal(jet), dual(jet)
            m = case.amplitude(self.history) * self.moments
            self._seen = case, q.copy(), (n, duals, m, np.einsum("imn,gimn->gmn", cross(m, n), duals))
        return self._seen[2]

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        n, _, _, c = self._surface(q, case)
        return self.geometry.nodal(-np.einsum("mgan,gmn,imn->mai", self.slopes, c, n), self.elements)

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        if blocks.skew:
            self._add_skew(q, case, blocks)
            return
        n, duals, _, c = self._surface(q, case)
        # Sums over points as products of matrices; a sum of this number of factors takes longer to plan than to do.
        left = np.einsum("mgan,gjmn->majn", self.slopes, duals).reshape(len(self.slopes), LOCAL, -1)
        right = np.einsum("mlbn,lmn,imn->mibn", self.slopes, c, n).reshape(len(self.slopes), LOCAL, -1)
        half = (left @ right.swapaxes(1, 2)).reshape(-1, FUNCTIONS, AXES, AXES, FUNCTIONS)
        half = half.transpose(0, 3, 1, 2, 4).reshape(-1, LOCAL, LOCAL)
        blocks.add(self.elements, -(half + half.swapaxes(1, 2)))

    def _add_skew(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        n, duals, m, _ = self._surface(q, case)
        spanned = cross(duals[R1], duals[R2])
        normal_part = np.einsum("imn,imn->mn", m, spanned)
        # A moment in the surface: the rest is rounding, and an unsymmetric solve costs as much as all else in an iteration.
        if not (np.abs(normal_part) > ROUNDED_PRODUCT * np.abs(m).max() * np.abs(spanned).max()).any():
            return
        # Along each normal, r_1 and r_2 of the functions: (m, 48, points), component by component.
        one, two = (np.einsum("man,imn->mian", self.slopes[:, g], n).reshape(len(self.slopes), LOCAL, -1) for g in (0, 1))
        half = (normal_part[:, None] * one) @ two.swapaxes(1, 2)
        blocks.add(self.elements, half - half.swapaxes(1, 2))


class EdgeMomentOnNormals(MomentOnNormals):
    """An :class:`EdgeMoment` on normals, which says what it applies along any edge."""

    def __init__(
        self, assembly: Assembly, elements: np.ndarray, points: np.ndarray, moments: np.ndarray, load: EdgeMoment,
        singular: list[Singularity],
    ):  # fmt: skip
        super().__init__(assembly, elements, points, moments, load.history, singular)
        self.load = load

    def edge_moments(self, facets: np.ndarray, at: np.ndarray, case: Case) -> np.ndarray:
        here, out = np.isin(facets, self.geometry.points_and_facets(self.load.where)[1]), np.zeros((3, *at.shape[1:]))
        out[:, here] = case.amplitude(self.history) * values_at("moment", self.load.moment, at[:, here], 3)
        return out
