"""Compiled assembly of theory `kirchhoff`; its formulas are those of :mod:`skancf.theories.kirchhoff.point`.

Each kernel works on the elements ``order[start:stop]``. Arrays have the 16 integration points last, so that inner loops
run over points.
"""

from typing import NamedTuple

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, FUNCTIONS, POINTS
from skancf.kernels.gather import gather, scatter_force
from skancf.kernels.panels import add_panel, set_panel
from skancf.showing import short

N_STRAINS, N_MEMBRANE = 6, 3
N_JETS = 5
JETS = N_JETS * POINTS
"""Columns of an array that has the jets one after the other, each at all points."""
ON_1, ON_2, ON_11, ON_22, ON_12 = range(0, JETS, POINTS)
"""Where each jet begins there."""
JET = POINTS * FUNCTIONS
TABLE = N_JETS * JET
PROJECTION = POINTS * POINTS
PROJECTIONS = N_MEMBRANE * PROJECTION
"""Sizes of the tables of one jet, and of one kind of points."""


class Elements(NamedTuple):
    """What differs between elements.

    ``shape`` (n,), the class of equal undeformed elements; for each class which kind of ``points`` it has (n_shapes,), the
    undeformed strains ``reference`` (n_shapes, 6 or 9, 16), the entries of the law with the weights ``law`` (n_shapes,
    n_pairs, 16), the number of the projection of its membrane strains, ``assumed`` (n_shapes,), 0 where they are taken as
    they are, and the roots of the factors with which the rest of the three counts, ``rest`` (n_shapes, 3).
    """

    shape: np.ndarray
    points: np.ndarray
    reference: np.ndarray
    law: np.ndarray
    assumed: np.ndarray
    rest: np.ndarray

    def __repr__(self) -> str:
        return short(self)


class Tables(NamedTuple):
    """What elements share: tables of each kind of integration points, the first of which are the Gauss points.

    ``table`` (n_kinds, 16, 80): jets of the local functions, jet by jet, ``jets`` its transpose, ``slopes`` (n_kinds, 32,
    16) the first two, point by point. ``projections`` (1 + n_kinds, 3, 16, 16): from membrane strains 11, 22, 12 to those
    that the law is applied to, ``(c, from, to)``: the identity, and the assumed ones, from strains at the Gauss points to
    the points of each kind; ``transposed`` the other way. ``kept`` (n_kinds, 16, 16): at the points, the polynomials that
    the assumed strains are made of, and ``fit`` (16, 16), from strains at the Gauss points to their coefficients. ``pairs``
    (n_pairs, 2): k <= l of the entries of the law.
    """

    table: np.ndarray
    jets: np.ndarray
    slopes: np.ndarray
    projections: np.ndarray
    transposed: np.ndarray
    kept: np.ndarray
    fit: np.ndarray
    pairs: np.ndarray

    def __repr__(self) -> str:
        return short(self)


@compiled(**INNER)
def jets(tables, kind, local, x):
    """r_1, r_2, r_11, r_22, r_12 at the points of a kind: x (3, 80), jet by jet."""
    for at in range(0, JETS, POINTS):
        set_panel(3, FUNCTIONS, local, 0, AXES, 1, tables.table, TABLE * kind + at, JETS, x, at, JETS)


@compiled(**INNER)
def gauss_slopes(tables, local, x):
    """r_1 and r_2 at the Gauss points, into the first columns of x (3, 80)."""
    for at in (ON_1, ON_2):
        set_panel(3, FUNCTIONS, local, 0, AXES, 1, tables.table, at, JETS, x, at, JETS)


@compiled(**INNER)
def surface(x, n, duals, gamma):
    """Unit normal (3, 16), dual vectors (2, 3, 16) and Christoffel symbols (3, 2, 16) of the jets."""
    for p in range(POINTS):
        a0, a1, a2, b0, b1, b2 = x[0, p], x[1, p], x[2, p], x[0, ON_2 + p], x[1, ON_2 + p], x[2, ON_2 + p]
        n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        square = n0 * n0 + n1 * n1 + n2 * n2
        length = 1.0 / np.sqrt(square)
        n[0, p], n[1, p], n[2, p] = n0 * length, n1 * length, n2 * length
        aa, bb, ab = a0 * a0 + a1 * a1 + a2 * a2, b0 * b0 + b1 * b1 + b2 * b2, a0 * b0 + a1 * b1 + a2 * b2
        aa, bb, ab = aa / square, bb / square, ab / square
        duals[0, 0, p], duals[0, 1, p], duals[0, 2, p] = bb * a0 - ab * b0, bb * a1 - ab * b1, bb * a2 - ab * b2
        duals[1, 0, p], duals[1, 1, p], duals[1, 2, p] = aa * b0 - ab * a0, aa * b1 - ab * a1, aa * b2 - ab * a2
    for k in range(3):
        at = ON_11 + POINTS * k
        for g in range(2):
            for p in range(POINTS):
                gamma[k, g, p] = (duals[g, 0, p] * x[0, at + p] + duals[g, 1, p] * x[1, at + p]
                                  + duals[g, 2, p] * x[2, at + p])  # fmt: skip


@compiled(**INNER)
def strains(x, n, reference, eps):
    """Membrane strains and curvature changes less the undeformed ones: eps (6, 16)."""
    for p in range(POINTS):
        e11 = e22 = e12 = k11 = k22 = k12 = 0.0
        for i in range(3):
            a, b = x[i, p], x[i, ON_2 + p]
            e11 += a * a
            e22 += b * b
            e12 += a * b
            k11 += n[i, p] * x[i, ON_11 + p]
            k22 += n[i, p] * x[i, ON_22 + p]
            k12 += n[i, p] * x[i, ON_12 + p]
        eps[0, p] = 0.5 * e11 - reference[0, p]
        eps[1, p] = 0.5 * e22 - reference[1, p]
        eps[2, p] = e12 - reference[2, p]
        eps[3, p] = -k11 - reference[3, p]
        eps[4, p] = -k22 - reference[4, p]
        eps[5, p] = -2.0 * k12 - reference[5, p]


@compiled(**INNER)
def add_change(x, y, n, gamma, eps):
    """Adds the change of the strains, linear in the change of the jets y (3, 80)."""
    for i in range(AXES):
        for p in range(POINTS):
            a, b, da, db, normal = x[i, p], x[i, ON_2 + p], y[i, p], y[i, ON_2 + p], n[i, p]
            eps[0, p] += a * da
            eps[1, p] += b * db
            eps[2, p] += a * db + b * da
            eps[3, p] -= normal * (y[i, ON_11 + p] - gamma[0, 0, p] * da - gamma[0, 1, p] * db)
            eps[4, p] -= normal * (y[i, ON_22 + p] - gamma[1, 0, p] * da - gamma[1, 1, p] * db)
            eps[5, p] -= 2.0 * normal * (y[i, ON_12 + p] - gamma[2, 0, p] * da - gamma[2, 1, p] * db)


@compiled(**INNER)
def section(tables, kind, assumed, law, rest, eps, hat, extra, stress):
    """Stresses (6 or 9, 16), with the weights, that do work on the strains.

    The law is applied to the assumed membrane strains with the curvatures, and to the scaled rest of the membrane strains.
    Assumed ones of own points are made of those at the Gauss points, the last three of the strains. ``hat`` (6, 16) and
    ``extra`` (3, 16) are scratch.
    """
    hat[3:] = eps[3:N_STRAINS]
    sampled = kind > 0 and assumed > 0
    first = N_STRAINS * POINTS if sampled else 0
    for c in range(N_MEMBRANE):
        at = PROJECTIONS * assumed + PROJECTION * c
        set_panel(1, POINTS, eps, first + POINTS * c, 1, 0, tables.projections, at, POINTS, hat, POINTS * c, POINTS)
    stress[:] = 0.0
    extra[:] = 0.0
    for m in range(tables.pairs.shape[0]):
        k, l = tables.pairs[m]
        for p in range(POINTS):
            stress[k, p] += law[m, p] * hat[l, p]
        if k != l:
            for p in range(POINTS):
                stress[l, p] += law[m, p] * hat[k, p]
        if l < 3:
            scale = rest[k] * rest[l]
            for p in range(POINTS):
                extra[k, p] += scale * law[m, p] * (eps[l, p] - hat[l, p])
            if k != l:
                for p in range(POINTS):
                    extra[l, p] += scale * law[m, p] * (eps[k, p] - hat[k, p])
    for c in range(N_MEMBRANE):
        at = PROJECTIONS * assumed + PROJECTION * c
        for p in range(POINTS):
            hat[c, p] = stress[c, p] - extra[c, p]
        stress[c] = extra[c]
        add_panel(1, POINTS, hat, POINTS * c, 1, 0, tables.transposed, at, POINTS, stress, first + POINTS * c, POINTS)


@compiled(**INNER)
def forces_of_jets(tables, kind, f, turned, force):
    """Forces (16, 3) on the local vectors of those on the jets, f (3, 80); ``turned`` (3, 16) is scratch."""
    set_panel(3, JETS, f, 0, 1, JETS, tables.jets, TABLE * kind, FUNCTIONS, turned, 0, FUNCTIONS)
    for a in range(FUNCTIONS):
        for i in range(AXES):
            force[a, i] = turned[i, a]


@compiled(**INNER)
def add_sampled_forces(tables, x, stress, f, turned, force):
    """Adds the forces of membrane stresses, the last three, on r_1 and r_2 at the Gauss points, x (3, 80)."""
    for i in range(AXES):
        for p in range(POINTS):
            f[i, ON_1 + p] = stress[6, p] * x[i, ON_1 + p] + stress[8, p] * x[i, ON_2 + p]
            f[i, ON_2 + p] = stress[8, p] * x[i, ON_1 + p] + stress[7, p] * x[i, ON_2 + p]
    set_panel(3, ON_11, f, 0, 1, JETS, tables.jets, 0, FUNCTIONS, turned, 0, FUNCTIONS)
    for a in range(FUNCTIONS):
        for i in range(AXES):
            force[a, i] += turned[i, a]


@compiled(**INNER)
def sampled_strains(x, y, reference, eps):
    """Membrane strains at the Gauss points less the undeformed ones, and their change with r_1 and r_2, y (3, 80)."""
    for p in range(POINTS):
        e11 = e22 = e12 = 0.0
        for i in range(AXES):
            a, b, da, db = x[i, ON_1 + p], x[i, ON_2 + p], y[i, ON_1 + p], y[i, ON_2 + p]
            e11 += a * (0.5 * a + da)
            e22 += b * (0.5 * b + db)
            e12 += a * b + a * db + b * da
        eps[6, p] = e11 - reference[6, p]
        eps[7, p] = e22 - reference[7, p]
        eps[8, p] = e12 - reference[8, p]


@compiled(**INNER)
def forces(tables, kind, x, n, gamma, stress, f, turned, force):
    """Forces (16, 3) on the local vectors; ``f`` (3, 80) and ``turned`` (3, 16) are scratch."""
    for i in range(AXES):
        for p in range(POINTS):
            m11, m22, m12 = stress[3, p], stress[4, p], 2.0 * stress[5, p]
            along = m11 * gamma[0, 0, p] + m22 * gamma[1, 0, p] + m12 * gamma[2, 0, p]
            across = m11 * gamma[0, 1, p] + m22 * gamma[1, 1, p] + m12 * gamma[2, 1, p]
            f[i, p] = stress[0, p] * x[i, p] + stress[2, p] * x[i, ON_2 + p] + along * n[i, p]
            f[i, ON_2 + p] = stress[2, p] * x[i, p] + stress[1, p] * x[i, ON_2 + p] + across * n[i, p]
            f[i, ON_11 + p] = -m11 * n[i, p]
            f[i, ON_22 + p] = -m22 * n[i, p]
            f[i, ON_12 + p] = -m12 * n[i, p]
    forces_of_jets(tables, kind, f, turned, force)


@compiled(**OPTIONS)
def stresses(start, stop, order, q, change, tables, maps, elements, strain_out, out):
    """Strain and stress extrapolated linearly along ``change``, strain(q) + B(q) change; the stress has the weights.

    Into ``strain_out`` (n_elements, 6 or 9, 16), or nowhere if that is empty, and ``out``.
    """
    local, moved = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES))
    x, y = np.empty((AXES, JETS)), np.empty((AXES, JETS))
    n, duals, gamma = np.empty((AXES, POINTS)), np.empty((2, AXES, POINTS)), np.empty((3, 2, POINTS))
    eps, hat, extra = np.zeros((out.shape[1], POINTS)), np.empty((N_STRAINS, POINTS)), np.empty((N_MEMBRANE, POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        kind, assumed, reference = elements.points[c], elements.assumed[c], elements.reference[c]
        gather(e, q, maps, local)
        jets(tables, kind, local, x)
        surface(x, n, duals, gamma)
        strains(x, n, reference, eps)
        if change.shape[0]:
            gather(e, change, maps, moved)
            jets(tables, kind, moved, y)
            add_change(x, y, n, gamma, eps)
        if kind > 0 and assumed > 0:
            y[:] = 0.0
            if change.shape[0]:
                gauss_slopes(tables, moved, y)
            gauss_slopes(tables, local, x)
            sampled_strains(x, y, reference, eps)
        else:
            eps[N_STRAINS:] = 0.0
        section(tables, kind, assumed, elements.law[c], elements.rest[c], eps, hat, extra, out[e])
        if strain_out.shape[0]:
            strain_out[e] = eps


@compiled(**OPTIONS)
def residual(start, stop, order, q, tables, maps, elements, out):
    """Internal force, added to out (n_nodes, 4, 3)."""
    local, force, turned = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES)), np.empty((AXES, FUNCTIONS))
    x, y, f = np.empty((AXES, JETS)), np.zeros((AXES, JETS)), np.empty((AXES, JETS))
    n, duals, gamma = np.empty((AXES, POINTS)), np.empty((2, AXES, POINTS)), np.empty((3, 2, POINTS))
    rows = elements.reference.shape[1]
    eps, stress = np.zeros((rows, POINTS)), np.empty((rows, POINTS))
    hat, extra, nothing = np.empty((N_STRAINS, POINTS)), np.empty((N_MEMBRANE, POINTS)), np.zeros((AXES, JETS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        kind, assumed, reference = elements.points[c], elements.assumed[c], elements.reference[c]
        gather(e, q, maps, local)
        jets(tables, kind, local, x)
        surface(x, n, duals, gamma)
        strains(x, n, reference, eps)
        sampled = kind > 0 and assumed > 0
        if sampled:
            gauss_slopes(tables, local, y)
            sampled_strains(y, nothing, reference, eps)
        section(tables, kind, assumed, elements.law[c], elements.rest[c], eps, hat, extra, stress)
        forces(tables, kind, x, n, gamma, stress, f, turned, force)
        if sampled:
            add_sampled_forces(tables, y, stress, f, turned, force)
        scatter_force(e, force, maps, out)


@compiled(**OPTIONS)
def force_of(start, stop, order, q, stress, tables, maps, elements, out):
    """Force of given stresses (n_elements, 6 or 9, 16), which have the weights, added to out (n_nodes, 4, 3)."""
    local, force, turned = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES)), np.empty((AXES, FUNCTIONS))
    x, f = np.empty((AXES, JETS)), np.empty((AXES, JETS))
    n, duals, gamma = np.empty((AXES, POINTS)), np.empty((2, AXES, POINTS)), np.empty((3, 2, POINTS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        kind = elements.points[c]
        gather(e, q, maps, local)
        jets(tables, kind, local, x)
        surface(x, n, duals, gamma)
        forces(tables, kind, x, n, gamma, stress[e], f, turned, force)
        if kind > 0 and elements.assumed[c] > 0:
            gauss_slopes(tables, local, x)
            add_sampled_forces(tables, x, stress[e], f, turned, force)
        scatter_force(e, force, maps, out)
