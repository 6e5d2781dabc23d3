"""The isotropic law."""

from dataclasses import dataclass

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, positive
from skancf.materials.law import SHEAR_CORRECTION, build
from skancf.showing import short


@by_value
@dataclass(frozen=True)
class Isotropic:
    r"""Isotropic elasticity.

    Parameters
    ----------
    young : float
        Young's modulus E (Pa).
    poisson : float
        Poisson's ratio, -1 < nu < 0.5.
    density : float
        Mass per undeformed volume (kg/m3).
    kind : {"plane_stress", "3d"}
        ``"plane_stress"`` (default): in-plane block :math:`E / (1 - \nu^2)`, thickness strain uncoupled. ``"3d"``: the
        three-dimensional law; with nu > 0 the fully parameterised plate then is too stiff in bending by
        :math:`(1 - \nu)^2 / (1 - 2 \nu)`, on any mesh.
    shear_correction : float
        Factor of the transverse shear modulus.
    expansion : float
        Coefficient of thermal expansion (1/K).

    Raises
    ------
    InputError
        For a modulus or density that is not positive or a Poisson's ratio outside (-1, 0.5).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0, expansion=12e-6)
    >>> print(f"{steel.stiffness()[0, 0] / 1e9:.1f} GPa")  # E / (1 - nu^2), plane stress
    230.8 GPa
    """

    young: float
    poisson: float
    density: float
    kind: str = "plane_stress"
    shear_correction: float = SHEAR_CORRECTION
    expansion: float = 0.0
    angle = 0.0

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("young", self.young, "Pa")
        nu = number("poisson", self.poisson)
        if not -1 < nu < 0.5:
            raise InputError(f"poisson = {nu}: an isotropic law needs -1 < poisson < 0.5")
        number("expansion", self.expansion)
        self.stiffness()

    def stiffness(self) -> np.ndarray:
        """C, shape (6, 6), in Voigt order 11, 22, 33, 23, 13, 12."""
        lame = self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        shear = self.young / (2 * (1 + self.poisson))
        full = np.diag([2 * shear] * 3 + [shear] * 3)
        full[:3, :3] += lame
        return build(self, full)

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,)."""
        return self.expansion * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 without stress out of the plane, shape (3,), of either kind."""
        return -self.poisson / (1 - self.poisson) * np.array([1.0, 1.0, 0.0])
