"""Where the loop begins."""

from typing import Any

import numpy as np
import skfem

from skancf.materials.zones import lines_of
from skancf.meshes import tensor
from skancf.meshes.counts import stretch
from skancf.meshes.lines import row_through
from skancf.meshes.tensor import bounds_of
from skancf.problem import Problem
from skancf.surfaces import closed_bounds

ELEMENTS = 16
AROUND = 8
"""Least number of elements around a closed direction."""


def starting_mesh(problem: Problem, quantity: Any = None) -> skfem.MeshQuad:
    """Some :data:`ELEMENTS` elements of equal sides in space, with mesh lines through point loads, supports and links, and
    along the sides of zones and of the rectangle over which a quantity is a mean.

    Raises
    ------
    InputError
        For a surface without bounds.
    """
    bounds = bounds_of(problem.surface)
    lengths = [s * (high - low) for s, (low, high) in zip(stretch(problem.surface), bounds, strict=True)]  # type: ignore[arg-type]
    wide = np.sqrt(lengths[0] / lengths[1])
    rows, closed = [], closed_bounds(problem.surface)
    for axis, (low, high) in enumerate(bounds):
        count = max(2, round(np.sqrt(ELEMENTS) * (wide if axis == 0 else 1 / wide)))
        if axis in closed:
            count = max(AROUND, count)
        sides = getattr(quantity, "within", None) or ((), ())
        held = [*_held(problem, axis), *map(float, sides[axis]), *lines_of(problem.zones, axis, closed)]
        rows.append(row_through(low, high, count, held, _loaded(problem, axis)))
    return tensor(problem.surface, *rows)  # type: ignore[arg-type]


def _held(problem: Problem, axis: int) -> list[float]:
    """Coordinates of single points that are held: they must have nodes."""
    found = [point for support in problem.supports for point in _points(getattr(support, "where", None))]
    return [float(point[axis]) for point in found]


def _loaded(problem: Problem, axis: int) -> list[float]:
    """Coordinates of points where something acts, a condition too: nodes there help."""
    places = [getattr(load, "at", None) for load in problem.loads] + [list(joint.points) for joint in problem.conditions]
    return [float(point[axis]) for place in places for point in _points(place)]


def _points(where: object) -> list:
    if isinstance(where, str) or not isinstance(where, list | tuple | np.ndarray):
        return []
    if len(where) == 2 and all(isinstance(x, int | float | np.number) for x in where):
        return [where]
    return [point for place in where for point in _points(place)]
