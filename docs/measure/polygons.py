r"""Thin polygons on hard simple supports, to nine digits: twice Poisson's equation, on meshes graded to the corners.

With :math:`\Delta M = -q` and :math:`\Delta w = -M / D`, both zero on the boundary, the energy is
:math:`\int M^2 / 2 D`; and a convex plate has the frequency :math:`\mu \sqrt{D / \rho t} / 2 \pi` and buckles under a
pressure :math:`\mu D` from all sides, with the first eigenvalue :math:`\mu` of the membrane. In a re-entrant corner of
the angle :math:`\omega` the moment has a part
:math:`K \sim r^{-\pi / \omega}` of its own, of which so much is there that the deflection has a finite energy:
:math:`\int M K = 0`.
"""

from itertools import pairwise

import numpy as np
import skfem
from numpy.polynomial import Polynomial
from scipy.sparse.linalg import eigsh
from skfem import BilinearForm, LinearForm
from skfem.helpers import dot, grad

GRADE, DEGREE = 0.15, 6


def lines(points: list[float], layers: int) -> np.ndarray:
    """Coordinates graded from both sides towards some of them, in steps that shrink by :data:`GRADE`."""
    steps = 0.5 * GRADE ** np.arange(layers)
    out = list(points)
    for a, b in pairwise(points):
        out += [*(a + steps * (b - a)), *(b - steps[1:] * (b - a))]
    return np.unique(out)


@BilinearForm
def stiffness(u, v, _):
    return dot(grad(u), grad(v))


@BilinearForm
def mass(u, v, _):
    return u * v


class Polygon:
    """An image of a rectangle, by a function of coordinates (2, n), perhaps without a part of it.

    Parameters
    ----------
    corners : pair of lists
        Lines to which the mesh is graded.
    place : function of (2, n)
        From the rectangle to the plane.
    without : ((x0, x1), (y0, y1)), optional
        A part of the rectangle that is left out.
    """

    def __init__(self, corners, place=lambda p: p, without=None, layers: int = 6):
        mesh = skfem.MeshQuad.init_tensor(*(lines(list(c), layers) for c in corners))
        if without is not None:
            mid = mesh.p[:, mesh.t].mean(axis=1)
            (x0, x1), (y0, y1) = without
            mesh = mesh.remove_elements(np.flatnonzero((mid[0] > x0) & (mid[0] < x1) & (mid[1] > y0) & (mid[1] < y1)))
        mesh = skfem.MeshQuad(place(mesh.p), mesh.t)
        self.basis = skfem.Basis(mesh, skfem.ElementQuadP(DEGREE), intorder=2 * DEGREE)
        self.edge = self.basis.get_dofs()
        self.stiffness, self.mass = stiffness.assemble(self.basis), mass.assemble(self.basis)

    def poisson(self, load):
        return skfem.solve(*skfem.condense(self.stiffness, load, D=self.edge))

    def eigenvalue(self) -> float:
        """The smallest one of the membrane (1/m^2)."""
        inside = self.basis.complement_dofs(self.edge)
        K, M = (A[inside][:, inside].tocsc() for A in (self.stiffness, self.mass))
        return float(eigsh(K, 1, M, sigma=0.0, return_eigenvectors=False)[0])

    def bent(self, at, reentrant=None):
        """Deflection at a point and energy with q = D = 1; ``reentrant`` is the corner, the direction (rad) of the first of
        its edges, its angle and the length of the shorter one."""
        b = self.basis
        moment = b.interpolate(self.poisson(LinearForm(lambda v, w: v).assemble(b)))
        values = np.asarray(moment)
        if reentrant is not None:
            own = self._singular(*reentrant)
            values = values - own * float((values * own * b.dx).sum() / (own**2 * b.dx).sum())
        w = self.poisson(LinearForm(lambda v, w: values * v).assemble(b))
        return float((b.probes(np.reshape(at, (2, 1)) + 1e-12) @ w)[0]), float((values**2 * b.dx).sum() / 2)

    def _singular(self, corner, first, angle, reach):
        """The function r^(-pi / angle) sin(pi theta / angle) near the corner, plus one of finite energy: harmonic, and zero
        on the boundary."""
        b, power = self.basis, np.pi / angle
        x, y = (c - o for c, o in zip(np.asarray(b.global_coordinates()), corner, strict=True))
        r, theta = np.hypot(x, y), np.mod(np.arctan2(y, x) - first, 2 * np.pi)
        s = np.clip(r / reach, 0.0, 1.0)
        # A cut-off of four derivatives, from one at the corner to zero at the reach.
        cut = Polynomial([1, 0, 0, 0, 0, -126, 420, -540, 315, -70])
        slope, bend = (cut.deriv(k)(s) / reach**k for k in (1, 2))
        wave = np.sin(power * theta) * r**-power
        load = wave * (bend + slope / r - 2 * power * slope / r)
        v = self.poisson(LinearForm(lambda v, w: load * v).assemble(b))
        return cut(s) * wave + np.asarray(b.interpolate(v))


def main() -> None:
    """Deflection, energy and first eigenvalue of what docs/measure/bars.py and tests/test_bars.py compare with."""
    for degrees in (35, 50):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        plate = Polygon(([0, 1.0],) * 2, lambda p, c=c, s=s: np.array([p[0] + c * p[1], s * p[1]]), layers=8)
        print("skew", degrees, *plate.bent((0.5 + 0.5 * c, 0.5 * s)), plate.eigenvalue())
    plate = Polygon(([0, 1.0],) * 2, lambda p: np.array([p[0] * (1 - 0.7 * p[1]) + 0.5 * p[1], 0.8 * p[1]]), layers=8)
    print("trapezium", *plate.bent((0.575, 0.4)), plate.eigenvalue())
    plate = Polygon(([-1, 0, 2.0], [-1, 0, 1.0]), without=((0, 2.0), (-1, 0)), layers=9)
    print("L", *plate.bent((1.0, 0.5), reentrant=((0.0, 0.0), 0.0, 1.5 * np.pi, 1.0)))


if __name__ == "__main__":
    main()
