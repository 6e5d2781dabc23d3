"""Summands of the equations of motion."""

from skancf.terms.term import Addition, Term

__all__ = ["Addition", "Term"]
