"""Meshes that refine themselves: quantities of interest, indicators, marking, transfer, and the loop."""

from skancf.adapt.estimate import Estimate, goal_estimate, residual
from skancf.adapt.limits import drift, no_limit
from skancf.adapt.loop import adapt
from skancf.adapt.marking import AllElements, Below, Doerfler, FixedFraction, Marking, Maximum, Never
from skancf.adapt.quantities import Displacement, Quantity, Reaction, Rotation, SectionForce, StrainEnergy
from skancf.adapt.recovery import recovery
from skancf.adapt.regions import find_regions
from skancf.adapt.result import AdaptiveResult, Level, Outcome
from skancf.adapt.stability import BucklingLoad
from skancf.adapt.stress import nodal_measure, stress_indicator, stress_regions
from skancf.adapt.transfer import transfer
from skancf.adapt.vibration import Eigenfrequency

__all__ = [
    "AdaptiveResult", "AllElements", "Below", "BucklingLoad", "Displacement", "Doerfler", "Eigenfrequency", "Estimate",
    "FixedFraction", "Level", "Marking", "Maximum", "Never", "Outcome", "Quantity", "Reaction", "Rotation", "SectionForce",
    "StrainEnergy", "adapt", "drift", "find_regions", "goal_estimate", "no_limit", "nodal_measure", "recovery", "residual",
    "stress_indicator", "stress_regions", "transfer",
]  # fmt: skip
