"""Shapes of modes as states, for pictures and films."""

from dataclasses import replace
from typing import Any

import numpy as np

from skancf.arguments import whole
from skancf.errors import InputError, positive
from skancf.solution import Solution


def nth(shapes: np.ndarray, i: int) -> np.ndarray:
    """One of some shapes; from the last one on where i is negative."""
    if not -len(shapes) <= whole("i", i, least=-len(shapes)) < len(shapes):
        raise InputError(f"i = {i}: there are {len(shapes)} modes, numbered from 0; ask for more by n")
    return np.asarray(shapes[int(i)])


def _largest_inside(system: Any, mode: np.ndarray) -> float:
    """Largest movement at the integration points: of single elements only slopes and twists of nodes may move."""
    geometry = system.geometry
    local = geometry.local(system.shell.nodal(mode))
    inside = geometry.integration.gathered(
        lambda points, e: np.einsum("ap,eai->epi", geometry.theory.position_table(points)[0], local[e])
    )
    return float(np.linalg.norm(inside, axis=2).max()) or 1.0


MODE = "mode of arbitrary size"


def moved_along(state: Solution, mode: np.ndarray, size: float | None) -> Solution:
    """A state moved along a mode until its nodes moved by ``size`` at most; by default a tenth of the structure's extent."""
    layout = state.system.layout
    r = layout.positions(state.system.undeformed)
    size = 0.1 * float(np.linalg.norm(np.ptp(r, axis=0))) if size is None else positive("size", size, "m")
    largest = float(np.linalg.norm(layout.positions(mode), axis=1).max()) or _largest_inside(state.system, mode)
    return Solution(state.system, state.q + size / largest * mode, load_factor=state.load_factor, note=MODE)


def swung_along(state: Solution, mode: np.ndarray, size: float | None, frames: int) -> tuple[Solution, ...]:
    """A period of a swing about a state along a mode, in equal parts; see :meth:`Modes.swing`."""
    far = moved_along(state, mode, size)
    n = whole("frames", frames, 2)
    parts = np.sin(2 * np.pi * np.arange(n) / n)
    return tuple(replace(far, q=state.q + part * (far.q - state.q)) for part in parts)
