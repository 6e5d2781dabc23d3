"""What steps miss of functions of time: a rule takes a load at one time of a step, and a prescribed motion at its ends."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from skancf.system.system import System

SAMPLES = 4096
"""Times in a run at which a function is looked at; a pulse between two of them is not seen."""
LEAST = 9
"""Times in a step at which it is looked at, both ends included."""
INSIDE = 1e-6
"""Of a step: so far from its ends they are looked at, since a function that jumps there has the value of the other side."""


class Missed(NamedTuple):
    """What a step misses of the integral of a function of time, that of its size over the step, and over the run (s)."""

    missed: float
    here: float
    whole: float


class LoadImpulses:
    """The functions of time of all loads and prescribed motions of a system, over a run.

    Attributes
    ----------
    missed : (n,) array
        The sums of what accepted steps missed, of each function.
    """

    def __init__(self, system: System, begin: float, span: float):
        self.functions: Sequence[Callable[[float], Any]] = system.histories()
        self.span = span
        times = begin + span * (np.arange(SAMPLES) + 0.5) / SAMPLES
        self.whole = [span * float(np.abs(_values(h, times)).mean()) for h in self.functions]
        self.missed = np.zeros(len(self.functions))

    def state(self) -> dict[str, Any]:
        return {"missed": self.missed}

    def restore(self, state: dict[str, Any]) -> None:
        self.missed = state["missed"]

    def step(self, start: float, dt: float) -> tuple[Missed, ...]:
        """What a step from a time on misses of each: the value in its middle is taken for the mean."""
        n = max(LEAST, int(SAMPLES * dt / self.span) + 2)
        parts = np.linspace(0, 1, n)
        parts[[0, -1]] = INSIDE, 1 - INSIDE
        times = np.append(start + dt * parts, start + 0.5 * dt)
        weights = np.full(n, 1 / (n - 1))
        weights[[0, -1]] *= 0.5
        out = []
        for function, whole in zip(self.functions, self.whole, strict=True):
            values = _values(function, times)
            mean, size = weights @ values[:-1], weights @ np.abs(values[:-1])
            out.append(Missed(dt * float(abs(mean - values[-1])), dt * float(size), whole))
        return tuple(out)

    def add(self, step: tuple[Missed, ...]) -> None:
        """Count what an accepted step missed."""
        self.missed = self.missed + [part.missed for part in step]

    @property
    def part(self) -> float:
        """The largest part of a function's integral that was missed."""
        parts = [m / whole for m, whole in zip(self.missed.tolist(), self.whole, strict=True) if whole > 0]
        return max(parts, default=0.0)


def _values(function: Callable[[float], Any], times: np.ndarray) -> np.ndarray:
    return np.array([_tried(function, t) for t in times.tolist()])


def _tried(function: Callable[[float], Any], time: float) -> float:
    """Zero where the function has no value, which is found out when the run gets there, or is the path of a load."""
    try:
        value = float(function(time))
    except Exception:  # whatever a user's function raises
        return 0.0
    return value if np.isfinite(value) else 0.0
