"""Sectors of conical frustums."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, positive
from skancf.showing import short
from skancf.surfaces.cylinder import ALONG_X
from skancf.surfaces.protocol import Interval
from skancf.surfaces.revolution import Revolution, check_sector


@by_value
@dataclass(frozen=True)
class Cone(Revolution):
    r"""A sector of the frustum of a circular cone about the axis of space x,

    .. math:: \mathbf X = (x,\; -\rho \cos y,\; \rho \sin y), \qquad \rho(x) = R_0 + (R_1 - R_0)\, x / H,
              \quad 0 \le x \le H.

    As in :class:`CylinderSector` y is the central angle, pi/2 at the crown (+z), the normal points outwards, and the sides
    are ``"left"`` (x = 0), ``"right"``, ``"start"`` and ``"end"``. Lines of constant y are straight.

    Parameters
    ----------
    radius_low, radius_high : float
        Radii R_0 at x = 0 and R_1 at x = H (m), both positive.
    height : float
        Length H along the axis (m).
    angle, start, closed
        As in :class:`CylinderSector`.

    Raises
    ------
    InputError
        For values out of range, an apex, and for ``closed`` without a full turn.

    Examples
    --------
    >>> funnel = sk.Cone(radius_low=0.5, radius_high=0.1, height=0.6, angle=2 * np.pi, closed=True)
    >>> print(funnel.position(0.3, np.pi / 4).round(3))
    [ 0.3   -0.212  0.212]
    """

    radius_low: float
    radius_high: float
    height: float
    angle: float
    start: float = 0.0
    closed: Any = False

    axes = ALONG_X

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        for name in ("radius_low", "radius_high"):
            if number(name, getattr(self, name)) == 0:
                raise InputError(
                    f"{name} = 0: a cone has no tangent plane at its apex; cut it off with a small positive radius"
                )
            positive(name, getattr(self, name))
        positive("height", self.height)
        object.__setattr__(self, "closed", check_sector(self.angle, self.start, self.closed))

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (0.0, self.height), (self.start, self.start + self.angle)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "start", "end"

    def meridian(self, x: np.ndarray) -> np.ndarray:
        one, zero = np.ones_like(x), np.zeros_like(x)
        slope = (self.radius_high - self.radius_low) / self.height
        return np.array([[self.radius_low + slope * x, x], [slope * one, one], [zero, zero]])
