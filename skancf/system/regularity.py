"""What loads and supports say they do to the regularity of a solution, all of them together."""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np

from skancf.errors import InputError, shown
from skancf.functions import Noted, is_ours
from skancf.history import FULL, Case
from skancf.layout.singularities import Singularity
from skancf.supports import Support
from skancf.system.system import System


def singularities(system: System, case: Case = FULL) -> list[Singularity]:
    """Those of all supports, loads, other terms and conditions.

    Raises
    ------
    InputError
        Where a load, support, term or condition of the user's own says something else.
    """
    return without_conditions(system, case) + of_conditions(system, case)


def of_conditions(system: System, case: Case = FULL) -> list[Singularity]:
    """Those of the conditions."""
    found = [_checked("condition", each, each.singularities, case) for each in system.conditions]
    return [one for said in found for one in said]


def without_conditions(system: System, case: Case = FULL) -> list[Singularity]:
    """Those of all supports, loads and other terms."""
    out: list[Singularity] = []
    for support in system.problem.supports:
        # A class that is not derived from Support need not know of them.
        said = getattr(support, "singularities", None) or partial(Support.singularities, support)
        out += _checked("support", support, said, system.geometry)
    for term in system.terms:
        out += _checked("load" if term.load else "term", getattr(term, "acting", term), term.singularities, case)
    return out


def _checked(name: str, owner: Any, said: Any, argument: Any) -> Sequence[Singularity]:
    if is_ours(owner):
        found: Sequence[Singularity] = said(argument)
        return found
    with Noted(f"{name}.singularities"):
        found = said(argument)
    if not isinstance(found, list | tuple) or not all(isinstance(each, Singularity) for each in found):
        raise InputError(f"{name}.singularities of {shown(owner)} = {shown(found)}: give a list of objects of "
                         "skancf.supports.Singularity, an empty one without any")  # fmt: skip
    return found


def facets_of(found: Iterable[Singularity], *kinds: str) -> np.ndarray:
    """Boundary facets along which all of these kinds act at once, (m,)."""
    parts = [each.facets for each in found if set(kinds) <= set(each.kinds)]
    return np.unique(np.concatenate([np.empty(0, dtype=int), *parts]))
