"""What objects remember from step to step, by name: written to disk, put back there, and gone back to."""

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class HasState(Protocol):
    """What remembers something from step to step.

    A rule, a control of steps, a policy of meshes or a term that has both methods is asked by the run that it takes part in,
    which then goes on, where it was cut off, and goes back, where meshes follow it, with what the object knew there.
    An object that has served a run still knows its end: give every run one of its own.

    Examples
    --------
    >>> class Steps:
    ...     def __init__(self):
    ...         self.dt = 1e-4
    ...     def state(self):
    ...         return {"dt": self.dt}
    ...     def restore(self, state):
    ...         self.dt = float(state["dt"])
    >>> isinstance(Steps(), sk.dynamics.HasState)
    True
    """

    def state(self) -> dict[str, Any]:
        """What it remembers: arrays, numbers, texts and None by name, or more of these by name.

        Names, kinds and numbers of dimensions stay the same over a run, sizes need not.
        """

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to what :meth:`state` gave."""


NONE = np.dtype("V1")
"""Of the empty array that stands for None."""


def flat(state: Mapping[str, Any], above: str = "") -> dict[str, np.ndarray]:
    """Copies of all values of a state as arrays, their names joined by dots."""
    out: dict[str, np.ndarray] = {}
    for name, value in state.items():
        if isinstance(value, Mapping):
            out |= flat(value, f"{above}{name}.")
        else:
            out[above + name] = np.empty(0, NONE) if value is None else as_array(value)
    return out


def as_array(value: Any) -> np.ndarray:
    """A new array, one of objects where lists have several lengths."""
    try:
        return np.array(value)
    except ValueError:
        return np.array([value, None], dtype=object)[:1]


def nested(arrays: Mapping[str, np.ndarray], like: Mapping[str, Any]) -> dict[str, Any]:
    """The state of which :func:`flat` made arrays; ``like`` is any state of the same object.

    Raises
    ------
    ValueError
        For names that are missing or too many, and for texts or numbers of dimensions that are others.
    """
    known = flat(like)
    if wrong := known.keys() ^ arrays.keys():
        raise ValueError(f"'{min(wrong)}' is missing there, or here")
    for name, value in arrays.items():
        kinds = {(array.ndim, array.dtype.kind == "U") for array in (value, known[name]) if array.dtype != NONE}
        if len(kinds) > 1:
            raise ValueError(f"'{name}' has the shape {value.shape} and the type {value.dtype}")
    return _nested(arrays, like, "")


def _nested(arrays: Mapping[str, np.ndarray], like: Mapping[str, Any], above: str) -> dict[str, Any]:
    return {
        name: _nested(arrays, value, f"{above}{name}.") if isinstance(value, Mapping) else _value(arrays[above + name])
        for name, value in like.items()
    }


def _value(array: np.ndarray) -> Any:
    if array.dtype == NONE:
        return None
    return array.copy() if array.ndim else array.item()
