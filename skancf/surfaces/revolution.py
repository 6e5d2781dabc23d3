"""What sectors of surfaces of revolution have in common."""

from abc import ABC, abstractmethod
from math import pi
from typing import Any

import numpy as np

from skancf.errors import InputError, number, positive, shown
from skancf.surfaces.protocol import parameters
from skancf.tolerances import FULL_TURN

# Turned by more than this many times its angle, the ends of a sector are known to less than the places of nodes.
LOST = 1e6


class Revolution(ABC):
    r"""A meridian :math:`(\rho(x), \zeta(x))` turned by the angle y about an axis,

    .. math:: \mathbf X = \rho(x) (\cos y\, \mathbf e_1 + \sin y\, \mathbf e_2) + \zeta(x)\, \mathbf e_3 .
    """

    # e_1, e_2, e_3 as columns.
    axes = np.eye(3)

    @abstractmethod
    def meridian(self, x: np.ndarray) -> np.ndarray:
        """rho and zeta, their first and their second derivatives, shape (3, 2, ...)."""

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = parameters(x, y)
        (rho, zeta), _, _ = self.meridian(x)
        return self._turned(0, y, rho, zeta)

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        x, y = parameters(x, y)
        (rho, zeta), (rho_x, zeta_x), _ = self.meridian(x)
        return self._turned(0, y, rho_x, zeta_x), self._turned(1, y, rho, 0 * zeta)

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y = parameters(x, y)
        (rho, zeta), (rho_x, _), (rho_xx, zeta_xx) = self.meridian(x)
        return (self._turned(0, y, rho_xx, zeta_xx), self._turned(1, y, rho_x, 0 * zeta),
                self._turned(2, y, rho, 0 * zeta))  # fmt: skip

    def _turned(self, order: int, y: np.ndarray, rho: np.ndarray, zeta: np.ndarray) -> np.ndarray:
        """Derivative of that order with respect to y, of rho (cos y, sin y) + zeta in space."""
        c, s = np.cos(y), np.sin(y)
        along_1, along_2 = ((c, s), (-s, c), (-c, -s))[order]
        return np.tensordot(self.axes, np.stack([rho * along_1, rho * along_2, zeta]), axes=1)


def check_sector(angle: Any, start: Any, closed: Any) -> tuple[bool, bool]:
    """The directions in which a sector is closed; ``closed`` is one bool, or the pair that this returned before."""
    positive("angle", angle)
    if abs(number("start", start)) > LOST * angle:
        raise InputError(f"start = {start}, angle = {angle}: the sector is lost in the rounding of its start; give "
                         "it within a turn of zero, in radians")  # fmt: skip
    pair = closed if isinstance(closed, tuple) else (False, closed)
    if not all(isinstance(way, bool | np.bool_ | int) for way in pair) or pair not in ((False, False), (False, True)):
        raise InputError(f"closed = {shown(closed)}: give True for a full turn without a seam, or False")
    if angle > 2 * pi * (1 + FULL_TURN):
        raise InputError(f"angle = {angle}: a sector needs 0 < angle <= 2 pi, in radians")
    if pair[1] and angle < 2 * pi * (1 - FULL_TURN):
        raise InputError(
            f"closed = True with angle = {angle}: only a full turn, angle = 2 pi, comes back to where it "
            "began; give that angle or leave closed out"
        )
    return False, bool(pair[1])
