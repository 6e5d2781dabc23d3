"""Compiled assembly of theory `full`. Each kernel works on the elements ``order[start:stop]``.

In-plane strains are taken at the integration points. Shear and thickness strains are taken at sampling points and
interpolated to the integration points; for the plain element the sampling points are the integration points and the
interpolation is the identity. Arrays have points last, so that inner loops run over points.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from skancf.theories.full import N_IN_PLANE, N_STRAINS
from skancf.theories.full_point import INNER, OPTIONS, in_plane, in_plane_force, in_plane_stiffness

N_SAMPLED = N_STRAINS - N_IN_PLANE
N_POINTS = 16
COMPONENTS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])


class Elements(NamedTuple):
    """What differs between elements.

    ``nodes`` (n, 4); the map from nodal coordinates to local vectors as triples: those of element e are
    ``pointer[e]:pointer[e + 1]``, c[``rows``] += ``values`` * the vector ``kinds`` of the corner ``corners``;
    ``shape`` (n,), the class of equal undeformed elements; for each class the undeformed strains ``reference``
    (n_shapes, 14, n_points), the law with the weights ``law`` (n_shapes, n_pairs, n_points), and the law of the sampled
    strains ``sampled`` (n_shapes, n_rows, n_rows).
    """

    nodes: np.ndarray
    pointer: np.ndarray
    rows: np.ndarray
    corners: np.ndarray
    kinds: np.ndarray
    values: np.ndarray
    shape: np.ndarray
    reference: np.ndarray
    law: np.ndarray
    sampled: np.ndarray


class Rule(NamedTuple):
    """What elements share.

    ``position`` (12, 2, n_points): r_1 and r_2 of the functions of r, ``director`` (4, 2, n_points): d_1 and d_2; both
    also with their points repeated, ``position_twice`` (12, 2, 32), and as columns, ``position_columns`` (32, 12).
    ``sample_position`` (2, n_samples, 12), ``sample_director`` (3, n_samples, 4): d_1, d_2, d at the sampling points.
    ``interpolation`` (5, n_samples, n_points), and whether it is the identity, ``plain``. ``sample_rows`` (n_rows, 2):
    strain (0 to 4) and sampling point of each sampled strain. ``pairs`` (n_pairs, 2): k <= l of the entries of the law
    that are not zero. ``coupled``: whether the law couples in-plane and sampled strains.
    """

    position: np.ndarray
    director: np.ndarray
    position_twice: np.ndarray
    director_twice: np.ndarray
    position_columns: np.ndarray
    director_columns: np.ndarray
    sample_position: np.ndarray
    sample_director: np.ndarray
    interpolation: np.ndarray
    plain: bool
    sample_rows: np.ndarray
    pairs: np.ndarray
    coupled: bool


@njit(**INNER)
def gather(e, q, elements, local):
    """Local vectors (16, 3) of element e from nodal coordinates (n_nodes, 4, 3)."""
    local[:] = 0.0
    for k in range(elements.pointer[e], elements.pointer[e + 1]):
        a, v = elements.rows[k], elements.values[k]
        n, kind = elements.nodes[e, elements.corners[k]], elements.kinds[k]
        for i in range(3):
            local[a, i] += v * q[n, kind, i]


@njit(**INNER)
def in_plane_jets(rule, local, out):
    """r_1, r_2, d_1, d_2 at the integration points: out (4, 3, 16)."""
    out[:] = 0.0
    for j in range(2):
        for i in range(3):
            for a in range(12):
                v = local[a, i]
                for p in range(N_POINTS):
                    out[j, i, p] += v * rule.position[a, j, p]
            for a in range(4):
                v = local[12 + a, i]
                for p in range(N_POINTS):
                    out[2 + j, i, p] += v * rule.director[a, j, p]


@njit(**INNER)
def sample_jets(rule, local, out):
    """r_1, r_2, d_1, d_2, d at the sampling points: out (n_samples, 5, 3)."""
    for s in range(out.shape[0]):
        for i in range(3):
            r1 = r2 = d1 = d2 = d = 0.0
            for a in range(12):
                r1 += local[a, i] * rule.sample_position[0, s, a]
                r2 += local[a, i] * rule.sample_position[1, s, a]
            for a in range(4):
                v = local[12 + a, i]
                d1 += v * rule.sample_director[0, s, a]
                d2 += v * rule.sample_director[1, s, a]
                d += v * rule.sample_director[2, s, a]
            out[s, 0, i], out[s, 1, i], out[s, 2, i], out[s, 3, i], out[s, 4, i] = r1, r2, d1, d2, d


@njit(**INNER)
def vectors(x, p):
    """The jet at a point as tuples."""
    return (
        (x[0, 0, p], x[0, 1, p], x[0, 2, p]), (x[1, 0, p], x[1, 1, p], x[1, 2, p]),
        (x[2, 0, p], x[2, 1, p], x[2, 2, p]), (x[3, 0, p], x[3, 1, p], x[3, 2, p]),
    )  # fmt: skip


@njit(**INNER)
def strains(rule, x, y, sx, sy, reference, eps):
    """The strains' symmetric bilinear form at two jets less the undeformed strains: eps (14, 16)."""
    for p in range(N_POINTS):
        e = in_plane(vectors(x, p), vectors(y, p))
        eps[0, p], eps[1, p], eps[2, p] = e[0] - reference[0, p], e[1] - reference[1, p], e[2] - reference[2, p]
        eps[3, p], eps[4, p], eps[5, p] = e[3] - reference[3, p], e[4] - reference[4, p], e[5] - reference[5, p]
        eps[6, p], eps[7, p], eps[8, p] = e[6] - reference[6, p], e[7] - reference[7, p], e[8] - reference[8, p]
    for k in range(N_SAMPLED):
        row = eps[N_IN_PLANE + k]
        for p in range(N_POINTS):
            row[p] = -reference[N_IN_PLANE + k, p]
    for r in range(rule.sample_rows.shape[0]):
        k, s = rule.sample_rows[r]
        value = 0.0
        for i in range(3):
            value += sx[s, k, i] * sy[s, 4, i] + sx[s, 4, i] * sy[s, k, i]
        value *= 0.25 if k == 4 else 0.5
        if rule.plain:
            eps[N_IN_PLANE + k, s] += value
        else:
            row, weight = eps[N_IN_PLANE + k], rule.interpolation[k, s]
            for p in range(N_POINTS):
                row[p] += value * weight[p]


@njit(**INNER)
def apply_law(rule, law, eps, stress):
    """Stress (14, 16) with the weights."""
    stress[:] = 0.0
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        for p in range(N_POINTS):
            stress[k, p] += law[m, p] * eps[l, p]
        if k != l:
            for p in range(N_POINTS):
                stress[l, p] += law[m, p] * eps[k, p]


@njit(**INNER)
def collect(rule, stress, sampled):
    """Stresses of the sampled strains, by the transposed interpolation: sampled (n_rows,)."""
    for r in range(rule.sample_rows.shape[0]):
        k, s = rule.sample_rows[r]
        if rule.plain:
            sampled[r] = stress[N_IN_PLANE + k, s]
            continue
        total = 0.0
        for p in range(N_POINTS):
            total += rule.interpolation[k, s, p] * stress[N_IN_PLANE + k, p]
        sampled[r] = total


@njit(**INNER)
def in_plane_stress(stress, p):
    return (
        stress[0, p], stress[1, p], stress[2, p], stress[3, p], stress[4, p],
        stress[5, p], stress[6, p], stress[7, p], stress[8, p],
    )  # fmt: skip


@njit(**OPTIONS)
def stresses(start, stop, order, q, change, rule, elements, strain_out, out):
    """Strain and stress extrapolated linearly along ``change``, strain(q) + B(q) change; the stress has the weights.

    Into ``strain_out`` (n_elements, 14, 16), or nowhere if that is empty, and ``out``.
    """
    n_samples = rule.sample_position.shape[1]
    local, moved = np.empty((16, 3)), np.empty((16, 3))
    x, y = np.empty((4, 3, N_POINTS)), np.empty((4, 3, N_POINTS))
    sx, sy = np.empty((n_samples, 5, 3)), np.empty((n_samples, 5, 3))
    eps = np.empty((N_STRAINS, N_POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, elements, local)
        gather(e, change, elements, moved)
        # For quadratic strains strain(q) + B(q) change is the bilinear form at q and q + 2 change.
        for a in range(16):
            for i in range(3):
                moved[a, i] = local[a, i] + 2.0 * moved[a, i]
        in_plane_jets(rule, local, x)
        in_plane_jets(rule, moved, y)
        sample_jets(rule, local, sx)
        sample_jets(rule, moved, sy)
        strains(rule, x, y, sx, sy, elements.reference[c], eps)
        apply_law(rule, elements.law[c], eps, out[e])
        if strain_out.shape[0]:
            for k in range(N_STRAINS):
                for p in range(N_POINTS):
                    strain_out[e, k, p] = eps[k, p]


@njit(**INNER)
def sampled_gradient(rule, sx, B):
    """Gradient of the sampled strains with respect to the local vectors: B (n_rows, 48), components outermost."""
    for r in range(rule.sample_rows.shape[0]):
        k, s = rule.sample_rows[r]
        for i in range(3):
            d, other, row = sx[s, 4, i], sx[s, k, i], B[r, 16 * i : 16 * i + 16]
            if k < 2:
                for a in range(12):
                    row[a] = d * rule.sample_position[k, s, a]
                for a in range(4):
                    row[12 + a] = other * rule.sample_director[2, s, a]
            else:
                for a in range(12):
                    row[a] = 0.0
                for a in range(4):
                    row[12 + a] = d * rule.sample_director[k - 2, s, a]
                    if k < 4:
                        row[12 + a] += other * rule.sample_director[2, s, a]


@njit(**INNER)
def sampled_geometric(rule, sampled, G):
    """Stress . second derivative of the sampled strains: G (16, 16), the same for the three components."""
    G[:] = 0.0
    for r in range(rule.sample_rows.shape[0]):
        k, s = rule.sample_rows[r]
        stress, d = sampled[r], rule.sample_director[2, s]
        if k < 2:
            for a in range(12):
                v = stress * rule.sample_position[k, s, a]
                for b in range(4):
                    G[a, 12 + b] += v * d[b]
                    G[12 + b, a] += v * d[b]
        else:
            other, half = rule.sample_director[k - 2, s], 0.5 if k == 4 else 1.0
            for a in range(4):
                for b in range(4):
                    G[12 + a, 12 + b] += half * stress * (other[a] * d[b] + d[a] * other[b])


@njit(**INNER)
def coupling(rule, law, x, X):
    """X (n_rows, 48): change of the sampled stresses with the local vectors through the in-plane strains."""
    X[:] = 0.0
    on_jets = np.empty((4, 3, N_POINTS))
    unit = np.zeros(N_IN_PLANE)
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        if k < N_IN_PLANE <= l:
            unit[:] = 0.0
            unit[k] = 1.0
            for p in range(N_POINTS):
                f = in_plane_force(vectors(x, p), (unit[0], unit[1], unit[2], unit[3], unit[4],
                                                   unit[5], unit[6], unit[7], unit[8]))  # fmt: skip
                for j in range(4):
                    for i in range(3):
                        on_jets[j, i, p] = f[j][i] * law[m, p]
            for r in range(rule.sample_rows.shape[0]):
                if rule.sample_rows[r, 0] == l - N_IN_PLANE:
                    weight = rule.interpolation[l - N_IN_PLANE, rule.sample_rows[r, 1]]
                    for i in range(3):
                        for j in range(2):
                            for p in range(N_POINTS):
                                v, w = weight[p] * on_jets[j, i, p], weight[p] * on_jets[2 + j, i, p]
                                for a in range(12):
                                    X[r, 16 * i + a] += v * rule.position[a, j, p]
                                for a in range(4):
                                    X[r, 16 * i + 12 + a] += w * rule.director[a, j, p]


@njit(**INNER)
def unpack(rule, law, square):
    """The in-plane law as an array (9, 9, 16), of which the entries that are zero are left alone."""
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m]
        if l < N_IN_PLANE:
            for p in range(N_POINTS):
                square[k, l, p] = square[l, k, p] = law[m, p]


@njit(**INNER)
def weight_rows(H, half, rule, W):
    """W (96, 32) = table^T H: derivatives with respect to local vectors on one side and two of the jets on the other.

    Rows: component, local function; columns: jet and point. ``half`` is 0 for the jets r_1, r_2 and 1 for d_1, d_2.
    """
    shift = 2 * N_POINTS * half
    for c in range(6):
        for a in range(12):
            for k in range(2 * N_POINTS):
                W[16 * c + a, k] = (rule.position_twice[a, 0, k] * H[0, c, shift + k]
                                    + rule.position_twice[a, 1, k] * H[1, c, shift + k])  # fmt: skip
        for a in range(4):
            for k in range(2 * N_POINTS):
                W[16 * c + 12 + a, k] = (rule.director_twice[a, 0, k] * H[2, c, shift + k]
                                         + rule.director_twice[a, 1, k] * H[3, c, shift + k])  # fmt: skip


@njit(**INNER)
def sampled_stiffness(e, rule, elements, B, MB):
    """MB = law of the sampled strains times their gradient B (n_rows, 48)."""
    c = elements.shape[e]
    if not rule.plain:
        np.dot(elements.sampled[c], B, MB)
        return
    MB[:] = 0.0
    for m in range(rule.pairs.shape[0]):
        k, l = rule.pairs[m, 0] - N_IN_PLANE, rule.pairs[m, 1] - N_IN_PLANE
        if k >= 0:
            for s in range(N_POINTS):
                weight = elements.law[c, m, s]
                for a in range(48):
                    MB[N_POINTS * k + s, a] += weight * B[N_POINTS * l + s, a]
                if k != l:
                    for a in range(48):
                        MB[N_POINTS * l + s, a] += weight * B[N_POINTS * k + s, a]


@njit(**INNER)
def scatter_tangent(e, elements, slots, K, out):
    """Adds an element's tangent, K (48, 48) of which i <= j is used, to the upper blocks, out (n_blocks, 12, 12)."""
    for k in range(elements.pointer[e], elements.pointer[e + 1]):
        a, v, row = elements.rows[k], elements.values[k], 3 * elements.kinds[k]
        slot_row = slots[e, elements.corners[k]]
        for l in range(elements.pointer[e], elements.pointer[e + 1]):
            slot = slot_row[elements.corners[l]]
            if slot >= 0:
                b, w, col = elements.rows[l], v * elements.values[l], 3 * elements.kinds[l]
                block = out[slot]
                block[row, col] += w * K[a, b]
                block[row, col + 1] += w * K[a, 16 + b]
                block[row, col + 2] += w * K[a, 32 + b]
                block[row + 1, col] += w * K[b, 16 + a]
                block[row + 1, col + 1] += w * K[16 + a, 16 + b]
                block[row + 1, col + 2] += w * K[16 + a, 32 + b]
                block[row + 2, col] += w * K[b, 32 + a]
                block[row + 2, col + 1] += w * K[16 + b, 32 + a]
                block[row + 2, col + 2] += w * K[32 + a, 32 + b]


@njit(**OPTIONS)
def tangent(start, stop, order, q, stress, rule, elements, slots, out):
    """Tangent with the given stresses (n_elements, 14, 16), added to out (n_blocks, 12, 12)."""
    n_samples, n_rows = rule.sample_position.shape[1], rule.sample_rows.shape[0]
    local, x, sx = np.empty((16, 3)), np.empty((4, 3, N_POINTS)), np.empty((n_samples, 5, 3))
    square = np.zeros((N_IN_PLANE, N_IN_PLANE, N_POINTS))
    H, W = np.empty((4, 6, 4 * N_POINTS)), np.empty((96, 2 * N_POINTS))
    of_r, of_d = np.empty((96, 12)), np.empty((96, 4))
    K, G, sampled = np.empty((48, 48)), np.empty((16, 16)), np.empty(n_rows)
    B, MB = np.empty((n_rows, 48)), np.empty((n_rows, 48))
    X, XB = np.empty((n_rows, 48)), np.empty((48, 48))
    for index in range(start, stop):
        e = order[index]
        law = elements.law[elements.shape[e]]
        gather(e, q, elements, local)
        in_plane_jets(rule, local, x)
        sample_jets(rule, local, sx)
        unpack(rule, law, square)
        for p in range(N_POINTS):
            in_plane_stiffness(square, p, vectors(x, p), in_plane_stress(stress[e], p), H)
        weight_rows(H, 0, rule, W)
        np.dot(W, rule.position_columns, of_r)
        weight_rows(H, 1, rule, W)
        np.dot(W, rule.director_columns, of_d)
        collect(rule, stress[e], sampled)
        sampled_gradient(rule, sx, B)
        sampled_stiffness(e, rule, elements, B, MB)
        np.dot(B.T, MB, K)
        if rule.coupled:
            coupling(rule, law, x, X)
            np.dot(X.T, B, XB)
            for a in range(48):
                for b in range(48):
                    K[a, b] += XB[a, b] + XB[b, a]
        sampled_geometric(rule, sampled, G)
        for c in range(6):
            i, j = 16 * COMPONENTS[c, 0], 16 * COMPONENTS[c, 1]
            for a in range(16):
                row = K[i + a]
                for b in range(12):
                    row[j + b] += of_r[16 * c + a, b]
                for b in range(4):
                    row[j + 12 + b] += of_d[16 * c + a, b]
                if c < 3:
                    for b in range(16):
                        row[j + b] += G[a, b]
        scatter_tangent(e, elements, slots, K, out)


@njit(**OPTIONS)
def mass(start, stop, order, shapes, elements, slots, out):
    """Adds the classes' mass matrices (n_shapes, 16, 16), the same for the three components."""
    K = np.zeros((48, 48))
    for index in range(start, stop):
        e = order[index]
        for i in range(0, 48, 16):
            for a in range(16):
                for b in range(16):
                    K[i + a, i + b] = shapes[elements.shape[e], a, b]
        scatter_tangent(e, elements, slots, K, out)
