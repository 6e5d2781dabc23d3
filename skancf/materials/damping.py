"""Damping of the material and of the mass."""

from dataclasses import dataclass

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number


@by_value
@dataclass(frozen=True)
class Damping:
    r"""Viscous damping in proportion to mass and stiffness, in dynamics; a state of rest does not see it.

    .. math:: f = \alpha M v, \qquad S = C (\varepsilon + \beta \dot\varepsilon)

    In small vibrations about the undeformed state a mode of circular frequency :math:`\omega` has the damping ratio
    :math:`\zeta = \alpha / (2 \omega) + \beta \omega / 2`. The second kind (Kelvin and Voigt) is of the strains: a motion
    as a rigid body has none, however far it turns. The first brakes every motion, as a medium at rest would.

    C is the stiffness of small strain, of a law at points too, and :math:`\varepsilon` Green's strain: the power
    :math:`\beta\, \dot\varepsilon \cdot C \dot\varepsilon` that it takes is never negative. The stiffness of stretched
    rubber would not do: where :math:`\psi` is not convex in C, as that of Mooney-Rivlin's and Ogden's laws is not from
    stretches of 1.5 on, it would put energy in.

    Parameters
    ----------
    mass : float
        :math:`\alpha` (1/s).
    stiffness : float
        :math:`\beta`, the time of retardation (s).

    Raises
    ------
    InputError
        For a factor that is negative or not finite.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> damped = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, damping=sk.Damping(mass=0.5, stiffness=1e-4))
    """

    mass: float = 0.0
    stiffness: float = 0.0

    def __post_init__(self) -> None:
        plain(self)
        for name, unit in (("mass", "1/s"), ("stiffness", "s")):
            if number(name, getattr(self, name)) < 0:
                raise InputError(f"{name} = {getattr(self, name)} {unit}: damping that is negative adds energy; give a "
                                 "factor of zero or more")  # fmt: skip
