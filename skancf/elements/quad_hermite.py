"""The bicubic Hermite rectangle as a scikit-fem element."""

from typing import Any

import numpy as np
import skfem
from skfem.element import DiscreteField

from skancf.elements.nodal import nodal_jacobian, require_aligned
from skancf.elements.reference import CORNERS, hermite_functions


class ElementQuadHermite(skfem.Element):
    r"""Bicubic Hermite rectangle (Bogner, Fox and Schmit): u, u_x, u_y and u_xy at each node; 16 functions, C1.

    The functions live on the reference square and are multiplied by powers of the side lengths, so that small elements
    far from the origin lose no digits; ``skfem.ElementQuadBFS`` inverts monomials of the global coordinates and does.
    Any corner numbering. Elements must be aligned rectangles.

    Raises
    ------
    InputError
        For a mesh with an element that is no aligned rectangle; the message names it.
    """

    nodal_dofs = 4
    maxdeg = 6
    dofnames = ("u", "u_x", "u_y", "u_xy")
    doflocs = np.repeat(CORNERS, 4, axis=0)
    refdom = skfem.refdom.RefQuad

    def gbasis(
        self, mapping: Any, X: np.ndarray, i: int, tind: np.ndarray | None = None
    ) -> tuple[DiscreteField]:
        if not 0 <= i < 16:
            self._index_error()
        require_aligned(mapping.mesh)
        corner, kind = divmod(i, 4)
        jacobian = nodal_jacobian(mapping.mesh, tind)[:, :, corner, :, None]
        xi, eta = (row if row.ndim == 2 else row[None, :] for row in X[:2])

        def function(m: int, n: int) -> np.ndarray:
            local = hermite_functions(xi, eta, (m, n))[corner]
            if kind in (1, 2):
                return jacobian[kind - 1, 0] * local[1] + jacobian[kind - 1, 1] * local[2]
            twist = jacobian[0, 0] * jacobian[1, 1] + jacobian[0, 1] * jacobian[1, 0]
            return local[kind] * (twist if kind == 3 else 1 + 0 * twist)

        inverse = mapping.invDF(X, tind=tind)
        grad = np.stack([function(1, 0), function(0, 1)])
        hess = np.stack([[function(2, 0), function(1, 1)], [function(1, 1), function(0, 2)]])
        return (
            DiscreteField(
                value=function(0, 0),
                grad=np.einsum("ji...,j...->i...", inverse, grad),
                hess=np.einsum("ki...,kl...,lj...->ij...", inverse, hess, inverse),
            ),
        )
