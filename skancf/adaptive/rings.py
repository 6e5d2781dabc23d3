r"""What a halving of the elements at a singular point leaves of an error, measured in rings about it.

Of a solution :math:`w \sim r^s` the rings between the radii :math:`2^{-j}` and :math:`2^{-j-1}` hold energies in proportion
to :math:`2^{-2 (s - 1) j}`, and so does what elements of such a size miss. With the energies of the answer and of the dual
weight, whose product is the error of a quantity,

.. math:: l = \left( \frac{E_j(u)\, E_j(z)}{E_{j-1}(u)\, E_{j-1}(z)} \right)^{1/2} .

Of the last two rings the smaller ratio counts: the last one has a part of the error of the innermost elements, the one
before more of the smooth part of the answer, and both mostly add to it.

The enriched mesh has a ring for each quartering at a singular point. No table of corners, supports and laws is asked.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skancf.adaptive.interpolation import ancestors_in
from skancf.adaptive.singular import images, touching
from skancf.equality import by_value
from skancf.meshes import MeshQuadTree
from skancf.meshes.forest import Leaves
from skancf.showing import short
from skancf.system.system import System
from skancf.tolerances import SAME_POINT

UNKNOWN = 1 / 2
"""Where nothing is measured, and at a quantity's own point: the largest of what clamped corners and point loads leave."""
LEAST, MOST = 0.25, 0.95
"""Bounds of what is measured. A smooth solution has a quarter of the energy in a ring of half the size."""
RINGS = 3
"""Quarterings that make enough of them: the outermost ring still has the smooth part of the answer."""

Pair = tuple[np.ndarray, np.ndarray]
"""Energies in the elements of the refined mesh, of an answer and of a weight."""


@by_value
@dataclass(frozen=True)
class Halvings:
    """What one halving leaves at singular points.

    Attributes
    ----------
    points : (2, n) array
        In the parameter plane.
    left : (n,) array
    """

    points: np.ndarray
    left: np.ndarray

    __repr__ = short

    def at(self, point: np.ndarray, extent: np.ndarray) -> float | None:
        """That of a point (2,); None of one that is not known."""
        apart = np.abs((self.points - point[:, None]) / extent[:, None]).max(axis=0)
        return float(self.left[np.argmin(apart)]) if apart.size and apart.min() < SAME_POINT else None

    def of(self, leaves: Leaves, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Leaves that hold any of the points (2, m), and the largest part that one of these leaves there."""
        there, left = touching(leaves, points), np.zeros(len(leaves))
        for point in points.T:
            known = self.at(point, leaves.extent)
            here = touching(leaves, point[:, None])
            left[here] = np.maximum(left[here], UNKNOWN if known is None else known)
        return there, left[there]


NOTHING_KNOWN = Halvings(np.empty((2, 0)), np.empty(0))


def halvings(
    coarse: System, fine: System, points: np.ndarray, pairs: Sequence[Pair], before: Halvings | None = None
) -> Halvings:
    """Of the singular points (2, n) of a problem; of those with too few rings what was ``before``, if they were there.

    Of several pairs of answer and weight, which each have a part in the error, the one that leaves most counts.
    """
    before, extent = before or NOTHING_KNOWN, coarse.mesh.leaves.extent
    above = ancestors_in(coarse.mesh.leaves, fine.mesh.leaves)
    left = np.empty(points.shape[1])
    for number, point in enumerate(points.T):
        around = images(fine.geometry, fine.mesh.leaves, point[:, None])
        here = touching(coarse.mesh.leaves, around)
        inside = np.flatnonzero(np.isin(above, here))
        quartered = fine.mesh.levels[touching(fine.mesh.leaves, around)].min() - coarse.mesh.levels[here].max()
        if quartered < RINGS:
            known = before.at(point, extent)
            left[number] = UNKNOWN if known is None else known
            continue
        rings = _rings(coarse.mesh, fine.mesh, above, inside, around)
        sums = [[np.bincount(rings, part[inside]) for part in pair] for pair in pairs]
        left[number] = max(left_by(answer, weight, quartered - 1) for answer, weight in sums)
    return Halvings(points, left)


def _rings(
    coarse: MeshQuadTree, fine: MeshQuadTree, above: np.ndarray, inside: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Number of the ring about points (2, n) in which elements of the refined mesh lie, by the sizes of their ancestors:
    0 beyond half of it, 1 beyond a quarter."""
    centres = fine.p[:, fine.t[:, inside]].mean(axis=1)
    sizes = np.ptp(coarse.p[:, coarse.t[:, above[inside]]], axis=1)
    nearest = np.full(len(inside), np.inf)
    for point in points.T:
        nearest = np.minimum(nearest, np.abs((centres - point[:, None]) / sizes).max(axis=0))
    return np.maximum(np.floor(-np.log2(nearest)).astype(int), 0)


def left_by(of_answer: np.ndarray, of_weight: np.ndarray, last: int) -> float:
    """What a halving leaves, by the energies (n,) in rings from the outermost to the ``last``, the third one at least.

    Examples
    --------
    >>> left_by(0.5 ** np.arange(5), 0.5 ** np.arange(5), last=4)
    0.5
    """
    products = of_answer[last - 2 : last + 1] * of_weight[last - 2 : last + 1]
    if not (products > 0).all():
        return LEAST
    ratios = np.sqrt(products[1:] / products[:-1])
    # Energies that grow inwards are those of a part of the answer which the rings outside do not have yet.
    return float(np.clip(ratios.min() if ratios.max() < 1 else ratios.max(), LEAST, MOST))
