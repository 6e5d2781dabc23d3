"""Theories: which strains are made of the position field."""

from skancf.errors import InputError
from skancf.theories.full import Full

ALL = {"full": Full}


def theory_named(theory: "str | Full") -> Full:
    """A theory from its name, with its defaults, or the theory itself."""
    if isinstance(theory, str):
        if theory not in ALL:
            raise InputError(f"theory = {theory!r}: unknown; there is {sorted(ALL)}")
        return ALL[theory]()
    if not isinstance(theory, Full):
        raise InputError(f"theory = {theory!r}: give a name, one of {sorted(ALL)}, or an object such as Full()")
    return theory


__all__ = ["ALL", "Full", "theory_named"]
