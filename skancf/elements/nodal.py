"""Elements with slopes at their nodes, and the bilinear map of each quad at its corners, which makes them local ones."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
import skfem

from skancf.elements.reference import CORNERS
from skancf.errors import InputError
from skancf.tolerances import ONE_PLACE


def nodal_jacobian(mesh: skfem.MeshQuad, elements: np.ndarray | None = None) -> np.ndarray:
    r"""Derivatives of the bilinear map of each quad at its own corners.

    Returns
    -------
    (2, 2, 4, n_elements) array
        Entry [i, j] is :math:`\partial x_i / \partial \xi_j`; the third axis is the corner.
    """
    corner = mesh.p[:, mesh.t if elements is None else mesh.t[:, elements]]
    along_xi = np.stack([corner[:, 1] - corner[:, 0]] * 2 + [corner[:, 2] - corner[:, 3]] * 2, axis=1)
    along_eta = np.stack([corner[:, 3] - corner[:, 0], corner[:, 2] - corner[:, 1]] * 2, axis=1)[:, [0, 1, 3, 2]]
    return np.stack([along_xi, along_eta], axis=1)


def askew(mesh: skfem.MeshQuad) -> np.ndarray:
    """Quads with a side that is not parallel to an axis of the parameter plane, (n_elements,) bool."""
    corner = mesh.p[:, mesh.t]
    sides = np.abs(np.roll(corner, -1, axis=1) - corner) / np.ptp(corner, axis=1, keepdims=True)
    return np.asarray((sides.min(axis=0) > ONE_PLACE).any(axis=0))


def require_aligned(mesh: skfem.MeshQuad, what: str = "the bicubic element", way_out: str = "or take theory 'full'") -> None:
    """InputError for a quad whose sides are not parallel to the axes of the parameter plane."""
    wrong = np.flatnonzero(askew(mesh))
    if wrong.size:
        corners = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in mesh.p[:, mesh.t[:, wrong[0]]].T)
        raise InputError(
            f"{wrong.size} of {mesh.t.shape[1]} elements are no aligned rectangles (first: element {wrong[0]} with corners "
            f"{corners}): {what} needs sides along x and y; put the shape into the surface X(x, y), not into "
            f"the mesh, {way_out}"
        )


class QuadWithSlopes(skfem.Element):
    """A quad with a value, two slopes and a fourth vector at each node, whose functions live on the reference square."""

    nodal_dofs = 4
    doflocs = np.repeat(CORNERS, 4, axis=0)
    refdom = skfem.refdom.RefQuad
    functions: ClassVar[Callable[..., np.ndarray]]
    """Local functions and their derivatives: (xi, eta, order) to (corner, kind, ...)."""

    def derivatives_of(
        self, mesh: skfem.MeshQuad, X: np.ndarray, i: int, tind: np.ndarray | None
    ) -> tuple[Callable[[int, int], np.ndarray], np.ndarray]:
        """The i-th function as (order in xi, order in eta) to values (n_elements, n), and the Jacobian at its corner.

        A slope's function is made of the two local ones, r_xi = r_x x_xi + r_y y_xi; the fourth is taken as it is.
        """
        if not 0 <= i < 16:
            self._index_error()
        corner, kind = divmod(i, 4)
        jacobian = nodal_jacobian(mesh, tind)[:, :, corner, :, None]
        xi, eta = (row if row.ndim == 2 else row[None, :] for row in X[:2])

        def function(m: int, n: int) -> np.ndarray:
            local = self.functions(xi, eta, (m, n))[corner]
            if kind in (1, 2):
                return np.asarray(jacobian[kind - 1, 0] * local[1] + jacobian[kind - 1, 1] * local[2])
            return np.asarray(local[kind] + 0 * jacobian[0, 0])

        return function, jacobian
