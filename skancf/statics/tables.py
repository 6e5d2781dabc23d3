"""Columns of the tables that results of statics are."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from skancf.solution import Solution
from skancf.tabular import Column, Columns


def states_of(states: Sequence[Solution]) -> dict[str, Column]:
    """Load factors, and the largest displacement of a node of each."""
    largest = [float(np.linalg.norm(state.displacements, axis=0).max()) for state in states]
    return {"load_factor": ([state.load_factor for state in states], ""), "largest_displacement": (largest, "m")}


def attempts_of(attempts: Iterable[tuple[float, Any]]) -> Columns:
    """A row for each solve, of its load factor and result; the residual is the last energy norm, NaN where there is none."""
    found = list(attempts)
    results = [result for _, result in found]
    return Columns(
        {
            "load_factor": [factor for factor, _ in found],
            "status": [result.status.value for result in results],
            "iterations": [result.iterations for result in results],
            "residual": [result.residual_norms[-1] if result.residual_norms else np.nan for result in results],
            "negative_pivots": [result.negative_pivots for result in results],
        }
    )
