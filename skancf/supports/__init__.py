"""Supports: which nodal coordinates are held, moved as prescribed, or held by springs and dashpots."""

from skancf.layout.singularities import Singularity
from skancf.supports.conditions import Support
from skancf.supports.driven import DrivenClamp
from skancf.supports.elastic import Dashpot, Foundation, Spring
from skancf.supports.held import Clamp, NoRotation, Pin, Roller, SimpleSupport, Symmetry
from skancf.supports.prescribed import Prescribed

ALL = [Clamp, Dashpot, DrivenClamp, Foundation, NoRotation, Pin, Prescribed, Roller, SimpleSupport, Spring, Symmetry]

__all__ = [
    "ALL", "Clamp", "Dashpot", "DrivenClamp", "Foundation", "NoRotation", "Pin", "Prescribed", "Roller", "SimpleSupport",
    "Singularity", "Spring", "Support", "Symmetry",
]  # fmt: skip
