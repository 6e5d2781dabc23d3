"""From indicators to the next mesh."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.adaptive.blunt import NOWHERE, Blunt
from skancf.adaptive.interpolation import ancestors_in
from skancf.adaptive.marking import Doerfler, Marking, Never
from skancf.adaptive.rings import NOTHING_KNOWN, Halvings
from skancf.adaptive.singular import images
from skancf.errors import InputError, shown
from skancf.functions import called
from skancf.layout.geometry import Geometry
from skancf.materials import Section
from skancf.meshes import MeshQuadTree
from skancf.meshes.forest import Leaves
from skancf.surfaces import Surface
from skancf.system.system import System
from skancf.theories import left_per_halving
from skancf.tolerances import SAME_POINT

AGAIN, AT_MOST = 3, 8
"""Largest number of times that an element is quartered from one mesh to the next; at singular points until no more than
:data:`ENOUGH` of its error is left."""
ENOUGH = 1 / 16
SMALLEST, SMALLEST_LARGE = 2.0**-18, 2.0**-14
"""Size of the smallest elements, of the extent of the surface: of small-deflection answers, and of others, whose strains are
rounded as the squares of positions are. Rounding grows with the inverse square of the size. The refined mesh of an estimate
has elements two levels smaller; levels end at 2^-20."""
POLE = 2.0**-9
"""The same at a pole, where the integration points of an element see a fourteenth of its width."""
DOERFLER, NEVER = Doerfler(0.9), Never()


def may_be_quartered(leaves: Leaves, surface: Surface, smallest: float = SMALLEST, blunt: Blunt = NOWHERE) -> np.ndarray:
    """Which elements are larger than the smallest size in both directions of the surface, (n_elements,); about blunt points
    than that of each."""
    corners = surface.position(*leaves.forest.places(leaves.cells))
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=0)
    extent = np.linalg.norm(np.ptp(surface.position(*leaves.forest.points), axis=1))
    # At a pole one side has no length.
    lengths, at_pole = np.maximum(sides[:2], sides[2:]).min(axis=0), sides.min(axis=0) < SAME_POINT * extent
    least = np.where(at_pole, max(smallest, POLE), smallest) * extent
    return np.asarray(lengths > 1.5 * np.maximum(least, blunt.smallest(corners)))


def may_be_merged(system: System) -> np.ndarray:
    """Elements of a quadtree whose sisters are in their zone, (n_elements,) bool: others would cross its border."""
    section = system.assembly.section
    if isinstance(section, Section):
        return np.ones(system.geometry.n_elements, dtype=bool)
    parents, family = np.unique(system.mesh.leaves.cells.parents.keys, return_inverse=True)
    low, high = np.full(len(parents), len(section.zones)), np.full(len(parents), -1)
    np.minimum.at(low, family, section.zones)
    np.maximum.at(high, family, section.zones)
    return np.asarray((low == high)[family])


def _numbers(name: str, marked: Any, n: int) -> np.ndarray:
    """Numbers of elements that a policy of the user's own gave, ascending; a mask of all n elements counts too."""
    try:
        found = np.atleast_1d(np.asarray(marked))
    except ValueError:
        found = np.array(None)
    if found.dtype == bool and found.shape == (n,):
        return np.flatnonzero(found)
    if found.ndim == 1 and not found.size:
        return np.empty(0, dtype=int)
    if found.ndim != 1 or found.dtype.kind not in "iu" or found.min() < 0 or found.max() >= n:
        raise InputError(f"{name}.marked gives {shown(marked)}: give an array of numbers of elements, from 0 to {n - 1}")
    return np.unique(found).astype(int)


@dataclass(frozen=True)
class Growth:
    """Which elements are quartered and which are merged.

    Parameters
    ----------
    refine : Marking
    coarsen : Marking
    smallest : float
        Size of the smallest elements, of the extent of the surface.
    blunt : Blunt
        Points about which they are larger.
    """

    refine: Marking = DOERFLER
    coarsen: Marking = NEVER
    smallest: float = SMALLEST
    blunt: Blunt = NOWHERE

    def next_mesh(
        self, system: System, indicators: np.ndarray, points: np.ndarray, halvings: Halvings = NOTHING_KNOWN
    ) -> MeshQuadTree:
        """Quarters marked elements, and those of their quarters that would be marked again; merges others of one zone.

        ``points`` (2, n) are the singular ones, ``halvings`` what one halving leaves there.
        """
        geometry, mesh = system.geometry, system.mesh
        leaves = mesh.leaves
        room = self.room(leaves, geometry.surface)
        marked = _numbers("marking", called("marking", self.refine.marked, np.where(room, indicators, 0.0)), len(leaves))
        marked = marked[room[marked]]
        finer = leaves.refined(marked)
        if 0 < marked.size < len(leaves):
            finer = self._again(geometry, finer, indicators, float(indicators[marked].min()), points, halvings)
        merged = _numbers("coarsening", called("coarsening", self.coarsen.marked, indicators), len(leaves))
        small = finer.find(leaves.cells.take(merged[may_be_merged(system)[merged]]))
        return mesh.regrown(finer).coarsened(small[small >= 0])

    def room(self, leaves: Leaves, surface: Surface) -> np.ndarray:
        """Which elements may be quartered, (n_elements,)."""
        return may_be_quartered(leaves, surface, self.smallest, self.blunt)

    def _again(
        self, geometry: Geometry, finer: Leaves, indicators: np.ndarray, least: float, points: np.ndarray, halvings: Halvings
    ) -> Leaves:  # fmt: skip
        """With quarters quartered again whose indicators will exceed the smallest of the marked ones twice.

        Of an indicator each quarter has a quarter of what is left; at a singular point one of them has all that the halving
        leaves.
        """
        leaves, smooth = geometry.mesh.leaves, left_per_halving(geometry.theory)
        for depth in range(1, AT_MOST):
            above = ancestors_in(leaves, finer)
            quartered = finer.cells.level - leaves.cells.level[above]
            left = np.where(quartered > 0, indicators[above] * (smooth / 4) ** quartered, 0.0)
            singular, halved = halvings.of(finer, images(geometry, finer, points))
            left[singular] = indicators[above[singular]] * halved ** quartered[singular]
            more = np.full(len(finer), depth < AGAIN)
            more[singular] |= halved**depth > ENOUGH
            more &= (left > 2 * least) & (quartered == depth) & self.room(finer, geometry.surface)
            again = np.flatnonzero(more)
            if not again.size:
                break
            finer = finer.refined(again)
        return finer
