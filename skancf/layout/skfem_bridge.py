r"""From the unknowns of a system to a basis of scikit-fem, and back by the transpose.

A basis knows no hanging nodes, seams and poles: it has twelve degrees of freedom at every node of the mesh. They are linear
in the unknowns, :math:`p = T q`, and a form's force f and stiffness K on the basis are :math:`T^T f` and :math:`T^T K T` on
the unknowns.
"""

from typing import Any

import scipy.sparse as sp
import skfem

from skancf.arguments import whole
from skancf.elements import ElementQuadANCF, ElementQuadHermite, through_thickness
from skancf.errors import InputError
from skancf.kernels.constants import AXES
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout

DEPTHS = 3
"""Gauss points through the thickness, exact for the strains of a flat plate."""


def basis_on(geometry: Geometry, intorder: int, facets: Any, thickness: float | None) -> skfem.AbstractBasis:
    """A basis of scikit-fem on the mesh with the theory's element, for forms of one's own.

    It has the position, its derivatives ``grad`` with respect to x and y, and in theory `kirchhoff` ``hess``.

    Parameters
    ----------
    intorder : int
        Order of the polynomials in x and in y that the quadrature integrates exactly; 7 is that of the library's own.
    facets
        A place on the boundary, such as ``"left"``: the basis is one of these edges.
    thickness : float, optional
        In theory `full`: the basis is one of the volume, of :math:`r + z d`, and ``grad`` has the derivative with respect
        to z, too.

    Raises
    ------
    InputError
        For an order that is no whole number, a place without an edge, and a thickness where there is no depth.
    """
    intorder = whole("intorder", intorder, most=127)
    directors, mesh = geometry.theory.directors, geometry.mesh
    element = skfem.ElementVector(ElementQuadANCF() if directors else ElementQuadHermite(), 3)
    if thickness is None:
        if facets is None:
            return skfem.Basis(mesh, element, intorder=intorder)
        return skfem.FacetBasis(mesh, element, intorder=intorder, facets=geometry.facets_on(facets))
    if not directors:
        raise InputError(f"thickness={thickness!r}: the element of theory 'kirchhoff' has no director and no depth; leave "
                         "thickness out, or take theory 'full'")  # fmt: skip
    if facets is not None:
        raise InputError("basis with facets and a thickness: edges have no depth here; give one of the two")
    return skfem.Basis(mesh, element, **through_thickness(mesh, thickness, intorder // 2 + 1, DEPTHS))


def unknowns_to_mesh(geometry: Geometry, layout: Layout, part: str) -> sp.csr_matrix:
    """T: see :attr:`skancf.system.System.to_mesh`; the twelve at a node are in the order of the basis' own."""
    of_part = sp.kron(geometry.of_nodes.matrix, sp.eye(AXES), format="coo")
    shape = (of_part.shape[0], layout.n_dofs)
    return sp.csr_matrix((of_part.data, (of_part.row, of_part.col + layout.dofs(part).start)), shape=shape)
