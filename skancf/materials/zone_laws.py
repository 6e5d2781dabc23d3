"""Laws at points that are another one in each zone, and linear laws among them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.materials.law import IN_PLANE, OUT_OF_PLANE, SHEAR_CORRECTION, corrected, stiffness_of, thinning_of
from skancf.materials.point_law import PAIRS, PAIRS_3D, PointLaw, PointResponse
from skancf.showing import short


@dataclass(frozen=True, eq=False)
class LinearAtPoints:
    """A linear law, asked at points, as those next to it are: stress is linear in Green's strain.

    Attributes
    ----------
    material : Law
    """

    material: Any
    n_history = 0
    shear_correction = SHEAR_CORRECTION

    @property
    def density(self) -> float:
        return float(self.material.density)

    @cached_property
    def _matrix(self) -> np.ndarray:
        return stiffness_of(self.material)

    def stiffness(self) -> np.ndarray:
        return self._matrix.copy()

    def thermal_strain(self) -> np.ndarray:
        return np.asarray(self.material.thermal_strain())

    @cached_property
    def _thinning(self) -> np.ndarray:
        return thinning_of(self.material)

    def thinning(self) -> np.ndarray:
        return self._thinning.copy()

    @cached_property
    def _plane(self) -> np.ndarray:
        """Stiffness (3, 3) where S33 = S23 = S13 = 0."""
        pp, pq, qq = (self._matrix[np.ix_(rows, columns)] for rows, columns in
                      ((IN_PLANE, IN_PLANE), (IN_PLANE, OUT_OF_PLANE), (OUT_OF_PLANE, OUT_OF_PLANE)))  # fmt: skip
        return np.asarray(pp - pq @ np.linalg.solve(qq, pq.T))

    def respond(self, C: np.ndarray, guess: Any = None, history: Any = None) -> PointResponse:
        """Plane stress."""
        strain = np.stack([(C[0] - 1) / 2, (C[1] - 1) / 2, C[2]])
        return _linear(self._plane, PAIRS, strain, 1 + 2 * self._thinning @ strain)

    plane_stress = respond

    def respond3d(self, C: np.ndarray) -> PointResponse:
        """In three dimensions; theory `full` hands over shear with the root of the correction that the law has in it."""
        strain = np.concatenate([(C[:3] - 1) / 2, C[3:]])
        return _linear(corrected(self._matrix, 1 / SHEAR_CORRECTION), PAIRS_3D, strain, C[2].copy())


def _linear(matrix: np.ndarray, pairs: Any, strain: np.ndarray, across: np.ndarray) -> PointResponse:
    stress = matrix @ strain
    rows, columns = np.array(pairs).T
    stiffness = np.repeat(matrix[rows, columns][:, None], strain.shape[1], axis=1)
    return PointResponse(0.5 * (stress * strain).sum(axis=0), stress, stiffness, across)


@dataclass(frozen=True, eq=False)
class LawsOfZones:
    """Several laws at points as one.

    Attributes
    ----------
    laws : tuple of PointLaw
    which : (n_places,) int array
        Number of the law at each place. Points come with the places in this order, as often as there are heights.
    """

    laws: tuple[PointLaw, ...]
    which: np.ndarray
    n_history = 0

    __repr__ = short

    @property
    def shear_correction(self) -> float:
        """The one of all, for theory `full`."""
        factors = {float(getattr(law, "shear_correction", 1.0)) for law in self.laws}
        if len(factors) > 1:
            raise InputError(f"zones: their laws have the shear correction factors {sorted(factors)}; theory 'full' takes "
                             "one for all laws at points, give them the same")  # fmt: skip
        return factors.pop()

    def of(self, place: int) -> PointLaw:
        """The law of a place."""
        return self.laws[int(self.which[place])]

    def thermal_strain(self) -> np.ndarray:
        raise InputError(
            "a temperature change with zones of several materials, one of which is a law at points: each law "
            "would expand by itself, which sections do not do yet; give all zones one material"
        )

    def respond(self, C: np.ndarray, guess: np.ndarray | None = None, history: Any = None) -> PointResponse:
        """Plane stress of all points."""
        return self._asked(C, lambda law, own, C: law.respond(C, None if guess is None else guess[own]))

    def respond3d(self, C: np.ndarray) -> PointResponse:
        """In three dimensions."""
        return self._asked(C, lambda law, own, C: law.respond3d(C))

    def _asked(self, C: np.ndarray, ask: Any) -> PointResponse:
        which = np.tile(self.which, C.shape[1] // max(len(self.which), 1))
        parts: list[np.ndarray] = []
        for number in np.unique(which) if which.size else [0]:
            own = np.flatnonzero(which == number)
            found = ask(self.laws[number], own, np.ascontiguousarray(C[:, own]))
            values = [found.energy, found.stress, found.stiffness, found.stretch33, found.code]
            if not parts:
                parts = [np.empty((*each.shape[:-1], C.shape[1]), each.dtype) for each in values]
            for part, each in zip(parts, values, strict=True):
                part[..., own] = each
        return PointResponse(*parts)
