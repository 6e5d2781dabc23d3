"""Compiled assembly of theory `full`. Each kernel works on the elements ``order[start:stop]``.

In-plane strains are taken at the integration points. Shear and thickness strains are taken at sampling points and
interpolated to the integration points; for the plain element the sampling points are the integration points and the
interpolation is the identity. Arrays have points last, so that inner loops run over points.
"""

from typing import NamedTuple

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, CORNERS, FUNCTIONS, POINTS
from skancf.kernels.gather import gather
from skancf.showing import short
from skancf.theories.full.nodes import N_POSITION
from skancf.theories.full.point import in_plane
from skancf.theories.full.theory import N_IN_PLANE, N_STRAINS

N_SAMPLED = N_STRAINS - N_IN_PLANE


class Elements(NamedTuple):
    """What differs between elements.

    ``shape`` (n,), the class of equal undeformed elements; for each class the undeformed strains ``reference``
    (n_shapes, 14, n_points), the law with the weights ``law`` (n_shapes, n_pairs, n_points), and the law of the sampled
    strains ``sampled`` (n_shapes, n_rows, n_rows).
    """

    shape: np.ndarray
    reference: np.ndarray
    law: np.ndarray
    sampled: np.ndarray

    def __repr__(self) -> str:
        return short(self)


class Tables(NamedTuple):
    """What elements share.

    ``position`` (12, 2, n_points): r_1 and r_2 of the functions of r, ``director`` (4, 2, n_points): d_1 and d_2; both
    also as columns, ``position_columns`` (32, 16), of which the last four are zero, and ``director_columns`` (32, 4).
    ``jets`` (n_points, 4, 16): r_1, r_2, d_1, d_2 of all functions.
    ``sample_position`` (2, n_samples, 12), ``sample_director`` (3, n_samples, 4): d_1, d_2, d at the sampling points.
    ``interpolation`` (5, n_samples, n_points), and whether it is the identity, ``plain``. ``sample_rows`` (n_rows, 2):
    strain (0 to 4) and sampling point of each sampled strain. ``pairs`` (n_pairs, 2): k <= l of the entries of the law
    that are not zero. ``coupled``: whether the law couples in-plane and sampled strains.
    """

    position: np.ndarray
    director: np.ndarray
    position_columns: np.ndarray
    director_columns: np.ndarray
    jets: np.ndarray
    sample_position: np.ndarray
    sample_director: np.ndarray
    interpolation: np.ndarray
    plain: bool
    sample_rows: np.ndarray
    pairs: np.ndarray
    coupled: bool

    def __repr__(self) -> str:
        return short(self)


@compiled(**INNER)
def in_plane_jets(tables, local, out):
    """r_1, r_2, d_1, d_2 at the integration points: out (4, 3, 16)."""
    out[:] = 0.0
    for j in range(2):
        for i in range(3):
            for a in range(N_POSITION):
                v = local[a, i]
                for p in range(POINTS):
                    out[j, i, p] += v * tables.position[a, j, p]
            for a in range(CORNERS):
                v = local[N_POSITION + a, i]
                for p in range(POINTS):
                    out[2 + j, i, p] += v * tables.director[a, j, p]


@compiled(**INNER)
def sample_jets(tables, local, out):
    """r_1, r_2, d_1, d_2, d at the sampling points: out (n_samples, 5, 3)."""
    for s in range(out.shape[0]):
        for i in range(3):
            r1 = r2 = d1 = d2 = d = 0.0
            for a in range(N_POSITION):
                r1 += local[a, i] * tables.sample_position[0, s, a]
                r2 += local[a, i] * tables.sample_position[1, s, a]
            for a in range(CORNERS):
                v = local[N_POSITION + a, i]
                d1 += v * tables.sample_director[0, s, a]
                d2 += v * tables.sample_director[1, s, a]
                d += v * tables.sample_director[2, s, a]
            out[s, 0, i], out[s, 1, i], out[s, 2, i], out[s, 3, i], out[s, 4, i] = r1, r2, d1, d2, d


@compiled(**INNER)
def vectors(x, p):
    """The jet at a point as tuples."""
    return (
        (x[0, 0, p], x[0, 1, p], x[0, 2, p]), (x[1, 0, p], x[1, 1, p], x[1, 2, p]),
        (x[2, 0, p], x[2, 1, p], x[2, 2, p]), (x[3, 0, p], x[3, 1, p], x[3, 2, p]),
    )  # fmt: skip


@compiled(**INNER)
def strains(tables, x, y, sx, sy, reference, eps):
    """The strains' symmetric bilinear form at two jets less the undeformed strains: eps (14, 16)."""
    for p in range(POINTS):
        e = in_plane(vectors(x, p), vectors(y, p))
        eps[0, p], eps[1, p], eps[2, p] = e[0] - reference[0, p], e[1] - reference[1, p], e[2] - reference[2, p]
        eps[3, p], eps[4, p], eps[5, p] = e[3] - reference[3, p], e[4] - reference[4, p], e[5] - reference[5, p]
        eps[6, p], eps[7, p], eps[8, p] = e[6] - reference[6, p], e[7] - reference[7, p], e[8] - reference[8, p]
    for k in range(N_SAMPLED):
        row = eps[N_IN_PLANE + k]
        for p in range(POINTS):
            row[p] = -reference[N_IN_PLANE + k, p]
    for r in range(tables.sample_rows.shape[0]):
        k, s = tables.sample_rows[r]
        value = 0.0
        for i in range(3):
            value += sx[s, k, i] * sy[s, 4, i] + sx[s, 4, i] * sy[s, k, i]
        value *= 0.25 if k == 4 else 0.5
        if tables.plain:
            eps[N_IN_PLANE + k, s] += value
        else:
            row, weight = eps[N_IN_PLANE + k], tables.interpolation[k, s]
            for p in range(POINTS):
                row[p] += value * weight[p]


@compiled(**INNER)
def apply_law(tables, law, eps, stress):
    """Stress (14, 16) with the weights."""
    stress[:] = 0.0
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m]
        for p in range(POINTS):
            stress[k, p] += law[m, p] * eps[l, p]
        if k != l:
            for p in range(POINTS):
                stress[l, p] += law[m, p] * eps[k, p]


@compiled(**INNER)
def collect(tables, stress, sampled):
    """Stresses of the sampled strains, by the transposed interpolation: sampled (n_rows,)."""
    for r in range(tables.sample_rows.shape[0]):
        k, s = tables.sample_rows[r]
        if tables.plain:
            sampled[r] = stress[N_IN_PLANE + k, s]
            continue
        total = 0.0
        for p in range(POINTS):
            total += tables.interpolation[k, s, p] * stress[N_IN_PLANE + k, p]
        sampled[r] = total


@compiled(**OPTIONS)
def stresses(start, stop, order, q, change, tables, maps, elements, strain_out, out):
    """Strain and stress extrapolated linearly along ``change``, strain(q) + B(q) change; the stress has the weights.

    Into ``strain_out`` (n_elements, 14, 16), or nowhere if that is empty, and ``out``.
    """
    n_samples = tables.sample_position.shape[1]
    local, moved = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES))
    x, y = np.empty((4, 3, POINTS)), np.empty((4, 3, POINTS))
    sx, sy = np.empty((n_samples, 5, 3)), np.empty((n_samples, 5, 3))
    eps = np.empty((N_STRAINS, POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, maps, local)
        moved[:] = 0.0
        if change.shape[0]:
            gather(e, change, maps, moved)
        # For quadratic strains strain(q) + B(q) change is the bilinear form at q and q + 2 change.
        for a in range(FUNCTIONS):
            for i in range(3):
                moved[a, i] = local[a, i] + 2.0 * moved[a, i]
        in_plane_jets(tables, local, x)
        in_plane_jets(tables, moved, y)
        sample_jets(tables, local, sx)
        sample_jets(tables, moved, sy)
        strains(tables, x, y, sx, sy, elements.reference[c], eps)
        apply_law(tables, elements.law[c], eps, out[e])
        if strain_out.shape[0]:
            for k in range(N_STRAINS):
                for p in range(POINTS):
                    strain_out[e, k, p] = eps[k, p]
