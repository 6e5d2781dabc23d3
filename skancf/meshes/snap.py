"""Nodes that single precision or another program left slightly off the bounds of the surface, or off their mesh line."""

from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.sparse.csgraph import connected_components

from skancf.errors import InputError
from skancf.tolerances import MOVED_OF_EDGE, ONE_PLACE, ROUNDED_PLACE, SEVEN_DIGITS, SINGLE_PRECISION


def onto_bounds(mesh: skfem.MeshQuad, bounds: Any) -> skfem.MeshQuad:
    """The mesh with nodes moved onto bounds that they miss by less than a millionth of the range or the rounding of single
    precision, if elements are not that small; itself without any.

    Raises
    ------
    InputError
        For a node farther outside.
    """
    box = np.array(bounds, float)
    size = (box[:, 1] - box[:, 0])[:, None]
    away = np.abs(mesh.p[:, :, None] - box[:, None]) / size[:, :, None]
    off = away.min(axis=2)
    widest = np.maximum(SEVEN_DIGITS, SINGLE_PRECISION * np.abs(box).max(axis=1, keepdims=True) / size)
    near = (off > ROUNDED_PLACE) & (off < widest)
    slack = np.full((2, 1), ONE_PLACE)
    if near.any() and not hasattr(mesh, "hanging"):
        reach = np.minimum(widest, MOVED_OF_EDGE * _shortest(mesh, size))
        near &= off <= reach
        slack = np.maximum(ONE_PLACE, reach)
        if near.any():
            bound = np.where(away[:, :, 0] < away[:, :, 1], box[:, :1], box[:, 1:])
            mesh = replace(mesh, doflocs=np.where(near, bound, mesh.p.astype(float)))
    for name, values, (low, high), part in zip("xy", mesh.p, box.tolist(), slack[:, 0].tolist(), strict=True):
        beyond = part * (high - low)
        outside = np.flatnonzero((values < low - beyond) | (values > high + beyond))
        if outside.size:
            hint = ""
            if (
                hasattr(mesh, "hanging")
                and not (np.maximum(low - values, values - high) > SEVEN_DIGITS * (high - low)).any()
            ):
                hint = "; make the quadtree by quadtree(mesh, surface), which moves its nodes onto the bounds"
            raise InputError(f"mesh node {outside[0]}: {name} = {values[outside[0]]} is outside the surface, which "
                             f"spans {low} to {high}; the mesh lives in the parameter plane{hint}")  # fmt: skip
    return mesh


def onto_lines(mesh: skfem.MeshQuad) -> skfem.MeshQuad:
    """A mesh of rectangles that single precision or another program left askew, by less than a millionth of the mesh or its
    rounding, with the nodes of each mesh line on it; itself where none is askew, or one by more."""
    along = np.abs(mesh.p[:, mesh.facets[0]] - mesh.p[:, mesh.facets[1]])
    off = along.min(axis=0)
    if hasattr(mesh, "hanging") or not off.any():
        return mesh
    size = np.ptp(mesh.p, axis=1, keepdims=True)
    # The two ends of an edge may be off in opposite directions.
    slack = 2 * np.maximum(SEVEN_DIGITS * size, SINGLE_PRECISION * np.abs(mesh.p).max(axis=1, keepdims=True))
    slack = np.minimum(slack, MOVED_OF_EDGE * _shortest(mesh, size) * size)
    across = along <= slack
    if not across.any(axis=0).all():
        return mesh
    p = mesh.p.astype(float)
    for row, (one, other) in zip(p, (mesh.facets[:, part] for part in across), strict=True):
        graph = sp.coo_array((np.ones(len(one)), (one, other)), shape=(len(row), len(row)))
        _, line = connected_components(graph, directed=False)
        _, first = np.unique(line, return_index=True)
        row[:] = row[first[line]]
    return replace(mesh, doflocs=p)


def _shortest(mesh: skfem.MeshQuad, size: np.ndarray) -> float:
    """The shortest edge, with the ranges (2, 1) of both directions as units."""
    ends = mesh.p[:, mesh.facets] / size[:, :, None]
    return float(np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=0).min()))
