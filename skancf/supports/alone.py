"""Points in a row along an edge of the boundary, which do not hold the edge."""

from typing import Any

import numpy as np

from skancf.errors import shown, warn
from skancf.layout.geometry import Geometry
from skancf.supports.conditions import Edges, edges, single_points, space_tangent

STRAIGHT = 0.87
"""Cosine of the angle by which a boundary turns in space at most where it counts as one line, 30 degrees."""


def edges_or_points(name: str, geometry: Geometry, where: Any) -> Edges:
    """:func:`~skancf.supports.conditions.edges` of a support that holds positions, with a warning for points in a row."""
    place = edges(geometry, where)
    if hint := geometry.strays(where):
        warn(f"{name}: where = {hint}; those are held as single points, between which the surface is free. Narrow the "
             "function if an edge alone is meant")  # fmt: skip
    row = points_in_a_row(geometry, place)
    if row is not None:
        x, y = row
        warn(
            f"{name}: where = {shown(where)} are single points, of which three or more are neighbours along one edge, at "
            f"({x:.6g}, {y:.6g}) for example: between them the edge is free, and stresses grow without limit as the mesh is "
            "refined. To hold the edge as well, give its name, or a function of (x, y) that is true along it"
        )
    return place


def points_in_a_row(geometry: Geometry, place: Edges) -> np.ndarray | None:
    """The middle one (2,) of three single points of a place that are neighbours along one line of the boundary, or None."""
    alone = geometry.ties.node_of[single_points(geometry, place)]
    if alone.size < 3:
        return None
    facets = geometry.boundary[np.isin(geometry.ends(geometry.boundary), alone).all(axis=0)]
    ends, directions = geometry.ends(facets), geometry.facet_directions(facets)
    for node in alone.tolist():
        at_it, seen = np.flatnonzero((ends == node).any(axis=0)), int(geometry.ties.representative[node])
        if len(at_it) != 2:
            continue
        one, two = (space_tangent(geometry, seen, directions[:, facet]) for facet in at_it)
        if abs(one @ two) > STRAIGHT:
            return np.asarray(geometry.mesh.p[:, seen])
    return None
