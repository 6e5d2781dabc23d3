"""Quantities of interest: single numbers of a state, with their derivatives by the nodal coordinates."""

from skancf.adapt.quantities.displacement import Displacement
from skancf.adapt.quantities.energy import StrainEnergy
from skancf.adapt.quantities.quantity import Quantity
from skancf.adapt.quantities.reaction import Reaction
from skancf.adapt.quantities.rotation import Rotation
from skancf.adapt.quantities.section_force import SectionForce

ALL = [Displacement, Reaction, Rotation, SectionForce, StrainEnergy]

__all__ = ["ALL", "Displacement", "Quantity", "Reaction", "Rotation", "SectionForce", "StrainEnergy"]
