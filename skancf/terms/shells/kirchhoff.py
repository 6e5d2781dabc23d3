"""Theory `kirchhoff` on a mesh: forces, stresses, tangents, and strains at any point."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, cast

import numpy as np

from skancf.kernels.constants import FUNCTIONS, POINTS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.points import IntegrationPoints
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.curved import CurvedSection, times
from skancf.materials.section import IN_PLANE, OUT_OF_PLANE
from skancf.terms.protocols import Heat
from skancf.terms.shells.kirchhoff_sections import build_thin_sections, local_curvature
from skancf.terms.shells.shell import CompiledAssembly
from skancf.theories.kirchhoff import between_kernel, kernels, tangent_kernel
from skancf.theories.kirchhoff.kernels import N_MEMBRANE, N_STRAINS
from skancf.theories.kirchhoff.theory import KEPT, Kirchhoff, covariant_to_local, jet_table, legendre
from skancf.tolerances import ROUNDED_VALUE

PLAIN = Kirchhoff(assumed=False)


class ThinAssembly(CompiledAssembly):
    """See :class:`skancf.terms.protocols.Assembly`."""

    residual_kernel, stress_kernel, tangent_kernel = kernels.residual, kernels.stresses, tangent_kernel.tangent
    assumes_membrane = True

    def __init__(self, geometry: Geometry, section: Section | SectionsOnMesh, schedule: Schedule):
        super().__init__(geometry, section, schedule)
        self.sections = build_thin_sections(geometry, section)
        theory = cast(Kirchhoff, geometry.theory)
        self._tables = _tables(theory, geometry.integration, self.sections.pairs)
        parts = self.sections
        self._elements = kernels.Elements(parts.shape, parts.points, parts.reference, parts.law, parts.assumed, parts.rest)

    def curved_at(self, points: np.ndarray, elements: np.ndarray | None = None) -> CurvedSection:
        """The section on the curved surface at local points (2, n) of elements (m,), or of all."""
        return self._everywhere or CurvedSection(self.section.at(points, elements))

    @cached_property
    def _everywhere(self) -> CurvedSection | None:
        """The one of a plate that is everywhere the same."""
        return CurvedSection(self.section) if isinstance(self.section, Section) else None

    @cached_property
    def couples(self) -> bool:
        """Whether bending strains the reference surface, somewhere."""
        curved = self.curved_at(self.geometry.integration.local)
        return bool(curved.section.abd()[..., :3, 3:].any()) or not curved.centred

    @property
    def plain_elements(self) -> kernels.Elements:
        """Elements whose membrane strains are taken as they are."""
        return self._elements._replace(assumed=np.zeros_like(self._elements.assumed))

    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        out = np.zeros_like(self.geometry.undeformed)
        self.schedule.run(kernels.force_of, q, stresses, self._tables, self.geometry.maps, self._elements, out)
        return out

    def force_between(self, q0: np.ndarray, q1: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        out = np.zeros_like(self.geometry.undeformed)
        self.schedule.run(
            between_kernel.force_between, q0, q1, stresses, self._tables, self.geometry.maps, self._elements, out
        )
        return out

    @cached_property
    def mass_shapes(self) -> np.ndarray:
        masses = self.sections.moments[:, 0]

        def products(points: np.ndarray, shapes: np.ndarray) -> np.ndarray:
            table = self.geometry.theory.position_table(points)[0]
            return np.einsum("ap,bp,sp->sab", table, table, masses[shapes])

        return self.geometry.integration.gathered(products, self.sections.points)

    @property
    def _sampled(self) -> np.ndarray:
        """Which elements have points of their own and assumed membrane strains, made of those at the Gauss points: (n,)."""
        sections = self.sections
        return np.asarray(((sections.points > 0) & (sections.assumed > 0))[sections.shape])

    def thermal_stresses(self, temperature: Heat) -> np.ndarray:
        return self._initial_stresses(self._free_strains(temperature))

    def thermal_energy(self, temperature: Heat) -> float:
        strains, sections, points = self._free_strains(temperature), self.sections, self.geometry.integration.local
        left = self.curved_at(points).energy_left(sections.curvature[sections.shape], *temperature(points))
        return float(0.5 * np.vdot(strains, self._initial_stresses(strains)) + np.vdot(self.areas, left))

    def _free_strains(self, temperature: Heat, of: Callable[..., np.ndarray] = CurvedSection.free_strains) -> np.ndarray:
        """Covariant strains (n_elements, 6 or 9, n_points) that a temperature change makes without section forces; ``of`` a
        curved section, its curvatures, T0 and T1 in the local frame."""
        sections, geometry = self.sections, self.geometry

        def covariant(
            curved: CurvedSection, curvature: np.ndarray, turn: np.ndarray, middle: np.ndarray, gradient: np.ndarray
        ) -> np.ndarray:
            free = of(curved, curvature, middle, gradient)
            return np.moveaxis(np.linalg.solve(turn, free[..., None])[..., 0], 1, 2)

        turn, local = np.moveaxis(sections.turn[sections.shape], 3, 1), geometry.integration.local
        out = covariant(self.curved_at(local), sections.curvature[sections.shape], turn, *temperature(local))
        if geometry.integration.shared:
            return out
        points, sampled = geometry.theory.quadrature[0], np.flatnonzero(self._sampled)
        more = np.zeros((len(out), N_MEMBRANE, POINTS))
        turn, curvature = self._frame(points, sampled)
        middle, gradient = (values[sampled] for values in temperature(points))
        curved, turn = self.curved_at(points, sampled), turn.transpose(2, 3, 0, 1)
        more[sampled] = covariant(curved, curvature, turn, middle, gradient)[:, :N_MEMBRANE]
        return np.concatenate([out, more], axis=1)

    def _initial_stresses(self, strains: np.ndarray) -> np.ndarray:
        """Stresses of covariant strains, both (n_elements, 6 or 9, n_points), assumed as those of a motion are.

        So that a free expansion, whose strains no polynomial may hold, is free of stress.
        """
        sections = self.sections
        projection = self._tables.projections[sections.assumed[sections.shape]]
        k, l = sections.pairs.T
        law = np.zeros((len(sections.law), N_STRAINS, N_STRAINS, strains.shape[2]))
        law[:, k, l] = law[:, l, k] = sections.law
        law, rest = law[sections.shape], sections.rest[sections.shape]
        hat = strains[:, :N_STRAINS].copy()
        hat[:, :3] = np.einsum("ecsp,ecs->ecp", projection, self._before_projection(strains))
        stress = np.einsum("eklp,elp->ekp", law, hat)
        left = strains[:, :3] - hat[:, :3]
        extra = np.einsum("ek,eklp,el,elp->ekp", rest, law[:, :3, :3], rest, left, optimize=True)
        back = np.einsum("ecsp,ecp->ecs", projection, stress[:, :3] - extra)
        if self.geometry.integration.shared:
            stress[:, :3] = extra + back
            return np.ascontiguousarray(stress)
        sampled = self._sampled[:, None, None]
        stress[:, :3] = extra + np.where(sampled, 0.0, back)
        return np.concatenate([stress, np.where(sampled, back, 0.0)], axis=1)

    def _before_projection(self, strains: np.ndarray) -> np.ndarray:
        """Of strains (n_elements, 6 or 9, n_points) the membrane strains that the assumed ones are made of."""
        if self.geometry.integration.shared:
            return strains[:, :N_MEMBRANE]
        return np.where(self._sampled[:, None, None], strains[:, N_STRAINS:], strains[:, :N_MEMBRANE])

    def membrane_rest(self, q: np.ndarray) -> np.ndarray:
        """What the assumed membrane strains leave out of those of the motion at the integration points: covariant,
        (n_elements, 3, n_points)."""
        geometry, sections = self.geometry, self.sections
        now, before = geometry.local(q), geometry.undeformed_local

        def change_at(points: np.ndarray, e: np.ndarray) -> np.ndarray:
            undeformed = PLAIN.strains(before[e], points)[:, :3]
            change = PLAIN.strains(now[e], points)[:, :3] - undeformed
            rounding = np.abs(change) < ROUNDED_VALUE * np.abs(undeformed).max(axis=(1, 2), keepdims=True)
            return np.asarray(np.where(rounding & (change.imag == 0), 0.0, change))

        change = source = geometry.integration.gathered(change_at)
        if not geometry.integration.shared:
            at_gauss = change_at(geometry.theory.quadrature[0], np.arange(geometry.n_elements))
            source = np.where(self._sampled[:, None, None], at_gauss, change)
        projection = self._tables.projections[sections.assumed[sections.shape]]
        return np.asarray(change - np.einsum("ecsp,ecs->ecp", projection, source))

    def rest_energy(self, rest: np.ndarray) -> float:
        """Energy of :meth:`membrane_rest`, with the small factors that it counts with."""
        sections = self.sections
        counted = sections.rest[sections.shape][:, :, None] * rest
        energy = 0.0
        for law, (k, l) in zip(sections.law[sections.shape].swapaxes(0, 1), sections.pairs, strict=True):
            if max(k, l) < 3:
                energy += (0.5 if k == l else 1.0) * float(np.vdot(counted[:, k], law * counted[:, l]))
        return energy

    def section_strains(
        self, q: np.ndarray, points: np.ndarray, elements: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """At points (2, n) of all elements or of some, (m,): membrane strains and curvature changes in the local frame
        (m, n, 6), and undeformed curvatures (m, n, 3)."""
        geometry, theory = self.geometry, self.geometry.theory
        elements = np.arange(geometry.n_elements) if elements is None else elements
        now, before = geometry.local(q, elements), geometry.undeformed_local[elements]
        change = theory.strains(now, points) - theory.strains(before, points)
        plain = self._plain(elements)
        if theory.assumed and len(plain):
            change[plain] = PLAIN.strains(now[plain], points) - PLAIN.strains(before[plain], points)
        turn, b = self._frame(points, elements)
        return np.asarray(np.einsum("ikep,ekp->epi", turn, change)), b

    def _frame(self, points: np.ndarray, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """At points (2, n) of elements: from covariant strains to local ones (6, 6, m, n), and curvatures (m, n, 3)."""
        geometry = self.geometry
        jets = geometry.theory.jets(geometry.undeformed_local[elements], points)
        turn, _ = covariant_to_local(jets, geometry.tangents(points, elements), geometry.side[elements])
        return turn, local_curvature(jets, turn)

    def section_forces(
        self, q: np.ndarray, points: np.ndarray, temperature: np.ndarray | None, elements: np.ndarray | None = None,
        small: bool = False,
    ) -> np.ndarray:  # fmt: skip
        """As the protocol has it, of all elements or of some, (m,)."""
        (strains, b), curved = self.section_strains(q, points, elements), self.curved_at(points, elements)
        if temperature is not None:
            strains = strains - curved.free_strains(b, *temperature)
        return np.asarray(curved.forces(b, (curved.law(b) @ strains[..., None])[..., 0]).swapaxes(1, 2))

    def _law_at(
        self, curved: CurvedSection, q: np.ndarray, points: np.ndarray, elements: np.ndarray, b: np.ndarray
    ) -> np.ndarray:
        """Derivative of forces and moments by the strains on which they do work, (m, n, 6, 6)."""
        return curved.law(b)

    def section_force_gradient(
        self, q: np.ndarray, elements: np.ndarray, points: np.ndarray, weights: np.ndarray
    ) -> np.ndarray:
        geometry, theory = self.geometry, cast(Kirchhoff, self.geometry.theory)
        (turn, b), curved = self._frame(points, elements), self.curved_at(points, elements)
        law = curved.forces(b[..., None, :], self._law_at(curved, q, points, elements, b))  # rows are symmetric to columns
        stresses = np.einsum("ikep,epij,ejp->ekp", turn, law, weights, optimize=True)
        local = geometry.local(q, elements)
        forces = theory.strain_forces(local, points, stresses)
        plain = self._plain(elements)
        forces[plain] = PLAIN.strain_forces(local[plain], points, stresses[plain])
        return geometry.nodal(forces, elements)

    def _plain(self, elements: np.ndarray) -> np.ndarray:
        """Which of some elements take their membrane strains as they are, as positions among them."""
        return np.flatnonzero(self.sections.assumed[self.sections.shape[elements]] == 0)

    def strains(
        self,
        q: np.ndarray,
        points: np.ndarray,
        z: Any,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        parts, b = self.section_strains(q, points, elements)
        free = np.zeros(6) if temperature is None else self._free_in(self.section.at(points, elements), z, temperature)
        out, curved = free + np.zeros((*b.shape[:-1], 6), parts.dtype), self.curved_at(points, elements)
        elastic = curved.strain_at(b, z, parts, temperature) - out[:, :, IN_PLANE]
        out[:, :, IN_PLANE] += elastic
        # The others follow from S33 = S23 = S13 = 0.
        out[:, :, OUT_OF_PLANE] += times(curved.section.condensed(z), elastic)
        return out


def _tables(theory: Kirchhoff, integration: IntegrationPoints, pairs: np.ndarray) -> kernels.Tables:
    """Tables of all kinds of integration points."""
    tables = np.stack([jet_table(points) for points in integration.points])
    kept = np.stack([np.hstack([legendre(points, numbers) for numbers in KEPT]).T for points in integration.points])
    identity = np.stack([np.eye(POINTS)] * N_MEMBRANE)
    projections = np.stack([identity, *[theory.interpolation(points) for points in integration.points]])
    n = len(tables)
    return kernels.Tables(
        table=np.ascontiguousarray(tables.transpose(0, 2, 1, 3).reshape(n, FUNCTIONS, -1)),
        jets=np.ascontiguousarray(tables.transpose(0, 1, 3, 2).reshape(n, -1, FUNCTIONS)),
        slopes=np.ascontiguousarray(tables[:, :2].transpose(0, 3, 1, 2).reshape(n, -1, FUNCTIONS)),
        projections=projections,
        transposed=np.ascontiguousarray(projections.swapaxes(2, 3)),
        kept=np.ascontiguousarray(kept),
        fit=np.ascontiguousarray(kept[0]) * integration.weights[0],
        pairs=pairs,
    )
