"""Conditions that cannot be met together: from the beginning, or beyond a load factor on the way."""

from functools import partial
from typing import Any

import numpy as np

from skancf.conditions.solver import conditions_in
from skancf.errors import InputError
from skancf.history import Case
from skancf.kernels.constants import AXES, BLOCK
from skancf.linear import contradiction, least_squares
from skancf.tolerances import CONTRADICTION

ASIDE = 1e-3
"""Of the size of nodal vectors: a change from which conditions are tried once more. Rods in line cannot get shorter to first
order, and do where they leave their line."""


def require_no_contradiction(system: Any) -> None:
    """InputError where no small change meets all conditions of the undeformed state with supports where they go."""
    conditions = conditions_in(system)
    if not conditions:
        return
    at = system.undeformed + system.prescribed()
    values = conditions.value(at)
    if conditions.met(values):
        return
    rows = contradiction(conditions.gradient(at), -values, conditions.scales, system.constraints)
    if rows.size:
        raise InputError(f"conditions contradict each other: {_words(system, at, rows)}")


def contradiction_ahead(system: Any, q: np.ndarray, load_factor: float, to: float) -> str | None:
    """Which conditions of a state (n_dofs,) cannot be met together on the way to another load factor, and beyond which.

    The structure has no say in it: whether any change of free coordinates near the state meets the conditions, with supports
    where they go, is a question of their geometry alone. None where one does, and where there are no conditions.
    """
    conditions = conditions_in(system)
    if not conditions or not conditions.met(conditions.value(q, Case(load_factor))):
        return None
    worst, rows = _open_rows(system, q, to)
    if rows is None or not rows.size:
        return None
    met, beyond = load_factor, to
    while abs(beyond - met) > CONTRADICTION * max(abs(to), abs(load_factor)):
        middle = 0.5 * (met + beyond)
        nearer, left = _open_rows(system, q, middle)
        if left is None:
            break
        met, q, beyond = (met, q, middle) if left.size else (middle, nearer, beyond)
    return f"Conditions contradict each other: {_words(system, worst, rows, f' beyond load factor {met:.4g}')}."


def _open_rows(system: Any, q: np.ndarray, load_factor: float) -> tuple[np.ndarray, np.ndarray | None]:
    """A state near another that meets conditions as well as any, and rows that it leaves open, see :func:`least_squares`."""
    conditions, constraints, case = system.conditions, system.constraints, Case(load_factor)
    at = q + constraints.fixed_part(system.undeformed + load_factor * system.prescribed() - q)
    sizes = np.abs(q).reshape(-1, BLOCK // AXES, AXES).max(axis=(0, 2))
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, (q.size // BLOCK, BLOCK)) * np.repeat(sizes, AXES)
    aside = at + constraints.free_part(ASIDE * noise.ravel())

    def solved(begin: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        value = partial(conditions.value, case=case)
        return least_squares(value, conditions.gradient, begin, constraints, conditions.met)

    found, rows = solved(at)
    return (found, rows) if rows is not None and not rows.size else solved(aside)


def _words(system: Any, q: np.ndarray, rows: np.ndarray, beyond: str = "") -> str:
    conditions = system.conditions
    names = [repr(name) for name in dict.fromkeys(conditions.owner(row) for row in np.sort(rows))]
    if len(names) == 1 or (conditions.gradient(q)[rows] @ system.prescribed()).any():
        names.append("what supports prescribe")
    together = f"{', '.join(names[:-1])} and {names[-1]} cannot be met together{beyond}"
    return f"{together}, as {conditions.words(rows[0])} shows. Take one of them out, or let both move alike"
