r"""Compiled parts of theory `full` for laws at points through the thickness.

The local strain at a height is a matrix P(z) times the 14 strains, so that their stresses and law are

.. math:: S = \int P^T \sigma \, dV, \qquad D = \int P^T C P \, dV - \frac{g g^T}{k}, \qquad
    g = \int z\, P^T C_{\cdot 33}\, dV, \quad k = \int z^2 C_{33\,33} \, dV,

where the second part of D is that of a strain across which is linear in z and has no stress in the mean,
:math:`\int z\, \sigma_{33}\, dV = 0`; what is left of this is taken off S to first order.
"""

import numpy as np

from skancf.compiled import OPTIONS, compiled
from skancf.kernels.constants import POINTS
from skancf.theories.full.kernels import N_SAMPLED
from skancf.theories.full.theory import N_STRAINS

LOCAL_STRAINS, ACROSS = 6, 2
"""Number of local strains, and the row of the one across."""


@compiled(**OPTIONS)
def to_local(start, stop, order, eps, shape, P, out):
    """Local strains (6, n_z, n_elements, 16) of strains (n_elements, 14, 16), by P (n_shapes, n_z, 6, 14, 16)."""
    for index in range(start, stop):
        e = order[index]
        own = P[shape[e]]
        for z in range(own.shape[0]):
            for v in range(LOCAL_STRAINS):
                for p in range(POINTS):
                    out[v, z, e, p] = 0.0
                for k in range(N_STRAINS):
                    for p in range(POINTS):
                        out[v, z, e, p] += own[z, v, k, p] * eps[e, k, p]


@compiled(**OPTIONS)
def integrate(start, stop, order, stress, stiffness, heights, shape, P, volume, stress_out, law_out):
    """Stresses (n_elements, 14, 16) and entries of their law (n_elements, 105, 16), from local stresses (6, n_z, n_elements,
    16) and their stiffness (21, n_z, n_elements, 16), with ``heights`` above the middle, and ``volume`` with the weights,
    both (n_shapes, n_z, 16)."""
    C, CP = np.empty((LOCAL_STRAINS, LOCAL_STRAINS)), np.empty((LOCAL_STRAINS, N_STRAINS))
    S, D, g = np.empty(N_STRAINS), np.empty((N_STRAINS, N_STRAINS)), np.empty(N_STRAINS)
    for index in range(start, stop):
        e = order[index]
        own, weights, arms = P[shape[e]], volume[shape[e]], heights[shape[e]]
        for p in range(POINTS):
            S[:], D[:], g[:] = 0.0, 0.0, 0.0
            across = left = 0.0
            for z in range(own.shape[0]):
                w, h, m = weights[z, p], arms[z, p], 0
                left += h * w * stress[ACROSS, z, e, p]
                for k in range(LOCAL_STRAINS):
                    for l in range(k, LOCAL_STRAINS):
                        C[k, l] = C[l, k] = w * stiffness[m, z, e, p]
                        m += 1
                for v in range(LOCAL_STRAINS):
                    for l in range(N_STRAINS):
                        total = 0.0
                        for u in range(LOCAL_STRAINS):
                            total += C[v, u] * own[z, u, l, p]
                        CP[v, l] = total
                across += h * h * C[ACROSS, ACROSS]
                for k in range(N_STRAINS):
                    g[k] += h * CP[ACROSS, k]
                    for v in range(LOCAL_STRAINS):
                        factor = own[z, v, k, p]
                        S[k] += factor * w * stress[v, z, e, p]
                        for l in range(k, N_STRAINS):
                            D[k, l] += factor * CP[v, l]
            m = 0
            for k in range(N_STRAINS):
                stress_out[e, k, p] = S[k] - g[k] * left / across
                for l in range(k, N_STRAINS):
                    law_out[e, m, p] = D[k, l] - g[k] * g[l] / across
                    m += 1


@compiled(**OPTIONS)
def sampled_laws(start, stop, order, law, interpolation, rows, out):
    """Laws of the sampled strains (n_elements, n_rows, n_rows), interpolation^T D interpolation, from entries of the law
    (n_elements, 105, 16)."""
    first = N_STRAINS * (N_STRAINS + 1) // 2 - N_SAMPLED * (N_SAMPLED + 1) // 2
    for index in range(start, stop):
        e = order[index]
        for r in range(rows.shape[0]):
            k, s = rows[r]
            for q in range(r, rows.shape[0]):
                l, t = rows[q]
                a, b = min(k, l), max(k, l)
                m = first + a * N_SAMPLED - a * (a - 1) // 2 + b - a
                total = 0.0
                for p in range(POINTS):
                    total += interpolation[k, s, p] * law[e, m, p] * interpolation[l, t, p]
                out[e, r, q] = out[e, q, r] = total
