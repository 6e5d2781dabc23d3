r"""Transverse shear of layered sections: its stress by equilibrium, and the stiffness that has its energy.

In cylindrical bending along direction 1 the stresses of lamination theory grow with the moment, :math:`M_{11,1} = Q_1`, and
equilibrium of what lies below a height gives the shear stress there; so along direction 2. With
:math:`(\varepsilon, \kappa) = F M` from the inverse of the section's stiffness,

.. math::
    \begin{bmatrix} \tau_{13} \\ \tau_{23} \end{bmatrix}(z) = -\int_{bottom}^z \Bigl( \begin{bmatrix} Q_{11} \\ Q_{12}
    \end{bmatrix} (\varepsilon + z \kappa)_{,1} + \begin{bmatrix} Q_{12} \\ Q_{22} \end{bmatrix} (\varepsilon + z
    \kappa)_{,2} \Bigr) dz = s(z) \begin{bmatrix} Q_1 \\ Q_2 \end{bmatrix}, \qquad K = \Bigl( \int s^T G^{-1} s \, dz
    \Bigr)^{-1},

where :math:`Q_{ab}` are rows of the layers' stiffness in the plane. A shear stress that is free at both faces follows, whose
integral is the shear force, and of one layer :math:`K = \tfrac56 G t`.

References
----------
J. M. Whitney, Shear correction factors for orthotropic laminates under static load, J. Appl. Mech. 40 (1973) 302-304.
K. Rohwer, Improved transverse shear stiffness for layered finite elements, DFVLR-FB 88-32 (1988): the two cylindrical
bendings.
"""

from dataclasses import replace

import numpy as np

from skancf.elements.quad_ancf import gauss
from skancf.materials.law import SHEAR_CORRECTION
from skancf.materials.section import SHEAR, Section

ALONG, ACROSS = [0, 2], [2, 1]
"""Rows of the stresses 11, 22, 12 whose growth along 1 and along 2 the shear stresses 13 and 23 balance."""


def shear_stresses(section: Section, n: int) -> np.ndarray:
    """Shear stresses 13 and 23 per unit of shear forces Q1 and Q2 at n Gauss points of each layer: (n_layers, n, 2, 2)
    (1/m)."""
    section = section.about(section.neutral)  # of a section far off, bending is a small difference
    grown = np.linalg.inv(section.abd())[:, [3, 4]]
    strain, curvature = grown[:3], grown[3:]
    low, t, s = section.z[:-1], section.thicknesses, gauss(n)[0]
    lengths = np.concatenate([s, [1.0]]) * t[:, None]
    # Integrals of 1 and z from the bottom of the layer to its points, and at last to its top.
    first = low[:, None] * lengths + lengths**2 / 2
    Q, shear = section.in_plane(), []
    for direction, rows in enumerate((ALONG, ACROSS)):
        of_strain, of_curvature = (np.einsum("lij,j->li", Q[:, rows], part[:, direction]) for part in (strain, curvature))
        inside = lengths[..., None] * of_strain[:, None] + first[..., None] * of_curvature[:, None]
        below = np.cumsum(inside[:, -1], axis=0) - inside[:, -1]
        shear.append(-(below[:, None] + inside[:, :-1]))
    return np.stack(shear, axis=-1)


def equilibrium_stiffness(section: Section) -> np.ndarray:
    """Transverse shear stiffness for 13 and 23 whose energy is that of :func:`shear_stresses`, (2, 2) (N/m).

    The laws hold their shear correction factor k, which here counts as far as it is not that of one homogeneous layer, 5/6:
    G is :math:`k G / \\tfrac56`.
    """
    modulus = section.stiffness[:, SHEAR][:, :, SHEAR] / SHEAR_CORRECTION
    s, w = shear_stresses(section, 3), gauss(3)[1]
    weights = section.thicknesses[:, None, None, None] * w[:, None, None]
    compliance = (s.swapaxes(2, 3) @ np.linalg.inv(modulus)[:, None] @ s * weights).sum(axis=(0, 1))
    return np.asarray(np.linalg.inv((compliance + compliance.T) / 2))


def with_shear_of_equilibrium(section: Section) -> Section:
    r"""The section with laws whose sum is the shear stiffness K of equilibrium; the stiffness in the plane stays.

    A shear strain that is constant through the thickness has the energy of :math:`S = \sum k G t`. The shear rows and
    columns of all layers are multiplied by the symmetric J with :math:`J S J = K`; one matrix for both directions and all
    layers, so that the frame does not matter and laws stay positive definite.
    """
    if (section.stiffness == section.stiffness[0]).all():
        return section
    S, K = section.shear_stiffness(), equilibrium_stiffness(section)
    root = _root(S)
    inverse = np.linalg.inv(root)
    factor = np.eye(6)
    factor[np.ix_(SHEAR, SHEAR)] = inverse @ _root(root @ K @ root) @ inverse
    return replace(section, stiffness=factor @ section.stiffness @ factor)


def _root(matrix: np.ndarray) -> np.ndarray:
    """The symmetric root of a symmetric positive definite matrix."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray(vectors * np.sqrt(values) @ vectors.T)
