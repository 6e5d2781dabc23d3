"""Checks of terms, conditions and laws of one's own, on demand."""

from skancf.materials.own_point_law import check_law
from skancf.materials.point_check import WrongLaw
from skancf.testing.condition import WrongCondition, check_condition
from skancf.testing.shared import Report
from skancf.testing.term import WrongTerm, check_term

__all__ = ["Report", "WrongCondition", "WrongLaw", "WrongTerm", "check_condition", "check_law", "check_term"]
