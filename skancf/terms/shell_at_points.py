"""A shell with laws at points, which are not linear: heat is in the law, and damping has the law of small strain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.elements.reference import CORNERS
from skancf.history import FULL, Case
from skancf.showing import short
from skancf.terms.protocols import Assembly
from skancf.terms.shell import Shell, total

REMEMBERED = 3
"""Temperatures whose assemblies are kept: of the start, the middle and the end of a step."""
STEP = 1e-4
"""Of a difference by the load factor: its square is small, and so is rounding over it."""


@dataclass(frozen=True)
class Extrapolated:
    """What a law says of strains that were extrapolated, and its stresses on all strains."""

    answer: Any
    stresses: np.ndarray

    __repr__ = short


class ShellAtPoints(Shell):
    """See :class:`~skancf.terms.shell.Shell`.

    A temperature change is a free stretch inside the law, see :mod:`skancf.materials.free_stretch`, and no initial stress;
    but in answers to first order, which are those of the law of small strain.
    """

    def __init__(self, assembly: Assembly, *place: Any, **options: Any) -> None:
        super().__init__(assembly, *place, **options)
        self._warm = tuple(heat for heat in self.heats if heat.temperature(CORNERS.T, FULL) is not None)
        self._other = tuple(heat for heat in self.heats if heat not in self._warm)
        self._known: list[tuple[tuple[float, ...], Any]] = []

    at_points = True

    @property
    def heated(self) -> bool:
        return bool(self._warm)

    def at(self, case: Case) -> Any:
        if not self._warm:
            return self.assembly
        factors = tuple(case.amplitude(heat.history) for heat in self._warm)
        found = next((made for known, made in self._known if known == factors), None)
        if found is None:
            of_case = Case(case.factor, case.time)
            assembly: Any = self.assembly
            found = assembly.heated(lambda points: total(heat.temperature(points, of_case) for heat in self._warm))
            self._known = [*self._known[1 - REMEMBERED :], (factors, found)]
        return found

    def initial_stresses(self, case: Case, small: bool = False) -> np.ndarray | None:
        return super().initial_stresses(case) if small else total(heat.initial_stresses(case) for heat in self._other)

    def energy(self, q: np.ndarray, case: Case = FULL) -> float:
        r"""That of the law, integrated (J)."""
        initial = self.initial_stresses(case)
        return float(self.at(case).strain_energy(self.nodal(q), initial))

    def exact_work(self, q0: np.ndarray, q1: np.ndarray, start: Case = FULL, end: Case = FULL) -> np.ndarray:
        r"""With a temperature that changes, the mean of the work at both, as the ledger has it for the heat: besides

        .. math:: \tfrac14 (S_{10} + S_{01} - S_{00} - S_{11}),

        the stresses of a state (first) and a temperature (second), of the start and the end.
        """
        one, two = (self.nodal(q) for q in (q0, q1))
        before, after = self.at(start), self.at(end)
        if before is after:
            return np.asarray(before.exact_work(one, two))
        mixed = [sign * made.stresses(q, None, keep_strains=False)[1]
                 for sign, made, q in ((1, before, two), (1, after, one), (-1, before, one), (-1, after, two))]  # fmt: skip
        return np.asarray(0.5 * (before.exact_work(one, two) + after.exact_work(one, two)) + 0.25 * sum(mixed))

    def add_tangent(
        self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any, stresses: Any = None,
        stiffer: float = 1.0,
    ) -> None:  # fmt: skip
        """What the law counts more is that of small strain; ``stresses`` may be :class:`Extrapolated`."""
        if blocks.skew:
            return
        answer = None
        if isinstance(stresses, Extrapolated):
            answer, stresses = stresses.answer, stresses.stresses
        stresses = self.stresses(q, None, case) if stresses is None else stresses
        initial = self.initial_stresses(case)
        stresses = stresses if initial is None else stresses - initial
        self.at(case).tangent(self.nodal(q), stresses, blocks.slots_of(self.cells), blocks.values, viscous=stiffer - 1.0,
                              of=answer)  # fmt: skip

    def extrapolated(self, q: np.ndarray, change: np.ndarray, case: Case) -> Extrapolated:
        """For a mixed iteration, see :meth:`skancf.terms.shells.points.AtPoints.extrapolated`."""
        assembly = self.at(case)
        answer = assembly.extrapolated(self.nodal(q), self.nodal(change))
        return Extrapolated(answer, assembly.stresses_of(answer))

    def mixed_force(self, q: np.ndarray, known: Extrapolated, case: Case) -> np.ndarray:
        """Internal force (n_dofs,) of the law linearised about it."""
        return self.flat(self.at(case).mixed_force(self.nodal(q), known.answer))

    def stresses_with_rate(self, q: np.ndarray, change: np.ndarray | None, rate: np.ndarray, case: Case) -> np.ndarray:
        return self.stresses(q, change, case) + self._retarding(q, rate)

    def retarding_force(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        if not self.retardation:
            return np.zeros(self.layout.n_dofs)
        return self.force_of(q, self._retarding(q, v))

    def _retarding(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Viscous stresses, of the law of small strain: never do they give energy."""
        nodal = self.nodal(q)
        moved = self.assembly.small_stresses(nodal, self.nodal(self.retardation * v))
        return np.asarray(moved - self.assembly.small_stresses(nodal))

    def load_rate(self, q: np.ndarray, load_factor: float) -> np.ndarray | None:
        """Derivative by the load factor of the forces that heat makes, (n_dofs,)."""
        if not self._warm:
            return None
        size = max(1.0, abs(load_factor))
        more, less = (self.stresses(q, None, Case(load_factor + sign * STEP * size)) for sign in (1, -1))
        return self.force_of(q, (less - more) / (2 * STEP * size))
