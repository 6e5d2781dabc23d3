"""Theory `kirchhoff` on a mesh with laws at points through the thickness, which are not linear in the strain."""

from dataclasses import dataclass

import numpy as np

from skancf.kernels.constants import POINTS
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.materials import Section
from skancf.materials.through_thickness import SectionResponse, heights, through_thickness
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.theories.kirchhoff import kernels, point_kernels
from skancf.theories.kirchhoff.kernels import N_MEMBRANE, N_STRAINS

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
        self._heights = heights(section)
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
        law = self.section.points_law
        assert law is not None
        return through_thickness(law, *self._heights, strains[:3], strains[3:], curvature)

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
            self.schedule.run(point_kernels.add_law, answer.law, EVERY_PAIR, hat - answer.hat, stress)
        return everything, self._on_all(stress, everything, hat)

    def _on_all(self, stress: np.ndarray, everything: np.ndarray, hat: np.ndarray) -> np.ndarray:
        """Stresses on all strains, from those on the strains that the law sees."""
        out = np.empty_like(everything)
        self.schedule.run(
            point_kernels.stresses, stress, everything, hat, self._tables, self._elements, self._places, out
        )
        return out

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
        return float(np.vdot(self.areas, answer.energy)) + self.rest_energy(rest)
