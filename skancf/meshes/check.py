"""Is this mesh usable?"""

from typing import Any

import numpy as np
import skfem

from skancf.errors import InputError
from skancf.meshes.outline import check_edges, check_outline, check_places, fills, overlapping
from skancf.tolerances import NO_AREA, SEVEN_DIGITS


def check_mesh(mesh: Any) -> None:
    r"""Every element is a convex quad, every node belongs to one, and the elements cover one region once.

    With corners :math:`p_0 \ldots p_3` in the order of ``mesh.t``, the bilinear map of the reference square has the
    Jacobian :math:`J_i \propto (p_{i+1} - p_i) \times (p_i - p_{i-1})` at corner i. All four must have the same sign,
    and none may vanish against the squared longest edge. Both signs are legal: corners may be numbered either way
    round, and two elements of a mesh may differ.

    Raises
    ------
    InputError
        For anything that is not a ``skfem.MeshQuad`` with straight edges, points that are not finite, a quad that is
        not convex or has no area (its number and corners are named), nodes without an element, nodes in the middle of
        another element's edge, where the surface would be torn, two nodes at one place, elements that overlap or are
        there twice, and pieces that no edge joins.

    Examples
    --------
    >>> sk.meshes.check_mesh(sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 4, 4))
    """
    check_mesh_on(mesh, None)


def check_mesh_on(mesh: Any, bounds: Any) -> None:
    """:func:`check_mesh`, and that the mesh covers the bounds of a surface, where it has bounds, but for holes and edges
    named ``"opening"``."""
    if not isinstance(mesh, skfem.MeshQuad) or isinstance(mesh, skfem.MeshQuad2):
        raise InputError(
            f"mesh is a {type(mesh).__name__}: give a skfem.MeshQuad (straight edges; "
            "the surface describes a curved shape, not the mesh)"
        )
    points, quads = mesh.p, mesh.t
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=0))
    if wrong.size:
        raise InputError(f"node {wrong[0]} lies at {points[:, wrong[0]]}: every coordinate must be a finite number")
    _check_quads(points, quads)
    unused = np.setdiff1d(np.arange(points.shape[1]), quads)
    if unused.size:
        raise InputError(
            f"{unused.size} nodes belong to no element (first: {unused[0]}): their unknowns would have no "
            "stiffness; mesh.remove_unused_nodes() drops them"
        )
    # A quadtree's elements are joined by construction.
    grown = hasattr(mesh, "hanging")
    if not grown:
        check_edges(mesh)
    if fills(mesh, bounds):
        return
    if not grown:
        check_places(mesh)
        _check_joined(mesh)
    check_outline(mesh, bounds)


def _check_joined(mesh: skfem.MeshQuad) -> None:
    """No node of the boundary lies inside an edge of it."""
    ends = mesh.p[:, mesh.facets[:, mesh.boundary_facets()]]
    middle, half = ends.mean(axis=1), (ends[:, 1] - ends[:, 0]) / 2
    length = np.linalg.norm(half, axis=0)
    pairs = [_between_ends(mesh.p[axis], mesh.boundary_nodes(), middle[axis], half[axis], facets)
             for axis, facets in enumerate(_by_direction(half))]  # fmt: skip
    facet, node = np.concatenate(pairs, axis=1)
    away = mesh.p[:, node] - middle[:, facet]
    off = np.abs(away[0] * half[1, facet] - away[1] * half[0, facet]) / length[facet] ** 2
    torn = np.flatnonzero(off < SEVEN_DIGITS)
    if torn.size:
        x, y = mesh.p[:, node[torn[0]]]
        raise InputError(
            overlapping(mesh)
            or f"node {node[torn[0]]} at ({x:.6g}, {y:.6g}) lies inside the edge of an "
            "element that does not have it: the surface would be torn there; give both sides the "
            "same nodes, or refine a sk.meshes.quadtree"
        )


def _by_direction(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the edges that run along x rather than y, and of the others."""
    along_x = np.abs(half[0]) >= np.abs(half[1])
    return np.flatnonzero(along_x), np.flatnonzero(~along_x)


def _between_ends(x: np.ndarray, nodes: np.ndarray, middle: np.ndarray, half: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Pairs (2, n) of an edge and a node whose coordinate is between those of the edge's ends."""
    nodes = nodes[np.argsort(x[nodes])]
    reach = np.abs(half[facets]) * (1 - SEVEN_DIGITS)
    first, last = (np.searchsorted(x[nodes], middle[facets] + sign * reach) for sign in (-1, 1))
    counts = last - first
    begin = np.repeat(first - np.cumsum(counts) + counts, counts)
    return np.stack([np.repeat(facets, counts), nodes[begin + np.arange(len(begin))]])


def corner_jacobians(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Jacobian at the four corners over the squared longest edge of each quad: (2, n), (4, nelems) -> (4, nelems)."""
    corner = points[:, quads]
    ahead = np.roll(corner, -1, axis=1) - corner
    behind = np.roll(ahead, 1, axis=1)
    longest = (ahead**2).sum(axis=0).max(axis=0)
    return (behind[0] * ahead[1] - behind[1] * ahead[0]) / np.where(longest > 0, longest, 1)


def _check_quads(points: np.ndarray, quads: np.ndarray) -> None:
    jacobian = corner_jacobians(points, quads)
    turned = jacobian * np.sign(jacobian.sum(axis=0))
    wrong = np.flatnonzero(~(turned > NO_AREA).all(axis=0))
    if wrong.size:
        first = wrong[0]
        corners = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in points[:, quads[:, first]].T)
        raise InputError(
            f"{wrong.size} elements are not convex quads (first: element {first} with corners {corners}): "
            "number the corners of each quad around it and move nodes until no angle reaches 180 degrees"
        )
