r"""Compiled stress and stiffness of energies of the invariants of C in three dimensions.

.. math::
    S = 2 \psi_{,I_1} I + 2 \psi_{,I_2} (I_1 I - C) + J \psi_{,J} C^{-1}, \qquad D = 4 \psi_{,CC},

with second derivatives of the invariants :math:`I_{2,CC} = I \otimes I - 1` and
:math:`J_{,CC} = \tfrac J4 C^{-1} \otimes C^{-1} - \tfrac J2 C^{-1} \odot C^{-1}`.
"""

from math import isfinite, nan, sqrt

import numpy as np

from skancf.materials.hyperelastic.kernels import point_function
from skancf.materials.point_law import BEYOND, FINE, FOLDED

SOLID_RESULTS = 29
"""Numbers of a point: energy, the six of S, the 21 of D, and the code."""
ROWS = np.array([0, 1, 2, 1, 0, 0])
COLUMNS = np.array([0, 1, 2, 2, 2, 1])
"""Indices of Voigt components 11, 22, 33, 23, 13, 12."""


@point_function
def fail(out, k, code):
    for row in range(SOLID_RESULTS - 1):
        out[row, k] = nan
    out[SOLID_RESULTS - 1, k] = code


@point_function
def store_solid(derivatives, C, k, par, out, inverse, G):
    """The numbers of point k, in column k; ``inverse`` (3, 3) and ``G`` (3, 6) are scratch."""
    a, b, c, f, e, d = C[0, k], C[1, k], C[2, k], C[3, k], C[4, k], C[5, k]
    A, B, E = a - 1.0, b - 1.0, c - 1.0
    trace = A + B + E
    pairs = A * B + B * E + A * E - d * d - e * e - f * f
    x = trace + pairs + A * (B * E - f * f) - d * (d * E - f * e) + e * (d * f - B * e)
    if not (a > 0.0 and a * b - d * d > 0.0 and x > -1.0):
        fail(out, k, FOLDED)
        return
    J2 = 1.0 + x
    J = sqrt(J2)
    energy, g1, g2, gJ, h11, h22, hJJ, h12, h1J, h2J = derivatives(trace, 2.0 * trace + pairs, x, par)
    if not isfinite(energy + g1 + g2 + gJ + h11 + h22 + hJJ):
        fail(out, k, BEYOND)
        return
    inverse[0, 0], inverse[1, 1], inverse[2, 2] = (b * c - f * f) / J2, (a * c - e * e) / J2, (a * b - d * d) / J2
    inverse[0, 1] = inverse[1, 0] = (e * f - d * c) / J2
    inverse[0, 2] = inverse[2, 0] = (d * f - b * e) / J2
    inverse[1, 2] = inverse[2, 1] = (d * e - a * f) / J2
    out[0, k] = energy
    for m in range(6):
        unit = 1.0 if m < 3 else 0.0
        G[0, m], G[1, m] = unit, (3.0 + trace) * unit - C[m, k]
        G[2, m] = 0.5 * J * inverse[ROWS[m], COLUMNS[m]]
        out[1 + m, k] = 2.0 * (g1 * G[0, m] + g2 * G[1, m] + gJ * G[2, m])
    row = 7
    for m in range(6):
        i, j = ROWS[m], COLUMNS[m]
        v1, v2 = h11 * G[0, m] + h12 * G[1, m] + h1J * G[2, m], h12 * G[0, m] + h22 * G[1, m] + h2J * G[2, m]
        v3 = h1J * G[0, m] + h2J * G[1, m] + hJJ * G[2, m]
        for n in range(m, 6):
            p, q = ROWS[n], COLUMNS[n]
            entry = v1 * G[0, n] + v2 * G[1, n] + v3 * G[2, n] + g2 * G[0, m] * G[0, n]
            if m == n:
                entry -= g2 if m < 3 else 0.5 * g2
            twice = inverse[i, p] * inverse[j, q] + inverse[i, q] * inverse[j, p]
            entry += 0.25 * J * gJ * (inverse[i, j] * inverse[p, q] - twice)
            out[row, k] = 4.0 * entry
            row += 1
    out[SOLID_RESULTS - 1, k] = FINE
