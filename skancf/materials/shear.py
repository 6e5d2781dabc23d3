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
from skancf.errors import warn
from skancf.materials.law import SHEAR_CORRECTION
from skancf.materials.section import SHEAR, Section, require_one

ALONE = 0.05
"""Error of the deflection by shear from which it is said that layers bend one by one."""
ALONG, ACROSS = [0, 2], [2, 1]
"""Rows of the stresses 11, 22, 12 whose growth along 1 and along 2 the shear stresses 13 and 23 balance."""


def shear_stresses(section: Section, s: np.ndarray) -> np.ndarray:
    """Shear stresses 13 and 23 per unit of shear forces Q1 and Q2 at parts s (n,) of the height of each layer.

    From 0 to 1, at its bottom and at its top: (n_layers, n, 2, 2) (1/m).
    """
    section = section.about(section.neutral)  # of a section far off, bending is a small difference
    grown = np.linalg.inv(section.abd())[:, [3, 4]]
    strain, curvature = grown[:3], grown[3:]
    low, lengths = section.z[:-1], np.append(s, 1.0) * section.thicknesses[:, None]
    # Integrals of 1 and z from the bottom of the layer to its points, and at last to its top.
    first = low[:, None] * lengths + lengths**2 / 2
    Q, shear = section.in_plane(), []
    for direction, rows in enumerate((ALONG, ACROSS)):
        of_strain, of_curvature = (np.einsum("lij,j->li", Q[:, rows], part[:, direction]) for part in (strain, curvature))
        inside = lengths[..., None] * of_strain[:, None] + first[..., None] * of_curvature[:, None]
        below = np.cumsum(inside[:, -1], axis=0) - inside[:, -1]
        shear.append(-(below[:, None] + inside[:, :-1]))
    return np.stack(shear, axis=-1)


def shear_stress_at(section: Section, z: float) -> np.ndarray:
    """Shear stresses 13 and 23 at a height per unit of the shear forces Q1 and Q2, in equilibrium: (2, 2) (1/m).

    With the shear forces of :meth:`skancf.Solution.shear_forces`, theory `kirchhoff`, it gives the interlaminar shear stress
    at an interface and the shear stress in a layer. The product is right where M11 grows along 1 and M22 along 2; what the
    twisting moment and the other two derivatives add is left out.

    Raises
    ------
    InputError
        For a height outside the faces.

    Examples
    --------
    >>> tau = shear_stress_at(laminate.section(), 0.25e-3) @ solution.shear_forces()[0, :, 0]
    """
    require_one(section)
    layer = int(section.layer_at(z))
    part = np.clip((z - section.z[layer]) / section.thicknesses[layer], 0.0, 1.0)
    return np.asarray(shear_stresses(section, np.array([part]))[layer, 0])


def equilibrium_stiffness(section: Section) -> np.ndarray:
    """Transverse shear stiffness for 13 and 23 whose energy is that of :func:`shear_stresses`, (2, 2) (N/m).

    The laws hold their shear correction factor k, which here counts as far as it is not that of one homogeneous layer, 5/6:
    G is :math:`k G / \\tfrac56`.
    """
    modulus = section.stiffness[:, SHEAR][:, :, SHEAR] / SHEAR_CORRECTION
    points, w = gauss(3)
    s = shear_stresses(section, points)
    weights = section.thicknesses[:, None, None, None] * w[:, None, None]
    compliance = (s.swapaxes(2, 3) @ np.linalg.inv(modulus)[:, None] @ s * weights).sum(axis=(0, 1))
    return np.asarray(np.linalg.inv((compliance + compliance.T) / 2))


def warping_length(section: Section) -> float:
    r"""How short waves are for the layers to bend one by one: their error over the shear deflection is
    :math:`(\pi \ell / a)^2` with the half wave a (m).

    Shear strains :math:`G^{-1} s` shift the layers by u(z), per unit of the shear force. Normals that stay straight have the
    part that is linear in z, and the rest strains the layers:

    .. math:: \ell^2 = K \int u_\perp Q_{aa} u_\perp \, dz,

    the larger one of both directions. Of a sandwich it is the root of the faces' own bending stiffness over K.
    """
    section, n = section.about(section.neutral), 4
    s, weights = gauss(n)
    z, w, layer = section.points(n)
    Q, t, K = section.in_plane()[layer], section.thicknesses, section.shear_stiffness()
    modulus = section.stiffness[:, SHEAR][:, :, SHEAR] / SHEAR_CORRECTION
    # The laws of a laminate are scaled by their ratio.
    scaled = np.diag(equilibrium_stiffness(section)) / np.diag(K)
    strain = np.linalg.solve(modulus[:, None], shear_stresses(section, s)) * scaled
    # Antiderivatives at the points of the polynomial through them, and over the whole layer.
    powers, degree = s[:, None] ** np.arange(n), np.arange(1, n + 1)
    inside = np.linalg.solve(powers.T, (s[:, None] ** degree / degree).T).T
    whole = np.einsum("p,lpij->lij", weights, strain) * t[:, None, None]
    below = np.cumsum(whole, axis=0) - whole
    shift = below[:, None] + np.einsum("qp,lpij->lqij", inside, strain) * t[:, None, None, None]
    squares = []
    for a in (0, 1):
        u, stiff = shift[..., a, a].ravel(), w * Q[:, a, a]
        line = np.stack([np.ones_like(z), z])
        rest = u - np.linalg.solve(line * stiff @ line.T, line * stiff @ u) @ line
        squares.append(K[a, a] * (stiff * rest**2).sum())
    return float(np.sqrt(max(squares)))


def warn_if_layers_bend_alone(section: Section, reach: float) -> None:
    """A warning where layers bend one by one, which no straight normal can, in waves as long as the body (m)."""
    if (section.stiffness == section.stiffness[0]).all():
        return
    share = (np.pi * warping_length(section) / reach) ** 2
    if share > ALONE:
        warn(
            "theory 'full' keeps normals straight, but layers as unlike as those of this section bend one by one: its "
            f"deflection by shear is too large by about {100 * share:.2g} % of itself (over {100 * ALONE:g} %) in waves as "
            f"long as the body, {reach:.3g} m, and by more in shorter ones. That is for a solid model, or a stiffer core"
        )


def with_shear_of_equilibrium(section: Section) -> Section:
    r"""The section with laws whose sum is the shear stiffness K of equilibrium; the stiffness in the plane stays.

    A shear strain that is constant through the thickness has the energy of :math:`S = \sum k G t`. The shear rows and
    columns of all layers are multiplied by the symmetric J with :math:`J S J = K`; one matrix for both directions and all
    layers, so that laws stay positive definite. K itself is that of cylindrical bending along the axes of the surface: of
    layers with fibres along several directions it is no tensor, and another frame has another one, by some per cent.
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
