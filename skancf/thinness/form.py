r"""What leaving shear out changes, from thin fields alone.

With the shear forces Q that balance the moments M of a thin state u, and those of the weight z of a number J, the answer to
:math:`\partial J / \partial q` with the tangent of the state,

.. math::
    F(u, z) = \int_A Q(u) \cdot S^{-1} Q(z) \, dA + \int_\Gamma c\, M_{nt}(u) M_{nt}(z)
        - \gamma_t(u) M_{nt}(z) - M_{nt}(u) \gamma_t(z) \; ds,
        \qquad c^2 = \frac{(S^{-1})_{tt}}{D_{66} - D_{16}^2 / D_{11}}

is J of the plate that yields to shear less J of the thin one, to first order. S is the transverse shear stiffness
:math:`k G t` and :math:`\gamma = S^{-1} Q`. :math:`\Gamma` is the part of the boundary where directors tilt along it: free
edges and soft supports (outward normal n, tangent t). The twisting moment of the thin theory is zero there in a plate with
shear; it dies away in a layer of the width :math:`\sqrt{D_{66} / S_{tt}}`, a third of the thickness of one material. The
bending stiffness is that of :math:`D - B A^{-1} B` in the frame n, t of the edge; in the layer neither :math:`M_{nn}` nor
:math:`Q_n` changes, so that a part of what resists twisting and sliding gives way.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.history import FULL, Case
from skancf.materials import Section
from skancf.showing import short
from skancf.system.linearised import Model
from skancf.system.system import System
from skancf.terms.load import LoadTerm
from skancf.theories.kirchhoff.theory import local_frame
from skancf.thinness.forces import BILINEAR, balancing, coupled
from skancf.thinness.moments import Moments, moments_of, moments_of_small
from skancf.thinness.rim import rim_of
from skancf.tolerances import SAME_VALUE
from skancf.vectors import cross

REACH = 0.8
"""Widths of an edge layer, about a quarter of the thickness, within which of a singular point the fields of the thin theory
are not counted: by measurement, docs/measure/theory_error.py."""
N_EDGE = 3
"""Gauss points on each edge."""


@dataclass(frozen=True)
class Fields:
    """Of a state or a weight: shear forces Q (n_elements, 2, 4) at the points :data:`BILINEAR`, and along the edges the
    twisting moment M_nt and the shear strain g_t, (n_facets, n)."""

    Q: np.ndarray
    twisting: np.ndarray
    sliding: np.ndarray

    __repr__ = short


class ShearForm:
    """The form F on a system of theory `kirchhoff`.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> form, fields = sk.solve_linear(system).shear_fields()
    >>> print(f"{form.shares(fields, fields).sum() > 0}")
    True
    """

    def __init__(self, system: System, case: Case = FULL):
        self.system, self.geometry, self.case = system, system.geometry, case
        rim = rim_of(system, case)
        self._facets, self._strong = rim.tilting, rim.strong
        (points, weights), section = BILINEAR, system.assembly.section
        self._inside = section.at(points)
        jets = self.geometry.theory.jets(self.geometry.undeformed_local, points)
        areas = np.linalg.norm(cross(jets[0], jets[1]), axis=0) * weights
        self._areas = areas * self._counts(self.geometry.parameters(points), self._inside)
        self._elements, self._points, lengths = self.geometry.edge_quadrature(self._facets, N_EDGE)
        self._edges = section.at(self._points, self._elements)
        self._lengths = lengths * self._counts(self.geometry.parameters(self._points, self._elements), self._edges)

    def _counts(self, at: np.ndarray, section: Section) -> np.ndarray:
        """Which places (2, ...) of the parameter plane are so far from singular points that thin fields mean something."""
        places, reach = np.asarray(self.geometry.surface.position(*at)), REACH * _width(section)
        out = np.ones(at.shape[1:], dtype=bool)
        for point in self._strong.T:
            out &= ((places - point[:, None, None]) ** 2).sum(axis=0) > reach**2
        return out

    @cached_property
    def _frame(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tangents and outward normals (2, m, n) of the edges in the local frame, and that frame, (3, 3, m, n)."""
        geometry, elements = self.geometry, self._inner[0]
        if not len(elements):
            return np.zeros((2, 0, N_EDGE)), np.zeros((2, 0, N_EDGE)), np.zeros((3, 3, 0, N_EDGE))
        points, side = self._inner[1], geometry.side[elements]
        jets = geometry.theory.jets(geometry.undeformed_local[elements], points)
        frame = local_frame(jets, geometry.tangents(points, elements), side)
        e, slopes = (np.stack([np.stack([self._picked(c) for c in v]) for v in vectors]) for vectors in (frame, jets[:2]))
        tangents = geometry.edge_points(self._facets, N_EDGE)[1] * geometry.side[self._elements][:, None]
        t = np.einsum("aimn,mg,gimn->amn", e[:2], tangents, slopes)
        t = t / np.linalg.norm(t, axis=0)
        return t, np.stack([t[1], -t[0]]), e

    @cached_property
    def _inner(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Elements (k,) at the edges, points (2, p) of all their sides, and for each facet its element among them, (m,), and
        its points among those, (m, n): values at all of them are found at once."""
        elements, row = np.unique(self._elements, return_inverse=True)
        middle = np.round(2 * self._points.mean(axis=2)).astype(int) @ [3, 1]
        _, first, side = np.unique(middle, return_index=True, return_inverse=True)
        points = self.geometry.inside(np.hstack([np.empty((2, 0)), *self._points[first]]))
        return elements, points, row, N_EDGE * side[:, None] + np.arange(N_EDGE)

    def _picked(self, values: np.ndarray) -> np.ndarray:
        """Values (m, n) of the edges from those (k, p) of their elements."""
        _, _, row, column = self._inner
        return np.asarray(values[row[:, None], column])

    def _at_edges(self, quantity: Callable[[np.ndarray, np.ndarray], np.ndarray], n: int) -> np.ndarray:
        """A quantity (k, n, p) of points and elements, at the points of all edges: (n, m, points)."""
        elements, points, _, _ = self._inner
        if not len(elements):
            return np.zeros((n, 0, N_EDGE))
        return np.stack([self._picked(one) for one in quantity(points, elements).swapaxes(0, 1)])

    def fields(self, moments: Moments) -> Fields:
        """Of moments that balance without forces between the edges."""
        inside = self.geometry.inside(BILINEAR[0])
        M = moments(BILINEAR[0], None)
        Q = balancing(self.geometry, M, inside)
        t, n, _ = self._frame
        at_edges = self._at_edges(moments, 3)
        twisting = n[0] * t[0] * at_edges[0] + n[1] * t[1] * at_edges[1] + (n[0] * t[1] + n[1] * t[0]) * at_edges[2]
        forces = self._at_edges(lambda points, elements: balancing(self.geometry, M[elements], points, elements), 2)
        return Fields(Q, twisting, self._sliding(forces))

    def of_state(self, model: Model, x: np.ndarray) -> Fields:
        """Of a state under its loads, at unknowns x of a model.

        Eccentric weight takes part in the balance, and moments on edges twist them.
        """
        of = moments_of_small if model.linear else moments_of
        return self.loaded(self.fields(of(self.system, x, self.case)), model.q(x))

    def loaded(self, fields: Fields, q: np.ndarray) -> Fields:
        """Fields of moments that balance the system's loads: its eccentric weight, and moments on its edges."""
        inside = self.geometry.inside(BILINEAR[0])
        more, Q, sliding = coupled(self.system, q, inside, self.case), fields.Q, fields.sliding
        if more is not None:
            Q = Q + more

            def forces_at(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
                return np.asarray(coupled(self.system, q, points, self.case, elements))

            forces = self._at_edges(forces_at, 2)
            sliding = sliding + self._sliding(forces)
        return Fields(Q, fields.twisting - self._applied, sliding)

    def _sliding(self, forces: np.ndarray) -> np.ndarray:
        """Shear strain along the edges (m, n) of shear forces there, (2, m, n)."""
        return _product(self._frame[0], _compliance(self._edges), forces)

    @property
    def _applied(self) -> np.ndarray:
        """Twisting moments that loads apply along the edges, (n_facets, n): t . (m x e3) of a moment m."""
        out, (t, _, e) = np.zeros(self._lengths.shape), self._frame
        along = np.einsum("amn,aimn->imn", t, e[:2])
        at = self.geometry.parameters(self._points, self._elements)
        acting = (load.acting for load in self.system.loads if isinstance(load, LoadTerm))
        for m in (load.edge_moments(self._facets, at, self.case) for load in acting):
            if m is not None:
                out += (along * cross(m, e[2])).sum(axis=0)
        return out

    def product(self, one: Fields, two: Fields) -> float:
        """F of two."""
        return float(self.shares(one, two).sum())

    def shares(self, one: Fields, two: Fields) -> np.ndarray:
        """What each element has in F, (n_elements,)."""
        compliance = _compliance(self._inside)
        of = "ep" * (compliance.ndim > 2)
        inside = np.einsum(f"eip,{of}ij,ejp,ep->e", one.Q, compliance, two.Q, self._areas)
        along = self._layer * one.twisting * two.twisting - one.sliding * two.twisting - one.twisting * two.sliding
        return inside + np.bincount(self._elements, (along * self._lengths).sum(axis=1), minlength=len(inside))

    @cached_property
    def _layer(self) -> np.ndarray:
        """c, (n_facets, n)."""
        t, n, _ = self._frame
        twist = np.stack([n[0] * t[0], n[1] * t[1], n[0] * t[1] + n[1] * t[0]])
        bend = np.stack([n[0] ** 2, n[1] ** 2, 2 * n[0] * n[1]])
        D66, D16, D11 = (_product(one, self._edges.pure_bending(), two)
                         for one, two in ((twist, twist), (twist, bend), (bend, bend)))  # fmt: skip
        return np.asarray(np.sqrt(_product(t, _compliance(self._edges), t) / (D66 - D16**2 / D11)))


def _compliance(section: Section) -> np.ndarray:
    """Of transverse shear, S^-1, (2, 2)."""
    return np.asarray(np.linalg.inv(section.shear_stiffness()))


def _width(section: Section) -> Any:
    """Of an edge layer, in the mean over both directions (m)."""
    return np.sqrt(section.pure_bending()[..., 2, 2] * np.trace(_compliance(section), axis1=-2, axis2=-1) / 2)


def _product(one: np.ndarray, matrix: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Of vectors (k, m, n) with one matrix (k, k), or one for each place: (m, n)."""
    return np.asarray(np.einsum(f"amn,{'mn' * (matrix.ndim > 2)}ab,bmn->mn", one, matrix, two))


def share_of(product: float, energy: float, heat: float) -> float:
    """F(u, u) over twice the strain energy; zero where a temperature change of the energy ``heat`` strains a body freely, so
    that both are rounding."""
    return 0.0 if energy <= SAME_VALUE * heat else product / (2 * energy)
