r"""Theory `kirchhoff`: thin plates and shells, whose normals stay normal and keep their length.

The strain at the depth z is :math:`\varepsilon + z \kappa`, membrane strain and curvature change of the mid-surface as in
:mod:`skancf.theories.kirchhoff.point`, on the bicubic Hermite element, which is C1.

A curved thin element whose membrane strains are taken as they are locks: bending without stretching asks for membrane
strains that cubics cannot make zero everywhere. The assumed membrane strain is the part that they can,

.. math:: \hat\varepsilon_{11} \in P_1(\xi) \otimes P_2(\eta), \quad \hat\varepsilon_{22} \in P_2(\xi) \otimes P_1(\eta),
    \quad \hat\varepsilon_{12} \in P_1(\xi) \otimes P_1(\eta),

the projection in the metric of the 4 x 4 Gauss points. The rest :math:`\varepsilon - \hat\varepsilon` counts with the
factors of :func:`rest_factors`, at most one: small against bending, enough to leave no motion free, and all of it where an
element is fine enough not to lock. Elements at a pole, whose metric starts from nothing, keep their membrane strains as
they are.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from skancf.arguments import flag
from skancf.elements.quad_ancf import square_quadrature
from skancf.elements.reference import hermite_functions, of_points
from skancf.kernels.constants import FUNCTIONS
from skancf.materials import Section
from skancf.showing import short
from skancf.theories.kirchhoff.nodes import HermiteNodes
from skancf.theories.kirchhoff.point import SECOND, dot, dual, gradient, strain, unit_normal
from skancf.vectors import cross

REST, REST_FROM = 0.8, 0.9
"""g and x0 of :func:`rest_factors`, by measurement: buckling against locking."""
KEPT = ((2, 3), (3, 2), (2, 2))
"""Legendre polynomials in xi and in eta that the assumed strains 11, 22, 12 are made of."""


@of_points
def legendre(points: np.ndarray, numbers: tuple[int, int]) -> np.ndarray:
    """Products of orthonormal Legendre polynomials on the reference square at points (2, n): (n, n_polynomials)."""
    xi, eta = (legvander(2 * s - 1, n - 1) * np.sqrt(2 * np.arange(n) + 1) for s, n in zip(points, numbers, strict=True))
    return np.asarray((xi[:, :, None] * eta[:, None, :]).reshape(points.shape[1], -1))


@of_points
def jet_table(points: np.ndarray) -> np.ndarray:
    """Jets of the 16 local functions at points (2, n): (5, 16, n)."""
    orders = [(1, 0), (0, 1), (2, 0), (0, 2), (1, 1)]
    return np.stack([hermite_functions(points[0], points[1], order).reshape(FUNCTIONS, -1) for order in orders])


@of_points
def _interpolation(points: np.ndarray) -> np.ndarray:
    inside, weights = square_quadrature(4)
    return np.stack([(legendre(inside, kept) * weights[:, None]) @ legendre(points, kept).T for kept in KEPT])


@of_points
def _values(points: np.ndarray) -> np.ndarray:
    return hermite_functions(points[0], points[1]).reshape(1, FUNCTIONS, -1)


@dataclass(frozen=True)
class Kirchhoff(HermiteNodes):
    """The thin plate or shell.

    Parameters
    ----------
    assumed : bool
        Assumed membrane strains, which do not lock on curved surfaces; False takes them as they are.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 4, 4), sk.Kirchhoff())
    >>> print(f"{1000 * sk.solve_linear(system).displacement((0.5, 0.5))[2]:.4f} mm")  # 0.00126 p a^4 / D
    -0.0658 mm
    """

    assumed: bool = True

    name = "kirchhoff"
    order = 4
    shear = False
    softest = 1e-3
    bytes_per_element, bytes_per_shape = 9_200, 13_000

    __repr__ = short

    def __post_init__(self) -> None:
        flag("assumed", self.assumed)

    @cached_property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Integration points (2, 16) of the reference square and their weights."""
        return square_quadrature(4)

    def warn_of(self, section: Section, reach: float) -> None:
        """The thin plate takes any section: what it leaves out is told by its answers."""

    def position_table(self, points: np.ndarray) -> np.ndarray:
        """Values of the local functions at points (2, n): (1, 16, n)."""
        return _values(points)

    def jets(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Jets (5, 3, n_elements, n) of local vectors (n_elements, 16, 3) at points (2, n)."""
        table = jet_table(points)
        return (np.moveaxis(local, 2, 0).reshape(-1, FUNCTIONS) @ table).reshape(5, 3, len(local), points.shape[1])

    def interpolation(self, points: np.ndarray) -> np.ndarray:
        """Weights of the integration points in the assumed membrane strains 11, 22, 12 at points (2, n): (3, 16, n)."""
        return _interpolation(points)

    def strains(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Strains (n_elements, 6, n) at points (2, n), before those of the undeformed state are subtracted."""
        out = np.moveaxis(strain(self.jets(local, points)), 0, 1)
        if self.assumed:
            inside = np.moveaxis(strain(self.jets(local, self.quadrature[0])), 0, 1)
            out[:, :3] = np.einsum("ecs,csp->ecp", inside[:, :3], self.interpolation(points))
        return out

    def nodal_table(self, points: np.ndarray) -> np.ndarray:
        """r and its derivatives 1, 2, 12 of the local functions at points (2, n): (4, 16, n)."""
        orders = [(0, 0), (1, 0), (0, 1), (1, 1)]
        return np.stack([hermite_functions(points[0], points[1], order).reshape(FUNCTIONS, -1) for order in orders])

    def strain_forces(self, local: np.ndarray, points: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces on the local vectors (n_elements, 16, 3) that do the work of stresses (n_elements, 6, n) on
        :meth:`strains`."""
        if not self.assumed:
            return self._forces_of(local, points, stresses, slice(0, 6))
        inside = self.quadrature[0]
        spread = np.einsum("ecp,csp->ecs", stresses[:, :3], self.interpolation(points))
        membrane = self._forces_of(local, inside, spread, slice(0, 3))
        return membrane + self._forces_of(local, points, stresses[:, 3:], slice(3, 6))

    def _forces_of(self, local: np.ndarray, points: np.ndarray, stresses: np.ndarray, rows: slice) -> np.ndarray:
        on_jets = np.einsum("ekp,kjiep->jiep", stresses, gradient(self.jets(local, points))[rows], optimize=True)
        return np.einsum("jap,jiep->eai", jet_table(points), on_jets, optimize=True)

    def slope_table(self, points: np.ndarray) -> np.ndarray:
        """r_1 and r_2 of the local functions at points (2, n): (2, 16, n)."""
        return jet_table(points)[:2]

    def normals(self, local: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Unit normal (n_elements, 3, n), on the side of the undeformed one."""
        return np.asarray(np.moveaxis(unit_normal(self.jets(local, points)), 0, 1) * side[:, None, None])

    def normal_rates(self, local: np.ndarray, rates: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Rate of the normal (n_elements, 3, n)."""
        jet, moved = self.jets(local, points), self.jets(rates, points)
        n = unit_normal(jet) * side[:, None]
        return np.asarray(np.moveaxis(-sum(a * dot(n, v) for a, v in zip(dual(jet), moved[:2], strict=True)), 0, 1))

    def bases(self, local: np.ndarray, points: np.ndarray, side: np.ndarray, z: Any) -> np.ndarray:
        """Tangent vectors at a height z, or one for each place, and the unit normal: columns of (n_elements, n, 3, 3)."""
        jet = self.jets(local, points)
        n, duals = unit_normal(jet) * side[:, None], dual(jet)
        r11, r22, r12 = (dot(n, jet[ab]) for ab in SECOND)
        slopes = [-(one * duals[0] + two * duals[1]) for one, two in ((r11, r12), (r12, r22))]
        return np.moveaxis(np.stack([jet[0] + z * slopes[0], jet[1] + z * slopes[1], n]), (0, 1), (-1, -2))


def local_frame(jet: np.ndarray, first: np.ndarray, side: np.ndarray) -> np.ndarray:
    """Rows e1, e2, e3, shape (3, 3, n_elements, n): e3 the normal on its side, e1 the part of ``first`` in the surface."""
    n = unit_normal(jet) * side[:, None]
    e1 = first - n * dot(n, first)
    e1 = e1 / np.sqrt(dot(e1, e1))
    return np.stack([e1, cross(n, e1), n])


def covariant_to_local(jet: np.ndarray, first: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""From covariant strains to those in the local frame.

    Parameters
    ----------
    jet : (5, 3, n_elements, n) array
        Of the undeformed state.
    first : (3, n_elements, n) array
        Tangent along the parameter x.
    side : (n_elements,) array
        1 where the corners are numbered counter-clockwise, else -1.

    Returns
    -------
    turn : (6, 6, n_elements, n) array
        Membrane strains 11, 22, 12 (doubled) and curvature changes, each from the covariant ones.
    area : (n_elements, n) array
        Per unit of the reference square.
    """
    e1, e2, _ = local_frame(jet, first, side)
    F = np.stack([[dot(e, jet[a]) for a in range(2)] for e in (e1, e2)])
    A = np.moveaxis(np.linalg.inv(np.moveaxis(F, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    voigt = [(0, 0), (1, 1), (0, 1)]
    turn = np.zeros((6, 6, *F.shape[2:]))
    for row, (p, q) in enumerate(voigt):
        for column, (i, j) in enumerate(voigt):
            turn[row, column] = (1.0 if p == q else 2.0) * (A[i, p] * A[j, q] + A[j, p] * A[i, q]) / 2
    turn[3:, 3:] = turn[:3, :3] * side[:, None]
    area = np.abs(F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0])
    return turn, area


def rest_factors(jet: np.ndarray, thickness: float) -> np.ndarray:
    r"""Roots :math:`\omega` of the factors of the rest of the membrane strains 11, 22, 12: (n_elements, 3).

    .. math:: \omega_{aa} = \min\Bigl(1, \max\Bigl(\frac{t}{h_a},\ g\,\frac{x_a - x_0}{x_a^2}\Bigr)\Bigr), \qquad
        x_a = \frac{k h_a^2}{t}, \qquad \omega_{12}^2 = \omega_{11} \omega_{22}

    with the lengths :math:`h_a` of an undeformed element and its largest principal curvature k. An element with
    :math:`x < x_0` resolves the waves in which a shell buckles, of the length :math:`\sqrt{t / k}`. In a coarser one some of
    its own waves have no membrane strain but the rest, and with :math:`t/h` alone they would buckle early. The second term
    holds them; it falls as locking, in proportion to :math:`x^2`, rises.
    """
    lengths = np.sqrt(dot(jet[:2].swapaxes(0, 1), jet[:2].swapaxes(0, 1))).mean(axis=-1)
    x = np.maximum(largest_curvature(jet).mean(axis=-1) * lengths**2 / thickness, REST_FROM)
    one, two = np.minimum(1.0, np.maximum(thickness / lengths, REST * (x - REST_FROM) / x**2))
    return np.stack([one, two, np.sqrt(one * two)], axis=1)


def largest_curvature(jet: np.ndarray) -> np.ndarray:
    """Size of the larger principal curvature, (...) (1/m)."""
    n, (a1, a2) = unit_normal(jet), dual(jet)
    b11, b22, b12 = (dot(jet[k], n) for k in SECOND)
    a11, a22, a12 = dot(a1, a1), dot(a2, a2), dot(a1, a2)
    mean = (a11 * b11 + a22 * b22 + 2 * a12 * b12) / 2
    gauss = (a11 * a22 - a12**2) * (b11 * b22 - b12**2)
    return np.asarray(np.abs(mean) + np.sqrt(np.maximum(mean**2 - gauss, 0.0)))
