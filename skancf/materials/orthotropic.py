"""The orthotropic law."""

from dataclasses import dataclass

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import positive, vector
from skancf.materials.law import SHEAR_CORRECTION, build, check_definite, thinning, turned_strain, turned_thinning
from skancf.showing import short


@by_value
@dataclass(frozen=True)
class Orthotropic:
    r"""Orthotropic elasticity from engineering constants.

    Parameters
    ----------
    young : (E1, E2, E3)
        Young's moduli (Pa).
    poisson : (nu12, nu13, nu23)
        Poisson's ratios, :math:`\nu_{ij} = -\varepsilon_j / \varepsilon_i` under stress along i.
    shear : (G12, G13, G23)
        Shear moduli (Pa).
    density : float
        Mass per undeformed volume (kg/m3).
    angle : float
        From the tangent along the parameter x to the material's axis 1, radians.
    kind, shear_correction
        As for :class:`~skancf.Anisotropic`.
    expansion : (a1, a2, a3)
        Coefficients of thermal expansion along the material's axes (1/K).

    Raises
    ------
    InputError
        For moduli that are not positive, or Poisson's ratios for which the law is not positive definite.

    Examples
    --------
    >>> ply = sk.Orthotropic(young=(138e9, 9e9, 9e9), poisson=(0.3, 0.3, 0.4), shear=(7e9, 7e9, 3.2e9), density=1600.0)
    >>> along, across = ply.stiffness()[[0, 1], [0, 1]] / 1e9
    >>> print(f"{along:.1f} GPa along the fibres, {across:.1f} GPa across")
    138.8 GPa along the fibres, 9.1 GPa across
    """

    young: tuple[float, float, float]
    poisson: tuple[float, float, float]
    shear: tuple[float, float, float]
    density: float
    angle: float = 0.0
    kind: str = "plane_stress"
    shear_correction: float = SHEAR_CORRECTION
    expansion: tuple[float, float, float] = (0.0, 0.0, 0.0)

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        for name, values in (("young", self.young), ("shear", self.shear)):
            for value in vector(name, values, 3):
                positive(name, value, "Pa")
        vector("poisson", self.poisson, 3)
        vector("expansion", self.expansion, 3)
        self.stiffness()

    def stiffness(self) -> np.ndarray:
        """C, shape (6, 6), in Voigt order 11, 22, 33, 23, 13, 12, after the turn by ``angle``."""
        return build(self, self._matrix())

    def _matrix(self) -> np.ndarray:
        """The three-dimensional law in the material's axes."""
        e1, e2, e3 = self.young
        nu12, nu13, nu23 = self.poisson
        g12, g13, g23 = self.shear
        compliance = np.diag([1 / e1, 1 / e2, 1 / e3, 1 / g23, 1 / g13, 1 / g12])
        for (i, j), value in {(0, 1): -nu12 / e1, (0, 2): -nu13 / e1, (1, 2): -nu23 / e2}.items():
            compliance[i, j] = compliance[j, i] = value
        check_definite(compliance, "Orthotropic")
        return np.linalg.inv(compliance)

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,), after the turn by ``angle``."""
        return turned_strain(np.array([*self.expansion, 0.0, 0.0, 0.0]), self.angle)

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 without stress out of the plane, shape (3,), of either kind."""
        return turned_thinning(thinning(self._matrix()), self.angle)
