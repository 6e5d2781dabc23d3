"""Plates and shells that move and bend a lot: ANCF with local refinement on scikit-fem."""

from skancf import adapt, meshes, output
from skancf.dynamics import FixedStep, GeneralizedAlpha, LocalError, Motion, simulate
from skancf.elements import ElementQuadANCF, ElementQuadHermite, through_thickness
from skancf.errors import DidNotConverge, InputError, SingularMatrix, SkancfError
from skancf.loads import (
    DiskForce,
    EdgeLoad,
    EdgeMoment,
    FollowerPressure,
    Gravity,
    LineLoad,
    PointForce,
    SurfaceLoad,
    Temperature,
)
from skancf.materials import Anisotropic, Isotropic, Laminate, Layer, Orthotropic
from skancf.problem import Problem
from skancf.solution import Solution
from skancf.statics import HalveAndGrow, StaticResult, solve, solve_linear
from skancf.supports import Clamp, Foundation, Pin, Prescribed, Roller, SimpleSupport, Spring, Symmetry
from skancf.surfaces import (
    AnnulusSector,
    Cone,
    CylinderSector,
    HyperbolicParaboloid,
    MappedSurface,
    Parallelogram,
    Plane,
    Rectangle,
    SphereSector,
)
from skancf.theories import Full, Kirchhoff
from skancf.version import __version__

__all__ = [
    "Anisotropic",
    "AnnulusSector",
    "Clamp",
    "Cone",
    "CylinderSector",
    "DidNotConverge",
    "DiskForce",
    "EdgeLoad",
    "EdgeMoment",
    "ElementQuadANCF",
    "ElementQuadHermite",
    "FixedStep",
    "FollowerPressure",
    "Foundation",
    "Full",
    "GeneralizedAlpha",
    "Gravity",
    "HalveAndGrow",
    "HyperbolicParaboloid",
    "InputError",
    "Isotropic",
    "Kirchhoff",
    "Laminate",
    "Layer",
    "LineLoad",
    "LocalError",
    "MappedSurface",
    "Motion",
    "Orthotropic",
    "Parallelogram",
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
    "SphereSector",
    "Spring",
    "StaticResult",
    "SurfaceLoad",
    "Symmetry",
    "Temperature",
    "__version__",
    "adapt",
    "meshes",
    "output",
    "simulate",
    "solve",
    "solve_linear",
    "through_thickness",
]  # fmt: skip
