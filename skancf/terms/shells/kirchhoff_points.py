"""Theory `kirchhoff` on a mesh with laws at points through the thickness, which are not linear in the strain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.kernels.constants import POINTS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.materials import Section
from skancf.materials.curved import CurvedSection
from skancf.materials.law import IN_PLANE, THICKNESS
from skancf.materials.parallel import strains_at
from skancf.materials.point_law import why
from skancf.materials.thickness_kernels import deformations
from skancf.materials.through_thickness import SectionResponse, heights, through_thickness
from skancf.terms.protocols import Heat
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.theories.kirchhoff import kernels, point_kernels
from skancf.theories.kirchhoff.kernels import N_MEMBRANE, N_STRAINS
from skancf.tolerances import NO_CHANGE

EVERY_PAIR = np.array([(k, l) for k in range(N_STRAINS) for l in range(k, N_STRAINS)])
REMEMBERED = 3
"""States whose answers are kept: start, middle and end of a step."""
NOWHERE = np.empty((0, 4, 3))


@dataclass(frozen=True)
class Answer:
    """What the law says of a state, with the weights of the points.

    Attributes
    ----------
    q : (n_nodes, 4, 3) array
        The state.
    everything : (n_elements, 6 or 9, 16) array
        All covariant strains.
    hat : (n_elements, 6, 16) array
        Covariant strains that the law sees.
    local : (6, n_elements, 16) array
        The same in the local frame.
    energy : (n_elements, 16) array
        Per area.
    code : (n_heights, n_elements, 16) array
        Where it is not 0 the law has no stress, see :mod:`skancf.materials.point_law`.
    stress : (n_elements, 6, 16) array
        On the strains that the law sees.
    law : (n_elements, 21, 16) array
        Entries of its derivative.
    """

    q: np.ndarray
    everything: np.ndarray
    hat: np.ndarray
    local: np.ndarray
    energy: np.ndarray
    code: np.ndarray
    stress: np.ndarray
    law: np.ndarray


class ThinPointAssembly(ThinAssembly):
    """See :class:`skancf.terms.protocols.Assembly`; classes of equal undeformed elements share all but the law.

    What assumed membrane strains leave out of them has the law of the undeformed state.
    """

    linear = False

    def __init__(self, geometry: Geometry, section: Section, schedule: Schedule):
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
        assert section.points_law is not None
        self._law, self._heights = section.points_law, heights(section)
        self._curvature = np.ascontiguousarray(np.moveaxis(sections.curvature[shape], -1, 0)).reshape(3, -1)
        self._answers: list[Answer] = []

    def _law_of_rest(self) -> np.ndarray:
        """Law (n_shapes, 3, 3, 16) of the rest of the membrane strains, with its factors and the weights."""
        sections = self.sections
        out = np.zeros((len(sections.law), N_MEMBRANE, N_MEMBRANE, POINTS))
        for m, (k, l) in enumerate(sections.pairs):
            if max(k, l) < N_MEMBRANE:
                out[:, k, l] = out[:, l, k] = (sections.rest[:, k] * sections.rest[:, l])[:, None] * sections.law[:, m]
        return out

    def answer(self, q: np.ndarray) -> Answer:
        """What the law says of a state, asked once for it."""
        for k, known in enumerate(self._answers):
            if np.array_equal(known.q, q):
                self._answers.insert(0, self._answers.pop(k))
                return known
        del self._answers[REMEMBERED - 1 :]
        self._answers.insert(0, self._ask(q))
        return self._answers[0]

    def _ask(self, q: np.ndarray) -> Answer:
        everything, hat, local = self._strains(q, NOWHERE)
        n = len(hat)
        found = self._through_thickness(local.reshape(N_STRAINS, -1), self._curvature)
        stress, law = np.empty((n, N_STRAINS, POINTS)), np.empty((n, len(EVERY_PAIR), POINTS))
        forces, stiffness = found.forces.reshape(-1, n, POINTS), found.stiffness.reshape(-1, n, POINTS)
        self.schedule.run(
            point_kernels.to_covariant, forces, stiffness, EVERY_PAIR, self._elements, self._places, stress, law
        )
        energy, code = found.energy.reshape(n, POINTS), found.code.reshape(-1, n, POINTS)
        return Answer(q.copy(), everything, hat, local, energy, code, stress, law)

    def _through_thickness(self, strains: np.ndarray, curvature: np.ndarray) -> SectionResponse:
        """Of strains (6, n) in the local frame."""
        return through_thickness(self._law, *self._heights, strains[:3], strains[3:], curvature)

    def _strains(self, q: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All strains, those that the law sees, and without a change these in the local frame."""
        n = self.geometry.n_elements
        everything = np.empty((n, *self.sections.reference.shape[1:]))
        hat, local = np.empty((n, N_STRAINS, POINTS)), np.empty((N_STRAINS, 0 if len(change) else n, POINTS))
        self.schedule.run(
            point_kernels.strains, q, change, self._tables, self.geometry.maps, self._elements, self._places, everything,
            hat, local,
        )  # fmt: skip
        return everything, hat, local

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        return self.force_of(q, self.stresses(q, None, keep_strains=False)[1])

    def stresses(self, q: np.ndarray, change: np.ndarray | None, keep_strains: bool) -> tuple[np.ndarray, np.ndarray]:
        answer = self.answer(q)
        everything, hat, stress = answer.everything, answer.hat, answer.stress
        if change is not None:
            everything, hat, _ = self._strains(q, change)
            stress = stress.copy()
            own = self._own.shape
            self.schedule.run(point_kernels.add_law, answer.law, own, EVERY_PAIR, hat - answer.hat, stress)
        return everything, self._on_all(stress, everything, hat)

    def _on_all(self, stress: np.ndarray, everything: np.ndarray, hat: np.ndarray) -> np.ndarray:
        """Stresses on all strains, from those on the strains that the law sees."""
        out = np.empty_like(everything)
        self.schedule.run(
            point_kernels.stresses, stress, everything, hat, self._tables, self._elements, self._places, out
        )
        return out

    def small_stresses(self, q: np.ndarray) -> np.ndarray:
        return super().stresses(q, None, keep_strains=False)[1]

    def exact_work(self, q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
        r"""Along the change of the strains in the metric C of small strain,

        .. math:: \frac{\psi_1 - \psi_0 - \bar S \cdot \Delta\varepsilon}{\Delta\varepsilon \cdot C \Delta\varepsilon}\,
            C \Delta\varepsilon,

        at each point; zero where the strain changes so little that it would be rounding.
        """
        start, end = self.answer(q0), self.answer(q1)
        sections, change = self.sections, end.hat - start.hat
        along = np.zeros_like(change)
        self.schedule.run(point_kernels.add_law, sections.law, sections.shape, sections.pairs, change, along)
        energies = self.areas * start.energy, self.areas * end.energy
        missing = energies[1] - energies[0] - 0.5 * ((start.stress + end.stress) * change).sum(axis=1)
        squares = (along * change).sum(axis=1)
        large = squares > NO_CHANGE**2 * (np.abs(energies[0]) + np.abs(energies[1]))
        along *= np.where(large, missing / np.where(large, squares, 1.0), 0.0)[:, None]
        nothing = np.zeros_like(start.everything)
        return self._on_all(along, nothing, nothing)

    def tangent(
        self, q: np.ndarray, stresses: np.ndarray, slots: np.ndarray, out: np.ndarray, plain: bool = False
    ) -> None:
        own = self._own._replace(law=self.answer(q).law)
        own = own._replace(assumed=np.zeros_like(own.assumed)) if plain else own
        kernel = type(self).tangent_kernel
        self.schedule.run(kernel, q, stresses, self._law_tables, self.geometry.maps, own, slots, out)

    def strain_energy(self, q: np.ndarray, initial: np.ndarray | None = None, thermal: float = 0.0) -> float:
        answer = self.answer(q)
        rest = answer.everything[:, :N_MEMBRANE] - answer.hat[:, :N_MEMBRANE]
        energy = float(np.vdot(self.areas, answer.energy)) + self.rest_energy(rest)
        return energy if initial is None else energy + (thermal - float(np.vdot(initial, answer.everything)))

    def thermal_stresses(self, temperature: Heat) -> np.ndarray:
        raise InputError("a temperature change with a law at points: the free strain would have to go into the law, which "
                         "sections do not do yet; take a linear law, whose thermal stress is that of small strain")

    def _at_places(self, strains: np.ndarray, b: np.ndarray) -> SectionResponse:
        """What the section says of local strains (m, n, 6) where the undeformed curvatures are b."""
        curvature = np.ascontiguousarray(np.moveaxis(b, -1, 0)).reshape(3, -1)
        return self._through_thickness(np.moveaxis(strains.real, -1, 0).reshape(N_STRAINS, -1), curvature)

    def _work_conjugate(self, curved: CurvedSection, strains: np.ndarray, b: np.ndarray) -> np.ndarray:
        found = self._at_places(strains, b)
        forces = np.moveaxis(found.forces.reshape(N_STRAINS, *b.shape[:-1]), 0, -1)
        if not np.iscomplexobj(strains):
            return forces
        return forces + 1j * (_square(found.stiffness, b.shape[:-1]) @ strains.imag[..., None])[..., 0]

    def _law_at(
        self, curved: CurvedSection, q: np.ndarray, points: np.ndarray, elements: np.ndarray, b: np.ndarray
    ) -> np.ndarray:
        return _square(self._at_places(self.section_strains(q, points, elements)[0], b).stiffness, b.shape[:-1])

    def strains(self, q: np.ndarray, points: np.ndarray, z: Any, temperature: np.ndarray | None) -> np.ndarray:
        parts, b = self.section_strains(q, points)
        out = np.zeros((*b.shape[:-1], 6), parts.dtype)
        if np.iscomplexobj(parts):  # a small change of the undeformed state
            out[..., IN_PLANE] = (strains_at(b, z)[..., :3, :] @ parts[..., None])[..., 0]
            section = self.section.at(points)
            out[..., THICKNESS] = out[..., IN_PLANE] @ section.thinning[section.layer_at(z)]
            return out
        flat = np.ascontiguousarray(np.moveaxis(np.concatenate([parts, b], axis=-1), -1, 0)).reshape(9, -1)
        C = np.empty((3, flat.shape[1]))
        deformations(np.array([z]), flat[:3], flat[3:6], flat[6:], C)
        across = self._law.respond(C).stretch33
        out[..., IN_PLANE] = _of_places(np.stack([C[0] - 1, C[1] - 1, 2 * C[2]]) / 2, b)
        out[..., THICKNESS] = _of_places(across[None] - 1, b)[..., 0] / 2
        return out

    def stress_of(self, elastic: np.ndarray, section: Section, z: Any, small: bool = False) -> np.ndarray:
        out = np.zeros_like(elastic)
        if small:
            out[..., IN_PLANE] = elastic[..., IN_PLANE] @ section.in_plane()[section.layer_at(z)]
            return out
        plane = np.moveaxis(elastic[..., IN_PLANE], -1, 0).reshape(3, -1)
        found = self._law.respond(np.stack([1 + 2 * plane[0], 1 + 2 * plane[1], plane[2]]))
        out[..., IN_PLANE] = _of_places(found.stress, elastic)
        return out

    def refusal(self) -> str | None:
        code = self._answers[0].code if self._answers else np.zeros((1, 1, 1), dtype=int)
        if not code.any():
            return None
        height, e, p = (int(at[0]) for at in np.nonzero(code))
        points = self.geometry.integration.local
        x, y = self.geometry.parameters(points if points.ndim == 2 else points[e], np.array([e]))[:, 0, p]
        strain = ", ".join(f"{value:.4g}" for value in self._answers[0].local[:3, e, p])
        name = type(getattr(self._law, "material", self._law)).__name__
        return (f"{name} has no stress in element {e} at (x, y) = ({x:.4g}, {y:.4g}), z = "
                f"{self._heights[0][height]:.4g}, membrane strain ({strain}): {why(self._law, int(code[height, e, p]))}")


def _square(entries: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Symmetric matrices (*shape, 6, 6) from their entries (21, n)."""
    k, l = EVERY_PAIR.T
    out = np.empty((*shape, N_STRAINS, N_STRAINS))
    out[..., k, l] = out[..., l, k] = np.moveaxis(entries.reshape(-1, *shape), 0, -1)
    return out


def _of_places(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Values (k, n) at the places of an array (m, n, ...): (m, n, k)."""
    return np.moveaxis(values.reshape(-1, *like.shape[:-1]), 0, -1)
