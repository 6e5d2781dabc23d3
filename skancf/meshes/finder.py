"""The elements that hold given points."""

from collections.abc import Callable
from typing import Any

import numpy as np
import skfem

from skancf.tolerances import ROUNDED_PLACE

Finder = Callable[[np.ndarray, np.ndarray], np.ndarray]
# Pairs of a point and an element that are looked at together.
AT_ONCE = 1 << 22


def element_finder(mesh: Any) -> Finder:
    """A function of x and y, (n,) each, that gives the elements; ValueError where a point is in none.

    The mesh's own where it has one. That of scikit-fem makes triangles, with all named boundaries, of the quads first, which
    takes longer than to solve a small problem.
    """
    if type(mesh).element_finder is not skfem.MeshQuad.element_finder:
        return mesh.element_finder()
    corners = mesh.p[:, mesh.t]
    ahead = np.roll(corners, -1, axis=1) - corners
    size = np.abs(ahead).max(axis=(0, 1))
    side = np.sign(ahead[0, 0] * ahead[1, 1] - ahead[1, 0] * ahead[0, 1])
    low, high = corners.min(axis=1) - ROUNDED_PLACE * size, corners.max(axis=1) + ROUNDED_PLACE * size

    def holding(points: np.ndarray) -> np.ndarray:
        """The first element that holds each point (2, n), -1 for none."""
        boxed = ((points[:, :, None] >= low[:, None]) & (points[:, :, None] <= high[:, None])).all(axis=0)
        point, element = np.nonzero(boxed)
        away = points[:, None, point] - corners[:, :, element]
        along = ahead[:, :, element]
        # Twice the area of the triangle on each edge, on the side of the element; its height is that over the edge.
        area = (along[0] * away[1] - along[1] * away[0]) * side[element]
        inside = (area >= -ROUNDED_PLACE * size[element] ** 2).all(axis=0)
        out = np.full(points.shape[1], -1)
        out[point[inside][::-1]] = element[inside][::-1]
        return out

    def finder(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        points, step = np.stack([x, y]), max(1, AT_ONCE // mesh.t.shape[1])
        parts = [holding(points[:, k : k + step]) for k in range(0, points.shape[1], step)]
        found = np.concatenate([np.empty(0, dtype=int), *parts])
        if (found < 0).any():
            raise ValueError("Point is outside of the mesh.")
        return found

    return finder
