"""Meshes that refine themselves: quantities of interest, indicators, marking, transfer, and the loop."""

from skancf.adaptive.estimate import Estimate, goal_estimate, residual_indicator
from skancf.adaptive.follow import Follow
from skancf.adaptive.limits import drift, no_limit
from skancf.adaptive.loop import adapt
from skancf.adaptive.marking import AllElements, Below, Doerfler, Even, FixedFraction, Marking, Maximum, Never
from skancf.adaptive.quantities import (
    ConditionForce,
    Displacement,
    Quantity,
    Reaction,
    Rotation,
    SectionForce,
    StrainEnergy,
)
from skancf.adaptive.recovery import recovery_indicator
from skancf.adaptive.regions import find_regions
from skancf.adaptive.remap import RemapChange, Remapped, remap
from skancf.adaptive.result import AdaptiveResult, Level
from skancf.adaptive.stability import BucklingLoad
from skancf.adaptive.stress import nodal_measure, stress_indicator, stress_regions
from skancf.adaptive.theory_error import TheoryError, theory_error
from skancf.adaptive.transfer import transfer
from skancf.adaptive.vibration import Eigenfrequency

__all__ = [
    "AdaptiveResult", "AllElements", "Below", "BucklingLoad", "ConditionForce", "Displacement", "Doerfler", "Eigenfrequency",
    "Estimate", "Even", "FixedFraction", "Follow", "Level", "Marking", "Maximum", "Never", "Quantity", "Reaction",
    "RemapChange",
    "Remapped", "Rotation", "SectionForce", "StrainEnergy", "TheoryError", "adapt", "drift", "find_regions",
    "goal_estimate", "no_limit", "nodal_measure", "recovery_indicator", "remap", "residual_indicator",
    "stress_indicator", "stress_regions", "theory_error", "transfer",
]  # fmt: skip
