"""States at output times and quantities at every step, as they come."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.dynamics.interpolation import StateInterpolation
from skancf.dynamics.log import Log
from skancf.dynamics.motion import Segment
from skancf.dynamics.pieces import StateRows, States, bounds_of
from skancf.dynamics.pulls import Pulls
from skancf.dynamics.state import State
from skancf.functions import called
from skancf.rows import Rows
from skancf.showing import short
from skancf.solution import Solution
from skancf.system.system import System
from skancf.tolerances import ABOVE_ZERO, ONE_TIME

Quantity = Callable[[Solution], Any]


@dataclass(frozen=True)
class Knot:
    """A kept state, the segment of the run in which it lies, and whether it is one at an output time."""

    segment: int
    time: float
    q: np.ndarray
    v: np.ndarray
    output: bool

    __repr__ = short


@dataclass(frozen=True)
class Pull:
    """Multipliers that act at a time, in a step that ends at another one, and the segment of the run."""

    segment: int
    end: float
    acting: float
    values: np.ndarray

    __repr__ = short


class Recorder:
    """Keeps the states at ``times``, or at the ends of all steps, and the ``quantities``.

    Every segment of the run, on one mesh and without a jump, also keeps its first and its last state, so that times between
    outputs can be interpolated.
    """

    def __init__(self, times: np.ndarray | None, quantities: Mapping[str, Quantity]):
        self.every = times is None
        self.times, self.quantities = np.zeros(1) if times is None else times, quantities
        self.slack = ONE_TIME * (self.times[-1] - self.times[0] + ABOVE_ZERO)
        self.done = 0
        self.states: States | None = None
        """Where states are that are not here."""
        self.systems: list[System] = []
        self.logs = {"knots": Log(Knot), "records": Log(), "pulls": Log(Pull)}

    def state(self) -> dict[str, Any]:
        """How many of the output times are done."""
        return {"done": self.done}

    def restore(self, state: dict[str, Any]) -> None:
        self.done = state["done"]

    @property
    def outputs(self) -> list[float] | str:
        """The output times, or "steps"."""
        return "steps" if self.every else self.times.tolist()

    def begin(self, system: System, state: State) -> None:
        """A new segment, on a mesh or after a jump: where the last state is an output, the first one is it instead."""
        self.systems.append(system)
        last, due = self.logs["knots"][-1:], self._due(state.time)
        self.done += due
        self._add(state.time, state.q, state.v, due or (bool(last) and last[0].output and last[0].time == state.time))
        self._pulled(state)

    def _pulled(self, state: State) -> None:
        if state.multipliers.size:
            self.logs["pulls"].append(Pull(len(self.systems) - 1, state.time, state.acting, state.multipliers))

    def _add(self, time: float, q: np.ndarray, v: np.ndarray, output: bool) -> None:
        self.logs["knots"].append(Knot(len(self.systems) - 1, time, q, v, output))

    def _due(self, time: float) -> bool:
        return self.every or (self.done < len(self.times) and bool(self.times[self.done] <= time + self.slack))

    def step(self, start: State, end: State) -> None:
        """The states at output times of a step."""
        self._pulled(end)
        if self.every:
            self._add(end.time, end.q, end.v, True)
            return
        while self._due(end.time):
            t = float(self.times[self.done])
            q, v = end.q, end.v
            if t < end.time - self.slack:
                q, v = StateInterpolation(self.systems[-1].layout, self.systems[-1].constraints).inside(t, start, end)
            self._add(t, q, v, True)
            self.done += 1

    def keep(self, state: State) -> None:
        """The quantities of an accepted state."""
        row: dict[str, Any] = {"time": state.time}
        pulls = _pulls(self.logs["pulls"][-LATEST:], len(self.systems) - 1)
        multipliers = None if pulls is None else pulls.at(state.time)
        for name, quantity in self.quantities.items():
            seen = Solution(self.systems[-1], state.q.copy(), state.v.copy(), state.time, multipliers=multipliers)
            row[_column(name)] = called(_column(name), quantity, seen)
        self.logs["records"].append(row)

    def end(self, state: State) -> None:
        """Closes a segment with its last state."""
        if state.time > self.logs["knots"][-1].time + self.slack:
            self._add(state.time, state.q, state.v, False)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """What was kept, by segments."""
        parts: list[list[Knot]] = [[] for _ in self.systems]
        begins = bounds_of([knot.segment for knot in self.logs["knots"]])
        knots = self.logs["knots"]
        for knot, after in zip(knots, [*knots[1:], None], strict=True):
            # At the time of an event the output is the state after it.
            late = after is not None and after.segment > knot.segment and after.output and after.time == knot.time
            parts[knot.segment].append(replace(knot, output=False) if late else knot)
        segments = []
        for k, (system, part) in enumerate(zip(self.systems, parts, strict=True)):
            time, output = (np.array([getattr(knot, name) for knot in part]) for name in ("time", "output"))
            q, v = (self._rows(name, part, begins[k][0], system.n_dofs) for name in ("q", "v"))
            segments.append(Segment(system, time, q, v, output, _pulls(self.logs["pulls"], k)))
        return tuple(segments)

    def _rows(self, name: str, part: list[Knot], first: int, n_dofs: int) -> np.ndarray | Rows:
        """Coordinates or rates of the states of a segment, the first of which has a number."""
        if self.states is None:
            return np.array([getattr(knot, name) for knot in part])
        return StateRows(self.states, name, first, (len(part), n_dofs))

    @property
    def records(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Times and values of the quantities."""
        rows = self.logs["records"]
        times = np.array([row["time"] for row in rows])
        return {name: (times, _stacked([row[_column(name)] for row in rows])) for name in self.quantities}


LATEST = 4
"""Rows of multipliers of which those at the present end are made."""


def _pulls(rows: list[Pull], segment: int) -> Pulls | None:
    """Those of a segment; None without conditions."""
    rows = [row for row in rows if row.segment == segment]
    return Pulls(*(np.array([getattr(row, name) for row in rows]) for name in ("end", "acting", "values"))) if rows else None


def _column(name: str) -> str:
    return f"record[{name!r}]"


def _stacked(values: list[Any]) -> np.ndarray:
    """An array of values, of objects where their shapes differ."""
    if len({np.shape(value) for value in values}) <= 1:
        return np.array(values)
    out = np.empty(len(values), dtype=object)
    out[:] = values
    return out
