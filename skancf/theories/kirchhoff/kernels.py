"""Compiled assembly of theory `kirchhoff`; its formulas are those of :mod:`skancf.theories.kirchhoff.point`.

Each kernel works on the elements ``order[start:stop]``. Arrays have the 16 integration points last, so that inner loops
run over points.
"""

from typing import NamedTuple

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.gather import gather, scatter_force
from skancf.kernels.panels import add_panel, set_panel

N_POINTS = 16


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

    ``table`` (16, 80): jets of the local functions, jet by jet, ``jets`` its transpose, ``slopes`` (32, 16) the first two,
    point by point. ``projections`` (2, 3, 16, 16): from the membrane strains 11, 22, 12 at the points to those that the law
    is applied to, ``(c, from, to)``: the identity, and the assumed ones; ``transposed`` the other way. ``kept`` (16, 16): at
    the points, the polynomials that the assumed strains are made of, and ``fit``, from strains at the points to their
    coefficients. ``pairs`` (n_pairs, 2): k <= l of the entries of the law.
    """

    table: np.ndarray
    jets: np.ndarray
    slopes: np.ndarray
    projections: np.ndarray
    transposed: np.ndarray
    kept: np.ndarray
    fit: np.ndarray
    pairs: np.ndarray


@compiled(**INNER)
def jets(rule, local, x):
    """r_1, r_2, r_11, r_22, r_12 at the points: x (3, 80), jet by jet."""
    for at in range(0, 80, 16):
        set_panel(3, 16, local, 0, 3, 1, rule.table, at, 80, x, at, 80)


@compiled(**INNER)
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


@compiled(**INNER)
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


@compiled(**INNER)
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


@compiled(**INNER)
def section(rule, assumed, law, rest, eps, hat, extra, stress):
    """Stresses (6, 16), with the weights, that do work on the strains at the points.

    The law is applied to the assumed membrane strains with the curvatures, and to the scaled rest of the membrane strains;
    ``hat`` (6, 16) and ``extra`` (3, 16) are scratch.
    """
    hat[3:] = eps[3:]
    for c in range(3):
        set_panel(1, N_POINTS, eps, 16 * c, 1, 0, rule.projections, 768 * assumed + 256 * c, 16, hat, 16 * c, 16)
    stress[:] = 0.0
    extra[:] = 0.0
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
        stress[c] = extra[c]
        add_panel(1, N_POINTS, hat, 16 * c, 1, 0, rule.transposed, 768 * assumed + 256 * c, 16, stress, 16 * c, 16)


@compiled(**INNER)
def forces_of_jets(rule, f, turned, force):
    """Forces (16, 3) on the local vectors of those on the jets, f (3, 80); ``turned`` (3, 16) is scratch."""
    set_panel(3, 80, f, 0, 1, 80, rule.jets, 0, 16, turned, 0, 16)
    for a in range(16):
        for i in range(3):
            force[a, i] = turned[i, a]


@compiled(**INNER)
def forces(rule, x, n, gamma, stress, f, turned, force):
    """Forces (16, 3) on the local vectors; ``f`` (3, 80) and ``turned`` (3, 16) are scratch."""
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
    forces_of_jets(rule, f, turned, force)


@compiled(**OPTIONS)
def stresses(start, stop, order, q, change, rule, maps, elements, strain_out, out):
    """Strain and stress extrapolated linearly along ``change``, strain(q) + B(q) change; the stress has the weights.

    Into ``strain_out`` (n_elements, 6, 16), or nowhere if that is empty, and ``out``.
    """
    local, moved = np.empty((16, 3)), np.empty((16, 3))
    x, y = np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    eps, hat, extra = np.empty((6, 16)), np.empty((6, 16)), np.empty((3, 16))
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
        section(rule, elements.assumed[c], elements.law[c], elements.rest[c], eps, hat, extra, out[e])
        if strain_out.shape[0]:
            strain_out[e] = eps


@compiled(**OPTIONS)
def residual(start, stop, order, q, rule, maps, elements, out):
    """Internal force, added to out (n_nodes, 4, 3)."""
    local, force, turned = np.empty((16, 3)), np.empty((16, 3)), np.empty((3, 16))
    x, f = np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    eps, hat, extra, stress = np.empty((6, 16)), np.empty((6, 16)), np.empty((3, 16)), np.empty((6, 16))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        strains(x, n, elements.reference[c], eps)
        section(rule, elements.assumed[c], elements.law[c], elements.rest[c], eps, hat, extra, stress)
        forces(rule, x, n, gamma, stress, f, turned, force)
        scatter_force(e, force, maps, out)


@compiled(**OPTIONS)
def force_of(start, stop, order, q, stress, rule, maps, out):
    """Force of given stresses (n_elements, 6, 16), which have the weights, added to out (n_nodes, 4, 3)."""
    local, force, turned = np.empty((16, 3)), np.empty((16, 3)), np.empty((3, 16))
    x, f = np.empty((3, 80)), np.empty((3, 80))
    n, duals, gamma = np.empty((3, 16)), np.empty((2, 3, 16)), np.empty((3, 2, 16))
    for index in range(start, stop):
        e = order[index]
        gather(e, q, maps, local)
        jets(rule, local, x)
        surface(x, n, duals, gamma)
        forces(rule, x, n, gamma, stress[e], f, turned, force)
        scatter_force(e, force, maps, out)
