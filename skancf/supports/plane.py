"""Does an edge lie in a plane of symmetry?"""

from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.layout.geometry import Geometry
from skancf.surfaces import normal
from skancf.tolerances import ONE_DIRECTION
from skancf.vectors import cross

# Cosine of the angle by which the planes of two edges differ at least where they meet in a corner, 30 degrees.
CORNER = 0.87


def check_planes(geometry: Geometry, where: Any) -> None:
    """InputError unless the tangent and the normal of the surface stay in one plane along connected edges of a place.

    So the direction out of the plane, tangent x normal, is the same along each edge and where two meet, except in a corner.
    """
    _, facets = geometry.points_and_facets(where)
    if not len(facets):
        raise InputError(f"Symmetry({where!r}): a plane of symmetry needs an edge, not a point")
    ends = geometry.mesh.facets[:, facets]
    out = _conormals(geometry, ends)
    crooked = np.linalg.norm(out - out[:, :, :1], axis=0).max(axis=1) > ONE_DIRECTION
    if crooked.any():
        raise _in_no_plane(geometry, where, ends[:, np.argmax(crooked)])
    at_ends = out[:, :, [0, -1]].reshape(3, -1).T
    nodes = ends.T.ravel()
    for node in np.flatnonzero(np.bincount(nodes, minlength=1) > 1):
        met = at_ends[nodes == node]
        cosines = np.abs(met @ met[0])
        if ((cosines > CORNER) & (np.linalg.norm(cross(met.T, met[0]), axis=0) > ONE_DIRECTION)).any():
            raise _in_no_plane(geometry, where, np.array([node]))


def _conormals(geometry: Geometry, ends: np.ndarray) -> np.ndarray:
    """Unit vectors tangent x normal at five places along each edge, (3, m, 5)."""
    start, end = geometry.mesh.p[:, ends].swapaxes(0, 1)
    along = end - start
    at = start[:, :, None] + along[:, :, None] * np.linspace(0, 1, 5)
    tangent = np.einsum("dm,dimn->imn", along, np.stack(geometry.surface.derivatives(*at)))
    out = cross(tangent, normal(geometry.surface, *at))
    return np.asarray(out / np.linalg.norm(out, axis=0))


def _in_no_plane(geometry: Geometry, where: Any, nodes: np.ndarray) -> InputError:
    place = ", ".join(f"{v:.4g}" for v in geometry.surface.position(*geometry.mesh.p[:, nodes]).mean(axis=1))
    return InputError(
        f"Symmetry({where!r}): near ({place}) the edge lies in no plane of symmetry, its direction or the surface's normal "
        "turns out of it; take an edge that does, and a support of its own for each plane"
    )
