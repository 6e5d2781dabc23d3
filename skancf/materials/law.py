r"""Linear elastic laws S = C E, as 6 x 6 matrices.

Voigt order is 11, 22, 33, 23, 13, 12 with doubled shear strains; direction 3 is the normal of the undeformed surface
and direction 1 its tangent along the parameter x, unless a material angle turns 1 and 2 about 3.
"""

from dataclasses import dataclass, field
from math import cos, sin
from typing import Any, Protocol

import numpy as np

from skancf.arguments import choice, plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, number, positive, shown, vector
from skancf.functions import Noted, is_ours
from skancf.showing import short
from skancf.tolerances import ROUNDED_SUM, SYMMETRIC

SHEAR_CORRECTION = 5 / 6
IN_PLANE, OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]
TRANSVERSE = [3, 4]
THICKNESS = 2


class Law(Protocol):
    """What the rest of the library knows of a material.

    Examples
    --------
    >>> class Glass:
    ...     density = 2500.0
    ...     def stiffness(self):
    ...         return sk.Isotropic(70e9, 0.23, 2500.0).stiffness()
    ...     def thermal_strain(self):
    ...         return np.zeros(6)
    >>> pane = sk.Problem(sk.Rectangle(1.0, 1.0), 0.006, Glass())
    """

    @property
    def density(self) -> float:
        """Mass per undeformed volume."""

    def stiffness(self) -> np.ndarray:
        """C, shape (6, 6), in the frame of the undeformed surface."""

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,), in the frame of the undeformed surface."""


def require_law(material: Any) -> None:
    """InputError for what has not the methods of a :class:`Law`."""
    missing = [name for name in ("density", "stiffness", "thermal_strain") if not hasattr(material, name)]
    if isinstance(material, type) or missing:
        raise InputError(f"material = {shown(material)}: give a law, for example Isotropic(young, poisson, density)"
                         + (f"; this has no {' and no '.join(missing)}" if missing else ""))  # fmt: skip


def stiffness_of(law: Any) -> np.ndarray:
    """The stiffness of a law, checked where the law does not come from this library."""
    if is_ours(law):
        return np.asarray(law.stiffness())
    with Noted("material"):
        matrix = finite("material.stiffness()", law.stiffness())
        vector("material.thermal_strain()", law.thermal_strain(), 6)
        positive("material.density", law.density, "kg/m3")
    if matrix.shape != (6, 6):
        raise InputError(f"material.stiffness() of shape {matrix.shape}: a law is a 6 x 6 matrix")
    return check_definite(matrix, type(law).__name__)


def thinning(matrix: np.ndarray) -> np.ndarray:
    """Strain 33 per unit of 11, 22, 12 where S33 = S23 = S13 = 0, of a law (6, 6): (3,)."""
    out, plane = matrix[np.ix_(OUT_OF_PLANE, OUT_OF_PLANE)], matrix[np.ix_(OUT_OF_PLANE, IN_PLANE)]
    return np.asarray(-np.linalg.solve(out, plane)[0])


def thinning_of(law: Any) -> np.ndarray:
    """The same of a law: what it says itself, which one of plane stress must, or that of its stiffness."""
    own = getattr(law, "thinning", None)
    return vector("material.thinning()", own(), 3) if callable(own) else thinning(stiffness_of(law))


def turned_thinning(row: np.ndarray, angle: float) -> np.ndarray:
    """The same (3,) of a material whose axes 1 and 2 are turned by ``angle`` (radians) about axis 3."""
    return np.asarray(row @ strain_turn(angle)[np.ix_(IN_PLANE, IN_PLANE)])


def check_definite(matrix: np.ndarray, name: str) -> np.ndarray:
    """The matrix, if it is symmetric positive definite."""
    scale = np.abs(matrix).max()
    asymmetry = np.abs(matrix - matrix.T).max()
    if asymmetry > SYMMETRIC * scale:
        raise InputError(
            f"{name}: the stiffness is not symmetric (largest difference {asymmetry:.3g}); "
            "an elastic law needs C = C^T, check nu_ij / E_i = nu_ji / E_j"
        )
    lowest = np.linalg.eigvalsh((matrix + matrix.T) / 2)[0]
    if not lowest > ROUNDED_SUM * scale:
        raise InputError(
            f"{name}: the stiffness is not positive definite (smallest eigenvalue {lowest:.3g}); "
            "some strain would release energy, check the moduli and Poisson's ratios"
        )
    return (matrix + matrix.T) / 2


def plane_stress(full: np.ndarray, shear_correction: float) -> np.ndarray:
    r"""The law of a plate made from a three-dimensional one.

    The in-plane block is condensed for S_33 = 0,
    :math:`C_{ab} - C_{a3} C_{3b} / C_{33}`, the thickness strain keeps :math:`C_{33}` and is uncoupled from the others,
    and the transverse shear block is multiplied by the shear correction factor.
    """
    reduced = full - np.outer(full[:, THICKNESS], full[THICKNESS]) / full[THICKNESS, THICKNESS]
    reduced[THICKNESS, THICKNESS] = full[THICKNESS, THICKNESS]
    return corrected(reduced, shear_correction)


def corrected(full: np.ndarray, shear_correction: float) -> np.ndarray:
    """The law with transverse shear (rows and columns 23 and 13) scaled by the shear correction factor."""
    factor = np.ones(6)
    factor[TRANSVERSE] = np.sqrt(shear_correction)
    return full * np.outer(factor, factor)


def strain_turn(angle: float) -> np.ndarray:
    """Strain in axes that are turned by ``angle`` (radians) about axis 3, from that in the present ones: (6, 6)."""
    c, s = cos(angle), sin(angle)
    return np.array(
        [
            [c * c, s * s, 0, 0, 0, c * s],
            [s * s, c * c, 0, 0, 0, -c * s],
            [0, 0, 1, 0, 0, 0],
            [0, 0, 0, c, -s, 0],
            [0, 0, 0, s, c, 0],
            [-2 * c * s, 2 * c * s, 0, 0, 0, c * c - s * s],
        ]
    )


def turned(matrix: np.ndarray, angle: float) -> np.ndarray:
    """The law of a material whose axes 1 and 2 are turned by ``angle`` (radians) about axis 3."""
    to_material = strain_turn(angle)
    return to_material.T @ matrix @ to_material


def turned_strain(strain: np.ndarray, angle: float) -> np.ndarray:
    """A strain (6,) that is known in axes turned by ``angle`` (radians) about axis 3, in the present ones."""
    return strain_turn(-angle) @ strain


@by_value
@dataclass(frozen=True, eq=False)
class Anisotropic:
    r"""Any symmetric positive definite 6 x 6 law.

    Parameters
    ----------
    matrix : (6, 6) array
        C in the material's axes, Voigt order 11, 22, 33, 23, 13, 12, doubled shear strains (Pa).
    density : float
        Mass per undeformed volume (kg/m3).
    angle : float
        From the tangent along the parameter x to the material's axis 1, radians.
    kind : {"plane_stress", "3d"}
        ``"plane_stress"`` condenses the in-plane block for S_33 = 0, which the element needs because its thickness
        strain is constant through the thickness; ``"3d"`` takes the matrix as it is and suffers Poisson thickness locking.
    shear_correction : float
        Factor of the transverse shear block.
    expansion : (6,)
        Thermal strain per kelvin in the material's axes, Voigt order and doubled shear strains (1/K).

    Raises
    ------
    InputError
        For a matrix that is not symmetric positive definite, or values that are not finite or not positive.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0, kind="3d")
    >>> ribbed = sk.Anisotropic(steel.stiffness() + np.diag([20e9, 0, 0, 0, 0, 0]), density=7850.0)
    >>> print(f"{(ribbed.stiffness()[0, 0] - ribbed.stiffness()[1, 1]) / 1e9:.1f} GPa")
    20.0 GPa
    """

    matrix: Any
    density: float
    angle: float = 0.0
    kind: str = "plane_stress"
    shear_correction: float = SHEAR_CORRECTION
    expansion: Any = (0.0,) * 6
    _stiffness: np.ndarray = field(init=False, repr=False, compare=False)

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("expansion", self.expansion, 6)
        object.__setattr__(self, "_stiffness", build(self, finite("matrix", self.matrix)))

    def stiffness(self) -> np.ndarray:
        return self._stiffness.copy()

    def thermal_strain(self) -> np.ndarray:
        """Free strain per kelvin, shape (6,), after the turn by ``angle``."""
        return turned_strain(vector("expansion", self.expansion, 6), self.angle)

    def thinning(self) -> np.ndarray:
        """Strain 33 per unit of 11, 22, 12 without stress out of the plane, shape (3,), of either kind."""
        return turned_thinning(thinning(finite("matrix", self.matrix)), self.angle)


def build(law: Any, full: np.ndarray) -> np.ndarray:
    """The checked stiffness of a law with the attributes of :class:`Anisotropic`."""
    name = type(law).__name__
    positive("density", law.density, "kg/m3")
    positive("shear_correction", law.shear_correction)
    choice("kind", law.kind, ("plane_stress", "3d"))
    if full.shape != (6, 6):
        raise InputError(f"{name}: matrix of shape {full.shape}; a law is a 6 x 6 matrix")
    full = check_definite(full, name)
    plate = plane_stress(full, law.shear_correction) if law.kind == "plane_stress" else corrected(full, law.shear_correction)
    return turned(plate, number("angle", law.angle))
