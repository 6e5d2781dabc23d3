"""Indicators that say where to refine, and the regions they lead to."""

from skancf.adapt.regions import find_regions
from skancf.adapt.stress import nodal_measure, stress_regions

__all__ = ["find_regions", "nodal_measure", "stress_regions"]
