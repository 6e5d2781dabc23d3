"""What there is to look at: states in order, whatever they come from."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from skancf.dynamics import Motion
from skancf.errors import InputError, shown
from skancf.solution import Solution
from skancf.states import solution_of, stands_for_state
from skancf.statics import BucklingResult, Modes, PathResult

GIVE = "give a Solution, a sequence of them, a result, a motion, a path or modes"


@dataclass(frozen=True)
class Reel:
    """States with their names.

    Attributes
    ----------
    states : tuple of Solution
    names : tuple of str
        What tells a state from the others, as in ``"t = 0.1 s"``.
    label : str
        What is counted: ``"time"``, ``"load factor"``, ``"mode"``, or ``"state"``.
    rest : Solution or None
        Of modes, about which each of the states swings.
    """

    states: tuple[Solution, ...]
    names: tuple[str, ...]
    label: str
    rest: Solution | None = None

    def at(self, k: int, phase: float = 90.0) -> Solution:
        """The k-th state, of modes at a phase (degrees) of its swing, with its largest displacement at 90."""
        state = self.states[k]
        if self.rest is None or phase == 90.0:
            return state
        part = float(np.sin(np.radians(phase)))
        return replace(state, q=self.rest.q + part * (state.q - self.rest.q))


def reel_of(states: Any) -> Reel:
    """The states of whatever has any."""
    if isinstance(states, Modes):
        names = tuple(f"mode {k}, {value:.4g} Hz" for k, value in enumerate(states.frequencies))
        return Reel(tuple(map(states.shape, range(len(names)))), names, "mode", states.state)
    if isinstance(states, BucklingResult):
        names = tuple(f"mode {k}, load factor {value:.4g}" for k, value in enumerate(states.load_factors))
        return Reel(tuple(map(states.shape, range(len(names)))), names, "mode", states.start)
    if isinstance(states, Motion):
        return _in_order(tuple(states.states))
    if isinstance(states, PathResult):
        return _in_order(states.solutions)
    if isinstance(states, Solution) or stands_for_state(states):
        return Reel((solution_of("states", states),), ("",), "state")
    if not isinstance(states, Iterable) or isinstance(states, str | bytes | dict | np.ndarray):
        raise InputError(f"states = {shown(states)}: {GIVE}")
    given = tuple(solution_of(f"states[{k}]", state) for k, state in enumerate(states))
    if not given:
        raise InputError("states: the sequence is empty; give at least one")
    return _in_order(given)


def series_of(states: Any) -> Any:
    """The states of a motion or path in order, the one that another result stands for, or what was given."""
    if isinstance(states, Motion):
        return states.states
    if isinstance(states, PathResult):
        return states.solutions
    return solution_of("states", states) if stands_for_state(states) else states


def _in_order(states: tuple[Solution, ...]) -> Reel:
    """States counted by their times, or load factors where these differ, or numbers."""
    if all(state.time is not None for state in states):
        return Reel(states, tuple(f"t = {state.time:.4g} s" for state in states), "time")
    if len(states) > 1 and all(a.load_factor != b.load_factor for a, b in pairwise(states)):
        return Reel(states, tuple(f"load factor {state.load_factor:.4g}" for state in states), "load factor")
    return Reel(states, tuple(f"state {k}" for k in range(len(states))), "state")
