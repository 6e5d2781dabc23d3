"""Coarse meshes of aligned rectangles, from which quadtrees grow."""

import numpy as np
import skfem

from skancf.elements.nodal import require_aligned
from skancf.errors import InputError
from skancf.meshes.check import check_mesh
from skancf.meshes.forest import BOTTOM, CORNER_NUMBER, LEFT, RIGHT, TOP, Forest
from skancf.tolerances import ONE_PLACE

MOST_ROOTS = 2**18
"""So many have numbers among the keys of cells."""


def forest_of(mesh: skfem.MeshQuad, closed: tuple[bool, bool]) -> Forest:
    """The forest of a coarse mesh whose directions are closed or not."""
    if mesh.nelements >= MOST_ROOTS:
        raise InputError(f"a coarse mesh of {mesh.nelements} elements: give fewer than {MOST_ROOTS}, and refine them")
    check_mesh(mesh)
    require_aligned(mesh, "a quadtree, which is what is refined element by element,",
                    "or solve on this mesh as it is, with theory 'full' and without adapting")  # fmt: skip
    points = _on_lines(mesh.p)
    corners = _counter_clockwise(points, mesh.t)
    coarse = skfem.MeshQuad(points, corners)
    return Forest(points, corners.astype(np.int64), coarse.t2f.astype(np.int64), _neighbours(coarse, closed), closed)


def _on_lines(points: np.ndarray) -> np.ndarray:
    """Coordinates that are equal to rounding made equal."""
    out = points.copy()
    for row in out:
        order = np.argsort(row)
        new = np.diff(row[order], prepend=-np.inf) > ONE_PLACE * np.ptp(row)
        row[order] = row[order][new][np.cumsum(new) - 1]
    return out


def _counter_clockwise(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Corners of each rectangle from the lower left one on."""
    place = points[:, quads]
    above = (place > place.mean(axis=1, keepdims=True)).astype(int)
    return np.take_along_axis(quads, np.argsort(CORNER_NUMBER[above[0], above[1]], axis=0), axis=0)


def _neighbours(coarse: skfem.MeshQuad, closed: tuple[bool, bool]) -> np.ndarray:
    """Root across each side, (4, n_roots + 1)."""
    elements = np.arange(coarse.nelements)
    out = np.full((4, len(elements) + 1), -1)
    both = coarse.f2t[:, coarse.t2f]
    out[:, :-1] = np.where(both[0] == elements, both[1], both[0])
    out[:, :-1][out[:, :-1] == elements] = -1
    for axis, (one, other) in enumerate([(LEFT, RIGHT), (BOTTOM, TOP)]):
        if closed[axis]:
            _across_seam(coarse, axis, one, other, out)
    return out


def _across_seam(coarse: skfem.MeshQuad, axis: int, one: int, other: int, out: np.ndarray) -> None:
    at, along = coarse.p[axis], coarse.p[1 - axis]
    starts = np.flatnonzero(at[coarse.t[0]] == at.min())
    ends = np.flatnonzero(at[coarse.t[2]] == at.max())
    starts, ends = (roots[np.argsort(along[coarse.t[0, roots]])] for roots in (starts, ends))
    intervals = [along[coarse.t[[0, 2]][:, roots]] for roots in (starts, ends)]
    if intervals[0].shape != intervals[1].shape or (intervals[0] != intervals[1]).any():
        raise InputError(f"the surface is closed in {'xy'[axis]}, but the mesh has other edges at {at.min():.6g} than at "
                         f"{at.max():.6g}; give both ends the same nodes")  # fmt: skip
    out[one, starts], out[other, ends] = ends, starts
