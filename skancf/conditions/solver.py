"""What solvers need of a system with conditions, and one without: the same solver and matrix without conditions."""

from typing import Any

import numpy as np

from skancf.linear import BlockMatrix, ConditionedSolver, DirectSolver


def conditions_in(system: Any) -> Any:
    """The conditions of a system; None where it has none, or knows nothing of them."""
    return getattr(system, "conditions", None) or None


def solver_at(system: Any, solver: DirectSolver, q: np.ndarray) -> Any:
    """A solver whose answers meet the conditions of a system to first order about q; the same one without conditions."""
    conditions = conditions_in(system)
    return ConditionedSolver(solver, conditions.gradient(q)) if conditions else solver


def curved(system: Any, matrix: BlockMatrix, q: np.ndarray, multipliers: np.ndarray | None) -> BlockMatrix:
    """A tangent of a system with the curvature of its conditions."""
    conditions = conditions_in(system)
    if not conditions or multipliers is None or not multipliers.size:
        return matrix
    blocks = system.blocks()
    conditions.add_curvature(q, multipliers, blocks)
    return matrix if blocks.is_zero else matrix + blocks.matrix()
