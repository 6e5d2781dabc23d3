"""States of a run that stay in the pieces of its folder until they are asked for."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from skancf.dynamics.log import Log
from skancf.dynamics.run_files import RunFiles, under
from skancf.rows import Rows

GONE = np.empty(0)
"""Instead of the coordinates of a state that are in a piece."""


class States:
    """The states (rows of the log ``knots``) of a run, of which most are in pieces and those since the last one here.

    ``kind`` makes a row. ``starts`` are the numbers of the first state of each piece and of the one after the last.
    """

    def __init__(self, files: RunFiles, knots: Log) -> None:
        self.files, self.knots = files, knots
        self.names: list[str] = []
        self.starts = [0]
        self._latest: tuple[str, list[Any]] = ("", [])

    def let_go(self, piece: str) -> None:
        """Forget the coordinates of states that a new piece holds, all that there are."""
        for k in range(self.starts[-1], len(self.knots)):
            self.knots[k] = replace(self.knots[k], q=GONE, v=GONE)
        self.names.append(piece)
        self.starts.append(len(self.knots))

    def of(self, number: int) -> Any:
        """One state, from its piece or from memory."""
        knot = self.knots[number]
        if number >= self.starts[-1]:
            return knot
        piece = int(np.searchsorted(self.starts, number, side="right")) - 1
        return self._piece(self.names[piece])[number - self.starts[piece]]

    def _piece(self, name: str) -> list[Any]:
        """The states of a piece; the latest one is kept."""
        if self._latest[0] != name:
            rows = Log(self.knots.kind)
            rows.add(under("knots", self.files.read(name)))
            self._latest = name, rows
        return self._latest[1]


class StateRows(Rows):
    """Coordinates ``q`` or rates ``v`` of some states in a row, from the number ``first`` on."""

    def __init__(self, states: States, name: str, first: int, shape: tuple[int, int]) -> None:
        super().__init__(shape)
        self.states, self.name, self.first = states, name, first

    def read(self, numbers: np.ndarray) -> np.ndarray:
        return np.stack([getattr(self.states.of(self.first + int(k)), self.name) for k in numbers])


def bounds_of(segments: list[int]) -> list[tuple[int, int]]:
    """First state and the one after the last of each segment, whose numbers are given state by state."""
    at = np.searchsorted(segments, np.arange(segments[-1] + 2))
    return list(pairwise(at.tolist()))
