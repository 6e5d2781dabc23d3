r"""Ritz's method for thin rhombic plates of side 1 by Legendre polynomials in oblique coordinates s, t in [-1, 1].

With :math:`x = (s + t \cos\alpha) / 2,\; y = t \sin\alpha / 2` and D = 1 the energy is that of Kirchhoff's theory,

.. math:: \tfrac12 \int (w_{,xx} + w_{,yy})^2 - 2 (1 - \nu) (w_{,xx} w_{,yy} - w_{,xy}^2) \, dx\, dy - \int q w.

Global polynomials: independent of any mesh (Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 1959, art. 80).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import cos, pi, sin

import numpy as np
from numpy.polynomial import Legendre, Polynomial

HELD = Polynomial([1.0, 0.0, -1.0])
FACTORS = {"simple": HELD, "clamped": HELD**2, "corners": Polynomial([1.0])}


@dataclass(frozen=True)
class Plate:
    """Deflection as a function of the oblique coordinates along the sides, from 0 to 1, and half the work of the load."""

    deflection: Callable[[np.ndarray, np.ndarray], np.ndarray]
    energy: float


@cache
def uniform(edges: str, n: int, poisson: float = 0.3, angle: float = pi / 2) -> Plate:
    """Under q = 1: edges "simple", "clamped" or, for the square, "corners" (free, held there); degrees below n a side."""
    factor = FACTORS[edges]
    functions = [factor * Legendre.basis(k).convert(kind=Polynomial) for k in range(n)]
    # The solution does not change by half a turn, on the square by two mirrors.
    step = 1 if edges != "corners" else 2
    pairs = [(i, j) for i in range(0, n, step) for j in range(0, n, step) if (i + j) % 2 == 0]

    def products(s: np.ndarray, t: np.ndarray, orders: tuple[int, int]) -> np.ndarray:
        one, two = ([f.deriv(k)(v) for f in functions] for v, k in zip((s, t), orders, strict=True))
        values = np.array([one[i] * two[j] for i, j in pairs])
        if edges == "corners":
            # Less the first one, all vanish at the corners, where even Legendre polynomials are 1.
            values = values[1:] - values[0]
        return values

    g, weight = np.polynomial.legendre.leggauss(n + 6)
    s, t = (v.ravel() for v in np.meshgrid(g, g, indexing="ij"))
    area = np.outer(weight, weight).ravel() * sin(angle) / 4
    ss, st, tt = (4 * products(s, t, orders) for orders in ((2, 0), (1, 1), (0, 2)))
    xx, xy, yy = ss, (st - cos(angle) * ss) / sin(angle), (tt - 2 * cos(angle) * st + cos(angle) ** 2 * ss) / sin(angle) ** 2
    K = sum((a * area) @ b.T for a, b in ((xx, xx), (yy, yy)))
    mixed = (xx * area) @ yy.T
    K = K + poisson * (mixed + mixed.T) + 2 * (1 - poisson) * (xy * area) @ xy.T
    load = products(s, t, (0, 0)) @ area
    scale = 1 / np.sqrt(K.diagonal())
    c = scale * np.linalg.solve(scale[:, None] * K * scale, scale * load)
    return Plate(lambda x, y: c @ products(2 * x - 1, 2 * y - 1, (0, 0)), float(c @ load) / 2)
