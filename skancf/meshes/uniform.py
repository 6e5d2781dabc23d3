"""Uniform meshes."""

from collections.abc import Sequence

import numpy as np
import skfem

from skancf.arguments import whole
from skancf.memory import MESH, require_mesh
from skancf.meshes.openings import Opening, rectangles_of
from skancf.meshes.tensor import bounds_of, tensor
from skancf.surfaces import Surface


def uniform(surface: Surface, nx: int, ny: int, openings: Sequence[Opening] = ()) -> skfem.MeshQuad:
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
    NotEnoughMemory
        For more elements than a system would fit for, before any memory is taken.

    Examples
    --------
    >>> plate = sk.Rectangle(2.0, 1.0)
    >>> mesh = sk.meshes.uniform(plate, 4, 2)
    >>> mesh.nelements, sorted(mesh.boundaries)
    (8, ['bottom', 'left', 'right', 'top'])
    """
    nx, ny = whole("nx", nx), whole("ny", ny)
    x_bounds, y_bounds = bounds_of(surface)
    # Before the rows of nodes; with openings some of the elements are cut out, and those that are left are looked at later.
    if not len(rectangles_of(openings)):
        require_mesh(nx * ny)
    else:
        require_mesh(nx * ny, MESH)
    return tensor(surface, np.linspace(*x_bounds, nx + 1), np.linspace(*y_bounds, ny + 1), openings)
