"""Summands of the equations of motion."""
