"""Flat skew plates."""

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, positive
from skancf.showing import short
from skancf.surfaces.protocol import Interval, parameters


@by_value
@dataclass(frozen=True)
class Parallelogram:
    r"""A flat skew plate :math:`\mathbf X = (x + y \cos\alpha,\; y \sin\alpha,\; 0)`, its lower left corner at the origin.

    x and y run along its sides. These are ``"left"``, ``"right"``, ``"bottom"`` and ``"top"``. Its normal is +z.

    Parameters
    ----------
    length_x, length_y : float
        Lengths of the sides (m).
    angle : float
        Angle alpha between the sides at the origin (radians), 0 < angle < pi.

    Raises
    ------
    InputError
        For values out of range.

    Examples
    --------
    >>> skew = sk.Parallelogram(1.0, 0.8, angle=np.pi / 3)
    >>> print(skew.position(1.0, 0.8).round(3))
    [1.4   0.693 0.   ]
    """

    length_x: float
    length_y: float
    angle: float

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("length_x", self.length_x)
        positive("length_y", self.length_y)
        positive("angle", self.angle)
        if not self.angle < pi:
            raise InputError(f"angle = {self.angle}: the sides of a parallelogram meet at 0 < angle < pi, in radians")

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (0.0, self.length_x), (0.0, self.length_y)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "bottom", "top"

    @property
    def closed(self) -> tuple[bool, bool]:
        return False, False

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = parameters(x, y)
        return np.stack([x + y * cos(self.angle), y * sin(self.angle), np.zeros_like(x)])

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        zero = np.zeros(np.broadcast(x, y).shape)
        return (np.stack([zero + 1, zero, zero]),
                np.stack([zero + cos(self.angle), zero + sin(self.angle), zero]))  # fmt: skip

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shape = (3, *np.broadcast(x, y).shape)
        return np.zeros(shape), np.zeros(shape), np.zeros(shape)
