"""Plates and shells that move and bend a lot: ANCF with local refinement on scikit-fem."""

import importlib
import logging
from typing import TYPE_CHECKING, Any

from skancf import (
    adaptive,
    conditions,
    dynamics,
    loads,
    materials,
    meshes,
    statics,
    supports,
    surfaces,
    terms,
    theories,
)  # fmt: skip
from skancf.adaptive import (
    AdaptiveResult,
    AllElements,
    Below,
    BucklingLoad,
    ConditionForce,
    Displacement,
    Doerfler,
    Eigenfrequency,
    Even,
    FixedFraction,
    Follow,
    Maximum,
    Never,
    Reaction,
    RemapChange,
    Remapped,
    Rotation,
    SectionForce,
    StrainEnergy,
    TheoryError,
    adapt,
    find_regions,
    goal_estimate,
    nodal_measure,
    recovery_indicator,
    remap,
    residual_indicator,
    stress_indicator,
    stress_regions,
    theory_error,
    transfer,
)
from skancf.checks import Check
from skancf.compiling import announce
from skancf.conditions import Hinge, RigidLink
from skancf.dynamics import (
    Checkpoint,
    EnergyBalance,
    EnergyMomentum,
    FixedStep,
    GeneralizedAlpha,
    ImplicitMidpoint,
    Ledger,
    LocalError,
    Motion,
    NewtonCount,
    RigidVelocity,
    Spectrum,
    Trapezoidal,
    read_motion,
    simulate,
    spectrum,
)
from skancf.elements import ElementQuadANCF, ElementQuadHermite, through_thickness
from skancf.envelopes import Envelope, envelope
from skancf.errors import DidNotConverge, InputError, NoLimit, NotEnoughMemory, SingularMatrix, SkancfError
from skancf.history import Case, Path, Pulse, Ramp, Table
from skancf.lines import Arc
from skancf.loads import (
    DiskForce,
    EdgeImpulse,
    EdgeLoad,
    EdgeMoment,
    FollowerPressure,
    Gravity,
    Impulse,
    LineLoad,
    MovingForce,
    MovingLine,
    PointForce,
    PointMoment,
    SurfaceLoad,
    Temperature,
)
from skancf.materials import (
    Anisotropic,
    Damping,
    Isotropic,
    Laminate,
    Layer,
    Orthotropic,
    Zone,
)
from skancf.problem import Problem
from skancf.progress import Progress
from skancf.solution import Solution
from skancf.solving import Status
from skancf.statics import (
    ArcLength,
    BucklingResult,
    DisplacementControl,
    DisplacementReached,
    HalveAndGrow,
    Modes,
    OutOfDepth,
    PathResult,
    StaticResult,
    StepLength,
    buckling,
    modes,
    solve,
    solve_linear,
    trace,
)
from skancf.strength import Strength, Utilisation, utilisation
from skancf.supports import (
    Clamp,
    Dashpot,
    DrivenClamp,
    Foundation,
    NoRotation,
    Pin,
    Prescribed,
    Roller,
    SimpleSupport,
    Spring,
    Symmetry,
)
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
from skancf.units import Units
from skancf.version import __version__

if TYPE_CHECKING:
    from skancf import export, output, storage, testing
    from skancf.about import info
    from skancf.materials import Hyperelastic, MooneyRivlin, NeoHooke, Ogden
    from skancf.storage import load, read_problem, save
    from skancf.storage.run_file import run_file
    from skancf.terms.forms import FormTerm

__all__ = [
    "AdaptiveResult",
    "AllElements",
    "Anisotropic",
    "AnnulusSector",
    "Arc",
    "ArcLength",
    "Below",
    "BucklingLoad",
    "BucklingResult",
    "Case",
    "Check",
    "Checkpoint",
    "Clamp",
    "ConditionForce",
    "Cone",
    "CylinderSector",
    "Damping",
    "Dashpot",
    "DidNotConverge",
    "DiskForce",
    "Displacement",
    "DisplacementControl",
    "DisplacementReached",
    "Doerfler",
    "DrivenClamp",
    "EdgeImpulse",
    "EdgeLoad",
    "EdgeMoment",
    "Eigenfrequency",
    "ElementQuadANCF",
    "ElementQuadHermite",
    "EnergyBalance",
    "EnergyMomentum",
    "Envelope",
    "Even",
    "FixedFraction",
    "FixedStep",
    "Follow",
    "FollowerPressure",
    "FormTerm",
    "Foundation",
    "Full",
    "GeneralizedAlpha",
    "Gravity",
    "HalveAndGrow",
    "Hinge",
    "HyperbolicParaboloid",
    "Hyperelastic",
    "ImplicitMidpoint",
    "Impulse",
    "InputError",
    "Isotropic",
    "Kirchhoff",
    "Laminate",
    "Layer",
    "Ledger",
    "LineLoad",
    "LocalError",
    "MappedSurface",
    "Maximum",
    "Modes",
    "MooneyRivlin",
    "Motion",
    "MovingForce",
    "MovingLine",
    "NeoHooke",
    "Never",
    "NewtonCount",
    "NoLimit",
    "NoRotation",
    "NotEnoughMemory",
    "Ogden",
    "Orthotropic",
    "OutOfDepth",
    "Parallelogram",
    "Path",
    "PathResult",
    "Pin",
    "Plane",
    "PointForce",
    "PointMoment",
    "Prescribed",
    "Problem",
    "Progress",
    "Pulse",
    "Ramp",
    "Reaction",
    "Rectangle",
    "RemapChange",
    "Remapped",
    "RigidLink",
    "RigidVelocity",
    "Roller",
    "Rotation",
    "SectionForce",
    "SimpleSupport",
    "SingularMatrix",
    "SkancfError",
    "Solution",
    "Spectrum",
    "SphereSector",
    "Spring",
    "StaticResult",
    "Status",
    "StepLength",
    "StrainEnergy",
    "Strength",
    "SurfaceLoad",
    "Symmetry",
    "Table",
    "Temperature",
    "TheoryError",
    "Trapezoidal",
    "Units",
    "Utilisation",
    "Zone",
    "__version__",
    "adapt",
    "adaptive",
    "buckling",
    "conditions",
    "dynamics",
    "envelope",
    "export",
    "find_regions",
    "goal_estimate",
    "info",
    "load",
    "loads",
    "materials",
    "meshes",
    "modes",
    "nodal_measure",
    "output",
    "read_motion",
    "read_problem",
    "recovery_indicator",
    "remap",
    "residual_indicator",
    "run_file",
    "save",
    "simulate",
    "solve",
    "solve_linear",
    "spectrum",
    "statics",
    "storage",
    "stress_indicator",
    "stress_regions",
    "supports",
    "surfaces",
    "terms",
    "testing",
    "theories",
    "theory_error",
    "through_thickness",
    "trace",
    "transfer",
    "utilisation",
]  # fmt: skip


# Nothing is printed before a user asks for it, as by logging.basicConfig(level=logging.INFO).
logging.getLogger(__name__).addHandler(logging.NullHandler())

announce()

LATER_ROOMS = ("export", "output", "storage", "testing")
LATER_NAMES = {
    **dict.fromkeys(("Hyperelastic", "MooneyRivlin", "NeoHooke", "Ogden"), "materials"),
    **dict.fromkeys(("load", "read_problem", "run_file", "save"), "storage"),
    "FormTerm": "terms.forms",
    "info": "about",
}


def __getattr__(name: str) -> Any:
    """Some are loaded when they are first used: many runs show and keep nothing, and few have rubber or forms."""
    if name in LATER_ROOMS:
        return importlib.import_module(f"skancf.{name}")
    if name in LATER_NAMES:
        return getattr(importlib.import_module(f"skancf.{LATER_NAMES[name]}"), name)
    raise AttributeError(f"module 'skancf' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
