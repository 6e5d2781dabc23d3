"""The generalised-alpha rule."""

from dataclasses import dataclass
from functools import cached_property

from skancf.arguments import plain
from skancf.dynamics.newmark import Newmark
from skancf.errors import InputError, number


@dataclass(frozen=True)
class GeneralizedAlpha(Newmark):
    r"""Generalised-alpha, second order, with the spectral radius ``rho_inf`` at infinite frequency.

    .. math::
        M\,[(1-\alpha_m) a_{n+1} + \alpha_m a_n] + f_{int}(q_\alpha) = f_{ext}(q_\alpha, t_\alpha), \qquad
        q_\alpha = (1-\alpha_f) q_{n+1} + \alpha_f q_n,

    with Newmark's formulas for q and v. It takes energy out of what the steps do not resolve, and little out of the rest, in
    linear problems; in large rotations its energy is not bounded. A body that turns at the rate :math:`\omega` is strained
    where forces are taken, at a chord between two states, so that its ends of steps are stretched by
    :math:`\tfrac12 \alpha_f (1-\alpha_f) (\omega \Delta t)^2` both ways, whatever its stiffness: for comparison, and for
    motions that turn little. ``rho_inf = 1`` damps nothing, is the implicit midpoint rule and not stable in long nonlinear
    runs; 0 damps high frequencies within a step.

    References
    ----------
    Chung and Hulbert (1993), Journal of Applied Mechanics 60, 371-375.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rule=sk.GeneralizedAlpha(rho_inf=0.6), dt=2e-4, progress=False)
    >>> print(motion.status.value, len(motion.steps))
    finished 25
    """

    rho_inf: float = 0.8

    def __post_init__(self) -> None:
        plain(self)
        if not 0 <= number("rho_inf", self.rho_inf) <= 1:
            raise InputError(f"rho_inf = {self.rho_inf}: a spectral radius lies between 0 and 1")

    @cached_property
    def alpha_m(self) -> float:  # type: ignore[override]
        return (2 * self.rho_inf - 1) / (self.rho_inf + 1)

    @cached_property
    def alpha_f(self) -> float:  # type: ignore[override]
        return self.rho_inf / (self.rho_inf + 1)

    @cached_property
    def gamma(self) -> float:  # type: ignore[override]
        return 0.5 - self.alpha_m + self.alpha_f

    @cached_property
    def beta(self) -> float:  # type: ignore[override]
        return 0.25 * (1 - self.alpha_m + self.alpha_f) ** 2
