"""Functions of time that multiply loads and prescribed displacements."""

from collections.abc import Callable

import numpy as np

from skancf.errors import InputError

History = Callable[[float], float]


def check_history(history: object) -> None:
    """InputError for a history that cannot be called."""
    if history is not None and not callable(history):
        raise InputError(f"history = {history!r}: give a function of time, as in history=lambda t: min(1.0, t / 0.1)")


def amplitude(history: History | None, time: float | None) -> float:
    """The factor at a time; without a time or a history it is one.

    Raises
    ------
    InputError
        Where the function is not finite.
    """
    if history is None or time is None:
        return 1.0
    value = float(history(time))
    if not np.isfinite(value):
        raise InputError(f"history at t = {time} is {value}; a function of time must be finite over the whole run")
    return value
