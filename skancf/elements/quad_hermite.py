"""The bicubic Hermite rectangle as a scikit-fem element."""

from typing import Any

import numpy as np
from skfem.element import DiscreteField

from skancf.elements.nodal import QuadWithSlopes, require_aligned
from skancf.elements.reference import hermite_functions


class ElementQuadHermite(QuadWithSlopes):
    r"""Bicubic Hermite rectangle (Bogner, Fox and Schmit): u, u_x, u_y and u_xy at each node; 16 functions, C1.

    The functions live on the reference square and are multiplied by powers of the side lengths, so that small elements
    far from the origin lose no digits; ``skfem.ElementQuadBFS`` inverts monomials of the global coordinates and does.
    Any corner numbering. Elements must be aligned rectangles.

    Raises
    ------
    InputError
        For a mesh with an element that is no aligned rectangle; the message names it.

    Examples
    --------
    >>> import skfem
    >>> mesh = skfem.MeshQuad().refined(1)
    >>> print(skfem.Basis(mesh, sk.ElementQuadHermite()).N)
    36
    """

    maxdeg = 6
    dofnames = ("u", "u_x", "u_y", "u_xy")
    functions = staticmethod(hermite_functions)

    def gbasis(self, mapping: Any, X: np.ndarray, i: int, tind: np.ndarray | None = None) -> tuple[DiscreteField]:
        require_aligned(mapping.mesh)
        function, jacobian = self.derivatives_of(mapping.mesh, X, i, tind)
        twist = jacobian[0, 0] * jacobian[1, 1] + jacobian[0, 1] * jacobian[1, 0] if i % 4 == 3 else 1.0
        inverse = mapping.invDF(X, tind=tind)
        grad = np.stack([function(1, 0), function(0, 1)])
        hess = np.stack([[function(2, 0), function(1, 1)], [function(1, 1), function(0, 2)]])
        return (
            DiscreteField(
                value=twist * function(0, 0),
                grad=twist * np.einsum("ji...,j...->i...", inverse, grad),
                hess=twist * np.einsum("ki...,kl...,lj...->ij...", inverse, hess, inverse),
            ),
        )
