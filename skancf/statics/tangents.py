"""Tangents about which eigenproblems are solved, and what they leave out."""

import warnings
from typing import Any

import numpy as np

from skancf.assembly.system import System
from skancf.errors import OutOfDepth
from skancf.linear import BlockMatrix
from skancf.solution import Solution
from skancf.statics.newton import skew_part

# A skew part so small against the stiffness is rounding, of edges that are held or lie in a plane of symmetry.
ROUNDING = 1e-12
# A stiffness so many times what is added to it leaves twelve digits of that.
NO_LOSS = 1e3
SYMMETRIC_ONLY = (
    "Loads that follow a free edge have no potential, so that the tangent is not symmetric: only its symmetric part is "
    "counted, and flutter is not found; a run of simulate(system) shows it"
)


def linear_tangent(system: System, change: np.ndarray, load_factor: float = 1.0) -> BlockMatrix:
    """Tangent of the undeformed place with the first-order stresses of a linear answer, (n_dofs,), and the loads' own part.

    The computed stresses of the undeformed state are rounding, and taken away.
    """
    start = system.undeformed
    return system.tangent(start, system.stresses(start, change) - system.stresses(start), factor=load_factor)


def geometric_stiffness(system: System, change: np.ndarray, stiffness: BlockMatrix) -> BlockMatrix:
    """What the stresses of a linear answer, (n_dofs,), and its loads add to the stiffness of the undeformed state.

    It is a difference of two matrices, in which a load that is small against the stiffness is lost to rounding: then the
    load is taken larger, and the difference divided by that.
    """
    added = linear_tangent(system, change) + (-1.0) * stiffness
    size = float(np.abs(added.values).max())
    larger = float(np.abs(stiffness.values).max()) / size if size else 1.0
    if larger <= NO_LOSS:
        return added
    return (1.0 / larger) * (linear_tangent(system, larger * change, larger) + (-1.0) * stiffness)


def state_tangent(system: System, state: Solution | None) -> BlockMatrix:
    """Symmetric tangent of a state; of a linear answer that which :func:`linear_tangent` has; None is the unloaded state."""
    if state is None:
        return system.stiffness()
    if state.linear:
        return linear_tangent(system, state.change, state.load_factor)
    return system.tangent(state.q, factor=state.load_factor)


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
