"""Theories: which strains are made of the position field."""

from skancf.errors import InputError, shown
from skancf.theories.full.theory import Full
from skancf.theories.kirchhoff.theory import Kirchhoff
from skancf.theories.theory import Theory, left_per_halving

ALL: dict[str, type] = {"full": Full, "kirchhoff": Kirchhoff}


def theory_named(theory: "str | Theory") -> Theory:
    """A theory from its name, with its defaults, or the theory itself."""
    if isinstance(theory, str):
        if theory not in ALL:
            raise InputError(f"theory = {shown(theory)}: unknown; there is {sorted(ALL)}")
        made: Theory = ALL[theory]()
        return made
    if not isinstance(theory, tuple(ALL.values())):
        raise InputError(f"theory = {shown(theory)}: give a name, one of {sorted(ALL)}, or an object such as Full()")
    return theory


__all__ = ["ALL", "Full", "Kirchhoff", "Theory", "left_per_halving", "theory_named"]
