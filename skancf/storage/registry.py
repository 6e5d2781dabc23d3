"""The classes whose objects are kept in files, by name; a new one takes one line here."""

import importlib
from dataclasses import Field, fields
from typing import Any

DESCRIBED: dict[str, tuple[str, ...]] = {
    "problem": ("Problem",),
    "surfaces": (
        "AnnulusSector", "Cone", "CylinderSector", "HyperbolicParaboloid", "MappedSurface", "Parallelogram", "Plane",
        "Rectangle", "SphereSector",
    ),
    "materials": (
        "Anisotropic", "Damping", "Gent", "Hyperelastic", "Isotropic", "Laminate", "Layer", "MooneyRivlin", "NeoHooke",
        "Ogden", "Orthotropic", "Yeoh", "Zone",
    ),
    "supports": (
        "Clamp", "Dashpot", "DrivenClamp", "Foundation", "NoRotation", "Pin", "Prescribed", "Roller", "SimpleSupport",
        "Spring", "Symmetry",
    ),
    "loads": (
        "DiskForce", "EdgeImpulse", "EdgeLoad", "EdgeMoment", "FollowerPressure", "Gravity", "Impulse", "LineLoad",
        "MovingForce", "MovingLine", "PointForce", "PointMoment", "SurfaceLoad", "Temperature",
    ),
    "loads.tables": ("Sampled",),
    "conditions": ("Hinge", "RigidLink"),
    "theories": ("Full", "Kirchhoff"),
    "history": ("Path", "Pulse", "Ramp", "Table"),
    "terms.forms": ("FormTerm",),
    "storage.splined": ("Splined",),
    "statics": ("ArcLength", "DisplacementControl", "DisplacementReached", "HalveAndGrow", "StepLength"),
    "dynamics": (
        "EnergyBalance", "EnergyMomentum", "FixedStep", "GeneralizedAlpha", "ImplicitMidpoint", "LocalError", "NewtonCount",
        "RigidVelocity", "Trapezoidal",
    ),
    "adaptive": (
        "AllElements", "Below", "BucklingLoad", "ConditionForce", "Displacement", "Doerfler", "Eigenfrequency", "Even",
        "FixedFraction", "Maximum", "Never", "Reaction", "Rotation", "SectionForce", "StrainEnergy",
    ),
    "meshes": ("Region",),
}  # fmt: skip
"""Descriptions, by their rooms: what a user writes down, kept as tables of numbers and texts."""

RESULTS: dict[str, tuple[str, ...]] = {
    "solution": ("Solution",),
    "checks": ("Check",),
    "statics": ("BucklingResult", "Choice", "Event", "Modes", "NewtonResult", "PathResult", "StaticResult"),
    "dynamics": ("Ledger", "MeshEvent", "Motion"),
    "dynamics.motion": ("Segment", "Step"),
    "dynamics.pulls": ("Pulls",),
    "adaptive": ("AdaptiveResult", "Level", "TheoryError"),
    "storage.stored": ("StoredFields", "StoredState"),
}
"""Answers, by their rooms: kept as groups of arrays."""

KEPT_OUT = ("BoundedSurface", "Checkpoint", "Follow", "Surface")
"""Public dataclasses and protocols that describe no part of a problem: they name folders and functions."""

Kinds = dict[str, str]


def _rooms(kinds: dict[str, tuple[str, ...]]) -> Kinds:
    return {name: room for room, names in kinds.items() for name in names}


KINDS, ANSWERS = _rooms(DESCRIBED), _rooms(RESULTS)


def class_named(name: str) -> type:
    """A class of either list; its room is imported when it is first asked for."""
    found: type = getattr(importlib.import_module(f"skancf.{(KINDS | ANSWERS)[name]}"), name)
    return found


def kind_of(value: Any, kinds: Kinds) -> str | None:
    """The name of the class of an object, if it is in a list; one of a class that is derived from it is another."""
    cls = type(value)
    name = cls.__name__
    ours = cls.__module__.split(".")[0] == "skancf" and name in kinds
    return name if ours and class_named(name) is cls else None


def fields_of(cls: type) -> dict[str, Field[Any]]:
    """The fields that its call takes, by name."""
    return {field.name: field for field in fields(cls) if field.init}
