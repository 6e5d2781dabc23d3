r"""Inextensible elastica: a cantilever of length 1 with a dead force at its end, normal to the undeformed axis.

By Legendre's elliptic integrals with :math:`m = (1 + \sin\varphi) / 2` and :math:`\sin^2 \theta = 1 / (2 m)`,

.. math::
    \sqrt{\alpha} = K(m) - F(\theta | m), \qquad w = 1 - \frac{2}{\sqrt\alpha}(E(m) - E(\theta | m)), \qquad
    1 - u = \sqrt{2 \sin\varphi / \alpha},

with :math:`\alpha = P L^2 / E I` and the tip angle :math:`\varphi` (Bisshopp and Drucker 1945, Quart. Appl.
Math. 3, 272-275).
"""

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc


def tip_angle(alpha: float) -> float:
    def excess(phi: float) -> float:
        m = (1 + np.sin(phi)) / 2
        return ellipk(m) - ellipkinc(np.arcsin(np.sqrt(1 / (2 * m))), m) - np.sqrt(alpha)

    return brentq(excess, 1e-9, np.pi / 2 - 1e-12, xtol=1e-14)


def tip(alpha: float) -> tuple[float, float]:
    """Displacements over the length: against the undeformed axis, along the force."""
    phi = tip_angle(alpha)
    m = (1 + np.sin(phi)) / 2
    theta = np.arcsin(np.sqrt(1 / (2 * m)))
    w = 1 - 2 / np.sqrt(alpha) * (ellipe(m) - ellipeinc(theta, m))
    return 1 - np.sqrt(2 * np.sin(phi) / alpha), float(w)


def rolled(turns: float, length: float) -> tuple[float, float]:
    """The same under an end moment that bends the beam to ``turns`` of a circle."""
    angle = 2 * np.pi * turns
    return length * (1 - np.sin(angle) / angle), length * (1 - np.cos(angle)) / angle


def extensible(slenderness: float, alpha: float, moment: float = 0.0) -> tuple[float, float]:
    r"""The tip of a strip of thin-plate theory, length 1, which also stretches, under an end force and an end moment.

    With stretch :math:`\lambda` and angle :math:`\theta` the energy per length over E I is
    :math:`\tfrac12 (\lambda^2 - 1)^2 / (4 e) + \tfrac12 (\lambda \theta')^2, \; e = (h / L)^2 / 12`, whose equilibrium is

    .. math:: m' = -\alpha \lambda \cos\theta, \quad m = \lambda^2 \theta', \quad
        \lambda (\lambda^2 - 1) / 2 + e\, m^2 / \lambda^3 = e\, \alpha \sin\theta.

    Parameters
    ----------
    slenderness : float
        L / h.
    alpha, moment : float
        P L^2 / (E I) and M L / (E I).
    """
    e = 1 / (12 * slenderness**2)

    def stretch(theta: np.ndarray, m: np.ndarray) -> np.ndarray:
        s = np.ones_like(theta)
        for _ in range(8):
            excess = s * (s * s - 1) / 2 + e * m**2 / s**3 - e * alpha * np.sin(theta)
            s = s - excess / ((3 * s * s - 1) / 2 - 3 * e * m**2 / s**4)
        return s

    def slopes(_: np.ndarray, y: np.ndarray) -> np.ndarray:
        s = stretch(y[0], y[1])
        return np.array([y[1] / s**2, -alpha * s * np.cos(y[0]), s * np.cos(y[0]), s * np.sin(y[0])])

    at = np.linspace(0, 1, 81)
    guess = np.array([moment * at + tip_angle(alpha) * at * (2 - at) if alpha else moment * at, moment + 0 * at, at, 0 * at])
    found = solve_bvp(slopes, lambda a, b: np.array([a[0], b[1] - moment, a[2], a[3]]), at, guess, tol=1e-9, max_nodes=20000)
    if not found.success:
        raise ArithmeticError(found.message)
    return 1 - found.y[2, -1], found.y[3, -1]
