"""Meshes that are the product of two rows of nodes, with their sides named."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import skfem

from skancf.errors import InputError, finite, shown
from skancf.memory import MESH, require_mesh
from skancf.meshes.openings import Opening, cut, rectangles_of
from skancf.surfaces import BoundedSurface, Interval, Surface, closed_directions
from skancf.surfaces.checks import require_surface
from skancf.tolerances import ONE_PLACE

LONGEST = 1e9
"""Largest ratio of the two ranges of a surface's parameters."""


def tensor(surface: Surface, x: Any, y: Any, openings: Sequence[Opening] = ()) -> skfem.MeshQuad:
    """Aligned rectangles between the node positions ``x`` and ``y``, with the boundaries named by ``surface.sides``.

    Sides of a closed direction are one curve in space and no boundary; they get no name. The edges of openings are the
    boundary ``"opening"``; where an opening reaches a side, the rest of that side keeps its name.

    Parameters
    ----------
    surface : BoundedSurface
        Gives the bounds and the names of the four sides.
    x, y : (nx + 1,), (ny + 1,) array
        Increasing node positions from the lower to the upper bound (units of the parameter plane).
    openings : sequence of ((x0, x1), (y0, y1))
        Rectangles without elements, with sides on mesh lines. They may touch or overlap each other and the sides of the
        surface. At the seam of a closed direction they lie on both sides of it.

    Returns
    -------
    skfem.MeshQuad
        nx times ny rectangles less those in openings, corners numbered clockwise (as ``MeshQuad.init_tensor`` does).

    Raises
    ------
    InputError
        For a surface without bounds, and for positions that do not increase from bound to bound. For an opening whose sides
        are not on mesh lines or out of bounds, and for openings that leave nothing, or parts that meet at a node only.
    NotEnoughMemory
        For more elements than a system would fit for, before any memory is taken.

    Examples
    --------
    >>> mesh = sk.meshes.tensor(sk.Rectangle(1.0, 1.0), x=[0.0, 0.1, 0.4, 1.0], y=[0.0, 0.5, 1.0])
    >>> mesh.nelements
    6
    """
    surface = bounded(surface)
    x_bounds, y_bounds = surface.bounds
    x, y = node_row("x", x, x_bounds), node_row("y", y, y_bounds)
    rectangles = rectangles_of(openings)
    cells = (x.size - 1) * (y.size - 1)
    if len(rectangles):
        require_mesh(cells, MESH)
    else:
        require_mesh(cells)
    places = [(0, x[0]), (0, x[-1]), (1, y[0]), (1, y[-1])]
    closed = closed_directions(surface)
    mesh = skfem.MeshQuad.init_tensor(x, y)
    ends = mesh.p[:, mesh.facets]
    mesh = mesh.with_boundaries(
        {
            name: np.flatnonzero((ends[direction] == at).all(axis=0))
            for name, (direction, at) in zip(surface.sides, places, strict=True)
            if not closed[direction]
        }
    )
    return cut(mesh, x, y, rectangles, closed)


def node_row(name: str, values: Any, bounds: Interval) -> np.ndarray:
    """``values`` as node positions that increase from bound to bound; the ends are set exactly."""
    row = finite(name, values).copy()
    low, high = bounds
    if row.ndim != 1 or row.size < 2:
        raise InputError(f"{name} has shape {row.shape}: give a row of at least two node positions")
    steps = np.diff(row)
    if not (steps > 0).all():
        worst = int(np.argmin(steps))
        raise InputError(
            f"{name}[{worst}] = {row[worst]}, {name}[{worst + 1}] = {row[worst + 1]}: "
            "node positions must increase; sort them and drop repeated ones"
        )
    if np.abs(row[[0, -1]] - [low, high]).max() > ONE_PLACE * (high - low):
        raise InputError(
            f"{name} runs from {row[0]} to {row[-1]}: it must cover the bounds ({low}, {high}) "
            "of the surface; put the first and the last node there"
        )
    row[[0, -1]] = low, high
    return row


def bounds_of(surface: Surface) -> tuple[Interval, Interval]:
    """``surface.bounds``, or an InputError."""
    return bounded(surface).bounds


def bounded(surface: Surface) -> BoundedSurface:
    """``surface``, or an :class:`InputError` that says what to do instead."""
    require_surface(surface, ())
    if isinstance(surface, type) or not hasattr(surface, "bounds") or not hasattr(surface, "sides"):
        raise InputError(
            f"surface = {shown(surface)}: it has no bounds to mesh; use a surface over a rectangle "
            "of the parameter plane, or bring a MeshQuad of your own"
        )
    one, two = (high - low for low, high in surface.bounds)
    if max(one, two) > LONGEST * min(one, two):
        raise InputError(f"surface = {shown(surface)}: its parameters span {one:.6g} by {two:.6g}, and elements of a length "
                         f"over {LONGEST:g} times their width have no area in floating-point numbers")  # fmt: skip
    return cast("BoundedSurface", surface)
