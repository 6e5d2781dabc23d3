"""Sectors of circular cylinders."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import positive
from skancf.showing import short
from skancf.surfaces.protocol import Interval
from skancf.surfaces.revolution import Revolution, check_sector

# The axis along x; the angle from -y over +z to +y, so that the normal points outwards.
ALONG_X = np.array([[0.0, 0, 1], [-1, 0, 0], [0, 1, 0]])


@by_value
@dataclass(frozen=True)
class CylinderSector(Revolution):
    r"""A sector of a circular cylinder about the axis of space x,

    .. math:: \mathbf X = (x,\; -R \cos y,\; R \sin y), \qquad 0 \le x \le \text{length}.

    y is the central angle, 0 in the direction -y of space, pi/2 at the crown (+z), pi in the direction +y. A shallow roof
    with its crown on top has ``start = pi/2 - angle/2``; its x and y run along those of space. The normal points
    outwards, away from the axis. The sides are ``"left"`` (x = 0), ``"right"``, ``"start"`` (the smallest angle) and
    ``"end"``.

    Parameters
    ----------
    radius, length : float
        Radius R and length along the axis (m).
    angle : float
        Central angle (radians), 0 < angle <= 2 pi.
    start : float
        Smallest central angle (radians).
    closed : bool
        With ``angle = 2 pi``: True for a whole tube, False for one that is slit along its length.
        The surface shows it as the pair (False, closed).

    Raises
    ------
    InputError
        For values out of range, and for ``closed`` without a full turn.

    Examples
    --------
    >>> tube = sk.CylinderSector(radius=0.5, length=1.5, angle=2 * np.pi, closed=True)
    >>> print(tube.position(1.0, np.pi / 4).round(3))
    [ 1.    -0.354  0.354]
    """

    radius: float
    length: float
    angle: float
    start: float = 0.0
    closed: Any = False

    axes = ALONG_X

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("radius", self.radius)
        positive("length", self.length)
        object.__setattr__(self, "closed", check_sector(self.angle, self.start, self.closed))

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (0.0, self.length), (self.start, self.start + self.angle)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "start", "end"

    def meridian(self, x: np.ndarray) -> np.ndarray:
        one, zero = np.ones_like(x), np.zeros_like(x)
        return np.array([[self.radius * one, x], [zero, one], [zero, zero]])
