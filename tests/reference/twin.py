r"""A slow twin of the fully parameterised plate: one element, one point at a time, three-dimensional strain.

Written from the papers, with shape functions in the form of Mikkola and Shabana (2003) on [-1, 1] x [-1, 1], and strain
energy only. The energy is a polynomial in the nodal coordinates, so that its derivative by a complex step is exact to
rounding. Assumed strains: Bathe and Dvorkin (1986) for the idea; here shear 13 is sampled at xi = -1, 0, 1 on the two
edges eta = -1, 1, shear 23 with the two exchanged, and the thickness strain at the corners.
"""

from collections.abc import Callable

import numpy as np

SIGNS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
STEP = 1e-30
VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def shapes(xi: complex, eta: complex) -> np.ndarray:
    """(4 corners, 4): functions of r, r_xi, r_eta and d; derivatives with respect to xi, eta in [-1, 1]."""
    a, b = SIGNS.T
    X, Y = 1 + a * xi, 1 + b * eta
    r = X * Y * (2 + a * xi + b * eta - xi**2 - eta**2) / 8
    return np.stack([r, a * X * Y * (xi**2 - 1) / 8, b * X * Y * (eta**2 - 1) / 8, X * Y / 4], axis=1)


class Element:
    """One element: corners (4, 2) in the parameter plane."""

    def __init__(self, corners: np.ndarray, undeformed: np.ndarray, assumed: bool):
        self.corners, self.undeformed, self.assumed = corners, undeformed, assumed
        self.jacobians = [self.slopes(*sign) for sign in SIGNS]

    def at(self, xi: float, eta: float) -> np.ndarray:
        """Parameters (x, y)."""
        return (1 + SIGNS[:, 0] * xi) * (1 + SIGNS[:, 1] * eta) / 4 @ self.corners

    def slopes(self, xi: float, eta: float) -> np.ndarray:
        """(2, 2): rows x_xi, y_xi and x_eta, y_eta."""
        a, b = SIGNS.T
        return np.stack([a * (1 + b * eta), b * (1 + a * xi)]) / 4 @ self.corners

    def basis(self, q: np.ndarray, xi: float, eta: float, z: float) -> np.ndarray:
        """g_1, g_2, g_3 as columns, derivatives of r + z d with respect to xi, eta, z, of nodal (..., 4, 4, 3)."""
        local = q.astype(complex)
        for corner, J in enumerate(self.jacobians):
            local[..., corner, 1:3, :] = J @ q[..., corner, 1:3, :]
        along_xi, along_eta = shapes(xi + 1j * STEP, eta).imag / STEP, shapes(xi, eta + 1j * STEP).imag / STEP
        depth = np.array([1, 1, 1, z])
        g = [np.einsum("ck,...cki->...i", table * depth, local) for table in (along_xi, along_eta)]
        g.append(np.einsum("c,...ci->...i", shapes(xi, eta)[:, 3].real, local[..., 3, :]))
        return np.stack(g, axis=-1)

    def covariant(self, q: np.ndarray, xi: float, eta: float, z: float) -> np.ndarray:
        """Green-Lagrange strain (..., 3, 3) with respect to xi, eta, z."""
        now, before = self.basis(q, xi, eta, z), self.basis(self.undeformed, xi, eta, z)
        return (now.swapaxes(-1, -2) @ now - before.T @ before) / 2

    def strain(self, q: np.ndarray, xi: float, eta: float, z: float) -> np.ndarray:
        """The same with shear and thickness parts interpolated between samples."""
        E = self.covariant(q, xi, eta, z)
        if self.assumed:
            E[..., 0, 2] = E[..., 2, 0] = sum(
                quadratic(xi, s) * linear(eta, t) * self.covariant(q, s, t, z)[..., 0, 2]
                for s in (-1, 0, 1) for t in (-1, 1)
            )  # fmt: skip
            E[..., 1, 2] = E[..., 2, 1] = sum(
                linear(xi, s) * quadratic(eta, t) * self.covariant(q, s, t, z)[..., 1, 2]
                for s in (-1, 1) for t in (-1, 0, 1)
            )  # fmt: skip
            E[..., 2, 2] = sum(linear(xi, s) * linear(eta, t) * self.covariant(q, s, t, z)[..., 2, 2] for s, t in SIGNS)
        return E

    def energy(self, q: np.ndarray, law: np.ndarray, thickness: float, frame: Callable, n_z: int = 3) -> np.ndarray:
        """Of nodal coordinates (..., 4, 4, 3), as many states as you like; ``frame(x, y)`` are rows e1, e2, e3."""
        s, w = np.polynomial.legendre.leggauss(4)
        depth, depth_weight = np.polynomial.legendre.leggauss(n_z)
        total = 0.0
        for i, j, k in np.ndindex(4, 4, n_z):
            point = s[i], s[j], depth[k] * thickness / 2
            F = frame(*self.at(s[i], s[j])) @ self.basis(self.undeformed, *point).real
            A = np.linalg.inv(F)
            E = A.T @ self.strain(q, *point) @ A
            voigt = np.stack([E[..., a, b] * (1 if a == b else 2) for a, b in VOIGT])
            volume = abs(np.linalg.det(F)) * w[i] * w[j] * depth_weight[k] * thickness / 2
            total = total + np.einsum("a...,ab,b...->...", voigt, law, voigt) / 2 * volume
        return total

    def force(self, q: np.ndarray, law: np.ndarray, thickness: float, frame: Callable) -> np.ndarray:
        """Derivative of the energy, (4, 4, 3)."""
        steps = q + 1j * STEP * np.eye(48).reshape(48, 4, 4, 3)
        return self.energy(steps, law, thickness, frame).imag.reshape(4, 4, 3) / STEP


def linear(s: float, at: int) -> float:
    return (1 + at * s) / 2


def quadratic(s: float, at: int) -> float:
    return 1 - s * s if at == 0 else s * (s + at) / 2


def flat(x: float, y: float) -> np.ndarray:
    """The frame of a flat plate with x and y as parameters."""
    return np.eye(3)


def polar(radius: float, angle: float) -> np.ndarray:
    """The frame of a sector of an annulus."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
