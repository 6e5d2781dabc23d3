"""What checks of terms and conditions have in common: states, blocks, and what they report."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.history import Case
from skancf.kernels.constants import BLOCK
from skancf.linear import BlockPattern
from skancf.meshes import uniform
from skancf.problem import Problem
from skancf.showing import short
from skancf.vectors import rotation

TURN = (0.7, -1.6, 1.1)
"""Rotation vector of the turned state (rad)."""
CASE = Case(factor=0.7, time=0.3)


@dataclass
class Report:
    """What a check found.

    Attributes
    ----------
    errors : dict
        Largest relative difference of each thing that was checked.
    unchanged : bool or None
        Whether a motion of everything as a rigid body leaves the energy as it is; None without an energy.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel)
    >>> report = sk.testing.check_condition(sk.RigidLink((0.0, 0.0), (1.0, 1.0)), plate)
    >>> print(len(report.errors) > 0)
    True
    """

    errors: dict[str, float] = field(default_factory=dict)
    unchanged: bool | None = None

    __repr__ = short

    def add(self, what: str, error: float) -> None:
        self.errors[what] = max(error, self.errors.get(what, 0.0))

    def __str__(self) -> str:
        lines = [f"{what}: {error:.0e}" for what, error in self.errors.items()]
        if self.unchanged is not None:
            lines.append(f"rigid motions {'leave' if self.unchanged else 'change'} the energy")
        return "\n".join(lines)


@contextmanager
def blamed(kind: type[InputError]) -> Iterator[None]:
    try:
        yield
    except InputError as wrong:
        raise kind(str(wrong)) from wrong


def mesh_of(problem: Problem, mesh: Any) -> Any:
    return uniform(problem.surface, 3, 4) if mesh is None else mesh


def states_about(layout: Any, amount: float, rng: np.random.Generator) -> Iterator[np.ndarray]:
    for turn in (np.zeros(3), np.array(TURN)):
        q = rotated(layout, layout.undeformed, rotation(turn)).ravel()
        yield q + amount * layout.scales.ravel() * rng.uniform(-1, 1, q.size)


def rotated(layout: Any, blocks: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Everything turned about its centre."""
    out, centre = blocks @ R.T, layout.positions(blocks).mean(axis=0)
    out[layout.moving, 0] += centre - R @ centre
    return np.asarray(out)


def pair(layout: Any, states: Sequence[np.ndarray], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    q = np.asarray(states[0], float)
    return q, q + 0.01 * layout.scales.ravel() * rng.uniform(-1, 1, q.size)


def pattern_of(system: Any, bound: Any) -> BlockPattern:
    """Of the shell's blocks and those of a term or condition."""
    cells = tuple(each.T for each in (system.shell.cells, bound.couples()) if each.size)
    return BlockPattern.from_cells(cells, system.layout.n_blocks, BLOCK, system.layout.places.T)
