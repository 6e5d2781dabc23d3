r"""Exact elasticity of layered tubes: Lame's problem and the pure bending of a curved bar, layer by layer.

A layer is orthotropic along its axis, hoop and radius, strained by :math:`\varepsilon_z` along the axis and bent by a part a
of its angle: :math:`\varepsilon_\theta = u / r + a`. With :math:`\lambda^2 = C_{\theta\theta} / C_{rr}` the movement is
:math:`u = c_1 r^\lambda + c_2 r^{-\lambda} + p(r)`, where for :math:`f = (C_{\theta z} - C_{rz}) \varepsilon_z +
(C_{\theta\theta} - C_{r\theta}) a` the last is :math:`f r / (C_{rr} - C_{\theta\theta})`, or of isotropy
:math:`f r \ln r / (2 C_{rr})` (S. G. Lekhnitskii, Anisotropic Plates, 1968).
"""

from dataclasses import dataclass

import numpy as np

AXIAL, HOOP, RADIAL = 0, 1, 2
TERMS = 4  # c1, c2, ez, a


@dataclass
class Tube:
    """Layers between radii (n + 1,), laws (6, 6) of directions axis, hoop, radius; ``coefficients`` (n, 2), ez and a."""

    radii: np.ndarray
    laws: list
    coefficients: np.ndarray
    ez: float
    turn: float

    def _terms(self, k, r):
        """u and u' per c1, c2, ez and a at r in layer k: (2, 4)."""
        C = self.laws[k]
        power, gap = np.sqrt(C[HOOP, HOOP] / C[RADIAL, RADIAL]), C[RADIAL, RADIAL] - C[HOOP, HOOP]
        pushes = np.array([C[HOOP, AXIAL] - C[RADIAL, AXIAL], C[HOOP, HOOP] - C[RADIAL, HOOP]])
        if abs(gap) > 1e-10 * C[HOOP, HOOP]:
            own = np.stack([pushes / gap * r, pushes / gap])
        else:
            own = np.stack([pushes * r * np.log(r), pushes * (1 + np.log(r))]) / (2 * C[RADIAL, RADIAL])
        return np.hstack([[[r**power, r**-power], [power * r ** (power - 1), -power * r ** (-power - 1)]], own])

    def _stress(self, k, r):
        """Radial, hoop and axial stress per c1, c2, ez and a: (3, 4)."""
        C, (u, slope) = self.laws[k], self._terms(k, r)
        strain = np.stack([[0.0, 0.0, 1.0, 0.0], u / r + [0.0, 0.0, 0.0, 1.0], slope])
        return C[np.ix_([RADIAL, HOOP, AXIAL], [AXIAL, HOOP, RADIAL])] @ strain

    def _own(self, k):
        return np.append(self.coefficients[k], [self.ez, self.turn])

    def displacement(self, k, r):
        return float(self._terms(k, r)[0] @ self._own(k))

    def stress(self, k, r):
        """Radial, hoop and axial."""
        return self._stress(k, r) @ self._own(k)

    def thinned(self, r, reference):
        """Movement at r against that of a reference surface, per unit of hoop strain, by Poisson's ratio."""

        def up_to(r):
            return sum(-C[HOOP, RADIAL] / C[RADIAL, RADIAL] * (np.clip(r, low, high) - low)
                       for C, low, high in zip(self.laws, self.radii, self.radii[1:], strict=False))  # fmt: skip

        return up_to(r) - up_to(reference)

    def integral(self, which, power=0):
        """Of a stress (0 radial, 1 hoop, 2 axial) times r^power over the wall."""
        s, w = np.polynomial.legendre.leggauss(12)
        out = 0.0
        for k, (low, high) in enumerate(zip(self.radii, self.radii[1:], strict=False)):
            r = (low + high) / 2 + (high - low) / 2 * s
            out += (high - low) / 2 * sum(wi * self.stress(k, ri)[which] * ri**power for ri, wi in zip(r, w, strict=True))
        return out

    def at_surface(self, reference):
        """Movement of a reference surface, or of the face next to it: what is between them is rigid."""
        r = np.clip(reference, self.radii[0], self.radii[-1])
        return self.displacement(int(np.searchsorted(self.radii[1:-1], r)), r)


def tube(radii, laws, inside=0.0, outside=0.0, ez=0.0, turn=0.0):
    """Under a pressure inside and one outside (Pa), with a given axial strain and bent by a part of its angle."""
    radii, n = np.asarray(radii, float), len(laws)
    made = Tube(radii, laws, np.zeros((n, 2)), ez, turn)
    A, b = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)

    def put(row, k, terms, sign):
        A[row, 2 * k : 2 * k + 2] += sign * terms[:2]
        b[row] -= sign * (terms[2:] @ [ez, turn])

    put(0, 0, made._stress(0, radii[0])[0], 1)
    b[0] -= inside
    put(1, n - 1, made._stress(n - 1, radii[-1])[0], 1)
    b[1] -= outside
    for k in range(n - 1):
        for row, terms in ((2 + 2 * k, made._terms), (3 + 2 * k, made._stress)):
            put(row, k, terms(k, radii[k + 1])[0], 1)
            put(row, k + 1, terms(k + 1, radii[k + 1])[0], -1)
    made.coefficients = np.linalg.solve(A, b).reshape(n, 2)
    return made


def pressed(radii, laws, reference, ez=0.0):
    """As much as a pressure 1 on a surface of a radius, on both faces so that the change of thickness does as much work as
    there, none: on one face if that is the surface."""
    one = tube(radii, laws)
    levers = [one.thinned(r, reference) * r for r in (radii[0], radii[-1])]
    faces = [[levers[0], -levers[1]], [radii[0], -radii[-1]]]
    inside, outside = np.linalg.lstsq(faces, [0.0, reference])[0]  # without Poisson's ratio any two faces do
    return tube(radii, laws, inside, outside, ez)
