"""Theory `full`: the fully parameterised plate."""

from skancf.theories.full.theory import Full

__all__ = ["Full"]
