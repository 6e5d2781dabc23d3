"""Compiled parts of :mod:`skancf.materials.through_thickness`, with its formulas."""

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled


@compiled(**INNER)
def inverse_shifter(b1, b2, b12, z):
    """Components 11, 22, 12 of the inverse of 1 - z b, and its determinant's: the area at z per area of the surface."""
    s1, s2, s12 = 1.0 - z * b1, 1.0 - z * b2, -z * b12
    area = s1 * s2 - s12 * s12
    return s2 / area, s1 / area, -s12 / area, area


@compiled(**INNER)
def mixed(eps, kappa, curvature, k):
    """m = a^-1 b, components 11, 12, 21, 22; a^-1, b and the rest b a^-1 b - B B of the change of the metric."""
    a1, a2, a12 = 1.0 + 2.0 * eps[0, k], 1.0 + 2.0 * eps[1, k], eps[2, k]
    B1, B2, B12 = curvature[0, k], curvature[1, k], curvature[2, k]
    b1, b2, b12 = B1 - kappa[0, k], B2 - kappa[1, k], B12 - 0.5 * kappa[2, k]
    det = a1 * a2 - a12 * a12
    i1, i2, i12 = a2 / det, a1 / det, -a12 / det
    m11, m12, m21, m22 = i1 * b1 + i12 * b12, i1 * b12 + i12 * b2, i12 * b1 + i2 * b12, i12 * b12 + i2 * b2
    f1 = b1 * m11 + b12 * m21 - (B1 * B1 + B12 * B12)
    f2 = b12 * m12 + b2 * m22 - (B2 * B2 + B12 * B12)
    f12 = b1 * m12 + b12 * m22 - B12 * (B1 + B2)
    return (m11, m12, m21, m22), (i1, i2, i12), (f1, f2, f12)


@compiled(**OPTIONS)
def deformations(z, eps, kappa, curvature, out):
    """C11, C22, C12 at heights z (m, n), or (m, 1) of all, of n points: (3, m * n), heights one after the other."""
    n, own = eps.shape[1], z.shape[1] > 1
    for k in range(n):
        _, _, f = mixed(eps, kappa, curvature, k)
        place = k if own else 0
        for j in range(z.shape[0]):
            h = z[j, place]
            e1 = 2.0 * (eps[0, k] + h * kappa[0, k]) + h * h * f[0]
            e2 = 2.0 * (eps[1, k] + h * kappa[1, k]) + h * h * f[1]
            e12 = eps[2, k] + h * kappa[2, k] + h * h * f[2]
            s1, s2, s12, _ = inverse_shifter(curvature[0, k], curvature[1, k], curvature[2, k], h)
            at = j * n + k
            out[0, at] = 1.0 + s1 * s1 * e1 + 2.0 * s1 * s12 * e12 + s12 * s12 * e2
            out[1, at] = 1.0 + s12 * s12 * e1 + 2.0 * s2 * s12 * e12 + s2 * s2 * e2
            out[2, at] = s1 * s12 * e1 + (s1 * s2 + s12 * s12) * e12 + s12 * s2 * e2


@compiled(**INNER)
def to_surface(s1, s2, s12, T):
    """From a strain there, order 11, 22, 12 (doubled), to that of an orthonormal frame at the height: (3, 3)."""
    T[0, 0], T[0, 1], T[0, 2] = s1 * s1, s12 * s12, s1 * s12
    T[1, 0], T[1, 1], T[1, 2] = s12 * s12, s2 * s2, s2 * s12
    T[2, 0], T[2, 1], T[2, 2] = 2.0 * s1 * s12, 2.0 * s2 * s12, s1 * s2 + s12 * s12


@compiled(**INNER)
def set_levers(m, P, R):
    """P: e to m^T e m; R: k to (k m + m^T k) / 2, both (3, 3)."""
    m11, m12, m21, m22 = m
    P[0, 0], P[0, 1], P[0, 2] = m11 * m11, m21 * m21, m11 * m21
    P[1, 0], P[1, 1], P[1, 2] = m12 * m12, m22 * m22, m12 * m22
    P[2, 0], P[2, 1], P[2, 2] = 2.0 * m11 * m12, 2.0 * m21 * m22, m11 * m22 + m12 * m21
    R[0, 0], R[0, 1], R[0, 2] = m11, 0.0, 0.5 * m21
    R[1, 0], R[1, 1], R[1, 2] = 0.0, m22, 0.5 * m12
    R[2, 0], R[2, 1], R[2, 2] = m12, m21, 0.5 * (m11 + m22)


@compiled(**INNER)
def add_stress_part(m, inverse, s2, W, full):
    """What the stress adds to the stiffness: Z : (Y^T a^-1 Y), Y = k + 2 e m, for Z the second moment of the stress."""
    m11, m12, m21, m22 = m
    W[:] = 0.0
    W[0, 0], W[0, 2], W[0, 3] = 2.0 * m11, m21, 1.0
    W[1, 0], W[1, 2], W[1, 5] = 2.0 * m12, m22, 0.5
    W[2, 1], W[2, 2], W[2, 5] = 2.0 * m21, m11, 0.5
    W[3, 1], W[3, 2], W[3, 4] = 2.0 * m22, m12, 1.0
    for p in range(2):
        for q in range(2):
            i = inverse[p] if p == q else inverse[2]
            for r in range(2):
                for s in range(2):
                    factor = i * (s2[r] if r == s else s2[2])
                    for k in range(6):
                        for l in range(k, 6):
                            full[k, l] += factor * W[2 * p + r, k] * W[2 * q + s, l]


@compiled(**INNER)
def set_powers(z, weights, curvature, k, n, energy, stress, stiffness, T, D, s, d):
    """Integrals of energy, of stresses s (3, 3) times 1, z, z^2, and of stiffnesses d (5, 3, 3) times 1 to z^4."""
    s[:] = 0.0
    d[:] = 0.0
    total, place = 0.0, k if z.shape[1] > 1 else 0
    for j in range(z.shape[0]):
        at, h = j * n + k, z[j, place]
        s1, s2, s12, area = inverse_shifter(curvature[0, k], curvature[1, k], curvature[2, k], h)
        to_surface(s1, s2, s12, T)
        D[0, 0], D[1, 1], D[2, 2] = stiffness[0, at], stiffness[1, at], stiffness[2, at]
        D[0, 1] = D[1, 0] = stiffness[3, at]
        D[0, 2] = D[2, 0] = stiffness[4, at]
        D[1, 2] = D[2, 1] = stiffness[5, at]
        w = weights[j, place] * area
        total += w * energy[at]
        for a in range(3):
            own = w * (T[0, a] * stress[0, at] + T[1, a] * stress[1, at] + T[2, a] * stress[2, at])
            s[0, a] += own
            s[1, a] += h * own
            s[2, a] += h * h * own
            for b in range(a, 3):
                entry = 0.0
                for c in range(3):
                    entry += T[c, a] * (D[c, 0] * T[0, b] + D[c, 1] * T[1, b] + D[c, 2] * T[2, b])
                entry *= w
                for power in range(5):
                    d[power, a, b] += entry
                    entry *= h
                for power in range(5):
                    d[power, b, a] = d[power, a, b]
    return total


@compiled(**INNER)
def set_stiffness(d, P, R, full):
    """The upper half of L^T D L integrated, L = [1 - z^2 P, z - z^2 R]."""
    for a in range(3):
        for b in range(3):
            ee, ek, kk = d[0, a, b], d[1, a, b], d[2, a, b]
            for c in range(3):
                ee -= d[2, a, c] * P[c, b] + P[c, a] * d[2, c, b]
                ek -= d[2, a, c] * R[c, b] + P[c, a] * d[3, c, b]
                kk -= d[3, a, c] * R[c, b] + R[c, a] * d[3, c, b]
                for e in range(3):
                    four = d[4, c, e]
                    ee += P[c, a] * four * P[e, b]
                    ek += P[c, a] * four * R[e, b]
                    kk += R[c, a] * four * R[e, b]
            full[a, b], full[a, 3 + b], full[3 + a, 3 + b] = ee, ek, kk


@compiled(**OPTIONS)
def resultants(z, weights, eps, kappa, curvature, energy, stress, stiffness, out_energy, out_forces, out_stiffness):
    """Energy (n,), forces and moments (6, n) and stiffness (21, n) per area, from energy (m * n,), stress (3, m * n) and
    stiffness (6, m * n) at the heights (m, n), or (m, 1) of all."""
    n = eps.shape[1]
    T, D, s, d = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((5, 3, 3))
    P, R, W, full = np.empty((3, 3)), np.empty((3, 3)), np.empty((4, 6)), np.empty((6, 6))
    for k in range(n):
        m, inverse, _ = mixed(eps, kappa, curvature, k)
        set_levers(m, P, R)
        out_energy[k] = set_powers(z, weights, curvature, k, n, energy, stress, stiffness, T, D, s, d)
        for a in range(3):
            force, moment = s[0, a], s[1, a]
            for c in range(3):
                force -= P[c, a] * s[2, c]
                moment -= R[c, a] * s[2, c]
            out_forces[a, k], out_forces[3 + a, k] = force, moment
        set_stiffness(d, P, R, full)
        add_stress_part(m, inverse, s[2], W, full)
        at = 0
        for i in range(6):
            for j in range(i, 6):
                out_stiffness[at, k] = full[i, j]
                at += 1
