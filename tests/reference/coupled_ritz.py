"""Ritz's method as in thick_ritz, without symmetry, for any bending and shear stiffness: the energy under q = 1."""

from functools import cache

import numpy as np
from numpy.polynomial import Legendre

from reference.thick_ritz import FREE, HELD

LEFT = Legendre([1.0, 1.0])
# For w and both rotations with shear, and for w without: the factor in x and that in y.
THICK = {"soft": ((HELD, HELD), (FREE, FREE), (FREE, FREE)), "clamped": ((HELD, HELD),) * 3,
         "one clamped": ((LEFT, FREE),) * 3}  # fmt: skip
THIN = {"soft": (HELD, HELD), "clamped": (HELD**2, HELD**2), "one clamped": (LEFT**2, FREE)}


@cache
def energy(edges: str, bending: tuple, shear: tuple | None, n: int = 12) -> float:
    """Of the unit square with the stiffness (3, 3) of 11, 22, 12 and (2, 2) of 13, 23; without that of the thin theory."""
    s, weight = np.polynomial.legendre.leggauss(n + 10)
    area = np.outer(weight, weight).ravel() / 4

    def table(factors: tuple, orders: tuple[int, int]) -> np.ndarray:
        functions = ([f * Legendre.basis(k) for k in range(n)] for f in factors)
        X, Y = (np.array([g.deriv(order)(s) if order else g(s) for g in each])
                for each, order in zip(functions, orders, strict=True))  # fmt: skip
        return 2.0 ** sum(orders) * np.einsum("ip,jq->ijpq", X, Y).reshape(n * n, -1)

    def form(rows: list[np.ndarray], law: tuple) -> np.ndarray:
        return sum(law[i][j] * (one * area) @ two.T for i, one in enumerate(rows) for j, two in enumerate(rows) if law[i][j])

    if shear is None:
        w = THIN[edges]
        K, load = form([table(w, (2, 0)), table(w, (0, 2)), 2 * table(w, (1, 1))], bending), table(w, (0, 0)) @ area
    else:
        (w, w_x, w_y), (_, p_x, p_y), (_, r_x, r_y) = ([table(f, o) for o in ((0, 0), (1, 0), (0, 1))] for f in THICK[edges])
        p, r, zero = table(THICK[edges][1], (0, 0)), table(THICK[edges][2], (0, 0)), np.zeros_like(w)
        K = form([np.vstack(v) for v in ((zero, p_x, zero), (zero, zero, r_y), (zero, p_y, r_x))], bending)
        K = K + form([np.vstack(v) for v in ((w_x, p, zero), (w_y, zero, r))], shear)
        load = np.concatenate([w @ area, np.zeros(2 * n * n)])
    scale = 1 / np.sqrt(K.diagonal())
    return float(0.5 * load @ (scale * np.linalg.solve(scale[:, None] * K * scale, scale * load)))
