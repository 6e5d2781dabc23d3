r"""Theory `full` at a point, compiled: in-plane strains, the forces they put on the jet, and their stiffness.

Jets are tuples of four vectors :math:`V = (r_{,1}, r_{,2}, d_{,1}, d_{,2})`. The nine in-plane strains are products of
two of them, so that the derivative of the strain :math:`V_a \cdot V_x` with respect to :math:`V_a` is :math:`V_x`. A law
is an array (9, 9, n_points).
"""

from skancf.compiled import INNER, compiled
from skancf.kernels.constants import POINTS


@compiled(**INNER)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled(**INNER)
def sum4(s, a, t, b, u, c, v, d):
    """s a + t b + u c + v d for vectors a, b, c, d."""
    return (
        s * a[0] + t * b[0] + u * c[0] + v * d[0],
        s * a[1] + t * b[1] + u * c[1] + v * d[1],
        s * a[2] + t * b[2] + u * c[2] + v * d[2],
    )


@compiled(**INNER)
def in_plane(x, y):
    """The symmetric bilinear form of the nine in-plane strains at two jets: e0, e1, e2, each 11, 22, 2 x 12."""
    return (
        0.5 * dot(x[0], y[0]),
        0.5 * dot(x[1], y[1]),
        0.5 * (dot(x[0], y[1]) + dot(x[1], y[0])),
        0.5 * (dot(x[0], y[2]) + dot(x[2], y[0])),
        0.5 * (dot(x[1], y[3]) + dot(x[3], y[1])),
        0.5 * (dot(x[0], y[3]) + dot(x[3], y[0]) + dot(x[1], y[2]) + dot(x[2], y[1])),
        0.5 * dot(x[2], y[2]),
        0.5 * dot(x[3], y[3]),
        0.5 * (dot(x[2], y[3]) + dot(x[3], y[2])),
    )


@compiled(**INNER)
def in_plane_force(v, s):
    """Derivative of stress . strain with respect to the four vectors of the jet."""
    a, b, c, d = v
    return (
        sum4(s[0], a, s[2], b, s[3], c, s[5], d),
        sum4(s[2], a, s[1], b, s[5], c, s[4], d),
        sum4(s[3], a, s[5], b, s[6], c, s[8], d),
        sum4(s[5], a, s[4], b, s[8], c, s[7], d),
    )


@compiled(**INNER)
def stress_changes(law, p, i, j, k, l, v):
    """Derivatives of the nine stresses with respect to a vector of the jet, whose strains are i, j, k, l; 9 vectors."""
    a, b, c, d = v
    return (
        sum4(law[0, i, p], a, law[0, j, p], b, law[0, k, p], c, law[0, l, p], d),
        sum4(law[1, i, p], a, law[1, j, p], b, law[1, k, p], c, law[1, l, p], d),
        sum4(law[2, i, p], a, law[2, j, p], b, law[2, k, p], c, law[2, l, p], d),
        sum4(law[3, i, p], a, law[3, j, p], b, law[3, k, p], c, law[3, l, p], d),
        sum4(law[4, i, p], a, law[4, j, p], b, law[4, k, p], c, law[4, l, p], d),
        sum4(law[5, i, p], a, law[5, j, p], b, law[5, k, p], c, law[5, l, p], d),
        sum4(law[6, i, p], a, law[6, j, p], b, law[6, k, p], c, law[6, l, p], d),
        sum4(law[7, i, p], a, law[7, j, p], b, law[7, k, p], c, law[7, l, p], d),
        sum4(law[8, i, p], a, law[8, j, p], b, law[8, k, p], c, law[8, l, p], d),
    )


@compiled(**INNER)
def force_change(v, w0, w1, w2, w3, geometric):
    """Derivative of the force on one vector of the jet with respect to another: the 3 x 3 block, row by row.

    ``w0`` to ``w3`` are the changes of the stresses that multiply the four vectors v in that force.
    """
    a, b, c, d = v
    x = (a[0] * w0[0] + b[0] * w1[0] + c[0] * w2[0] + d[0] * w3[0] + geometric,
         a[0] * w0[1] + b[0] * w1[1] + c[0] * w2[1] + d[0] * w3[1],
         a[0] * w0[2] + b[0] * w1[2] + c[0] * w2[2] + d[0] * w3[2])  # fmt: skip
    y = (a[1] * w0[0] + b[1] * w1[0] + c[1] * w2[0] + d[1] * w3[0],
         a[1] * w0[1] + b[1] * w1[1] + c[1] * w2[1] + d[1] * w3[1] + geometric,
         a[1] * w0[2] + b[1] * w1[2] + c[1] * w2[2] + d[1] * w3[2])  # fmt: skip
    z = (a[2] * w0[0] + b[2] * w1[0] + c[2] * w2[0] + d[2] * w3[0],
         a[2] * w0[1] + b[2] * w1[1] + c[2] * w2[1] + d[2] * w3[1],
         a[2] * w0[2] + b[2] * w1[2] + c[2] * w2[2] + d[2] * w3[2] + geometric)  # fmt: skip
    return x, y, z


@compiled(**INNER)
def store(of_a, of_b, at_b, at_a, block):
    """Components 11, 22, 33, 12, 13, 23 of a block (a, b) into H[a] at b and of its transpose into H[b] at a."""
    x, y, z = block
    of_a[0, at_b], of_a[1, at_b], of_a[2, at_b] = x[0], y[1], z[2]
    of_a[3, at_b], of_a[4, at_b], of_a[5, at_b] = x[1], x[2], y[2]
    of_b[0, at_a], of_b[1, at_a], of_b[2, at_a] = x[0], y[1], z[2]
    of_b[3, at_a], of_b[4, at_a], of_b[5, at_a] = y[0], z[0], z[1]


@compiled(**INNER)
def in_plane_stiffness(law, p, v, s, H):
    """Second derivative of the in-plane energy with respect to the jet, into H (4, 6, 64): jet, component, jet and point."""
    # Zero, but not as a literal: the compiler makes a new function for each literal argument.
    o = p - p
    r1, r2, d1, d2 = H[0], H[1], H[2], H[3]
    at_r1, at_r2, at_d1, at_d2 = p, p + POINTS, p + 2 * POINTS, p + 3 * POINTS
    w = stress_changes(law, p, o, o + 2, o + 3, o + 5, v)
    store(r1, r1, at_r1, at_r1, force_change(v, w[0], w[2], w[3], w[5], s[0]))
    w = stress_changes(law, p, o + 2, o + 1, o + 5, o + 4, v)
    store(r1, r2, at_r2, at_r1, force_change(v, w[0], w[2], w[3], w[5], s[2]))
    store(r2, r2, at_r2, at_r2, force_change(v, w[2], w[1], w[5], w[4], s[1]))
    w = stress_changes(law, p, o + 3, o + 5, o + 6, o + 8, v)
    store(r1, d1, at_d1, at_r1, force_change(v, w[0], w[2], w[3], w[5], s[3]))
    store(r2, d1, at_d1, at_r2, force_change(v, w[2], w[1], w[5], w[4], s[5]))
    store(d1, d1, at_d1, at_d1, force_change(v, w[3], w[5], w[6], w[8], s[6]))
    w = stress_changes(law, p, o + 5, o + 4, o + 8, o + 7, v)
    store(r1, d2, at_d2, at_r1, force_change(v, w[0], w[2], w[3], w[5], s[5]))
    store(r2, d2, at_d2, at_r2, force_change(v, w[2], w[1], w[5], w[4], s[4]))
    store(d1, d2, at_d2, at_d1, force_change(v, w[3], w[5], w[6], w[8], s[8]))
    store(d2, d2, at_d2, at_d2, force_change(v, w[5], w[4], w[8], w[7], s[7]))
