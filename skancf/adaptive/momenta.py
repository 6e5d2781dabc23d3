r"""Momenta of a body as products with rigid velocities, and the velocities of least energy that have them.

With the rigid velocities :math:`G^T` of a body as it is now, :math:`p = G M v` are its momenta. Of all velocities that have
them, the one of least kinetic energy is :math:`M_{ff}^{-1} M G^T \lambda` where supports are at rest; that of a free body is
rigid. What a velocity has beyond it is without momentum, and the two kinetic energies add up.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from skancf.dynamics.initial import rigid_rates
from skancf.layout.layout import Layout
from skancf.system.system import System
from skancf.tolerances import DEPENDENT, ROUNDED_SUM


class Momenta:
    """The six momenta at nodal coordinates q of a system.

    Parameters
    ----------
    solve
        Forces to velocities, by the mass of free coordinates.
    """

    def __init__(self, system: System, q: np.ndarray, solve: Callable[[np.ndarray], np.ndarray]):
        self.system, self._solve = system, solve
        positions = system.layout.positions(q)
        self.centre = positions.mean(axis=0)
        self.size = float(np.abs(positions - self.centre).max())
        self._modes = self.rigid(system.layout, q)

    def rigid(self, layout: Layout, q: np.ndarray) -> np.ndarray:
        """Unit translations and, in units of this size, rotations about this centre of a body at q: (6, n_dofs)."""
        none, axes = np.zeros(3), np.eye(3)
        translations = [rigid_rates(q, axis, none, self.centre, layout.moving) for axis in axes]
        rotations = [rigid_rates(q, none, axis / self.size, self.centre, layout.moving) for axis in axes]
        return np.array(translations + rotations)

    def corrected(self, v: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """The velocity next to v in the mass norm that has the wanted momenta (6,)."""
        flow = self.system.mass @ v
        missing = wanted - self._modes @ flow
        if (np.abs(missing) <= ROUNDED_SUM * (np.abs(self._modes) @ np.abs(flow))).all():
            return v
        return v + self._least(missing)

    def slowed(self, v: np.ndarray, allowed: float) -> tuple[np.ndarray, float]:
        """The velocity with the kinetic energy that is allowed, the deforming part made smaller, and its factor."""
        if self.system.kinetic_energy(v) <= allowed:
            return v, 1.0
        held = self.system.constraints.fixed_part(v)
        if held.any():
            held = held - self._solve(self.system.mass @ held)
        least = held + self._least(self._modes @ (self.system.mass @ (v - held)))
        deforming = v - least
        energy = self.system.kinetic_energy(deforming)
        left = allowed - self.system.kinetic_energy(least)
        factor = float(np.sqrt(np.clip(left / energy, 0.0, 1.0))) if energy > 0 else 0.0
        return least + factor * deforming, factor

    def _least(self, momenta: np.ndarray) -> np.ndarray:
        """The velocity of least energy with these momenta, where supports are at rest."""
        multipliers = np.linalg.lstsq(self._gram, momenta, rcond=DEPENDENT)[0]
        return np.asarray(multipliers @ self._lightest)

    @cached_property
    def _lightest(self) -> np.ndarray:
        """Velocities of least energy, one for each momentum, (6, n_dofs)."""
        if not (self.system.constraints.fixed.any() or self.system.conditions):
            return self._modes
        return np.array([self._solve(self.system.mass @ mode) for mode in self._modes])

    @cached_property
    def _gram(self) -> np.ndarray:
        return np.array([self._modes @ (self.system.mass @ v) for v in self._lightest])
