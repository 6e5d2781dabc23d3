"""What a quantity of interest knows."""

from abc import ABC, abstractmethod
from typing import Protocol

import numpy as np

from skancf.solution import Solution
from skancf.states import StateLike, solution_of


class Quantity(Protocol):
    """A number J(q) of a state, and how it changes with the nodal coordinates.

    A quantity that is a residual on held coordinates also has ``lift(state)``, the field (n_dofs,) that it multiplies there.
    One that may be zero may have ``scale(state)``, a size to compare it with. One that depends on the multipliers of
    conditions has ``by_multipliers(state)``, its derivative with respect to them.

    For a small-deflection answer both are of first order about the undeformed state, as its fields are: the gradient is
    the one there, and the value the one there plus its product with the change. (The strain energy is of second order.)

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> class Stretch:
    ...     unit = "m"
    ...     def __init__(self):
    ...         self.end = sk.Displacement(at=(1.0, 0.05), direction=(1.0, 0.0, 0.0))
    ...     def value(self, state):
    ...         return self.end.value(state)
    ...     def gradient(self, state):
    ...         return self.end.gradient(state)
    >>> print(sk.adapt(strip, Stretch(), rtol=1e-2, theory="kirchhoff").unit)
    m
    """

    @property
    def unit(self) -> str:
        """SI unit of the value."""

    def value(self, state: Solution) -> float:
        """J of a state."""

    def gradient(self, state: Solution) -> np.ndarray:
        r""":math:`\partial J / \partial q`, (n_dofs,)."""


class Smooth(ABC):
    """A quantity that is a smooth function of the nodal coordinates, given by :meth:`_value` and :meth:`_gradient`."""

    def value(self, state: StateLike) -> float:
        """J of a state."""
        state = solution_of("state", state)
        return float(state.model.value(
            lambda q: self._value(state, q), state.unknowns, lambda q, change: float(self._gradient(state, q) @ change)
        ))  # fmt: skip

    def gradient(self, state: StateLike) -> np.ndarray:
        r""":math:`\partial J / \partial q`, (n_dofs,)."""
        state = solution_of("state", state)
        return self._gradient(state, state.about)

    @abstractmethod
    def _value(self, state: Solution, q: np.ndarray) -> float:
        """With the loads and the time of a state, but nodal coordinates q."""

    @abstractmethod
    def _gradient(self, state: Solution, q: np.ndarray) -> np.ndarray:
        """Its derivative with respect to them."""
