"""Yeoh's law."""

from dataclasses import dataclass

import numpy as np

from skancf.compiled import compiled
from skancf.equality import by_value
from skancf.errors import number, positive
from skancf.materials.hyperelastic import kernels
from skancf.materials.hyperelastic.kernels import LOOP, POINT
from skancf.materials.hyperelastic.law import OfInvariants
from skancf.materials.hyperelastic.solid_kernels import store_solid
from skancf.showing import short


@compiled(**POINT)
def isochoric(i1, i2, par):
    one, two, three = par[1], par[2], par[3]
    return (i1 * (one + i1 * (two + i1 * three)), one + i1 * (2.0 * two + i1 * 3.0 * three), 0.0,
            2.0 * two + 6.0 * i1 * three, 0.0, 0.0)  # fmt: skip


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
class Yeoh(OfInvariants):
    r"""Rubber that stiffens, :math:`\psi = \sum_{k=1}^3 c_{k0} (J^{-2/3} I_1 - 3)^k + \tfrac K4 (J^2 - 1 - 2 \ln J)`.

    Parameters
    ----------
    c10, c20, c30 : float
        Pa; the shear modulus of small strain is :math:`\mu = 2 c_{10}`.
    density : float
        Mass per undeformed volume (kg/m3).
    poisson, bulk, expansion
        As for :class:`~skancf.NeoHooke`; without Poisson's ratio and bulk modulus it is incompressible.

    Raises
    ------
    InputError
        For a ``c10`` that is not positive, and as for :class:`~skancf.NeoHooke`.

    Examples
    --------
    >>> tyre = sk.materials.Yeoh(c10=0.2e6, c20=-2e3, c30=50.0, density=1100.0)
    >>> stress = tyre.plane_stress(np.array([[4.0], [0.5], [0.0]])).stress  # stretched to twice its length
    >>> print((4 * stress[0]).round(1), "Pa")
    [1348200.] Pa
    """

    c10: float
    c20: float
    c30: float
    density: float
    poisson: float | None = None
    bulk: float | None = None
    expansion: float = 0.0
    compiled = at_point
    _at_points = staticmethod(at_points)
    _in_solids = staticmethod(in_solids)

    __repr__ = short

    def _check(self) -> None:
        positive("c10", self.c10, "Pa")
        number("c20", self.c20)
        number("c30", self.c30)

    @property
    def shear_modulus(self) -> float:
        return 2 * self.c10

    @property
    def parameters(self) -> np.ndarray:
        return np.array([self.bulk_modulus, self.c10, self.c20, self.c30])
