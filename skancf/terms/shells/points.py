"""What assemblies with a law at points share: it is asked once for a state, and its stress is not linear in the strain."""

from abc import abstractmethod
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.errors import warn
from skancf.kernels.constants import AXES, POINTS, VECTORS
from skancf.kernels.laws import add_law
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.point_law import FINE, PointLaw, why
from skancf.materials.zone_laws import LawsOfZones
from skancf.showing import short
from skancf.terms.protocols import Heat
from skancf.terms.shells.shell import CompiledAssembly
from skancf.tolerances import NO_CHANGE

REMEMBERED = 3
"""States whose answers are kept: start, middle and end of a step."""
WARM = 2
"""More of them with a temperature that changes: both ends with that of the other."""
NOWHERE = np.empty((0, VECTORS, AXES))
"""No change of the nodal vectors."""


@dataclass(frozen=True)
class Answer:
    """What the law says of a state, with the weights of the points.

    Attributes
    ----------
    q : (n_nodes, 4, 3) array
        The state.
    heat : (2, n_elements, 16) array or None
        The temperature change T0 and T1.
    everything : (n_elements, n_all, 16) array
        All covariant strains.
    seen : (n_elements, n_strains, 16) array
        Those that the law sees.
    energy : (n_elements, 16) array
    stress : (n_elements, n_strains, 16) array
        On the strains that the law sees.
    law : (n_elements, n_pairs, 16) array
        Entries k <= l of its derivative.
    code : (n_heights, n_elements, 16) array
        Where it is not 0 the law has no stress, see :mod:`skancf.materials.point_law`.
    """

    q: np.ndarray
    heat: np.ndarray | None
    everything: np.ndarray
    seen: np.ndarray
    energy: np.ndarray
    stress: np.ndarray
    law: np.ndarray
    code: np.ndarray

    __repr__ = short


class AtPoints(CompiledAssembly):
    """See :class:`skancf.terms.protocols.Assembly`; a base before the assembly of a theory, with the law of small strain.

    A theory gives :meth:`_ask`, :meth:`_seen`, :meth:`_on_all` and :meth:`_elements_with`.
    """

    linear = False
    section: Section | SectionsOnMesh
    heat: np.ndarray | None = None
    """Temperature change T0 and T1 at the integration points, (2, n_elements, 16), with which the law expands."""
    temperature: Heat | None = None
    """The same at any points."""
    every_pair: Any
    """Entries (n_pairs, 2) of a law that is full."""
    _heights: tuple[np.ndarray, np.ndarray]
    """Of the integration points, and their weights: (n_heights,) each, or of a field with axes of the places."""

    @cached_property
    def law(self) -> Any:
        """That of the integration points."""
        return self.section.at(self.geometry.integration.local).points_law

    def _law_at_point(self, e: int, p: int) -> PointLaw:
        """The law of an integration point."""
        law: PointLaw = self.law.of(e * POINTS + p) if isinstance(self.law, LawsOfZones) else self.law
        return law

    def __init__(self, *place: Any) -> None:
        super().__init__(*place)
        self._answers: list[Answer] = []
        self._last: list[Answer] = []

    def heated(self, temperature: Heat) -> "AtPoints":
        """The same under a temperature change T0 + z T1; they remember together."""
        other = copy(self)
        other.temperature = temperature
        other.heat = np.asarray(temperature(self.geometry.integration.local), dtype=float)
        other._warmed()
        return other

    @abstractmethod
    def _warmed(self) -> None:
        """Called on one that was given a temperature."""

    def answer(self, q: np.ndarray) -> Answer:
        """What the law says of a state, asked once for it."""
        answers = self._answers
        for k, known in enumerate(answers):
            if known.heat is self.heat and np.array_equal(known.q, q):
                answers.insert(0, answers.pop(k))
                self._last[:] = [known]
                return known
        del answers[REMEMBERED - 1 + (0 if self.heat is None else WARM) :]
        answers.insert(0, self._ask(q))
        self._last[:] = answers[:1]
        return answers[0]

    def extrapolated(self, q: np.ndarray, change: np.ndarray) -> Answer:
        r"""What the law says of strains that are extrapolated linearly along a change.

        Newton's method for strains e as unknowns besides q, with :math:`f(q) = B^T S(e)` and :math:`e = \varepsilon(q)`,
        takes the change of q from the tangent with S(e) and D(e), and the force of
        :math:`S(e) + D(e) (\varepsilon(q) - e)`. So the law never sees the membrane strains that a rotation of finite size
        makes of a linear step, and at the end e is the strain.
        """
        self._last[:] = [self._ask(q, change)]
        return self._last[0]

    def stresses_of(self, answer: Answer) -> np.ndarray:
        """On all strains."""
        return self._on_all(answer.stress, answer.everything, answer.seen)

    def mixed_force(self, q: np.ndarray, answer: Answer) -> np.ndarray:
        """Force of the law linearised about an answer."""
        everything, seen = self._seen(q, NOWHERE)
        stress, own = answer.stress.copy(), np.arange(len(answer.stress))
        self.schedule.run(add_law, answer.law, own, self.every_pair, seen - answer.seen, stress)
        return self.force_of(q, self._on_all(stress, everything, seen))

    @abstractmethod
    def _ask(self, q: np.ndarray, change: np.ndarray = NOWHERE) -> Answer:
        """Ask the law about the strains of a state, extrapolated along a change."""

    @abstractmethod
    def _seen(self, q: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All strains, extrapolated linearly along a change, and those that the law sees."""

    @abstractmethod
    def _on_all(self, stress: np.ndarray, everything: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """Stresses on all strains, from those on the strains that the law sees."""

    @abstractmethod
    def _elements_with(self, law: np.ndarray, plain: bool) -> tuple[Any, Any]:
        """Tables and elements of the tangent with the law of each element, (n_elements, n_pairs, 16)."""

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        return self.force_of(q, self.stresses(q, None, keep_strains=False)[1])

    def stresses(self, q: np.ndarray, change: np.ndarray | None, keep_strains: bool) -> tuple[np.ndarray, np.ndarray]:
        answer = self.answer(q)
        everything, seen, stress = answer.everything, answer.seen, answer.stress
        if change is not None:
            everything, seen = self._seen(q, change)
            stress, own = stress.copy(), np.arange(len(stress))
            self.schedule.run(add_law, answer.law, own, self.every_pair, seen - answer.seen, stress)
        return everything, self._on_all(stress, everything, seen)

    def small_stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        return super().stresses(q, change, keep_strains=False)[1]

    def exact_work(self, q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
        r"""Along the change of the strains in the metric C of small strain,

        .. math:: \frac{\psi_1 - \psi_0 - \bar S \cdot \Delta\varepsilon}{\Delta\varepsilon \cdot C \Delta\varepsilon}\,
            C \Delta\varepsilon,

        at each point; zero where the strain changes so little that it would be rounding.

        References
        ----------
        O. Gonzalez, Exact energy and momentum conserving algorithms for general models in nonlinear elasticity, Comput.
        Methods Appl. Mech. Eng. 190 (2000) 1763-1783.
        """
        start, end, sections = self.answer(q0), self.answer(q1), self.sections
        change = end.seen - start.seen
        along = np.zeros_like(change)
        self.schedule.run(add_law, sections.law, sections.shape, sections.pairs, change, along)
        missing = end.energy - start.energy - 0.5 * ((start.stress + end.stress) * change).sum(axis=1)
        squares = (along * change).sum(axis=1)
        large = squares > NO_CHANGE**2 * (np.abs(start.energy) + np.abs(end.energy))
        along *= np.where(large, missing / np.where(large, squares, 1.0), 0.0)[:, None]
        nothing = np.zeros_like(start.everything)
        return self._on_all(along, nothing, nothing)

    def tangent(
        self, q: np.ndarray, stresses: np.ndarray, slots: np.ndarray, out: np.ndarray, plain: bool = False,
        viscous: float = 0.0, of: Answer | None = None,
    ) -> None:  # fmt: skip
        """With ``viscous`` times the law of small strain besides; ``of`` an answer, or that of q."""
        law = (self.answer(q) if of is None else of).law
        tables, elements = self._elements_with(law + viscous * self._small_law if viscous else law, plain)
        kernel = type(self).tangent_kernel
        self.schedule.run(kernel, q, stresses, tables, self.geometry.maps, elements, slots, out)

    @cached_property
    def _small_law(self) -> np.ndarray:
        """Entries of the law of small strain, as :attr:`Answer.law` has them."""
        known = np.flatnonzero((self.every_pair[:, None] == self.sections.pairs).all(axis=2).any(axis=1))  # in one order
        out = np.zeros((len(self.sections.law), len(self.every_pair), self.sections.law.shape[2]))
        out[:, known] = self.sections.law
        return np.asarray(out[self.sections.shape])

    def strain_energy(self, q: np.ndarray, initial: np.ndarray | None = None, thermal: float = 0.0) -> float:
        answer = self.answer(q)
        energy = float(answer.energy.sum()) + self._energy_of_rest(answer)
        return energy if initial is None else energy + (thermal - float(np.vdot(initial, answer.everything)))

    def _energy_of_rest(self, answer: Answer) -> float:
        """Of the strains that the law does not see."""
        return 0.0

    def refusal(self) -> str | None:
        answers = self._last
        if not answers or not answers[0].code.any():
            return None
        height, e, p = (int(at[0]) for at in np.nonzero(answers[0].code))
        code, points = int(answers[0].code[height, e, p]), self.geometry.integration.local
        x, y = self.geometry.parameters(points if points.ndim == 2 else points[e], np.array([e]))[:, 0, p]
        strain = ", ".join(f"{value:.4g}" for value in self._membrane(answers[0], e, p))
        z, law = self._heights[0], self._law_at_point(e, p)
        z = z[height] if z.ndim == 1 else z.reshape(len(z), -1, POINTS)[height, e, p]
        return (f"{name_of(law)} has no stress in element {e} at (x, y) = ({x:.4g}, {y:.4g}), z = {z:.4g}, membrane strain "
                f"({strain}): {why(law, code)}")  # fmt: skip

    def warn_of(self, code: np.ndarray) -> None:
        """Say that numbers that were asked for do not exist, where a law's codes are not 0."""
        if code.any():
            first = int(code[code != FINE][0])
            names = " or ".join(dict.fromkeys(map(name_of, getattr(self.law, "laws", (self.law,)))))
            warn(f"{names} has no stress at {np.count_nonzero(code)} of {code.size} places that were asked for, and "
                 f"what depends on it is not a number there: {why(self.law, first)}")  # fmt: skip

    @abstractmethod
    def _membrane(self, answer: Answer, e: int, p: int) -> np.ndarray:
        """Membrane strain (3,) in the local frame at a point of an element."""


def name_of(law: Any) -> str:
    """That of its class, as the user knows it."""
    return type(getattr(law, "material", law)).__name__


def square(entries: np.ndarray, pairs: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Symmetric matrices (*shape, n, n) from their entries (n_pairs, m)."""
    k, l = pairs.T
    out = np.empty((*shape, k.max() + 1, k.max() + 1))
    out[..., k, l] = out[..., l, k] = np.moveaxis(entries.reshape(-1, *shape), 0, -1)
    return out


def of_places(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Values (k, n) at the places of an array (m, n, ...): (m, n, k)."""
    return np.moveaxis(values.reshape(-1, *like.shape[:-1]), 0, -1)
