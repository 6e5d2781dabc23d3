"""Indicators that say where to refine, the elements they mark, and the regions they lead to."""

from skancf.adapt.marking import AllElements, Below, Doerfler, FixedFraction, Marking, Maximum, Never
from skancf.adapt.recovery import recovery
from skancf.adapt.regions import find_regions
from skancf.adapt.stress import nodal_measure, stress_indicator, stress_regions

__all__ = [
    "AllElements",
    "Below",
    "Doerfler",
    "FixedFraction",
    "Marking",
    "Maximum",
    "Never",
    "find_regions",
    "nodal_measure",
    "recovery",
    "stress_indicator",
    "stress_regions",
]
