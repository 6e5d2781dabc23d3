r"""Undeformed mid-surfaces :math:`\mathbf X(x, y)` over a parameter plane.

A mesh lives in the parameter plane; a surface says where its points are in space. A surface that is a rectangle in the
parameter plane has ``bounds``, the intervals of x and y, and ``sides``, the names of its boundary where x and y are
smallest and largest.
"""

from dataclasses import dataclass
from math import pi
from typing import Any, Protocol

import numpy as np

from skancf.errors import InputError, number, positive, vector

Interval = tuple[float, float]


class Surface(Protocol):
    """What the rest of the library knows of a surface."""

    def position(self, x: Any, y: Any) -> np.ndarray:
        """X(x, y), shape (3, ...)."""

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """X_x and X_y, each of shape (3, ...)."""


class BoundedSurface(Surface, Protocol):
    """A surface over a rectangle of the parameter plane."""

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        """Smallest and largest x, smallest and largest y."""

    @property
    def sides(self) -> tuple[str, str, str, str]:
        """Names of the boundaries x = min, x = max, y = min, y = max."""


def normal(surface: Surface, x: Any, y: Any) -> np.ndarray:
    """Unit normal X_x x X_y / |X_x x X_y|, shape (3, ...)."""
    n = np.cross(*surface.derivatives(x, y), axis=0)
    return n / np.sqrt((n * n).sum(axis=0))


@dataclass(frozen=True)
class Plane:
    """The plane z = 0 with x and y as parameters, for any mesh of it.

    Its boundaries are the named boundaries of the mesh.
    """

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return np.stack([x, y, np.zeros_like(x)])

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        zero = np.zeros(np.broadcast(x, y).shape)
        return np.stack([zero + 1, zero, zero]), np.stack([zero, zero + 1, zero])


@dataclass(frozen=True)
class Rectangle(Plane):
    """A flat rectangle ``length_x`` by ``length_y`` in the plane z = 0, its lower left corner at ``origin``.

    Raises
    ------
    InputError
        For a length that is not positive.
    """

    length_x: float
    length_y: float
    origin: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        positive("length_x", self.length_x)
        positive("length_y", self.length_y)
        vector("origin", self.origin, 2)

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        x, y = self.origin
        return (x, x + self.length_x), (y, y + self.length_y)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "bottom", "top"


@dataclass(frozen=True)
class AnnulusSector:
    """A flat sector of an annulus; x is the radius and y the central angle in radians.

    Its sides are ``"inner"``, ``"outer"``, ``"start"`` (the smallest angle) and ``"end"``.

    Raises
    ------
    InputError
        For radii that are not 0 < inner < outer, or an angle outside (0, 2 pi).
    """

    inner: float
    outer: float
    angle: float = pi / 2
    start: float = 0.0

    def __post_init__(self) -> None:
        positive("inner", self.inner)
        positive("outer", self.outer)
        positive("angle", self.angle)
        number("start", self.start)
        if not self.inner < self.outer:
            raise InputError(f"inner = {self.inner}, outer = {self.outer}: the inner radius must be the smaller one")
        if not self.angle < 2 * pi:
            raise InputError(f"angle = {self.angle}: a sector needs 0 < angle < 2 pi; a closed ring is not a sector")

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        return (self.inner, self.outer), (self.start, self.start + self.angle)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "inner", "outer", "start", "end"

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return np.stack([x * np.cos(y), x * np.sin(y), np.zeros_like(x)])

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        c, s, zero = np.cos(y), np.sin(y), np.zeros_like(x)
        return np.stack([c, s, zero]), np.stack([-x * s, x * c, zero])
