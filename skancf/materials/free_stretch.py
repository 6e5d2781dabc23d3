r"""Stretch without stress inside a law at points, as of a temperature change.

A piece of the body that is free takes the stretch :math:`U = 1 + \alpha T`, without rotation, and a law sees what is left,

.. math::
    C_e = U^{-1} C \, U^{-1}, \qquad E_e = U^{-1} (E - E_T) \, U^{-1}, \qquad E_T = \tfrac12 (U^2 - 1) .

Its energy is that per volume of the freely stretched piece, so that a heated body is one of the same law whose undeformed
shape is larger. Per undeformed volume

.. math::
    \psi = \det U \, \psi_e(C_e), \qquad S = \det U \; U^{-1} S_e \, U^{-1}.

References
----------
S. C. H. Lu and K. S. Pister, Decomposition of deformation and representation of the free energy function for isotropic
thermoelastic solids, Int. J. Solids Struct. 11 (1975) 927-934; L. Vujosevic and V. A. Lubarda, Finite-strain
thermoelasticity based on multiplicative decomposition of deformation gradient, Theor. Appl. Mech. 28-29 (2002) 379-399.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.materials.law import IN_PLANE
from skancf.materials.point_law import PAIRS, PAIRS_3D, PointResponse
from skancf.showing import short

PLACES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Rows and columns of a tensor's six numbers."""


@dataclass(frozen=True)
class FreeStretch:
    """Of n points, in the plane (k = 3; 11, 22, 12) or in three dimensions (k = 6).

    Attributes
    ----------
    free : (k, n) array
        Free strain.
    turn : (k, k, n) array
        From a strain less the free one to that of the law, with doubled shear.
    volume : (n,) array
        Over the undeformed one.
    across : (n,) array
        Square of the stretch 33.
    """

    free: np.ndarray
    turn: np.ndarray
    volume: np.ndarray
    across: np.ndarray

    __repr__ = short

    def respond(self, law: Callable[..., PointResponse], C: np.ndarray, *more: Any) -> PointResponse:
        """What a law then says of C (k, n), with a stress 33 of zero where k is 3; per undeformed volume."""
        normal = 2 if len(C) == 3 else 3
        strain = C.copy()
        strain[:normal] = 0.5 * (strain[:normal] - 1)
        elastic = np.einsum("kln,ln->kn", self.turn, strain - self.free)
        elastic[:normal] = 1 + 2 * elastic[:normal]
        found = law(elastic, *more)
        pairs = np.array(PAIRS if len(C) == 3 else PAIRS_3D).T
        full = np.empty((len(C), len(C), C.shape[1]))
        full[pairs[0], pairs[1]] = full[pairs[1], pairs[0]] = found.stiffness
        full = np.einsum("kin,kln,ljn->ijn", self.turn, full, self.turn, optimize=True)
        return PointResponse(
            self.volume * found.energy, self.volume * np.einsum("kin,kn->in", self.turn, found.stress),
            self.volume * full[pairs[0], pairs[1]], self.across * found.stretch33, found.code, found.history,
        )  # fmt: skip


def free_stretch(expansion: np.ndarray, change: np.ndarray, plane: bool, over: Any = 1.0) -> FreeStretch:
    """Of an expansion (6,) per kelvin at temperature changes (n,); ``over``: divided by a stretch (n,) of all directions.

    Raises
    ------
    InputError
        Where nothing would be left of a length.
    """
    stretch = np.eye(3) + change[:, None, None] * _tensor(expansion)
    smallest = np.linalg.eigvalsh(stretch)[:, 0] if len(change) else np.ones(1)
    if not smallest.min() > 0:
        raise InputError(f"temperature: a change of {change[smallest.argmin()]:.6g} K leaves a free stretch of "
                         f"{smallest.min():.4g} with this expansion; it must be greater than zero")  # fmt: skip
    stretch = np.moveaxis(stretch, 0, -1) / over
    across = stretch[2, 2] ** 2
    volume = np.linalg.det(np.moveaxis(stretch, -1, 0))
    if plane:  # S13 and S23 are zero
        stretch[2, :2] = stretch[:2, 2] = 0.0
        volume = (stretch[0, 0] * stretch[1, 1] - stretch[0, 1] ** 2) * stretch[2, 2]
    left = np.moveaxis(np.linalg.inv(np.moveaxis(stretch, -1, 0)), 0, -1)
    change_of = stretch - np.eye(3)[..., None]
    strain = change_of + 0.5 * np.einsum("ikn,kjn->ijn", change_of, change_of)
    rows = IN_PLANE if plane else range(6)
    places = [PLACES[k] for k in rows]
    twice = [1.0 if i == j else 2.0 for i, j in places]
    free = np.stack([c * strain[i, j] for c, (i, j) in zip(twice, places, strict=True)])
    turn = np.stack([
        np.stack([0.5 * c * (left[i, k] * left[j, l] + left[i, l] * left[j, k]) for k, l in places])
        for c, (i, j) in zip(twice, places, strict=True)
    ])  # fmt: skip
    return FreeStretch(free, turn, volume, across)


def _tensor(strain: np.ndarray) -> np.ndarray:
    """Of six numbers with doubled shear: (3, 3)."""
    out = np.zeros((3, 3))
    for value, (i, j) in zip(strain, PLACES, strict=True):
        out[i, j] = out[j, i] = value if i == j else 0.5 * value
    return out
