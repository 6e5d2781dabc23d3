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
from skancf.materials import Section
from skancf.materials.free_stretch import FreeStretch, free_stretch
from skancf.materials.hyperelastic.law import require_solid
from skancf.materials.law import IN_PLANE, THICKNESS, TRANSVERSE
from skancf.materials.point_law import PointResponse
from skancf.terms.protocols import Heat
from skancf.terms.shells.full import FullAssembly
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

    def __init__(self, geometry: Geometry, section: Section, schedule: Schedule):
        require_solid(getattr(section.points_law, "material", section.points_law))
        super().__init__(geometry, section, schedule)
        self._heights, self._middle = section.points(self.theory.n_thickness)[:2], 0.5 * (section.z[0] + section.z[-1])
        shape, n = self.sections.shape, geometry.n_elements
        representative = np.unique(shape, return_index=True)[1]
        points, weights = self.theory.quadrature
        P, volume = self._matrices(points, representative)
        self._matrix = np.ascontiguousarray(P.transpose(3, 0, 1, 2, 4))
        self._volume = np.ascontiguousarray(np.moveaxis(volume * weights, 0, 1))
        self._own = kernels.Elements(np.arange(n, dtype=shape.dtype), np.empty((0, 0, 0)), np.empty((0, 0, 0)),
                                     np.empty((0, 0, 0)))  # fmt: skip
        self._law_tables = self._tables._replace(pairs=EVERY_PAIR, coupled=True)

    def _matrices(self, points: np.ndarray, elements: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """From the 14 strains to those that the law sees, at heights and points of elements, (n_z, 6, 14, m, n), and volumes
        with the weights of the heights, (n_z, m, n)."""
        geometry, (z, weights) = self.geometry, self._heights
        local = geometry.undeformed_local[slice(None) if elements is None else elements]
        P, volume = covariant_to_local(self.theory.jets(local, points), geometry.tangents(points, elements), z)
        P[:, TRANSVERSE] *= self._sheared
        return P, volume * weights[:, None, None]

    @property
    def _sheared(self) -> float:
        """Root of the shear correction factor."""
        return float(np.sqrt(getattr(self.law, "shear_correction", 1.0)))

    def _ask(self, q: np.ndarray, change: np.ndarray = NOWHERE) -> Answer:
        everything, _ = self._seen(q, change)
        n, (z, _), shape = len(everything), self._heights, self.sections.shape
        local = np.empty((6, z.size, n, POINTS))
        self.schedule.run(point_kernels.to_local, everything, shape, self._matrix, local)
        volume = np.moveaxis(self._volume[shape], 1, 0)
        _, found = self._balanced(local, volume, self._free)
        stress, law = np.empty_like(everything), np.empty((n, len(EVERY_PAIR), POINTS))
        parts = (part.reshape(-1, *local.shape[1:]) for part in (found.stress, found.stiffness))
        self.schedule.run(point_kernels.integrate, *parts, self._arms, shape, self._matrix, self._volume, stress, law)
        energy = (found.energy.reshape(local.shape[1:]) * volume).sum(axis=0)
        return Answer(q.copy(), self.heat, everything, everything, energy, stress, law, found.code.reshape(local.shape[1:]))

    _free: FreeStretch | None = None

    def _warmed(self) -> None:
        assert self.heat is not None
        self._free = self._free_stretch(self._heights[0], self.heat)

    def _free_stretch(self, z: Any, heat: np.ndarray | None) -> FreeStretch | None:
        """At heights (n_z,) of places with T0 and T1, (2, ...): of n_z times as many points; None without heat."""
        if heat is None:
            return None
        change = np.reshape(heat[0] + np.multiply.outer(z, heat[1]), -1)
        return free_stretch(self.law.thermal_strain(), change, plane=False)

    def _respond(self, C: np.ndarray, free: FreeStretch | None) -> PointResponse:
        law: Any = self.law
        found: PointResponse = law.respond3d(C) if free is None else free.respond(law.respond3d, C)
        return found

    @property
    def _arms(self) -> np.ndarray:
        """Heights above the middle of the layer."""
        return self._heights[0] - self._middle

    def _balanced(
        self, local: np.ndarray, volume: np.ndarray, free: FreeStretch | None
    ) -> tuple[np.ndarray, PointResponse]:
        r"""The factor of the strain across that is linear in z, (...), and what the law then says of all points.

        Newton's method for :math:`\int z \sigma_{33} dV = 0` at strains (6, n_z, ...), with volumes (n_z, ...).
        """
        z = self._arms.reshape(-1, *[1] * (local.ndim - 2))
        alpha, size = np.zeros(local.shape[2:]), float(np.abs(z).max())
        for _ in range(ITERATIONS):
            C = 1.0 * local
            C[THICKNESS] += alpha * z
            C[:3] = 1 + 2 * C[:3]
            found = self._respond(C.reshape(6, -1), free)
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
        _, stress, _ = self._held(self._matrices(self.theory.quadrature[0])[1], *temperature(self.theory.quadrature[0]))
        shape = self.sections.shape
        return np.ascontiguousarray(
            np.einsum("ezvkp,vzep,ezp->ekp", self._matrix[shape], stress, self._volume[shape], optimize=True)
        )

    def thermal_energy(self, temperature: Heat) -> float:
        volume = np.moveaxis(self._volume[self.sections.shape], 1, 0)
        free, stress, _ = self._held(volume, *temperature(self.theory.quadrature[0]))
        return 0.5 * float(np.einsum("vzep,vzep,zep->", free, stress, volume, optimize=True))

    def _held(
        self, volume: np.ndarray, middle: np.ndarray, gradient: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Free strains and what stresses hold them back to first order, (6, n_z, m, n) each, where volumes are (n_z, m, n);
        and the factor of the strain across that is linear in z, (m, n)."""
        z = self._arms[:, None, None]
        change = middle + np.multiply.outer(self._heights[0], gradient)
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
        found = self._respond(np.array([[1.0], [1.0], [1.0], [0.0], [0.0], [0.0]]), None)
        return square(found.stiffness, PAIRS, (1,))[0]

    def strains(
        self, q: np.ndarray, points: np.ndarray, z: Any, temperature: np.ndarray | None, small: bool = False
    ) -> np.ndarray:
        if small and temperature is not None:
            out = self.strains(q, points, z, None)
            if not np.iscomplexobj(out):  # in the undeformed state
                out[..., THICKNESS] += (z - self._middle) * self._held(self._matrices(points)[1], *temperature)[2]
            return out
        geometry, theory = self.geometry, self.theory
        change = theory.strains(geometry.local(q), points) - theory.strains(geometry.undeformed_local, points)
        jets = theory.jets(geometry.undeformed_local, points)
        to_local, _ = covariant_to_local(jets, geometry.tangents(points), np.array([z]))
        out = np.einsum("vken,ekn->env", to_local[0], change, optimize=True)
        out[..., THICKNESS] += (z - self._middle) * self._across(change, points, temperature)
        return out

    def _across(self, change: np.ndarray, points: np.ndarray, temperature: np.ndarray | None) -> np.ndarray:
        """Factor of the strain across that is linear in z, (m, n), of strains (m, 14, n), complex ones too, at points."""
        alpha, rates = self._across_with_rates(change.real, points, temperature)
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
        found = self._respond(C.reshape(6, -1), self._free_stretch(np.array([z]), heat))
        self.warn_of(found.code)
        if first_order:
            law = square(found.stiffness, PAIRS, strains.shape[:-1])
            if small and temperature is not None and not np.iscomplexobj(strains):
                strains = strains - section.thermal_strain(z, *temperature)
            return np.asarray(sheared * (law @ (sheared * strains)[..., None])[..., 0])
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
        to_local[:, THICKNESS] += np.multiply.outer(z - self._middle, rates)
        stresses = np.zeros_like(change)
        for depth, share, rows in zip(z, w, to_local, strict=True):
            plane = share * (weights[:, :3] + depth * weights[:, 3:])
            plane = plane - depth * np.einsum("enij,ein->ejn", self._shorter(points, elements), plane)
            strains = np.einsum("vken,ekn->env", rows, change)
            strains[..., THICKNESS] += (depth - self._middle) * (alpha - np.einsum("ken,ekn->en", rates, change))
            law = self._law_of(strains, depth, heat)[..., IN_PLANE, :]
            stresses += np.einsum("ecn,encv,vken->ekn", plane, law, rows, optimize=True)
        return geometry.nodal(theory.strain_forces(now, points, stresses), elements)

    def _law_of(self, strains: np.ndarray, z: float, heat: np.ndarray | None) -> np.ndarray:
        """Derivative of :meth:`stress_of` by the strains, (m, n, 6, 6)."""
        sheared = np.where(np.isin(np.arange(6), TRANSVERSE), self._sheared, 1.0)
        C = np.moveaxis(strains * sheared, -1, 0).copy()
        C[:3] = 1 + 2 * C[:3]
        found = self._respond(C.reshape(6, -1), self._free_stretch(np.array([z]), heat))
        return np.asarray(square(found.stiffness, PAIRS, strains.shape[:-1]) * np.multiply.outer(sheared, sheared))

    def _across_with_rates(
        self, change: np.ndarray, points: np.ndarray, temperature: np.ndarray | None, elements: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Factor of the strain across that is linear in z, (m, n), and its derivative by the 14 strains (m, 14, n) at points
        of elements: (14, m, n)."""
        P, volume = self._matrices(points, elements)
        local = np.einsum("zvken,ekn->vzen", P, change, optimize=True)
        alpha, found = self._balanced(local, volume, self._free_stretch(self._heights[0], temperature))
        arm = self._arms[:, None, None]
        rows = square(found.stiffness, PAIRS, volume.shape)[..., THICKNESS, :]
        moved = np.einsum("zen,zenv,zvken->ken", volume * arm, rows, P, optimize=True)
        return alpha, -moved / (volume * arm**2 * rows[..., THICKNESS]).sum(axis=0)
