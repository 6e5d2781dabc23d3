r"""Thin circular cylinders on diaphragms, small displacements, by Fourier series along the axis.

With the angle :math:`\theta` and the displacements u (axial), v (along the circle) and w (outwards), the linear membrane
strains and curvature changes of the mid-surface of Kirchhoff's theory are

.. math::
    \varepsilon = (u_{,x},\; v_{,s} + w / R,\; u_{,s} + v_{,x}), \qquad
    \kappa = -(w_{,xx},\; w_{,ss} - 2 v_{,s} / R - w / R^2,\; 2 (w_{,xs} - v_{,x} / R)), \qquad s = R \theta,

(Koiter 1960, A consistent first approximation in the general theory of thin elastic shells). Terms
:math:`u = U(\theta) \cos \mu x,\; (v, w) = (V, W)(\theta) \sin \mu x,\; \mu = m \pi / L` fulfil the conditions of
diaphragms and do not couple.
"""

from dataclasses import dataclass
from math import pi, sin

import numpy as np
from numpy.polynomial import Legendre, Polynomial


@dataclass(frozen=True)
class Cylinder:
    """Between diaphragms at x = 0 and x = length."""

    radius: float
    length: float
    thickness: float
    young: float
    poisson: float

    def law(self) -> np.ndarray:
        """Of membrane strains and curvature changes, (6, 6)."""
        Q = np.array([[1, self.poisson, 0], [self.poisson, 1, 0], [0, 0, (1 - self.poisson) / 2]])
        Q = Q * self.young / (1 - self.poisson**2)
        return np.kron(np.diag([self.thickness, self.thickness**3 / 12]), Q)


def strains(cylinder: Cylinder, mu: np.ndarray, u: list, v: list, w: list) -> np.ndarray:
    """Amplitudes of the six strains for functions (value, first, second derivative by the angle) of u, v and w: (6, ...)."""
    R = cylinder.radius
    return np.stack([
        -mu * u[0], (v[1] + w[0]) / R, u[1] / R + mu * v[0],
        mu**2 * w[0], (-w[2] + 2 * v[1] + w[0]) / R**2, -2 * mu * (w[1] - v[0]) / R,
    ])  # fmt: skip


def pinched(cylinder: Cylinder, terms: int) -> float:
    """Displacement under one of two opposite inward unit forces at mid-length: m and n below 2 ``terms``.

    What is left out falls like 1 / terms^2, as for a plate.
    """
    m, n = 2 * np.arange(terms) + 1, 2 * np.arange(terms)
    mu, n = np.meshgrid(m * pi / cylinder.length, n, indexing="ij")
    one, zero = np.ones(mu.shape), np.zeros(mu.shape)
    nothing = [zero, zero, zero]
    cosine, sine = [one, -n, -(n**2)], [one, n, -(n**2)]  # the derivative of each is a multiple of the other
    B = np.stack([strains(cylinder, mu, cosine, nothing, nothing), strains(cylinder, mu, nothing, sine, nothing),
                  strains(cylinder, mu, nothing, nothing, cosine)])  # fmt: skip
    # Integral of cos^2 or sin^2 over the angle and over the length.
    area = np.where(n == 0, 2 * pi, pi) * cylinder.radius * cylinder.length / 2
    K = np.einsum("kimn,ij,ljmn,mn->mnkl", B, cylinder.law(), B, area, optimize=True)
    # v and the strains of n = 0 vanish with sin(0): any stiffness will do.
    K[n == 0, 1, 1] = K[n == 0, 0, 0]
    K[n == 0, 1, 0] = K[n == 0, 0, 1] = K[n == 0, 1, 2] = K[n == 0, 2, 1] = 0.0
    compliance = np.linalg.inv(K)[..., 2, 2]
    return float(2 * compliance.sum())


def roof(cylinder: Cylinder, half_angle: float, weight: float, terms: int = 12, degree: int = 16) -> float:
    """Downward displacement of the free straight edges at mid-length under dead weight per area, crown on top.

    Over the angle from the crown u, v and w are Legendre polynomials (Ritz's method).
    """
    g, gauss = np.polynomial.legendre.leggauss(degree + 8)
    angle, stretch = half_angle * g, 1 / half_angle
    functions = [Legendre.basis(k).convert(kind=Polynomial) for k in range(degree)]
    tables = [[f(g), stretch * f.deriv()(g), stretch**2 * f.deriv(2)(g) + 0 * g] for f in functions]
    even, odd, nothing = tables[::2], tables[1::2], [0 * g] * 3
    shapes = [(f, nothing, nothing) for f in even]
    shapes += [(nothing, f, nothing) for f in odd] + [(nothing, nothing, f) for f in even]
    area, total = half_angle * gauss * cylinder.radius * cylinder.length / 2, 0.0
    for m in range(1, 2 * terms, 2):
        B = np.stack([strains(cylinder, m * pi / cylinder.length, *shape) for shape in shapes])
        K = np.einsum("kip,ij,ljp,p->kl", B, cylinder.law(), B, area, optimize=True)
        down = np.stack([np.sin(angle) * v[0] - np.cos(angle) * w[0] for _, v, w in shapes])
        load = 4 / (m * pi) * weight * down @ area
        scale = 1 / np.sqrt(K.diagonal())
        c = scale * np.linalg.solve(scale[:, None] * K * scale, scale * load)
        end = np.array([sin(half_angle) * v - np.cos(half_angle) * w for v, w in _at_the_end(functions)])
        total += sin(m * pi / 2) * float(c @ end)
    return total


def _at_the_end(functions: list) -> list[tuple[float, float]]:
    even, odd = functions[::2], functions[1::2]
    return [(0.0, 0.0)] * len(even) + [(f(1.0), 0.0) for f in odd] + [(0.0, f(1.0)) for f in even]
