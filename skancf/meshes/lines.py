"""Meshes with lines where they are wanted."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import skfem

from skancf.arguments import row, whole
from skancf.errors import positive
from skancf.materials.zones import Zone, check_zones, lines_of
from skancf.memory import MESH, require_mesh
from skancf.meshes.openings import Opening, rectangles_of
from skancf.meshes.tensor import bounds_of, tensor
from skancf.surfaces import Interval, Surface, closed_bounds
from skancf.tolerances import ONE_PLACE


def with_lines(
    surface: Surface, nx: int, ny: int, zones: Sequence[Zone] = (), *, beside: float | None = None, x: Any = (),
    y: Any = (), openings: Sequence[Opening] = (),
) -> skfem.MeshQuad:  # fmt: skip
    """About ``nx`` by ``ny`` rectangles over ``surface.bounds``, with lines where zones end and at some coordinates.

    Between these lines steps are even, at least one, and as near to those of :func:`uniform` as whole numbers are. Quadtrees
    on this mesh keep its lines.

    Parameters
    ----------
    surface : BoundedSurface
    nx, ny : int
    zones : sequence of Zone
        Those of a problem; a rectangle has lines along its four sides, as far as it is in bounds.
    beside : float, optional
        In the parameters: more lines on both sides of those, at this distance. Where the membrane stiffness jumps, strains
        do too, and in theory `full` the slopes at a node do not: errors are those of the elements beside the line, in
        proportion to their size across it. A row that is half as wide as the plate is thick makes them small.
    x, y : sequences of float
        Coordinates of more lines.
    openings : sequence of ((x0, x1), (y0, y1))
        Rectangles without elements; their sides are lines too.

    Raises
    ------
    InputError
        For counts that are not whole numbers of at least 1, a width that is not positive, a surface without bounds, and
        zones that overlap.

    Examples
    --------
    >>> strip = sk.Rectangle(1.0, 0.1)
    >>> mesh = sk.meshes.with_lines(strip, 4, 1, x=[0.3])
    >>> print(np.unique(mesh.p[0]))
    [0.         0.3        0.53333333 0.76666667 1.        ]
    """
    zones, counts = check_zones(zones), (whole("nx", nx), whole("ny", ny))
    width = None if beside is None else positive("beside", beside)
    sides = rectangles_of(openings).reshape(-1, 2, 2)
    rows, closed = [], closed_bounds(surface)
    for axis, (name, more) in enumerate((("x", x), ("y", y))):
        low, high = bounds_of(surface)[axis]
        ends = lines_of(zones, axis, closed)
        thin = [] if width is None else _beside(ends, width, (low, high), axis in closed)
        held = [*ends, *thin, *row(name, more).tolist(), *sides[:, axis].ravel().tolist()]
        require_mesh(counts[axis], MESH)
        rows.append(row_through(low, high, counts[axis], held))
    return tensor(surface, rows[0], rows[1], openings)


def _beside(ends: Sequence[float], width: float, bounds: Interval, closed: bool) -> list[float]:
    """Coordinates at a distance from both sides of those ends that are inside, but no less from any."""
    low, high = bounds
    out = [end + side * width for end in ends if closed or low < end < high for side in (-1, 1)]
    if closed:
        out = [low + (at - low) % (high - low) for at in out]
    return [at for at in out if np.abs(np.subtract(ends, at)).min() > width * (1 - ONE_PLACE)]


def row_through(low: float, high: float, count: int, held: Sequence[float], wanted: Sequence[float] = ()) -> np.ndarray:
    """About ``count`` even steps that meet the coordinates ``held``, and those ``wanted`` where no sliver comes of it."""
    fixed = np.array([low, high])
    for points, least in ((held, ONE_PLACE * (high - low)), (wanted, (high - low) / count / 4)):
        for x in sorted(points):
            if low < x < high and np.abs(fixed - x).min() > least:
                fixed = np.sort(np.append(fixed, x))
    parts = np.maximum(1, np.round(count * np.diff(fixed) / (high - low)).astype(int))
    steps = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(fixed[:-1], fixed[1:], parts, strict=True)]
    return np.append(np.concatenate(steps), high)
