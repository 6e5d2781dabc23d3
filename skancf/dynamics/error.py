"""What a step adds to the error of a motion, and how far the motion came, both in metres."""

import numpy as np

from skancf.dynamics.state import State
from skancf.dynamics.step_solver import StepSolver
from skancf.system.system import System
from skancf.tolerances import KNOWN_START, ROUNDED_POSITION

ADDING = np.pi / 2
"""Errors of an oscillation's steps add up all of a cosine without its sign, of which they measure 2 / pi."""
MANY = 50
"""Times the rounding of positions: a motion that is smaller is not followed."""


class Measure:
    """Sizes of motions on one mesh: mass-weighted root mean squares of positions.

    Where nothing is held they are taken less their mean, so that a common translation does not count.

    Attributes
    ----------
    rounding : float
        The size that rounding has (m).
    """

    def __init__(self, system: System):
        mass = np.abs(system.inertia.shares[system.layout.moving, 0])
        self.system, self.mass = system, float(mass.sum())
        self.weights = mass / mass.sum()
        self.free = not system.constraints.fixed.any() and system.foundation is None
        positions = system.layout.positions(system.undeformed)
        self.rounding = ROUNDED_POSITION * float(np.abs(positions - positions.mean(axis=0)).max())

    def size(self, u: np.ndarray) -> float:
        """That of nodal vectors (n_dofs,)."""
        r = self.system.layout.positions(u)
        with np.errstate(over="ignore", invalid="ignore"):
            if self.free:
                r = r - self.weights @ r
            return float(np.sqrt(self.weights @ (r * r).sum(axis=1)))

    def least(self, q: np.ndarray) -> float:
        """The displacement (m) from a start at nodal coordinates q (n_dofs,) that errors are compared with at least.

        That of rounding, and a small part of the displacement at the start, which is known to the tolerance of statics.
        """
        return max(MANY * self.rounding, KNOWN_START * self.size(q - self.system.undeformed))

    def error(self, solver: StepSolver, start: State, end: State, span: float) -> float:
        r"""What a step adds to the error by the end of the run (m).

        .. math::
            \frac{\pi}{2} |e_s| + 2 A \frac{\Delta t}{T}, \qquad A = \frac{\sqrt{h \cdot M F h / m}}{4 c}, \quad h = e - e_s

        :math:`e = c\,\Delta t^3 \dddot q`, of which :math:`e_s` is the part that the step resolves. The errors of vibrations
        h that it hardly resolves do not add up: what is wrong of them is twice their amplitude A at most, whatever the
        number of steps, so that each has its share of that. F is that of :meth:`StepSolver.slowed`.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # an error that is not finite rejects the step
            rule = solver.rule
            error = rule.error(start, end)
            slow = solver.resolved(error, end.dt)
            rest = error - slow
            inertia = float(rest @ (self.system.mass @ solver.slowed(rest, end.dt)))
            amplitude = np.sqrt(max(inertia, 0.0) / self.mass) / (4 * abs(rule.error_constant))
            return float(ADDING * self.size(slow) + 2 * amplitude * end.dt / span)
