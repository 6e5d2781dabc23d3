"""A problem as a sketch: its surface with what holds it and what acts on it."""

from collections.abc import Iterator
from numbers import Real
from typing import Any

import numpy as np

from skancf.errors import SkancfError
from skancf.layout.geometry import Geometry
from skancf.meshes import uniform
from skancf.output.canvas import INK, new_figure
from skancf.problem import Problem
from skancf.theories import Full

LINES, FINE = 8, 6
"""Elements along each parameter, and straight pieces of one of their edges."""
HELD, ACTING = "#0072B2", "#D55E00"
LONGEST = 0.22
"""Of an arrow, of the surface's extent."""


def sketch(problem: Problem) -> Any:
    """A figure of matplotlib: grid lines of the surface, supported edges and points in blue, forces as arrows.

    Directions of loads are told, and their sizes are not. What has no place, as a pressure, is not drawn.
    """
    geometry = Geometry(uniform(problem.surface, LINES, LINES), problem.surface, Full())
    figure = new_figure(6.0, 4.2)
    axes = figure.add_subplot(projection="3d")
    axes.computed_zorder = False
    for line in _curves(geometry, np.arange(geometry.mesh.nfacets)):
        axes.plot(*line, color="#b0b0b0", linewidth=0.6)
    for line in _curves(geometry, geometry.boundary):
        axes.plot(*line, color=INK, linewidth=1.2)
    extent = float(np.ptp(geometry.undeformed[:, 0], axis=0).max())
    for support in problem.supports:
        _mark(axes, geometry, getattr(support, "where", None))
    for load in problem.loads:
        _arrows(axes, geometry, load, LONGEST * extent)
    axes.set_aspect("equal")
    axes.set(xlabel="x", ylabel="y", zlabel="z")
    axes.locator_params(nbins=4)
    return figure


def _curves(geometry: Geometry, facets: np.ndarray) -> Iterator[np.ndarray]:
    """Edges of elements as they lie in space, (3, n) each."""
    s = np.linspace(0, 1, FINE + 1)
    for first, last in geometry.mesh.p[:, geometry.mesh.facets[:, facets]].transpose(2, 1, 0):
        yield np.asarray(geometry.surface.position(*(first[:, None] * (1 - s) + last[:, None] * s)))


def _places(geometry: Geometry, where: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points in space (n, 3) and facets that a place means; none where the sketch's mesh has no such place."""
    if _is_point(where):
        return np.asarray(geometry.surface.position(*where)).reshape(1, 3), np.empty(0, dtype=int)
    if isinstance(where, list | tuple):
        parts = [_places(geometry, each) for each in where]
        return np.concatenate([p for p, _ in parts]), np.concatenate([f for _, f in parts])
    try:
        nodes, facets = geometry.points_and_facets(where)
    except SkancfError:
        return np.empty((0, 3)), np.empty(0, dtype=int)
    return geometry.undeformed[nodes, 0], facets


def _is_point(where: Any) -> bool:
    return np.shape(where) == (2,) and all(isinstance(x, Real | np.number) for x in where)


def _mark(axes: Any, geometry: Geometry, where: Any) -> None:
    points, facets = _places(geometry, where)
    for line in _curves(geometry, facets):
        axes.plot(*line, color=HELD, linewidth=3.2, solid_capstyle="round", zorder=4)
    if not len(facets):
        axes.plot(*points.T, "^", color=HELD, markersize=8, markeredgecolor="white", zorder=5)


def _arrows(axes: Any, geometry: Geometry, load: Any, length: float) -> None:
    """Arrows in the direction of a load whose force is three numbers, or its place where that is all that is known."""
    at, where = getattr(load, "at", None), getattr(load, "where", None)
    force = next((getattr(load, name) for name in ("force", "acceleration", "impulse") if hasattr(load, name)), None)
    if at is None and where is None:
        points = geometry.undeformed[:: max(1, geometry.n_nodes // 12), 0]
    else:
        points = _places(geometry, where if at is None else at)[0]
    if force is None or np.shape(force) != (3,) or not np.any(np.asarray(force, dtype=float)):
        if at is not None or where is not None:
            axes.plot(*points.T, "o", color=ACTING, markersize=6, markeredgecolor="white", zorder=5)
        return
    arrow = length * np.asarray(force, dtype=float) / np.linalg.norm(np.asarray(force, dtype=float))
    arrow = arrow if at is not None else 0.6 * arrow
    start = points - arrow
    axes.quiver(
        *start.T, *np.broadcast_to(arrow, points.shape).T, color=ACTING, linewidth=1.8, arrow_length_ratio=0.3, zorder=6
    )
