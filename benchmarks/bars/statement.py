"""Scenes from data: objects of the library as ``{"Name": [arguments]}`` or ``{"Name": {"name": argument}}``."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import skancf as sk

FOLDER = Path(__file__).parent
SCENES = FOLDER / "scenes.json"


def line(axis: str, at: float, low: float, high: float) -> Callable[[Any, Any], Any]:
    """The place of the nodes from low to high on the line x = at or y = at."""

    def place(x: Any, y: Any) -> Any:
        across, along = (x, y) if axis == "x" else (y, x)
        return (abs(across - at) < 1e-9) & (along > low - 1e-9) & (along < high + 1e-9)

    return place


def trapezium(bottom: float, top: float, height: float, lean: float = 0.0) -> sk.MappedSurface:
    """Sides at y = 0 and y = height are parallel; the top's middle is so far to the right of the bottom's."""

    def at(s: Any, t: Any) -> Any:
        return (s - 0.5) * (bottom + (top - bottom) * t) + lean * t, height * t, 0 * s

    def slopes(s: Any, t: Any) -> Any:
        wide = bottom + (top - bottom) * t
        return (wide, 0 * s, 0 * s), ((s - 0.5) * (top - bottom) + lean, height + 0 * s, 0 * s)

    return sk.MappedSurface(at, ((0.0, 1.0), (0.0, 1.0)), exact_derivatives=slopes)


def kirsch(one: float, two: float) -> Callable[[Any, Any], Any]:
    """Tractions at radius r of the sheet with a hole of radius 1 under membrane forces one along x and two along y."""

    def traction(r: Any, angle: Any) -> Any:
        mean, half, q = (one + two) / 2, (one - two) / 2, 1 / r**2
        radial = mean * (1 - q) + half * (1 - 4 * q + 3 * q**2) * np.cos(2 * angle)
        shear = -half * (1 + 2 * q - 3 * q**2) * np.sin(2 * angle)
        c, s = np.cos(angle), np.sin(angle)
        return radial * c - shear * s, radial * s + shear * c, 0 * r

    return traction


def harmonic(edge: Any, wave: float) -> sk.Prescribed:
    """w = exp(k x) cos(k y), which needs no load, at an edge."""

    def w(x: Any, y: Any) -> Any:
        return None, None, np.exp(wave * x) * np.cos(wave * y)

    def turn(x: Any, y: Any) -> Any:
        growth = wave * np.exp(wave * x)
        return -growth * np.sin(wave * y), -growth * np.cos(wave * y), 0 * x

    return sk.Prescribed(edge, w, rotation=turn)


WORDS: dict[str, Callable[..., Any]] = {
    "degrees": radians, "pi": lambda times: times * pi, "line": line, "trapezium": trapezium, "kirsch": kirsch,
    "harmonic": harmonic,
}  # fmt: skip


def made(data: Any) -> Any:
    """The value of data: lists are tuples, ``{"word": [arguments]}`` is what the word makes of them."""
    if isinstance(data, list):
        return tuple(made(one) for one in data)
    if not isinstance(data, dict):
        return data
    ((word, given),) = data.items()
    make = WORDS[word] if word in WORDS else getattr(sk, word)
    if isinstance(given, dict):
        return make(**{name: made(value) for name, value in given.items()})
    return make(*(made(value) for value in (given if isinstance(given, list) else [given])))


class Goal(NamedTuple):
    """A quantity of a scene, with the tolerances it is asked to, and how its right value is found."""

    name: str
    quantity: Any
    tolerances: tuple[float, ...]
    by: dict[str, Any]


@dataclass(frozen=True)
class Scene:
    """A problem and what is asked of it."""

    name: str
    problem: sk.Problem
    asked: tuple[Goal, ...]
    first: tuple[int, int] | None
    openings: tuple[Any, ...]
    linear: bool
    theory: str
    kinds: tuple[str, ...]
    data: dict[str, Any]

    def start(self) -> Any:
        """The first mesh of ``adapt``, None for its own choice."""
        return None if self.first is None else self.mesh(*self.first)

    def mesh(self, nx: int, ny: int) -> Any:
        return sk.meshes.uniform(self.problem.surface, nx, ny, openings=self.openings)

    def options(self) -> dict[str, Any]:
        return {"mesh": self.start(), "theory": self.theory, "linear": self.linear}


def scenes(path: Path = SCENES) -> Iterator[Scene]:
    """All scenes of a file."""
    stored = json.loads(path.read_text(encoding="utf-8"))
    for data in stored["scenes"]:
        yield scene(data, stored)


def scene(data: dict[str, Any], stored: dict[str, Any]) -> Scene:
    """A scene of a file's data."""

    asked = tuple(
        Goal(
            name,
            made(one["quantity"]),
            tuple(one.get("rtol", data.get("rtol", stored["rtol"]))),
            one.get("by", data.get("by")),
        )
        for name, one in data["ask"].items()
    )
    problem = sk.Problem(
        made(data["surface"]), data.get("thickness"), made(stored["materials"][data["material"]]),
        list(made(data["supports"])), list(made(data.get("loads", []))),
    )  # fmt: skip
    first = data.get("first")
    return Scene(
        data["name"], problem, asked, tuple(first) if first else None, made(data.get("openings", [])),
        data.get("linear", True), data.get("theory", "kirchhoff"), tuple(data["kinds"]), data,
    )  # fmt: skip
