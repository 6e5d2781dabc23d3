"""The bilinear map of each quad at its own corners, which turns nodal slopes into local ones."""

import numpy as np
import skfem

from skancf.errors import InputError

# Sides of an aligned rectangle are parallel to the axes up to the rounding of coordinates.
ALIGNED = 1e-9


def nodal_jacobian(mesh: skfem.MeshQuad, elements: np.ndarray | None = None) -> np.ndarray:
    r"""Derivatives of the bilinear map of each quad at its own corners.

    Returns
    -------
    (2, 2, 4, n_elements) array
        Entry [i, j] is :math:`\partial x_i / \partial \xi_j`; the third axis is the corner.
    """
    corner = mesh.p[:, mesh.t if elements is None else mesh.t[:, elements]]
    along_xi = np.stack([corner[:, 1] - corner[:, 0]] * 2 + [corner[:, 2] - corner[:, 3]] * 2, axis=1)
    along_eta = np.stack(
        [corner[:, 3] - corner[:, 0], corner[:, 2] - corner[:, 1]] * 2, axis=1
    )[:, [0, 1, 3, 2]]
    return np.stack([along_xi, along_eta], axis=1)


def require_aligned(mesh: skfem.MeshQuad) -> None:
    """InputError for a quad whose sides are not parallel to the axes of the parameter plane."""
    sides = np.abs(np.roll(mesh.p[:, mesh.t], -1, axis=1) - mesh.p[:, mesh.t])
    askew = np.flatnonzero((sides.min(axis=0) > ALIGNED * sides.max(axis=0)).any(axis=0))
    if askew.size:
        corners = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in mesh.p[:, mesh.t[:, askew[0]]].T)
        raise InputError(
            f"{askew.size} of {mesh.t.shape[1]} elements are no aligned rectangles (first: element {askew[0]} with corners "
            f"{corners}): the bicubic element needs sides along x and y; put the shape into the surface X(x, y), not into "
            "the mesh, or take theory 'full'"
        )
