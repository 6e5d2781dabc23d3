r"""What every rule of integration has: one set of equations for the increment :math:`u = q_{n+1} - q_n`.

.. math:: M\,a(u) + D\,v(u) + f_{int}(u) = f_{ext}(u)

with the accelerations and rates of the rule, linear in u, and the forces where it takes them.
"""

from abc import ABC, abstractmethod

import numpy as np
import scipy.sparse as sp

from skancf.conditions.sums import Conditions
from skancf.dynamics.state import State
from skancf.history import Case
from skancf.linear import BlockMatrix
from skancf.system.system import System
from skancf.terms.shell import Shell


class Rule(ABC):
    """A rule of integration. Forces are taken at one state, at the fraction ``stage`` of the step, unless overridden."""

    stage: float
    symmetric = True
    """Whether the stiffness is all of the derivative, but for loads that follow."""
    newton_rtol = 1e-5
    """How far Newton's method goes, in the energy norm, where a user does not say it."""
    balance = 0.1
    """Part of the energy that a run may gain or lose without a source, where a user does not say it."""

    @property
    @abstractmethod
    def error_constant(self) -> float:
        """c of the error of a step, :math:`c\\,\\Delta t^3 \\dddot q`."""

    @abstractmethod
    def mass_factor(self, dt: float) -> float:
        """Derivative of the accelerations with respect to u."""

    @abstractmethod
    def damping_factor(self, dt: float) -> float:
        """Derivative of the rates with respect to u."""

    @abstractmethod
    def acceleration(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Accelerations that the mass multiplies."""

    @abstractmethod
    def rate(self, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Rates that the damping multiplies."""

    @abstractmethod
    def end(self, u: np.ndarray, start: State, dt: float) -> State:
        """The state at the end of the step."""

    @abstractmethod
    def jerk(self, start: State, end: State) -> np.ndarray:
        """Third derivative over a step."""

    def error(self, start: State, end: State) -> np.ndarray:
        """Estimate of the error that a step adds, for every coordinate."""
        return abs(self.error_constant) * end.dt**3 * self.jerk(start, end)

    def at_stage(self, u: np.ndarray, start: State, dt: float) -> tuple[np.ndarray, float]:
        """State and time at which external forces are taken."""
        return start.q + self.stage * u, start.time + self.stage * dt

    def tangent_at(self, u: np.ndarray, start: State) -> tuple[np.ndarray, np.ndarray]:
        """States to which the rows and the columns of the derivative of the internal force belong, (n_dofs,) each."""
        at = start.q + self.stage * u
        return at, at

    def gradient(self, conditions: Conditions, u: np.ndarray, start: State, dt: float) -> sp.csr_matrix:
        """That of conditions with which their multipliers act, (n, n_dofs); they are met at the end of the step."""
        return conditions.gradient(self.at_stage(u, start, dt)[0])

    def stresses(
        self, system: System, u: np.ndarray, start: State, dt: float, change: np.ndarray | None = None
    ) -> np.ndarray:
        r"""Stresses with those of the material's damping, :math:`C\,(\varepsilon + \beta\,\dot\varepsilon)`.

        Extrapolated linearly along a ``change`` of u if one is given.
        """
        along = None if change is None else self.stage * change
        at, time = self.at_stage(u, start, dt)
        if not system.shell.retardation:
            return system.stresses(at, along, Case(time=time))
        rate = self.rate(u if change is None else u + change, start, dt)
        return system.shell.stresses_with_rate(at, along, rate, Case(time=time))

    def viscous_stresses(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """The part of them that the material's damping makes."""
        at, time = self.at_stage(u, start, dt)
        return self.stresses(system, u, start, dt) - system.stresses(at, None, Case(time=time))

    def numerical_stresses(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray | None:
        """The part of them that takes energy out of what the steps do not resolve, if the rule has one."""
        return None

    def force_of(self, shell: Shell, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> np.ndarray:
        """Internal force of given stresses of the shell."""
        return shell.force_of(self.at_stage(u, start, dt)[0], stresses)

    def others_force(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Force of the other terms of the structure."""
        at, time = self.at_stage(u, start, dt)
        return system.others.force(at, self.rate(u, start, dt), Case(time=time))

    def internal_force(self, system: System, u: np.ndarray, start: State, dt: float) -> np.ndarray:
        """Internal force, less that of initial stresses."""
        at, time = self.at_stage(u, start, dt)
        if system.shell.retardation:
            force = self.force_of(system.shell, u, start, dt, self.stresses(system, u, start, dt))
        else:
            force = system.shell.internal_force(at, Case(time=time))
        initial = system.shell.initial_stress_force(at, Case(time=time))
        force = force if initial is None else force - initial
        return force + self.others_force(system, u, start, dt) if system.others else force

    def stiffness(self, system: System, u: np.ndarray, start: State, dt: float, stresses: np.ndarray) -> BlockMatrix:
        """Derivative of the internal less the external force with respect to u, its symmetric part, with given stresses."""
        at, time = self.at_stage(u, start, dt)
        stiffer = 1 + system.shell.retardation * self.damping_factor(dt) / self.stage
        tangent = system.tangent(at, Case(time=time), stresses, stiffer, self.rate(u, start, dt))
        tangent.values[:] *= self.stage
        return tangent
