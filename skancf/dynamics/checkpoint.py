r"""Runs on disk: what a run has is written while it goes on, and a run that was cut off continues bit for bit.

A folder holds numbered pieces, each with what came since the one before, the meshes, and one file with the present state.
Every file is whole or not there, and the state is written last: a crash loses what came after it, and no more.
"""

import json
import re
from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from skancf.assembly.system import System
from skancf.atomic import AnyPath, check_folder, replacing
from skancf.dynamics.ledger import COLUMNS, SUMS, Forces, MeshEvent
from skancf.dynamics.motion import Step
from skancf.dynamics.recorder import Knot
from skancf.dynamics.run import Run
from skancf.dynamics.state import State
from skancf.errors import InputError
from skancf.meshes import quadtree_file
from skancf.version import __version__

FORMAT = "skancf run 1"
STATE = "state.npz"
CLOSE = 1e-9
"""Arrays of the same problem differ by rounding of another machine at most."""


@dataclass(frozen=True)
class Checkpoint:
    """Where a run is written while it goes on, and how often.

    Parameters
    ----------
    folder : str or Path
        For this run alone.
    every : int
        Accepted steps between two writes. With meshes that follow the motion it is done at the next look at the mesh. The
        factors of the tangent are renewed then, so that a run that starts there does the same: not too often.

    Raises
    ------
    InputError
        For a number of steps that is none, and a folder that cannot be written.
    """

    folder: AnyPath
    every: int = 100

    def __post_init__(self) -> None:
        if not (isinstance(self.every, (int, np.integer)) and self.every > 0):
            raise InputError(f"every = {self.every}: give a whole number of steps between two writes, 1 at least")

    @property
    def path(self) -> Path:
        return Path(self.folder)

    def begins(self, run: Run, asked: dict[str, Any]) -> "Writer":
        """The writer of a run that starts."""
        check_folder(self.path)
        if (self.path / STATE).exists():
            raise InputError(f"folder '{self.path}': holds a run already; go on with it by resume=True, choose another "
                             "folder, or remove it")  # fmt: skip
        writer = Writer(self, asked)
        writer.write(run)
        return writer


class Writer:
    """Writes a run piece by piece."""

    def __init__(self, checkpoint: Checkpoint, asked: dict[str, Any], pieces: int = 0, counts: dict[str, int] | None = None):
        self.folder, self.every, self.asked = checkpoint.path, checkpoint.every, asked
        self.pieces, self.since = pieces, 0
        self.counts = counts or dict.fromkeys(("knots", "systems", "steps", "rows", "records", "events"), 0)

    def after_step(self, run: Run) -> None:
        """Write if it is time to: where a run need not go back any more."""
        self.since += 1
        if self.since >= self.every and (run.settings.follow is None or run.looked == 0):
            self.write(run)

    def write(self, run: Run, finished: bool = False) -> None:
        """What came since the last write, then the state."""
        run.solver.forget()
        self.pieces, self.since = self.pieces + 1, 0
        self._meshes(run)
        _save(self.folder / f"piece_{self.pieces:06d}.npz", self._piece(run))
        lists = self._lists(run)
        self.counts = {name: len(values) for name, values in lists.items()}
        text = {"format": FORMAT, "version": __version__, "settings": self.asked["settings"], "pieces": self.pieces,
                "counts": self.counts, "finished": finished}  # fmt: skip
        arrays = {f"asked_{name}": value for name, value in self.asked["arrays"].items()}
        _save(self.folder / STATE, {"text": np.array(json.dumps(text)), **arrays, **_state_of(run)})

    def _lists(self, run: Run) -> dict[str, list[Any]]:
        recorder, book = run.recorder, run.book
        return {"knots": recorder.knots, "systems": recorder.systems, "steps": run.steps, "rows": book.rows,
                "records": recorder.record_times, "events": book.events}  # fmt: skip

    def _piece(self, run: Run) -> dict[str, np.ndarray]:
        counts, recorder, book = self.counts, run.recorder, run.book
        knots, rows = recorder.knots[counts["knots"] :], book.rows[counts["rows"] :]
        out = {
            "knots": np.array([(k.stretch, k.time, k.output) for k in knots], dtype=float).reshape(-1, 3),
            "steps": np.array([astuple(step) for step in run.steps[counts["steps"] :]], dtype=float),
            "book_times": np.array(book.times[counts["rows"] :]),
            "events": np.array([astuple(event) for event in book.events[counts["events"] :]], dtype=float),
            "record_times": np.array(recorder.record_times[counts["records"] :]),
            **{f"book_{name}": np.array([row[name] for row in rows], dtype=float) for name in COLUMNS},
            **{f"record_{name}": np.array(values[counts["records"] :]) for name, values in recorder.values.items()},
        }
        for stretch in sorted({k.stretch for k in knots}):
            for name in ("q", "v"):
                out[f"{name}_{stretch}"] = np.array([getattr(k, name) for k in knots if k.stretch == stretch])
        return out

    def _meshes(self, run: Run) -> None:
        """Meshes other than the first."""
        systems = run.recorder.systems
        for k in range(max(self.counts["systems"], 1), len(systems)):
            if systems[k] is not systems[k - 1]:
                quadtree_file.save(systems[k].mesh, _mesh_file(self.folder, k))


def _mesh_file(folder: Path, stretch: int) -> Path:
    return folder / f"mesh_{stretch:06d}.npz"


def _save(file: Path, arrays: dict[str, np.ndarray]) -> None:
    with replacing(file) as part, part.open("wb") as stream:
        np.savez(stream, **arrays)


def _load(file: Path) -> dict[str, np.ndarray]:
    try:
        with np.load(file, allow_pickle=False) as data:
            return {name: data[name] for name in data.files}
    except Exception as error:  # damage shows in many ways: in numpy's headers, in the archive, in what it unpacks
        raise InputError(f"file '{file}': is no part of a run, or is damaged ({error}); begin in another folder") from error


def _state_of(run: Run) -> dict[str, np.ndarray]:
    state, book = run.state, run.book
    numbers = [state.time, state.dt, run.dt, run.shortest, run.largest, run.solver.energy, float(run.solver.rough),
               float(run.recorder.done), float(len(run.impulses)), book.turnover, float(run.looked)]  # fmt: skip
    sums = {f"sum_{name}": np.asarray(book.sums[name]) for name in SUMS}
    forces = {f"forces_{field.name}": np.asarray(getattr(book.before, field.name)) for field in fields(Forces)}
    return {"numbers": np.array(numbers), "q": state.q, "v": state.v, "a": state.a, **sums, **forces}


def asked_of(run: Run, record: Any, every: int) -> dict[str, Any]:
    """What a run was asked for: settings as texts, and arrays that tell its problem from another."""
    settings, system = run.settings, run.system
    text = {name: _plain(value) for name, value in asdict_of(settings).items()}
    text |= {"outputs": run.recorder.times.tolist(), "record": sorted(record), "every": every,
             "theory": _plain(system.geometry.theory)}  # fmt: skip
    times = np.linspace(settings.begin, settings.end, 7)
    at, geometry = system.undeformed, system.geometry
    size = 1e-3 * np.abs(at).max()
    moved = at + size * np.cos(np.arange(at.size))
    forces = [system.applied_force(moved, t) for t in times]
    arrays = {
        "mesh": geometry.mesh.p, "elements": geometry.mesh.t, "surface": at, "supports": system.constraints.fixed,
        "support_motion": np.array([system.prescribed(t) for t in times]), "stiffness": system.internal_force(moved),
        "mass": system.mass @ moved, "loads": np.array(forces),
        "temperature": np.array([system.external_force(moved, t) - f for t, f in zip(times, forces, strict=True)]),
        "damping": np.append(np.zeros(0) if system.viscous is None else system.viscous @ moved, system.retardation),
        "impulses": np.array([np.append(j, t) for t, j in system.impulses()]), "start": np.stack([run.state.q, run.state.v]),
    }  # fmt: skip
    return {"settings": text, "arrays": arrays}


def asdict_of(settings: Any) -> dict[str, Any]:
    """Fields of a dataclass, as they are."""
    return {field.name: getattr(settings, field.name) for field in fields(settings)}


def _plain(value: Any) -> Any:
    """A number as it is, anything else as its text without addresses."""
    if value is None or isinstance(value, (int, float, str)):
        return value
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))


def resumed(
    checkpoint: Checkpoint, run: Run, asked: dict[str, Any], system_on: Callable[[Any], System]
) -> tuple[Writer, bool] | None:
    """Put a run where the one in the folder is; its writer, and whether it had finished. None if there is none.

    Raises
    ------
    InputError
        For a run of another problem, with other settings, or of another version; the difference is named.
    """
    file = checkpoint.path / STATE
    if not file.exists():
        return None
    data = _load(file)
    text = _checked(file, data, asked)
    writer = Writer(checkpoint, asked, text["pieces"], text["counts"])
    pieces = [_load(checkpoint.path / f"piece_{k:06d}.npz") for k in range(1, text["pieces"] + 1)]
    _restore(run, data, pieces, text["counts"]["systems"], checkpoint.path, system_on)
    return writer, bool(text["finished"])


def _checked(file: Path, data: dict[str, np.ndarray], asked: dict[str, Any]) -> dict[str, Any]:
    def refuse(reason: str) -> InputError:
        return InputError(f"file '{file}': {reason}; go on with what it was begun with, or begin in another folder")

    if "text" not in data:
        raise refuse("is no state of a run")
    text: dict[str, Any] = json.loads(str(data["text"]))
    if text.get("format") != FORMAT:
        raise refuse(f"is {text.get('format')}, this version reads '{FORMAT}'")
    if text["version"] != __version__:
        raise refuse(f"was written by version {text['version']}, this is {__version__}, which may not do the same")
    for name, value in asked["settings"].items():
        if text["settings"].get(name) != value:
            raise refuse(f"its run has {name} = {_short(text['settings'].get(name))}, this one {_short(value)}")
    for name, value in asked["arrays"].items():
        known = data.get(f"asked_{name}")
        if known is None or known.shape != np.shape(value):
            raise refuse(f"its run has another {name.replace('_', ' ')}")
        difference, size = np.abs(np.asarray(known, float) - value).max(initial=0.0), np.abs(value).max(initial=0.0)
        if difference > CLOSE * size:
            raise refuse(f"its run has another {name.replace('_', ' ')}, by {difference / max(size, 1e-300):.1e} of it")
    return text


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 80 else text[:76] + " ..."


def _restore(
    run: Run, data: dict[str, np.ndarray], pieces: list[dict[str, np.ndarray]], n_systems: int, folder: Path,
    system_on: Callable[[Any], System],
) -> None:  # fmt: skip
    recorder, book = run.recorder, run.book
    systems = [run.system]
    for k in range(1, n_systems):
        file = _mesh_file(folder, k)
        systems.append(system_on(quadtree_file.load(file)) if file.exists() else systems[-1])
    recorder.systems, recorder.knots, recorder.record_times = systems, [], []
    recorder.values = {name: [] for name in recorder.values}
    run.steps, book.times, book.rows, book.events = [], [], [], []
    for piece in pieces:
        rows: dict[int, int] = {}
        for stretch, time, output in piece["knots"]:
            k = int(stretch)
            i = rows[k] = rows.get(k, -1) + 1
            recorder.knots.append(Knot(k, float(time), piece[f"q_{k}"][i], piece[f"v_{k}"][i], bool(output)))
        run.steps += [_record(Step, row) for row in piece["steps"]]
        book.times += piece["book_times"].tolist()
        columns = [piece[f"book_{name}"] for name in COLUMNS]
        book.rows += [dict(zip(COLUMNS, row, strict=True)) for row in zip(*columns, strict=True)]
        book.events += [_record(MeshEvent, row) for row in piece["events"]]
        recorder.record_times += piece["record_times"].tolist()
        for name, values in recorder.values.items():
            values += list(piece[f"record_{name}"])
    if systems[-1] is not run.system:
        run.solver.close()
        run._on(systems[-1])
    time, dt, run.dt, run.shortest, run.largest, energy, rough, done, impulses, turnover, looked = data["numbers"].tolist()
    run.state = State(time, data["q"], data["v"], data["a"], dt)
    run.solver.energy, run.solver.rough = energy, bool(rough)
    run.solver.forget()
    recorder.done, run.looked, book.turnover = int(done), int(looked), turnover
    run.impulses = run.impulses[len(run.impulses) - int(impulses) :]
    book.sums = {name: data[f"sum_{name}"] if data[f"sum_{name}"].ndim else float(data[f"sum_{name}"]) for name in SUMS}
    forces = {field.name: data[f"forces_{field.name}"] for field in fields(Forces)}
    book.before = Forces(float(forces.pop("time")), **forces)
    run.mark_here()


def _record(kind: Any, row: np.ndarray) -> Any:
    """A dataclass of numbers from their row."""
    return kind(*(field.type(value) for field, value in zip(fields(kind), row.tolist(), strict=True)))
