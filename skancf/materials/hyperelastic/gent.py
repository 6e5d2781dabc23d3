"""Gent's law."""

from dataclasses import dataclass
from math import inf, log1p

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
    half, most = 0.5 * par[1], par[2]
    left = 1.0 - i1 / most
    if not left > 0.0:
        return inf, inf, 0.0, inf, 0.0, 0.0
    return -half * most * log1p(-i1 / most), half / left, 0.0, half / (most * left * left), 0.0, 0.0


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
class Gent(OfInvariants):
    r"""Rubber of chains that end somewhere.

    .. math:: \psi = -\tfrac{\mu J_m}{2} \ln \Bigl( 1 - \frac{J^{-2/3} I_1 - 3}{J_m} \Bigr) + \tfrac K4 (J^2 - 1 - 2 \ln J)

    Parameters
    ----------
    shear : float
        Shear modulus :math:`\mu` of small strain (Pa).
    most : float
        :math:`J_m`, what :math:`J^{-2/3} I_1 - 3` stays below: 30 to 100 of rubber, 1 of tissue.
    density : float
        Mass per undeformed volume (kg/m3).
    poisson, bulk, expansion
        As for :class:`~skancf.NeoHooke`; without Poisson's ratio and bulk modulus it is incompressible.

    Raises
    ------
    InputError
        For a shear modulus or a limit that is not positive, and as for :class:`~skancf.NeoHooke`.

    Examples
    --------
    >>> tissue = sk.materials.Gent(shear=0.4e6, most=30.0, density=1000.0)
    >>> stress = tissue.plane_stress(np.array([[4.0], [0.5], [0.0]])).stress  # stretched to twice its length
    >>> print((4 * stress[0]).round(1), "Pa")
    [1500000.] Pa
    """

    shear: float
    most: float
    density: float
    poisson: float | None = None
    bulk: float | None = None
    expansion: float = 0.0
    compiled = at_point
    _at_points = staticmethod(at_points)
    _in_solids = staticmethod(in_solids)

    __repr__ = short

    @property
    def limit(self) -> str:  # type: ignore[override]
        return f"I1 - 3, at equal volume, must stay below most = {self.most:g}"

    def _check(self) -> None:
        positive("shear", self.shear, "Pa")
        positive("most", self.most)

    @property
    def shear_modulus(self) -> float:
        return self.shear

    @property
    def parameters(self) -> np.ndarray:
        return np.array([self.bulk_modulus, self.shear, self.most])
