"""Theory `full` on a mesh: forces, stresses, tangents, and strains at any point."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, cast

import numpy as np

from skancf.errors import InputError
from skancf.kernels.constants import FUNCTIONS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.curved import require_one_side
from skancf.materials.law import IN_PLANE
from skancf.materials.parallel import TRACE, principal_curvatures, sums
from skancf.terms.protocols import Heat
from skancf.terms.shells.full_sections import Sections, build_sections
from skancf.terms.shells.shell import CompiledAssembly
from skancf.theories.full import kernels, residual_kernel, tangent_kernel
from skancf.theories.full.nodes import N_POSITION
from skancf.theories.full.theory import D1, D2, N_IN_PLANE, N_STRAINS, R1, R2, D, Full, covariant_to_local, jet_table, strain
from skancf.tolerances import ROUNDED_PLACE

ALL, BENDING = slice(None), slice(3, N_IN_PLANE)
"""All strains, and those with slopes of the director."""
SHEARED = [4, 3]
"""The stresses 13 and 23."""


class FullAssembly(CompiledAssembly):
    """See :class:`skancf.terms.protocols.Assembly`."""

    residual_kernel, stress_kernel, tangent_kernel = residual_kernel.residual, kernels.stresses, tangent_kernel.tangent
    recovers_bending = True
    resultant_points = 2
    """Gauss points in each layer that section forces are integrated with."""

    def __init__(self, geometry: Geometry, section: Section | SectionsOnMesh, schedule: Schedule):
        super().__init__(geometry, section, schedule)
        if not geometry.integration.shared:
            raise InputError("theory 'full' has the Gauss points in all elements, as its force takes many at once; "
                             "take theory 'kirchhoff'")  # fmt: skip
        self.theory = cast(Full, geometry.theory)
        self.sections = build_sections(geometry, section)
        points = self.theory.quadrature[0]
        here = section.at(points)
        bottom, top = here.z[..., 0], here.z[..., -1]
        if (np.abs(bottom + top) > ROUNDED_PLACE * np.asarray(here.thickness)).any():
            require_one_side(principal_curvatures(self._curvature(points)), [bottom, top])
        self._tables = _tables(self.theory, self.sections)
        parts = self.sections
        self._elements = kernels.Elements(parts.shape, parts.reference, parts.law, parts.sampled)

    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        out = np.zeros_like(self.geometry.undeformed)
        self.schedule.run(residual_kernel.force_of, q, stresses, self._tables, self.geometry.maps, self._elements, out)
        return out

    def force_between(self, q0: np.ndarray, q1: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        return self.force_of(0.5 * (q0 + q1), stresses)  # strains are quadratic

    @cached_property
    def mass_shapes(self) -> np.ndarray:
        r, d = self.geometry.theory.position_table(self.geometry.theory.quadrature[0])
        m0, m1, m2 = np.moveaxis(self.sections.moments, 1, 0)
        return (
            np.einsum("ap,bp,sp->sab", r, r, m0)
            + np.einsum("ap,bp,sp->sab", r, d, m1)
            + np.einsum("ap,bp,sp->sab", d, r, m1)
            + np.einsum("ap,bp,sp->sab", d, d, m2)
        )

    def thermal_stresses(self, temperature: Heat) -> np.ndarray:
        free, laws, to_local, volume = self._heated(temperature)
        stress = np.einsum(f"z{_of(laws)}pq,zevq,zev->zevp", laws, free, volume)
        return np.ascontiguousarray(np.einsum("zpkev,zevp->ekv", to_local, stress, optimize=True))

    def thermal_energy(self, temperature: Heat) -> float:
        free, laws, _, volume = self._heated(temperature)
        return float(0.5 * np.einsum(f"zevp,z{_of(laws)}pq,zevq,zev->", free, laws, free, volume, optimize=True))

    def _heated(self, temperature: Heat) -> tuple[np.ndarray, ...]:
        """Free strains, laws, from the strains to those in the local frame, and volumes, at all integration points: the
        layers' points first."""
        geometry, (points, weights) = self.geometry, self.geometry.theory.quadrature
        section, (middle, gradient) = self.section.at(points), temperature(points)
        z, thicknesses, laws = section.through(self.theory.n_thickness)
        free = np.stack([section.thermal_strain_of_one_director(depth, middle, gradient) for depth in z])
        jets = geometry.theory.jets(geometry.undeformed_local, points)
        to_local, volume = covariant_to_local(jets, geometry.tangents(points), z)
        return free, laws, to_local, volume * weights * over_points(thicknesses)

    def section_forces(
        self,
        q: np.ndarray,
        points: np.ndarray,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        z, w, stress = self._through_thickness(
            lambda depth: self.strains(q, points, depth, temperature, small, elements), points, temperature, small, elements
        )
        return self._resultants(z, w, stress, points, elements)

    def bending_forces(self, q: np.ndarray, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """The part of the section forces (m, 6, n) that slopes of the director make."""
        z, w, stress = self._through_thickness(
            lambda depth: self.bending_strains(q, points, depth, elements), points, elements=elements
        )
        return self._resultants(z, w, stress, points, elements)

    def shear_forces(
        self,
        q: np.ndarray,
        points: np.ndarray,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        z, w, stress = self._through_thickness(
            lambda depth: self.strains(q, points, depth, temperature, small, elements), points, temperature, small, elements
        )
        b11, b22, b12 = np.moveaxis(self._curvature(points, elements), -1, 0)
        t1, t2 = np.moveaxis(stress[..., SHEARED], -1, 0)
        z, w = over_points(z), over_points(w)
        across = [t1 - z * (b22 * t1 - b12 * t2), t2 - z * (b11 * t2 - b12 * t1)]
        return np.stack([(w * part).sum(axis=0) for part in across], axis=1)

    def _through_thickness(
        self, strains: Callable[[Any], np.ndarray], points: np.ndarray, temperature: np.ndarray | None = None,
        small: bool = False, elements: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
        """Heights, their weights, and stresses (n_z, m, n, 6) there of strains (m, n, 6) at a depth."""
        section = self.section.at(points, elements)
        z, w, _ = section.through(self.resultant_points)
        return z, w, np.stack([self.stress_of(strains(depth), section, depth, temperature, small) for depth in z])

    def _resultants(
        self, z: np.ndarray, w: np.ndarray, stress: np.ndarray, points: np.ndarray, elements: np.ndarray | None
    ) -> np.ndarray:
        """N and M (m, 6, n) of stresses through the thickness."""
        plane = stress[..., IN_PLANE]
        plane = plane - over_points(z)[..., None] * np.einsum("epij,zepj->zepi", self._shorter(points, elements), plane)
        return np.concatenate([np.einsum("zep,zepi->eip", over_points(w * z**k), plane) for k in (0, 1)], axis=1)

    def _shorter(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """What lengths at a height take from a stress 11, 22, 12 per length of the reference surface: (m, n, 3, 3) (1/m)."""
        b = self._curvature(points, elements)
        return (b @ TRACE)[..., None, None] * np.eye(3) - 0.5 * sums(b).swapaxes(-1, -2)

    def _curvature(self, points: np.ndarray, elements: np.ndarray | None = None) -> np.ndarray:
        """Undeformed curvatures 11, 22, 12 in the local frame at points (2, n) of elements: (m, n, 3) (1/m)."""
        geometry = self.geometry
        jets = geometry.theory.jets(geometry.undeformed_local[slice(None) if elements is None else elements], points)
        to_local, _ = covariant_to_local(jets, geometry.tangents(points, elements), np.zeros(1))
        doubled = np.einsum("ikep,kep->epi", to_local[0][[0, 1, 5], :3], strain(jets)[3:6])
        return np.asarray(-doubled / [1.0, 1.0, 2.0])

    def section_force_gradient(
        self, q: np.ndarray, elements: np.ndarray, points: np.ndarray, weights: np.ndarray, part: slice = ALL
    ) -> np.ndarray:
        geometry, theory = self.geometry, self.theory
        z, w, laws = self.section.at(points, elements).through(2)
        jets = theory.jets(geometry.undeformed_local[elements], points)
        to_local, _ = covariant_to_local(jets, geometry.tangents(points, elements), z)
        depths, shares = over_points(z)[:, :, None], over_points(w)[:, :, None]
        plane = shares * (weights[:, :3] + depths * weights[:, 3:])
        plane = plane - depths * np.einsum("enij,zein->zejn", self._shorter(points, elements), plane)
        stresses, rows = np.zeros((len(elements), N_STRAINS, points.shape[1])), laws[..., IN_PLANE, :]
        stresses[:, part] = np.einsum(
            f"zvken,z{_of(laws, 'en')}cv,zecn->ekn", to_local[:, :, part], rows, plane, optimize=True
        )
        return geometry.nodal(theory.strain_forces(geometry.local(q, elements), points, stresses), elements)

    @staticmethod
    def _free_in(section: Section, z: Any, temperature: np.ndarray) -> np.ndarray:
        return section.thermal_strain_of_one_director(z, *temperature)

    def strains(
        self,
        q: np.ndarray,
        points: np.ndarray,
        z: Any,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        return self._strains(q, points, z, ALL, elements)

    def bending_strains(self, q: np.ndarray, points: np.ndarray, z: Any, elements: np.ndarray | None = None) -> np.ndarray:
        """The part of :meth:`strains` that slopes of the director make."""
        return self._strains(q, points, z, BENDING, elements)

    def _strains(self, q: np.ndarray, points: np.ndarray, z: Any, part: slice, elements: np.ndarray | None) -> np.ndarray:
        geometry, theory = self.geometry, self.geometry.theory
        before = geometry.undeformed_local[slice(None) if elements is None else elements]
        change = theory.strains(geometry.local(q, elements), points) - theory.strains(before, points)
        jets = theory.jets(before, points)
        to_local, _ = covariant_to_local(jets, geometry.tangents(points, elements), np.asarray(z)[None])
        return np.einsum("vken,ekn->env", to_local[0][:, part], change[:, part], optimize=True)


def _of(laws: np.ndarray, places: str = "ev") -> str:
    """Subscripts of places, of laws that have axes for them."""
    return places if laws.ndim > 3 else ""


def over_points(values: np.ndarray) -> np.ndarray:
    """Values through the thickness (k,) of all places, or of each, (k, m, n), as (k, 1, 1) or (k, m, n)."""
    return values.reshape(len(values), *(values.shape[1:] or (1, 1)))


def _tables(theory: Full, sections: Sections) -> kernels.Tables:
    inside, sampled = jet_table(theory.quadrature[0]), jet_table(theory.samples)
    interpolation, rows = theory.sampling()
    position = np.ascontiguousarray(inside[[R1, R2], :N_POSITION].swapaxes(0, 1))
    director = np.ascontiguousarray(inside[[D1, D2], N_POSITION:].swapaxes(0, 1))
    k, l = sections.pairs.T
    return kernels.Tables(
        position=position,
        director=director,
        position_columns=np.ascontiguousarray(inside[[R1, R2]].swapaxes(1, 2).reshape(-1, FUNCTIONS)),
        director_columns=np.ascontiguousarray(director.reshape(4, -1).T),
        jets=np.ascontiguousarray(inside[[R1, R2, D1, D2]].transpose(2, 0, 1)),
        sample_position=np.ascontiguousarray(sampled[[R1, R2], :N_POSITION].transpose(0, 2, 1)),
        sample_director=np.ascontiguousarray(sampled[[D1, D2, D], N_POSITION:].transpose(0, 2, 1)),
        interpolation=interpolation,
        plain=not theory.assumed,
        sample_rows=rows,
        pairs=sections.pairs,
        coupled=bool(((k < N_IN_PLANE) & (l >= N_IN_PLANE)).any()),
    )
