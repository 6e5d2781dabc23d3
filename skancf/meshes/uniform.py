"""Uniform meshes."""

from collections.abc import Sequence

import numpy as np
import skfem

from skancf.meshes.openings import Opening
from skancf.meshes.tensor import bounds_of, tensor, whole
from skancf.surfaces import BoundedSurface


def uniform(surface: BoundedSurface, nx: int, ny: int, openings: Sequence[Opening] = ()) -> skfem.MeshQuad:
    """``nx`` by ``ny`` equal rectangles over ``surface.bounds``, with the boundaries named by ``surface.sides``.

    Equal in the parameter plane: on a sector of an annulus, equal steps of the radius and of the central angle.

    Parameters
    ----------
    surface : BoundedSurface
    nx, ny : int
    openings : sequence of ((x0, x1), (y0, y1))
        Rectangles without elements, with sides on mesh lines; see :func:`tensor`.

    Raises
    ------
    InputError
        For counts that are not whole numbers of at least 1, for a surface without bounds, and for openings that
        :func:`tensor` cannot cut.

    Examples
    --------
    An L-shaped plate, whose re-entrant edges are the boundary ``"opening"``:

    >>> plate = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
    >>> mesh = sk.meshes.uniform(plate, 8, 8, openings=[((0.0, 1.0), (0.0, 1.0))])
    """
    nx, ny = whole("nx", nx), whole("ny", ny)
    x_bounds, y_bounds = bounds_of(surface)
    return tensor(surface, np.linspace(*x_bounds, nx + 1), np.linspace(*y_bounds, ny + 1), openings)
