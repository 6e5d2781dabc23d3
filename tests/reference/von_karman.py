r"""Large deflection of square plates in von Karman's theory by Ritz's method, a = E = h = 1.

.. math:: \varepsilon = (u_{,x} + \tfrac12 w_{,x}^2,\; v_{,y} + \tfrac12 w_{,y}^2,\; u_{,y} + v_{,x} + w_{,x} w_{,y})

Legendre polynomials of the symmetric class on a quarter's coordinates. The equations scale exactly: w / h depends on
q a^4 / (E h^4) and Poisson's ratio only. Levy, NACA Technical Note 847 (1942), has clamped plates by double series.
"""

import numpy as np
from numpy.polynomial import Legendre, Polynomial

FREE, HELD = Polynomial([1.0]), Polynomial([1.0, 0.0, -1.0])
# Factors of w and of u and v at all edges: immovable edges hold u = v = 0.
EDGES = {"simple": (HELD, HELD), "clamped": (HELD**2, HELD), "clamped, free in plane": (HELD**2, FREE)}


def centre(edges: str, loads: tuple[float, ...], poisson: float = 0.3, n: int = 7) -> np.ndarray:
    """w_c / h under growing loads q a^4 / (E h^4); n functions a side for each of u, v, w."""
    bending_factor, membrane_factor = EDGES[edges]
    g, gauss = np.polynomial.legendre.leggauss(4 * n)
    area = np.outer(gauss, gauss).ravel() / 4

    def row(factor: Polynomial, parity: int, order: int) -> np.ndarray:
        functions = [(factor * Legendre.basis(2 * k + parity).convert(kind=Polynomial)).deriv(order) for k in range(n)]
        return np.array([f(g) + 0 * g for f in functions])

    def table(factor: Polynomial, parities: tuple[int, int], orders: tuple[int, int]) -> np.ndarray:
        one, two = (row(factor, *pair) for pair in zip(parities, orders, strict=True))
        # Derivatives on a side of length 1 are twice those on [-1, 1].
        return 2 ** sum(orders) * np.einsum("ip,jq->ijpq", one, two).reshape(n * n, -1)

    w, w_x, w_y, w_xx, w_xy, w_yy = (
        table(bending_factor, (0, 0), k) for k in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    u_x, u_y = (table(membrane_factor, (1, 0), k) for k in ((1, 0), (0, 1)))
    v_x, v_y = (table(membrane_factor, (0, 1), k) for k in ((1, 0), (0, 1)))
    law = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]]) / (1 - poisson**2)
    zero, kappa = np.zeros_like(w), np.stack([w_xx, w_yy, 2 * w_xy])
    linear = np.hstack([np.stack([u_x, zero, u_y]), np.stack([zero, v_y, v_x])])
    bending = np.einsum("iap,ij,jbp,p->ab", kappa, law / 12, kappa, area, optimize=True)
    work, first = w @ area, slice(2 * n * n, None)
    c, deflections = np.zeros(3 * n * n), []
    middle = table_at_centre(bending_factor, n)
    for load in loads:
        for _ in range(60):
            x, y = c[first] @ w_x, c[first] @ w_y
            B = np.hstack([linear, np.stack([x * w_x, y * w_y, x * w_y + y * w_x])])
            strain = np.einsum("iap,a->ip", linear, c[: 2 * n * n]) + np.stack([x * x / 2, y * y / 2, x * y])
            N = law @ strain * area
            residual = np.einsum("iap,ip->a", B, N)
            residual[first] += bending @ c[first] - load * work
            K = np.einsum("iap,ij,jbp,p->ab", B, law, B, area, optimize=True)
            K[first, first] += bending + (w_x * N[0]) @ w_x.T + (w_y * N[1]) @ w_y.T
            K[first, first] += (w_x * N[2]) @ w_y.T + (w_y * N[2]) @ w_x.T
            scale = 1 / np.sqrt(K.diagonal())
            change = -scale * np.linalg.solve(scale[:, None] * K * scale, scale * residual)
            c = c + change
            if abs(change[first] @ middle) < 1e-10:
                break
        deflections.append(c[first] @ middle)
    return np.array(deflections)


def table_at_centre(factor: Polynomial, n: int) -> np.ndarray:
    """Values of the functions of w in the middle, (n * n,)."""
    values = np.array([(factor(0.0) * Legendre.basis(2 * k))(0.0) for k in range(n)])
    return np.outer(values, values).ravel()
