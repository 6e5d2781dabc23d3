r"""Inextensible elastica: a cantilever of length 1 with a dead force at its end, normal to the undeformed axis.

By Legendre's elliptic integrals with :math:`m = (1 + \sin\varphi) / 2` and :math:`\sin^2 \theta = 1 / (2 m)`,

.. math::
    \sqrt{\alpha} = K(m) - F(\theta | m), \qquad w = 1 - \frac{2}{\sqrt\alpha}(E(m) - E(\theta | m)), \qquad
    1 - u = \sqrt{2 \sin\varphi / \alpha},

with :math:`\alpha = P L^2 / E I` and the tip angle :math:`\varphi` (Bisshopp and Drucker 1945, Quart. Appl.
Math. 3, 272-275).
"""

import numpy as np
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
