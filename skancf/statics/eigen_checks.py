"""Which eigenvalues a search has found: gaps in which all below can be counted, and what is checked of the pairs."""

from collections.abc import Sequence

import numpy as np

from skancf.checks import Check, failures
from skancf.errors import DidNotConverge, warn
from skancf.tolerances import ORTHOGONAL_SHAPES, SEPARATION

# Neighbours that differ less than this, relatively, belong to one group: equal ones of a symmetric structure differ by the
# error of an unsymmetric mesh.
CLOSE = 1e-3
# Of bounds over the tolerance that was asked for. The errors of Rayleigh quotients are far below, of the order of
# their squares.
SAFETY = 1000.0
# Searches in a row that bring back none of the eigenvalues that are missing.
TRIES = 2


def gap_after(values: np.ndarray, n: int, close: float = CLOSE) -> int | None:
    """The smallest number k >= n such that ``values[k]``, ascending, is apart from those before; None where none is."""
    for k in range(max(n, 1), len(values)):
        if values[k] - values[k - 1] > close * max(abs(values[k]), abs(values[k - 1])):
            return k
    return None


def gap_or_group(values: np.ndarray, n: int, tries: int) -> int | None:
    """The same; in a long group, after some searches, behind the first that is not equal to the next to rounding."""
    found = gap_after(values, n)
    return found if found is not None or tries < 2 else gap_after(values, n, SEPARATION)


def group_note(what: str, values: np.ndarray, n: int, end: int) -> str:
    """That the n-th of ascending values is one of a group of nearly equal ones that ends at ``end`` > n; nothing else."""
    if end <= n:
        return ""
    begin = n - 1
    while begin and gap_after(values[: begin + 1], begin) is None:
        begin -= 1
    return (
        f"{what} {n - 1} is one of a group of {end - begin}, {begin} to {end - 1}, that are equal or nearly so, of which "
        f"{n - begin} {'is' if n - begin == 1 else 'are'} given: their shapes may be mixed at will; ask for n = {end} to "
        "have them all"
    )


def pair_check(errors: np.ndarray, allowed: np.ndarray) -> Check:
    """The pair of which the bound on the relative error is the largest against what is allowed for it."""
    if not errors.size:
        return Check("relative error of the eigenvalues", 0.0, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        worst = int(np.argmax(np.where(np.isnan(errors), np.inf, errors / allowed)))
    return Check(
        f"relative error of the eigenvalues, worst in number {worst}", float(errors[worst]), float(allowed[worst]),
        "Ask for one or two more, or for another tolerance.",
    )  # fmt: skip


def orthogonality_check(products: np.ndarray, metric: str) -> Check:
    """Products (n, n) of the shapes against the unit matrix."""
    off = float(np.abs(products - np.eye(len(products))).max(initial=0.0))
    return Check(
        f"shapes orthonormal in the {metric}", off, ORTHOGONAL_SHAPES, "Ask for one or two more, or a smaller tolerance."
    )


def count_check(found: int, counted: int, where: str) -> Check:
    """How many eigenvalues are missing, or too many, by the signs of pivots."""
    return Check(
        f"eigenvalues {where}: {found} found, {counted} by the signs of the pivots", float(abs(counted - found)), 0.0,
        "Some of the lowest are missing, or counted twice; ask for more, or use another mesh or solver.",
    )  # fmt: skip


def rigid_check(found: int, free: int) -> Check:
    """How many of the rigid motions that nothing holds are missing among motions without stiffness."""
    return Check(
        f"motions without stiffness: {found} found, {free} rigid ones are free", float(max(free - found, 0)), 0.0,
        "So thin a structure bends by less than the stiffness of conditions rounds; take theory 'full', or hold it.",
    )  # fmt: skip


def warn_of_failures(checks: Sequence[Check]) -> None:
    """A warning of the checks that fail, where the caller's caller sees it."""
    said = failures(checks)
    if said:
        warn(said)


def require_checks(checks: Sequence[Check]) -> None:
    """DidNotConverge where a check fails, for a number on which others are built."""
    said = failures(checks)
    if said:
        raise DidNotConverge(said)
