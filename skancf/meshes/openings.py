"""Rectangles cut out of a mesh."""

from typing import Any

import numpy as np
import skfem

from skancf.errors import InputError, finite
from skancf.tolerances import ONE_PLACE

OPENING = "opening"
"""Name of the boundary around openings."""

Opening = tuple[tuple[float, float], tuple[float, float]]


def cut(
    mesh: skfem.MeshQuad, x: np.ndarray, y: np.ndarray, rectangles: np.ndarray, closed: tuple[bool, bool]
) -> skfem.MeshQuad:
    """A mesh between node positions without the elements in some rectangles; new edges are the boundary ``"opening"``.

    Names of sides of which nothing is left are dropped; the remaining elements keep their order and their corners.

    Parameters
    ----------
    mesh
        Of rectangles between the positions ``x`` and ``y``.
    rectangles : (n, 2, 2) array
        Of :func:`rectangles_of`.
    closed : (bool, bool)
        Directions whose two ends are one curve in space.
    """
    if not len(rectangles):
        return mesh
    if OPENING in (mesh.boundaries or {}):
        raise InputError(f"openings: the surface has a side {OPENING!r}, the name of the edges of openings; rename it")
    inside = _inside(mesh, x, y, rectangles)
    if inside.all():
        raise InputError("openings: together they cover all elements, so that nothing is left; leave some")
    _check_seams(mesh, inside, closed)
    left = mesh.restrict(np.flatnonzero(~inside), skip_boundaries=True)
    _check_joints(left)
    # Facets that are left keep their order.
    kept = np.unique(mesh.t2f[:, ~inside])
    first, second = mesh.f2t[:, kept]
    names = {name: np.flatnonzero(np.isin(kept, facets)) for name, facets in (mesh.boundaries or {}).items()}
    names[OPENING] = np.flatnonzero((second >= 0) & (inside[first] != inside[second]))
    return left.with_boundaries({name: facets for name, facets in names.items() if facets.size})


def _inside(mesh: skfem.MeshQuad, x: np.ndarray, y: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """Which elements are in an opening, (n_elements,)."""
    middle = mesh.p[:, mesh.t].mean(axis=1)
    inside = np.zeros(mesh.nelements, dtype=bool)
    for k, sides in enumerate(rectangles):
        within = [_between(f"openings[{k}]", *parts) for parts in zip("xy", (x, y), sides, middle, strict=True)]
        inside |= within[0] & within[1]
    return inside


def rectangles_of(openings: Any) -> np.ndarray:
    """Openings as an array (n, 2, 2): direction, lower and upper side."""
    given = finite("openings", openings)
    if given.ndim == 0 or (given.size and given.shape[1:] != (2, 2)):
        raise InputError(f"openings of shape {given.shape}: give a list of rectangles ((x0, x1), (y0, y1)), as in "
                         "openings=[((0.2, 0.4), (0.2, 0.4))]")  # fmt: skip
    return given


def _between(name: str, axis: str, lines: np.ndarray, sides: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Which elements are between two mesh lines."""
    low, high = sides.tolist()
    slack = ONE_PLACE * (lines[-1] - lines[0])
    if not low + 2 * slack < high:
        raise InputError(f"{name}: {axis} from {low} to {high} covers no element; give the lower side first, then the upper")
    for side in (low, high):
        if not lines[0] - slack <= side <= lines[-1] + slack:
            raise InputError(f"{name}: its side {axis} = {side} is outside the bounds ({lines[0]}, {lines[-1]}); "
                             "end it at the bound")  # fmt: skip
        if np.abs(lines - side).min() > slack:
            above = int(np.searchsorted(lines, side))
            raise InputError(f"{name}: its side {axis} = {side} is on no mesh line, the nearest are {axis} = "
                             f"{lines[above - 1]:.12g} and {lines[above]:.12g}; move the side or the lines")  # fmt: skip
    return (middle > low) & (middle < high)


def _check_seams(mesh: skfem.MeshQuad, inside: np.ndarray, closed: tuple[bool, bool]) -> None:
    """InputError where an opening ends at a seam, on the other side of which the surface goes on."""
    for axis, name in enumerate("xy"):
        if not closed[axis]:
            continue
        low, high = mesh.p[axis].min(), mesh.p[axis].max()
        across, along = mesh.p[axis, mesh.facets], mesh.p[1 - axis, mesh.facets].mean(axis=0)
        start, end = (np.flatnonzero((across == bound).all(axis=0)) for bound in (low, high))
        start, end = (facets[np.argsort(along[facets])] for facets in (start, end))
        apart = inside[mesh.f2t[0, start]] != inside[mesh.f2t[0, end]]
        if apart.any():
            near = f"{'yx'[axis]} = {along[start][apart][0]:.6g}"
            raise InputError(f"openings: one ends at the seam {name} = {low}, which is {name} = {high} too, near {near}; "
                             "cut on both sides of the seam, or on none")  # fmt: skip


def _check_joints(mesh: skfem.MeshQuad) -> None:
    """InputError where elements meet at a node and are not neighbours there, neither directly nor by others."""
    n = mesh.p.shape[1]
    edges, quads = (np.bincount(cells.ravel(), minlength=n) for cells in (mesh.facets, mesh.t))
    # k elements around a node have k edges there if they close the circle, and one more for each gap between them.
    alone = np.flatnonzero(edges - quads > 1)
    if alone.size:
        place = ", ".join(f"{v:.6g}" for v in mesh.p[:, alone[0]])
        raise InputError(f"openings: what is left hangs together at node {alone[0]}, ({place}), by that node only, which is "
                         "a hinge; join the openings, or keep them apart by an element")  # fmt: skip
