"""Local frames of the undeformed surface, and how far the material has turned."""

import numpy as np

from skancf.system.system import System


def frames(system: System, points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Local frames at points (2, n) of elements (m,), in which stresses and section forces have their components.

    Columns e1, e2, e3 of (m, n, 3, 3): e3 the normal of the undeformed surface, e1 along the parameter x.
    """
    geometry = system.geometry
    bases = geometry.theory.bases(geometry.undeformed_local[elements], points, geometry.side[elements], 0.0)
    normal = np.cross(bases[..., 0], bases[..., 1])
    normal = normal * np.sign((normal * bases[..., 2]).sum(axis=-1, keepdims=True))
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    first = np.moveaxis(geometry.tangents(points, elements), 0, -1)
    first = first - normal * (normal * first).sum(axis=-1, keepdims=True)
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=-1)


def turns(system: System, q: np.ndarray, points: np.ndarray, elements: np.ndarray, z: np.ndarray | float) -> np.ndarray:
    r"""Rotations R of the polar decompositions :math:`F = R U` of the deformation gradient at heights z: (m, n, 3, 3).

    F takes the tangent vectors at z and the normal (director) of the undeformed state to those of the state q.
    """
    geometry = system.geometry
    place = (points, geometry.side[elements], z)
    before = geometry.theory.bases(geometry.undeformed_local[elements], *place)
    now = geometry.theory.bases(geometry.local(system.shell.nodal(q), elements), *place)
    left, _, right = np.linalg.svd(now @ np.linalg.inv(before))
    return np.asarray(left @ right)
