"""Indicators that say where to refine, the regions they lead to, and quantities of interest."""

from skancf.adapt.limits import drift, no_limit
from skancf.adapt.quantities import Displacement, Quantity, Reaction, Rotation, SectionForce, StrainEnergy
from skancf.adapt.regions import find_regions
from skancf.adapt.stress import nodal_measure, stress_regions

__all__ = [
    "Displacement", "Quantity", "Reaction", "Rotation", "SectionForce", "StrainEnergy", "drift", "find_regions", "no_limit",
    "nodal_measure", "stress_regions",
]  # fmt: skip
