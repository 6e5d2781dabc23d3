"""Compiled assembly of theory `kirchhoff`; its formulas are those of :mod:`skancf.theories.kirchhoff_point`.

Each kernel works on the elements ``order[start:stop]``. Arrays have the 16 integration points last, so that inner loops
run over points.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from skancf.assembly.local import gather, scatter_force, scatter_tangent
from skancf.compiled import INNER, OPTIONS

N_POINTS = 16
N_ROWS = 11 * N_POINTS


class Elements(NamedTuple):
    """What differs between elements.

    ``shape`` (n,), the class of equal undeformed elements; for each class the undeformed strains ``reference``
    (n_shapes, 6, 16), the entries of the law with the weights ``law`` (n_shapes, n_pairs, 16), whether membrane strains are
    ``assumed`` (n_shapes,), 0 or 1, and the roots of the factors with which the rest of the three counts, ``rest``
    (n_shapes, 3).
    """

    shape: np.ndarray
    reference: np.ndarray
    law: np.ndarray
    assumed: np.ndarray
    rest: np.ndarray


class Rule(NamedTuple):
    """What elements share.

    ``table`` (16, 80): jets of the local functions, jet by jet; ``slopes`` (32, 16): the first two. ``projections``
    (2, 3, 16, 16): from the membrane strains 11, 22, 12 at the points to those that the law is applied to, ``(c, from,
    to)``: the identity, and the assumed ones. ``pairs`` (n_pairs, 2): k <= l of the entries of the law.
    """

    table: np.ndarray
    slopes: np.ndarray
    projections: np.ndarray
    pairs: np.ndarray


@njit(**INNER)
def jets(rule, local, x):
    """r_1, r_2, r_11, r_22, r_12 at the points: x (3, 80), jet by jet."""
    np.dot(local.T, rule.table, x)


@njit(**INNER)
def surface(x, n, duals, gamma):
    """Unit normal (3, 16), dual vectors (2, 3, 16) and Christoffel symbols (3, 2, 16) of the jets."""
    for p in range(N_POINTS):
        a0, a1, a2, b0, b1, b2 = x[0, p], x[1, p], x[2, p], x[0, 16 + p], x[1, 16 + p], x[2, 16 + p]
        n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        square = n0 * n0 + n1 * n1 + n2 * n2
        length = 1.0 / np.sqrt(square)
        n[0, p], n[1, p], n[2, p] = n0 * length, n1 * length, n2 * length
        aa, bb, ab = a0 * a0 + a1 * a1 + a2 * a2, b0 * b0 + b1 * b1 + b2 * b2, a0 * b0 + a1 * b1 + a2 * b2
        aa, bb, ab = aa / square, bb / square, ab / square
        duals[0, 0, p], duals[0, 1, p], duals[0, 2, p] = bb * a0 - ab * b0, bb * a1 - ab * b1, bb * a2 - ab * b2
        duals[1, 0, p], duals[1, 1, p], duals[1, 2, p] = aa * b0 - ab * a0, aa * b1 - ab * a1, aa * b2 - ab * a2
    for k in range(3):
        at = 32 + 16 * k
        for g in range(2):
            for p in range(N_POINTS):
                gamma[k, g, p] = (duals[g, 0, p] * x[0, at + p] + duals[g, 1, p] * x[1, at + p]
                                  + duals[g, 2, p] * x[2, at + p])  # fmt: skip


@njit(**INNER)
def strains(x, n, reference, eps):
    """Membrane strains and curvature changes less the undeformed ones: eps (6, 16)."""
    for p in range(N_POINTS):
        e11 = e22 = e12 = k11 = k22 = k12 = 0.0
        for i in range(3):
            a, b = x[i, p], x[i, 16 + p]
            e11 += a * a
            e22 += b * b
            e12 += a * b
            k11 += n[i, p] * x[i, 32 + p]
            k22 += n[i, p] * x[i, 48 + p]
            k12 += n[i, p] * x[i, 64 + p]
        eps[0, p] = 0.5 * e11 - reference[0, p]
        eps[1, p] = 0.5 * e22 - reference[1, p]
        eps[2, p] = e12 - reference[2, p]
        eps[3, p] = -k11 - reference[3, p]
        eps[4, p] = -k22 - reference[4, p]
        eps[5, p] = -2.0 * k12 - reference[5, p]


@njit(**INNER)
def add_change(x, y, n, gamma, eps):
    """Adds the change of the strains, linear in the change of the jets y (3, 80)."""
    for i in range(3):
        for p in range(N_POINTS):
            a, b, da, db, normal = x[i, p], x[i, 16 + p], y[i, p], y[i, 16 + p], n[i, p]
            eps[0, p] += a * da
            eps[1, p] += b * db
            eps[2, p] += a * db + b * da
            eps[3, p] -= normal * (y[i, 32 + p] - gamma[0, 0, p] * da - gamma[0, 1, p] * db)
            eps[4, p] -= normal * (y[i, 48 + p] - gamma[1, 0, p] * da - gamma[1, 1, p] * db)
            eps[5, p] -= 2.0 * normal * (y[i, 64 + p] - gamma[2, 0, p] * da - gamma[2, 1, p] * db)


@njit(**INNER)
def section(rule, projection, law, rest, eps, hat, stress):
    """Stresses (6, 16), with the weights, that do work on the strains at the points.

    The law is applied to the assumed membrane strains with the curvatures, and to the scaled rest of the membrane strains;
    ``hat`` (6, 16) is scratch.
    """
    hat[:3] = 0.0
    hat[3:] = eps[3:]
    for c in range(3):
        for s in range(N_POINTS):
            for p in range(N_POINTS):
                hat[c, p] += projection[c, s, p] * eps[c, s]
    stress[:] = 0.0
    extra = np.zeros((3, N_POINTS))
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        for p in range(N_POINTS):
            stress[k, p] += law[m, p] * hat[l, p]
        if k != l:
            for p in range(N_POINTS):
                stress[l, p] += law[m, p] * hat[k, p]
        if l < 3:
            scale = rest[k] * rest[l]
            for p in range(N_POINTS):
                extra[k, p] += scale * law[m, p] * (eps[l, p] - hat[l, p])
            if k != l:
                for p in range(N_POINTS):
                    extra[l, p] += scale * law[m, p] * (eps[k, p] - hat[k, p])
    for c in range(3):
        for p in range(N_POINTS):
            hat[c, p] = stress[c, p] - extra[c, p]
        for s in range(N_POINTS):
            total = extra[c, s]
            for p in range(N_POINTS):
                total += projection[c, s, p] * hat[c, p]
            stress[c, s] = total


@njit(**INNER)
def forces(rule, x, n, gamma, stress, f, force):
    """Forces (16, 3) on the local vectors; ``f`` (3, 80) is scratch."""
    for i in range(3):
        for p in range(N_POINTS):
            m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
            along = m11 * gamma[0, 0, p] + m22 * gamma[1, 0, p] + m12 * gamma[2, 0, p]
            across = m11 * gamma[0, 1, p] + m22 * gamma[1, 1, p] + m12 * gamma[2, 1, p]
            f[i, p] = stress[0, p] * x[i, p] + stress[2, p] * x[i, 16 + p] + along * n[i, p]
            f[i, 16 + p] = stress[2, p] * x[i, p] + stress[1, p] * x[i, 16 + p] + across * n[i, p]
            f[i, 32 + p] = -m11 * n[i, p]
            f[i, 48 + p] = -m22 * n[i, p]
            f[i, 64 + p] = -m12 * n[i, p]
    np.dot(rule.table, f.T, force)


@njit(**OPTIONS)
def stresses(start, stop, order, q, change, rule, maps, elements, strain_out, out):
    """Strain and stress extrapolated linearly along ``change``, strain(q) + B(q) change; the stress has the weights.

    Into ``strain_out`` (n_elements, 6, 16), or nowhere if that is empty, and ``out``.
    """
    local, moved = np.empty((16, 3)), np.empty((16, 3))
    x, y = np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    eps, hat = np.empty((6, 16)), np.empty((6, 16))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        strains(x, n, elements.reference[c], eps)
        if change.shape[0]:
            gather(e, change, maps, moved)
            jets(rule, moved, y)
            add_change(x, y, n, gamma, eps)
        section(rule, rule.projections[elements.assumed[c]], elements.law[c], elements.rest[c], eps, hat, out[e])
        if strain_out.shape[0]:
            strain_out[e] = eps


@njit(**OPTIONS)
def residual(start, stop, order, q, rule, maps, elements, out):
    """Internal force, added to out (n_nodes, 4, 3)."""
    local, force, x, f = np.empty((16, 3)), np.empty((16, 3)), np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    eps, hat, stress = np.empty((6, 16)), np.empty((6, 16)), np.empty((6, 16))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        strains(x, n, elements.reference[c], eps)
        section(rule, rule.projections[elements.assumed[c]], elements.law[c], elements.rest[c], eps, hat, stress)
        forces(rule, x, n, gamma, stress, f, force)
        scatter_force(e, force, maps, out)


@njit(**OPTIONS)
def force_of(start, stop, order, q, stress, rule, maps, out):
    """Force of given stresses (n_elements, 6, 16), which have the weights, added to out (n_nodes, 4, 3)."""
    local, force, x, f = np.empty((16, 3)), np.empty((16, 3)), np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    for index in range(start, stop):
        e = order[index]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        forces(rule, x, n, gamma, stress[e], f, force)
        scatter_force(e, force, maps, out)


@njit(**INNER)
def strain_rows(rule, projection, rest, x, n, gamma, A):
    """Gradients of the strains (16 points each), (144, 48): three assumed membrane strains, three curvatures, the scaled
    rest of the membrane strains."""
    table = rule.table
    plain = np.empty((N_POINTS, 48))
    for c in range(3):
        for p in range(N_POINTS):
            for i in range(3):
                u, v = x[i, p], x[i, 16 + p]
                u, v = (u, 0.0) if c == 0 else ((0.0, v) if c == 1 else (v, u))
                for a in range(16):
                    plain[p, 16 * i + a] = u * table[a, p] + v * table[a, 16 + p]
        hat, other = A[16 * c : 16 * c + 16], A[96 + 16 * c : 112 + 16 * c]
        np.dot(projection[c].T, plain, hat)
        for p in range(N_POINTS):
            for a in range(48):
                other[p, a] = rest[c] * (plain[p, a] - hat[p, a])
    for k in range(3):
        double = -2.0 if k == 2 else -1.0
        for p in range(N_POINTS):
            row = A[48 + 16 * k + p]
            for a in range(16):
                g = double * (table[a, 32 + 16 * k + p] - gamma[k, 0, p] * table[a, p] - gamma[k, 1, p] * table[a, 16 + p])
                for i in range(3):
                    row[16 * i + a] = n[i, p] * g


@njit(**INNER)
def law_rows(rule, law, A, B):
    """Half of the law times the gradients: B (144, 48)."""
    B[:144] = 0.0
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        for p in range(N_POINTS):
            d = 0.5 * law[m, p]
            for a in range(48):
                B[16 * k + p, a] += d * A[16 * l + p, a]
            if k != l:
                for a in range(48):
                    B[16 * l + p, a] += d * A[16 * k + p, a]
            if l < 3:
                for a in range(48):
                    B[96 + 16 * k + p, a] += d * A[96 + 16 * l + p, a]
                if k != l:
                    for a in range(48):
                        B[96 + 16 * l + p, a] += d * A[96 + 16 * k + p, a]


@njit(**INNER)
def bending_rows(rule, x, n, duals, gamma, stress, A, B):
    """Rows 144 to 175, whose products A^T B with their transpose are moment . second derivative of the curvature."""
    table = rule.table
    for p in range(N_POINTS):
        m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
        on1 = m11 * gamma[0, 0, p] + m22 * gamma[1, 0, p] + m12 * gamma[2, 0, p]
        on2 = m11 * gamma[0, 1, p] + m22 * gamma[1, 1, p] + m12 * gamma[2, 1, p]
        bending = 0.0
        for i in range(3):
            bending += n[i, p] * (m11 * x[i, 32 + p] + m22 * x[i, 48 + p] + m12 * x[i, 64 + p])
        for g in range(2):
            row, with_row = A[144 + 16 * g + p], B[144 + 16 * g + p]
            along = across = 0.0
            for i in range(3):
                along += duals[g, i, p] * duals[0, i, p]
                across += duals[g, i, p] * duals[1, i, p]
            along, across = 0.5 * bending * along, 0.5 * bending * across
            for a in range(16):
                N1, N2 = table[a, p], table[a, 16 + p]
                w = m11 * table[a, 32 + p] + m22 * table[a, 48 + p] + m12 * table[a, 64 + p] - on1 * N1 - on2 * N2
                own, both = N1 if g == 0 else N2, along * N1 + across * N2
                for i in range(3):
                    row[16 * i + a] = n[i, p] * own
                    with_row[16 * i + a] = duals[g, i, p] * w + both * n[i, p]


@njit(**INNER)
def membrane_geometry(rule, stress, T, G):
    """Half of membrane stress . second derivative of the strain: G (16, 16), the same for the three components."""
    for a in range(16):
        for p in range(N_POINTS):
            N1, N2 = rule.table[a, p], rule.table[a, 16 + p]
            T[a, p] = 0.5 * (stress[0, p] * N1 + stress[2, p] * N2)
            T[a, 16 + p] = 0.5 * (stress[2, p] * N1 + stress[1, p] * N2)
    np.dot(T, rule.slopes, G)


@njit(**OPTIONS)
def tangent(start, stop, order, q, stress, rule, maps, elements, slots, out):
    """Tangent with the given stresses (n_elements, 6, 16), added to out (n_blocks, 12, 12)."""
    local, x = np.empty((16, 3)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    A, B = np.empty((N_ROWS, 48)), np.empty((N_ROWS, 48))
    K, G, T = np.empty((48, 48)), np.empty((16, 16)), np.empty((16, 32))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        strain_rows(rule, rule.projections[elements.assumed[c]], elements.rest[c], x, n, gamma, A)
        law_rows(rule, elements.law[c], A, B)
        bending_rows(rule, x, n, duals, gamma, stress[e], A, B)
        np.dot(A.T, B, K)
        membrane_geometry(rule, stress[e], T, G)
        for i in range(0, 48, 16):
            for a in range(16):
                for b in range(16):
                    K[i + a, i + b] += G[a, b]
        # A^T B is half of the tangent; the other half is its transpose.
        for a in range(48):
            for b in range(a + 1):
                K[a, b] = K[b, a] = K[a, b] + K[b, a]
        scatter_tangent(e, maps, slots, K, out)

