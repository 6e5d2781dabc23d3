"""Sectors of spheres."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, positive, vector
from skancf.showing import short
from skancf.surfaces.protocol import Interval
from skancf.surfaces.revolution import Revolution, check_sector


@by_value
@dataclass(frozen=True)
class SphereSector(Revolution):
    r"""A sector of a sphere about the origin,

    .. math:: \mathbf X = R (\sin x \cos y,\; \sin x \sin y,\; \cos x).

    x is the polar angle from the axis +z of space, y the longitude from +x towards +y, both in radians. The normal points
    outwards. The sides are ``"top"`` (the smallest polar angle), ``"bottom"``, ``"start"`` (the smallest longitude) and
    ``"end"``. The quarter of a hemisphere with a hole of 18 degrees is
    ``SphereSector(10.0, (radians(18), pi / 2), pi / 2)``.

    Parameters
    ----------
    radius : float
        Radius R (m).
    polar : (2,) tuple of float
        Smallest and largest polar angle, 0 <= low < high <= pi; 0 and pi are poles.
    angle : float
        Range of the longitude, 0 < angle <= 2 pi.
    start : float
        Smallest longitude.
    closed : bool
        With ``angle = 2 pi``: True for a whole zone, False for one that is slit along a meridian.
        The surface shows it as the pair (False, closed).

    Raises
    ------
    InputError
        For values out of range, and for ``closed`` without a full turn.

    Examples
    --------
    >>> dome = sk.SphereSector(10.0, polar=(0.0, np.pi / 2), angle=2 * np.pi, closed=True)
    >>> print(dome.position(np.pi / 4, np.pi / 4).round(3))
    [5.    5.    7.071]
    """

    radius: float
    polar: tuple[float, float]
    angle: float
    start: float = 0.0
    closed: Any = False

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("radius", self.radius)
        low, high = vector("polar", self.polar, 2)
        if not 0 <= low < high <= pi:
            raise InputError(f"polar = {self.polar}: give polar angles 0 <= low < high <= pi from the axis +z, in radians")
        object.__setattr__(self, "closed", check_sector(self.angle, self.start, self.closed))

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        low, high = self.polar
        return (low, high), (self.start, self.start + self.angle)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "top", "bottom", "start", "end"

    def meridian(self, x: np.ndarray) -> np.ndarray:
        s, c = np.sin(x), np.cos(x)
        return self.radius * np.array([[s, c], [c, -s], [-s, -c]])
