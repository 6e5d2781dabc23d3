"""Points where derivatives of a solution may have no limit."""

from typing import Any

import numpy as np

from skancf.adaptive.quantities import SectionForce
from skancf.assembly.geometry import Geometry
from skancf.assembly.system import System
from skancf.errors import InputError, finite
from skancf.meshes.forest import Leaves

SAME = 1e-8


def singular_points(system: System, quantity: Any = None) -> np.ndarray:
    """Places in the parameter plane, (2, n): corners of the boundary, ends of supported edges, point loads and supports.

    And the point of a section force, about which its dual weight is singular.
    """
    geometry, problem = system.geometry, system.problem
    places = [_boundary_corners(geometry)]
    if isinstance(quantity, SectionForce) and quantity.at is not None:
        places.append(geometry.within(finite("at", quantity.at)[:, None]))
    for item in (*problem.supports, *problem.loads):
        if hasattr(item, "where"):
            places.append(_ends(geometry, item.where))
        points = [getattr(item, name) for name in ("at", "start", "end") if hasattr(item, name)]
        places += [np.reshape(point, (2, 1)).astype(float) for point in points]
    found = _around_poles(geometry, _both_sides(geometry, np.hstack(places)))
    if not found.size:
        return found
    scale = SAME * np.ptp(geometry.mesh.p, axis=1)[:, None]
    return np.asarray(found[:, np.unique(np.round(found / scale), axis=1, return_index=True)[1]])


def _both_sides(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    """Points of a closed seam at both of its ends."""
    for axis, (low, high) in geometry.closed_bounds().items():
        for here, there in ((low, high), (high, low)):
            other = points[:, np.abs(points[axis] - here) < SAME * (high - low)]
            other[axis] = there
            points = np.hstack([points, other])
    return points


def _boundary_corners(geometry: Geometry) -> np.ndarray:
    """Nodes of the boundary where it turns."""
    mesh, facets = geometry.mesh, geometry.boundary
    along = np.abs(geometry.facet_directions(facets))
    along_x = np.bincount(mesh.facets[:, facets[along[0] > along[1]]].ravel(), minlength=mesh.p.shape[1])
    along_y = np.bincount(mesh.facets[:, facets[along[0] <= along[1]]].ravel(), minlength=mesh.p.shape[1])
    return np.asarray(mesh.p[:, (along_x > 0) & (along_y > 0)])


def _ends(geometry: Geometry, where: Any) -> np.ndarray:
    """Ends of the edges of a place, and its nodes that are on none."""
    try:
        nodes, facets = geometry.points_and_facets(where)
    except InputError:
        return np.empty((2, 0))
    ends = geometry.mesh.facets[:, facets]
    once = np.flatnonzero(np.bincount(ends.ravel(), minlength=geometry.mesh.p.shape[1]) == 1)
    alone = np.setdiff1d(nodes, geometry.ties.node_of[ends])
    return np.hstack([geometry.mesh.p[:, once], geometry.points[:, alone]])


def _around_poles(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    """The points, and of one at a pole all places that it has in the parameter plane."""
    if not geometry.ties.poles:
        return points
    positions = geometry.surface.position(*geometry.within(points)).T
    size = SAME * np.ptp(geometry.undeformed[:, 0], axis=0).max()
    for pole in geometry.ties.poles:
        if (np.linalg.norm(positions - geometry.undeformed[pole, 0], axis=1) < size).any():
            points = np.hstack([points, geometry.mesh.p[:, geometry.ties.node_of == pole]])
    return points


def touching(leaves: Leaves, points: np.ndarray) -> np.ndarray:
    """Leaves that hold any of the points (2, n), (m,)."""
    (low, high), slack = leaves.boxes, SAME * leaves.extent[:, None]
    inside = [((low <= point[:, None] + slack) & (high >= point[:, None] - slack)).all(axis=0) for point in points.T]
    return np.flatnonzero(np.any(inside, axis=0)) if inside else np.empty(0, dtype=int)
