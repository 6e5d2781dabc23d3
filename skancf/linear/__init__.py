"""Symmetric matrices of small dense blocks, and direct solvers that keep what they know of a pattern.

Nothing here knows of elements: a pattern comes from a graph of nodes, a matrix from numbers, and a solver from both
together with the coordinates that are prescribed.
"""

from skancf.linear.conditioned import ConditionedSolver, contradiction
from skancf.linear.constraints import Constraints
from skancf.linear.least_squares import least_squares
from skancf.linear.matrix import BlockMatrix
from skancf.linear.pattern import BlockPattern
from skancf.linear.skew import SkewSolver
from skancf.linear.softest import factor_shifted, soft_motions
from skancf.linear.solver import BACKENDS, DirectSolver, available_backends, check_backend

__all__ = [
    "BACKENDS", "BlockMatrix", "BlockPattern", "ConditionedSolver", "Constraints", "DirectSolver", "SkewSolver",
    "available_backends", "check_backend", "contradiction", "factor_shifted", "least_squares", "soft_motions",
]  # fmt: skip
