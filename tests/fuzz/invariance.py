"""What must not change when the same is said otherwise."""

from typing import Any

import numpy as np
from hypothesis import assume

from fuzz.assessment import bounded, change_of, nodal, nothing, rounding, sizes, solved, stored, unsure
from fuzz.case import Case
from fuzz.transforms import in_frame, in_units

CLOSE = 1e-9
"""Sums in another order, besides what rounding may do to the answer."""


def agree(one: Any, two: Any, shown: np.ndarray, what: str, energy: float) -> None:
    """The same answer: displacements (3, n) of the second one, as the first has them, and its energy."""
    error, scale = CLOSE + rounding(one) + rounding(two), stored(one).max() + stored(two).max()
    loads, here = nodal(one.system.external_force(one.system.undeformed)), one.displacements
    # Loads that do no work leave noise, which has no frame.
    mighty = float((np.abs(loads).sum(axis=(0, 2)) * np.abs(nodal(change_of(one))).max(axis=(0, 2))).sum())
    assume(not loads.any() or one.system.shell.thermal_energy() or abs(one.work) > 1e-9 * mighty)
    gap, size = float(np.abs(here - shown).max()), float(np.abs(here).max())
    bounded(f"displacements {what}", gap, error * size + 3 * (unsure(one) + unsure(two)) + 4 * scale)
    # Of a heated body that is free to expand the energy is a difference of these two.
    energies = abs(one.strain_energy) + one.system.shell.thermal_energy()
    lost = scale * sizes(loads[:, 0])
    bounded(f"energy {what}", abs(one.strain_energy - energy), error * energies + lost + nothing(one) + nothing(two))


def units(given: tuple[Case, tuple[float, float]]) -> None:
    """In millimetres or kilonewtons displacements are the same lengths and energies the same."""
    case, (length, force) = given
    here, there = solved(case), solved(in_units(case, length, force))
    agree(here, there, there.displacements / length, "in other units", there.strain_energy / (length * force))


def frame(given: tuple[Case, Any]) -> None:
    """A body that is turned, mirrored or shifted with all that acts on it answers turned, mirrored or shifted."""
    case, (turn, shift) = given
    here, there = solved(case), solved(in_frame(case, turn, shift))
    agree(here, there, turn.T @ there.displacements, "in another frame", there.strain_energy)


def numbering(given: tuple[Case, int]) -> None:
    """Neither the order of nodes and elements nor where their corners begin has a meaning."""
    case, seed = given
    here, there = solved(case), solved(case, seed)
    agree(here, there, _in_order_of(here, there), "with other numbers", there.strain_energy)


def _in_order_of(one: Any, two: Any) -> np.ndarray:
    """Displacements of a solution at the nodes of another one's mesh."""
    gaps = np.abs(one.system.mesh.p[:, :, None] - two.system.mesh.p[:, None, :]).sum(axis=0)
    return two.displacements[:, gaps.argmin(axis=1)]


def symmetry(pair: tuple[Case, Case]) -> None:
    """A half with a plane of symmetry is half of the whole."""
    half, whole = (solved(case) for case in pair)
    agree(half, whole, _in_order_of(half, whole), "of the half and the whole", whole.strain_energy / 2)
