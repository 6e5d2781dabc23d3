"""The elements that meet at places of the parameter plane."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from skancf.errors import InputError
from skancf.layout.geometry import Geometry
from skancf.tolerances import ABOUT_A_PLACE

DIAGONALS = np.array([[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0]])
TOGETHER, DIGITS = 16, 12
"""Pairs of a point and an element that are evaluated together; digits to which local points are the same."""
SHOWN = 3
"""Places that a message names."""


class Around(NamedTuple):
    """Pairs of a place and an element that holds it: several for a place on an edge of the mesh.

    Attributes
    ----------
    places : (m,) int array
        Number of the place, ascending.
    elements : (m,) int array
    local : (m, 2) array
        Where the place is in the element's reference square.
    """

    places: np.ndarray
    elements: np.ndarray
    local: np.ndarray

    def means(self, values: np.ndarray, n: int) -> np.ndarray:
        """Means (n, ...) over the elements at each place of values (m, ...) of the pairs."""
        out = np.zeros((n, *values.shape[1:]), values.dtype)
        np.add.at(out, self.places, values)
        return np.asarray((out.T / np.bincount(self.places, minlength=n)).T)


def at_pairs(elements: np.ndarray, local: np.ndarray, value: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """Values (m, ...) at local points (m, 2) of elements (m,), by a function of points (2, k) and elements (l,) that gives
    those of all points in all elements, (l, k, ...).

    Pairs with the same local point are evaluated together; where there are few such, some elements at the points of all.
    """
    points, group = np.unique(np.round(local, DIGITS), axis=0, return_inverse=True)
    if len(points) * TOGETHER <= len(elements):
        parts = np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1])
        found = [value(point[:, None], elements[pairs])[:, 0] for point, pairs in zip(points, parts, strict=True)]
    else:
        order = np.argsort(elements, kind="stable")
        parts, found = [order[k : k + TOGETHER] for k in range(0, len(order), TOGETHER)], []
        for pairs in parts:
            some, at = np.unique(elements[pairs], return_inverse=True)
            found.append(value(local[pairs].T, some)[at, np.arange(len(pairs))])
    values = np.concatenate(found)
    out = np.empty_like(values)
    out[np.concatenate(parts)] = values
    return out


def require_inside(geometry: Geometry, points: np.ndarray, name: str = "points") -> None:
    """InputError that names the points (2, n) that the surface does not hold."""
    inside = geometry.locate_inside(points)[0]
    if inside.all():
        return
    wrong = points[:, ~inside].T
    named = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in wrong[:SHOWN])
    more = f" and {len(wrong) - SHOWN} more" if len(wrong) > SHOWN else ""
    low, high = geometry.mesh.p.min(axis=1), geometry.mesh.p.max(axis=1)
    holes = ", openings left out" if len(geometry.openings) else ""
    raise InputError(
        f"{name}: {len(wrong)} of {points.shape[1]} lie outside the surface: {named}{more}; in the parameter plane it "
        f"reaches from ({low[0]:.6g}, {low[1]:.6g}) to ({high[0]:.6g}, {high[1]:.6g}){holes}"
    )


def elements_around(geometry: Geometry, points: np.ndarray, side: np.ndarray | None = None) -> Around:
    """The elements at points (2, n): all that share an edge or corner there, or only those in the direction ``side`` (2,).

    Raises
    ------
    InputError
        For points outside the surface, and where there is no element on that side.
    """
    require_inside(geometry, points)
    first = geometry.locate_all(points)[0]
    size = np.ptp(geometry.mesh.p[:, geometry.mesh.t[:, first]], axis=1)
    ways = DIAGONALS if side is None else (side / np.abs(side).max())[:, None]
    away = (ABOUT_A_PLACE * ways[:, None] * size[:, :, None]).reshape(2, -1)
    moved = np.repeat(points, ways.shape[1], axis=1) + away
    place = np.repeat(np.arange(points.shape[1]), ways.shape[1])
    # Most places off the surface are beyond its bounds; to look for them by themselves takes long.
    bounds = geometry.mesh.p.min(axis=1), geometry.mesh.p.max(axis=1)
    near = ((bounds[0] <= geometry.within(moved).T) & (bounds[1] >= geometry.within(moved).T)).all(axis=1)
    place, moved, away = place[near], moved[:, near], away[:, near]
    inside, elements, _ = geometry.locate_inside(moved)
    place = place[inside]
    lost = np.setdiff1d(np.arange(points.shape[1]), place)
    if side is not None and lost.size:
        x, y = points[:, lost[0]]
        raise InputError(f"side = {tuple(side.tolist())}: there is no element on that side of ({x:.6g}, {y:.6g})")
    # Across a seam the place itself is at the other end of the parameter.
    back = geometry.within(moved[:, inside]) - away[:, inside]
    if lost.size:
        place, elements = np.append(place, lost), np.append(elements, first[lost])
        back = np.hstack([back, geometry.within(points[:, lost])])
    pairs, kept = np.unique(np.stack([place, elements]), axis=1, return_index=True)
    local = geometry.local_in(pairs[1], back[:, kept, None])[:, :, 0]
    return Around(pairs[0], pairs[1], local)
