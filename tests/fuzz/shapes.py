"""Surfaces that are stated by a function, and a surface in another frame; their ``repr`` makes them again."""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

import skancf as sk


@dataclass(frozen=True)
class Barrel:
    """Curved both ways, over unit fractions of its sides."""

    length_x: float
    length_y: float
    rise: float

    def __call__(self, x: Any, y: Any) -> Any:
        return self.length_x * x, self.length_y * y, self.rise * (1 - (2 * x - 1) ** 2) * (1.5 - (y - 0.3) ** 2)

    def scaled(self, s: float) -> "Barrel":
        return Barrel(s * self.length_x, s * self.length_y, s * self.rise)


@dataclass(frozen=True)
class Torus:
    """A ring of circular section, over its two angles; closed in both."""

    radius: float
    tube: float

    def __call__(self, x: Any, y: Any) -> Any:
        ring = self.radius + self.tube * np.cos(x)
        return ring * np.cos(y), ring * np.sin(y), self.tube * np.sin(x)

    def scaled(self, s: float) -> "Torus":
        return Torus(s * self.radius, s * self.tube)


def barrel(length_x: float, length_y: float, rise: float) -> sk.MappedSurface:
    return sk.MappedSurface(Barrel(length_x, length_y, rise), ((0.0, 1.0), (0.0, 1.0)))


def torus(radius: float, tube: float) -> sk.MappedSurface:
    return sk.MappedSurface(Torus(radius, tube), ((0.0, 2 * pi), (0.0, 2 * pi)), closed=(True, True))


@dataclass(frozen=True)
class Moved:
    """A surface in another frame: turned or mirrored, then shifted."""

    surface: Any
    turn: tuple[tuple[float, ...], ...]
    shift: tuple[float, float, float]

    def _turned(self, vectors: np.ndarray) -> np.ndarray:
        return np.tensordot(np.array(self.turn), vectors, axes=1)

    def position(self, x: Any, y: Any) -> np.ndarray:
        turned = self._turned(self.surface.position(x, y))
        return turned + np.array(self.shift).reshape(3, *[1] * (turned.ndim - 1))

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, ...]:
        return tuple(self._turned(v) for v in self.surface.derivatives(x, y))

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, ...]:
        return tuple(self._turned(v) for v in self.surface.second_derivatives(x, y))

    @property
    def bounds(self) -> Any:
        return self.surface.bounds

    @property
    def sides(self) -> Any:
        return self.surface.sides

    @property
    def closed(self) -> Any:
        return self.surface.closed


def open_sides(surface: Any) -> list[str]:
    """Sides that are edges: neither seams nor poles."""
    (x0, x1), (y0, y1) = surface.bounds
    s = np.linspace(0, 1, 5)
    x, y = x0 + s * (x1 - x0), y0 + s * (y1 - y0)
    found, ends = [], [(x0, y), (x1, y), (x, y0), (x, y1)]
    for k, (name, end) in enumerate(zip(surface.sides, ends, strict=True)):
        span = np.ptp(surface.position(*np.broadcast_arrays(*end)), axis=1).max()
        if not surface.closed[k // 2] and span > 1e-9 * max(x1 - x0, y1 - y0):
            found.append(name)
    return found


def extent(surface: Any) -> float:
    """Its largest dimension along an axis of space."""
    x, y = np.meshgrid(*[np.linspace(*bounds, 9) for bounds in surface.bounds])
    return float(np.ptp(surface.position(x, y).reshape(3, -1), axis=1).max())
