"""The law of Mooney and Rivlin."""

from dataclasses import dataclass

import numpy as np

from skancf.compiled import compiled
from skancf.equality import by_value
from skancf.errors import InputError, number
from skancf.materials.hyperelastic import kernels
from skancf.materials.hyperelastic.kernels import LOOP, POINT
from skancf.materials.hyperelastic.law import OfInvariants
from skancf.materials.hyperelastic.solid_kernels import store_solid
from skancf.showing import short


@compiled(**POINT)
def isochoric(i1, i2, par):
    return par[1] * i1 + par[2] * i2, par[1], par[2], 0.0, 0.0, 0.0


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
class MooneyRivlin(OfInvariants):
    r"""Rubber, :math:`\psi = c_{10} (J^{-2/3} I_1 - 3) + c_{01} (J^{-4/3} I_2 - 3) + \tfrac K4 (J^2 - 1 - 2 \ln J)`.

    Parameters
    ----------
    c10, c01 : float
        Pa; the shear modulus of small strain is :math:`\mu = 2 (c_{10} + c_{01})`.
    density : float
        Mass per undeformed volume (kg/m3).
    poisson, bulk, expansion
        As for :class:`~skancf.NeoHooke`; without Poisson's ratio and bulk modulus it is incompressible.

    Raises
    ------
    InputError
        For a shear modulus that is not positive, and as for :class:`~skancf.NeoHooke`.

    Examples
    --------
    >>> rubber = sk.MooneyRivlin(c10=0.15e6, c01=0.05e6, density=1000.0)
    >>> stretch = 2.0  # along 1, free across: Cauchy's stress is 2 (stretch^2 - 1 / stretch) (c10 + c01 / stretch)
    >>> stress = rubber.plane_stress(np.array([[stretch**2], [1 / stretch], [0.0]])).stress
    >>> print((stress[0] * stretch**2).round(1), "Pa")
    [1225000.] Pa
    """

    c10: float
    c01: float
    density: float
    poisson: float | None = None
    bulk: float | None = None
    expansion: float = 0.0
    compiled = at_point
    _at_points = staticmethod(at_points)
    _in_solids = staticmethod(in_solids)

    __repr__ = short

    def _check(self) -> None:
        number("c10", self.c10)
        number("c01", self.c01)
        if not self.shear_modulus > 0:
            raise InputError(f"c10 = {self.c10}, c01 = {self.c01}: the shear modulus 2 (c10 + c01) = {self.shear_modulus} "
                             "Pa must be greater than zero")  # fmt: skip

    @property
    def shear_modulus(self) -> float:
        return 2 * (self.c10 + self.c01)

    @property
    def parameters(self) -> np.ndarray:
        return np.array([self.bulk_modulus, self.c10, self.c01])
