"""Does a number run away as the mesh is refined? Judged by what refinement did."""

from collections.abc import Sequence

import numpy as np

from skancf.adaptive.result import Level
from skancf.adaptive.singular import touching

LEVELS = 3
"""Meshes over which an indicator is watched."""
STAYS = 0.7
"""An indicator that is no smaller than this part of what it was a number of meshes before does not fall."""
LITTLE = 0.1
"""An error of less than this part of the indicators that make it is what cancels in them, not what they say."""
MOST = 0.5
"""Share of all indicators that the elements at one point have then."""


def why_without_limit(levels: Sequence[Level], points: np.ndarray) -> str | None:
    """The point whose elements, smaller on each mesh, hold most of an error that does not fall; None without one.

    An error that falls as slowly as that of a corner, by a half with each halving of the elements there, has a limit. One
    that grows with the logarithm of the element size stays as it is, and so do the parts of the elements in it.
    """
    if len(levels) <= LEVELS or not points.size:
        return None
    watched = levels[-LEVELS - 1 :]
    errors = [abs(level.error) for level in watched]
    for point in points.T:
        at = [touching(level.mesh.leaves, point[:, None]) for level in watched]
        parts = np.array([level.indicators[here].sum() for level, here in zip(watched, at, strict=True)])
        depths = np.array([level.mesh.levels[here].max() for level, here in zip(watched, at, strict=True)])
        alone = parts[-1] > MOST * watched[-1].indicators.sum() and errors[-1] > LITTLE * parts[-1]
        stays = parts[-1] > STAYS * parts[0] and errors[-1] > STAYS * errors[0]
        if alone and stays and (np.diff(depths) > 0).all():
            return (
                f"the value goes on changing as elements at ({point[0]:.6g}, {point[1]:.6g}) get smaller, by as much on "
                "each mesh: it seems to have no limit. Take a quantity away from that point, a mean over a region about it "
                "(SectionForce(..., within=...)), or spread what acts there (DiskForce, a support along an edge)"
            )
    return None
