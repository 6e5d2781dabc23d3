"""Theory `kirchhoff`: thin plates and shells."""

from skancf.theories.kirchhoff.theory import Kirchhoff

__all__ = ["Kirchhoff"]
