"""Right values by formulas, series and one-dimensional Ritz; D = q = 1 unless said otherwise. No use of the library."""

import sys
from collections.abc import Callable
from math import cos, exp, pi, radians, sin
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.special import iv, jv

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from reference import axisymmetric, cylinder, elastica

NU = 0.3
Value = tuple[float, float, str]
"""Value, uncertainty, source."""
EXACT = 1e-12


def _waves(terms: int, odd: bool = False) -> tuple[np.ndarray, np.ndarray]:
    n = np.arange(1, terms, 2 if odd else 1)
    return n[:, None], n[None, :]


def navier(what: str, bed: float = 0.0) -> Value:
    """Unit square on hard supports, and on a foundation, under q = 1."""
    found = []
    for terms in (800, 1600):
        m, n = _waves(terms, odd=True)
        w = 16 / (pi**2 * m * n) / (pi**4 * (m**2 + n**2) ** 2 + bed)
        signs = np.sin(m * pi / 2) * np.sin(n * pi / 2)
        found.append({
            "w": (w * signs).sum(), "energy": 0.5 * (w * 4 / (pi**2 * m * n)).sum(),
            "moment": -(w * signs * pi**2 * (m**2 + NU * n**2)).sum(),
        }[what])  # fmt: skip
    return float(found[1]), abs(found[1] - found[0]), "Navier's series"


def supported_side() -> Value:
    """Force of a side of the unit square with both its corners, which pull down: 1/4 + R - 2 R, R = 2 (1 - nu) w,xy."""
    found = []
    for terms in (1000, 2000, 4000):
        m, n = _waves(terms, odd=True)
        found.append(0.25 - 2 * (1 - NU) * float((16 / (pi**4 * (m**2 + n**2) ** 2)).sum()))
    a, b, c = found
    one, two = b + (b - a) / 3, c + (c - b) / 3  # tails fall like 1 / terms^2
    return two, abs(two - one), "Navier's series"


def supported_frequency(m: int, n: int) -> Value:
    """Hz, for a mass of 0.01 per area."""
    return 10 * pi / 2 * (m**2 + n**2), EXACT, "closed form"


def _force(
    at: list[float], functional: Callable[[np.ndarray, np.ndarray], np.ndarray], load: np.ndarray | None = None
) -> Value:
    """Unit square on hard supports under a force at a point, or a load with other coefficients: the tail falls like
    1 / terms^2 at the force."""
    found = []
    for terms in (1000, 2000, 4000):
        m, n = _waves(terms)
        acting = (
            np.sin(m * pi * at[0]) * np.sin(n * pi * at[1])
            if load is None
            else -m * pi * np.cos(m * pi * at[0]) * np.sin(n * pi * at[1])
        )
        found.append(float((4 * acting / (pi**4 * (m**2 + n**2) ** 2) * functional(m, n)).sum()))
    return found[2], max(abs(found[2] - found[1]), 1e-9 * abs(found[2])), "Navier's series"


def navier_force(at: list[float], times: float = 1.0) -> Value:
    value, doubt, source = _force(at, lambda m, n: np.sin(m * pi * at[0]) * np.sin(n * pi * at[1]))
    return times * value, times * doubt, source


def navier_force_moment(at: list[float], where: list[float]) -> Value:
    def moment(m: np.ndarray, n: np.ndarray) -> np.ndarray:
        return -(pi**2) * (m**2 + NU * n**2) * np.sin(m * pi * where[0]) * np.sin(n * pi * where[1]) * _mean(m) * _mean(n)

    def _mean(k: np.ndarray) -> np.ndarray:  # Lanczos' factors: what is smooth there converges as if it were so all over
        return np.sinc(k / k.max()) ** 3

    return _force(at, moment)


def navier_couple(where: list[float]) -> Value:
    """w under a moment of 1 about y at the middle."""
    return _force([0.5, 0.5], lambda m, n: np.sin(m * pi * where[0]) * np.sin(n * pi * where[1]), np.zeros(1))


def disc(what: str, part: float = 0.0) -> Value:
    """Clamped, radius 1: w at a radius, the energy of a part, the moment in the middle and that at the edge."""
    value = {"w": (1 - part**2) ** 2 / 64, "energy": part * pi / 384, "moment": -(1 + NU) / 16, "edge moment": 1 / 8}[what]
    return value, EXACT, "closed form"


def supported_disc(what: str, part: float = 1.0) -> Value:
    """w = (1 - r^2) ((5 + nu) / (1 + nu) - r^2) / 64."""
    c = (5 + NU) / (1 + NU)
    return {"w": c / 64, "energy": part * pi / 64 * (c / 4 - 1 / 12)}[what], EXACT, "closed form"


def disc_force(what: str) -> Value:
    w = axisymmetric.disc_centre("clamped", "point")
    return {"clamped": w, "energy": w / 2}[what], EXACT, "closed form"


def disc_frequency() -> Value:
    """Clamped disc, a mass of 0.01 per area."""
    root = brentq(lambda k: jv(0, k) * iv(1, k) + iv(0, k) * jv(1, k), 3.0, 3.4, xtol=1e-15)
    return 10 * root**2 / (2 * pi), 1e-11, "Bessel functions"


def ring(inner: float, what: str) -> Value:
    """Free at the inner edge, clamped at 1: w and the hoop moment there."""
    w = axisymmetric.ring((inner, 1.0), ("free", "clamped"))
    rows = np.vstack([axisymmetric.conditions(e, r, 1.0, NU) for r, e in ((inner, "free"), (1.0, "clamped"))])
    c = np.append(np.linalg.solve(rows[:, :4], -rows[:, 4]), 1.0)
    _, slope, second, _ = axisymmetric.derivatives(inner, 1.0) @ c
    # w is up along a load upwards here, and the plate is loaded downwards.
    return {"w": float(w(inner)), "moment": float(slope / inner + NU * second)}[what], 1e-12, "closed form"


def roof() -> Value:
    shell = cylinder.Cylinder(25.0, 50.0, 0.25, 4.32e8, 0.0)
    one, two = (cylinder.roof(shell, radians(40), 90.0, terms, degree) for terms, degree in ((24, 20), (48, 24)))
    return two, max(abs(two - one), 1e-8), "series along the axis, polynomials around it (tests/reference/cylinder.py)"


def pinched() -> Value:
    """Tails fall like 1 / terms^2."""
    shell = cylinder.Cylinder(300.0, 600.0, 3.0, 3e6, 0.3)
    a, b, c = (cylinder.pinched(shell, terms) for terms in (100, 200, 400))
    one, two = b + (b - a) / 3, c + (c - b) / 3
    return two, abs(two - one), "Fourier series (tests/reference/cylinder.py), extrapolated"


def warm_square() -> Value:
    """Curvature alpha times 1000 per length below: w = (1 + nu) kappa times the torsion function."""
    m = np.arange(1, 101, 2)
    middle = 1 / 8 - (4 / pi**3 * np.sin(m * pi / 2) / (m**3 * np.cosh(m * pi / 2))).sum()
    return float((1 + NU) * 1e-2 * middle), 1e-12, "series of the torsion function"


def harmonic(k: float, x: float, y: float, what: str) -> Value:
    w = exp(k * x) * cos(k * y)
    value = {"w": w, "moment": -(1 - NU) * k**2 * w, "rotation": k * exp(k * x) * sin(k * y)}[what]
    return value, EXACT, "closed form"


def strip(slenderness: float, load: float, what: str) -> Value:
    u, w = elastica.extensible(slenderness, load)
    return {"u": float(u), "w": float(w)}[what], 1e-8, "extensible elastica (tests/reference/elastica.py)"


def dome(what: str, part: float = 1.0) -> Value:
    r"""A cap of radius 1 to the polar angle 0.7, 0.02 thick, clamped, under a pressure of 1 inwards.

    Ritz's method on the meridian with the strains of Koiter's theory, w outwards:

    .. math:: \varepsilon = (u' + w,\; u \cot\phi + w), \qquad
        \rho = (w'' - w - 2 u',\; w' \cot\phi - w - 2 u \cot\phi).
    """
    one, two = (_dome(n)[what] for n in (14, 20))
    if what == "energy":
        one, two = part * one, part * two
    return two, max(abs(two - one), 1e-9 * abs(two)), "Ritz's method on the meridian"


def _dome(n: int, end: float = 0.7, thickness: float = 0.02, young: float = 1.092e7) -> dict[str, float]:
    g, gauss = np.polynomial.legendre.leggauss(4 * n)
    phi, area = end * (g + 1) / 2, gauss * end / 2
    cot, weight = 1 / np.tan(phi), area * 2 * pi * np.sin(phi)
    u, w = (np.array(functions) for functions in _functions(n, phi / end, end))
    strains = [np.stack([f[1], cot * f[0], -2 * f[1], -2 * cot * f[0]]) for f in u]
    strains += [np.stack([f[0], f[0], f[2] - f[0], cot * f[1] - f[0]]) for f in w]
    B = np.array(strains)
    law = young / (1 - NU**2) * np.kron(np.diag([thickness, thickness**3 / 12]), [[1, NU], [NU, 1]])
    K = np.einsum("aip,ij,bjp,p->ab", B, law, B, weight, optimize=True)
    load = -np.concatenate([np.zeros(n), w[:, 0] @ weight])
    scale = 1 / np.sqrt(K.diagonal())
    c = scale * np.linalg.solve(scale[:, None] * K * scale, scale * load)
    middle = [(-1.0) ** k for k in range(n)]
    return {"w": -float(c[n:] @ middle), "energy": 0.5 * float(load @ c)}


def _functions(n: int, r: np.ndarray, end: float) -> tuple[list, list]:
    """Odd functions that vanish at r = 1, and even ones that do with their slope: values and two derivatives by phi."""
    s, held = 2 * r**2 - 1, 1 - r**2
    odd, even = [], []
    for k in range(n):
        f = np.polynomial.Legendre.basis(k)
        p, dp, ddp = f(s), 4 * r * f.deriv()(s), 16 * r**2 * f.deriv(2)(s) + 4 * f.deriv()(s)
        a, da, dda = r * held, 1 - 3 * r**2, -6 * r
        b, db, ddb = held**2, -4 * r * held, 12 * r**2 - 4
        odd.append([a * p, (da * p + a * dp) / end, (dda * p + 2 * da * dp + a * ddp) / end**2])
        even.append([b * p, (db * p + b * dp) / end, (ddb * p + 2 * db * dp + b * ddp) / end**2])
    return odd, even


def tank(what: str) -> Value:
    r"""A quarter of a cylinder of radius and length 1, 0.02 thick, clamped at its foot, under a pressure of 1 outwards.

    Ritz's method along the axis with :math:`\varepsilon = (u', w),\; \rho = (w'', -w)`: w at a quarter of the length, the
    axial moment :math:`-D (w'' - \nu w)` at the foot, the energy.
    """
    one, two = (_tank(n)[what] for n in (24, 32))
    return two, abs(two - one), "Ritz's method along the axis"


def _tank(n: int, thickness: float = 0.02, young: float = 1.092e7) -> dict[str, float]:
    g, gauss = np.polynomial.legendre.leggauss(3 * n)
    law = young / (1 - NU**2) * np.kron(np.diag([thickness, thickness**3 / 12]), [[1, NU], [NU, 1]])

    def strains(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of functions x P_k for u and x^2 P_k for w, (2 n, 4, ...); and w."""
        u, w = [], []
        for k in range(n):
            f = np.polynomial.Legendre.basis(k, domain=[0, 1])
            p, dp, ddp = f(x), f.deriv()(x), f.deriv(2)(x)
            u.append([p + x * dp, 0 * x, 0 * x, 0 * x])
            w.append([0 * x, x**2 * p, 2 * p + 4 * x * dp + x**2 * ddp, -(x**2) * p])
        return np.array(u + w), np.array(w)[:, 1]

    B, w = strains((g + 1) / 2)
    weight = gauss / 2 * pi / 2
    K = np.einsum("aip,ij,bjp,p->ab", B, law, B, weight, optimize=True)
    load = np.concatenate([np.zeros(n), w @ weight])
    scale = 1 / np.sqrt(K.diagonal())
    c = scale * np.linalg.solve(scale[:, None] * K * scale, scale * load)
    foot = np.einsum("a,ai->i", c, strains(np.zeros(1))[0][:, :, 0])
    inside = float(c[n:] @ strains(np.full(1, 0.25))[1][:, 0])
    return {"w": inside, "moment": -float((law @ foot)[2]), "energy": 0.5 * float(load @ c)}


FORMULAS: dict[str, Callable[..., Value]] = {
    f.__name__: f
    for f in (navier, supported_side, supported_frequency, navier_force, navier_force_moment, navier_couple, disc,
              supported_disc, disc_force, disc_frequency, ring, roof, pinched, warm_square, harmonic, strip, dome, tank)
}  # fmt: skip
