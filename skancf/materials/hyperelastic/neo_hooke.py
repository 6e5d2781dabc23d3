"""The neo-Hookean law."""

from dataclasses import dataclass

import numpy as np

from skancf.compiled import compiled
from skancf.equality import by_value
from skancf.errors import positive
from skancf.materials.hyperelastic import kernels
from skancf.materials.hyperelastic.kernels import LOOP, POINT
from skancf.materials.hyperelastic.law import OfInvariants
from skancf.materials.hyperelastic.solid_kernels import store_solid
from skancf.showing import short


@compiled(**POINT)
def isochoric(i1, i2, par):
    half = 0.5 * par[1]
    return half * i1, half, 0.0, 0.0, 0.0, 0.0


@compiled(**POINT)
def derivatives(i1, i2, x, par):
    first, second = kernels.isochoric(i1, i2, x)
    return kernels.with_volume(isochoric(first, second, par), i1, i2, x, par[0])


@compiled(**POINT)
def at_point(a, b, d, guess, par):
    return kernels.of_invariants(isochoric, derivatives, a, b, d, guess, par)


@compiled(**LOOP)
def at_points(C, guess, par, out):
    for k in range(C.shape[1]):
        kernels.store(out, k, at_point(C[0, k], C[1, k], C[2, k], guess[k], par))


@compiled(**LOOP)
def in_solids(C, par, out):
    inverse, G = np.empty((3, 3)), np.empty((3, 6))
    for k in range(C.shape[1]):
        store_solid(derivatives, C, k, par, out, inverse, G)


@by_value
@dataclass(frozen=True)
class NeoHooke(OfInvariants):
    r"""Rubber at moderate stretches, :math:`\psi = \tfrac \mu 2 (J^{-2/3} I_1 - 3) + \tfrac K4 (J^2 - 1 - 2 \ln J)`.

    Parameters
    ----------
    shear : float
        Shear modulus :math:`\mu` of small strain (Pa).
    density : float
        Mass per undeformed volume (kg/m3).
    poisson : float, optional
        Poisson's ratio of small strain, for :math:`K = 2 \mu (1 + \nu) / (3 - 6 \nu)`; 0.5 is incompressible.
    bulk : float, optional
        Bulk modulus K instead (Pa). Without both the law is incompressible, and has the first part alone.
    expansion : float
        Coefficient of thermal expansion (1/K).

    Raises
    ------
    InputError
        For moduli or a density that are not positive, and a Poisson's ratio outside (-1, 0.5].

    Examples
    --------
    >>> rubber = sk.NeoHooke(shear=0.4e6, density=1000.0)
    >>> stretch = 2.0  # along 1, free across: Cauchy's stress is mu (stretch^2 - 1 / stretch)
    >>> stress = rubber.plane_stress(np.array([[stretch**2], [1 / stretch], [0.0]])).stress
    >>> print((stress[0] * stretch**2).round(1), "Pa")
    [1400000.] Pa
    """

    shear: float
    density: float
    poisson: float | None = None
    bulk: float | None = None
    expansion: float = 0.0
    compiled = at_point
    _at_points = staticmethod(at_points)
    _in_solids = staticmethod(in_solids)

    __repr__ = short

    def _check(self) -> None:
        positive("shear", self.shear, "Pa")

    @property
    def shear_modulus(self) -> float:
        return self.shear

    @property
    def parameters(self) -> np.ndarray:
        return np.array([self.bulk_modulus, self.shear])
