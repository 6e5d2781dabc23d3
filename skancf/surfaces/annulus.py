"""Flat sectors, rings and discs."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, positive
from skancf.showing import short
from skancf.surfaces.protocol import Interval
from skancf.surfaces.revolution import Revolution, check_sector


@by_value
@dataclass(frozen=True)
class AnnulusSector(Revolution):
    r"""A flat sector of an annulus, :math:`\mathbf X = (x \cos y,\; x \sin y,\; 0)`; x is the radius, y the central angle.

    Its sides are ``"inner"``, ``"outer"``, ``"start"`` (the smallest angle) and ``"end"``. Its normal is +z.

    Parameters
    ----------
    inner, outer : float
        Radii (m), 0 <= inner < outer. ``inner = 0``: a disc, or a sector of it, with a pole at its centre.
    angle : float
        Central angle (radians), 0 < angle <= 2 pi.
    start : float
        Smallest central angle, from the axis of space x towards that of y (radians).
    closed : bool
        With ``angle = 2 pi``: True for a whole ring, False for one that is slit from ``"start"`` to ``"end"``.
        The surface shows it as the pair (False, closed).

    Raises
    ------
    InputError
        For radii or an angle out of range, and for ``closed`` without a full turn.

    Examples
    --------
    >>> ring = sk.AnnulusSector(inner=0.2, outer=0.5, angle=2 * np.pi, closed=True)
    >>> print(ring.position(0.5, np.pi / 4).round(3))
    [0.354 0.354 0.   ]
    """

    inner: float
    outer: float
    angle: float = pi / 2
    start: float = 0.0
    closed: Any = False

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("outer", self.outer)
        if number("inner", self.inner) < 0:
            raise InputError(f"inner = {self.inner}: give a radius of at least zero (0: a disc)")
        if not self.inner < self.outer:
            raise InputError(f"inner = {self.inner}, outer = {self.outer}: the inner radius must be the smaller one")
        object.__setattr__(self, "closed", check_sector(self.angle, self.start, self.closed))

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (self.inner, self.outer), (self.start, self.start + self.angle)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "inner", "outer", "start", "end"

    def meridian(self, x: np.ndarray) -> np.ndarray:
        one, zero = np.ones_like(x), np.zeros_like(x)
        return np.array([[x, zero], [one, zero], [zero, zero]])
