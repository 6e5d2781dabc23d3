"""Quadtrees that grow from the rectangles of a coarse mesh: cells by integer coordinates, and who lies beside whom.

A cell of level l is a square number (x, y), 0 <= x, y < 2^l, of its root, the coarse rectangle. Equal points have equal
integers, so that nothing here depends on rounding.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skancf.showing import short

DEEPEST = 20
"""Largest level; one corner of a square metre is refined down to a micrometre."""
POINT = DEEPEST + 1
# Sides of a cell as scikit-fem numbers them, and the step across each.
STEPS = ((0, -1), (1, 0), (0, 1), (-1, 0))
BOTTOM, RIGHT, TOP, LEFT = range(4)
AROUND = tuple((dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if (dx, dy) != (0, 0))
CORNER_X, CORNER_Y = np.array([0, 1, 1, 0]), np.array([0, 0, 1, 1])


class Cells(NamedTuple):
    """Cells of a forest, arrays (n,) each. A root of -1 is no cell."""

    root: np.ndarray
    level: np.ndarray
    x: np.ndarray
    y: np.ndarray

    def __repr__(self) -> str:
        return short(self)

    def take(self, index: np.ndarray) -> "Cells":
        return Cells(*(part[index] for part in self))

    def join(self, other: "Cells") -> "Cells":
        return Cells(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))

    @property
    def parents(self) -> "Cells":
        """Cells of level 0 are no children; their parent is no cell."""
        return Cells(np.where(self.level > 0, self.root, -1), self.level - 1, self.x >> 1, self.y >> 1)

    @property
    def children(self) -> "Cells":
        """Four for each cell, one after the other, in the order of corners."""
        root, level = np.repeat(self.root, 4), np.repeat(self.level + 1, 4)
        dx, dy = np.tile(CORNER_X, len(self.root)), np.tile(CORNER_Y, len(self.root))
        return Cells(root, level, 2 * np.repeat(self.x, 4) + dx, 2 * np.repeat(self.y, 4) + dy)

    @property
    def corner(self) -> np.ndarray:
        """Which corner of its parent each cell has, as (0 or 1, 0 or 1): (2, n)."""
        return np.stack([self.x & 1, self.y & 1])

    @property
    def keys(self) -> np.ndarray:
        """One integer each, (n,), -1 for no cell."""
        key = ((self.root << 5 | self.level) << 2 * DEEPEST) | self.y << DEEPEST | self.x
        return np.where((self.root < 0) | (self.level < 0), -1, key)


@dataclass(frozen=True)
class Forest:
    """The coarse mesh of aligned rectangles.

    Parameters
    ----------
    points : (2, n_vertices) array
    corners : (4, n_roots) int array
        Counter-clockwise, the lower left one first.
    facets : (4, n_roots) int array
        Numbers of the sides bottom, right, top, left.
    neighbours : (4, n_roots + 1) int array
        The root across each side, across closed seams too; -1 for none. The last column is that of no root.
    closed : (bool, bool)
        Directions whose two ends are one.
    """

    points: np.ndarray
    corners: np.ndarray
    facets: np.ndarray
    neighbours: np.ndarray
    closed: tuple[bool, bool] = (False, False)

    __repr__ = short

    @property
    def n_roots(self) -> int:
        return self.corners.shape[1]

    @property
    def roots(self) -> Cells:
        zero = np.zeros(self.n_roots, dtype=np.int64)
        return Cells(np.arange(self.n_roots), zero, zero, zero)

    def beside(self, cells: Cells, dx: int, dy: int) -> Cells:
        """The cell of the same level one step away, diagonally too; around a corner by whichever side leads there."""
        if dx and dy:
            first = self._step(self._step(cells, 0, dx), 1, dy)
            other = self._step(self._step(cells, 1, dy), 0, dx)
            lost = first.root < 0
            return Cells(*(np.where(lost, b, a) for a, b in zip(first, other, strict=True)))
        return self._step(cells, 0, dx) if dx else self._step(cells, 1, dy)

    def _step(self, cells: Cells, axis: int, by: int) -> Cells:
        at, size = (cells.y if axis else cells.x) + by, np.int64(1) << np.maximum(cells.level, 0)
        out = (at < 0) | (at >= size)
        side = ((LEFT, RIGHT), (BOTTOM, TOP))[axis][by > 0]
        root = np.where(out, self.neighbours[side, cells.root], cells.root)
        at = at & (size - 1)
        return Cells(root, cells.level, *((cells.x, at) if axis else (at, cells.y)))

    def point_keys(self, cells: Cells) -> np.ndarray:
        """One integer for each corner, the same for the same point: (4, n). Those of the coarse vertices are their numbers.

        Points of a seam are two, as in the parameter plane.
        """
        shift = DEEPEST - cells.level
        X = (cells.x + CORNER_X[:, None]) << shift
        Y = (cells.y + CORNER_Y[:, None]) << shift
        whole, root = np.int64(1) << DEEPEST, np.broadcast_to(cells.root, X.shape)
        keys = (np.int64(1) << 62) | root << 2 * POINT | Y << POINT | X
        for side, at, end, along in ((BOTTOM, Y, 0, X), (RIGHT, X, whole, Y), (TOP, Y, whole, X), (LEFT, X, 0, Y)):
            on = at == end
            keys[on] = (np.int64(1) << 61) | self.facets[side, root[on]].astype(np.int64) << POINT | along[on]
        for corner in range(4):
            on = (whole * CORNER_X[corner] == X) & (whole * CORNER_Y[corner] == Y)
            keys[on] = self.corners[corner, root[on]]
        return keys

    def places(self, cells: Cells) -> np.ndarray:
        """Corners in the parameter plane, (2, 4, n)."""
        size = np.ldexp(1.0, -cells.level)
        low, high = self.points[:, self.corners[0, cells.root]], self.points[:, self.corners[2, cells.root]]
        s = np.stack([(cells.x + CORNER_X[:, None]) * size, (cells.y + CORNER_Y[:, None]) * size])
        # Exact at both ends.
        return np.asarray(low[:, None] * (1 - s) + high[:, None] * s)

    def covering(self, leaves: "Leaves", root: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The leaf that holds each place x, y in [0, 1] of a root, (n,); of several the one towards the upper right."""
        out = np.full(len(root), -1)
        for level in np.unique(leaves.cells.level):
            size = np.int64(1) << level
            at = (np.minimum((s * size).astype(np.int64), size - 1) for s in (x, y))
            found = leaves.find(Cells(root, np.full(len(root), level), *at))
            out = np.where(found >= 0, found, out)
        return out


class Leaves:
    """The cells of a mesh, in the order of their keys, 2:1 balanced over edges and corners."""

    def __init__(self, forest: Forest, cells: Cells):
        keys = cells.keys
        order = np.argsort(keys)
        self.forest, self.cells, self.keys = forest, cells.take(order), keys[order]

    def __len__(self) -> int:
        return len(self.keys)

    @property
    def boxes(self) -> np.ndarray:
        """Lower left and upper right corners in the parameter plane, (2, 2, n): corner, coordinate."""
        return self.forest.places(self.cells)[:, [0, 2]].swapaxes(0, 1)

    @property
    def extent(self) -> np.ndarray:
        """Of the forest in both directions of the parameter plane, (2,)."""
        return np.asarray(np.ptp(self.forest.points, axis=1))

    def find(self, cells: Cells) -> np.ndarray:
        """Number of each of these cells, (n,); -1 where it is no leaf."""
        wanted = cells.keys
        at = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.where(self.keys[at] == wanted, at, -1)

    def closure(self, marked: np.ndarray) -> np.ndarray:
        """Leaves (m,) to split so that these are split and the mesh stays balanced."""
        split = np.zeros(len(self), dtype=bool)
        front = np.unique(marked)
        split[front] = True
        while front.size:
            cells = self.cells.take(front)
            found = np.concatenate([self.find(self.forest.beside(cells, *step).parents) for step in AROUND])
            front = np.unique(found[found >= 0])
            front = front[~split[front]]
            split[front] = True
        return np.flatnonzero(split)

    def refined(self, marked: np.ndarray) -> "Leaves":
        """With these leaves split, and others as far as balance needs it."""
        which = self.closure(marked)
        return self.split(which) if which.size else self

    def split(self, which: np.ndarray) -> "Leaves":
        """With the children of some leaves instead of these."""
        kept = np.ones(len(self), dtype=bool)
        kept[which] = False
        return Leaves(self.forest, self.cells.take(np.flatnonzero(kept)).join(self.cells.take(which).children))

    def families(self, marked: np.ndarray) -> np.ndarray:
        """Sets of four marked sisters, in the order of corners, that may be merged: (4, m).

        The mesh stays balanced: no leaf beside a sister is smaller than she, or it belongs to a set that is merged too.
        """
        merging = np.zeros(len(self), dtype=bool)
        sisters = np.empty((4, 0), dtype=int)
        cells = self.cells.take(np.unique(marked))
        first = cells.take(np.flatnonzero((cells.corner == 0).all(axis=0) & (cells.level > 0)))
        found = self.find(first.parents.children).reshape(-1, 4).T
        is_marked = np.zeros(len(self) + 1, dtype=bool)
        is_marked[marked] = True
        found = found[:, (found >= 0).all(axis=0) & is_marked[found].all(axis=0)]
        levels = self.cells.level[found[0]]
        for level in np.unique(levels)[::-1]:  # the smallest first, they may make room for larger ones
            here = found[:, levels == level]
            here = here[:, ~self._has_smaller(here, merging)]
            merging[here] = True
            sisters = np.hstack([sisters, here])
        return sisters

    def _has_smaller(self, sisters: np.ndarray, merging: np.ndarray) -> np.ndarray:
        """Is there a leaf beside the four that is smaller than they, and is not merged? (m,)"""
        cells, blocked = self.cells.take(sisters.ravel()), np.zeros(sisters.size, dtype=bool)
        for dx, dy in AROUND:
            beside = self.forest.beside(cells, dx, dy)
            touching = Cells(beside.root, beside.level + 1, 2 * beside.x + (dx < 0), 2 * beside.y + (dy < 0))
            found = self.find(touching)
            blocked |= (found >= 0) & ~merging[found]
        return np.asarray(blocked.reshape(sisters.shape).any(axis=0))

    def merged(self, sisters: np.ndarray) -> "Leaves":
        """With the parents of sets of sisters (4, m) instead of these."""
        kept = np.ones(len(self), dtype=bool)
        kept[sisters] = False
        return Leaves(self.forest, self.cells.take(np.flatnonzero(kept)).join(self.cells.take(sisters[0]).parents))

    def larger_beside(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Leaves whose side is half of a larger leaf's: their numbers, sides, the hanging corner, and the larger leaf.

        The hanging corner is the middle of the larger leaf's side; its far end is the corner of the same number of the
        parent.
        """
        parts = []
        corner_x, corner_y = self.cells.corner
        for side, (dx, dy) in enumerate(STEPS):
            outer = (corner_x == (dx > 0)) if dx else (corner_y == (dy > 0))
            small = np.flatnonzero(outer & (self.cells.level > 0))
            large = self.find(self.forest.beside(self.cells.take(small), dx, dy).parents)
            small, large = small[large >= 0], large[large >= 0]
            x, y = corner_x[small], corner_y[small]
            hanging = CORNER_NUMBER[(x, 1 - y) if dx else (1 - x, y)]
            parts.append((small, np.full(len(small), side), hanging, large))
        joined = (np.concatenate(part) for part in zip(*parts, strict=True))
        return tuple(joined)  # type: ignore[return-value]


CORNER_NUMBER = np.array([[0, 3], [1, 2]])
"""Number of the corner (0 or 1, 0 or 1)."""
