"""Theory `kirchhoff` on a mesh with laws at points through the thickness, which are not linear in the strain."""

from typing import Any

import numpy as np

from skancf.kernels.constants import POINTS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.curved import CurvedSection
from skancf.materials.free_stretch import free_stretch
from skancf.materials.law import IN_PLANE, THICKNESS
from skancf.materials.parallel import strains_at
from skancf.materials.point_law import PointResponse
from skancf.materials.section import stress_of
from skancf.materials.through_thickness import (
    SectionResponse,
    deformation_at,
    heated_through_thickness,
    heights,
    through_thickness,
)
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.terms.shells.points import NOWHERE, Answer, AtPoints, of_places, square
from skancf.theories.kirchhoff import kernels, point_kernels
from skancf.theories.kirchhoff.kernels import N_MEMBRANE, N_STRAINS

EVERY_PAIR = np.array([(k, l) for k in range(N_STRAINS) for l in range(k, N_STRAINS)])


class ThinPointAssembly(AtPoints, ThinAssembly):
    """See :class:`skancf.terms.protocols.Assembly`; classes of equal undeformed elements share all but the law.

    What assumed membrane strains leave out of them has the law of the undeformed state.
    """

    every_pair = EVERY_PAIR

    def __init__(self, geometry: Geometry, section: Section | SectionsOnMesh, schedule: Schedule):
        super().__init__(geometry, section, schedule)
        sections, n = self.sections, geometry.n_elements
        turn, shape = sections.turn, sections.shape
        rest = self._law_of_rest()
        side = np.where(np.einsum("eklp,eklp->e", turn[:, :3, :3], turn[:, 3:, 3:]) < 0, -1.0, 1.0)
        self._places = point_kernels.Places(np.ascontiguousarray(turn[:, :3, :3]), side, sections.areas, rest)
        self._law_tables = self._tables._replace(pairs=EVERY_PAIR)
        self._own = kernels.Elements(
            np.arange(n, dtype=shape.dtype), sections.points[shape], np.empty((0, 0, 0)), np.empty((0, 0, 0)),
            sections.assumed[shape], rest[shape],
        )  # fmt: skip
        self._heights = heights(section.at(geometry.integration.local))
        self._curvature = np.ascontiguousarray(np.moveaxis(sections.curvature[shape], -1, 0)).reshape(3, -1)

    def _law_of_rest(self) -> np.ndarray:
        """Law (n_shapes, 3, 3, 16) of the rest of the membrane strains, with its factors and the weights."""
        sections = self.sections
        out = np.zeros((len(sections.law), N_MEMBRANE, N_MEMBRANE, POINTS))
        for m, (k, l) in enumerate(sections.pairs):
            if max(k, l) < N_MEMBRANE:
                out[:, k, l] = out[:, l, k] = (sections.rest[:, k] * sections.rest[:, l])[:, None] * sections.law[:, m]
        return out

    def _ask(self, q: np.ndarray, change: np.ndarray = NOWHERE) -> Answer:
        everything, hat, local = self._all_strains(q, change)
        n = len(hat)
        found = _through_thickness(self.law, self._heights, local.reshape(N_STRAINS, -1), self._curvature, self.heat)
        stress, law = np.empty((n, N_STRAINS, POINTS)), np.empty((n, len(EVERY_PAIR), POINTS))
        forces, stiffness = found.forces.reshape(-1, n, POINTS), found.stiffness.reshape(-1, n, POINTS)
        self.schedule.run(
            point_kernels.to_covariant, forces, stiffness, EVERY_PAIR, self._elements, self._places, stress, law
        )
        energy, code = self.areas * found.energy.reshape(n, POINTS), found.code.reshape(-1, n, POINTS)
        return Answer(q.copy(), self.heat, everything, hat, energy, stress, law, code)

    def _warmed(self) -> None:
        """Membrane strains of the free expansion that assumed ones do not hold are no strain of the rest."""
        assert self.temperature is not None
        free = self._free_strains(self.temperature, self._expanded)
        projection = self._tables.projections[self.sections.assumed[self.sections.shape]]
        kept = np.einsum("ecsp,ecs->ecp", projection, self._before_projection(free))
        self._unheld = free[:, :N_MEMBRANE] - kept
        self._unheld_local = np.einsum("eklp,elp->kep", self._places.turn[self.sections.shape], self._unheld)

    def _expanded(self, curved: CurvedSection, b: np.ndarray, middle: np.ndarray, gradient: np.ndarray) -> np.ndarray:
        """Strains (m, n, 6) of the surface where it expands freely; that they are bent does not count."""
        free = free_stretch(self.law.thermal_strain(), middle.reshape(-1), plane=True).free
        return np.concatenate([of_places(free, np.empty((*middle.shape, 1))), np.zeros((*middle.shape, 3))], axis=-1)

    def _seen(self, q: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._all_strains(q, change, in_local_frame=False)[:2]

    def _all_strains(
        self, q: np.ndarray, change: np.ndarray, in_local_frame: bool = True
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All strains, those that the law sees, and, if asked, these in the local frame."""
        n = self.geometry.n_elements
        everything = np.empty((n, *self.sections.reference.shape[1:]))
        hat, local = np.empty((n, N_STRAINS, POINTS)), np.empty((N_STRAINS, n * in_local_frame, POINTS))
        self.schedule.run(
            point_kernels.strains, q, change, self._tables, self.geometry.maps, self._elements, self._places, everything,
            hat, local,
        )  # fmt: skip
        if self.heat is not None:
            everything[:, :N_MEMBRANE] -= self._unheld
            if in_local_frame:
                local[:N_MEMBRANE] += self._unheld_local
        return everything, hat, local

    def _on_all(self, stress: np.ndarray, everything: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """Stresses on all strains, from those on the strains that the law sees."""
        out = np.empty_like(everything)
        self.schedule.run(point_kernels.stresses, stress, everything, seen, self._tables, self._elements, self._places, out)
        return out

    def _elements_with(self, law: np.ndarray, plain: bool) -> tuple[Any, Any]:
        own = self._own._replace(law=law)
        return self._law_tables, own._replace(assumed=np.zeros_like(own.assumed)) if plain else own

    def _energy_of_rest(self, answer: Answer) -> float:
        return self.rest_energy(answer.everything[:, :N_MEMBRANE] - answer.seen[:, :N_MEMBRANE])

    def _membrane(self, answer: Answer, e: int, p: int) -> np.ndarray:
        turn: np.ndarray = self._places.turn[self.sections.shape[e], :, :, p]
        return turn @ answer.seen[e, :N_MEMBRANE, p]

    def section_forces(
        self, q: np.ndarray, points: np.ndarray, temperature: np.ndarray | None, elements: np.ndarray | None = None,
        small: bool = False,
    ) -> np.ndarray:  # fmt: skip
        if small and temperature is not None:
            return super().section_forces(q, points, temperature, elements)
        (strains, b), curved = self.section_strains(q, points, elements), self.curved_at(points, elements)
        return np.asarray(curved.forces(b, self._of_law(curved.section, strains, b, temperature)).swapaxes(1, 2))

    def _at_places(self, section: Section, strains: np.ndarray, b: np.ndarray, heat: np.ndarray | None) -> SectionResponse:
        """What a section says of local strains (m, n, 6) where the undeformed curvatures are b."""
        curvature = np.ascontiguousarray(np.moveaxis(b, -1, 0)).reshape(3, -1)
        flat = np.moveaxis(strains.real, -1, 0).reshape(N_STRAINS, -1)
        found = _through_thickness(section.points_law, heights(section), flat, curvature, heat)
        self.warn_of(found.code)
        return found

    def _of_law(self, section: Section, strains: np.ndarray, b: np.ndarray, heat: np.ndarray | None) -> np.ndarray:
        """Forces and moments that do work on local strains, both (m, n, 6)."""
        found = self._at_places(section, strains, b, heat)
        forces = np.moveaxis(found.forces.reshape(N_STRAINS, *b.shape[:-1]), 0, -1)
        if not np.iscomplexobj(strains):
            return forces
        return forces + 1j * (square(found.stiffness, EVERY_PAIR, b.shape[:-1]) @ strains.imag[..., None])[..., 0]

    def _law_at(
        self, curved: CurvedSection, q: np.ndarray, points: np.ndarray, elements: np.ndarray, b: np.ndarray
    ) -> np.ndarray:
        heat = None if self.temperature is None else np.asarray(self.temperature(points))[:, elements]
        found = self._at_places(curved.section, self.section_strains(q, points, elements)[0], b, heat)
        return square(found.stiffness, EVERY_PAIR, b.shape[:-1])

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
            return super().strains(q, points, z, temperature, elements=elements)
        (parts, b), section = self.section_strains(q, points, elements), self.section.at(points, elements)
        out = np.zeros((*b.shape[:-1], 6), parts.dtype)
        if np.iscomplexobj(parts):  # a small change of the undeformed state
            out[..., IN_PLANE] = (strains_at(b, z)[..., :3, :] @ parts[..., None])[..., 0]
            row = section.of_layer(section.thinning, z)
            out[..., THICKNESS] = out[..., IN_PLANE] @ row if row.ndim == 1 else (out[..., IN_PLANE] * row).sum(axis=-1)
            return out
        flat = np.ascontiguousarray(np.moveaxis(np.concatenate([parts, b], axis=-1), -1, 0)).reshape(9, -1)
        middle = None if temperature is None else temperature[0].reshape(-1)
        C = deformation_at(section.points_law, z, flat[:3], flat[3:6], flat[6:], middle)
        across = _respond(section.points_law, C, z, temperature).stretch33
        out[..., IN_PLANE] = of_places(np.stack([C[0] - 1, C[1] - 1, 2 * C[2]]) / 2, b)
        out[..., THICKNESS] = of_places(across[None] - 1, b)[..., 0] / 2
        return out

    def stress_of(
        self, strains: np.ndarray, section: Section, z: Any, temperature: np.ndarray | None = None, small: bool = False
    ) -> np.ndarray:
        out = np.zeros_like(strains)
        if small:
            free = 0.0 if temperature is None else section.thermal_strain(z, *temperature)
            out[..., IN_PLANE] = stress_of(section.of_layer(section.in_plane(), z), (strains - free)[..., IN_PLANE])
            return out
        plane = np.moveaxis(strains[..., IN_PLANE], -1, 0).reshape(3, -1)
        C = np.stack([1 + 2 * plane[0], 1 + 2 * plane[1], plane[2]])
        found = _respond(section.points_law, C, z, temperature)
        self.warn_of(found.code)
        out[..., IN_PLANE] = of_places(found.stress, strains)
        return out


def _through_thickness(
    law: Any, z: tuple[np.ndarray, np.ndarray], strains: np.ndarray, curvature: np.ndarray, heat: np.ndarray | None
) -> SectionResponse:
    """Of strains (6, n) in the local frame, with a temperature change (2, ...) of the n places."""
    place = (law, *z, strains[:3], strains[3:], curvature)
    return through_thickness(*place) if heat is None else heated_through_thickness(*place, *heat.reshape(2, -1))


def _respond(law: Any, C: np.ndarray, z: Any, temperature: np.ndarray | None) -> PointResponse:
    """What a law says of C (3, n) at a height, where the temperature change is (2, ...)."""
    if temperature is None:
        found: PointResponse = law.respond(C)
        return found
    change = (temperature[0] + z * temperature[1]).reshape(-1)
    return free_stretch(law.thermal_strain(), change, plane=True).respond(law.respond, C)
