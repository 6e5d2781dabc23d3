"""Compiled tangent of theory `full`; strains and tables are those of :mod:`skancf.theories.full.kernels`."""

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, CORNERS, FUNCTIONS, LOCAL, POINTS
from skancf.kernels.gather import gather, prefetch_blocks, scatter_tangent
from skancf.kernels.panels import add_panel, aligned, set_panel
from skancf.theories.full.kernels import collect, in_plane_jets, sample_jets, vectors
from skancf.theories.full.nodes import N_POSITION
from skancf.theories.full.point import in_plane_force, in_plane_stiffness
from skancf.theories.full.theory import N_IN_PLANE

COMPONENTS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])
PARTS = len(COMPONENTS)
N_JETS = 4
OF_JETS = N_JETS * POINTS
OF_FUNCTIONS = PARTS * FUNCTIONS
PAIRS, ON_DIRECTORS = FUNCTIONS * FUNCTIONS, CORNERS * FUNCTIONS
"""Sizes of arrays with all jets at all points, with all upper components, with all pairs of functions, and of those with
directors."""


@compiled(**INNER)
def in_plane_stress(stress, p):
    return (
        stress[0, p], stress[1, p], stress[2, p], stress[3, p], stress[4, p],
        stress[5, p], stress[6, p], stress[7, p], stress[8, p],
    )  # fmt: skip


@compiled(**INNER)
def sampled_gradient(tables, sx, B):
    """Gradient of the sampled strains with respect to the local vectors: B (n_rows, 48), components outermost."""
    for r in range(tables.sample_rows.shape[0]):
        k, s = tables.sample_rows[r]
        for i in range(3):
            d, other, row = sx[s, 4, i], sx[s, k, i], B[r, FUNCTIONS * i : FUNCTIONS * (i + 1)]
            if k < 2:
                for a in range(N_POSITION):
                    row[a] = d * tables.sample_position[k, s, a]
                for a in range(CORNERS):
                    row[N_POSITION + a] = other * tables.sample_director[2, s, a]
            else:
                for a in range(N_POSITION):
                    row[a] = 0.0
                for a in range(CORNERS):
                    row[N_POSITION + a] = d * tables.sample_director[k - 2, s, a]
                    if k < 4:
                        row[N_POSITION + a] += other * tables.sample_director[2, s, a]


@compiled(**INNER)
def sampled_geometric(tables, sampled, G):
    """Stress . second derivative of the sampled strains: G (16, 16), the same for the three components."""
    G[:] = 0.0
    for r in range(tables.sample_rows.shape[0]):
        k, s = tables.sample_rows[r]
        stress, d = sampled[r], tables.sample_director[2, s]
        if k < 2:
            for a in range(N_POSITION):
                v = stress * tables.sample_position[k, s, a]
                for b in range(CORNERS):
                    G[a, N_POSITION + b] += v * d[b]
                    G[N_POSITION + b, a] += v * d[b]
        else:
            other, half = tables.sample_director[k - 2, s], 0.5 if k == 4 else 1.0
            for a in range(CORNERS):
                for b in range(CORNERS):
                    G[N_POSITION + a, N_POSITION + b] += half * stress * (other[a] * d[b] + d[a] * other[b])


@compiled(**INNER)
def coupling(tables, law, x, X):
    """X (n_rows, 48): change of the sampled stresses with the local vectors through the in-plane strains."""
    X[:] = 0.0
    on_jets = np.empty((N_JETS, AXES, POINTS))
    unit = np.zeros(N_IN_PLANE)
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m]
        if k < N_IN_PLANE <= l:
            unit[:] = 0.0
            unit[k] = 1.0
            for p in range(POINTS):
                f = in_plane_force(vectors(x, p), (unit[0], unit[1], unit[2], unit[3], unit[4],
                                                   unit[5], unit[6], unit[7], unit[8]))  # fmt: skip
                for j in range(4):
                    for i in range(3):
                        on_jets[j, i, p] = f[j][i] * law[m, p]
            for r in range(tables.sample_rows.shape[0]):
                if tables.sample_rows[r, 0] == l - N_IN_PLANE:
                    weight = tables.interpolation[l - N_IN_PLANE, tables.sample_rows[r, 1]]
                    for i in range(3):
                        for j in range(2):
                            for p in range(POINTS):
                                v, w = weight[p] * on_jets[j, i, p], weight[p] * on_jets[2 + j, i, p]
                                for a in range(N_POSITION):
                                    X[r, FUNCTIONS * i + a] += v * tables.position[a, j, p]
                                for a in range(CORNERS):
                                    X[r, FUNCTIONS * i + N_POSITION + a] += w * tables.director[a, j, p]


@compiled(**INNER)
def unpack(tables, law, square):
    """The in-plane law as an array (9, 9, 16), of which the entries that are zero are left alone."""
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m]
        if l < N_IN_PLANE:
            for p in range(POINTS):
                square[k, l, p] = square[l, k, p] = law[m, p]


@compiled(**INNER)
def add_in_plane(tables, H, W, of_d, Y):
    """Adds table^T H table, with the tables of the functions of r on the right, to Y (96, 16), rows component and function.

    What the functions of d on the right make is of_d (24, 16), rows component and function of d. W (32, 96) is scratch: H
    table, rows jet and point.
    """
    for half in range(2):
        for k in range(2 * POINTS):
            at, table, row = 2 * POINTS * half + k, N_JETS * FUNCTIONS * (k % POINTS), OF_FUNCTIONS * k
            set_panel(6, N_JETS, H, at, PARTS * OF_JETS, OF_JETS, tables.jets, table, FUNCTIONS, W, row, FUNCTIONS)
        if half == 0:
            for row in range(0, OF_FUNCTIONS, 6):
                at = FUNCTIONS * row
                add_panel(6, 2 * POINTS, W, row, OF_FUNCTIONS, 1, tables.position_columns, 0, FUNCTIONS, Y, at, FUNCTIONS)
        else:
            for c in range(PARTS):
                at, row = FUNCTIONS * c, ON_DIRECTORS * c
                set_panel(4, 2 * POINTS, tables.director_columns, 0, CORNERS, 1, W, at, OF_FUNCTIONS, of_d, row, FUNCTIONS)


@compiled(**INNER)
def sampled_stiffness(e, tables, elements, B, MB):
    """MB = law of the sampled strains times their gradient B (n_rows, 48)."""
    c = elements.shape[e]
    if not tables.plain:
        n_rows = B.shape[0]
        for row in range(0, n_rows, 4):
            at = (c * n_rows + row) * n_rows
            for i in range(0, LOCAL, FUNCTIONS):
                set_panel(4, n_rows, elements.sampled, at, 1, n_rows, B, i, LOCAL, MB, LOCAL * row + i, LOCAL)
        return
    MB[:] = 0.0
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m, 0] - N_IN_PLANE, tables.pairs[m, 1] - N_IN_PLANE
        if k >= 0:
            for s in range(POINTS):
                weight = elements.law[c, m, s]
                for a in range(LOCAL):
                    MB[POINTS * k + s, a] += weight * B[POINTS * l + s, a]
                if k != l:
                    for a in range(LOCAL):
                        MB[POINTS * l + s, a] += weight * B[POINTS * k + s, a]


@compiled(**OPTIONS)
def tangent(start, stop, order, q, stress, tables, maps, elements, slots, out):
    """Tangent with the given stresses (n_elements, 14, 16), added to out (n_blocks, 12, 12)."""
    n_samples, n_rows = tables.sample_position.shape[1], tables.sample_rows.shape[0]
    local, x, sx = np.empty((FUNCTIONS, AXES)), np.empty((N_JETS, AXES, POINTS)), np.empty((n_samples, 5, 3))
    square = np.zeros((N_IN_PLANE, N_IN_PLANE, POINTS))
    H, W = np.empty((N_JETS, PARTS, OF_JETS)), aligned(2 * POINTS, OF_FUNCTIONS)
    of_d = aligned(PARTS * CORNERS, FUNCTIONS)
    K, Y = np.empty((LOCAL, LOCAL)), aligned(OF_FUNCTIONS, FUNCTIONS)
    G, sampled = np.empty((FUNCTIONS, FUNCTIONS)), np.empty(n_rows)
    B, MB, X = aligned(n_rows, LOCAL), aligned(n_rows, LOCAL), aligned(n_rows, LOCAL)
    for index in range(start, stop):
        e = order[index]
        law = elements.law[elements.shape[e]]
        prefetch_blocks(e, slots, out)
        gather(e, q, maps, local)
        in_plane_jets(tables, local, x)
        sample_jets(tables, local, sx)
        unpack(tables, law, square)
        for p in range(POINTS):
            in_plane_stiffness(square, p, vectors(x, p), in_plane_stress(stress[e], p), H)
        collect(tables, stress[e], sampled)
        sampled_gradient(tables, sx, B)
        sampled_stiffness(e, tables, elements, B, MB)
        for c in range(PARTS):
            i, j = COMPONENTS[c]
            for a in range(0, FUNCTIONS, 8):
                row, column, at = FUNCTIONS * i + a, FUNCTIONS * j, PAIRS * c + FUNCTIONS * a
                set_panel(8, n_rows, B, row, LOCAL, 1, MB, column, LOCAL, Y, at, FUNCTIONS)
        if tables.coupled:
            coupling(tables, law, x, X)
            for c in range(PARTS):
                i, j = COMPONENTS[c]
                for a in range(0, FUNCTIONS, 8):
                    row, column, at = FUNCTIONS * i + a, FUNCTIONS * j, PAIRS * c + FUNCTIONS * a
                    add_panel(8, n_rows, X, row, LOCAL, 1, B, column, LOCAL, Y, at, FUNCTIONS)
                    add_panel(8, n_rows, B, row, LOCAL, 1, X, column, LOCAL, Y, at, FUNCTIONS)
        add_in_plane(tables, H, W, of_d, Y)
        sampled_geometric(tables, sampled, G)
        for c in range(PARTS):
            i, j = FUNCTIONS * COMPONENTS[c, 0], FUNCTIONS * COMPONENTS[c, 1]
            for a in range(FUNCTIONS):
                for b in range(FUNCTIONS):
                    K[i + a, j + b] = Y[FUNCTIONS * c + a, b]
                for b in range(CORNERS):
                    K[i + a, j + N_POSITION + b] += of_d[CORNERS * c + b, a]
                if c < 3:
                    for b in range(FUNCTIONS):
                        K[i + a, j + b] += G[a, b]
        scatter_tangent(e, maps, slots, K, out)
