"""Tangents about which eigenproblems are solved, and what they leave out."""

import warnings
from typing import Any

import numpy as np

from skancf.errors import OutOfDepth
from skancf.history import Case
from skancf.linear import BlockMatrix
from skancf.solution import Solution
from skancf.statics.newton import skew_part
from skancf.system.system import System

# A skew part so small against the stiffness is rounding, of edges that are held or lie in a plane of symmetry.
ROUNDING = 1e-12
STEP = 1e-5
"""Of a difference, relative to the size of the body: its square, and rounding over it, are small."""
SYMMETRIC_ONLY = (
    "Loads that follow a free edge have no potential, so that the tangent is not symmetric: only its symmetric part is "
    "counted, and flutter is not found; a run of simulate(system) shows it"
)


def linear_tangent(system: System, change: np.ndarray, load_factor: float = 1.0) -> BlockMatrix:
    """Tangent of the undeformed place with the first-order stresses of a linear answer, (n_dofs,), and the loads' own part.

    The computed stresses of the undeformed state are rounding, and taken away.
    """
    return system.stiffness() + geometric_stiffness(system, change, load_factor)


def geometric_stiffness(system: System, change: np.ndarray, load_factor: float = 1.0) -> BlockMatrix:
    """What the stresses of a linear answer, (n_dofs,), and its loads add to the stiffness of the undeformed state.

    It is a difference of two matrices, in which what is small against the stiffness is lost to rounding. It is linear in the
    load, so that answer and load are scaled to the size of the body first.
    """
    start, size = system.undeformed, float(np.abs(change).max(initial=0.0))
    power = int(np.frexp(np.abs(start).max())[1] - np.frexp(size)[1]) if size else 0
    stresses = system.stresses(start, np.ldexp(change, power)) - system.stresses(start)
    scaled = system.tangent(start, Case(float(np.ldexp(load_factor, power))), stresses)
    values = scaled.values - system.stiffness().values
    if others := _change_of_others(system, np.ldexp(change, power)):
        values += others.values
    return BlockMatrix(scaled.pattern, np.ldexp(values, -power))


def _change_of_others(system: Any, change: np.ndarray) -> BlockMatrix | None:
    """Derivative of the tangent of terms beside the shell along a change of the size of the body, by differences."""
    start, others = system.undeformed, getattr(system, "others", None)
    if not others:
        return None
    after, before = (others.tangent(start + sign * STEP * change) for sign in (1.0, -1.0))
    if after is None or before is None:
        return None
    return BlockMatrix(after.pattern, (after.values - before.values) / (2 * STEP))


def state_tangent(system: System, state: Solution | None) -> BlockMatrix:
    """Symmetric tangent of a state; of a linear answer that which :func:`linear_tangent` has; None is the unloaded state."""
    if state is None:
        return system.stiffness()
    if state.linear:
        return linear_tangent(system, state.change, state.load_factor)
    return system.tangent(state.q, state.case)


def is_skew(system: Any, tangent: BlockMatrix, q: np.ndarray, load_factor: float) -> bool:
    """Has the loads' tangent a skew part on the free coordinates, the symmetric one scaled to unit diagonal?"""
    skew = skew_part(system, q, load_factor)
    if skew is None:
        return False
    sizes = np.sqrt(np.abs(tangent.diagonal()))
    scale = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    free = system.constraints.free_part
    probe = free(scale * np.random.default_rng(0).standard_normal(q.size))
    return bool(np.abs(scale * free(skew @ probe)).max() > ROUNDING)


def warn_if_skew(system: System, tangent: BlockMatrix, q: np.ndarray, load_factor: float) -> None:
    """A warning where eigenvalues of the symmetric part do not tell all."""
    if is_skew(system, tangent, q, load_factor):
        warnings.warn(SYMMETRIC_ONLY, OutOfDepth, stacklevel=3)
