"""What the stored runs of a scene say: medians, and the time to an accuracy."""

import json
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.machine import RESULTS
from benchmarks.scenes import SCENES, Scene

OURS = "skancf"
TARGETS = (1e-2, 1e-3, 1e-4)


@dataclass(frozen=True)
class Curve:
    """The ladder of one variant of a program on one scene: medians of its runs, in the order of its sizes."""

    program: str
    label: str
    theory: str
    sizes: tuple[float, ...]
    dofs: tuple[int, ...]
    errors: tuple[float, ...]
    seconds: tuple[float, ...]
    failed: tuple[str, ...] = ()

    @property
    def ours(self) -> bool:
        return self.program == OURS

    def time_to(self, error: float) -> float | None:
        """Seconds of the fastest run in the part of the ladder from which on no run has a larger error; None without one.

        An error that is small once, on the way from too stiff to too soft, does not count.
        """
        last = max((k for k, e in enumerate(self.errors) if e > error), default=-1)
        return min(self.seconds[last + 1 :], default=None)


@dataclass(frozen=True)
class Compared:
    """All curves of a scene, with what could not be run."""

    scene: Scene
    curves: tuple[Curve, ...]
    cannot: tuple[tuple[str, str], ...]
    stored: dict[str, Any]

    def fastest(self, ours: bool, error: float) -> tuple[float, Curve] | None:
        """The shortest time to an accuracy and who has it."""
        times = [(curve.time_to(error), curve) for curve in self.curves if curve.ours == ours]
        return min(((t, c) for t, c in times if t is not None), key=lambda pair: pair[0], default=None)

    def known(self, error: float) -> bool:
        """Are the reference values, for the theories of the curves, accurate enough to tell?"""
        return max((self.scene.uncertainty(c.theory) for c in self.curves), default=0.0) <= error / 2


def compared(folder: Path = RESULTS) -> Iterator[Compared]:
    """The stored scenes, in their order."""
    for scene in SCENES.values():
        file = folder / f"scene_{scene.name}.json"
        if file.exists():
            yield read(scene, json.loads(file.read_text(encoding="utf-8")))


def read(scene: Scene, stored: dict[str, Any]) -> Compared:
    ladders: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in stored["rows"]:
        ladders.setdefault((row["module"], row["variant"]), []).append(row)
    curves = (curve(rows) for rows in ladders.values())
    cannot = tuple((entry["label"], entry["reason"]) for entry in stored["cannot"])
    return Compared(scene, tuple(curves), cannot, stored)


def curve(rows: list[dict[str, Any]]) -> Curve:
    done = [row for row in rows if row["wall"]]
    return Curve(
        rows[0]["program"], rows[0]["label"], rows[0]["theory"],
        tuple(row["size"] for row in done), tuple(row["dofs"] for row in done), tuple(row["error"] for row in done),
        tuple(statistics.median(row["wall"]) for row in done),
        tuple(f"size {row['size']:g}: {row['failed']}" for row in rows if not row["wall"] and "failed" in row),
    )  # fmt: skip
