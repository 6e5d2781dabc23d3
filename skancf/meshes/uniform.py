"""Uniform meshes."""

import numpy as np
import skfem

from skancf.meshes.tensor import bounds_of, tensor, whole
from skancf.surfaces import BoundedSurface


def uniform(surface: BoundedSurface, nx: int, ny: int) -> skfem.MeshQuad:
    """``nx`` by ``ny`` equal rectangles over ``surface.bounds``, with the boundaries named by ``surface.sides``.

    Equal in the parameter plane: on a sector of an annulus, equal steps of the radius and of the central angle.

    Raises
    ------
    InputError
        For counts that are not whole numbers of at least 1, and for a surface without bounds.
    """
    nx, ny = whole("nx", nx), whole("ny", ny)
    x_bounds, y_bounds = bounds_of(surface)
    return tensor(surface, np.linspace(*x_bounds, nx + 1), np.linspace(*y_bounds, ny + 1))
