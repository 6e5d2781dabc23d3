"""Saddles with straight edges."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, number, positive
from skancf.showing import short
from skancf.surfaces.protocol import Interval, parameters


@by_value
@dataclass(frozen=True)
class HyperbolicParaboloid:
    r"""A saddle over a rectangle centred at the origin,

    .. math:: \mathbf X = (x,\; y,\; c x y), \qquad c = \frac{4\, \text{rise}}{\text{length}_x \text{length}_y},
              \quad |x| \le \text{length}_x / 2, \quad |y| \le \text{length}_y / 2.

    Its edges are straight: ``"left"``, ``"right"``, ``"bottom"`` and ``"top"``. Its normal has a positive z. Turned by
    45 degrees about z it is z = c (x^2 - y^2) / 2; that saddle over a square along its own axes has curved edges and is a
    :class:`MappedSurface`.

    Parameters
    ----------
    length_x, length_y : float
        Sides of the rectangle (m).
    rise : float
        Height of the corner where x and y are largest (m), of either sign; two corners have -rise.

    Raises
    ------
    InputError
        For lengths that are not positive, and for no rise.

    Examples
    --------
    >>> saddle = sk.HyperbolicParaboloid(2.0, 2.0, rise=0.5)
    >>> print(saddle.position(1.0, 1.0))
    [1.  1.  0.5]
    """

    length_x: float
    length_y: float
    rise: float

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("length_x", self.length_x)
        positive("length_y", self.length_y)
        if number("rise", self.rise) == 0:
            raise InputError("rise = 0: this is flat; use a Rectangle")

    @property
    def _twist(self) -> float:
        return 4 * self.rise / (self.length_x * self.length_y)

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (-self.length_x / 2, self.length_x / 2), (-self.length_y / 2, self.length_y / 2)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "bottom", "top"

    @property
    def closed(self) -> tuple[bool, bool]:
        return False, False

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = parameters(x, y)
        return np.stack([x, y, self._twist * x * y])

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        x, y = parameters(x, y)
        one, zero = np.ones_like(x), np.zeros_like(x)
        return np.stack([one, zero, self._twist * y]), np.stack([zero, one, self._twist * x])

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        zero = np.zeros(np.broadcast(x, y).shape)
        none = np.stack([zero, zero, zero])
        return none, np.stack([zero, zero, zero + self._twist]), none.copy()
