"""Plates and shells that move and bend a lot: ANCF with local refinement on scikit-fem."""

from skancf import adapt, meshes, output
from skancf.dynamics import FixedStep, GeneralizedAlpha, LocalError, Motion, simulate
from skancf.elements import ElementQuadANCF, through_thickness
from skancf.errors import DidNotConverge, InputError, SingularMatrix, SkancfError
from skancf.loads import DiskForce, EdgeLoad, EdgeMoment, Gravity, PointForce, SurfaceLoad
from skancf.materials import Anisotropic, Isotropic, Orthotropic
from skancf.problem import Problem
from skancf.solution import Solution
from skancf.statics import (
    ArcLength,
    BucklingResult,
    DisplacementControl,
    DisplacementReached,
    HalveAndGrow,
    Modes,
    PathResult,
    StaticResult,
    StepLength,
    buckling,
    modes,
    solve,
    solve_linear,
    trace,
)
from skancf.supports import Clamp, Pin, Prescribed, Roller, SimpleSupport, Symmetry
from skancf.surfaces import AnnulusSector, Plane, Rectangle
from skancf.theories import Full
from skancf.version import __version__

__all__ = [
    "Anisotropic",
    "AnnulusSector",
    "ArcLength",
    "BucklingResult",
    "Clamp",
    "DidNotConverge",
    "DiskForce",
    "DisplacementControl",
    "DisplacementReached",
    "EdgeLoad",
    "EdgeMoment",
    "ElementQuadANCF",
    "FixedStep",
    "Full",
    "GeneralizedAlpha",
    "Gravity",
    "HalveAndGrow",
    "InputError",
    "Isotropic",
    "LocalError",
    "Modes",
    "Motion",
    "Orthotropic",
    "PathResult",
    "Pin",
    "Plane",
    "PointForce",
    "Prescribed",
    "Problem",
    "Rectangle",
    "Roller",
    "SimpleSupport",
    "SingularMatrix",
    "SkancfError",
    "Solution",
    "StaticResult",
    "StepLength",
    "SurfaceLoad",
    "Symmetry",
    "__version__",
    "adapt",
    "buckling",
    "meshes",
    "modes",
    "output",
    "simulate",
    "solve",
    "solve_linear",
    "through_thickness",
    "trace",
]  # fmt: skip
