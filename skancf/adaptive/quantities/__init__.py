"""Quantities of interest: single numbers of a state, with their derivatives by the nodal coordinates."""

from skancf.adaptive.quantities.condition_force import ConditionForce
from skancf.adaptive.quantities.displacement import Displacement
from skancf.adaptive.quantities.energy import StrainEnergy
from skancf.adaptive.quantities.quantity import Quantity
from skancf.adaptive.quantities.reaction import Reaction
from skancf.adaptive.quantities.rotation import Rotation
from skancf.adaptive.quantities.section_force import SectionForce

__all__ = ["ConditionForce", "Displacement", "Quantity", "Reaction", "Rotation", "SectionForce", "StrainEnergy"]
