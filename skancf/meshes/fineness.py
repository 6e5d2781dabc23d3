"""How fine a region is: the rule that graded and quadtree meshes share."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skancf.errors import InputError, finite, number, positive
from skancf.meshes.region import Region
from skancf.tolerances import ONE_PLACE

Pair = tuple[float, float]


def fractions(regions: Sequence[Region], finest: float) -> np.ndarray:
    r"""Fine length over coarse length of each region, :math:`\max(\text{finest}, (\sigma_i / \bar\sigma)^{-1/2})`: (m,)."""
    finest = number("finest", finest)
    if not 0 < finest < 1:
        raise InputError(f"finest = {finest}: give the smallest fine length over the coarse one, between 0 and 1")
    return np.array([max(finest, region.ratio**-0.5) for region in regions])


def coarse_lengths(coarse: Any, bounds: Sequence[Pair]) -> Pair:
    """The coarse length in each direction, which must fit between the bounds there."""
    lengths = pair("coarse", coarse)
    for direction, (length, (low, high)) in enumerate(zip(lengths, bounds, strict=True)):
        if positive("coarse", length) > (high - low) * (1 + ONE_PLACE):
            raise InputError(f"coarse: an element length l_0 = {length} does not fit into the side L = {high - low} "
                             f"along {'xy'[direction]}; give a shorter one")  # fmt: skip
    return lengths


def pair(name: str, value: Any) -> Pair:
    """One number for both directions, or one for each."""
    array = finite(name, value)
    if array.shape not in ((), (2,)):
        raise InputError(f"{name} = {value}: give one number, or one for each direction")
    x, y = np.broadcast_to(array, 2).tolist()
    return x, y
