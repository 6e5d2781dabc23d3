"""States at output times and quantities at every step, as they come."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from skancf.assembly.system import System
from skancf.dynamics.motion import Stretch, hermite
from skancf.dynamics.state import State
from skancf.solution import Solution

Quantity = Callable[[Solution], Any]


class Recorder:
    """Keeps the states at ``times`` and the ``quantities``.

    Every stretch of the run also keeps its first and its last state, so that times between outputs can be interpolated.
    """

    def __init__(self, times: np.ndarray, quantities: Mapping[str, Quantity]):
        self.times, self.quantities = times, quantities
        self.slack = 1e-9 * (times[-1] - times[0] + 1e-300)
        self.done = 0
        self.finished: list[Stretch] = []
        self.system: System
        self.knots: list[tuple[float, np.ndarray, np.ndarray, bool]] = []
        self.record_times: list[float] = []
        self.values: dict[str, list[Any]] = {name: [] for name in quantities}

    def begin(self, system: System, state: State) -> None:
        """A new stretch, on a mesh or after a jump."""
        self.system = system
        due = self._due(state.time)
        self.knots = [(state.time, state.q, state.v, due)]
        self.done += due

    def _due(self, time: float) -> bool:
        return self.done < len(self.times) and self.times[self.done] <= time + self.slack

    def step(self, start: State, end: State) -> None:
        """The states at output times of a step."""
        while self._due(end.time):
            t = float(self.times[self.done])
            q, v = end.q, end.v
            if t < end.time - self.slack:
                q, v = hermite(t, np.array([start.time, end.time]), np.array([start.q, end.q]), np.array([start.v, end.v]))
            self.knots.append((t, q, v, True))
            self.done += 1

    def keep(self, state: State) -> None:
        """The quantities of an accepted state."""
        self.record_times.append(state.time)
        for name, quantity in self.quantities.items():
            self.values[name].append(quantity(Solution(self.system, state.q, state.v, state.time)))

    def mark(self) -> tuple[int, int, int, int]:
        """What :meth:`rewind` goes back to, in the present stretch."""
        return self.done, len(self.finished), len(self.knots), len(self.record_times)

    def rewind(self, mark: tuple[int, int, int, int]) -> None:
        """Forget what was kept since a mark."""
        self.done, _, n_knots, n = mark
        del self.knots[n_knots:], self.record_times[n:]
        for values in self.values.values():
            del values[n:]

    def end(self, state: State) -> None:
        """Closes a stretch with its last state."""
        if self.knots and state.time > self.knots[-1][0] + self.slack:
            self.knots.append((state.time, state.q, state.v, False))
        if part := self.present():
            self.finished.append(part)
        self.knots = []

    def present(self) -> Stretch | None:
        """The stretch so far."""
        if not self.knots:
            return None
        times, q, v, outputs = (np.array(column) for column in zip(*self.knots, strict=True))
        return Stretch(self.system, times, q, v, outputs)

    @property
    def records(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        n = min([len(self.record_times), *(len(values) for values in self.values.values())])
        return {name: (np.array(self.record_times[:n]), np.array(values[:n])) for name, values in self.values.items()}
