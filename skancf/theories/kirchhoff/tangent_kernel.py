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
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL, POINTS
from skancf.kernels.gather import gather, prefetch_blocks, scatter_tangent
from skancf.kernels.panels import add_panel, aligned, set_panel
from skancf.theories.kirchhoff.kernels import (
    JET,
    JETS,
    N_JETS,
    N_MEMBRANE,
    N_STRAINS,
    ON_2,
    ON_11,
    ON_12,
    ON_22,
    TABLE,
    gauss_slopes,
    jets,
    surface,
)

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
PARTS = 9
"""Components of Y, and of the gradients of three strains."""
OF_POINTS, OF_FUNCTIONS = PARTS * POINTS, PARTS * FUNCTIONS
PAIRS = FUNCTIONS * FUNCTIONS
"""Sizes of arrays with all components, and with all pairs of functions."""
LAW, BENDING = N_STRAINS * POINTS, (N_STRAINS + 1) * N_MEMBRANE * POINTS
"""Steps from row to row of the law, and where its bending part begins."""


@compiled(**INNER)
def unpack(tables, law, square):
    """The law, with the signs and factors of the gradients, as an array (6, 6, 16)."""
    square[:] = 0.0
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m]
        factor = FACTORS[k] * FACTORS[l]
        for p in range(POINTS):
            square[k, l, p] = square[l, k, p] = factor * law[m, p]


@compiled(**INNER)
def second_by_second(tables, kind, square, gamma, scratch, S):
    """N_k D_kl N_l at each point, of N_k less gamma times the first derivatives: S (16, 256); scratch (6, 16)."""
    for p in range(POINTS):
        for k in range(3):
            for a in range(FUNCTIONS):
                scratch[k, a] = (tables.jets[kind, ON_11 + POINTS * k + p, a] - gamma[k, 0, p] * tables.jets[kind, p, a]
                                 - gamma[k, 1, p] * tables.jets[kind, ON_2 + p, a])  # fmt: skip
        set_panel(3, 3, square, BENDING + p, POINTS, LAW, scratch, 0, FUNCTIONS, scratch, 3 * FUNCTIONS, FUNCTIONS)
        for a in range(0, FUNCTIONS, 8):
            at = PAIRS * p + FUNCTIONS * a
            set_panel(8, 3, scratch, a, FUNCTIONS, 1, scratch, 3 * FUNCTIONS, FUNCTIONS, S, at, FUNCTIONS)


@compiled(**INNER)
def kept_law(tables, kind, square, rest, C):
    """One of the next two, by what the rest has: known when this is compiled."""
    if rest.ndim == 1:
        kept_law_with(tables, kind, square, rest, C)
    else:
        kept_law_beside(tables, kind, square, rest, C)


@compiled(**INNER)
def kept_law_with(tables, kind, square, rest, C):
    """C (16, 16), half the law of the coefficients of the assumed strains with that of the rest; the membrane law becomes
    that of the rest."""
    for k in range(3):
        for l in range(3):
            scale = rest[k] * rest[l]
            for r in range(KEPT[k], KEPT[k + 1]):
                for s in range(KEPT[l], KEPT[l + 1]):
                    total = 0.0
                    for p in range(POINTS):
                        total += tables.kept[kind, r, p] * square[k, l, p] * tables.kept[kind, s, p]
                    C[r, s] = 0.5 * (1.0 + scale) * total
            for p in range(POINTS):
                square[k, l, p] *= scale


@compiled(**INNER)
def kept_law_beside(tables, kind, square, rest, C):
    """As :func:`kept_law_with` where the rest has a law of its own, (3, 3, 16), which the membrane law becomes."""
    for k in range(3):
        for l in range(3):
            for r in range(KEPT[k], KEPT[k + 1]):
                for s in range(KEPT[l], KEPT[l + 1]):
                    total = 0.0
                    for p in range(POINTS):
                        both = square[k, l, p] + rest[k, l, p]
                        total += tables.kept[kind, r, p] * both * tables.kept[kind, s, p]
                    C[r, s] = 0.5 * total
            for p in range(POINTS):
                square[k, l, p] = rest[k, l, p]


@compiled(**INNER)
def membrane_forces(x, square, z):
    """Law times gradients of the membrane strains, less the tables: z (2, 9, 16), first derivative, strain and component."""
    for k in range(3):
        for j in range(3):
            for p in range(POINTS):
                u, v = x[j, p], x[j, ON_2 + p]
                z[0, 3 * k + j, p] = square[k, 0, p] * u + square[k, 2, p] * v
                z[1, 3 * k + j, p] = square[k, 1, p] * v + square[k, 2, p] * u


@compiled(**INNER)
def coefficients(x, n, duals, gamma, square, stress, shared, z, E, scratch):
    """E (2, 5, 9, 16): of N_J in A^g, by g and J. S has the second derivatives alone if ``shared`` is 1, all if it is 0."""
    cross, on, H, bending = scratch[:6], scratch[6:8], scratch[8:12], scratch[12]
    for p in range(POINTS):
        m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
        on[0, p] = m11 * gamma[0, 0, p] + m22 * gamma[1, 0, p] + m12 * gamma[2, 0, p]
        on[1, p] = m11 * gamma[0, 1, p] + m22 * gamma[1, 1, p] + m12 * gamma[2, 1, p]
        bending[p] = (
            n[0, p] * (m11 * x[0, ON_11 + p] + m22 * x[0, ON_22 + p] + m12 * x[0, ON_12 + p])
            + n[1, p] * (m11 * x[1, ON_11 + p] + m22 * x[1, ON_22 + p] + m12 * x[1, ON_12 + p])
            + n[2, p] * (m11 * x[2, ON_11 + p] + m22 * x[2, ON_22 + p] + m12 * x[2, ON_12 + p])
        )
    for g in range(2):
        for k in range(3):
            for p in range(POINTS):
                cross[3 * g + k, p] = -shared * (square[3 + k, 3, p] * gamma[0, g, p] + square[3 + k, 4, p] * gamma[1, g, p]
                                                 + square[3 + k, 5, p] * gamma[2, g, p])  # fmt: skip
    for g in range(2):
        for d in range(2):
            for p in range(POINTS):
                metric = duals[d, 0, p] * duals[g, 0, p] + duals[d, 1, p] * duals[g, 1, p] + duals[d, 2, p] * duals[g, 2, p]
                law = (gamma[0, d, p] * cross[3 * g, p] + gamma[1, d, p] * cross[3 * g + 1, p]
                       + gamma[2, d, p] * cross[3 * g + 2, p])  # fmt: skip
                H[2 * g + d, p] = 0.5 * (bending[p] * metric - law)
    for c in range(9):
        i, j = FIRST[c], SECOND[c]
        same = 0.5 if i == j else 0.0
        for g in range(2):
            for p in range(POINTS):
                u, v, nn, tilt = x[i, p], x[i, ON_2 + p], n[i, p] * n[j, p], n[j, p] * duals[g, i, p]
                E[g, 0, c, p] = (0.5 * (u * z[g, j, p] + v * z[g, 6 + j, p]) + same * stress[2 * g, p]
                                 + nn * H[2 * g, p] - tilt * on[0, p])  # fmt: skip
                E[g, 1, c, p] = (0.5 * (v * z[g, 3 + j, p] + u * z[g, 6 + j, p]) + same * stress[2 - g, p]
                                 + nn * H[2 * g + 1, p] - tilt * on[1, p])  # fmt: skip
                E[g, 2, c, p] = tilt * stress[3, p] + nn * cross[3 * g, p]
                E[g, 3, c, p] = tilt * stress[4, p] + nn * cross[3 * g + 1, p]
                E[g, 4, c, p] = tilt * 2.0 * stress[5, p] + nn * cross[3 * g + 2, p]


@compiled(**INNER)
def membrane_gradient(tables, kind, x, of_first, M):
    """Gradients of the membrane strains: M (48, 48), rows point and strain, columns component and function.

    ``of_first`` (2, 9, 16) is scratch: what the first derivatives are multiplied by.
    """
    for i in range(3):
        for p in range(POINTS):
            u, v = x[i, p], x[i, ON_2 + p]
            of_first[0, i, p], of_first[0, 3 + i, p], of_first[0, 6 + i, p] = u, 0.0, v
            of_first[1, i, p], of_first[1, 3 + i, p], of_first[1, 6 + i, p] = 0.0, v, u
    for p in range(POINTS):
        table = TABLE * kind + FUNCTIONS * p
        set_panel(9, 2, of_first, p, OF_POINTS, POINTS, tables.jets, table, JET, M, OF_FUNCTIONS * p, FUNCTIONS)


@compiled(**INNER)
def membrane_rest(tables, kind, n, gamma, square, z, coupled, T):
    """T (48, 48), rows as those of M: what the curvatures add to the membrane stresses, less those of ``z``."""
    of_jets = np.empty((5, 9, POINTS))
    for k in range(3):
        for i in range(3):
            at = 3 * k + i
            for p in range(POINTS):
                of_jets[0, at, p], of_jets[1, at, p] = -z[0, at, p], -z[1, at, p]
            if coupled:
                for l in range(3):
                    for p in range(POINTS):
                        value = square[k, 3 + l, p] * n[i, p]
                        of_jets[2 + l, at, p] = value
                        of_jets[0, at, p] -= value * gamma[l, 0, p]
                        of_jets[1, at, p] -= value * gamma[l, 1, p]
    for p in range(POINTS):
        table, at = TABLE * kind + FUNCTIONS * p, OF_FUNCTIONS * p
        n_jets = N_JETS if coupled else 2
        set_panel(9, n_jets, of_jets, p, OF_POINTS, POINTS, tables.jets, table, JET, T, at, FUNCTIONS)


@compiled(**INNER)
def add_first_derivatives(tables, kind, E, slopes, A, Y):
    """Adds A^g times first derivatives, all components, to Y (144, 16); A (16, 144) is scratch."""
    for first in range(0, POINTS, HALF):
        for p in range(HALF):
            for g in range(2):
                at, row = N_JETS * OF_POINTS * g + first + p, OF_FUNCTIONS * (2 * p + g)
                table = TABLE * kind + FUNCTIONS * (first + p)
                set_panel(9, N_JETS, E, at, OF_POINTS, POINTS, tables.jets, table, JET, A, row, FUNCTIONS)
        for row in range(0, OF_FUNCTIONS, 6):
            at = 2 * FUNCTIONS * first
            add_panel(6, 2 * HALF, A, row, OF_FUNCTIONS, 1, slopes, at, FUNCTIONS, Y, FUNCTIONS * row, FUNCTIONS)


@compiled(**INNER)
def add_sampled_geometric(tables, stress, W, Y):
    """Adds half of the membrane stresses at the Gauss points times second derivatives of the strains there, the same for
    11, 22 and 33; W (32, 16) is scratch."""
    for p in range(POINTS):
        for a in range(FUNCTIONS):
            one, two = tables.slopes[0, 2 * p, a], tables.slopes[0, 2 * p + 1, a]
            W[2 * p, a] = 0.5 * (stress[6, p] * one + stress[8, p] * two)
            W[2 * p + 1, a] = 0.5 * (stress[8, p] * one + stress[7, p] * two)
    for c in range(6):
        if FIRST[c] == SECOND[c]:
            for a in range(0, FUNCTIONS, 8):
                at = PAIRS * c + FUNCTIONS * a
                add_panel(8, 2 * POINTS, W, a, FUNCTIONS, 1, tables.slopes, 0, FUNCTIONS, Y, at, FUNCTIONS)


@compiled(**INNER)
def add_assumed(tables, kind, M, T, C, G, Z, Y):
    """Adds the products of the gradients G of the coefficients of the assumed strains with Z to Y.

    M has the gradients of the strains at the Gauss points, T what is left of the stresses at the points.
    """
    of_kind = PAIRS * kind
    for i in range(0, LOCAL, FUNCTIONS):
        set_panel(6, POINTS, tables.fit, 0, 1, POINTS, M, i, OF_FUNCTIONS, G, i, LOCAL)
        set_panel(6, POINTS, tables.fit, 6 * POINTS, 1, POINTS, M, LOCAL + i, OF_FUNCTIONS, G, 6 * LOCAL + i, LOCAL)
        set_panel(4, POINTS, tables.fit, 12 * POINTS, 1, POINTS, M, 2 * LOCAL + i, OF_FUNCTIONS, G, 12 * LOCAL + i, LOCAL)
        set_panel(6, POINTS, tables.kept, of_kind, 1, POINTS, T, i, OF_FUNCTIONS, Z, i, LOCAL)
        at = of_kind + 6 * POINTS
        set_panel(6, POINTS, tables.kept, at, 1, POINTS, T, LOCAL + i, OF_FUNCTIONS, Z, 6 * LOCAL + i, LOCAL)
        at = of_kind + 12 * POINTS
        set_panel(4, POINTS, tables.kept, at, 1, POINTS, T, 2 * LOCAL + i, OF_FUNCTIONS, Z, 12 * LOCAL + i, LOCAL)
        for a in range(0, POINTS, 8):
            add_panel(8, POINTS, C, POINTS * a, 1, POINTS, G, i, LOCAL, Z, LOCAL * a + i, LOCAL)
    for c in range(PARTS):
        for a in range(0, FUNCTIONS, 8):
            first, second, at = FUNCTIONS * FIRST[c] + a, FUNCTIONS * SECOND[c], PAIRS * c + FUNCTIONS * a
            add_panel(8, POINTS, G, first, LOCAL, 1, Z, second, LOCAL, Y, at, FUNCTIONS)


@compiled(**OPTIONS)
def tangent(start, stop, order, q, stress, tables, maps, elements, slots, out):
    """Tangent with the given stresses (n_elements, 6 or 9, 16), added to out (n_blocks, 12, 12)."""
    local, x = np.empty((FUNCTIONS, AXES)), aligned(AXES, JETS)
    n, duals, gamma = np.empty((AXES, POINTS)), np.empty((2, AXES, POINTS)), np.empty((3, 2, POINTS))
    z, of_first = np.empty((2, PARTS, POINTS)), np.empty((2, PARTS, POINTS))
    E, scratch = np.empty((2, N_JETS, PARTS, POINTS)), np.empty((13, POINTS))
    S, A, Y = aligned(POINTS, PAIRS), aligned(2 * HALF, OF_FUNCTIONS), aligned(OF_FUNCTIONS, FUNCTIONS)
    K, M, T = aligned(LOCAL, LOCAL), aligned(LOCAL, LOCAL), aligned(LOCAL, LOCAL)
    G, Z, C = aligned(POINTS, LOCAL), aligned(POINTS, LOCAL), np.zeros((POINTS, POINTS))
    square, rows = np.empty((N_STRAINS, N_STRAINS, POINTS)), aligned(6, FUNCTIONS)
    slopes, W = aligned(2 * POINTS, FUNCTIONS), aligned(2 * POINTS, FUNCTIONS)
    normals, nothing = np.empty((6, POINTS)), np.zeros((3, 2, POINTS))
    coupled = False
    for m in range(tables.pairs.shape[0]):
        coupled = coupled or tables.pairs[m, 0] < 3 <= tables.pairs[m, 1]
    last, last_kind, assumed = -1, -1, False
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        kind = elements.points[c]
        if kind != last_kind:
            slopes[:] = tables.slopes[kind]
            last_kind = kind
        if c != last:
            unpack(tables, elements.law[c], square)
            assumed = elements.assumed[c] > 0
            if assumed:
                second_by_second(tables, kind, square, nothing, rows, S)
                kept_law(tables, kind, square, elements.rest[c], C)
            last = c
        prefetch_blocks(e, slots, out)
        gather(e, q, maps, local)
        jets(tables, kind, local, x)
        surface(x, n, duals, gamma)
        membrane_forces(x, square, z)
        coefficients(x, n, duals, gamma, square, stress[e], 1.0 if assumed else 0.0, z, E, scratch)
        if not assumed:
            # At a pole gamma has no bound, and the parts of the second derivatives would cancel.
            second_by_second(tables, kind, square, gamma, rows, S)
        for k in range(6):
            factor = 0.5 if FIRST[k] == SECOND[k] else 1.0
            for p in range(POINTS):
                normals[k, p] = factor * n[FIRST[k], p] * n[SECOND[k], p]
        for a in range(FUNCTIONS):
            set_panel(6, POINTS, normals, 0, 1, POINTS, S, FUNCTIONS * a, PAIRS, Y, FUNCTIONS * a, PAIRS)
        Y[6 * FUNCTIONS :] = 0.0
        add_first_derivatives(tables, kind, E, slopes, A, Y)
        if assumed or coupled:
            if not assumed:
                membrane_gradient(tables, kind, x, of_first, M)
                z[:] = 0.0
            membrane_rest(tables, kind, n, gamma, square, z, coupled, T)
        if assumed:
            if kind > 0:
                gauss_slopes(tables, local, x)
                add_sampled_geometric(tables, stress[e], W, Y)
            membrane_gradient(tables, 0, x, of_first, M)
            add_assumed(tables, kind, M, T, C, G, Z, Y)
        elif coupled:
            for part in range(PARTS):
                for a in range(0, FUNCTIONS, 8):
                    first, second, at = FUNCTIONS * FIRST[part] + a, FUNCTIONS * SECOND[part], PAIRS * part + FUNCTIONS * a
                    add_panel(8, LOCAL, M, first, LOCAL, 1, T, second, LOCAL, Y, at, FUNCTIONS)
        for k in range(6):
            i, j, other = FUNCTIONS * FIRST[k], FUNCTIONS * SECOND[k], FUNCTIONS * MIRROR[k]
            for a in range(FUNCTIONS):
                for b in range(FUNCTIONS):
                    K[i + a, j + b] = Y[FUNCTIONS * k + a, b] + Y[other + b, a]
        scatter_tangent(e, maps, slots, K, out)
