r"""Compiled plane stress of an energy of one's own, from values of it alone, at complex numbers.

First derivatives are those of a step i s so small that its square is nothing; second ones by invariants are of two steps of
opposite sign at 45 degrees in the complex plane,

.. math::
    f'(x) = \operatorname{Im} f(x + i s) / s, \qquad
    f''(x) = \operatorname{Im} \bigl( f(x + \sqrt i h) + f(x - \sqrt i h) \bigr) / h^2 + O(h^4),

in which no two numbers of equal size are subtracted, so that they have twelve digits. By components there are ten of them,
and each is of one step h along the sixth root of one, :math:`\zeta = e^{i \pi / 3}`, whose third power is real,

.. math::
    f''(x) = \frac 2 {h^2} \Bigl( \frac{\operatorname{Im} f(x + \zeta h)}{\sin \pi / 3} - h f'(x) \Bigr) + O(h^2),

which takes the first derivative away and has nine digits. Mixed ones are those along sums.

An energy that is no real number at real arguments, such as a logarithm of a negative one, counts as infinite.

References
----------
K.-L. Lai and J. L. Crassidis, Extensions of the first and second complex-step derivative approximations, *Journal of
Computational and Applied Mathematics* 219 (2008) 276-293.
"""

from functools import lru_cache
from math import inf, isfinite, nan, sqrt
from typing import Any, NamedTuple

import numba
import numpy as np

from skancf.materials.hyperelastic import kernels
from skancf.materials.hyperelastic.kernels import LOOP, point_function
from skancf.materials.hyperelastic.solid_kernels import store_solid
from skancf.materials.point_law import BEYOND, FINE, FOLDED

TINY_STEP = 2.0**-100
STEP = 2.0**-10
"""Of the size of what it changes; its fourth power is 1e-12."""
AHEAD = 2.0**-20
"""How far the slope of Newton's method looks, relatively."""
SUSPECT = 2.0**-40
"""Of the energy: its change over a tiny step is 1e-30, unless it is a number that is not real."""
DIAGONAL = complex(sqrt(0.5), sqrt(0.5))
SHORT = 2.0**-17
"""A step along the sixth root of one, of the size of what it changes: its square, and rounding over it, are 1e-10."""
SIXTH, OVER_SINE = complex(0.5, sqrt(0.75)), 1 / sqrt(0.75)


class Kernels(NamedTuple):
    """Of one energy: ``at_point``, ``at_points`` and ``in_solids`` as those of other laws; ``at_rest``, all derivatives by
    a, b, d, c as :func:`skancf.materials.hyperelastic.kernels.of_components`."""

    at_point: Any
    at_points: Any
    at_rest: Any
    in_solids: Any


@lru_cache(maxsize=64)
def kernels_of(energy: Any, components: bool, incompressible: bool) -> Kernels:
    """Compiled functions of an energy of (I1, I2, J, parameters), or of (C11, C22, C33, C12, parameters)."""
    point, rest, derivatives = (of_components if components else of_invariants)(energy, incompressible)
    loop = numba.njit(**LOOP)

    def at_points(C, guess, par, out):
        for k in range(C.shape[1]):
            kernels.store(out, k, point(C[0, k], C[1, k], C[2, k], guess[k], par))

    def at_rest(par):
        return rest(None, 1.0, 1.0, 0.0, 1.0, par)

    def in_solids(C, par, out):
        inverse, G = np.empty((3, 3)), np.empty((3, 6))
        for k in range(C.shape[1]):
            store_solid(derivatives, C, k, par, out, inverse, G)

    return Kernels(point, loop(at_points), loop(at_rest), None if components or incompressible else loop(in_solids))


@point_function
def is_off(value):
    """Whether a value a tiny step from real arguments may be no real number there: it is looked at once more."""
    return not abs(value.real) * SUSPECT >= abs(value.imag)


def by_invariants(psi):
    """Values and derivatives of an energy of I1, I2, J: as a real number, by I1 and I2 where J is 1, and by all three.

    J is handed over as a real number where only the others move: its powers and logarithms are then cheap.
    """

    @point_function
    def still(I1, I2, J, par):
        """The energy; infinite where it is no real number."""
        value = psi(complex(I1), complex(I2), complex(J), par)
        return value.real if value.imag == 0.0 else inf

    @point_function
    def twice_of_two(I1, I2, J, u, v, par):
        """Second derivative along (u, v, 0)."""
        u, v = DIAGONAL * u, DIAGONAL * v
        return psi(I1 + u, I2 + v, J, par).imag + psi(I1 - u, I2 - v, J, par).imag

    @point_function
    def twice(I1, I2, J, u, v, w, par):
        """Second derivative along (u, v, w)."""
        u, v, w = DIAGONAL * u, DIAGONAL * v, DIAGONAL * w
        return psi(I1 + u, I2 + v, J + w, par).imag + psi(I1 - u, I2 - v, J - w, par).imag

    @point_function
    def of_two_at(I1, I2, J, par):
        """Energy and derivatives 1, 2, 11, 22, 12."""
        s, k1, k2 = TINY_STEP, STEP * I1 / 3.0, STEP * I2 / 3.0
        one, two = psi(complex(I1, s), complex(I2), J, par), psi(complex(I1), complex(I2, s), J, par)
        energy = still(I1, I2, J, par) if is_off(one) else one.real
        x, y = twice_of_two(I1, I2, J, k1, 0.0, par), twice_of_two(I1, I2, J, 0.0, k2, par)
        xy = twice_of_two(I1, I2, J, k1, k2, par) - x - y
        return energy, one.imag / s, two.imag / s, x / (k1 * k1), y / (k2 * k2), 0.5 * xy / (k1 * k2)

    @point_function
    def of_two(i1, i2, par):
        return of_two_at(3.0 + i1, 3.0 + i2, 1.0, par)

    @point_function
    def derivatives(i1, i2, x, par):
        I1, I2, J, s = 3.0 + i1, 3.0 + i2, sqrt(1.0 + x), TINY_STEP
        energy, g1, g2, h11, h22, h12 = of_two_at(I1, I2, J, par)
        gJ = psi(complex(I1), complex(I2), complex(J, s), par).imag / s
        k1, k2, kJ = STEP * I1 / 3.0, STEP * I2 / 3.0, STEP * J
        qJ = twice(I1, I2, J, 0.0, 0.0, kJ, par)
        q1J = twice(I1, I2, J, k1, 0.0, kJ, par) - k1 * k1 * h11 - qJ
        q2J = twice(I1, I2, J, 0.0, k2, kJ, par) - k2 * k2 * h22 - qJ
        return energy, g1, g2, gJ, h11, h22, qJ / (kJ * kJ), h12, 0.5 * q1J / (k1 * kJ), 0.5 * q2J / (k2 * kJ)

    return still, of_two, derivatives


def of_invariants(psi, incompressible):
    """The numbers of a point, and derivatives by components and by invariants, of an energy of I1, I2, J."""
    still, of_two, derivatives = by_invariants(psi)

    @point_function
    def on_the_way(T, p, c, par):
        """The energy a tiny step ahead in C33."""
        J, s = sqrt(p * c), TINY_STEP * c
        return psi(complex(T + c, s), complex(p + c * T, s * T), complex(J, 0.5 * s * J / c), par)

    @point_function
    def across(unused, a, b, d, c, par):
        T, p = a + b, a * b - d * d
        here = on_the_way(T, p, c, par)
        if is_off(here) and not isfinite(still(T + c, p + c * T, sqrt(p * c), par)):
            return nan, nan
        first, more = here.imag / (TINY_STEP * c), c * (1.0 + AHEAD)
        return first, (on_the_way(T, p, more, par).imag / (TINY_STEP * more) - first) / (c * AHEAD)

    @point_function
    def full(unused, a, b, d, c, par):
        return kernels.of_components(derivatives, a, b, d, c, par)

    @point_function
    def at_point(a, b, d, guess, par):
        if incompressible:
            return kernels.incompressible(of_two, a, b, d, par)
        return kernels.compressible(across, full, derivatives, a, b, d, guess, par)

    return at_point, full, derivatives


def by_components(psi, incompressible):
    """Values of an energy of C11, C22, C33, C12: as a real number, a tiny step ahead, and with all derivatives."""

    @point_function
    def value(a, b, c, d, par):
        if incompressible:
            c = 1.0 / (a * b - d * d)
        return psi(a, b, c, d, par)

    @point_function
    def still(a, b, c, d, par):
        real = value(complex(a), complex(b), complex(c), complex(d), par)  # infinite where it is no real number
        return real.real if real.imag == 0.0 else inf

    @point_function
    def once(a, b, c, d, u, v, w, x, par):
        s = TINY_STEP
        return value(complex(a, s * u), complex(b, s * v), complex(c, s * w), complex(d, s * x), par)

    @point_function
    def curved(a, b, c, d, u, v, w, x, slope, par):
        """Half of the second derivative along (u, v, w, x), which is small, where the first one is known."""
        u, v, w, x = SIXTH * u, SIXTH * v, SIXTH * w, SIXTH * x
        return value(a + u, b + v, c + w, d + x, par).imag * OVER_SINE - slope

    @point_function
    def full(unused, a, b, d, c, par):
        s, ka, kb, kc, kd = TINY_STEP, SHORT * a, SHORT * b, SHORT * c, SHORT * sqrt(a * b)
        of_a, of_b = once(a, b, c, d, 1.0, 0.0, 0.0, 0.0, par), once(a, b, c, d, 0.0, 1.0, 0.0, 0.0, par)
        of_d = once(a, b, c, d, 0.0, 0.0, 0.0, 1.0, par)
        ga, gb, gd = of_a.imag / s, of_b.imag / s, of_d.imag / s
        la, lb, ld = ga * ka, gb * kb, gd * kd
        aa, bb = curved(a, b, c, d, ka, 0.0, 0.0, 0.0, la, par), curved(a, b, c, d, 0.0, kb, 0.0, 0.0, lb, par)
        dd = curved(a, b, c, d, 0.0, 0.0, 0.0, kd, ld, par)
        ab = curved(a, b, c, d, ka, kb, 0.0, 0.0, la + lb, par) - aa - bb
        ad = curved(a, b, c, d, ka, 0.0, 0.0, kd, la + ld, par) - aa - dd
        bd = curved(a, b, c, d, 0.0, kb, 0.0, kd, lb + ld, par) - bb - dd
        energy = still(a, b, c, d, par) if is_off(of_a) else of_a.real
        gc = cc = ac = bc = dc = 0.0
        if not incompressible:
            gc = once(a, b, c, d, 0.0, 0.0, 1.0, 0.0, par).imag / s
            lc = gc * kc
            cc = curved(a, b, c, d, 0.0, 0.0, kc, 0.0, lc, par)
            ac = curved(a, b, c, d, ka, 0.0, kc, 0.0, la + lc, par) - aa - cc
            bc = curved(a, b, c, d, 0.0, kb, kc, 0.0, lb + lc, par) - bb - cc
            dc = curved(a, b, c, d, 0.0, 0.0, kc, kd, lc + ld, par) - cc - dd
        return (energy, ga, gb, gd, gc, 2.0 * aa / (ka * ka), 2.0 * bb / (kb * kb), 2.0 * dd / (kd * kd),
                2.0 * cc / (kc * kc), ab / (ka * kb), ad / (ka * kd), bd / (kb * kd), ac / (ka * kc), bc / (kb * kc),
                dc / (kd * kc))  # fmt: skip

    return still, once, full


def of_components(psi, incompressible):
    """The numbers of a point, and all derivatives, of an energy of C11, C22, C33, C12."""
    still, once, full = by_components(psi, incompressible)

    @point_function
    def across(unused, a, b, d, c, par):
        s, more = TINY_STEP, c * (1.0 + AHEAD)
        here = once(a, b, c, d, 0.0, 0.0, 1.0, 0.0, par)
        if is_off(here) and not isfinite(still(a, b, c, d, par)):
            return nan, nan
        first = here.imag / s
        return first, (once(a, b, more, d, 0.0, 0.0, 1.0, 0.0, par).imag / s - first) / (c * AHEAD)

    @point_function
    def at_point(a, b, d, guess, par):
        if not incompressible:
            return kernels.compressible(across, full, across, a, b, d, guess, par)
        p = a * b - d * d
        if not (a > 0.0 and p > 0.0):
            return kernels.failed(FOLDED)
        energy, ga, gb, gd, _, aa, bb, dd, _, ab, ad, bd, _, _, _ = full(None, a, b, d, 1.0 / p, par)
        if not isfinite(energy + ga + gb + gd + aa + bb + dd):
            return kernels.failed(BEYOND)
        return energy, 2.0 * ga, 2.0 * gb, gd, 4.0 * aa, 4.0 * bb, dd, 4.0 * ab, 2.0 * ad, 2.0 * bd, 1.0 / p, FINE

    return at_point, full, None
