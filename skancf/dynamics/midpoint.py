"""The implicit midpoint rule."""

from dataclasses import dataclass

import numpy as np

from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.tolerances import NEWTON_EXACT


@dataclass(frozen=True)
class ImplicitMidpoint(Rule):
    r"""The implicit midpoint rule: keeps momenta exactly and energy of linear problems; a reference, not a choice.

    .. math::
        M \frac{v_{n+1} - v_n}{\Delta t} + f_{int}(q_{1/2}) = f_{ext}(q_{1/2}, t_{1/2}), \qquad
        \frac{v_{n+1} + v_n}{2} = \frac{u}{\Delta t}, \qquad q_{1/2} = q_n + \tfrac12 u

    In large rotations with steps that do not resolve the membrane's frequencies its energy is not bounded.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rule=sk.ImplicitMidpoint(), dt=2e-4, progress=False)
    >>> print(motion.status.value, len(motion.steps))
    finished 25
    """

    stage = 0.5
    newton_rtol = NEWTON_EXACT

    @property
    def error_constant(self) -> float:
        return 1 / 12

    def mass_factor(self, dt: float) -> float:
        return 2 / dt**2

    def damping_factor(self, dt: float) -> float:
        return 1 / dt

    def acceleration(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return 2 / dt**2 * (u - dt * start.v)

    def rate(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return u / dt

    def end(self, u: np.ndarray, start: State, dt: float) -> State:
        """The acceleration is that of the middle of the step."""
        a = self.acceleration(u, start, dt)
        return State(start.time + dt, start.q + u, 2 / dt * u - start.v, a, dt, before=start.q)

    def jerk(self, start: State, end: State) -> np.ndarray:
        return (end.a - start.a) / (0.5 * (start.dt + end.dt))
