"""What the stored runs of a scene say: medians, and the time to an accuracy."""

import json
import statistics
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from benchmarks.machine import RESULTS
from benchmarks.scenes import SCENES, Scene

OURS = "skancf"
TARGETS = (1e-2, 2.5e-3, 1e-3, 1e-4)


@dataclass(frozen=True)
class Curve:
    """The ladder of one variant of a program on one scene, in the order of its sizes: medians of its runs.

    A size that failed has an infinite error and no time. ``uncertainty`` is
    that of its reference, infinite where there is none of its own theory.
    """

    program: str
    module: str
    label: str
    theory: str
    sizes: tuple[float, ...]
    dofs: tuple[int, ...]
    errors: tuple[float, ...]
    seconds: tuple[float, ...]
    uncertainty: float = 0.0
    failed: tuple[str, ...] = ()

    @property
    def ours(self) -> bool:
        return self.program == OURS

    @property
    def done(self) -> list[int]:
        """Numbers of the sizes that did not fail."""
        return [k for k, error in enumerate(self.errors) if error < inf]

    def time_to(self, error: float) -> float | None:
        """Seconds of the fastest run in the part of the ladder from which on no run has a larger error; None without one.

        An error that is small once, on the way from too stiff to too soft, does not count.
        """
        return min(self.seconds[self._from(error) :], default=None)

    def confirmed(self, error: float) -> bool:
        """Has a finer mesh confirmed it? The last of a ladder may be accurate by chance."""
        return len(self.errors) - self._from(error) > 1

    def known(self, error: float) -> bool:
        """Is its reference accurate enough to tell?"""
        return self.uncertainty <= error / 2

    def _from(self, error: float) -> int:
        return 1 + max((k for k, e in enumerate(self.errors) if e > error), default=-1)


@dataclass(frozen=True)
class Compared:
    """All curves of a scene, with what could not be run, and ladders that were not finished."""

    scene: Scene
    curves: tuple[Curve, ...]
    cannot: tuple[tuple[str, str], ...]
    stored: dict[str, Any]

    def fastest(self, ours: bool, error: float) -> tuple[float, Curve] | None:
        """The shortest time to an accuracy and who has it."""
        times = [(curve.time_to(error), curve) for curve in self.curves if curve.ours == ours]
        return min(((t, c) for t, c in times if t is not None), key=lambda pair: pair[0], default=None)


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
    curves = (curve(scene, rows) for rows in ladders.values())
    notes = [*stored["cannot"], *stored.get("unfinished", ())]
    return Compared(scene, tuple(curves), tuple((entry["label"], entry["reason"]) for entry in notes), stored)


def curve(scene: Scene, rows: list[dict[str, Any]]) -> Curve:
    """Errors are computed anew from the values: a reference may have become better since."""
    theory = rows[0]["theory"]
    return Curve(
        rows[0]["program"], rows[0]["module"], rows[0]["label"], theory, tuple(row["size"] for row in rows),
        tuple(row.get("dofs", 0) for row in rows),
        tuple(scene.error(row["values"], theory) if row["wall"] else inf for row in rows),
        tuple(statistics.median(row["wall"]) if row["wall"] else inf for row in rows), scene.uncertainty(theory),
        tuple(f"size {row['size']:g}: {row['failed']}" for row in rows if not row["wall"]),
    )  # fmt: skip
