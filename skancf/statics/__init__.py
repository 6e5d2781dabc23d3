"""Equilibrium: Newton's method, load steps, paths, linear answers; buckling and vibration about it."""

from skancf.checks import Check
from skancf.errors import OutOfDepth
from skancf.statics.buckling import BucklingResult, buckling
from skancf.statics.choice import Choice
from skancf.statics.controls import ArcLength, DisplacementControl, DisplacementReached, StepLength
from skancf.statics.equilibrium import solve
from skancf.statics.events import Event
from skancf.statics.linear import solve_linear
from skancf.statics.modes import Modes, modes
from skancf.statics.newton import NewtonResult, newton
from skancf.statics.path import trace
from skancf.statics.path_result import PathResult
from skancf.statics.static_result import HalveAndGrow, StaticResult

__all__ = [
    "ArcLength",
    "BucklingResult",
    "Check",
    "Choice",
    "DisplacementControl",
    "DisplacementReached",
    "Event",
    "HalveAndGrow",
    "Modes",
    "NewtonResult",
    "OutOfDepth",
    "PathResult",
    "StaticResult",
    "StepLength",
    "buckling",
    "modes",
    "newton",
    "solve",
    "solve_linear",
    "trace",
]  # fmt: skip
