"""A system: the sum of all terms over the unknowns of a mesh. What solvers know."""

from skancf.system.system import System

__all__ = ["System"]
