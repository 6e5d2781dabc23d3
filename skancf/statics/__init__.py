"""Equilibrium: Newton's method, load steps, linear answers."""

from skancf.statics.load_steps import HalveAndGrow, StaticResult, solve, solve_linear
from skancf.statics.newton import NewtonResult, Status, newton

__all__ = ["HalveAndGrow", "NewtonResult", "StaticResult", "Status", "newton", "solve", "solve_linear"]
