"""The generalised-alpha rule."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skancf.errors import InputError, number


@dataclass(frozen=True)
class GeneralizedAlpha:
    r"""Generalised-alpha, second order, with the spectral radius ``rho_inf`` at infinite frequency.

    .. math::
        M\,[(1-\alpha_m) a_{n+1} + \alpha_m a_n] + f_{int}(q_\alpha) = f_{ext}(q_\alpha, t_\alpha), \qquad
        q_\alpha = (1-\alpha_f) q_{n+1} + \alpha_f q_n,

    with Newmark's formulas for q and v. ``rho_inf = 1`` damps nothing and is not stable in long nonlinear runs; 0 damps
    high frequencies within a step.

    References
    ----------
    Chung and Hulbert (1993), Journal of Applied Mechanics 60, 371-375.
    """

    rho_inf: float = 0.8
    order = 2

    def __post_init__(self) -> None:
        if not 0 <= number("rho_inf", self.rho_inf) <= 1:
            raise InputError(f"rho_inf = {self.rho_inf}: a spectral radius lies between 0 and 1")

    @cached_property
    def alpha_m(self) -> float:
        return (2 * self.rho_inf - 1) / (self.rho_inf + 1)

    @cached_property
    def alpha_f(self) -> float:
        return self.rho_inf / (self.rho_inf + 1)

    @cached_property
    def gamma(self) -> float:
        return 0.5 - self.alpha_m + self.alpha_f

    @cached_property
    def beta(self) -> float:
        return 0.25 * (1 - self.alpha_m + self.alpha_f) ** 2

    def mass_factor(self, dt: float) -> float:
        """Factor of the mass in the derivative of the residual with respect to q_{n+1}."""
        return (1 - self.alpha_m) / (self.beta * dt**2)

    @property
    def stiffness_factor(self) -> float:
        """Factor of the stiffness in it."""
        return 1 - self.alpha_f

    def acceleration(self, q1: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float) -> np.ndarray:
        """a_{n+1} that belongs to q_{n+1}."""
        return (q1 - q - dt * v) / (self.beta * dt**2) - (0.5 / self.beta - 1) * a

    def velocity(self, a1: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float) -> np.ndarray:
        """v_{n+1} that belongs to a_{n+1}."""
        return v + dt * ((1 - self.gamma) * a + self.gamma * a1)

    def local_error(self, change_of_acceleration: np.ndarray, dt: float) -> np.ndarray:
        """Estimate of the error of one step, (beta - 1/6) dt^2 (a_{n+1} - a_n) (Zienkiewicz and Xie, 1991)."""
        return abs(self.beta - 1 / 6) * dt**2 * change_of_acceleration
