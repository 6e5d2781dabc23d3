r"""Compiled plane stress of energies of the invariants of C, at one point.

With a, b, d, c for C11, C22, C12, C33 and J for the root of det C,

.. math:: I_1 = a + b + c, \qquad I_2 = (a b - d^2) + c (a + b), \qquad J^2 = (a b - d^2) c.

A compressible law has the c at which :math:`\psi_{,c} = 0`, by Newton's method on its logarithm, and is condensed:

.. math:: D_{ij} = f_i f_j (\psi_{,ij} - \psi_{,ic} \psi_{,jc} / \psi_{,cc}), \qquad f = 2, 2, 1 \text{ for } a, b, d.

An incompressible one has :math:`c = 1 / (a b - d^2)`, and the energy is one of a, b, d alone.

Invariants are handed over as what they exceed those of the undeformed state by: sums of small numbers keep their digits.
For that, functions here are compiled so that sums stay in the order in which they are written.

Functions that take functions are compiled with their callers, and not kept by themselves: their cache would find no function
of an earlier process.

References
----------
J. Kiendl, M.-C. Hsu, M. C. H. Wu and A. Reali, Isogeometric Kirchhoff-Love shell formulations for general hyperelastic
materials, *Computer Methods in Applied Mechanics and Engineering* 291 (2015) 280-303.
"""

from math import exp, expm1, inf, isfinite, isinf, log, log1p, nan, sqrt

import numba

from skancf.compiled import INNER, OPTIONS
from skancf.materials.point_law import BEYOND, FINE, FOLDED, NO_THICKNESS
from skancf.tolerances import LAST_STEP

ORDERED = {"contract", "nsz", "arcp"}
"""Freedom of the compiler without that to change the order of sums."""
POINT = {**INNER, "fastmath": ORDERED}
LOOP = {**OPTIONS, "fastmath": ORDERED}
RESULTS = 12
"""Numbers of a point: energy, S11, S22, S12, the six of D, C33, and the code of what became of it."""
ITERATIONS = 100
"""Of Newton's method: four to five from afar, two from the last value; more halve an interval."""
LARGEST_STEP = 1.0
"""Of the logarithm of C33."""

point_function = numba.njit(**POINT)


@point_function
def failed(code):
    return nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, code


@point_function
def store(out, k, values):
    """The numbers of a point, in column k."""
    (out[0, k], out[1, k], out[2, k], out[3, k], out[4, k], out[5, k],
     out[6, k], out[7, k], out[8, k], out[9, k], out[10, k], out[11, k]) = values  # fmt: skip


@point_function
def with_volume(w, i1, i2, x, bulk):
    r"""Energy and derivatives by I1, I2, J from those of an isochoric energy w by its invariants, with

    .. math:: \psi = w(J^{-2/3} I_1, J^{-4/3} I_2) + \tfrac K4 (J^2 - 1 - 2 \ln J)

    for I1 = 3 + i1, I2 = 3 + i2, J^2 = 1 + x: the energy, then derivatives 1, 2, J, 11, 22, JJ, 12, 1J, 2J.
    """
    energy, w1, w2, w11, w22, w12 = w
    square = 1.0 + x
    J = sqrt(square)
    s = exp(-log1p(x) / 3.0)
    s2 = s * s
    first, second = s * (3.0 + i1), s2 * (3.0 + i2)
    first_J, second_J = -2.0 / 3.0 * first / J, -4.0 / 3.0 * second / J
    on_J = w11 * first_J + w12 * second_J
    on_J2 = w12 * first_J + w22 * second_J
    return (
        energy + 0.25 * bulk * (x - log1p(x)),
        s * w1,
        s2 * w2,
        w1 * first_J + w2 * second_J + 0.5 * bulk * x / J,
        s2 * w11,
        s2 * s2 * w22,
        (on_J * first_J + on_J2 * second_J + (10.0 / 9.0 * w1 * first + 28.0 / 9.0 * w2 * second) / square
         + 0.5 * bulk * (1.0 + 1.0 / square)),
        s * s2 * w12,
        s * (on_J - 2.0 / 3.0 * w1 / J),
        s2 * (on_J2 - 4.0 / 3.0 * w2 / J),
    )  # fmt: skip


@point_function
def isochoric(i1, i2, x):
    """What the invariants of the isochoric part exceed 3 by."""
    less = -log1p(x) / 3.0
    return exp(less) * i1 + 3.0 * expm1(less), exp(2.0 * less) * i2 + 3.0 * expm1(2.0 * less)


@point_function
def invariants(a, b, d, less_c):
    """I1 - 3, I2 - 3, J^2 - 1, for C33 = 1 + less_c."""
    A, B = a - 1.0, b - 1.0
    P = A + B + (A * B - d * d)
    x = P + less_c * (1.0 + P) if abs(P) < 0.5 else (a * b - d * d) * (1.0 + less_c) - 1.0
    return A + B + less_c, P + (A + B) + less_c * (a + b), x


@point_function
def across(derivatives, a, b, d, c, par):
    """First and second derivative of the energy by C33."""
    T = a + b
    i1, i2, x = invariants(a, b, d, c - 1.0)
    _, g1, g2, gJ, h11, h22, hJJ, h12, h1J, h2J = derivatives(i1, i2, x, par)
    J = sqrt(1.0 + x)
    by_c = 0.5 * J / c
    first = g1 + T * g2 + by_c * gJ
    second = h11 + T * (2.0 * h12 + T * h22) + by_c * (2.0 * (h1J + T * h2J) + by_c * hJJ) - 0.25 * J / (c * c) * gJ
    return first, second


@point_function
def thickness(slopes, derivatives, a, b, d, guess, par):
    """C33 without stress across, and whether it was found; ``slopes`` are as :func:`across`.

    Newton's method on its logarithm, within what is known to have the root between.
    """
    y = log(guess) if guess > 0.0 else -log(a * b - d * d)
    low, high = -inf, inf
    for _ in range(ITERATIONS):
        c = exp(y)
        first, second = slopes(derivatives, a, b, d, c, par)
        force = c * first
        if force > 0.0:
            high = y
        elif force < 0.0:
            low = y
        elif force == 0.0:
            return c, True
        else:  # beyond a limit: towards the thickness of the least distortion, which is within it or nothing is
            least = log(0.5 * (a + b))
            if y < least:
                low = y
            else:
                high = y
            y = 0.5 * (y + least)
            continue
        rise = force + c * c * second
        step = -LARGEST_STEP if force > 0.0 else LARGEST_STEP
        if rise > 0.0 and isfinite(rise):
            step = min(max(-force / rise, -LARGEST_STEP), LARGEST_STEP)
        if abs(step) < LAST_STEP and isfinite(force):
            return exp(y + step), True
        following = y + step
        if not (low < following < high):
            following = 0.5 * (low + high)
        y = following
    return exp(y), False


@point_function
def product(q, u, v):
    """u Q v of triples, Q with the entries 11, 22, 33, 12, 13, 23."""
    return (u[0] * (q[0] * v[0] + q[3] * v[1] + q[4] * v[2]) + u[1] * (q[3] * v[0] + q[1] * v[1] + q[5] * v[2])
            + u[2] * (q[4] * v[0] + q[5] * v[1] + q[2] * v[2]))  # fmt: skip


@point_function
def of_components(derivatives, a, b, d, c, par):
    """Energy; its derivatives by a, b, d, c; second ones aa, bb, dd, cc, ab, ad, bd, ac, bc, dc."""
    i1, i2, x = invariants(a, b, d, c - 1.0)
    energy, g1, g2, gJ, h11, h22, hJJ, h12, h1J, h2J = derivatives(i1, i2, x, par)
    q = (h11, h22, hJJ, h12, h1J, h2J)
    J, p = sqrt(1.0 + x), a * b - d * d
    la, lb, ld, lc = b / p, a / p, -2.0 * d / p, 1.0 / c  # of the logarithm of det C
    half = 0.5 * J
    ua, ub, ud, uc = (1.0, b + c, half * la), (1.0, a + c, half * lb), (0.0, -2.0 * d, half * ld), (1.0, a + b, half * lc)
    on_J = gJ * half  # J_ij = J / 4 l_i l_j + J / 2 l_ij
    f = 0.5 * on_J
    return (
        energy,
        g1 * ua[0] + g2 * ua[1] + gJ * ua[2],
        g1 * ub[0] + g2 * ub[1] + gJ * ub[2],
        g2 * ud[1] + gJ * ud[2],
        g1 * uc[0] + g2 * uc[1] + gJ * uc[2],
        product(q, ua, ua) - f * la * la,
        product(q, ub, ub) - f * lb * lb,
        product(q, ud, ud) - 2.0 * g2 - f * ld * ld - 2.0 * on_J / p,
        product(q, uc, uc) - f * lc * lc,
        product(q, ua, ub) + g2 - f * la * lb + on_J / p,
        product(q, ua, ud) - f * la * ld,
        product(q, ub, ud) - f * lb * ld,
        product(q, ua, uc) + g2 + f * la * lc,
        product(q, ub, uc) + g2 + f * lb * lc,
        product(q, ud, uc) + f * ld * lc,
    )  # fmt: skip


@point_function
def condensed(full, c):
    """The numbers of a point from all derivatives, where the one by c is zero."""
    energy, ga, gb, gd, _, aa, bb, dd, cc, ab, ad, bd, ac, bc, dc = full
    if not isfinite(energy + ga + gb + gd + cc + aa + bb + dd):
        return failed(BEYOND)
    ra, rb, rd = ac / cc, bc / cc, dc / cc
    return (energy, 2.0 * ga, 2.0 * gb, gd, 4.0 * (aa - ac * ra), 4.0 * (bb - bc * rb), dd - dc * rd, 4.0 * (ab - ac * rb),
            2.0 * (ad - ac * rd), 2.0 * (bd - bc * rd), c, FINE)  # fmt: skip


@point_function
def compressible(slopes, full, derivatives, a, b, d, guess, par):
    """The numbers of a point of a compressible law; ``slopes`` and ``full`` are as :func:`across` and
    :func:`of_components`."""
    if not (a > 0.0 and a * b - d * d > 0.0):
        return failed(FOLDED)
    c, found = thickness(slopes, derivatives, a, b, d, guess, par)
    values = condensed(full(derivatives, a, b, d, c, par), c)
    if not found and isfinite(values[0]):
        return failed(NO_THICKNESS)
    return values


@point_function
def incompressible(isochoric_derivatives, a, b, d, par):
    """The numbers of a point of an incompressible law, from energy and derivatives 1, 2, 11, 22, 12 by I1 and I2."""
    p = a * b - d * d
    if not (a > 0.0 and p > 0.0):
        return failed(FOLDED)
    A, B, c = a - 1.0, b - 1.0, 1.0 / p
    P, T = A + B + (A * B - d * d), a + b
    energy, g1, g2, h11, h22, h12 = isochoric_derivatives(A + B - P * c, (A + B) * c + P * (1.0 - 2.0 * c), par)
    if not isfinite(energy + g1 + g2 + h11 + h22 + h12):
        return failed(BEYOND)
    c2, q = c * c, (h11, h22, 0.0, h12, 0.0, 0.0)
    k1, k2 = -c2, 1.0 - T * c2  # dI1 = dT + k1 dp, dI2 = c dT + k2 dp
    ua, ub, ud = (1.0 + k1 * b, c + k2 * b, 0.0), (1.0 + k1 * a, c + k2 * a, 0.0), (-2.0 * k1 * d, -2.0 * k2 * d, 0.0)
    of_p = g1 * k1 + g2 * k2
    pp, tp = 2.0 * c2 * c * (g1 + g2 * T), -g2 * c2
    return (
        energy,
        2.0 * (g1 * ua[0] + g2 * ua[1]),
        2.0 * (g1 * ub[0] + g2 * ub[1]),
        g1 * ud[0] + g2 * ud[1],
        4.0 * (product(q, ua, ua) + pp * b * b + 2.0 * tp * b),
        4.0 * (product(q, ub, ub) + pp * a * a + 2.0 * tp * a),
        product(q, ud, ud) + 4.0 * pp * d * d - 2.0 * of_p,
        4.0 * (product(q, ua, ub) + pp * a * b + tp * (a + b) + of_p),
        2.0 * (product(q, ua, ud) - 2.0 * pp * b * d - 2.0 * tp * d),
        2.0 * (product(q, ub, ud) - 2.0 * pp * a * d - 2.0 * tp * d),
        c,
        FINE,
    )


@point_function
def of_invariants(isochoric_derivatives, derivatives, a, b, d, guess, par):
    """The numbers of a point of an energy of invariants, whose first parameter is the bulk modulus."""
    if isinf(par[0]):
        return incompressible(isochoric_derivatives, a, b, d, par)
    return compressible(across, of_components, derivatives, a, b, d, guess, par)
