r"""Compiled tangent of theory `kirchhoff`.

With :math:`N_J`, the jets J = 1, 2, 11, 22, 12 of the 16 local functions at a point, the tangent is :math:`Y + Y^T` with

.. math:: Y_{ij} = \sum_p n_i n_j S + \sum_{p, \gamma} A^\gamma_{ij} \otimes N_\gamma + \sum_r G_{r i} \otimes Z_{r j}.

S, of second derivatives alone, belongs to the class of an element: :math:`N_k D_{kl} N_l`. Whatever has a first derivative
on one side is in A, the membrane strains as if they were taken as they are, with the law of the rest. G are the gradients of
the coefficients of the assumed strains, Z what makes up for the difference. All are products with tables that elements
share.
"""

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.gather import gather, prefetch_blocks, scatter_tangent
from skancf.kernels.panels import add_panel, aligned, set_panel
from skancf.theories.kirchhoff.kernels import N_POINTS, jets, surface

FIRST = np.array([0, 0, 0, 1, 1, 2, 1, 2, 2])
SECOND = np.array([0, 1, 2, 1, 2, 2, 0, 0, 1])
"""Components i, j of Y, upper ones first."""
MIRROR = np.array([0, 6, 7, 3, 8, 5])
"""Where j, i of the upper ones are."""
KEPT = np.array([0, 6, 12, 16])
"""Where the coefficients of the assumed strains 11, 22, 12 begin."""
FACTORS = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -2.0])
"""Of the strains' gradients r_1 N_1, ..., n (N_11 - ...), ..."""
HALF = 8
"""Points whose rows of A are in the cache at a time."""


@compiled(**INNER)
def unpack(rule, law, square):
    """The law, with the signs and factors of the gradients, as an array (6, 6, 16)."""
    square[:] = 0.0
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        factor = FACTORS[k] * FACTORS[l]
        for p in range(N_POINTS):
            square[k, l, p] = square[l, k, p] = factor * law[m, p]


@compiled(**INNER)
def second_by_second(rule, square, gamma, scratch, S):
    """N_k D_kl N_l at each point, of N_k less gamma times the first derivatives: S (16, 256); scratch (6, 16)."""
    for p in range(N_POINTS):
        for k in range(3):
            for a in range(16):
                scratch[k, a] = (rule.jets[32 + 16 * k + p, a] - gamma[k, 0, p] * rule.jets[p, a]
                                 - gamma[k, 1, p] * rule.jets[16 + p, a])  # fmt: skip
        set_panel(3, 3, square, 336 + p, 16, 96, scratch, 0, 16, scratch, 48, 16)
        for a in range(0, 16, 8):
            set_panel(8, 3, scratch, a, 16, 1, scratch, 48, 16, S, 256 * p + 16 * a, 16)


@compiled(**INNER)
def kept_law(rule, square, rest, C):
    """C (16, 16), half the law of the coefficients of the assumed strains with that of the rest; the membrane law becomes
    that of the rest."""
    for k in range(3):
        for l in range(3):
            scale = rest[k] * rest[l]
            for r in range(KEPT[k], KEPT[k + 1]):
                for s in range(KEPT[l], KEPT[l + 1]):
                    total = 0.0
                    for p in range(N_POINTS):
                        total += rule.kept[r, p] * square[k, l, p] * rule.kept[s, p]
                    C[r, s] = 0.5 * (1.0 + scale) * total
            for p in range(N_POINTS):
                square[k, l, p] *= scale


@compiled(**INNER)
def membrane_forces(x, square, z):
    """Law times gradients of the membrane strains, less the tables: z (2, 9, 16), first derivative, strain and component."""
    for k in range(3):
        for j in range(3):
            for p in range(N_POINTS):
                u, v = x[j, p], x[j, 16 + p]
                z[0, 3 * k + j, p] = square[k, 0, p] * u + square[k, 2, p] * v
                z[1, 3 * k + j, p] = square[k, 1, p] * v + square[k, 2, p] * u


@compiled(**INNER)
def coefficients(x, n, duals, gamma, square, stress, shared, z, E, scratch):
    """E (2, 5, 9, 16): of N_J in A^g, by g and J. S has the second derivatives alone if ``shared`` is 1, all if it is 0."""
    cross, on, H, bending = scratch[:6], scratch[6:8], scratch[8:12], scratch[12]
    for p in range(N_POINTS):
        m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
        on[0, p] = m11 * gamma[0, 0, p] + m22 * gamma[1, 0, p] + m12 * gamma[2, 0, p]
        on[1, p] = m11 * gamma[0, 1, p] + m22 * gamma[1, 1, p] + m12 * gamma[2, 1, p]
        bending[p] = (
            n[0, p] * (m11 * x[0, 32 + p] + m22 * x[0, 48 + p] + m12 * x[0, 64 + p])
            + n[1, p] * (m11 * x[1, 32 + p] + m22 * x[1, 48 + p] + m12 * x[1, 64 + p])
            + n[2, p] * (m11 * x[2, 32 + p] + m22 * x[2, 48 + p] + m12 * x[2, 64 + p])
        )
    for g in range(2):
        for k in range(3):
            for p in range(N_POINTS):
                cross[3 * g + k, p] = -shared * (square[3 + k, 3, p] * gamma[0, g, p] + square[3 + k, 4, p] * gamma[1, g, p]
                                                 + square[3 + k, 5, p] * gamma[2, g, p])  # fmt: skip
    for g in range(2):
        for d in range(2):
            for p in range(N_POINTS):
                metric = duals[d, 0, p] * duals[g, 0, p] + duals[d, 1, p] * duals[g, 1, p] + duals[d, 2, p] * duals[g, 2, p]
                law = (gamma[0, d, p] * cross[3 * g, p] + gamma[1, d, p] * cross[3 * g + 1, p]
                       + gamma[2, d, p] * cross[3 * g + 2, p])  # fmt: skip
                H[2 * g + d, p] = 0.5 * (bending[p] * metric - law)
    for c in range(9):
        i, j = FIRST[c], SECOND[c]
        same = 0.5 if i == j else 0.0
        for g in range(2):
            for p in range(N_POINTS):
                u, v, nn, tilt = x[i, p], x[i, 16 + p], n[i, p] * n[j, p], n[j, p] * duals[g, i, p]
                E[g, 0, c, p] = (0.5 * (u * z[g, j, p] + v * z[g, 6 + j, p]) + same * stress[2 * g, p]
                                 + nn * H[2 * g, p] - tilt * on[0, p])  # fmt: skip
                E[g, 1, c, p] = (0.5 * (v * z[g, 3 + j, p] + u * z[g, 6 + j, p]) + same * stress[2 - g, p]
                                 + nn * H[2 * g + 1, p] - tilt * on[1, p])  # fmt: skip
                E[g, 2, c, p] = tilt * stress[3, p] + nn * cross[3 * g, p]
                E[g, 3, c, p] = tilt * stress[4, p] + nn * cross[3 * g + 1, p]
                E[g, 4, c, p] = tilt * 2.0 * stress[5, p] + nn * cross[3 * g + 2, p]


@compiled(**INNER)
def membrane_gradient(rule, x, of_first, M):
    """Gradients of the membrane strains: M (48, 48), rows point and strain, columns component and function.

    ``of_first`` (2, 9, 16) is scratch: what the first derivatives are multiplied by.
    """
    for i in range(3):
        for p in range(N_POINTS):
            u, v = x[i, p], x[i, 16 + p]
            of_first[0, i, p], of_first[0, 3 + i, p], of_first[0, 6 + i, p] = u, 0.0, v
            of_first[1, i, p], of_first[1, 3 + i, p], of_first[1, 6 + i, p] = 0.0, v, u
    for p in range(N_POINTS):
        set_panel(9, 2, of_first, p, 144, 16, rule.jets, 16 * p, 256, M, 144 * p, 16)


@compiled(**INNER)
def membrane_rest(rule, n, gamma, square, z, coupled, T):
    """T (48, 48), rows as those of M: what the curvatures add to the membrane stresses, less those of ``z``."""
    of_jets = np.empty((5, 9, N_POINTS))
    for k in range(3):
        for i in range(3):
            at = 3 * k + i
            for p in range(N_POINTS):
                of_jets[0, at, p], of_jets[1, at, p] = -z[0, at, p], -z[1, at, p]
            if coupled:
                for l in range(3):
                    for p in range(N_POINTS):
                        value = square[k, 3 + l, p] * n[i, p]
                        of_jets[2 + l, at, p] = value
                        of_jets[0, at, p] -= value * gamma[l, 0, p]
                        of_jets[1, at, p] -= value * gamma[l, 1, p]
    for p in range(N_POINTS):
        set_panel(9, 5 if coupled else 2, of_jets, p, 144, 16, rule.jets, 16 * p, 256, T, 144 * p, 16)


@compiled(**OPTIONS)
def tangent(start, stop, order, q, stress, rule, maps, elements, slots, out):
    """Tangent with the given stresses (n_elements, 6, 16), added to out (n_blocks, 12, 12)."""
    local, x = np.empty((16, 3)), aligned(3, 80)
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    z, of_first, E, scratch = np.empty((2, 9, 16)), np.empty((2, 9, 16)), np.empty((2, 5, 9, 16)), np.empty((13, 16))
    S, A, Y, K = aligned(16, 256), aligned(2 * HALF, 144), aligned(144, 16), aligned(48, 48)
    M, T, G, Z, C = aligned(48, 48), aligned(48, 48), aligned(16, 48), aligned(16, 48), np.zeros((16, 16))
    square, rows, slopes, normals = np.empty((6, 6, 16)), aligned(6, 16), aligned(32, 16), np.empty((6, 16))
    nothing = np.zeros((3, 2, 16))
    slopes[:] = rule.slopes
    coupled = False
    for m in range(rule.pairs.shape[0]):
        coupled = coupled or rule.pairs[m, 0] < 3 <= rule.pairs[m, 1]
    last, assumed = -1, False
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        if c != last:
            unpack(rule, elements.law[c], square)
            assumed = elements.assumed[c] == 1
            if assumed:
                second_by_second(rule, square, nothing, rows, S)
                kept_law(rule, square, elements.rest[c], C)
            last = c
        prefetch_blocks(e, slots, out)
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        membrane_forces(x, square, z)
        coefficients(x, n, duals, gamma, square, stress[e], 1.0 if assumed else 0.0, z, E, scratch)
        if not assumed:
            # At a pole gamma has no bound, and the parts of the second derivatives would cancel.
            second_by_second(rule, square, gamma, rows, S)
        for k in range(6):
            factor = 0.5 if FIRST[k] == SECOND[k] else 1.0
            for p in range(N_POINTS):
                normals[k, p] = factor * n[FIRST[k], p] * n[SECOND[k], p]
        for a in range(16):
            set_panel(6, N_POINTS, normals, 0, 1, 16, S, 16 * a, 256, Y, 16 * a, 256)
        Y[96:] = 0.0
        for first in range(0, N_POINTS, HALF):
            for p in range(HALF):
                for g in range(2):
                    at, row = first + p, 2 * p + g
                    set_panel(9, 5, E, 720 * g + at, 144, 16, rule.jets, 16 * at, 256, A, 144 * row, 16)
            for row in range(0, 144, 6):
                add_panel(6, 2 * HALF, A, row, 144, 1, slopes, 32 * first, 16, Y, 16 * row, 16)
        if assumed or coupled:
            membrane_gradient(rule, x, of_first, M)
            if not assumed:
                z[:] = 0.0
            membrane_rest(rule, n, gamma, square, z, coupled, T)
        if assumed:
            for i in range(0, 48, 16):
                set_panel(6, 16, rule.fit, 0, 1, 16, M, i, 144, G, i, 48)
                set_panel(6, 16, rule.fit, 96, 1, 16, M, 48 + i, 144, G, 288 + i, 48)
                set_panel(4, 16, rule.fit, 192, 1, 16, M, 96 + i, 144, G, 576 + i, 48)
                set_panel(6, 16, rule.kept, 0, 1, 16, T, i, 144, Z, i, 48)
                set_panel(6, 16, rule.kept, 96, 1, 16, T, 48 + i, 144, Z, 288 + i, 48)
                set_panel(4, 16, rule.kept, 192, 1, 16, T, 96 + i, 144, Z, 576 + i, 48)
                for a in range(0, 16, 8):
                    add_panel(8, 16, C, 16 * a, 1, 16, G, i, 48, Z, 48 * a + i, 48)
            for c9 in range(9):
                for a in range(0, 16, 8):
                    add_panel(8, 16, G, 16 * FIRST[c9] + a, 48, 1, Z, 16 * SECOND[c9], 48, Y, 256 * c9 + 16 * a, 16)
        elif coupled:
            for c9 in range(9):
                for a in range(0, 16, 8):
                    add_panel(8, 48, M, 16 * FIRST[c9] + a, 48, 1, T, 16 * SECOND[c9], 48, Y, 256 * c9 + 16 * a, 16)
        for k in range(6):
            i, j, other = 16 * FIRST[k], 16 * SECOND[k], 16 * MIRROR[k]
            for a in range(16):
                for b in range(16):
                    K[i + a, j + b] = Y[16 * k + a, b] + Y[other + b, a]
        scatter_tangent(e, maps, slots, K, out)
