"""States at output times and quantities at every step, as they come."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from skancf.dynamics.between import Between
from skancf.dynamics.motion import Stretch
from skancf.dynamics.state import State
from skancf.functions import called
from skancf.solution import Solution
from skancf.system.system import System

Quantity = Callable[[Solution], Any]


class Knot(NamedTuple):
    """A kept state, the stretch of the run in which it lies, and whether it is one at an output time."""

    stretch: int
    time: float
    q: np.ndarray
    v: np.ndarray
    output: bool


class Recorder:
    """Keeps the states at ``times``, or at the ends of all steps, and the ``quantities``.

    Every stretch of the run, on one mesh and without a jump, also keeps its first and its last state, so that times between
    outputs can be interpolated.
    """

    def __init__(self, times: np.ndarray | None, quantities: Mapping[str, Quantity]):
        self.every = times is None
        self.times, self.quantities = np.zeros(1) if times is None else times, quantities
        self.slack = 1e-9 * (self.times[-1] - self.times[0] + 1e-300)
        self.done = 0
        self.systems: list[System] = []
        self.knots: list[Knot] = []
        self.record_times: list[float] = []
        self.values: dict[str, list[Any]] = {name: [] for name in quantities}

    @property
    def asked(self) -> list[float] | str:
        """The output times, or "steps"."""
        return "steps" if self.every else self.times.tolist()

    def begin(self, system: System, state: State) -> None:
        """A new stretch, on a mesh or after a jump."""
        self.systems.append(system)
        due = self._due(state.time)
        self.done += due
        due = self.replace_output(len(self.systems) - 1, state.time) or due
        self._add(state.time, state.q, state.v, due)

    def replace_output(self, stretch: int, time: float) -> bool:
        """At the time of an event the output is the state after it: whether there is one before it that no longer counts."""
        last = self.knots[-1] if self.knots else None
        if last is None or last.stretch == stretch or not last.output or last.time != time:
            return False
        self.knots[-1] = last._replace(output=False)
        return True

    def _add(self, time: float, q: np.ndarray, v: np.ndarray, output: bool) -> None:
        self.knots.append(Knot(len(self.systems) - 1, time, q, v, output))

    def _due(self, time: float) -> bool:
        return self.every or (self.done < len(self.times) and bool(self.times[self.done] <= time + self.slack))

    def step(self, start: State, end: State) -> None:
        """The states at output times of a step."""
        if self.every:
            self._add(end.time, end.q, end.v, True)
            return
        while self._due(end.time):
            t = float(self.times[self.done])
            q, v = end.q, end.v
            if t < end.time - self.slack:
                q, v = Between(self.systems[-1].layout, self.systems[-1].constraints).inside(t, start, end)
            self._add(t, q, v, True)
            self.done += 1

    def keep(self, state: State) -> None:
        """The quantities of an accepted state."""
        self.record_times.append(state.time)
        for name, quantity in self.quantities.items():
            seen = Solution(self.systems[-1], state.q.copy(), state.v.copy(), state.time)
            self.values[name].append(called(f"record[{name!r}]", quantity, seen))

    def end(self, state: State) -> None:
        """Closes a stretch with its last state."""
        if state.time > self.knots[-1].time + self.slack:
            self._add(state.time, state.q, state.v, False)

    def mark(self) -> tuple[int, int, int]:
        """What :meth:`rewind` goes back to, in the present stretch."""
        return self.done, len(self.knots), len(self.record_times)

    def rewind(self, mark: tuple[int, int, int]) -> None:
        """Forget what was kept since a mark."""
        self.done, n_knots, n = mark
        del self.knots[n_knots:], self.record_times[n:]
        for values in self.values.values():
            del values[n:]

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """What was kept, by stretches."""
        parts: list[list[Knot]] = [[] for _ in self.systems]
        for knot in self.knots:
            parts[knot.stretch].append(knot)
        return tuple(
            Stretch(system, *(np.array([getattr(knot, name) for knot in part]) for name in ("time", "q", "v", "output")))
            for system, part in zip(self.systems, parts, strict=True)
        )

    @property
    def records(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Times and values of the quantities."""
        n = min([len(self.record_times), *(len(values) for values in self.values.values())])
        times = np.array(self.record_times[:n])
        return {name: (times, _stacked(values[:n])) for name, values in self.values.items()}


def _stacked(values: list[Any]) -> np.ndarray:
    """An array of values, of objects where their shapes differ."""
    if len({np.shape(value) for value in values}) <= 1:
        return np.array(values)
    out = np.empty(len(values), dtype=object)
    out[:] = values
    return out
