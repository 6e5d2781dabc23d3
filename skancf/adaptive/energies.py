"""Strain energies of the elements, of states and of small changes, and the work of one on the other."""

import numpy as np

from skancf.solution import Solution
from skancf.system.system import System
from skancf.system.unstressed import of_change

Strained = tuple[np.ndarray, np.ndarray]
"""Strains and stresses with their weights, (n_elements, n_strains, n_points) each."""


def small(system: System, change: np.ndarray, q: np.ndarray | None = None) -> Strained:
    """Of a change of the coordinates q, the undeformed ones by default, to first order."""
    return of_change(system.shell, system.undeformed if q is None else q, change)


def of_state(state: Solution) -> Strained:
    """Of a state, those of a free strain not subtracted."""
    return state.model.strained(state.unknowns)


def virtual_work(one: Strained, other: Strained) -> np.ndarray:
    """Of the stresses of one on the strains of the other, (n_elements,) (J)."""
    return np.asarray((other[0] * one[1]).sum(axis=(1, 2)))


def energies(strained: Strained) -> np.ndarray:
    """Sizes of strain energies, (n_elements,) (J).

    Of a small change about a state that is stretched so far that its law grows softer, they may be negative without the work
    of the stress that is there."""
    return np.abs(0.5 * virtual_work(strained, strained))
