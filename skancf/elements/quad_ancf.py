"""The fully parameterised ANCF plate as a scikit-fem element, and the tools to integrate it through the thickness."""

from functools import cache
from typing import Any

import numpy as np
import skfem
from skfem.element import DiscreteField

from skancf.arguments import MESH, instance, whole
from skancf.elements.nodal import QuadWithSlopes
from skancf.elements.reference import ancf_functions
from skancf.errors import positive


class ElementQuadANCF(QuadWithSlopes):
    r"""Fully parameterised ANCF plate: r, r_x, r_y and r_z at each node of a 2D ``MeshQuad``; 16 functions.

    Local points may have a third row, the distance z from the mid-surface (a length); values are then those of
    :math:`\mathbf r(x, y) + z\,\mathbf d(x, y)` and gradients have three rows. Without it z = 0 and gradients have two.

    Works on aligned rectangles of any corner numbering and on general quads, where the slopes at a node become
    :math:`r_{,\xi} = r_{,x} x_{,\xi} + r_{,y} y_{,\xi}`.

    Examples
    --------
    >>> import skfem
    >>> mesh = skfem.MeshQuad().refined(1)
    >>> basis = skfem.Basis(
    ...     mesh, skfem.ElementVector(sk.ElementQuadANCF(), 3), **sk.through_thickness(mesh, 0.05)
    ... )
    >>> print(basis.N)
    108
    """

    maxdeg = 4
    dofnames = ("u", "u_x", "u_y", "u_z")
    functions = staticmethod(ancf_functions)

    def gbasis(self, mapping: Any, X: np.ndarray, i: int, tind: np.ndarray | None = None) -> tuple[DiscreteField]:
        function, _ = self.derivatives_of(mapping.mesh, X, i, tind)
        kind = i % 4
        inverse = mapping.invDF(X, tind=tind)
        value = function(0, 0)
        grad = np.einsum("ji...,j...->i...", inverse, np.stack([function(1, 0), function(0, 1)]))
        z = (X[2] if X[2].ndim == 2 else X[2][None, :]) if len(X) == 3 else 0.0
        normal_slope = value if kind == 3 else np.zeros_like(value)
        if kind == 3:
            value, grad = z * value, z * grad
        if len(X) == 3:
            grad = np.concatenate([grad, normal_slope[None]])
        return (DiscreteField(value=value, grad=grad),)


class MappingPlate(skfem.MappingIsoparametric):
    """The mesh's own mapping for local points (xi, eta, z); z is a length and goes through unchanged."""

    def __init__(self, mesh: skfem.MeshQuad):
        super().__init__(mesh, skfem.ElementQuad1())

    def F(self, X: np.ndarray, tind: np.ndarray | None = None) -> np.ndarray:
        plane = super().F(X[:2], tind)
        return np.concatenate([plane, [np.broadcast_to(z, plane.shape[1:]) for z in X[2:]]]) if len(X) > 2 else plane

    def J(self, i: int, j: int, X: np.ndarray, tind: np.ndarray | None = None) -> np.ndarray:
        return super().J(i, j, X[:2], tind)


_leggauss = cache(np.polynomial.legendre.leggauss)


def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights on [0, 1]."""
    points, weights = _leggauss(n)
    return (points + 1) / 2, weights / 2


def square_quadrature(n: int) -> tuple[np.ndarray, np.ndarray]:
    """n x n Gauss points of the reference square, (2, n n) with eta running fastest, and weights (n n,)."""
    s, w = gauss(n)
    return np.stack([np.repeat(s, n), np.tile(s, n)]), np.outer(w, w).ravel()


def through_thickness(mesh: skfem.MeshQuad, thickness: float, n: int = 4, n_z: int = 2) -> dict[str, Any]:
    """Keyword arguments for ``skfem.Basis`` that integrate over the volume of the plate.

    Parameters
    ----------
    mesh
        Mesh of the mid-plane.
    thickness
        A length.
    n, n_z
        Gauss points along each side and through the thickness, at most 64.

    Raises
    ------
    InputError
        For what is no mesh, a thickness that is not positive, and numbers of points that are no whole ones.

    Examples
    --------
    >>> mesh = sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 2, 2)
    >>> print(sorted(sk.through_thickness(mesh, 0.01)))
    ['mapping', 'quadrature']
    """
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    thickness, n, n_z = positive("thickness", thickness), whole("n", n, most=64), whole("n_z", n_z, most=64)
    plane, plane_weights = square_quadrature(n)
    s, w = gauss(n_z)
    z = np.tile((s - 0.5) * thickness, plane.shape[1])
    points = np.vstack([np.repeat(plane, n_z, axis=1), z])
    weights = np.outer(plane_weights, w * thickness).ravel()
    return {"mapping": MappingPlate(mesh), "quadrature": (points, weights)}
