r"""Ritz's method for square plates of side 1 by Legendre polynomials, with shear (Mindlin 1951) and without; D = 1.

Energies :math:`\tfrac12 \int \kappa \cdot D \kappa + k G h |\nabla w - \theta|^2` with the curvature of :math:`\theta`, and
the same with :math:`\theta = \nabla w`. Only fields that are symmetric about both middle lines. Global polynomials see
an edge layer of the width l from the degree :math:`\sqrt{1 / l}` on.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Legendre
from scipy.linalg import eigh

FREE, HELD = Legendre([1.0]), Legendre([2 / 3, 0.0, -2 / 3])
"""1 and 1 - x^2."""
# For w, theta_x, theta_y: the factor in x and that in y.
EDGES = {
    "hard": ((HELD, HELD), (FREE, HELD), (HELD, FREE)),
    "soft": ((HELD, HELD), (FREE, FREE), (FREE, FREE)),
    "clamped": ((HELD, HELD), (HELD, HELD), (HELD, HELD)),
    "two free": ((HELD, FREE), (FREE, FREE), (HELD, FREE)),
}
THIN = {"hard": (HELD, HELD), "soft": (HELD, HELD), "clamped": (HELD**2, HELD**2), "two free": (HELD, FREE)}
"""Edges "two free" have hard supports at x = 0 and 1, and none at y = 0 and 1."""


def functions(factor: Legendre, parity: int, n: int) -> list[Legendre]:
    return [factor * Legendre.basis(2 * k + parity) for k in range(n)]


def table(field: tuple, n: int, x: np.ndarray, y: np.ndarray, orders: tuple[int, int]) -> np.ndarray:
    """Derivatives of the products of functions at the points of a grid, (n^2, x, y), in the coordinates of a side 1."""
    (fx, px), (fy, py) = field
    X, Y = (np.array([f.deriv(k)(s) if k else f(s) for f in functions(factor, parity, n)])
            for factor, parity, k, s in ((fx, px, orders[0], x), (fy, py, orders[1], y)))  # fmt: skip
    return 2.0 ** sum(orders) * np.einsum("ip,jq->ijpq", X, Y).reshape(n * n, len(x), len(y))


@dataclass(frozen=True)
class Plate:
    """Coefficients (n_fields, n^2) of w, or of w, theta_x and theta_y."""

    fields: tuple
    n: int
    poisson: float
    c: np.ndarray
    energy: float

    def deflection(self, x: float, y: float) -> float:
        at = table(self.fields[0], self.n, np.array([2 * x - 1]), np.array([2 * y - 1]), (0, 0))[:, 0, 0]
        return float(self.c[0] @ at)

    def mean_moment(self, low: float, high: float) -> float:
        """Mean of M_11 over the square from low to high, positive where the upper face is stretched by a load up."""
        g, weight = np.polynomial.legendre.leggauss(self.n + 4)
        s = low + high - 1 + (high - low) * g
        area = np.outer(weight, weight) / 4
        if len(self.fields) == 1:
            xx, yy = (table(self.fields[0], self.n, s, s, k) for k in ((2, 0), (0, 2)))
            values = np.tensordot(self.c[0], xx + self.poisson * yy, 1)
        else:
            xx, yy = table(self.fields[1], self.n, s, s, (1, 0)), table(self.fields[2], self.n, s, s, (0, 1))
            values = np.tensordot(self.c[1], xx, 1) + self.poisson * np.tensordot(self.c[2], yy, 1)
        return -float((values * area).sum())


def _matrices(edges: str, h: float, n: int, poisson: float) -> tuple:
    """Fields, stiffness, the work of q = 1, and the matrices of w^2 + (h^2 / 12) theta^2 and w,x^2; h = 0 is thin."""
    g, weight = np.polynomial.legendre.leggauss(2 * n + 8)
    area = np.outer(weight, weight).ravel() / 4
    flat = lambda field, orders: table(field, n, g, g, orders).reshape(n * n, -1)  # noqa: E731
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    parities = ((0, 0), (1, 0), (0, 1))
    factors = EDGES[edges] if h else (THIN[edges],)
    fields = tuple(tuple(zip(f, p, strict=True)) for f, p in zip(factors, parities, strict=False))
    w, w_x, w_y = (flat(fields[0], k) for k in ((0, 0), (1, 0), (0, 1)))
    if not h:
        curvature = [flat(fields[0], (2, 0)), flat(fields[0], (0, 2)), 2 * flat(fields[0], (1, 1))]
        K = sum(law[i, j] * (curvature[i] * area) @ curvature[j].T for i in range(3) for j in range(3) if law[i, j])
        return fields, K, w @ area, (w * area) @ w.T, (w_x * area) @ w_x.T
    (p, p_x, p_y), (r, r_x, r_y) = ([flat(f, k) for k in ((0, 0), (1, 0), (0, 1))] for f in fields[1:])
    zero = np.zeros_like(w)
    curvature = [np.vstack(rows) for rows in ((zero, p_x, zero), (zero, zero, r_y), (zero, p_y, r_x))]
    K = sum(law[i, j] * (curvature[i] * area) @ curvature[j].T for i in range(3) for j in range(3) if law[i, j])
    stiffness = 5 / 6 * 6 * (1 - poisson) / h**2  # k G h / D
    K = K + stiffness * sum((s * area) @ s.T for s in (np.vstack((w_x, -p, zero)), np.vstack((w_y, zero, -r))))
    on_w, along = np.vstack((w, zero, zero)), np.vstack((w_x, zero, zero))
    turned = (np.vstack((zero, p, zero)), np.vstack((zero, zero, r)))
    mass = (on_w * area) @ on_w.T + h**2 / 12 * sum((v * area) @ v.T for v in turned)
    return fields, K, on_w @ area, mass, (along * area) @ along.T


@cache
def uniform(edges: str, h: float, n: int = 12, poisson: float = 0.3) -> Plate:
    """Under q = 1, with thickness h and shear; h = 0 is the thin theory."""
    fields, K, load, _, _ = _matrices(edges, h, n, poisson)
    scale = 1 / np.sqrt(K.diagonal())
    c = scale * np.linalg.lstsq(scale[:, None] * K * scale, scale * load, rcond=1e-15)[0]
    return Plate(fields, n, poisson, c.reshape(len(fields), -1), float(c @ load) / 2)


@cache
def lowest(edges: str, h: float, kind: str = "frequency", n: int = 8, poisson: float = 0.3) -> float:
    r""":math:`\omega \sqrt{\rho h a^4 / D}` of the first symmetric vibration, rotary inertia included; or, ``"buckling"``,
    :math:`N a^2 / D` of a compression along x."""
    _, K, _, mass, along = _matrices(edges, h, n, poisson)
    scale = 1 / np.sqrt(K.diagonal())
    other = mass if kind == "frequency" else along
    largest = float(eigh(scale[:, None] * other * scale, scale[:, None] * K * scale, eigvals_only=True)[-1])
    return largest**-0.5 if kind == "frequency" else 1 / largest
