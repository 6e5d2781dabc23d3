"""The files of a run: whole or not there, and known by the state that names them."""

import hashlib
import io
import json
import os
from collections.abc import Callable
from dataclasses import astuple, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from skancf.atomic import reason, replacing
from skancf.dynamics.asked import Asked
from skancf.dynamics.ledger import COLUMNS, Book, MeshEvent
from skancf.dynamics.motion import Step
from skancf.dynamics.recorder import Knot, Recorder
from skancf.errors import InputError, SkancfError
from skancf.meshes import quadtree_file
from skancf.system.system import System

FORMAT = "skancf run 3"
RUN, STATE, PIECE, MESH = "run.npz", "state.npz", "piece_{:06d}.npz", "mesh_{:06d}.npz"
STOPPED, REST = "stopped.npz", "rest.npz"
"""The state where a run stopped before its end, and what came since the last piece: to look at, not to go on from."""

KEYS = {"files", "pieces", "counts", "status", "message", "seconds"}
"""Of a state."""


@dataclass
class Kept:
    """The lists of a run that grow, and how long they are."""

    recorder: Recorder
    steps: list[Step]
    book: Book

    @property
    def counts(self) -> dict[str, int]:
        return {"knots": len(self.recorder.knots), "systems": len(self.recorder.systems), "steps": len(self.steps),
                "rows": len(self.book.rows), "records": len(self.recorder.record_times),
                "events": len(self.book.events)}  # fmt: skip

    def since(self, counts: dict[str, int]) -> dict[str, np.ndarray]:
        """What came after there were so many, as arrays."""
        recorder, book = self.recorder, self.book
        knots, rows = recorder.knots[counts["knots"] :], book.rows[counts["rows"] :]
        out = {
            "knots": np.array([(k.stretch, k.time, k.output) for k in knots], dtype=float).reshape(-1, 3),
            "steps": np.array([astuple(step) for step in self.steps[counts["steps"] :]], dtype=float),
            "book_times": np.array(book.times[counts["rows"] :], dtype=float),
            "events": np.array([astuple(event) for event in book.events[counts["events"] :]], dtype=float),
            "record_times": np.array(recorder.record_times[counts["records"] :], dtype=float),
            **{f"book_{name}": np.array([row[name] for row in rows], dtype=float) for name in COLUMNS},
            **{f"record_{name}": _numbers(name, all_[counts["records"] :]) for name, all_ in recorder.values.items()},
        }
        for stretch in sorted({k.stretch for k in knots}):
            for name in ("q", "v"):
                out[f"{name}_{stretch}"] = np.array([getattr(k, name) for k in knots if k.stretch == stretch])
        return out

    def forget(self) -> None:
        """Empty lists."""
        recorder, book = self.recorder, self.book
        recorder.systems, recorder.knots, recorder.record_times = [], [], []
        recorder.values = {name: [] for name in recorder.values}
        book.times, book.rows, book.events = [], [], []
        self.steps.clear()

    def add(self, piece: dict[str, np.ndarray]) -> None:
        """What :meth:`since` gave."""
        recorder, book = self.recorder, self.book
        rows: dict[int, int] = {}
        for stretch, time, output in piece["knots"].tolist():
            k = int(stretch)
            i = rows[k] = rows.get(k, -1) + 1
            recorder.replace_output(k, time)
            recorder.knots.append(Knot(k, time, piece[f"q_{k}"][i], piece[f"v_{k}"][i], bool(output)))
        self.steps += [_record(Step, row) for row in piece["steps"]]
        book.times += piece["book_times"].tolist()
        columns = [piece[f"book_{name}"] for name in COLUMNS]
        book.rows += [dict(zip(COLUMNS, row, strict=True)) for row in zip(*columns, strict=True)]
        book.events += [_record(MeshEvent, row) for row in piece["events"]]
        recorder.record_times += piece["record_times"].tolist()
        for name, values in recorder.values.items():
            values += list(piece[f"record_{name}"])


def _numbers(name: str, values: list[Any]) -> np.ndarray:
    try:
        out = np.array(values)
    except ValueError:
        out = np.empty(0, dtype=object)
    if out.dtype.hasobject:
        raise SkancfError(f"record[{name!r}] gives what cannot be written, for example a {type(values[0]).__name__}; let it "
                          "give numbers, or arrays of one shape")  # fmt: skip
    return out


def _record(kind: Any, row: np.ndarray) -> Any:
    """A dataclass of numbers from their row."""
    types: list[Any] = [part.type for part in fields(kind)]
    return kind(*(number(value) for number, value in zip(types, row.tolist(), strict=True)))


@dataclass
class RunFiles:
    """Reads and writes the files of one run, and knows the digests of those that it has."""

    folder: Path
    digests: dict[str, str] = field(default_factory=dict)

    def refused(self, name: str, why: str) -> InputError:
        return InputError(f"file '{self.folder / name}': {why}; go on with what the run was begun with, or begin in another "
                          "folder")  # fmt: skip

    # --- writing ---------------------------------------------------------------------------------------------------------

    def write(self, name: str, arrays: dict[str, np.ndarray]) -> None:
        """One file, on the disk when this returns."""
        stream = io.BytesIO()
        np.savez(stream, **arrays)  # type: ignore[arg-type]
        data = stream.getvalue()
        with replacing(self.folder / name) as part, part.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        self.digests[name] = _digest(data)

    def write_asked(self, asked: Asked) -> None:
        text = {"format": FORMAT, "settings": asked.settings, "shapes": asked.shapes}
        self.write(RUN, {"text": np.array(json.dumps(text)), **asked.arrays})

    def write_meshes(self, systems: list[System], first: int) -> None:
        """Those from ``first`` on that are not the one before; the mesh that a run begins with is the user's."""
        for k in range(max(first, 1), len(systems)):
            if systems[k] is not systems[k - 1]:
                name = MESH.format(k)
                file = quadtree_file.save(systems[k].mesh, self.folder / name)
                with file.open("rb+") as stream:
                    self.digests[name] = _digest(stream.read())
                    os.fsync(stream.fileno())

    def write_state(self, name: str, text: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        """Last of all: it names the files that belong to it."""
        text = {"format": FORMAT, "files": self.digests.copy(), **text}
        self.write(name, {"text": np.array(json.dumps(text)), **arrays})
        del self.digests[name]

    def clean(self) -> None:
        """Take away what a process that was killed had not finished writing."""
        for file in self.folder.glob(".*.part.npz"):
            file.unlink(missing_ok=True)

    def remove(self, name: str) -> None:
        """Take a file away."""
        (self.folder / name).unlink(missing_ok=True)
        self.digests.pop(name, None)

    # --- reading ---------------------------------------------------------------------------------------------------------

    def bytes_of(self, name: str) -> bytes:
        try:
            data = (self.folder / name).read_bytes()
        except FileNotFoundError:
            raise self.refused(name, "is missing") from None
        except OSError as error:
            raise self.refused(name, f"cannot be read ({reason(error)})") from error
        if name not in (STATE, STOPPED) and _digest(data) != self.digests.get(name):
            raise self.refused(name, f"is damaged, or belongs to another run than '{STATE}'")
        return data

    def read(self, name: str) -> dict[str, np.ndarray]:
        """One file; no code in it is run."""
        data = self.bytes_of(name)
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                return {key: file[key] for key in file.files}
        except Exception as error:  # damage shows in many ways: in numpy's headers, in the archive, in what it unpacks
            raise self.refused(name, f"is no part of a run, or is damaged ({error})") from error

    def _text(self, name: str, data: dict[str, np.ndarray]) -> dict[str, Any]:
        try:
            text = json.loads(str(data["text"]))
            kind = text["format"]
        except (KeyError, ValueError, TypeError) as error:
            raise self.refused(name, "is no part of a run") from error
        if kind != FORMAT:
            raise self.refused(name, f"is '{kind}', this version reads '{FORMAT}'")
        return dict(text)

    def read_state(self, name: str = STATE) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """The state; from here on the digests are those it names."""
        data = self.read(name)
        text = self._text(name, data)
        if not text.keys() >= KEYS:
            raise self.refused(name, "is no state of a run")
        self.digests = dict(text["files"])
        return text, data

    def read_asked(self) -> Asked:
        data = self.read(RUN)
        text = self._text(RUN, data)
        return Asked(text["settings"], text["shapes"], {name: data[name] for name in data if name != "text"})

    def read_kept(self, text: dict[str, Any], kept: Kept, first: System) -> None:
        """All pieces and meshes; ``first`` is the system that the run began on."""
        kept.forget()
        names = [PIECE.format(k) for k in range(1, text["pieces"] + 1)]
        pieces = [self.read(name) for name in (*names, REST) if name in names or name in self.digests]
        try:
            for piece in pieces:
                kept.add(piece)
            systems = self._systems(text["counts"]["systems"], first, first.problem.on)
            kept.recorder.systems = systems
            fits = kept.counts == text["counts"]
        except (KeyError, ValueError, TypeError, IndexError) as error:
            if isinstance(error, InputError):
                raise
            raise self.refused(STATE, f"does not fit its pieces ({error!r})") from error
        if not fits:
            raise self.refused(STATE, "does not fit its pieces")

    def _systems(self, n: int, first: System, on: Callable[..., System]) -> list[System]:
        systems = [first]
        for k in range(1, n):
            name = MESH.format(k)
            if name in self.digests:
                self.bytes_of(name)
                systems.append(on(quadtree_file.load(self.folder / name), first.geometry.theory))
            else:
                systems.append(systems[-1])
        return systems


def _digest(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=16).hexdigest()
