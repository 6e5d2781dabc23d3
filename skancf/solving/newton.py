"""Newton's method, once: what its tangents are, and when it ends, are separate objects."""

import logging
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skancf.errors import SingularMatrix
from skancf.showing import short
from skancf.solving.loop import End
from skancf.solving.status import Status

logger = logging.getLogger(__name__)

FOUND = (Status.CONVERGED, Status.ROUNDING)
"""Ends whose last correction is part of the answer: rounding may leave some of it open."""


class Tangents(Protocol):
    """Equations, and how their corrections are found: with factors of every state, or with those of an earlier one."""

    def residual(self, x: np.ndarray) -> np.ndarray:
        """What is to vanish."""

    def correction(self, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        """What would make it vanish, were it linear, and the energy of that: how large it is.

        Raises
        ------
        SingularMatrix
        """

    def step(self, x: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        """The next state, after a correction that was not the last."""


class StopCriterion(Protocol):
    """When an iteration ends."""

    def assess(self, x: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        """How it ends with a correction of x, the last of whose ``energies`` belongs to it; None to go on.

        With an end of :data:`FOUND` it is taken.
        """


@dataclass(frozen=True)
class Iteration:
    """The last state, how it ended there, the energies of all corrections and the last residual."""

    x: np.ndarray
    status: Status
    message: str
    energies: list[float]
    residual: np.ndarray
    iterations: int

    __repr__ = short

    @property
    def ok(self) -> bool:
        """Whether the last correction was small enough."""
        return self.status.ok


def iterate(
    x: np.ndarray, tangents: Tangents, criterion: StopCriterion, most: int, log: logging.Logger = logger
) -> Iteration:
    """Corrections of a first guess until one is the last, no more than ``most``; a failure is an end like others.

    On level DEBUG the logger is told of each.
    """
    energies: list[float] = []
    told = log.isEnabledFor(logging.DEBUG)
    for step in range(1, most + 1):
        residual = tangents.residual(x)
        if not np.isfinite(residual).all():
            return Iteration(x, Status.NOT_FINITE, "", energies, residual, step)
        try:
            change, energy = tangents.correction(x, residual)
        except SingularMatrix as singular:
            return Iteration(x, Status.SINGULAR, str(singular), energies, residual, step)
        energies.append(energy)
        if told:
            log.debug("iteration %d: energy of the residual %.3e", step, energy)
        if end := criterion.assess(x, change, energies):
            return Iteration(x + change if end[0] in FOUND else x, *end, energies, residual, step)
        x = tangents.step(x, residual, change)
    return Iteration(x, Status.STEPS_SPENT, "", energies, residual, most)
