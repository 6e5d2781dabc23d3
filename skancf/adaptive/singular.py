"""Points where derivatives of a solution may have no limit, and which of them surely have none."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from skancf.adaptive.quantities import SectionForce
from skancf.errors import finite, unit_vector
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, nodes_at
from skancf.meshes.forest import Leaves
from skancf.supports.conditions import R_X, R_Y
from skancf.surfaces import normal
from skancf.system.regularity import facets_of, singularities
from skancf.system.system import System
from skancf.tolerances import ONE_DIRECTION, SAME_POINT


def singular_points(system: System, quantity: Any = None) -> np.ndarray:
    """Places in the parameter plane, (2, n): corners of the boundary, ends of supported edges, point loads and supports.

    And the point of a section force, about which its dual weight is singular. Not the poles that mirrors make smooth.
    """
    geometry, said = system.geometry, singularities(system)
    corners, smooth = _boundary_corners(geometry), _mirrored_poles(geometry, said)
    places = [corners[:, ~at_poles(geometry, corners, smooth)]]
    if isinstance(quantity, SectionForce) and quantity.at is not None:
        places.append(geometry.within(finite("at", quantity.at)[:, None]))
    for each in said:
        mirrors = at_poles(geometry, each.points, smooth) if "mirror" in each.kinds else np.zeros(each.points.shape[1], bool)
        if each.at_rest:
            places.append(each.points[:, ~mirrors])
    found = _around_poles(geometry, _both_sides(geometry, np.hstack(places)))
    if not found.size:
        return found
    scale = SAME_POINT * np.ptp(geometry.mesh.p, axis=1)[:, None]
    return np.asarray(found[:, np.unique(np.round(found / scale), axis=1, return_index=True)[1]])


def _both_sides(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    """Points of a closed seam at both of its ends."""
    for axis, (low, high) in geometry.closed_bounds().items():
        for here, there in ((low, high), (high, low)):
            other = points[:, np.abs(points[axis] - here) < SAME_POINT * (high - low)]
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


def _around_poles(geometry: Geometry, points: np.ndarray) -> np.ndarray:
    """The points, and of one at a pole all places that it has in the parameter plane."""
    for pole in geometry.ties.poles:
        if at_poles(geometry, points, [pole]).any():
            points = np.hstack([points, geometry.mesh.p[:, geometry.ties.node_of == pole]])
    return points


def at_poles(geometry: Geometry, points: np.ndarray, poles: Iterable[int] | None = None) -> np.ndarray:
    """Which points (2, n) of the parameter plane are at one of these poles, all of them by default: (n,)."""
    out, poles = np.zeros(points.shape[1], dtype=bool), list(geometry.ties.poles if poles is None else poles)
    if not poles or not points.size:
        return out
    positions = np.asarray(geometry.surface.position(*geometry.within(points))).T
    size = SAME_POINT * np.ptp(geometry.undeformed[:, 0], axis=0).max()
    for pole in poles:
        out |= np.linalg.norm(positions - geometry.undeformed[pole, 0], axis=1) < size
    return out


def images(geometry: Geometry, leaves: Leaves, points: np.ndarray) -> np.ndarray:
    """Points (2, n), and where one is at a pole all corners that leaves of the same surface have there."""
    here = [pole for pole in geometry.ties.poles if at_poles(geometry, points, [pole]).any()]
    if not here:
        return points
    corners = leaves.forest.places(leaves.cells).reshape(2, -1)
    return np.hstack([points, np.unique(corners[:, at_poles(geometry, corners, here)], axis=1)])


def _mirrored_poles(geometry: Geometry, said: list[Singularity]) -> list[int]:
    """Poles at which the surface, mirrored at the edges that end there, is smooth."""
    mirrored = facets_of(said, "mirror")
    if not geometry.ties.poles or not mirrored.size:
        return []
    others = geometry.mesh.facets[:, np.setdiff1d(geometry.boundary, mirrored)]
    ends = np.unique(geometry.ties.node_of[others])
    return [pole for pole in geometry.ties.poles if pole not in ends and _mirrors_fit(geometry, pole)]


def _mirrors_fit(geometry: Geometry, pole: int) -> bool:
    """Whether fields that are even about both edges of a sector with its tip in a pole are smooth there: as r^(pi / angle),
    which is no power of a smooth field for angles between a right and a straight one, and beyond that."""
    nodes = np.flatnonzero(geometry.ties.node_of == pole)
    tangents = geometry.ties.mix[nodes][:, 1:3, 1:3] @ geometry.ties.poles[pole]
    along = tangents[np.arange(len(nodes)), np.argmax(np.linalg.norm(tangents, axis=2), axis=1)]
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    order = np.lexsort(geometry.mesh.p[:, nodes])
    steps = along[order]
    angle = np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1.0, 1.0)).sum()
    return bool(angle < np.pi / 2 + ONE_DIRECTION or abs(angle - np.pi) < ONE_DIRECTION)


def holding(low: np.ndarray, high: np.ndarray, point: np.ndarray, extent: np.ndarray) -> np.ndarray:
    """Which boxes, (2, n) each end, hold a point (2,), on their rim too."""
    slack = SAME_POINT * extent[:, None]
    return np.asarray(((low <= point[:, None] + slack) & (high >= point[:, None] - slack)).all(axis=0))


def touching(leaves: Leaves, points: np.ndarray) -> np.ndarray:
    """Leaves that hold any of the points (2, n), (m,)."""
    low, high = leaves.boxes
    inside = [holding(low, high, point, leaves.extent) for point in points.T]
    return np.flatnonzero(np.any(inside, axis=0)) if inside else np.empty(0, dtype=int)


def held_points(geometry: Geometry, said: list[Singularity]) -> Iterator[tuple[Singularity, np.ndarray, bool, bool]]:
    """Single points (2,) that supports hold, whether in position, and whether their normal; without what an edge holds
    anyway."""
    held = geometry.ends(facets_of(said, "position"))
    clamped = geometry.ends(facets_of(said, "position", "normal"))
    for each in (each for each in said if each.holds and each.at_rest):
        for point in each.alone.T:
            node = nodes_at(geometry, point[:, None])
            rests = bool({"position", "part"} & set(each.kinds)) and not np.isin(node, held).any()
            turned = "normal" in each.kinds and not np.isin(node, clamped).any()
            if rests or turned:
                yield each, point, rests, turned


def at_free_right_angle(geometry: Geometry, said: list[Singularity], at: Any) -> bool:
    """Is there a right-angled corner of theory `kirchhoff` that no mirror makes a part of a longer edge?"""
    for node in () if geometry.theory.shear else geometry.corners:
        mesh_node = int(geometry.ties.representative[node])
        if not same_point(geometry, geometry.mesh.p[:, mesh_node], at):
            continue
        x, y = geometry.undeformed_at(mesh_node)[[R_X, R_Y]]
        guided = np.setdiff1d(facets_of(said, "normal"), facets_of(said, "position", "normal"))
        mirrors = np.concatenate([facets_of(said, "mirror"), guided])
        mirrored = bool(np.isin(node, geometry.ends(mirrors)))
        return bool(abs(x @ y) < ONE_DIRECTION * np.linalg.norm(x) * np.linalg.norm(y)) and not mirrored
    return False


def has_part_along(geometry: Geometry, force: np.ndarray, at: Any) -> bool:
    """Does a force (3,) at a point have a part along the undeformed surface?"""
    force, n = unit_vector("force", force), normal_at(geometry, at)
    return bool(np.linalg.norm(force - (force @ n) * n) > ONE_DIRECTION)


def normal_at(geometry: Geometry, at: Any) -> np.ndarray:
    """The undeformed normal, at a pole its limit."""
    x, y = geometry.within(finite("at", at))[:, None]
    return np.asarray(normal(geometry.surface, x, y)[:, 0])


def same_point(geometry: Geometry, one: Any, two: Any) -> bool:
    """Are two points of the parameter plane one, across the seam of a closed parameter and at a pole too?"""
    apart, extent = finite("at", one) - finite("at", two), np.ptp(geometry.mesh.p, axis=1)
    apart = apart - geometry.whole_turns(apart)
    if np.linalg.norm(apart / extent) < SAME_POINT:
        return True
    at = [np.asarray(geometry.surface.position(*geometry.within(finite("at", p))[:, None]))[:, 0] for p in (one, two)]
    size = SAME_POINT * np.ptp(geometry.undeformed[:, 0], axis=0).max()
    return any(max(np.linalg.norm(p - geometry.undeformed[pole, 0]) for p in at) < size for pole in geometry.ties.poles)
