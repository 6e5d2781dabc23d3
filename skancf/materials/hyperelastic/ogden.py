r"""Ogden's law, in principal stretches.

With the eigenvalues :math:`l_1 \ge l_2` of C in the plane, :math:`l_3 = c`, and :math:`L_i = \ln l_i`, the energy has first
derivatives :math:`t_i` and second ones :math:`h_{ij}` by the logarithms. In the axes of the eigenvectors the shear has

.. math:: \frac{t_1 / l_1 - t_2 / l_2}{l_1 - l_2} = \frac{t_1 - t_2}{l_1 (l_1 - l_2)} - \frac{t_2}{l_1 l_2},

and :math:`t_1 - t_2` is a sum of :math:`e^{\alpha y_2} (e^{\alpha (y_1 - y_2)} - 1)`, which keeps its digits however near
the stretches are to each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, expm1, isfinite, isinf, log, log1p, sqrt
from typing import Any

import numpy as np

from skancf.compiled import compiled
from skancf.equality import by_value
from skancf.errors import InputError, finite
from skancf.materials.hyperelastic import kernels
from skancf.materials.hyperelastic.kernels import LOOP, POINT
from skancf.materials.hyperelastic.law import OfInvariants
from skancf.materials.point_law import BEYOND, FINE, FOLDED
from skancf.showing import short


@compiled(**POINT)
def principal(a, b, d):
    """Logarithms of both eigenvalues, the eigenvalues, their difference, and cosine and sine of twice the angle."""
    A, B = a - 1.0, b - 1.0
    mean, half = 0.5 * (A + B), 0.5 * (A - B)
    r = sqrt(half * half + d * d)
    e1, e2 = mean + r, mean - r
    if e1 > 1.0:
        e2 = (a * b - d * d) / (1.0 + e1) - 1.0
    cos, sin = (half / r, d / r) if r > 0.0 else (1.0, 0.0)
    return log1p(e1), log1p(e2), 1.0 + e1, 1.0 + e2, 2.0 * r, cos, sin


@compiled(**POINT)
def terms(y1, y2, y3, par):
    """Energy; sums of mu (e^(alpha y) - 1) and of mu alpha e^(alpha y) for each of three logarithms."""
    energy, f1, f2, f3, g1, g2, g3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(1, par.size - 1, 2):
        shear, alpha = par[k], par[k + 1]
        one, two, three = expm1(alpha * y1), expm1(alpha * y2), expm1(alpha * y3)
        energy += shear / alpha * (one + two + three)
        f1 += shear * one
        f2 += shear * two
        f3 += shear * three
        g1 += shear * alpha * (1.0 + one)
        g2 += shear * alpha * (1.0 + two)
        g3 += shear * alpha * (1.0 + three)
    return energy, f1, f2, f3, g1, g2, g3


@compiled(**POINT)
def shearing(y2, l2, apart, par):
    """(t1 - t2) / (l1 - l2) of the isochoric part, for eigenvalues that are ``apart``."""
    total, log_ratio = 0.0, 0.5 * log1p(apart / l2)
    for k in range(1, par.size - 1, 2):
        shear, alpha = par[k], par[k + 1]
        quotient = expm1(alpha * log_ratio) / apart if apart > 0.0 else 0.5 * alpha / l2
        total += 0.5 * shear * exp(alpha * y2) * quotient
    return total


@compiled(**POINT)
def in_plane(t1, t2, h11, h22, h12, shear, l1, l2, cos, sin):
    """Derivatives by a, b, d, then aa, bb, dd, ab, ad, bd, and those of both eigenvalues by a, b, d."""
    F1, F2 = t1 / l1, t2 / l2
    F11, F22, F12 = (h11 - t1) / (l1 * l1), (h22 - t2) / (l2 * l2), h12 / (l1 * l2)
    s = shear / l1 - t2 / (l1 * l2)
    u = (0.5 * (1.0 + cos), 0.5 * (1.0 - cos), sin)
    v = (0.5 * (1.0 - cos), 0.5 * (1.0 + cos), -sin)
    square = 0.5 * s * sin * sin
    return (
        F1 * u[0] + F2 * v[0],
        F1 * u[1] + F2 * v[1],
        F1 * u[2] + F2 * v[2],
        F11 * u[0] * u[0] + F22 * v[0] * v[0] + 2.0 * F12 * u[0] * v[0] + square,
        F11 * u[1] * u[1] + F22 * v[1] * v[1] + 2.0 * F12 * u[1] * v[1] + square,
        F11 * u[2] * u[2] + F22 * v[2] * v[2] + 2.0 * F12 * u[2] * v[2] + 2.0 * s * cos * cos,
        F11 * u[0] * u[1] + F22 * v[0] * v[1] + F12 * (u[0] * v[1] + u[1] * v[0]) - square,
        F11 * u[0] * u[2] + F22 * v[0] * v[2] + F12 * (u[0] * v[2] + u[2] * v[0]) - s * cos * sin,
        F11 * u[1] * u[2] + F22 * v[1] * v[2] + F12 * (u[1] * v[2] + u[2] * v[1]) + s * cos * sin,
        u,
        v,
    )


@compiled(**POINT)
def volume(total, bulk):
    """Energy of a change of volume whose square has the logarithm ``total``, and its derivatives by that."""
    x = expm1(total)
    return 0.25 * bulk * (x - total), 0.25 * bulk * x, 0.25 * bulk * (1.0 + x)


@compiled(**POINT)
def across(unused, a, b, d, c, par):
    L1, L2, _, _, _, _, _ = principal(a, b, d)
    L3 = log(c)
    total = L1 + L2 + L3
    _, f1, f2, f3, g1, g2, g3 = terms(0.5 * L1 - total / 6.0, 0.5 * L2 - total / 6.0, 0.5 * L3 - total / 6.0, par)
    _, by_total, twice = volume(total, par[0])
    t3 = 0.5 * (f3 - (f1 + f2 + f3) / 3.0) + by_total
    h33 = 0.25 * g3 - g3 / 6.0 + (g1 + g2 + g3) / 36.0 + twice
    return t3 / c, (h33 - t3) / (c * c)


@compiled(**POINT)
def of_components(unused, a, b, d, c, par):
    """As :func:`skancf.materials.hyperelastic.kernels.of_components`."""
    L1, L2, l1, l2, apart, cos, sin = principal(a, b, d)
    L3 = log(c)
    total = L1 + L2 + L3
    y2 = 0.5 * L2 - total / 6.0
    energy, f1, f2, f3, g1, g2, g3 = terms(0.5 * L1 - total / 6.0, y2, 0.5 * L3 - total / 6.0, par)
    of_volume, by_total, twice = volume(total, par[0])
    less, more = by_total - (f1 + f2 + f3) / 6.0, twice + (g1 + g2 + g3) / 36.0
    t1, t2, t3 = 0.5 * f1 + less, 0.5 * f2 + less, 0.5 * f3 + less
    h11, h22, h33 = g1 / 12.0 + more, g2 / 12.0 + more, g3 / 12.0 + more
    h12, h13, h23 = more - (g1 + g2) / 12.0, more - (g1 + g3) / 12.0, more - (g2 + g3) / 12.0
    ga, gb, gd, aa, bb, dd, ab, ad, bd, u, v = in_plane(
        t1, t2, h11, h22, h12, shearing(y2, l2, apart, par), l1, l2, cos, sin
    )
    F13, F23 = h13 / (l1 * c), h23 / (l2 * c)
    return (energy + of_volume, ga, gb, gd, t3 / c, aa, bb, dd, (h33 - t3) / (c * c), ab, ad, bd,
            F13 * u[0] + F23 * v[0], F13 * u[1] + F23 * v[1], F13 * u[2] + F23 * v[2])  # fmt: skip


@compiled(**POINT)
def incompressible(a, b, d, par):
    p = a * b - d * d
    if not (a > 0.0 and p > 0.0):
        return kernels.failed(FOLDED)
    L1, L2, l1, l2, apart, cos, sin = principal(a, b, d)
    y2 = 0.5 * L2
    energy, f1, f2, f3, g1, g2, g3 = terms(0.5 * L1, y2, -0.5 * (L1 + L2), par)
    t1, t2 = 0.5 * (f1 - f3), 0.5 * (f2 - f3)
    h11, h22, h12 = 0.25 * (g1 + g3), 0.25 * (g2 + g3), 0.25 * g3
    ga, gb, gd, aa, bb, dd, ab, ad, bd, _, _ = in_plane(
        t1, t2, h11, h22, h12, shearing(y2, l2, apart, par), l1, l2, cos, sin
    )
    if not isfinite(energy + ga + gb + gd + aa + bb + dd):
        return kernels.failed(BEYOND)
    return energy, 2.0 * ga, 2.0 * gb, gd, 4.0 * aa, 4.0 * bb, dd, 4.0 * ab, 2.0 * ad, 2.0 * bd, 1.0 / p, FINE


@compiled(**POINT)
def at_point(a, b, d, guess, par):
    if isinf(par[0]):
        return incompressible(a, b, d, par)
    return kernels.compressible(across, of_components, across, a, b, d, guess, par)


@compiled(**LOOP)
def at_points(C, guess, par, out):
    for k in range(C.shape[1]):
        kernels.store(out, k, at_point(C[0, k], C[1, k], C[2, k], guess[k], par))


@by_value
@dataclass(frozen=True)
class Ogden(OfInvariants):
    r"""Rubber at large stretches, :math:`\psi = \sum_p \tfrac{\mu_p}{\alpha_p} (\bar\lambda_1^{\alpha_p} +
    \bar\lambda_2^{\alpha_p} + \bar\lambda_3^{\alpha_p} - 3) + \tfrac K4 (J^2 - 1 - 2 \ln J)`.

    :math:`\bar\lambda_i = J^{-1/3} \lambda_i` are the principal stretches without the change of volume.

    Parameters
    ----------
    terms : sequence of (mu, alpha)
        :math:`\mu_p` (Pa) and :math:`\alpha_p`; the shear modulus of small strain is
        :math:`\mu = \tfrac12 \sum \mu_p \alpha_p`.
    density : float
        Mass per undeformed volume (kg/m3).
    poisson, bulk, expansion
        As for :class:`~skancf.NeoHooke`; without Poisson's ratio and bulk modulus it is incompressible.

    Raises
    ------
    InputError
        For terms that are no pairs, an exponent that is zero, a shear modulus that is not positive, and as for
        :class:`~skancf.NeoHooke`.

    Notes
    -----
    Stable at all stretches if every :math:`\mu_p \alpha_p` is positive; otherwise at those it was fitted to.

    Examples
    --------
    >>> rubber = sk.Ogden([(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)], density=1000.0)
    >>> stress = rubber.plane_stress(np.array([[4.0], [0.5], [0.0]])).stress  # stretched to twice its length
    >>> print((4 * stress[0]).round(1), "Pa")
    [1205443.2] Pa
    """

    terms: Sequence[Any]
    density: float
    poisson: float | None = None
    bulk: float | None = None
    expansion: float = 0.0
    compiled = at_point
    _at_points = staticmethod(at_points)

    __repr__ = short

    def _check(self) -> None:
        pairs = finite("terms", self.terms)
        if pairs.ndim != 2 or pairs.shape[1] != 2 or not len(pairs):
            raise InputError(f"terms of shape {pairs.shape}: give pairs, as in [(6.3e5, 1.3), (-1e4, -2.0)]")
        object.__setattr__(self, "terms", tuple(map(tuple, pairs.tolist())))
        if not pairs[:, 1].all():
            raise InputError(f"terms = {self.terms}: an exponent is zero; leave that term out, it has no energy")
        if not self.shear_modulus > 0:
            raise InputError(f"terms = {self.terms}: the shear modulus, half the sum of mu alpha, is {self.shear_modulus:g} "
                             "Pa and must be greater than zero")  # fmt: skip

    @property
    def shear_modulus(self) -> float:
        return 0.5 * sum(shear * alpha for shear, alpha in self.terms)

    @property
    def parameters(self) -> np.ndarray:
        return np.array([self.bulk_modulus, *np.ravel(self.terms)])
