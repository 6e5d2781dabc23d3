"""Results where a state is asked for: which of its states a result stands for, and what to give where that is not clear."""

from typing import Any, Protocol

from skancf.arguments import STATE, instance
from skancf.errors import DidNotConverge, InputError
from skancf.solution import Solution


class StandsForState(Protocol):
    """A result that one state stands for."""

    def _as_solution(self) -> Solution:
        """That state; InputError where several may be meant, DidNotConverge where the asked one was not found."""


StateLike = Solution | StandsForState
"""A Solution; a StaticResult or PathResult that arrived, for its last equilibrium; an AdaptiveResult, for its best mesh."""


def stands_for_state(value: Any) -> bool:
    """Whether it is a result that says which state it stands for, or why it stands for none."""
    return not isinstance(value, type) and hasattr(value, "_as_solution")


def solution_of(name: str, value: Any) -> Solution:
    """``value`` as a Solution, or the state that a result stands for.

    Raises
    ------
    InputError
        For a result that did not arrive, with its message; for one of several states, such as modes and motions, with how to
        choose one of them; and for everything else.
    """
    if isinstance(value, Solution):
        return value
    if not stands_for_state(value):
        return instance(name, value, Solution, STATE)
    try:
        return instance(name, value._as_solution(), Solution, STATE)
    except DidNotConverge as failed:
        said = str(failed).rstrip(". ")
        raise InputError(f"{name}: this {type(value).__name__} did not arrive: {said}. Give its .solution to take the last "
                         "equilibrium that was found") from failed  # fmt: skip
    except InputError as wrong:
        raise InputError(f"{name}: {wrong}") from wrong
