"""Step control: how long the next step is, and whether the last one is good enough."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Protocol

from skancf.arguments import plain, whole
from skancf.dynamics.impulses import Missed
from skancf.errors import InputError, number, positive
from skancf.showing import short
from skancf.tolerances import ABOVE_ZERO


@dataclass(frozen=True)
class Attempt:
    """A step that converged.

    Attributes
    ----------
    dt, span : float
        Its length and that of the run (s).
    error : float
        What it adds to the error by the end of the run (m): see :class:`LocalError`.
    iterations : int
    motion, growth : float
        The largest displacement from the start of the run so far, that at its end included, and what it was less before (m).
    rounding : float
        The size that rounding of positions has (m).
    begins : bool
        Whether the motion has only begun, so that its error says nothing yet.
    impulses : tuple of Missed
        What it misses of the loads.
    hardest : float
        The largest of earlier steps' :meth:`StepControl.over`, which fades.
    imbalance, total : float
        Energy without a source, of the step and of the run so far over the part of its length that is done, relative.
    young : bool
        Whether energies more than doubled in the step, so that there is nothing yet to compare the imbalance with.
    """

    dt: float
    span: float
    error: float
    iterations: int
    motion: float = 0.0
    growth: float = 0.0
    rounding: float = 0.0
    begins: bool = False
    impulses: tuple[Missed, ...] = ()
    hardest: float = 0.0
    imbalance: float = 0.0
    young: bool = False
    total: float = float("inf")

    __repr__ = short


class StepControl(Protocol):
    """A policy that knows no mechanics."""

    @property
    def smallest(self) -> float:
        """A run stops when its step falls below this part of the first one."""

    def first(self, guess: float) -> float:
        """First step, from a guess: a fiftieth of the run."""

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

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, steps=sk.FixedStep(dt=2e-4), progress=False)
    >>> print(len(motion.steps))
    25
    """

    dt: float
    smallest: float = 1e-6

    __repr__ = short

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


FADING = 0.9
"""How much of a hard step is still thought of one step later: what a step may be swings with a vibration."""


@dataclass(frozen=True)
class _Limited(ABC):
    """What the controls of an error share: each step may cause its part of the asked one."""

    rtol: float = 1e-3
    largest: float = float("inf")
    smallest: float = 1e-6

    def __post_init__(self) -> None:
        plain(self)
        _check(self.largest, rtol=self.rtol, smallest=self.smallest)

    def first(self, guess: float) -> float:
        return min(guess, self.largest)

    @abstractmethod
    def over(self, attempt: Attempt) -> float:
        """Error of a step over what it may be; of order two in the step, since a shorter step may cause less."""

    def accepts(self, attempt: Attempt) -> bool:
        return self.over(attempt) <= 1

    def next_step(self, attempt: Attempt) -> float:
        over = self.over(attempt)
        if over > 1:
            return _changed(attempt.dt, min(0.9 * over**-0.5, 0.9), self.largest)
        hardest = max(over, FADING * attempt.hardest, ABOVE_ZERO)
        return _changed(attempt.dt, max(0.9 * hardest**-0.5, 1.0), self.largest)


BEGINNING = 1 / 25
"""Part of the run, times the third root of the asked error, that a step may last in which the motion only begins."""
NEGLIGIBLE = 0.05
"""Part of the asked error that a step may miss of a load at once: what jumps without a knot is found by no short step."""


@dataclass(frozen=True)
class LocalError(_Limited):
    r"""Steps whose errors add up to ``rtol`` of the largest displacement over the run.

    A step of length :math:`\Delta t` in a run of length T may add the error

    .. math:: \tfrac12 r\,[R\,\Delta t / T + (R - R_{old})] + a\,\Delta t / T

    where R is the largest displacement from the start of the run so far, so that the whole run may add :math:`r R + a`, and
    a motion that begins at rest has something to compare its errors with. It is a millionth of the displacement at the start
    at least, so that a state at rest is not taken for a motion. Nothing else has a scale: steps depend neither on
    the units, nor on how large a load is, nor, where nothing is held, on a common translation. What a step adds is

    .. math:: \frac{\pi}{2} |e_s| + 2 A \frac{\Delta t}{T},

    the part :math:`e_s` of the rule's error :math:`c\,\Delta t^3 \dddot q` that it resolves, and its share of the amplitude
    A of vibrations that it hardly resolves. Sizes are mass-weighted root mean squares over the plate.

    A load that grows from zero makes errors in its first steps that are a fixed part of the motion there, however short they
    are: such a step may last :math:`T \sqrt[3]{r} / 25`, so that its error is a small part of what comes later.

    What is missed of each function of time h of a load or a prescribed motion is controlled alike: a rule takes h in the
    middle of a step, and what that misses of its integral, :math:`\Delta t\,|h(t_{1/2}) - \bar h|`, may be
    :math:`\tfrac12 r\,[I\,\Delta t / T + \int_{\Delta t} |h|]`, with the integral I of :math:`|h|` over the run. So no
    pulse is stepped over that is longer than T / 4096.

    Parameters
    ----------
    rtol : float
        Asked error, relative to the largest displacement.
    largest : float
        Longest step (s).
    smallest : float
        A run stops when its step falls below this part of the first guess.
    atol : float
        Asked error (m) that is good enough however small the motion is.

    References
    ----------
    O. C. Zienkiewicz and Y. M. Xie, A simple error estimator and adaptive time stepping procedure for dynamic analysis,
    Earthquake Eng. Struct. Dyn. 20 (1991) 871-887.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, steps=sk.LocalError(atol=1e-5), rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    atol: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (number("atol", self.atol) >= 0):
            raise InputError(f"atol = {self.atol} m: an error is not negative")

    def over(self, attempt: Attempt) -> float:
        share = attempt.dt / attempt.span
        allowed = 0.5 * self.rtol * (attempt.motion * share + attempt.growth) + self.atol * share + attempt.rounding
        beginning = (share / BEGINNING) ** 2 * self.rtol ** (-2 / 3)  # of order three, of which nothing else is known
        error = beginning if attempt.begins else attempt.error / max(allowed, ABOVE_ZERO)
        return max([error, *(self._over_impulse(part, share) for part in attempt.impulses)])

    def _over_impulse(self, part: Missed, share: float) -> float:
        if part.missed <= NEGLIGIBLE * self.rtol * part.whole:
            return 0.0
        return part.missed / (0.5 * self.rtol * (part.whole * share + part.here))


@dataclass(frozen=True)
class EnergyBalance(_Limited):
    """Steps whose energy without a source adds up to ``rtol`` of the largest energy over the run.

    For rules that do not keep energy themselves; :class:`~skancf.EnergyMomentum` balances at any step, right or wrong. With
    :class:`~skancf.GeneralizedAlpha`, whose accelerations belong to other times than its states, less than a few hundredths
    cannot always be kept, whatever the step: the run stops and says so.

    Parameters
    ----------
    rtol : float
        Asked part of the energy, gained or lost by the integration until the end of the run.
    largest, smallest : float
        As for :class:`LocalError`.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> rule = sk.GeneralizedAlpha()
    >>> motion = sk.simulate(system, 0.002, steps=sk.EnergyBalance(), rule=rule, rtol=1e-2, progress=False)
    >>> print(motion.status.value)
    finished
    """

    def over(self, attempt: Attempt) -> float:
        return abs(attempt.imbalance) * attempt.span / (self.rtol * attempt.dt)

    def accepts(self, attempt: Attempt) -> bool:
        # What one step loses and the next one gains back adds up to nothing, and no shorter step may lose less.
        return attempt.young or abs(attempt.total) <= self.rtol or super().accepts(attempt)

    def next_step(self, attempt: Attempt) -> float:
        return attempt.dt if self.over(attempt) > 1 and self.accepts(attempt) else super().next_step(attempt)


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

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, steps=sk.NewtonCount(dt=1e-4), progress=False)
    >>> print(motion.status.value)
    finished
    """

    dt: float
    iterations: int = 5
    largest: float = float("inf")
    smallest: float = 1e-6

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        _check(self.largest, dt=self.dt, smallest=self.smallest)
        whole("iterations", self.iterations)

    def first(self, guess: float) -> float:
        return min(self.dt, self.largest)

    def accepts(self, attempt: Attempt) -> bool:
        return True

    def next_step(self, attempt: Attempt) -> float:
        return _changed(attempt.dt, self.iterations / max(attempt.iterations, 1), self.largest)
