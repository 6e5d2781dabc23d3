r"""A slow twin of the thin plate or shell: one element at a time, dense matrices, nothing shared between elements.

With the strains :math:`E` at the 4 x 4 Gauss points (membrane strains and curvature changes, point after point within each
component) and the matrix :math:`P` that takes membrane strains to their assumed part, the generalised strains are

.. math:: g = A E = (P \varepsilon, \; \kappa, \; s (\varepsilon - P \varepsilon)), \qquad
    \text{energy} = \tfrac12 g \cdot D g,

with roots s of the factors of the rest. Then the stresses are :math:`A^T D A E`, the force :math:`B^T` of them, the tangent
:math:`B^T A^T D A B` and the stresses on the second derivative of the strains.
"""

import numpy as np
from numpy.polynomial import Polynomial

from skancf.materials.curved import CurvedSection
from skancf.theories.kirchhoff import point

CORNERS = [(0, 0), (1, 0), (1, 1), (0, 1)]
# Cubic Hermite functions on [0, 1]: value and slope at 0, value and slope at 1.
CUBIC = [[Polynomial([1, 0, -3, 2]), Polynomial([0, 1, -2, 1])], [Polynomial([0, 0, 3, -2]), Polynomial([0, 0, -1, 1])]]
DERIVATIVES = [(1, 0), (0, 1), (2, 0), (0, 2), (1, 1)]
SYMMETRIC = [(0, 0), (1, 1), (0, 1)]
DEGREES = [(1, 2), (2, 1), (1, 1)]
"""Degrees in xi and eta of the assumed strains 11, 22, 12."""


def gauss_points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """xi, eta and weights of the 4 x 4 points of the unit square."""
    s, w = np.polynomial.legendre.leggauss(4)
    xi, eta = np.meshgrid((s + 1) / 2, (s + 1) / 2, indexing="ij")
    return xi.ravel(), eta.ravel(), np.outer(w, w).ravel() / 4


def jet_functions() -> np.ndarray:
    """Derivatives of the functions of r, r_xi, r_eta, r_xieta of each corner at the Gauss points: (5, 4, 4, 16)."""
    xi, eta, _ = gauss_points()
    out = np.empty((5, 4, 4, 16))
    for k, (m, n) in enumerate(DERIVATIVES):
        for corner, (i, j) in enumerate(CORNERS):
            for kind, (a, b) in enumerate([(0, 0), (1, 0), (0, 1), (1, 1)]):
                out[k, corner, kind] = CUBIC[i][a].deriv(m)(xi) * CUBIC[j][b].deriv(n)(eta)
    return out


def projections() -> np.ndarray:
    """P by weighted least squares with powers of xi and eta, (3, 16, 16)."""
    xi, eta, w = gauss_points()
    out = []
    for high, wide in DEGREES:
        V = np.stack([xi**m * eta**n for m in range(high + 1) for n in range(wide + 1)], axis=1)
        out.append(V @ np.linalg.solve(V.T * w @ V, V.T * w))
    return np.array(out)


class Element:
    """One element of corners (4, 2) in the parameter plane with undeformed nodal vectors (4, 4, 3)."""

    def __init__(self, corners, undeformed, surface, section, assumed=True, thickness=None):
        sides = corners[1] - corners[0], corners[3] - corners[0]
        (x_xi, y_xi), (x_eta, y_eta) = sides
        nodal = np.zeros((4, 4))
        nodal[0, 0] = 1
        nodal[1:3, 1:3] = sides
        nodal[3, 3] = x_xi * y_eta + x_eta * y_xi
        functions = np.einsum("kclp,ln->kcnp", jet_functions(), nodal).reshape(5, 16, 16)
        self.table = np.einsum("knp,ij->kpinj", functions, np.eye(3)).reshape(5, 16, 3, 48)
        self.side = np.sign(x_xi * y_eta - x_eta * y_xi)
        xi, eta, self.weights = gauss_points()
        at = corners[0][:, None] + sides[0][:, None] * xi + sides[1][:, None] * eta
        self.reference = self.jet(undeformed)
        self.before = point.strain(self.reference)
        abd = section.abd()
        if thickness is None:
            # Free of membrane forces, bending yields to the last block of the inverse.
            thickness = np.sqrt(12 * np.trace(np.linalg.inv(np.linalg.inv(abd)[3:, 3:])) / np.trace(abd[:3, :3]))
        self.D = self._law(surface.derivatives(*at)[0], CurvedSection(section))
        self.A = self._generalised(thickness, assumed)

    def jet(self, q: np.ndarray) -> np.ndarray:
        """(5, 3, 16) of nodal vectors (4, 4, 3)."""
        return np.moveaxis(self.table @ q.ravel(), 1, 2)

    def _law(self, along_x: np.ndarray, section: CurvedSection) -> np.ndarray:
        """D of the generalised strains, (144, 144)."""
        out, duals, n = np.zeros((9, 16, 9, 16)), point.dual(self.reference), point.unit_normal(self.reference) * self.side
        for p in range(16):
            e1 = along_x[:, p] - n[:, p] * (n[:, p] @ along_x[:, p])  # the interpolated surface has other normals
            e1 = e1 / np.linalg.norm(e1)
            c = np.stack([e1, np.cross(n[:, p], e1)]) @ duals[:, :, p].T  # e_i . A^a
            turn = np.zeros((3, 3))
            for row, (i, j) in enumerate(SYMMETRIC):
                for column, (a, b) in enumerate(SYMMETRIC):
                    E = np.zeros((2, 2))
                    E[a, b] = E[b, a] = 1.0 if a == b else 0.5
                    turn[row, column] = (c @ E @ c.T)[i, j] * (1.0 if i == j else 2.0)
            both = np.kron(np.diag([1.0, self.side]), turn)
            r1, r2, r11, r22, r12 = self.reference[:, :, p]
            h = np.array([[r11 @ n[:, p], r12 @ n[:, p]], [r12 @ n[:, p], r22 @ n[:, p]]])
            b = c @ h @ c.T
            abd = section.law(np.array([b[0, 0], b[1, 1], b[0, 1]]))
            law = both.T @ abd @ both * np.linalg.norm(np.cross(r1, r2)) * self.weights[p]
            out[:6, p, :6, p] = law
            out[6:, p, 6:, p] = law[:3, :3]
        return out.reshape(144, 144)

    def _curvature(self, p: int) -> float:
        """The larger principal curvature of the undeformed element at a point: an eigenvalue of metric^-1 curvature."""
        r1, r2, r11, r22, r12 = self.reference[..., p]
        n = np.cross(r1, r2)
        n = n / np.linalg.norm(n)
        b = np.array([[r11 @ n, r12 @ n], [r12 @ n, r22 @ n]])
        return float(np.abs(np.linalg.eigvals(np.linalg.solve([[r1 @ r1, r1 @ r2], [r1 @ r2, r2 @ r2]], b))).max())

    def _generalised(self, thickness: float, assumed: bool) -> np.ndarray:
        """A, (144, 96)."""
        lengths = np.linalg.norm(self.reference[:2], axis=1).mean(axis=1)
        x = np.mean([self._curvature(p) for p in range(16)]) * lengths**2 / thickness
        one, two = np.minimum(1, np.maximum(thickness / lengths, 0.8 * (x - 0.9) / x**2 if (x > 0).all() else 0))
        roots = one, two, np.sqrt(one * two)
        P = projections() if assumed else np.stack([np.eye(16)] * 3)
        A = np.zeros((9, 16, 6, 16))
        for c in range(3):
            A[c, :, c], A[3 + c, :, 3 + c] = P[c], np.eye(16)
            A[6 + c, :, c] = roots[c] * (np.eye(16) - P[c])
        return A.reshape(144, 96)

    def strains(self, q: np.ndarray) -> np.ndarray:
        """E, (96,)."""
        return (point.strain(self.jet(q)) - self.before).ravel()

    def gradients(self, q: np.ndarray) -> np.ndarray:
        """B, (96, 48)."""
        return np.einsum("skip,kpin->spn", point.gradient(self.jet(q)), self.table).reshape(96, 48)

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        """(6, 16), extrapolated along a change of the nodal vectors."""
        E = self.strains(q) + (0 if change is None else self.gradients(q) @ change.ravel())
        return (self.A.T @ self.D @ self.A @ E).reshape(6, 16)

    def energy(self, q: np.ndarray) -> float:
        g = self.A @ self.strains(q)
        return float(g @ self.D @ g / 2)

    def force(self, q: np.ndarray) -> np.ndarray:
        """(4, 4, 3)."""
        return (self.gradients(q).T @ self.stresses(q).ravel()).reshape(4, 4, 3)

    def tangent(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """(48, 48) with given stresses."""
        G = self.A @ self.gradients(q)
        second = point.second_derivative(self.jet(q), stresses)
        return G.T @ self.D @ G + np.einsum("kpim,kiljp,lpjn->mn", self.table, second, self.table, optimize=True)
