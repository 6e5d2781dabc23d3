"""A pretension that nothing but motion feels, and how far slopes turn: measures of large changes."""

from typing import Any

import numpy as np

from skancf.history import Case
from skancf.layout.folds import first_fold
from skancf.layout.geometry import Geometry
from skancf.linear import BlockMatrix

__all__ = ["first_fold", "largest_turn", "pretension"]

NO_SLOPE = 1e-9
"""A slope so short, relative to the longest, has no direction."""


def pretension(system: Any) -> BlockMatrix:
    """Geometric stiffness of a uniform dilation by one: see :attr:`skancf.system.system.System.pretension`."""
    start = system.undeformed
    dilated = system.stresses(start, start) - system.stresses(start)
    return BlockMatrix(system.pattern, system.tangent(start, Case(0.0), dilated).values - system.stiffness().values)


def largest_turn(geometry: Geometry, change: np.ndarray) -> float:
    """Largest change of a slope, r_x or r_y of a node, relative to the slope's undeformed length; change (n, 4, 3)."""
    lengths = np.sqrt((geometry.undeformed[:, 1:3] ** 2).sum(axis=2))
    with np.errstate(over="ignore"):
        turns = np.sqrt((change[:, 1:3] ** 2).sum(axis=2))
    held = lengths > NO_SLOPE * lengths.max()
    return float((turns[held] / lengths[held]).max())
