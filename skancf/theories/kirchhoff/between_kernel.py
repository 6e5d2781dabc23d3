"""Compiled forces of theory `kirchhoff` on the way from one state to another, which do the work of stresses exactly; the
formulas are those of :func:`skancf.theories.kirchhoff.point.discrete_gradient`."""

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, FUNCTIONS, POINTS
from skancf.kernels.gather import gather, scatter_force
from skancf.theories.kirchhoff.kernels import (
    JETS,
    ON_2,
    ON_11,
    ON_12,
    ON_22,
    add_sampled_forces,
    forces_of_jets,
    gauss_slopes,
    jets,
)


@compiled(**INNER)
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled(**INNER)
def inner(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled(**INNER)
def mixed(s, a, t, b):
    """s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@compiled(**INNER)
def pair(x, y, k, p):
    """Middle and change of jet k at point p."""
    at = POINTS * k + p
    a, b = (x[0, at], x[1, at], x[2, at]), (y[0, at], y[1, at], y[2, at])
    return mixed(0.5, a, 0.5, b), mixed(1.0, b, -1.0, a)


@compiled(**INNER)
def bending_between(a, b, c, da, db, dc, J, bending, on_J):
    """Factors of the changes of r_1, r_2 and sum M r_ab in the change of M . r_ab . n, as
    :func:`skancf.theories.kirchhoff.point.discrete_gradient` has them; ``bending`` is the mean of M . r_ab . n."""
    m = cross(a, b)
    square = inner(m, m)
    n = mixed(1.0 / np.sqrt(square), m, 0.0, m)
    aa, bb, ab = inner(a, a) / square, inner(b, b) / square, inner(a, b) / square
    dual_a, dual_b = mixed(bb, a, -ab, b), mixed(aa, b, -ab, a)
    tilt = mixed(-inner(n, da), dual_a, -inner(n, db), dual_b)
    spin = mixed(0.5, mixed(1.0, cross(dual_a, da), 1.0, cross(dual_b, db)), 0.5, cross(n, tilt))
    turned_a, turned_b = cross(spin, a), cross(spin, b)
    rest_a, rest_b, rest_c = cross(db, dc), cross(dc, turned_a), cross(turned_a, turned_b)
    torque = mixed(1.0, mixed(1.0, cross(a, rest_a), 1.0, cross(b, rest_b)), 1.0, cross(c, rest_c))
    leaning = cross(torque, n)
    on_a = mixed(0.5, cross(torque, dual_a), -0.5 * inner(dual_a, leaning), n)
    on_b = mixed(0.5, cross(torque, dual_b), -0.5 * inner(dual_b, leaning), n)
    f_a = mixed(1.0, cross(b, c), 0.25, mixed(1.0, rest_a, -1.0, on_a))
    f_b = mixed(1.0, cross(c, a), 0.25, mixed(1.0, rest_b, -1.0, on_b))
    f_c = mixed(1.0, m, 0.25, rest_c)
    f_a = mixed(1.0 / J, f_a, -bending / J, on_J[0])
    f_b = mixed(1.0 / J, f_b, -bending / J, on_J[1])
    return f_a, f_b, mixed(1.0 / J, f_c, 0.0, f_c)


@compiled(**INNER)
def forces_between(tables, kind, x, y, stress, f, turned, force):
    """Forces (16, 3) on the local vectors that do the work of stresses on the change of the strains from x to y, exactly;
    ``f`` (3, 80) and ``turned`` (3, 16) are scratch."""
    for p in range(POINTS):
        a0, b0 = (x[0, p], x[1, p], x[2, p]), (x[0, ON_2 + p], x[1, ON_2 + p], x[2, ON_2 + p])
        a1, b1 = (y[0, p], y[1, p], y[2, p]), (y[0, ON_2 + p], y[1, ON_2 + p], y[2, ON_2 + p])
        (a, da), (b, db) = pair(x, y, 0, p), pair(x, y, 1, p)
        m0, m1 = cross(a0, b0), cross(a1, b1)
        J0, J1 = np.sqrt(inner(m0, m0)), np.sqrt(inner(m1, m1))
        J = 0.5 * (J0 + J1)
        aa, bb = 0.5 * (inner(a0, a0) + inner(a1, a1)), 0.5 * (inner(b0, b0) + inner(b1, b1))
        ab = 0.5 * (inner(a0, b0) + inner(a1, b1))
        on_J = mixed(bb / J, a, -ab / J, b), mixed(aa / J, b, -ab / J, a)
        m11, m22, m12 = -stress[3, p], -stress[4, p], -2.0 * stress[5, p]
        (c1, d1), (c2, d2), (c3, d3) = pair(x, y, 2, p), pair(x, y, 3, p), pair(x, y, 4, p)
        c = mixed(1.0, mixed(m11, c1, m22, c2), m12, c3)
        dc = mixed(1.0, mixed(m11, d1, m22, d2), m12, d3)
        start, end = mixed(1.0, c, -0.5, dc), mixed(1.0, c, 0.5, dc)
        bending = 0.5 * (inner(start, m0) / J0 + inner(end, m1) / J1)
        f_a, f_b, f_c = bending_between(a, b, c, da, db, dc, J, bending, on_J)
        for i in range(3):
            f[i, p] = stress[0, p] * a[i] + stress[2, p] * b[i] + f_a[i]
            f[i, ON_2 + p] = stress[2, p] * a[i] + stress[1, p] * b[i] + f_b[i]
            f[i, ON_11 + p] = m11 * f_c[i]
            f[i, ON_22 + p] = m22 * f_c[i]
            f[i, ON_12 + p] = m12 * f_c[i]
    forces_of_jets(tables, kind, f, turned, force)


@compiled(**OPTIONS)
def force_between(start, stop, order, q0, q1, stress, tables, maps, elements, out):
    """Force of given stresses (n_elements, 6 or 9, 16), which have the weights, on the way from q0 to q1, added to out."""
    local, force, turned = np.empty((FUNCTIONS, AXES)), np.empty((FUNCTIONS, AXES)), np.empty((AXES, FUNCTIONS))
    middle, x, y, f = np.empty((FUNCTIONS, AXES)), np.empty((AXES, JETS)), np.empty((AXES, JETS)), np.empty((AXES, JETS))
    for index in range(start, stop):
        e = order[index]
        c = elements.shape[e]
        kind = elements.points[c]
        gather(e, q0, maps, middle)
        jets(tables, kind, middle, x)
        gather(e, q1, maps, local)
        jets(tables, kind, local, y)
        forces_between(tables, kind, x, y, stress[e], f, turned, force)
        if kind > 0 and elements.assumed[c] > 0:
            # Membrane strains are quadratic: their gradient in the middle is exact.
            middle += local
            middle *= 0.5
            gauss_slopes(tables, middle, x)
            add_sampled_forces(tables, x, stress[e], f, turned, force)
        scatter_force(e, force, maps, out)
