"""How many cells in each direction make a given number of nodes."""

from itertools import count
from math import exp, isqrt, log
from typing import Any

import numpy as np

from skancf.arguments import whole
from skancf.errors import InputError, shown
from skancf.meshes.placing import coarse_for
from skancf.meshes.sizes import Sizes
from skancf.surfaces import Surface
from skancf.tolerances import ROOT_OF_COUNTS, SAME_VALUE

# A factorisation may miss the natural nx : ny by this factor; beyond it cells get needlessly slender.
WIDEST_MISS = 5 / 3


def shape_for(surface: Surface, along_x: Sizes, along_y: Sizes, nodes: int) -> tuple[int, int]:
    """(nx, ny) with (nx + 1)(ny + 1) = ``nodes`` and nx : ny closest to the natural one.

    Raises
    ------
    InputError
        When no factorisation comes near; names the closest numbers of nodes that have one.
    """
    whole("nodes", nodes, least=4)
    natural = natural_proportion(surface, along_x, along_y, nodes)
    shape = factorise(nodes, natural)
    if shape is None:
        fewer = next((n for n in range(nodes - 1, 3, -1) if factorise(n, natural)), None)
        more = next(n for n in count(nodes + 1) if factorise(n, natural))
        nearest = f"{fewer} or {more}" if fewer else f"{more}"
        raise InputError(
            f"nodes = {nodes}: this is not (nx + 1)(ny + 1) with nx : ny near {natural:.3g}; the nearest "
            f"possible numbers are {nearest}; or give shape=(nx, ny)"
        )
    return shape


def factorise(nodes: int, proportion: float) -> tuple[int, int] | None:
    """The pair of counts with nx : ny closest to ``proportion``, None if all miss it by more than ``WIDEST_MISS``."""
    small = [d for d in range(2, isqrt(nodes) + 1) if nodes % d == 0]
    pairs = [(d - 1, nodes // d - 1) for d in sorted({*small, *(nodes // d for d in small)})]
    # Rounded: two mirror images miss by the same factor, and the first of them is taken on every machine.
    misses = [round(abs(log(nx / ny / proportion)), 9) for nx, ny in pairs]
    best = min(misses, default=np.inf)
    return pairs[misses.index(best)] if best <= log(WIDEST_MISS) + SAME_VALUE else None


def natural_proportion(surface: Surface, along_x: Sizes, along_y: Sizes, nodes: int) -> float:
    """nx : ny, as real numbers, when the coarse length in space is the same in both directions."""
    from scipy.optimize import brentq  # not at the top: graded meshes alone need it, and it is slow to load

    scale_x, scale_y = stretch(surface)

    def counts(log_coarse: float) -> tuple[float, float]:
        return along_x.count(exp(log_coarse) / scale_x), along_y.count(exp(log_coarse) / scale_y)

    def missing(log_coarse: float) -> float:
        nx, ny = counts(log_coarse)
        return (nx + 1) * (ny + 1) - nodes

    # With the other direction at one cell or none, a direction holds at most ``nodes`` cells; and in the coarsest case
    # each direction holds at most one.
    finest = min(coarse_for(along_x, nodes) * scale_x, coarse_for(along_y, nodes) * scale_y)
    coarsest = max(coarse_for(along_x, 1) * scale_x, coarse_for(along_y, 1) * scale_y)
    nx, ny = counts(brentq(missing, log(finest), log(coarsest) + SAME_VALUE, xtol=ROOT_OF_COUNTS))
    return nx / ny


def stretch(surface: Any) -> tuple[float, float]:
    """Mean lengths of X_x and X_y: what a unit of each parameter measures in space."""
    (x_low, x_high), (y_low, y_high) = surface.bounds
    middles = (np.arange(16) + 0.5) / 16
    x, y = np.meshgrid(x_low + (x_high - x_low) * middles, y_low + (y_high - y_low) * middles)
    x_slope, y_slope = surface.derivatives(x, y)
    along_x, along_y = (float(np.linalg.norm(slope, axis=0).mean()) for slope in (x_slope, y_slope))
    if not (along_x > 0 and along_y > 0):
        raise InputError(f"surface = {shown(surface)}: the mean lengths of X_x and X_y are {along_x:.3g} and {along_y:.3g}; "
                         "a surface has area, correct its derivatives")  # fmt: skip
    return along_x, along_y
