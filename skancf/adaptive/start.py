"""Where the loop begins."""

import numpy as np
import skfem

from skancf.errors import InputError
from skancf.meshes import tensor
from skancf.meshes.counts import stretch
from skancf.meshes.tensor import bounds_of
from skancf.problem import Problem
from skancf.surfaces import closed_directions

ELEMENTS = 16
AROUND = 8
"""Least number of elements around a closed direction."""
SAME = 1e-9


def starting_mesh(problem: Problem) -> skfem.MeshQuad:
    """Some :data:`ELEMENTS` elements of equal sides in space, with mesh lines through point loads and supports.

    Raises
    ------
    InputError
        For a surface without bounds.
    """
    bounds = bounds_of(problem.surface)  # type: ignore[arg-type]
    lengths = [s * (high - low) for s, (low, high) in zip(stretch(problem.surface), bounds, strict=True)]  # type: ignore[arg-type]
    wide = np.sqrt(lengths[0] / lengths[1])
    rows = []
    for axis, (low, high) in enumerate(bounds):
        count = max(2, round(np.sqrt(ELEMENTS) * (wide if axis == 0 else 1 / wide)))
        if closed_directions(problem.surface)[axis]:
            count = max(AROUND, count)
        rows.append(_row(low, high, count, _needed(problem, axis)))
    return tensor(problem.surface, *rows)  # type: ignore[arg-type]


def _needed(problem: Problem, axis: int) -> list[float]:
    """Coordinates of single points where something acts or holds."""
    found = []
    for item in (*problem.supports, *problem.loads):
        at = getattr(item, "at", None)
        found += [at] if at is not None else _points(getattr(item, "where", None))
    return [float(point[axis]) for point in found]


def _points(where: object) -> list:
    if isinstance(where, str) or not isinstance(where, list | tuple | np.ndarray):
        return []
    if len(where) == 2 and all(isinstance(x, int | float | np.number) for x in where):
        return [where]
    return [point for place in where for point in _points(place)]


def _row(low: float, high: float, count: int, needed: list[float]) -> np.ndarray:
    """About ``count`` even steps that meet the needed coordinates."""
    inner = sorted({x for x in needed if low + SAME * (high - low) < x < high - SAME * (high - low)})
    fixed = np.array([low, *inner, high])
    apart = np.diff(fixed, prepend=-np.inf) > SAME * (high - low)
    fixed = fixed[apart]
    parts = np.maximum(1, np.round(count * np.diff(fixed) / (high - low)).astype(int))
    row = np.concatenate([np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(fixed[:-1], fixed[1:], parts, strict=True)])
    if not np.isfinite(row).all():
        raise InputError(f"bounds ({low}, {high}): a mesh needs finite ones")
    return np.append(row, high)
