r"""Simply supported polygonal plates as two membranes, by polynomials of high degree on meshes graded to all corners.

With D = q = 1 and hard supports :math:`-\Delta m = 1,\; -\Delta w = m`, both zero at the edges (Marcus 1924). Where a corner
is re-entrant that w has no finite energy; the plate's moment is m plus a multiple of the function :math:`m_s \sim
r^{-\pi/\omega}` that is harmonic and zero at the edges,

.. math:: m + c\, m_s, \qquad c = -\frac{\int m\, m_s}{\int m_s^2}

(Nazarov and Sweers 2007, J. Differential Equations 233, 151-180). The energy is :math:`\tfrac12 \int w`, the first
frequency of a convex plate is that of the membrane.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import skfem
from scipy.integrate import quad
from scipy.sparse.linalg import eigsh, splu
from skfem.models.poisson import laplace, mass

RATIO = 0.5
TURN = 2 / 3
"""pi over the angle of the re-entrant corner, three right angles."""


def graded(line: list[float], layers: int) -> np.ndarray:
    """Positions that become denser towards both ends of each interval."""
    half = 0.5 * RATIO ** np.arange(layers)
    unit = np.concatenate([[0.0], half[::-1], 1 - half[1:]])
    return np.concatenate([*[a + (b - a) * unit for a, b in pairwise(line)], [line[-1]]])


def mesh_of(x: list[float], y: list[float], corner: bool, position: Callable[..., Any], layers: int) -> skfem.MeshQuad:
    """Over the rectangles between the lines, without x > 0 > y where there is a corner there, mapped by ``position``."""
    mesh = skfem.MeshQuad.init_tensor(graded(x, layers), graded(y, layers))
    middle = mesh.p[:, mesh.t].mean(axis=1)
    if corner:
        mesh = mesh.restrict(np.flatnonzero((middle[0] < 0) | (middle[1] > 0)))
    return skfem.MeshQuad(np.ascontiguousarray(position(*mesh.p)[:2]), mesh.t)


class Plate:
    """w, energy and first eigenvalue of the membrane."""

    def __init__(self, x: list[float], y: list[float], corner: bool, position: Callable[..., Any], layers: int, degree: int):
        self.outer = (x[-1], -x[0], y[-1], -y[0])
        mesh = mesh_of(x, y, corner, position, layers)
        self.order = 2 * degree + 1
        self.basis = basis = skfem.Basis(mesh, skfem.ElementQuadP(degree), intorder=self.order)
        self.free = basis.complement_dofs(basis.get_dofs())
        self.stiffness, self.mass = laplace.assemble(basis).tocsc(), mass.assemble(basis).tocsc()
        self.solver = splu(self.stiffness[self.free][:, self.free])
        self.load = skfem.LinearForm(lambda v, _: v).assemble(basis)
        m = self.answer(self.load)
        w = self.answer(self.mass @ m)
        if corner:
            w = w + self.corrected(m)
        self.w, self.energy = w, 0.5 * float(self.load @ w)

    def answer(self, force: np.ndarray) -> np.ndarray:
        out = np.zeros(len(force))
        out[self.free] = self.solver.solve(force[self.free])
        return out

    def corrected(self, m: np.ndarray) -> np.ndarray:
        """The deflection c w_s of the singular moment, which is its leading term times a bump b, and a rest v."""
        b, s = self.bump, singular
        form = skfem.LinearForm

        def growth(v: Any, at: Any) -> Any:  # the Laplacian of b s
            (_, bx, by, bb), (sx, sy) = b(*at.x), slopes(*at.x)
            return (2 * (bx * sx + by * sy) + bb * s(*at.x)) * v

        rest = self.answer(form(growth).assemble(self.basis))
        leading = form(lambda v, at: b(*at.x)[0] * s(*at.x) * v).assemble(self.basis)
        excess = skfem.Functional(lambda at: (b(*at.x)[0] ** 2 - 1) * s(*at.x) ** 2).assemble(self.basis)
        force = leading + self.mass @ rest
        square = self.singular_square() + float(excess) + 2 * float(leading @ rest) + float(rest @ (self.mass @ rest))
        return -float(m @ force) / square * self.answer(force)

    def bump(self, x: np.ndarray, y: np.ndarray) -> tuple[Any, Any, Any, Any]:
        """One in the corner and zero at the other edges; its slopes and Laplacian."""
        right, left, top, bottom = self.outer
        f, df, ddf = (1 - x / right) * (1 + x / left), 1 / left - 1 / right - 2 * x / (left * right), -2 / (left * right)
        g, dg, ddg = (1 - y / top) * (1 + y / bottom), 1 / bottom - 1 / top - 2 * y / (top * bottom), -2 / (top * bottom)
        return f * g, df * g, f * dg, ddf * g + f * ddg

    def singular_square(self) -> float:
        """The integral of the singular function squared, by that over the radius in closed form."""
        right, left, top, bottom = self.outer

        def part(angle: float) -> float:
            c, s = np.cos(angle), np.sin(angle)
            far = min((right if c > 0 else left) / max(abs(c), 1e-300), (top if s > 0 else bottom) / max(abs(s), 1e-300))
            return float(np.sin(TURN * angle) ** 2 * far ** (2 - 2 * TURN) / (2 - 2 * TURN))

        turns = sorted(np.arctan2(y, x) % (2 * np.pi) for x, y in ((right, top), (-left, top), (-left, -bottom)))
        ends = [0.0, *turns, 1.5 * np.pi]
        return sum(quad(part, a, b, epsabs=1e-13, epsrel=1e-13)[0] for a, b in pairwise(ends))

    def deflection(self, at: np.ndarray) -> float:
        """w at a point (2,)."""
        return float((self.basis.probes(at[:, None] * (1 + 1e-13)) @ self.w)[0])

    def eigenvalue(self) -> float:
        """The first of the membrane."""
        K, M = (matrix[self.free][:, self.free] for matrix in (self.stiffness, self.mass))
        return float(eigsh(K, 1, M, sigma=0.0, return_eigenvectors=False)[0])


def singular(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    r""":math:`r^{-2/3} \sin(2 \theta / 3)` from the axis x on."""
    angle = np.arctan2(y, x)
    return np.hypot(x, y) ** -TURN * np.sin(TURN * np.where(angle < -1e-12, angle + 2 * np.pi, angle))


def slopes(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the singular function."""
    angle = np.arctan2(y, x)
    angle = np.where(angle < -1e-12, angle + 2 * np.pi, angle)
    size = -TURN * np.hypot(x, y) ** (-TURN - 1)
    return size * np.sin((TURN + 1) * angle), -size * np.cos((TURN + 1) * angle)
