"""Conditions on the unknowns, g(q) = 0, and the forces that keep them: links, hinges, and the user's own."""

from skancf.conditions.condition import Condition, Joint
from skancf.conditions.hinge import Hinge
from skancf.conditions.rigid_link import RigidLink

__all__ = ["Condition", "Hinge", "Joint", "RigidLink"]
