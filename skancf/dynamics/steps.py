"""Step control: how long the next step is, and whether the last one is good enough."""

from dataclasses import dataclass

from skancf.errors import InputError, positive


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
        positive("dt", self.dt, "s")
        positive("smallest", self.smallest)

    def first(self, guess: float) -> float:
        """First step, from a guess that the initial acceleration gives."""
        return self.dt

    def accepts(self, error: float) -> bool:
        """Whether a step with this local error is good enough."""
        return True

    def next_step(self, dt: float, error: float) -> float:
        """Length of the step after one of length dt with this local error."""
        return min(self.dt, 2 * dt)


@dataclass(frozen=True)
class LocalError:
    """Steps whose estimated local error is ``rtol`` of the displacement.

    The error is the mass-weighted root mean square over the plate, relative to the largest displacement so far plus the
    thickness. A step is changed only where it pays, because the factors of the tangent belong to it.

    Parameters
    ----------
    rtol : float
        Tolerance of each step.
    largest : float
        Longest step (s).
    smallest : float
        A run stops when its step falls below this part of the first guess.
    """

    rtol: float = 1e-4
    largest: float = float("inf")
    smallest: float = 1e-6

    def __post_init__(self) -> None:
        positive("rtol", self.rtol)
        positive("smallest", self.smallest)
        if not self.largest > 0:
            raise InputError(f"largest = {self.largest} s: give a step length greater than zero")

    def first(self, guess: float) -> float:
        """First step, from a guess that the initial acceleration gives."""
        return min(guess, self.largest)

    def accepts(self, error: float) -> bool:
        """Whether a step with this local error is good enough."""
        return error <= self.rtol

    def next_step(self, dt: float, error: float) -> float:
        """Length of the step after one of length dt with this local error."""
        factor = 0.9 * (self.rtol / max(error, 1e-30)) ** (1 / 3)
        if error > self.rtol:
            return dt * max(0.3, min(0.8, factor))
        return min(self.largest, dt * min(2.0, factor)) if factor > 1.25 else dt
