"""Meshes of the parameter plane as curves and triangles of the x-y plane."""

from typing import Any

import numpy as np
import skfem

from skancf.arguments import MESH, instance
from skancf.errors import InputError, finite
from skancf.meshes import Region
from skancf.surfaces import Surface
from skancf.surfaces.checks import require_surface

ENOUGH_CELLS = 15_000


def drawable(mesh: Any, surface: Any) -> None:
    """InputError for what is no mesh, and for what is no surface and not None."""
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    if surface is not None:
        require_surface(surface, ("position", "derivatives"))


def to_plane(surface: Surface | None, points: np.ndarray) -> np.ndarray:
    """x and y in space, (2, ...), of points of the parameter plane (2, ...)."""
    return points if surface is None else np.asarray(surface.position(*points))[:2]


def edge_curves(mesh: skfem.MeshQuad, surface: Surface | None) -> np.ndarray:
    """All edges as polylines, (m, n, 2); straight ones where there is no surface. Of a divided edge its halves."""
    # The whole edge that smaller elements divide has one neighbour, and yet is no boundary.
    once = np.concatenate([np.flatnonzero(mesh.f2t[1] >= 0), mesh.boundary_facets()])
    ends = mesh.p[:, mesh.facets[:, once]]
    s = np.linspace(0, 1, 2 if surface is None else 13)
    points = ends[:, 0, :, None] * (1 - s) + ends[:, 1, :, None] * s
    return np.moveaxis(to_plane(surface, points), 0, -1)


def cell_outlines(mesh: skfem.MeshQuad, surface: Surface | None) -> np.ndarray:
    """The outline of each element, (n_elements, n, 2)."""
    corners = mesh.p[:, mesh.t]
    s = np.linspace(0, 1, 1 if surface is None else 8, endpoint=False)
    points = corners[:, :, None] * (1 - s)[:, None] + np.roll(corners, -1, axis=1)[:, :, None] * s[:, None]
    return to_plane(surface, points.reshape(2, -1, mesh.t.shape[1])).T


def region_within(mesh: skfem.MeshQuad, region: Region) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner (2,) of a region, cut off at the bounds of the mesh."""
    centre, half = np.array(region.centre), np.array(region.half_size)
    low = np.maximum(centre - half, mesh.p.min(axis=1))
    return low, np.minimum(centre + half, mesh.p.max(axis=1))


def region_outline(mesh: skfem.MeshQuad, surface: Surface | None, region: Region) -> np.ndarray:
    """The outline of a region, (2, n)."""
    low, high = region_within(mesh, region)
    s = np.linspace(0, 1, 25)
    rim = np.concatenate([[s, 0 * s], [0 * s + 1, s], [1 - s, 0 * s + 1], [0 * s, 1 - s]], axis=1)
    return to_plane(surface, low[:, None] + (high - low)[:, None] * rim)


def label_place(mesh: skfem.MeshQuad, surface: Surface | None, region: Region) -> np.ndarray:
    """Where a region's label goes: below its middle, where a named point often is."""
    low, high = region_within(mesh, region)
    return to_plane(surface, low + np.array([0.5, 0.25]) * (high - low))


def subdivided(mesh: skfem.MeshQuad, values: Any, surface: Surface | None) -> tuple[Any, np.ndarray]:
    """Triangles (matplotlib) and values of a bilinear field, fine enough for curved boundaries and contours.

    Quadrilaterals are cut into four triangles about their middle, which favours no diagonal.
    """
    from matplotlib.tri import Triangulation

    fine, field = mesh, finite("values", values)
    if field.shape != (mesh.p.shape[1],):
        raise InputError(f"values have shape {field.shape}: give one for each of the {mesh.p.shape[1]} nodes")
    for _ in range(3):
        if fine.t.shape[1] <= ENOUGH_CELLS / 4:
            fine, field = _refine(fine, field)
    middle = fine.p.shape[1] + np.arange(fine.t.shape[1])
    triangles = np.concatenate([np.stack([fine.t[k], fine.t[(k + 1) % 4], middle], axis=1) for k in range(4)])
    points = np.concatenate([fine.p, fine.p[:, fine.t].mean(axis=1)], axis=1)
    return Triangulation(*to_plane(surface, points), triangles), np.concatenate([field, field[fine.t].mean(axis=0)])


def _refine(mesh: skfem.MeshQuad, field: np.ndarray) -> tuple[skfem.MeshQuad, np.ndarray]:
    """Halve the edges; new nodes are numbered nodes, edges, elements, as ``refined`` of scikit-fem does."""
    plain = skfem.MeshQuad(mesh.p, mesh.t)
    new = np.concatenate([field, _middles(mesh, plain.facets, field), field[mesh.t].mean(axis=0)])
    return plain.refined(), new


def _middles(mesh: skfem.MeshQuad, edges: np.ndarray, field: np.ndarray) -> np.ndarray:
    """Values in the middle of edges (2, n); where a node hangs, its own, so that the field has no gap."""
    values = field[edges].mean(axis=0)
    if not hasattr(mesh, "hanging"):
        return values
    keys, wanted = (np.sort(pairs, axis=0).T @ [mesh.p.shape[1], 1] for pairs in (edges, mesh.hanging_ends))
    order = np.argsort(keys)
    at = order[np.minimum(np.searchsorted(keys[order], wanted), len(order) - 1)]
    # Across a closed seam the edge has other nodes.
    found = keys[at] == wanted
    values[at[found]] = field[mesh.hanging[found]]
    return values
