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

from skancf.vectors import cross

R1, R2, R11, R22, R12 = range(5)
N_STRAINS = 6
FIRST, SECOND = (R1, R2), (R11, R22, R12)
DOUBLED = (1.0, 1.0, 2.0)
"""Factor of the components 11, 22, 12 in a sum over a and b, and of the shear entries of the strains."""


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Inner product over the first axis."""
    product: np.ndarray = np.add.reduce(a * b, axis=0)
    return product


def unit_normal(jet: np.ndarray) -> np.ndarray:
    """n, shape (3, ...)."""
    n = cross(jet[R1], jet[R2])
    unit: np.ndarray = n / np.sqrt(dot(n, n))
    return unit


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
    out = np.empty((N_STRAINS, *n.shape[1:]), n.dtype)
    out[0], out[1], out[2] = 0.5 * dot(jet[R1], jet[R1]), 0.5 * dot(jet[R2], jet[R2]), dot(jet[R1], jet[R2])
    out[3], out[4], out[5] = -dot(jet[R11], n), -dot(jet[R22], n), -2.0 * dot(jet[R12], n)
    return out


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


def spin_adjoint(n: np.ndarray, duals: np.ndarray, torque: np.ndarray) -> np.ndarray:
    r"""What a torque does on changes of r_1 and r_2 through the spin that they make, (2, 3, ...).

    The spin is linear in them and exact where they turn: :math:`\omega = \tfrac12 (a^\gamma \times \delta r_{,\gamma} +
    n \times \delta n)`.
    """
    tilt = cross(torque, n)
    return np.stack([0.5 * (cross(torque, a) - n * dot(a, tilt)) for a in duals])


def discrete_gradient(jet0: np.ndarray, jet1: np.ndarray) -> np.ndarray:
    r"""A gradient between two jets, with which the strains change exactly: (6, 5, 3, ...).

    With :math:`\bar r = (r^0 + r^1) / 2` and :math:`\Delta r = r^1 - r^0` it has, for every component,

    .. math:: D\varepsilon \cdot \Delta r = \varepsilon(r^1) - \varepsilon(r^0), \qquad
        D\varepsilon \cdot (\theta \times \bar r) = 0 \text{ for every } \theta,

    so that forces made of it do the work of the stresses exactly and have no moment. Nothing is divided by
    :math:`\Delta r`. The curvature is :math:`T / J` with :math:`T_{ab} = [r_{,1}, r_{,2}, r_{,ab}]` and
    :math:`J = |r_{,1} \times r_{,2}|`. Its change is :math:`(\Delta T - \bar\kappa\, \Delta J) / \bar J`, where J is a
    function of scalar products, whose changes are those at the middle, and

    .. math:: \Delta T = [\Delta a, \bar b, \bar c] + [\bar a, \Delta b, \bar c] + [\bar a, \bar b, \Delta c]
        + \tfrac14 [\Delta a, \Delta b, \Delta c].

    Of the last term the part that a spin :math:`\omega` of the surface makes vanishes; with
    :math:`w = \Delta r - \omega \times \bar r` it is linear in w: :math:`[w_a, \Delta b, \Delta c] +
    [\omega \times \bar a, w_b, \Delta c] + [\omega \times \bar a, \omega \times \bar b, w_c]`.

    References
    ----------
    O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6 (1996) 449-467: what a discrete
    gradient of invariant functions must satisfy.
    """
    mid, change = 0.5 * (jet0 + jet1), jet1 - jet0
    a, b, da, db = mid[R1], mid[R2], change[R1], change[R2]
    n, duals = unit_normal(mid), dual(mid)
    normals = [cross(jet[R1], jet[R2]) for jet in (jet0, jet1)]
    lengths = [np.sqrt(dot(m, m)) for m in normals]
    J = 0.5 * (lengths[0] + lengths[1])
    aa, bb, ab = (0.5 * (dot(jet0[i], jet0[j]) + dot(jet1[i], jet1[j])) for i, j in ((R1, R1), (R2, R2), (R1, R2)))
    on_J = (bb * a - ab * b) / J, (aa * b - ab * a) / J
    tilt = -dot(n, da) * duals[0] - dot(n, db) * duals[1]
    spin = 0.5 * (cross(duals[0], da) + cross(duals[1], db) + cross(n, tilt))
    turned_a, turned_b = cross(spin, a), cross(spin, b)
    out = np.zeros((N_STRAINS, *mid.shape))
    out[0, R1], out[1, R2], out[2, R1], out[2, R2] = a, b, b, a
    for k, (second, factor) in enumerate(zip(SECOND, DOUBLED, strict=True), start=3):
        c, dc = mid[second], change[second]
        bar = 0.5 * (dot(jet0[second], normals[0]) / lengths[0] + dot(jet1[second], normals[1]) / lengths[1])
        rest = [cross(db, dc), cross(dc, turned_a), cross(turned_a, turned_b)]
        torque = np.sum([cross(v, g) for v, g in zip((a, b, c), rest, strict=True)], axis=0)
        on_a, on_b = spin_adjoint(n, duals, torque)
        on_T = (
            cross(b, c) + 0.25 * (rest[0] - on_a),
            cross(c, a) + 0.25 * (rest[1] - on_b),
            cross(a, b) + 0.25 * rest[2],
        )
        for g in FIRST:
            out[k, g] = -factor * (on_T[g] - bar * on_J[g]) / J
        out[k, second] = -factor * on_T[2] / J
    return out
