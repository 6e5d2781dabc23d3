"""Tangents about which eigenproblems are solved, and what they leave out."""

from typing import Any

import numpy as np

from skancf.errors import InputError, warn
from skancf.linear import BlockMatrix
from skancf.solution import Solution
from skancf.statics.conditioned import conditions_in, curved
from skancf.statics.corrections import skew_part
from skancf.system.system import System
from skancf.tolerances import ROUNDED_PRODUCT

SYMMETRIC_ONLY = (
    "Loads that follow a free edge, or terms of one's own, have no potential, so that the tangent is not symmetric: only "
    "its symmetric part is counted, and flutter is not found; a run of simulate(system) shows it"
)


def state_tangent(system: System, state: Solution | None) -> BlockMatrix:
    """Symmetric tangent of a state, with its stresses to first order for a linear answer, and the curvature of conditions;
    None is the unloaded state.

    Raises
    ------
    InputError
        For a state without the multipliers of the system's conditions.
    """
    if state is None:
        return system.stiffness()
    conditions, multipliers = conditions_in(system), state.multipliers
    if conditions and (multipliers is None or len(multipliers) != conditions.n):
        raise InputError("state: it has no multipliers of this system's conditions, whose forces are part of the stiffness; "
                         "give what solve, solve_linear or trace found of the same system")  # fmt: skip
    return curved(system, state.model.prestressed(state.unknowns, state.case), state.about, multipliers)


def is_skew(system: Any, tangent: BlockMatrix, q: np.ndarray, load_factor: float) -> bool:
    """Has the loads' tangent a skew part on the free coordinates, the symmetric one scaled to unit diagonal?"""
    skew = skew_part(system, q, load_factor)
    if skew is None:
        return False
    sizes = np.sqrt(np.abs(tangent.diagonal()))
    scale = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    free = system.constraints.free_part
    probe = free(scale * np.random.default_rng(0).standard_normal(q.size))
    return bool(np.abs(scale * free(skew @ probe)).max() > ROUNDED_PRODUCT)


def warn_if_skew(system: System, tangent: BlockMatrix, q: np.ndarray, load_factor: float) -> None:
    """A warning where eigenvalues of the symmetric part do not tell all."""
    if is_skew(system, tangent, q, load_factor):
        warn(SYMMETRIC_ONLY)
