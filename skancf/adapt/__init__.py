"""Meshes that refine themselves: quantities of interest, indicators, marking, transfer, and the loop."""

from skancf.adapt.limits import drift, no_limit
from skancf.adapt.marking import AllElements, Below, Doerfler, FixedFraction, Marking, Maximum, Never
from skancf.adapt.quantities import Displacement, Quantity, Reaction, Rotation, SectionForce, StrainEnergy
from skancf.adapt.recovery import recovery
from skancf.adapt.regions import find_regions
from skancf.adapt.stress import nodal_measure, stress_indicator, stress_regions
from skancf.adapt.transfer import transfer

__all__ = [
    "AllElements", "Below", "Displacement", "Doerfler", "FixedFraction", "Marking", "Maximum", "Never", "Quantity",
    "Reaction", "Rotation", "SectionForce", "StrainEnergy", "drift", "find_regions", "no_limit", "nodal_measure", "recovery",
    "stress_indicator", "stress_regions", "transfer",
]  # fmt: skip
