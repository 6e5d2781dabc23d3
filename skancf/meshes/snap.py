"""Nodes that single precision or another program left beside the bounds of the surface."""

from dataclasses import replace
from typing import Any

import numpy as np
import skfem

from skancf.errors import InputError

# Of the range of a parameter: this near to a bound is on it, unless elements are that small.
NEAR = 1e-6
# Of the shortest edge.
OF_AN_EDGE = 1e-2
# Of the range: nodes that are outside by rounding alone are left where they are.
ROUNDING = 1e-12
# Of the range: so far from the bounds nodes of a quadtree may be, which are not moved.
SLACK = 1e-9


def onto_bounds(mesh: skfem.MeshQuad, bounds: Any) -> skfem.MeshQuad:
    """The mesh with nodes moved onto bounds that they miss by less than a millionth of the range; itself without any.

    Raises
    ------
    InputError
        For a node farther outside.
    """
    box = np.array(bounds, float)
    size = (box[:, 1] - box[:, 0])[:, None]
    away = np.abs(mesh.p[:, :, None] - box[:, None]) / size[:, :, None]
    off = away.min(axis=2)
    near = (off > ROUNDING) & (off < NEAR)
    slack = SLACK
    if near.any() and not hasattr(mesh, "hanging"):
        ends = mesh.p[:, mesh.facets] / size[:, :, None]
        slack = max(SLACK, min(NEAR, OF_AN_EDGE * np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=0).min())))
        near &= off <= slack
        if near.any():
            bound = np.where(away[:, :, 0] < away[:, :, 1], box[:, :1], box[:, 1:])
            mesh = replace(mesh, doflocs=np.where(near, bound, mesh.p.astype(float)))
    for name, values, (low, high) in zip("xy", mesh.p, box.tolist(), strict=True):
        beyond = slack * (high - low)
        outside = np.flatnonzero((values < low - beyond) | (values > high + beyond))
        if outside.size:
            hint = ""
            if hasattr(mesh, "hanging") and not (np.maximum(low - values, values - high) > NEAR * (high - low)).any():
                hint = "; make the quadtree by quadtree(mesh, surface), which moves its nodes onto the bounds"
            raise InputError(f"mesh node {outside[0]}: {name} = {values[outside[0]]} is outside the surface, which "
                             f"spans {low} to {high}; the mesh lives in the parameter plane{hint}")  # fmt: skip
    return mesh
