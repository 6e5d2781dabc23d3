"""The energy-momentum rule."""

from dataclasses import dataclass

import numpy as np

from skancf.assembly.system import System
from skancf.dynamics.midpoint import ImplicitMidpoint
from skancf.dynamics.state import State
from skancf.linear import BlockMatrix

NEARLY = 0.75
"""Fraction of the step at which the tangent is taken: its symmetric part is then right to second order."""


@dataclass(frozen=True)
class EnergyMomentum(ImplicitMidpoint):
    r"""The midpoint rule with an internal force that does the work of the mean stress exactly.

    .. math::
        M \frac{v_{n+1} - v_n}{\Delta t} + D\varepsilon^T\, \tfrac12 (S_n + S_{n+1}) = f_{ext}(q_{1/2}, t_{1/2}), \qquad
        D\varepsilon \cdot u = \varepsilon_{n+1} - \varepsilon_n

    So energy, linear and angular momentum are kept to what Newton's method leaves, at any step. In theory `full` strains
    are quadratic in q and :math:`D\varepsilon` is their gradient at the middle; in `kirchhoff` it is the
    :func:`~skancf.theories.kirchhoff_point.discrete_gradient` at each integration point. What steps do not resolve is kept
    too, and may make Newton's method need shorter steps: a little damping of the material helps.

    References
    ----------
    J. C. Simo and N. Tarnow, The discrete energy-momentum method, ZAMP 43 (1992) 757-792.
    """

    symmetric = False

    def stresses(
        self, system: System, u: np.ndarray, start: State, dt: float, change: np.ndarray | None = None
    ) -> np.ndarray:
        r"""Mean stresses, and those of the material's damping, :math:`\beta\,(S_{n+1} - S_n) / \Delta t`."""
        before, after = _at_start(system, start), system.stresses(start.q + u, change)
        damping = system.retardation / dt
        return (0.5 - damping) * before + (0.5 + damping) * after

    def viscous_stresses(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        return system.retardation / dt * (system.stresses(start.q + u) - _at_start(system, start))

    def force_of(self, system: System, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> np.ndarray:
        return system.force_between(start.q, start.q + u, stresses)

    def internal_force(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        stresses, held = self.stresses(system, u, start, dt), system.held_back(start.time)
        if held is not None:
            stresses = stresses - 0.5 * (held + system.held_back(start.time + dt))
        return self.force_of(system, u, start, dt, stresses)

    def stiffness(
        self, system: System, u: np.ndarray, start: State, dt: float, stresses: np.ndarray
    ) -> BlockMatrix:
        stiffer = 1 + 2 * system.retardation / dt
        at, time = start.q + NEARLY * u, start.time + 0.5 * dt
        tangent = system.tangent(at, stresses, time, stiffer=stiffer)
        tangent.values[:] *= 0.5
        return tangent


def _at_start(system: System, start: State) -> np.ndarray:
    if "stresses" not in start.kept:
        start.kept["stresses"] = system.stresses(start.q)
    return start.kept["stresses"]
