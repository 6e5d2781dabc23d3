"""What a run in time leaves behind."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from skancf.assembly.system import System
from skancf.errors import DidNotConverge, InputError, number
from skancf.solution import Solution, probe


class MotionStatus(Enum):
    """How a run ended."""

    FINISHED = "finished"
    STEP_TOO_SMALL = "the step became too small"
    FAILED = "an error on the way"
    INTERRUPTED = "interrupted from the keyboard"


@dataclass(frozen=True)
class Step:
    """One attempted step: its end and length (s), error, Newton iterations, factorisations, accepted or not."""

    time: float
    dt: float
    error: float
    iterations: int
    factorisations: int
    accepted: bool


@dataclass(frozen=True)
class Motion:
    """States over time, as far as the run came.

    Attributes
    ----------
    times : (n,) array
        Output times (s).
    q, v : (n, n_dofs) arrays
        Nodal coordinates and their rates.
    steps : tuple of Step
        Every attempted step.
    records : dict of name to (times, values)
        The quantities asked for, at every accepted step.
    seconds : float
        Wall time.
    """

    system: System
    times: np.ndarray
    q: np.ndarray
    v: np.ndarray
    steps: tuple[Step, ...]
    records: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    status: MotionStatus = MotionStatus.FINISHED
    message: str = ""
    seconds: float = 0.0

    @property
    def finished(self) -> bool:
        return self.status is MotionStatus.FINISHED

    @property
    def iterations(self) -> int:
        """Newton iterations, those of rejected steps included."""
        return sum(step.iterations for step in self.steps)

    def unwrap(self) -> "Motion":
        """The motion, or :class:`~skancf.DidNotConverge` if it did not reach its end."""
        if not self.finished:
            raise DidNotConverge(self.message)
        return self

    def at(self, time: float) -> Solution:
        """State at any time, by cubic interpolation between output times."""
        t = number("time", time)
        if not self.times[0] <= t <= self.times[-1]:
            raise InputError(f"time = {t} s: the motion is known from {self.times[0]} to {self.times[-1]} s")
        k = min(int(np.searchsorted(self.times, t, side="right")) - 1, len(self.times) - 2)
        if k < 0:
            return Solution(self.system, self.q[0], self.v[0], t)
        q, v = hermite(t, self.times[k : k + 2], self.q[k : k + 2], self.v[k : k + 2])
        return Solution(self.system, q, v, t)

    @property
    def states(self) -> Iterator[Solution]:
        """The states at the output times."""
        for t, q, v in zip(self.times, self.q, self.v, strict=True):
            yield Solution(self.system, q, v, float(t))

    def displacement(self, at: Any, z: float = 0.0) -> np.ndarray:
        """Displacement of one point of the parameter plane at the output times, (n, 3)."""
        if z:
            return np.array([state.displacement(at, z) for state in self.states])
        point = probe(self.system, at)
        change = (self.q - self.system.undeformed).reshape(len(self.q), -1, 3)
        return np.einsum("p,tpi->ti", point.data, change[:, point.indices])

    def history(self, quantity: Callable[[Solution], Any]) -> np.ndarray:
        """A quantity of each state at the output times, (n, ...)."""
        return np.array([quantity(state) for state in self.states])


def hermite(t: float, times: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cubic interpolation of q and its rate between two times with values (2, ...) and rates (2, ...)."""
    dt = times[1] - times[0]
    s = (t - times[0]) / dt
    value = ((1 - s) ** 2 * (1 + 2 * s), s**2 * (3 - 2 * s), s * (1 - s) ** 2 * dt, s**2 * (s - 1) * dt)
    slope = (6 * s * (s - 1) / dt, 6 * s * (1 - s) / dt, (1 - s) * (1 - 3 * s), s * (3 * s - 2))
    return tuple(w[0] * q[0] + w[1] * q[1] + w[2] * v[0] + w[3] * v[1] for w in (value, slope))
