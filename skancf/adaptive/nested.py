"""The error of a number from what it did on meshes of which each has every element of the last one quartered."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.adaptive.analysis import Answer
from skancf.adaptive.estimate import Estimate
from skancf.adaptive.interpolation import ancestors_in
from skancf.adaptive.rings import UNKNOWN
from skancf.adaptive.singular import images, singular_points
from skancf.meshes import MeshQuadTree
from skancf.showing import short
from skancf.theories import left_per_halving

SLOWER, FASTER = 0.85, 1.5
"""Parts of the factor by which differences fall at the full order, between which they are trusted."""
AGREES = 0.2
"""Part of the last estimate by which the new value may have missed what it foretold."""

MARGIN = 0.1
"""Part of an error that is added to its bar: three meshes say less than a dual weight."""


@dataclass
class Nested:
    r"""Values on the last meshes of a run, as long as each has every element of the one before quartered.

    With the differences :math:`d_k = J_k - J_{k-1}` of three such meshes, their ratio :math:`r = d_{k-1} / d_k` and that of
    the full order, R = 16 in theory `kirchhoff` and 4 in `full`, an error :math:`a + b`, of which quartering leaves
    :math:`a / R` and, of what singular points make, at most :math:`b / 2`, is

    .. math::
        a = \frac{(r - 2)\, d_k}{(R - 1)(R - 2)}, \qquad b = \frac{(R - r)\, d_k}{R - 2}.

    At the full order, r = R, this is Richardson's :math:`d_k / (R - 1)`, and no less than that is taken for one that seems
    higher. It is trusted where no singular point leaves more than a half, r is near R, and the estimate on the mesh before
    foretold the new value; where it is not, the dual weight has to say.

    Attributes
    ----------
    quantity : Quantity
    values : list of float
    mesh : MeshQuadTree or None
        The last one.
    estimate : Estimate or None
        On that one.
    """

    quantity: Any = None
    values: list[float] = field(default_factory=list)
    mesh: MeshQuadTree | None = None
    estimate: Estimate | None = None

    __repr__ = short

    def error(self, answer: Answer) -> Estimate | None:
        """The estimate of an answer on the next mesh; None where three meshes do not tell it."""
        system, before = answer.state.system, self.estimate
        if before is None or len(self.values) < 2 or not self._quartered(system.mesh):
            return None
        if (before.halvings.left > UNKNOWN).any():
            return None
        left = left_per_halving(system.geometry.theory)
        last, error = answer.value - self.values[-1], extrapolated(self.values[-2], self.values[-1], answer.value, 1 / left)
        if error is None or not abs(last + error - before.error) <= AGREES * abs(before.error):
            return None
        foretold = before.error - last
        if not before.nested and foretold * error > 0 and abs(foretold) > abs(error):
            error = foretold
        return Estimate(
            answer.value, error, self._shares(answer, before, left), answer.state, 0.0, MARGIN * abs(error),
            before.rounding / left, before.scale, before.halvings, nested=True,
        )  # fmt: skip

    def _shares(self, answer: Answer, before: Estimate, left: float) -> np.ndarray:
        """What is left of the indicators of the mesh before, at singular points all in one of the quarters."""
        system = answer.state.system
        leaves = system.mesh.leaves
        assert self.mesh is not None
        out = before.indicators[ancestors_in(self.mesh.leaves, leaves)]
        there, once = before.halvings.of(leaves, images(system.geometry, leaves, singular_points(system, self.quantity)))
        left_there = out[there] * once
        out *= left / 4
        out[there] = left_there
        return out

    def add(self, mesh: MeshQuadTree, estimate: Estimate) -> None:
        """A finished mesh."""
        kept = self.values[-1:] if self._quartered(mesh) else []
        self.values, self.mesh, self.estimate = [*kept, estimate.value], mesh, estimate

    def _quartered(self, mesh: MeshQuadTree) -> bool:
        """Is a mesh the last one with every element quartered?"""
        if self.mesh is None or mesh.nelements != 4 * self.mesh.nelements:
            return False
        above = ancestors_in(self.mesh.leaves, mesh.leaves)
        return bool((above >= 0).all() and (mesh.leaves.cells.level == self.mesh.leaves.cells.level[above] + 1).all())


def extrapolated(first: float, second: float, third: float, order: float) -> float | None:
    """Limit minus the third value, of meshes each twice as fine as the last, whose differences fall by the factor ``order``
    where nothing is singular; None where they do not fall so."""
    last, ratio = third - second, np.inf if third == second else (second - first) / (third - second)
    if not SLOWER * order <= ratio <= FASTER * order:
        return None
    smooth, singular = (ratio - 2) / ((order - 1) * (order - 2)), (order - ratio) / (order - 2)
    return float(last * max(smooth + singular, 1 / (order - 1)))
