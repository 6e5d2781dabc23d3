r"""Theory `full` on a mesh with laws at points through the thickness, which are not linear in the strain.

The theory has one strain across through the thickness, and a law in three dimensions that couples it to the others would
make bending stiffer by :math:`(1 - \nu)^2 / (1 - 2 \nu)`. So at each integration point there is a strain across besides,
:math:`z\,\alpha`, with the :math:`\alpha` of the least energy: an enhanced assumed strain, eliminated where it is.
Transverse shear strains go into the law times the root of its shear correction factor.

References
----------
N. Buechter and E. Ramm, 3d-extension of nonlinear shell equations based on the enhanced assumed strain concept, in
*Computational Methods in Applied Sciences* (1992) 55-62.
"""

from typing import Any

import numpy as np

from skancf.kernels.constants import POINTS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.free_stretch import FreeStretch, free_stretch
from skancf.materials.law import IN_PLANE, THICKNESS, TRANSVERSE
from skancf.materials.own_point_law import OwnPointLaw
from skancf.materials.point_law import PointResponse, require_solid
from skancf.terms.protocols import Heat
from skancf.terms.shells.full import FullAssembly, over_points
from skancf.terms.shells.points import NOWHERE, Answer, AtPoints, of_places, square
from skancf.theories.full import kernels, point_kernels
from skancf.theories.full.theory import N_STRAINS, covariant_to_local
from skancf.tolerances import LAST_STEP

EVERY_PAIR = np.array([(k, l) for k in range(N_STRAINS) for l in range(k, N_STRAINS)])
PAIRS = np.array([(k, l) for k in range(6) for l in range(k, 6)])
ACROSS = 11
"""Entry 33, 33 among the 21 of a stiffness."""
ITERATIONS = 25
LARGEST_STEP = 0.5
"""Part of the smallest C33 that one step may take away."""


class FullPointAssembly(AtPoints, FullAssembly):
    """See :class:`skancf.terms.protocols.Assembly`."""

    every_pair = EVERY_PAIR
    recovers_bending, resultant_points = False, 4

    def __init__(self, geometry: Geometry, section: Section | SectionsOnMesh, schedule: Schedule):
        for law in getattr(section.points_law, "laws", (section.points_law,)):
            require_solid(getattr(law, "material", law) if isinstance(law, OwnPointLaw) else law)
        super().__init__(geometry, section, schedule)
        shape, n = self.sections.shape, geometry.n_elements
        representative = np.unique(shape, return_index=True)[1]
        points, weights = self.theory.quadrature
        P, volume = self._matrices(points, representative)
        self._heights = self._through(section.at(points))
        self._arms = _arms(section.at(points), self._heights[0])
        arms = over_points(_arms(*self._at(points, representative)))
        self._arms_of_shapes = np.ascontiguousarray(np.moveaxis(np.broadcast_to(arms, volume.shape), 0, 1))
        self._matrix = np.ascontiguousarray(P.transpose(3, 0, 1, 2, 4))
        self._volume = np.ascontiguousarray(np.moveaxis(volume * weights, 0, 1))
        self._own = kernels.Elements(np.arange(n, dtype=shape.dtype), np.empty((0, 0, 0)), np.empty((0, 0, 0)),
                                     np.empty((0, 0, 0)))  # fmt: skip
        self._law_tables = self._tables._replace(pairs=EVERY_PAIR, coupled=True)

    def _matrices(self, points: np.ndarray, elements: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """From the 14 strains to those that the law sees, at heights and points of elements, (n_z, 6, 14, m, n), and volumes
        with the weights of the heights, (n_z, m, n)."""
        geometry, (z, weights) = self.geometry, self._through(self.section.at(points, elements))
        local = geometry.undeformed_local[slice(None) if elements is None else elements]
        P, volume = covariant_to_local(self.theory.jets(local, points), geometry.tangents(points, elements), z)
        P[:, TRANSVERSE] *= self._sheared
        return P, volume * over_points(weights)

    def _through(self, section: Section) -> tuple[np.ndarray, np.ndarray]:
        """Heights of points through the thickness, and their weights, (n_z,) or (n_z, m, n)."""
        z, weights, _ = section.points(self.theory.n_thickness)
        return np.moveaxis(z, -1, 0), np.moveaxis(weights, -1, 0)

    def _at(self, points: np.ndarray, elements: np.ndarray | None = None) -> tuple[Section, np.ndarray]:
        """The section at points of elements, and heights in it."""
        section = self.section.at(points, elements)
        return section, self._through(section)[0]

    @property
    def _sheared(self) -> float:
        """Root of the shear correction factor."""
        return float(np.sqrt(getattr(self.law, "shear_correction", 1.0)))

    def _ask(self, q: np.ndarray, change: np.ndarray = NOWHERE) -> Answer:
        everything, _ = self._seen(q, change)
        n, (z, _), shape = len(everything), self._heights, self.sections.shape
        local = np.empty((6, len(z), n, POINTS))
        self.schedule.run(point_kernels.to_local, everything, shape, self._matrix, local)
        volume = np.moveaxis(self._volume[shape], 1, 0)
        _, found = self._balanced(self.law, self._arms, local, volume, self._free)
        stress, law = np.empty_like(everything), np.empty((n, len(EVERY_PAIR), POINTS))
        parts = (part.reshape(-1, *local.shape[1:]) for part in (found.stress, found.stiffness))
        places = (self._arms_of_shapes, shape, self._matrix, self._volume)
        self.schedule.run(point_kernels.integrate, *parts, *places, stress, law)
        energy = (found.energy.reshape(local.shape[1:]) * volume).sum(axis=0)
        return Answer(q.copy(), self.heat, everything, everything, energy, stress, law, found.code.reshape(local.shape[1:]))

    _free: FreeStretch | None = None

    def _warmed(self) -> None:
        assert self.heat is not None
        self._free = _free_stretch(self.law, self._heights[0], self.heat)

    @staticmethod
    def _balanced(
        law: Any, arms: np.ndarray, local: np.ndarray, volume: np.ndarray, free: FreeStretch | None
    ) -> tuple[np.ndarray, PointResponse]:
        r"""The factor of the strain across that is linear in z, (...), and what the law then says of all points.

        Newton's method for :math:`\int z \sigma_{33} dV = 0` at strains (6, n_z, ...), with volumes (n_z, ...).
        """
        z = over_points(arms)
        alpha, size = np.zeros(local.shape[2:]), np.abs(z).max(axis=0)
        for _ in range(ITERATIONS):
            C = 1.0 * local
            C[THICKNESS] += alpha * z
            C[:3] = 1 + 2 * C[:3]
            found = _respond(law, C.reshape(6, -1), free)
            stress = found.stress[THICKNESS].reshape(volume.shape)
            slope = (volume * z * z * found.stiffness[ACROSS].reshape(volume.shape)).sum(axis=0)
            step = np.nan_to_num(-(volume * z * stress).sum(axis=0) / slope)  # zero where the law has no stress
            most = LARGEST_STEP * C[THICKNESS].min(axis=0) / (2 * size)
            if not (np.abs(step) * size > LAST_STEP).any():
                break
            alpha = alpha + np.clip(step, -most, most)
        return alpha, found

    def _seen(self, q: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shape = (self.geometry.n_elements, *self.sections.reference.shape[1:])
        strains, unused = np.empty(shape), np.empty(shape)
        kernel = type(self).stress_kernel
        self.schedule.run(kernel, q, change, self._tables, self.geometry.maps, self._elements, strains, unused)
        return strains, strains

    def _on_all(self, stress: np.ndarray, everything: np.ndarray, seen: np.ndarray) -> np.ndarray:
        return stress

    def _elements_with(self, law: np.ndarray, plain: bool) -> tuple[Any, Any]:
        tables, n_rows = self._law_tables, len(self._tables.sample_rows)
        if tables.plain:
            return tables, self._own._replace(law=law)
        sampled = np.empty((len(law), n_rows, n_rows))
        self.schedule.run(point_kernels.sampled_laws, law, tables.interpolation, tables.sample_rows, sampled)
        return tables, self._own._replace(law=law, sampled=sampled)

    def _membrane(self, answer: Answer, e: int, p: int) -> np.ndarray:
        middle = self._matrix[self.sections.shape[e], :, :, :, p].mean(axis=0)
        strain: np.ndarray = middle @ answer.everything[e, :, p]
        return strain[[0, 1, 5]]

    def thermal_stresses(self, temperature: Heat) -> np.ndarray:
        """To first order; of those across, what is linear in z relaxes."""
        points = self.theory.quadrature[0]
        _, stress, _ = self._held(*self._at(points), self._matrices(points)[1], *temperature(points))
        shape = self.sections.shape
        return np.ascontiguousarray(
            np.einsum("ezvkp,vzep,ezp->ekp", self._matrix[shape], stress, self._volume[shape], optimize=True)
        )

    def thermal_energy(self, temperature: Heat) -> float:
        volume = np.moveaxis(self._volume[self.sections.shape], 1, 0)
        points = self.theory.quadrature[0]
        free, stress, _ = self._held(*self._at(points), volume, *temperature(points))
        return 0.5 * float(np.einsum("vzep,vzep,zep->", free, stress, volume, optimize=True))

    def _held(
        self, section: Section, heights: np.ndarray, volume: np.ndarray, middle: np.ndarray, gradient: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Free strains and what stresses hold them back to first order, (6, n_z, m, n) each, where volumes are (n_z, m, n);
        and the factor of the strain across that is linear in z, (m, n)."""
        z = over_points(_arms(section, heights))
        change = middle + over_points(heights) * gradient
        free = np.multiply.outer(self.law.thermal_strain(), change)
        free[TRANSVERSE] *= self._sheared
        law = self._law_at_rest
        alpha = (volume * z * np.tensordot(law[THICKNESS], free, 1)).sum(axis=0) / (
            (volume * z * z).sum(axis=0) * law[THICKNESS, THICKNESS])  # fmt: skip
        moved = free.copy()
        moved[THICKNESS] -= alpha * z
        return free, np.tensordot(law, moved, 1), alpha

    @property
    def _law_at_rest(self) -> np.ndarray:
        """Stiffness (6, 6) of the undeformed state."""
        found = _respond(self.law, np.array([[1.0], [1.0], [1.0], [0.0], [0.0], [0.0]]), None)
        return square(found.stiffness, PAIRS, (1,))[0]

    def strains(
        self,
        q: np.ndarray,
        points: np.ndarray,
        z: Any,
        temperature: np.ndarray | None,
        small: bool = False,
        elements: np.ndarray | None = None,
    ) -> np.ndarray:
        if small and temperature is not None:
            out = self.strains(q, points, z, None, elements=elements)
            if not np.iscomplexobj(out):  # in the undeformed state
                section, heights = self._at(points, elements)
                held = self._held(section, heights, self._matrices(points, elements)[1], *temperature)[2]
                out[..., THICKNESS] += (z - _middle(section)) * held
            return out
        geometry, theory = self.geometry, self.theory
        before = geometry.undeformed_local[slice(None) if elements is None else elements]
        change = theory.strains(geometry.local(q, elements), points) - theory.strains(before, points)
        to_local, _ = covariant_to_local(theory.jets(before, points), geometry.tangents(points, elements), np.array([z]))
        out = np.einsum("vken,ekn->env", to_local[0], change, optimize=True)
        arm = z - _middle(self.section.at(points, elements))
        out[..., THICKNESS] += arm * self._across(change, points, temperature, elements)
        return out

    def _across(
        self, change: np.ndarray, points: np.ndarray, temperature: np.ndarray | None, elements: np.ndarray | None = None
    ) -> np.ndarray:
        """Factor of the strain across that is linear in z, (m, n), of strains (m, 14, n), complex ones too, at points."""
        alpha, rates = self._across_with_rates(change.real, points, temperature, elements)
        if not np.iscomplexobj(change):
            return alpha
        return np.asarray(alpha + 1j * np.einsum("ken,ekn->en", rates, change.imag))

    def stress_of(
        self, strains: np.ndarray, section: Section, z: Any, temperature: np.ndarray | None = None, small: bool = False
    ) -> np.ndarray:
        sheared = np.where(np.isin(np.arange(6), TRANSVERSE), self._sheared, 1.0)
        first_order = small or np.iscomplexobj(strains)
        C = np.moveaxis(np.zeros_like(strains.real) if first_order else strains * sheared, -1, 0).copy()
        C[:3] = 1 + 2 * C[:3]
        heat = None if small else temperature
        law = section.points_law
        found = _respond(law, C.reshape(6, -1), _free_stretch(law, np.array([z]), heat))
        self.warn_of(found.code)
        if first_order:
            matrix = square(found.stiffness, PAIRS, strains.shape[:-1])
            if small and temperature is not None and not np.iscomplexobj(strains):
                strains = strains - section.thermal_strain(z, *temperature)
            return np.asarray(sheared * (matrix @ (sheared * strains)[..., None])[..., 0])
        return np.asarray(sheared * of_places(found.stress, strains))

    def section_force_gradient(
        self, q: np.ndarray, elements: np.ndarray, points: np.ndarray, weights: np.ndarray, part: Any = None
    ) -> np.ndarray:
        geometry, theory, section = self.geometry, self.theory, self.section.at(points, elements)
        now, before = geometry.local(q, elements), geometry.undeformed_local[elements]
        change = theory.strains(now, points) - theory.strains(before, points)
        heat = None if self.temperature is None else np.asarray(self.temperature(points))[:, elements]
        alpha, rates = self._across_with_rates(change, points, heat, elements)
        z, w, _ = section.through(self.resultant_points)
        to_local, _ = covariant_to_local(theory.jets(before, points), geometry.tangents(points, elements), z)
        arms, stresses = over_points(_arms(section, z)), np.zeros_like(change)
        to_local[:, THICKNESS] += arms[:, None] * rates
        depths, shares = over_points(z)[:, :, None], over_points(w)[:, :, None]
        for height, depth, share, arm, rows in zip(z, depths, shares, arms, to_local, strict=True):
            plane = share * (weights[:, :3] + depth * weights[:, 3:])
            plane = plane - depth * np.einsum("enij,ein->ejn", self._shorter(points, elements), plane)
            strains = np.einsum("vken,ekn->env", rows, change)
            strains[..., THICKNESS] += arm * (alpha - np.einsum("ken,ekn->en", rates, change))
            law = self._law_of(section, strains, height, heat)[..., IN_PLANE, :]
            stresses += np.einsum("ecn,encv,vken->ekn", plane, law, rows, optimize=True)
        return geometry.nodal(theory.strain_forces(now, points, stresses), elements)

    def _law_of(self, section: Section, strains: np.ndarray, z: Any, heat: np.ndarray | None) -> np.ndarray:
        """Derivative of :meth:`stress_of` by the strains, (m, n, 6, 6)."""
        sheared = np.where(np.isin(np.arange(6), TRANSVERSE), self._sheared, 1.0)
        C = np.moveaxis(strains * sheared, -1, 0).copy()
        C[:3] = 1 + 2 * C[:3]
        law = section.points_law
        found = _respond(law, C.reshape(6, -1), _free_stretch(law, np.array([z]), heat))
        return np.asarray(square(found.stiffness, PAIRS, strains.shape[:-1]) * np.multiply.outer(sheared, sheared))

    def _across_with_rates(
        self, change: np.ndarray, points: np.ndarray, temperature: np.ndarray | None, elements: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Factor of the strain across that is linear in z, (m, n), and its derivative by the 14 strains (m, 14, n) at points
        of elements: (14, m, n)."""
        P, volume = self._matrices(points, elements)
        local = np.einsum("zvken,ekn->vzen", P, change, optimize=True)
        section, heights = self._at(points, elements)
        law, arm = section.points_law, over_points(_arms(section, heights))
        alpha, found = self._balanced(law, arm, local, volume, _free_stretch(law, heights, temperature))
        rows = square(found.stiffness, PAIRS, volume.shape)[..., THICKNESS, :]
        moved = np.einsum("zen,zenv,zvken->ken", volume * arm, rows, P, optimize=True)
        return alpha, -moved / (volume * arm**2 * rows[..., THICKNESS]).sum(axis=0)


def _middle(section: Section) -> Any:
    """Height of the middle of the layer, of one section or of each place."""
    return 0.5 * (section.z[..., 0] + section.z[..., -1])


def _arms(section: Section, heights: np.ndarray) -> np.ndarray:
    """Heights above the middle of the layer."""
    return np.asarray(heights - _middle(section))


def _free_stretch(law: Any, z: np.ndarray, heat: np.ndarray | None) -> FreeStretch | None:
    """At heights of places with T0 and T1, (2, ...): of n_z times as many points; None without heat."""
    if heat is None:
        return None
    return free_stretch(law.thermal_strain(), np.reshape(heat[0] + over_points(z) * heat[1], -1), plane=False)


def _respond(law: Any, C: np.ndarray, free: FreeStretch | None) -> PointResponse:
    found: PointResponse = law.respond3d(C) if free is None else free.respond(law.respond3d, C)
    return found
