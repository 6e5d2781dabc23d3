"""Two edges that lie on each other: chains of facets, the arc length along them, and the points at which both are met."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.elements.quad_ancf import gauss
from skancf.errors import InputError, shown
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.tolerances import ONE_PLACE, ROOT

APART = 1e-2
"""Of the length of an edge: two edges that are farther apart do not meet; nearer ones are closed, see
:mod:`skancf.conditions.closing`."""
INVERSIONS = 20
"""Newton iterations for the place in a facet that has a given arc length."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Boundary facets one after another, the same way on every mesh: from the end with the smaller x, or y where both have
    one x. A closed one begins at its smallest place, and goes to the neighbour with the smaller one.

    Attributes
    ----------
    geometry : Geometry
    facets : (m,) int array
    ends : (m, 2) int array
        Mesh nodes at which each begins and ends.
    closed : bool
        Whether it ends where it began.
    """

    geometry: Geometry
    facets: np.ndarray
    ends: np.ndarray
    closed: bool

    __repr__ = short

    @classmethod
    def of(cls, geometry: Geometry, where: Any) -> "Chain":
        """That of a place.

        Raises
        ------
        InputError
            For a place that is no single run of edges.
        """
        facets = geometry.facets_on(where)
        pairs = geometry.mesh.facets[:, facets].T
        at: dict[int, list[int]] = {}
        nodes, places = geometry.ties.node_of[pairs], geometry.mesh.p[:, pairs]
        for k in _in_order(places.mean(axis=2)):
            for node in nodes[k]:
                at.setdefault(int(node), []).append(int(k))
        tips = [node for node, those in at.items() if len(those) == 1]
        by_place = nodes.ravel()[_in_order(places.reshape(2, -1))].tolist()
        order, node = [], next(node for node in by_place if node in tips or not tips)
        left = set(range(len(facets)))
        while here := [k for k in at[node] if k in left]:
            k = here[0]
            left.remove(k)
            begin = 0 if nodes[k, 0] == node else 1
            order.append((k, begin))
            node = int(nodes[k, 1 - begin])
        if left or len(tips) not in (0, 2):
            raise InputError(f"where = {shown(where)}: its {len(facets)} edges are no single line; name one edge of the "
                             "boundary that runs from one end to the other")  # fmt: skip
        which, first = (np.array(each) for each in zip(*order, strict=True))
        ends = np.stack([pairs[which, first], pairs[which, 1 - first]], axis=1)
        return cls(geometry, facets[which], ends, not tips)

    def reversed(self) -> "Chain":
        """The same from its end."""
        return Chain(self.geometry, self.facets[::-1], self.ends[::-1, ::-1], self.closed)

    def beginning_at(self, k: int) -> "Chain":
        """A closed one that begins with its facet k."""
        order = np.roll(np.arange(len(self.facets)), -k)
        return Chain(self.geometry, self.facets[order], self.ends[order], self.closed)

    @cached_property
    def knots(self) -> np.ndarray:
        """Undeformed arc length at the ends of its facets, (m + 1,) (m)."""
        return np.concatenate([[0.0], np.cumsum(self._length(np.arange(len(self.facets)), np.ones(len(self.facets))))])

    @property
    def tips(self) -> np.ndarray:
        """Undeformed places of its two ends, (2, 3)."""
        return self.places(np.array([0, len(self.facets) - 1]), np.array([0.0, 1.0]))

    def at(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Facets (n,), by their place in the chain, and the part (n,) of each from its begin at arc lengths (n,)."""
        which = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.facets) - 1)
        wanted, whole = s - self.knots[which], np.diff(self.knots)[which]
        t = wanted / whole
        for _ in range(INVERSIONS):
            step = (wanted - self._length(which, t)) / self._speed(which, t[:, None])[:, 0]
            t = np.clip(t + step, 0.0, 1.0)
            if np.abs(step).max(initial=0.0) < ROOT:
                break
        return which, t

    def parameters(self, which: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points (2, n) of the parameter plane at parts t of facets."""
        ends = self.geometry.mesh.p[:, self.ends[which]]
        return np.asarray(ends[:, :, 0] + t * (ends[:, :, 1] - ends[:, :, 0]))

    def places(self, which: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Undeformed places (n, 3) there."""
        return np.asarray(self.geometry.surface.position(*self.parameters(which, t)).T)

    def local(self, which: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Elements (n,) and local coordinates (n, 2) there."""
        elements = self.geometry.mesh.f2t[0, self.facets[which]]
        return elements, self.geometry.local_in(elements, self.parameters(which, t)[:, :, None])[:, :, 0]

    def _speed(self, which: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Arc length per part at parts (n, k) of facets (n,)."""
        ends = self.geometry.mesh.p[:, self.ends[which]]
        way = ends[:, :, 1] - ends[:, :, 0]
        slopes = np.stack(self.geometry.surface.derivatives(*(ends[:, :, 0, None] + t * way[:, :, None])))
        return np.asarray(np.linalg.norm(np.einsum("dn,dink->ink", way, slopes), axis=0))

    def _length(self, which: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Arc length (n,) from the begin of facets to parts (n,) of them."""
        points, weights = gauss(8)
        return np.asarray(self._speed(which, t[:, None] * points) @ weights * t)


def _in_order(places: np.ndarray) -> np.ndarray:
    """Numbers (n,) of places (2, n) of the parameter plane by their x, and by y where it is one, up to rounding."""
    steps = np.round(places / (ONE_PLACE * np.abs(places).max()))
    return np.asarray(np.lexsort(steps[::-1]))


def side_by_side(first: Chain, second: Chain, names: tuple[str, str]) -> tuple[Chain, float]:
    """The second chain in the direction of the first, and beginning where that one begins; and by how much they miss each
    other at most (m).

    Raises
    ------
    InputError
        Where the two do not lie on each other, with the distance.
    """
    size = max(float(first.knots[-1]), ONE_PLACE)
    if first.closed != second.closed:
        raise InputError(f"{names[0]} and {names[1]}: one is closed and the other has two ends; name two edges that meet")
    if first.closed:
        begin = first.tips[0]
        starts = second.places(np.arange(len(second.facets)), np.zeros(len(second.facets)))
        second = second.beginning_at(int(np.argmin(np.linalg.norm(starts - begin, axis=1))))
    ways = [second, second.reversed()]
    probes = np.linspace(0.0, 1.0, 5)
    places = first.places(*first.at(probes * first.knots[-1]))
    apart = [np.linalg.norm(way.places(*way.at(probes * way.knots[-1])) - places, axis=1).max() for way in ways]
    nearest = ways[int(np.argmin(apart))]
    far = float(min(apart))
    if far > APART * size:
        raise InputError(f"{names[0]} and {names[1]} do not meet: undeformed they are up to {far:.4g} m apart, at edges "
                         f"{size:.4g} m long. Name two edges that lie on each other, or bend the surface so that they do; a "
                         "RigidLink keeps two points apart")  # fmt: skip
    return nearest, far


def segments(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of segments, and all knots of both, of two partitions of one length.

    A segment ends at a knot of either, and is at least as long as the longest interval of either that it meets: on it the
    gap has as many freedoms as conditions, or more.
    """
    length = float(first[-1])
    every = np.unique(np.concatenate([first, second * (length / second[-1])]))
    kept = np.concatenate([[True], np.diff(every) > ONE_PLACE * length])
    every = every[kept]
    every[-1] = length

    def longest(a: float, b: float) -> float:
        most = 0.0
        for knots in (first, second * (length / second[-1])):
            slack = ONE_PLACE * length
            low = int(np.searchsorted(knots, a + slack, side="right")) - 1
            high = int(np.searchsorted(knots, b - slack, side="left"))
            most = max(most, float(np.diff(knots[low : high + 1]).max()))
        return most

    ends = [0.0]
    for knot in every[1:]:
        if knot - ends[-1] >= longest(ends[-1], knot) - ONE_PLACE * length:
            ends.append(float(knot))
    if ends[-1] != every[-1]:
        ends[-1] = float(every[-1])
    return np.array(ends), every
