"""A cantilever under a pressure that stays normal to it: the inextensible elastica."""

import numpy as np
from scipy.integrate import solve_ivp


def tip(load: float) -> tuple[float, float, float]:
    r"""x / L, y / L and angle of the free end under p L^3 / (E I) = load, p a force per length along the turned normal.

    .. math:: \theta' = m, \quad m' = f_x \sin\theta - f_y \cos\theta, \quad f' = p\,(\sin\theta, -\cos\theta)

    in units of L and E I. Such a load turns with the strip, so the shape seen from the free end, where m = f = 0, is an
    initial value problem; the clamp then says how it lies in space.
    """

    def slopes(s: float, y: np.ndarray) -> np.ndarray:
        theta, moment, fx, fy = y[:4]
        c, n = np.cos(theta), np.sin(theta)
        return np.array([moment, fx * n - fy * c, load * n, -load * c, c, n])

    found = solve_ivp(slopes, (1.0, 0.0), np.zeros(6), method="DOP853", rtol=1e-12, atol=1e-13)
    theta, x, y = found.y[[0, 4, 5], -1]
    c, n = np.cos(theta), np.sin(theta)
    return float(-c * x - n * y), float(n * x - c * y), float(-theta)
