"""Curves as a user gives them: arrays, pairs, panels."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skancf.arguments import mapping
from skancf.errors import InputError, finite, shown

Curves = dict[str, tuple[np.ndarray, np.ndarray]]


def curves_of(curves: Any) -> Curves:
    """Curves of a mapping from label to pair."""
    mapping("curves", curves, "labels and pairs, as in {'adaptive': (n_dofs, errors)}")
    return {label: curve(label, pair) for label, pair in curves.items()}


def curve(label: str, pair: Any) -> tuple[np.ndarray, np.ndarray]:
    """Two arrays of the same length."""
    try:
        first, second = pair
    except (TypeError, ValueError) as wrong:
        raise InputError(f"{label!r}: {shown(pair)} is no pair; give two lists of the same length") from wrong
    x, y = finite(f"{label!r}", first), finite(f"{label!r}", second)
    if x.ndim != 1 or x.shape != y.shape or not len(x):
        raise InputError(f"{label!r}: values of shape {y.shape} against {x.shape}; give two lists of the same length")
    return x, y


def panels_of(times: Any, histories: Mapping[str, Any]) -> list[tuple[str, Curves]]:
    """Names and curves of panels; one without a name for a mapping that is not nested."""
    mapping("histories", histories, "labels and values, as in {'tip': values}")
    if not histories:
        raise InputError("histories: the sequence is empty; give at least one")
    nested = [isinstance(part, Mapping) for part in histories.values()]
    if any(nested) and not all(nested):
        raise InputError("histories: give curves, or panels of curves, not both")
    panels = histories if all(nested) else {"": histories}
    return [(name, _curves(times, part)) for name, part in panels.items()]


def _curves(times: Any, part: Mapping[str, Any]) -> Curves:
    if not part:
        raise InputError("histories: a panel has no curves; give at least one or leave the panel out")
    pairs = {label: values if isinstance(values, tuple) else (times, values) for label, values in part.items()}
    return {label: curve(label, pair) for label, pair in pairs.items()}
