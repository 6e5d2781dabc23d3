r"""Membrane strain and curvature change at a point, with gradient and second derivative in closed form.

The jet of a point is the five vectors :math:`r_{,1}, r_{,2}, r_{,11}, r_{,22}, r_{,12}`, derivatives with respect to the
reference square. With the unit normal :math:`n = r_{,1} \times r_{,2} / |r_{,1} \times r_{,2}|` the strains are

.. math::
    \varepsilon_{ab} = \tfrac12 (r_{,a} \cdot r_{,b} - R_{,a} \cdot R_{,b}), \qquad
    \kappa_{ab} = R_{,ab} \cdot N - r_{,ab} \cdot n,

so that the strain at the depth z is :math:`\varepsilon + z \kappa`. With the dual vectors :math:`a^\gamma` and the
Christoffel symbols :math:`\Gamma^\gamma_{ab} = r_{,ab} \cdot a^\gamma`,

.. math::
    \delta n = -a^\gamma (n \cdot \delta r_{,\gamma}), \qquad
    \delta \kappa_{ab} = -n \cdot (\delta r_{,ab} - \Gamma^\gamma_{ab} \delta r_{,\gamma}),

.. math::
    M^{ab} \delta^2 \kappa_{ab} = 2 (n \cdot \delta r_{,\gamma}) \, a^\gamma \cdot M^{ab} (\delta r_{,ab} -
    \Gamma^\lambda_{ab} \delta r_{,\lambda}) + M^{ab} b_{ab} a^{\gamma\lambda} (n \cdot \delta r_{,\gamma})
    (n \cdot \delta r_{,\lambda}).

All are scalar products of vectors that turn with the surface, so a rigid rotation changes nothing but rounding.
"""

import numpy as np

R1, R2, R11, R22, R12 = range(5)
N_STRAINS = 6
FIRST, SECOND = (R1, R2), (R11, R22, R12)
DOUBLED = (1.0, 1.0, 2.0)
"""Factor of the components 11, 22, 12 in a sum over a and b, and of the shear entries of the strains."""


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner product over the first axis."""
    return np.asarray((a * b).sum(axis=0))


def unit_normal(jet: np.ndarray) -> np.ndarray:
    """n, shape (3, ...)."""
    n = np.cross(jet[R1], jet[R2], axis=0)
    return np.asarray(n / np.sqrt(dot(n, n)))


def dual(jet: np.ndarray) -> np.ndarray:
    """Dual vectors of r_1 and r_2 in the tangent plane: (2, 3, ...)."""
    a11, a22, a12 = dot(jet[R1], jet[R1]), dot(jet[R2], jet[R2]), dot(jet[R1], jet[R2])
    det = a11 * a22 - a12 * a12
    return np.stack([a22 * jet[R1] - a12 * jet[R2], a11 * jet[R2] - a12 * jet[R1]]) / det


def strain(jet: np.ndarray) -> np.ndarray:
    r"""The strains before those of the undeformed state are subtracted.

    Parameters
    ----------
    jet : (5, 3, ...) array

    Returns
    -------
    (6, ...) array
        :math:`\tfrac12 r_{,1} \cdot r_{,1}, \tfrac12 r_{,2} \cdot r_{,2}, r_{,1} \cdot r_{,2}` and
        :math:`-r_{,11} \cdot n, -r_{,22} \cdot n, -2 r_{,12} \cdot n`.
    """
    n = unit_normal(jet)
    membrane = [0.5 * dot(jet[R1], jet[R1]), 0.5 * dot(jet[R2], jet[R2]), dot(jet[R1], jet[R2])]
    return np.stack(membrane + [-c * dot(jet[k], n) for k, c in zip(SECOND, DOUBLED, strict=True)])


def gradient(jet: np.ndarray) -> np.ndarray:
    """Derivative of the strains with respect to the jet: (6, 5, 3, ...)."""
    n, duals = unit_normal(jet), dual(jet)
    out = np.zeros((N_STRAINS, *jet.shape))
    out[0, R1], out[1, R2], out[2, R1], out[2, R2] = jet[R1], jet[R2], jet[R2], jet[R1]
    for k, (ab, c) in enumerate(zip(SECOND, DOUBLED, strict=True), start=3):
        out[k, ab] = -c * n
        for g in FIRST:
            out[k, g] = c * dot(jet[ab], duals[g]) * n
    return out


def second_derivative(jet: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Second derivative of stress . strain with respect to the jet: (5, 3, 5, 3, ...) for a stress (6, ...)."""
    n, duals = unit_normal(jet), dual(jet)
    out = np.zeros((5, 3, *jet.shape))
    for i in range(3):
        out[R1, i, R1, i], out[R2, i, R2, i] = stress[0], stress[1]
        out[R1, i, R2, i] = out[R2, i, R1, i] = stress[2]
    # Factors of delta r_ab - Gamma^g_ab delta r_g, contracted with M.
    weights = np.zeros((5, *stress.shape[1:]))
    bending = np.zeros(stress.shape[1:])
    for k, (ab, c) in enumerate(zip(SECOND, DOUBLED, strict=True), start=3):
        weights[ab] = c * stress[k]
        bending = bending + c * stress[k] * dot(jet[ab], n)
        for g in FIRST:
            weights[g] = weights[g] - c * stress[k] * dot(jet[ab], duals[g])
    for g in FIRST:
        for v in range(5):
            product = np.einsum("i...,j...->ij...", n, duals[g]) * weights[v]
            out[g, :, v] += product
            out[v, :, g] += product.swapaxes(0, 1)
        for l in FIRST:
            out[g, :, l] += bending * dot(duals[g], duals[l]) * np.einsum("i...,j...->ij...", n, n)
    return out
