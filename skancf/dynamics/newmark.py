"""Newmark's formulas, with which rules of the generalised-alpha family go from accelerations to rates and positions."""

import numpy as np

from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State


class Newmark(Rule):
    r"""Rules with the parameters alpha_m, alpha_f, beta and gamma.

    .. math::
        u = \Delta t\, v_n + \Delta t^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}], \qquad
        v_{n+1} = v_n + \Delta t\, [(1 - \gamma) a_n + \gamma a_{n+1}],

    accelerations at :math:`1 - \alpha_m` of the step, forces and rates at :math:`1 - \alpha_f`.
    """

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    @property
    def stage(self) -> float:  # type: ignore[override]
        return 1 - self.alpha_f

    @property
    def error_constant(self) -> float:
        r"""From the frequency of a linear oscillator, :math:`\omega (1 - c\,\omega^2 \Delta t^2)`."""
        return 0.5 * self.beta - 0.5 * (self.gamma - 0.5) * self.alpha_f - 1 / 24

    def mass_factor(self, dt: float) -> float:
        return (1 - self.alpha_m) / (self.beta * dt**2)

    def damping_factor(self, dt: float) -> float:
        return (1 - self.alpha_f) * self.gamma / (self.beta * dt)

    def _first(self, start: State, dt: float) -> np.ndarray:
        """Acceleration at the start of the step: what a rule stores is that at (alpha_m - alpha_f) of its own step later."""
        later = (self.alpha_m - self.alpha_f) * (dt - start.dt)
        return start.a if start.jerk is None or not start.dt or not later else start.a + later * start.jerk

    def _last(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return (u - dt * start.v) / (self.beta * dt**2) - (0.5 / self.beta - 1) * self._first(start, dt)

    def _rate(self, a: np.ndarray, start: State, dt: float) -> np.ndarray:
        return start.v + dt * ((1 - self.gamma) * self._first(start, dt) + self.gamma * a)

    def acceleration(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return (1 - self.alpha_m) * self._last(u, start, dt) + self.alpha_m * self._first(start, dt)

    def rate(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return (1 - self.alpha_f) * self._rate(self._last(u, start, dt), start, dt) + self.alpha_f * start.v

    def end(self, u: np.ndarray, start: State, dt: float) -> State:
        a = self._last(u, start, dt)
        jerk = (a - self._first(start, dt)) / dt
        return State(start.time + dt, start.q + u, self._rate(a, start, dt), a, dt, jerk, start.q)

    def jerk(self, start: State, end: State) -> np.ndarray:
        assert end.jerk is not None
        return end.jerk
