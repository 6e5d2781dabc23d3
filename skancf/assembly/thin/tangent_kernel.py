r"""Compiled tangent of theory `kirchhoff`.

With the jets :math:`N_J` of the local functions, J = 1, 2, 11, 22, 12, vectors over the 16 functions at each point, the tangent
is :math:`Y + Y^T` with

.. math:: Y_{ij} = \sum_p n_i n_j S + \sum_{p, \gamma} A^\gamma_{ij} \otimes N_\gamma + \sum_r G_{r i} \otimes Z_{r j}.

S, of second derivatives alone, belongs to the class of an element: :math:`N_k D_{kl} N_l`. Whatever has a first
derivative on one side is in A, the membrane strains as if they were taken as they are, with the law of the rest. G are
gradients of the coefficients of the assumed strains, Z what makes up for the difference.
"""

import numpy as np
from numba import njit

from skancf.assembly.local import gather, scatter_tangent
from skancf.assembly.panels import add_panel, aligned
from skancf.assembly.thin.kernels import N_POINTS, jets, surface
from skancf.compiled import INNER, OPTIONS

FIRST = np.array([0, 0, 0, 1, 1, 2, 1, 2, 2])
SECOND = np.array([0, 1, 2, 1, 2, 2, 0, 0, 1])
"""Components i, j of the rows of Y, upper ones first."""
MIRROR = np.array([0, 6, 7, 3, 8, 5])
"""Where j, i of the upper ones are."""
KEPT = np.array([0, 6, 12, 16])
"""Where the coefficients of the assumed strains 11, 22, 12 begin."""
FACTORS = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -2.0])
"""Of the strains' gradients r_1 N_1, ..., n (N_11 - ...), ..."""


@njit(**INNER)
def unpack(rule, law, square):
    """The law, with the signs and factors of the gradients, as an array (6, 6, 16)."""
    square[:] = 0.0
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        factor = FACTORS[k] * FACTORS[l]
        for p in range(N_POINTS):
            square[k, l, p] = square[l, k, p] = factor * law[m, p]


@njit(**INNER)
def second_by_second(rule, square, rows, S):
    """N_k D_kl N_l at each point: S (16, 256)."""
    S[:] = 0.0
    for p in range(N_POINTS):
        for k in range(3):
            for a in range(16):
                rows[k, a] = (square[3 + k, 3, p] * rule.jets[32 + p, a] + square[3 + k, 4, p] * rule.jets[48 + p, a]
                              + square[3 + k, 5, p] * rule.jets[64 + p, a])  # fmt: skip
        for a in range(0, 16, 8):
            add_panel(8, 3, rule.jets, 16 * (32 + p) + a, 256, 1, rows, 0, 16, S, 256 * p + 16 * a, 16)


@njit(**INNER)
def kept_law(rule, square, rest, weights, C):
    """Scales the membrane law to that of the rest. C (16, 16), with which Z = C G - (what does not commute).

    Returns whether something does not.
    """
    even = False
    for k in range(3):
        for l in range(3):
            for p in range(N_POINTS):
                even = even and abs(square[k, l, p] * weights[0] - square[k, l, 0] * weights[p]) <= 1e-13 * abs(
                    square[k, k, 0] * weights[p]
                )
                even = even and square[k, 3 + l, p] == 0.0
    for k in range(3):
        for l in range(3):
            scale = rest[k] * rest[l]
            factor = 0.5 * (1.0 - scale if even else 1.0 + scale)
            for r in range(KEPT[k], KEPT[k + 1]):
                for s in range(KEPT[l], KEPT[l + 1]):
                    total = 0.0
                    for p in range(N_POINTS):
                        total += rule.kept[r, p] * square[k, l, p] * rule.kept[s, p]
                    C[r, s] = factor * total
            for p in range(N_POINTS):
                square[k, l, p] *= scale
    return not even


@njit(**INNER)
def coefficients(x, n, duals, gamma, square, stress, E, cross, moments):
    """Of the first derivatives in A: E (2, 2, 9, 16) of N_d in A^g; of the second ones: cross (2, 3, 16), moments (3, 16)."""
    on, H = np.empty((2, N_POINTS)), np.empty((2, 2, N_POINTS))
    bending = np.empty(N_POINTS)
    for p in range(N_POINTS):
        m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
        moments[0, p], moments[1, p], moments[2, p] = m11, m22, m12
        for d in range(2):
            on[d, p] = m11 * gamma[0, d, p] + m22 * gamma[1, d, p] + m12 * gamma[2, d, p]
        total = 0.0
        for i in range(3):
            total += n[i, p] * (m11 * x[i, 32 + p] + m22 * x[i, 48 + p] + m12 * x[i, 64 + p])
        bending[p] = total
    for g in range(2):
        for k in range(3):
            for p in range(N_POINTS):
                cross[g, k, p] = -(square[3 + k, 3, p] * gamma[0, g, p] + square[3 + k, 4, p] * gamma[1, g, p]
                                   + square[3 + k, 5, p] * gamma[2, g, p])  # fmt: skip
    for d in range(2):
        for g in range(2):
            for p in range(N_POINTS):
                metric = duals[d, 0, p] * duals[g, 0, p] + duals[d, 1, p] * duals[g, 1, p] + duals[d, 2, p] * duals[g, 2, p]
                law = gamma[0, d, p] * cross[g, 0, p] + gamma[1, d, p] * cross[g, 1, p] + gamma[2, d, p] * cross[g, 2, p]
                H[d, g, p] = 0.5 * (bending[p] * metric - law)
    for c in range(9):
        i, j = FIRST[c], SECOND[c]
        same = 0.5 if i == j else 0.0
        for p in range(N_POINTS):
            u, v, uj, vj = x[i, p], x[i, 16 + p], x[j, p], x[j, 16 + p]
            for g in range(2):
                if g == 0:
                    z0 = square[0, 0, p] * uj + square[0, 2, p] * vj
                    z1 = square[1, 0, p] * uj + square[1, 2, p] * vj
                    z2 = square[2, 0, p] * uj + square[2, 2, p] * vj
                else:
                    z0 = square[0, 1, p] * vj + square[0, 2, p] * uj
                    z1 = square[1, 1, p] * vj + square[1, 2, p] * uj
                    z2 = square[2, 1, p] * vj + square[2, 2, p] * uj
                nn, tilt = n[i, p] * n[j, p], n[j, p] * duals[g, i, p]
                first, second = (stress[0, p], stress[2, p]) if g == 0 else (stress[2, p], stress[1, p])
                E[g, 0, c, p] = 0.5 * (u * z0 + v * z2) + same * first + nn * H[0, g, p] - tilt * on[0, p]
                E[g, 1, c, p] = 0.5 * (v * z1 + u * z2) + same * second + nn * H[1, g, p] - tilt * on[1, p]


@njit(**INNER)
def first_rows(rule, start, n, duals, E, cross, moments, A):
    """Rows (p, g) of A for the eight points from ``start`` on: A (16, 144)."""
    w, y = np.empty(16), np.empty((3, 16))
    for p in range(start, start + 8):
        N11, N22, N12 = rule.jets[32 + p], rule.jets[48 + p], rule.jets[64 + p]
        N1, N2 = rule.jets[p], rule.jets[16 + p]
        for a in range(16):
            w[a] = moments[0, p] * N11[a] + moments[1, p] * N22[a] + moments[2, p] * N12[a]
        for g in range(2):
            row = A[2 * (p - start) + g]
            for i in range(3):
                along = duals[g, i, p]
                c0, c1, c2 = n[i, p] * cross[g, 0, p], n[i, p] * cross[g, 1, p], n[i, p] * cross[g, 2, p]
                for a in range(16):
                    y[i, a] = along * w[a] + c0 * N11[a] + c1 * N22[a] + c2 * N12[a]
            for c in range(9):
                normal, e0, e1, i = n[SECOND[c], p], E[g, 0, c, p], E[g, 1, c, p], FIRST[c]
                for a in range(16):
                    row[16 * c + a] = normal * y[i, a] + e0 * N1[a] + e1 * N2[a]


@njit(**INNER)
def membrane_gradient(rule, x, M):
    """Gradients of the membrane strains at the points: M (48, 48), rows strain and point, columns component and function."""
    for p in range(N_POINTS):
        for i in range(3):
            u, v = x[i, p], x[i, 16 + p]
            for a in range(16):
                N1, N2 = rule.jets[p, a], rule.jets[16 + p, a]
                M[p, 16 * i + a] = u * N1
                M[16 + p, 16 * i + a] = v * N2
                M[32 + p, 16 * i + a] = v * N1 + u * N2


@njit(**INNER)
def uneven(rule, square, membrane, n, gamma, M, T):
    """T (48, 48): law times gradient of the curvatures, less that of the membrane strains if ``membrane``."""
    T[:] = 0.0
    normal = np.empty((3, 16))
    for p in range(N_POINTS):
        for l in range(3):
            for a in range(16):
                normal[l, a] = (rule.jets[32 + 16 * l + p, a] - gamma[l, 0, p] * rule.jets[p, a]
                                - gamma[l, 1, p] * rule.jets[16 + p, a])  # fmt: skip
        for k in range(3):
            row = T[16 * k + p]
            for l in range(3):
                law = square[k, 3 + l, p]
                for i in range(3):
                    for a in range(16):
                        row[16 * i + a] += law * n[i, p] * normal[l, a]
                if membrane:
                    law = square[k, l, p]
                    for a in range(48):
                        row[a] -= law * M[16 * l + p, a]


@njit(**INNER)
def add_fits(values, B, C):
    """Adds coefficients, values (16, 16) at the points, of the three fields B (48, 48) to C (16, 48)."""
    for i in range(0, 48, 16):
        add_panel(6, 16, values, 0, 1, 16, B, i, 48, C, i, 48)
        add_panel(6, 16, values, 96, 1, 16, B, 768 + i, 48, C, 288 + i, 48)
        add_panel(4, 16, values, 192, 1, 16, B, 1536 + i, 48, C, 576 + i, 48)


@njit(**INNER)
def add_outer(n_rows, G, Z, Y):
    """Adds the sum over the rows of G_i Z_j to Y."""
    for c in range(9):
        for a in range(0, 16, 8):
            add_panel(8, n_rows, G, 16 * FIRST[c] + a, 48, 1, Z, 16 * SECOND[c], 48, Y, 256 * c + 16 * a, 16)


@njit(**INNER)
def symmetric(Y, K):
    """Y + Y^T as K (48, 48), of which components i <= j are written."""
    for c in range(6):
        i, j = 16 * FIRST[c], 16 * SECOND[c]
        other = MIRROR[c]
        for a in range(16):
            for b in range(16):
                K[i + a, j + b] = Y[16 * c + a, b] + Y[16 * other + b, a]


@njit(**OPTIONS)
def tangent(start, stop, order, q, stress, rule, maps, elements, slots, out):
    """Tangent with the given stresses (n_elements, 6, 16), added to out (n_blocks, 12, 12)."""
    local, x = np.empty((16, 3)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    E, cross, moments = np.empty((2, 2, 9, 16)), np.empty((2, 3, 16)), np.empty((3, 16))
    S, A, Y, K, normals = aligned(16, 256), aligned(16, 144), aligned(144, 16), aligned(48, 48), np.empty((6, 16))
    M, T, G, Z, C = aligned(48, 48), aligned(48, 48), aligned(16, 48), aligned(16, 48), np.zeros((16, 16))
    square, rows, slopes = np.empty((6, 6, 16)), aligned(3, 16), aligned(32, 16)
    slopes[:] = rule.slopes
    coupled = False
    for m in range(rule.pairs.shape[0]):
        coupled = coupled or rule.pairs[m, 0] < 3 <= rule.pairs[m, 1]
    last, assumed, mixed = -1, False, False
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        if c != last:
            unpack(rule, elements.law[c], square)
            second_by_second(rule, square, rows, S)
            assumed = elements.assumed[c] == 1
            mixed = kept_law(rule, square, elements.rest[c], rule.weights, C) if assumed else coupled
            last = c
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        coefficients(x, n, duals, gamma, square, stress[e], E, cross, moments)
        Y[:] = 0.0
        for k in range(6):
            factor = 0.5 if FIRST[k] == SECOND[k] else 1.0
            for p in range(N_POINTS):
                normals[k, p] = factor * n[FIRST[k], p] * n[SECOND[k], p]
        for a in range(16):
            add_panel(6, 16, normals, 0, 1, 16, S, 16 * a, 256, Y, 16 * a, 256)
        for half in range(0, 16, 8):
            first_rows(rule, half, n, duals, E, cross, moments, A)
            for row in range(0, 144, 6):
                add_panel(6, 16, A, row, 144, 1, slopes, 32 * half, 16, Y, 16 * row, 16)
        if assumed or mixed:
            membrane_gradient(rule, x, M)
        if mixed:
            uneven(rule, square, assumed, n, gamma, M, T)
        if assumed:
            G[:] = 0.0
            Z[:] = 0.0
            add_fits(rule.fit, M, G)
            for i in range(0, 48, 16):
                for a in range(0, 16, 8):
                    add_panel(8, 16, C, 16 * a, 1, 16, G, i, 48, Z, 48 * a + i, 48)
            if mixed:
                add_fits(rule.kept, T, Z)
            add_outer(16, G, Z, Y)
        elif mixed:
            add_outer(48, M, T, Y)
        symmetric(Y, K)
        scatter_tangent(e, maps, slots, K, out)
