"""Step control: how long the next step is, and whether the last one is good enough."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Protocol

from skancf.arguments import plain, whole
from skancf.errors import InputError, positive


@dataclass(frozen=True)
class Attempt:
    """A step that converged: its length and that of the run (s), its error, iterations, and energy without a source.

    Error and imbalance are relative: see :class:`LocalError` and :class:`EnergyBalance`.
    """

    dt: float
    span: float
    error: float
    iterations: int
    imbalance: float
    young: bool = False
    """Whether energies more than doubled in the step, so that there is nothing yet to compare the imbalance with."""
    total: float = float("inf")
    """The imbalance of the run so far, over the part of its length that is done."""


class StepControl(Protocol):
    """A policy that knows no mechanics."""

    @property
    def smallest(self) -> float:
        """A run stops when its step falls below this part of the first one."""

    def first(self, guess: float) -> float:
        """First step, from a guess that the initial acceleration gives."""

    def accepts(self, attempt: Attempt) -> bool:
        """Whether a step is good enough."""

    def next_step(self, attempt: Attempt) -> float:
        """Length of the step after this one."""


def _check(largest: float = float("inf"), **numbers: float) -> None:
    """InputError for numbers, and a longest step, that are not positive."""
    for name, value in numbers.items():
        positive(name, value, "s" if name == "dt" else "")
    if isinstance(largest, float) and not largest > 0:
        raise InputError(f"largest = {largest} s: give a step length greater than zero")
    if not (isinstance(largest, float) and largest == float("inf")):
        positive("largest", largest, "s")


@dataclass(frozen=True)
class FixedStep:
    """Always the same step; halved while Newton's method fails.

    Parameters
    ----------
    dt : float
        Step (s).
    smallest : float
        A run stops when its step falls below this part of ``dt``.
    """

    dt: float
    smallest: float = 1e-6

    def __post_init__(self) -> None:
        plain(self)
        _check(dt=self.dt, smallest=self.smallest)

    def first(self, guess: float) -> float:
        return self.dt

    def accepts(self, attempt: Attempt) -> bool:
        return True

    def next_step(self, attempt: Attempt) -> float:
        return min(self.dt, 2 * attempt.dt)


def _changed(dt: float, factor: float, largest: float) -> float:
    """A step is changed only where it pays, because the factors of the tangent belong to it."""
    if factor < 1:
        return dt * max(0.3, min(0.8, factor))
    return min(largest, dt * min(2.0, factor)) if factor > 1.25 else min(largest, dt)


@dataclass(frozen=True)
class _Limited(ABC):
    """What the three controls share: each step may cause its part of the asked error, by its share of the time."""

    rtol: float = 1e-3
    largest: float = float("inf")
    smallest: float = 1e-6

    def __post_init__(self) -> None:
        plain(self)
        _check(self.largest, rtol=self.rtol, smallest=self.smallest)

    def first(self, guess: float) -> float:
        return min(guess, self.largest)

    @abstractmethod
    def measured(self, attempt: Attempt) -> float:
        """What counts as the error of a step, relative."""

    def _over(self, attempt: Attempt) -> float:
        """Error of a step over what it may be; of order two in the step, since a shorter step may cause less."""
        return self.measured(attempt) * attempt.span / (self.rtol * attempt.dt)

    def accepts(self, attempt: Attempt) -> bool:
        return self._over(attempt) <= 1

    def next_step(self, attempt: Attempt) -> float:
        factor = 0.9 * max(self._over(attempt), 1e-30) ** -0.5
        return _changed(attempt.dt, min(factor, 0.9) if self._over(attempt) > 1 else max(factor, 1.0), self.largest)


PARTLY = 0.6
"""How much of the steps' errors adds up: those of an oscillation have both signs. Measured on motions of several kinds."""


@dataclass(frozen=True)
class LocalError(_Limited):
    r"""Steps whose errors add up to ``rtol`` of the displacement over the run.

    A step of length :math:`\Delta t` in a run of length T may cause the error :math:`r\,\Delta t / T`. The error of a step
    is :math:`c\,\Delta t^3 |\dddot q|` with the constant of the rule, without the part that the step does not resolve; it is
    the mass-weighted root mean square over the plate, relative to the largest displacement so far plus the thickness.

    Parameters
    ----------
    rtol : float
        Asked error at the end of the run.
    largest : float
        Longest step (s).
    smallest : float
        A run stops when its step falls below this part of the first guess.

    References
    ----------
    O. C. Zienkiewicz and Y. M. Xie, A simple error estimator and adaptive time stepping procedure for dynamic analysis,
    Earthquake Eng. Struct. Dyn. 20 (1991) 871-887.
    """

    def measured(self, attempt: Attempt) -> float:
        return PARTLY * attempt.error


@dataclass(frozen=True)
class EnergyBalance(_Limited):
    """Steps whose energy without a source adds up to ``rtol`` of the largest energy over the run.

    For rules that do not keep energy themselves; :class:`~skancf.EnergyMomentum` balances at any step, right or wrong. With
    :class:`~skancf.GeneralizedAlpha`, whose accelerations belong to other times than its states, less than about a hundredth
    cannot always be kept, whatever the step: the run stops and says so.

    Parameters
    ----------
    rtol : float
        Asked part of the energy, gained or lost by the integration until the end of the run.
    largest, smallest : float
        As for :class:`LocalError`.
    """

    def measured(self, attempt: Attempt) -> float:
        return abs(attempt.imbalance)

    def accepts(self, attempt: Attempt) -> bool:
        # What one step loses and the next one gains back adds up to nothing, and no shorter step may lose less.
        return attempt.young or abs(attempt.total) <= self.rtol or super().accepts(attempt)

    def next_step(self, attempt: Attempt) -> float:
        return attempt.dt if self._over(attempt) > 1 and self.accepts(attempt) else super().next_step(attempt)


@dataclass(frozen=True)
class NewtonCount:
    """Steps that take a number of Newton iterations: for runs in which speed counts and the error is looked at otherwise.

    Parameters
    ----------
    dt : float
        First step (s).
    iterations : int
        Aimed at; steps grow where they take fewer and shrink where they take more.
    largest : float
        Longest step (s).
    smallest : float
        A run stops when its step falls below this part of ``dt``.
    """

    dt: float
    iterations: int = 5
    largest: float = float("inf")
    smallest: float = 1e-6

    def __post_init__(self) -> None:
        plain(self)
        _check(self.largest, dt=self.dt, smallest=self.smallest)
        whole("iterations", self.iterations)

    def first(self, guess: float) -> float:
        return min(self.dt, self.largest)

    def accepts(self, attempt: Attempt) -> bool:
        return True

    def next_step(self, attempt: Attempt) -> float:
        return _changed(attempt.dt, (self.iterations / max(attempt.iterations, 1)) ** 0.5, self.largest)
