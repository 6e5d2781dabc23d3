"""A system at large changes, and to first order in small ones about its undeformed state: two models, asked alike."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.history import FULL, Case
from skancf.linear import BlockMatrix
from skancf.system.system import System
from skancf.system.unstressed import derivative, of_change
from skancf.terms.shell import is_heated

STEP = 1e-5
"""Of a difference, relative to the size of the body: its square, and rounding over it, are small."""
Value = Callable[[np.ndarray], Any]
"""Of unknowns q."""
Rate = Callable[[np.ndarray, np.ndarray], Any]
"""Its derivative at q along a change."""


class Model(ABC):
    """What is asked of a system at a state, in unknowns x that are those of the model.

    Parameters
    ----------
    system : System
    """

    linear: bool
    """Whether forces are linear in x."""

    def __init__(self, system: System) -> None:
        self.system = system

    @abstractmethod
    def about(self, x: np.ndarray) -> np.ndarray:
        """The unknowns q of the system about which further changes are small, (n_dofs,)."""

    @abstractmethod
    def q(self, x: np.ndarray) -> np.ndarray:
        """The unknowns of the system, (n_dofs,)."""

    @abstractmethod
    def change(self, x: np.ndarray) -> np.ndarray:
        """Their change from the undeformed state, (n_dofs,)."""

    @abstractmethod
    def held(self, factor: float) -> np.ndarray:
        """What supports prescribe of x, (n_dofs,)."""

    @abstractmethod
    def internal_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """As :meth:`System.internal_force`."""

    @abstractmethod
    def external_force(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        """As :meth:`System.external_force`."""

    @abstractmethod
    def others_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """As :meth:`System.others_force`."""

    def conditions_force(self, x: np.ndarray, multipliers: np.ndarray | None) -> np.ndarray:
        """Of the conditions, on the left side of the equations, (n_dofs,); zero without multipliers."""
        if multipliers is None or not self.system.conditions:
            return np.zeros(self.system.n_dofs)
        return self.system.conditions.force(self.about(x), multipliers)

    def support_force(self, x: np.ndarray, case: Case, multipliers: np.ndarray | None) -> np.ndarray:
        """What supports exert in a state of rest, springs included, (n_dofs,)."""
        residual = self.internal_force(x) - self.external_force(x, case)
        if self.system.conditions:
            residual = residual + self.conditions_force(x, multipliers)
        support = self.system.constraints.fixed_part(residual)
        return support - self.others_force(x, None, case) if self.system.others else support

    @abstractmethod
    def conditions_value(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        """Values of the conditions, (n,)."""

    @abstractmethod
    def tangent(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        """Symmetric part of the derivative of the residual."""

    @abstractmethod
    def skew(self, x: np.ndarray, case: Case = FULL) -> sp.csr_matrix | None:
        """Skew part of it, or None."""

    @abstractmethod
    def elastic(self, x: np.ndarray) -> BlockMatrix:
        """The part of the tangent that stresses and loads have not."""

    @abstractmethod
    def prestressed(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        """The tangent for vibrations about x, with its stresses and the loads' own part."""

    @abstractmethod
    def strain_energy(self, x: np.ndarray, case: Case = FULL) -> float:
        """As :meth:`System.strain_energy` (J)."""

    @abstractmethod
    def work(self, x: np.ndarray, case: Case = FULL) -> float:
        """Of the loads on the displacements (J)."""

    @abstractmethod
    def strained(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Strains and stresses with their weights, (n_elements, n_strains, n_points) each."""

    @abstractmethod
    def value(self, value: Value, x: np.ndarray, rate: Rate | None = None) -> Any:
        """A quantity; without its rate it must be one of complex coordinates too."""

    @abstractmethod
    def rise(self, value: Value, x: np.ndarray, rate: Rate) -> Any:
        """What a quantity is more than in the undeformed state."""

    @abstractmethod
    def turn(self, vectors: Value, x: np.ndarray, rate: Rate) -> np.ndarray:
        """Angles (n,) between unit vectors (n, 3) and those of the undeformed state (rad)."""


class Exact(Model):
    """Any changes; its unknowns are those of the system."""

    linear = False

    def about(self, x: np.ndarray) -> np.ndarray:
        return x

    def q(self, x: np.ndarray) -> np.ndarray:
        return x

    def change(self, x: np.ndarray) -> np.ndarray:
        return x - self.system.undeformed

    def held(self, factor: float) -> np.ndarray:
        return self.system.undeformed + factor * self.system.prescribed()

    def internal_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        return self.system.internal_force(x, v, case)

    def external_force(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        return self.system.external_force(x, case)

    def others_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        return self.system.others.force(x, v, case)

    def conditions_value(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        return self.system.conditions.value(x, case)

    def tangent(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        return self.system.tangent(x, case)

    def skew(self, x: np.ndarray, case: Case = FULL) -> sp.csr_matrix | None:
        return self.system.skew(x, case)

    def elastic(self, x: np.ndarray) -> BlockMatrix:
        return self.system.tangent(x, Case(0.0), np.zeros_like(self.system.stresses(x)))

    def prestressed(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        return self.system.tangent(x, case)

    def strain_energy(self, x: np.ndarray, case: Case = FULL) -> float:
        return self.system.strain_energy(x, case)

    def work(self, x: np.ndarray, case: Case = FULL) -> float:
        return float(self.system.applied_force(x, case) @ self.change(x))

    def strained(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        strains, stresses = self.system.assembly.stresses(self.system.shell.nodal(x), None, keep_strains=True)
        return strains, stresses

    def value(self, value: Value, x: np.ndarray, rate: Rate | None = None) -> Any:
        return value(x)

    def rise(self, value: Value, x: np.ndarray, rate: Rate) -> Any:
        return value(x) - value(self.system.undeformed)

    def turn(self, vectors: Value, x: np.ndarray, rate: Rate) -> np.ndarray:
        before, now = vectors(self.system.undeformed), vectors(x)
        return np.arctan2(np.linalg.norm(np.cross(before, now), axis=1), (before * now).sum(axis=1))


class Linearised(Model):
    r"""First order in a small change u of the undeformed state, the unknowns; energies are quadratic,

    .. math:: f(u) = K u, \qquad U(u) = \tfrac12 u \cdot K u ,

    loads are those on the undeformed state, and any quantity is J(q_0) and its derivative along u. Of u alone all digits are
    kept, which the sum with positions has not.
    """

    linear = True

    def about(self, x: np.ndarray) -> np.ndarray:
        return self.system.undeformed

    def q(self, x: np.ndarray) -> np.ndarray:
        return self.system.undeformed + x

    def change(self, x: np.ndarray) -> np.ndarray:
        return x

    def held(self, factor: float) -> np.ndarray:
        return factor * self.system.prescribed()

    def internal_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """With what terms besides the shell have in the undeformed state."""
        force, others = self.system.stiffness() @ x, getattr(self.system, "others", None)
        if not others:
            return force
        force = force + others.force(self.system.undeformed, None, case)
        return force if self._skew is None else force + self._skew @ x

    def external_force(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        start, force = self.system.undeformed, self.system.external_force(self.system.undeformed)
        if is_heated(self.system):
            force = self.system.applied_force(start) + self.system.shell.initial_stress_force(start, FULL, small=True)
        return case.factor * force

    def others_force(self, x: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        force, springs = self.system.others.force(self.system.undeformed, None, case), self.system.foundation
        force = force if springs is None else force + springs @ x
        return force if self._skew is None else force + self._skew @ x

    @cached_property
    def _skew(self) -> sp.csr_matrix | None:
        """Of the structure's terms; loads are those on the undeformed state and have none."""
        others = getattr(self.system, "others", None)
        return others.skew(self.system.undeformed) if others else None

    def conditions_value(self, x: np.ndarray, case: Case = FULL) -> np.ndarray:
        """Without those at rest, which are rounding."""
        start, conditions = self.system.undeformed, self.system.conditions
        moved = conditions.value(start, case) - conditions.value(start, Case(0.0))
        return np.asarray(moved + conditions.gradient(start) @ x)

    def tangent(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        return self.system.stiffness()

    def skew(self, x: np.ndarray, case: Case = FULL) -> sp.csr_matrix | None:
        return self._skew

    def elastic(self, x: np.ndarray) -> BlockMatrix:
        return self.system.stiffness()

    def prestressed(self, x: np.ndarray, case: Case = FULL) -> BlockMatrix:
        return self.system.stiffness() + geometric_stiffness(self.system, x, case.factor)

    def strain_energy(self, x: np.ndarray, case: Case = FULL) -> float:
        start, shell, others = self.system.undeformed, self.system.shell, self.system.others
        force, energy = shell.initial_stress_force(start, case, small=True), self.system.stiffness().energy(x)
        energy += others.energy(start, case)
        energy += float(others.force(start, None, case) @ x)
        return energy if force is None else energy + shell.thermal_energy(case) - float(force @ x)

    def work(self, x: np.ndarray, case: Case = FULL) -> float:
        """Half of that of the whole loads, which grow with it."""
        return 0.5 * case.factor * float(self.system.applied_force(self.system.undeformed) @ x)

    def strained(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return of_change(self.system.shell, self.system.undeformed, x)

    def value(self, value: Value, x: np.ndarray, rate: Rate | None = None) -> Any:
        start = self.system.undeformed
        return value(start) + (derivative(value, start, x) if rate is None else rate(start, x))

    def rise(self, value: Value, x: np.ndarray, rate: Rate) -> Any:
        return rate(self.system.undeformed, x)

    def turn(self, vectors: Value, x: np.ndarray, rate: Rate) -> np.ndarray:
        start = self.system.undeformed
        return np.asarray(np.linalg.norm(np.cross(vectors(start), rate(start, x)), axis=1))


def geometric_stiffness(system: System, change: np.ndarray, load_factor: float = 1.0) -> BlockMatrix:
    """What the stresses of a linear answer, (n_dofs,), and its loads add to the stiffness of the undeformed state.

    The computed stresses of that state are rounding, and taken away. It is a difference of two matrices, in which what is
    small against the stiffness is lost to rounding. It is linear in the load, so that answer and load are scaled to the size
    of the body first.
    """
    start, size = system.undeformed, float(np.abs(change).max(initial=0.0))
    power = int(np.frexp(np.abs(start).max())[1] - np.frexp(size)[1]) if size else 0
    case, moved = Case(float(np.ldexp(load_factor, power))), np.ldexp(change, power)
    if is_heated(system):  # to first order
        cold = Case(0.0)
        stresses = system.stresses(start, moved, cold) - system.stresses(start, None, cold)
        initial = system.shell.initial_stresses(case, small=True)
        scaled, loads = system.tangent(start, cold, stresses - initial), system.loads.tangent(start, case)
        values = scaled.values - system.stiffness().values + (0.0 if loads is None else loads.values)
    else:
        scaled = system.tangent(start, case, system.stresses(start, moved) - system.stresses(start))
        values = scaled.values - system.stiffness().values
    if others := _change_of_others(system, np.ldexp(change, power)):
        values += others.values
    return BlockMatrix(scaled.pattern, np.ldexp(values, -power))


def _change_of_others(system: Any, change: np.ndarray) -> BlockMatrix | None:
    """Derivative of the tangent of terms besides the shell along a change of the size of the body, by differences."""
    start, others = system.undeformed, getattr(system, "others", None)
    if not others:
        return None
    after, before = (others.tangent(start + sign * STEP * change) for sign in (1.0, -1.0))
    if after is None or before is None:
        return None
    return BlockMatrix(after.pattern, (after.values - before.values) / (2 * STEP))
