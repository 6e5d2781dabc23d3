"""Moments of thin states, and of small changes about them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.assembly.system import System

Moments = Callable[[np.ndarray, np.ndarray | None], np.ndarray]
"""Moments (m, 3, n) at local points (2, n) of elements (m,), None for all of them."""
SMALL = 1e-5
"""Relative change of the nodal coordinates over which moments are differenced: its cubic term is below rounding."""


def moments_of(system: System, q: np.ndarray, factor: float = 1.0, time: float | None = None) -> Moments:
    """Those of nodal coordinates q, the temperature change counted with ``factor``."""
    assembly: Any = system.assembly

    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        heat = system.temperature(points, time)
        if heat is not None:
            heat = factor * (heat if elements is None else heat[:, elements])
        return np.asarray(assembly.section_forces(q.reshape(-1, 4, 3), points, heat, elements)[:, 3:])

    return moments


def moments_of_small(system: System, change: np.ndarray, factor: float = 1.0, time: float | None = None) -> Moments:
    """Those of a small-deflection answer that is a change from the undeformed coordinates."""
    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        return system.linearised(lambda q: moments_of(system, q, factor, time)(points, elements), change)

    return moments


def moment_rates(system: System, q: np.ndarray, change: np.ndarray) -> Moments:
    """Their derivative along a change of the nodal coordinates q."""
    sizes = [np.abs(v.reshape(-1, 4, 3)[:, :3]).max(axis=(0, 2)) for v in (change, system.undeformed)]
    size = float((sizes[0] / sizes[1]).max())
    step = SMALL / size if size > 0 else 1.0
    ahead, behind = (moments_of(system, q + sign * step * change) for sign in (1, -1))

    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        return (ahead(points, elements) - behind(points, elements)) / (2 * step)

    return moments
