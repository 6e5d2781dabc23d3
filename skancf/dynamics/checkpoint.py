r"""Runs on disk: what a run has is written while it goes on, and a run that was cut off continues bit for bit.

A folder holds what was asked for, numbered pieces, each with what came since the one before, the meshes, and one file with
the present state, which names the others and their digests. Every file is whole or not there, and the state is written last:
a crash loses what came after it, and no more.
"""

import time as clock
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import SYSTEM, instance, whole
from skancf.atomic import AnyPath, as_path, check_folder, reason
from skancf.dynamics.asked import Asked, asked_problem
from skancf.dynamics.ledger import SUMS, Book, Forces
from skancf.dynamics.motion import Motion
from skancf.dynamics.recorder import Recorder
from skancf.dynamics.run import Run
from skancf.dynamics.run_files import PIECE, REST, RUN, STATE, STOPPED, Kept, RunFiles
from skancf.dynamics.run_lock import RunLock
from skancf.dynamics.state import State
from skancf.dynamics.step_solver import Effort
from skancf.errors import InputError, SkancfError
from skancf.solving import Status
from skancf.system.system import System

N_NUMBERS = 12
"""In a state."""
PROBLEM = "give read_motion the system of the run, the problem on the mesh that it began with"


@dataclass(frozen=True)
class Checkpoint:
    """Where a run is written while it goes on, and how often.

    Parameters
    ----------
    folder : str or Path
        For this run alone, and for one process at a time: while one writes, a second is refused. A process that was killed
        is in nobody's way.
    every : int
        Accepted steps between two writes. With meshes that follow the motion it is done at the next look at the mesh. The
        factors of the tangent are renewed then, so that a run that starts there does the same: not too often. On 1000
        elements a write takes as long as a third of a step, and new factors as ten: with the default a tenth of the time,
        or less where factors are renewed anyway.

    Raises
    ------
    InputError
        For a number of steps that is none.

    Notes
    -----
    The bytes of a run that was cut off are those of one that was not, if machine, packages and number of cores stay the same
    and functions given by the user give the same each time. A policy of meshes or steps must not remember anything itself.
    """

    folder: AnyPath
    every: int = 100

    def __post_init__(self) -> None:
        as_path("folder", self.folder)
        object.__setattr__(self, "every", whole("every", self.every))

    def attach(self, run: Run, asked: Asked, resume: bool) -> "Writer":
        """The writer of a run: at its start, or where the one in the folder is if ``resume``.

        Raises
        ------
        InputError
            For a folder that cannot be written, into which another process writes, or that holds a run that is not to go on
            or that was asked for something else.
        """
        folder = check_folder(self.folder)
        lock = RunLock(folder)
        lock.take()
        try:
            writer = self._attached(folder, run, asked, resume)
        except BaseException:
            lock.release()
            raise
        writer.lock = lock
        return writer

    def _attached(self, folder: Path, run: Run, asked: Asked, resume: bool) -> "Writer":
        files, begun = RunFiles(folder), (folder / STATE).exists()
        if begun and not resume:
            raise InputError(f"folder '{folder}': holds a run already; go on with it by resume=True, choose another "
                             "folder, or remove it")  # fmt: skip
        if not begun and (folder / PIECE.format(2)).exists():
            raise InputError(f"folder '{folder}': holds pieces of a run, but '{STATE}' is missing; bring it back, or begin "
                             "in another folder")  # fmt: skip
        files.clean()
        if begun:
            return _resumed(files, self.every, run, asked)
        writer = Writer(files, self.every)
        writer.begin(run, asked)
        return writer


class Writer:
    """Writes a run piece by piece.

    Attributes
    ----------
    finished : bool
        The run in the folder has reached its end.
    """

    def __init__(
        self, files: RunFiles, every: int, pieces: int = 0, counts: dict[str, int] | None = None, spent: float = 0.0
    ):  # fmt: skip
        self.files, self.every, self.pieces, self.since = files, every, pieces, 0
        self.counts = counts or dict.fromkeys(("knots", "systems", "steps", "rows", "records", "events"), 0)
        self.spent, self.began, self.time, self.finished = spent, clock.perf_counter(), 0.0, False
        self.lock: RunLock | None = None

    @property
    def seconds(self) -> float:
        """Wall time of all processes that this run has taken."""
        return self.spent + clock.perf_counter() - self.began

    def close(self) -> None:
        """Let other processes write into the folder."""
        if self.lock is not None:
            self.lock.release()

    def begin(self, run: Run, asked: Asked) -> None:
        """What was asked for, and the first state."""
        try:
            self.files.write_asked(asked)
        except OSError as error:
            raise self._failed(error) from error
        self.write(run)

    def after_step(self, run: Run) -> None:
        """Write if it is time to: where a run need not go back any more."""
        self.since += 1
        if self.since >= self.every and (run.settings.follow is None or run.looked == 0):
            self.write(run)

    def write(self, run: Run, finished: bool = False) -> None:
        """What came since the last write, then the state.

        Raises
        ------
        SkancfError
            Where the folder cannot be written any more; what it holds stays as it is.
        """
        run.solver.forget()
        kept = Kept(run.recorder, run.steps, run.book)
        try:
            self._write(run, kept, PIECE.format(self.pieces + 1))
            self.files.remove(STOPPED)
            self.files.remove(REST)
            status = Status.FINISHED if finished else Status.UNFINISHED
            self._write_state(STATE, run, kept, self.pieces + 1, status)
        except OSError as error:
            raise self._failed(error) from error
        self.pieces, self.counts, self.since, self.time = self.pieces + 1, kept.counts, 0, run.state.time

    def stopped(self, run: Run, status: Status, message: str) -> None:
        """What a run that stopped before its end has computed since the last write, where the folder still takes it."""
        kept = Kept(run.recorder, run.steps, run.book)
        with suppress(OSError, SkancfError):
            self.files.remove(STOPPED)
            self._write(run, kept, REST)
            self._write_state(STOPPED, run, kept, self.pieces, status, message)

    def _write(self, run: Run, kept: Kept, name: str) -> None:
        if not (self.files.folder / RUN).exists():  # else a mesh might make the folder anew, without what was in it
            raise FileNotFoundError(2, "it is gone, or what was in it")
        self.files.write_meshes(run.recorder.systems, self.counts["systems"])
        self.files.write(name, kept.since(self.counts))

    def _write_state(
        self, name: str, run: Run, kept: Kept, pieces: int, status: Status, message: str = ""
    ) -> None:  # fmt: skip
        text = {"pieces": pieces, "counts": kept.counts, "status": status.name, "message": message, "seconds": self.seconds}
        self.files.write_state(name, text, _state_of(run))

    def _failed(self, error: OSError) -> SkancfError:
        way = f"it holds the run until t = {self.time:.6g} s. Make room, or bring it back, and go on by resume=True"
        if isinstance(error, FileNotFoundError):
            way = f"it held the run until t = {self.time:.6g} s. Bring it back and go on by resume=True, or begin in another"
        return SkancfError(f"folder '{self.files.folder}' cannot be written any more ({reason(error)}); {way}")


def _state_of(run: Run) -> dict[str, np.ndarray]:
    state, book = run.state, run.book
    numbers = [state.time, state.dt, run.dt, run.shortest, run.farthest, run.hardest, run.solver.energy,
               float(run.solver.effort), float(run.recorder.done), float(len(run.strikes)), book.turnover,
               float(run.mark.tries)]  # fmt: skip
    sums = {f"sum_{name}": np.asarray(book.sums[name]) for name in SUMS}
    forces = {f"forces_{field.name}": np.asarray(getattr(book.before, field.name)) for field in fields(Forces)}
    return {"numbers": np.array(numbers), "missed": run.impulses.missed, "origin": run.origin,
            "q": state.q, "v": state.v, "a": state.a, **sums, **forces,
            **{name: np.zeros(0) if value is None else value for name, value in _optional(state).items()}}  # fmt: skip


def _optional(state: State) -> dict[str, np.ndarray | None]:
    """What only some rules keep of a state."""
    return {"jerk": state.jerk, "before": state.before}


def _resumed(files: RunFiles, every: int, run: Run, asked: Asked) -> Writer:
    """Puts a run where the one in the folder is."""
    text, data = files.read_state()
    difference = asked.difference(files.read_asked())
    if difference:
        raise files.refused(STATE, difference)
    files.read_kept(text, Kept(run.recorder, run.steps, run.book), run.system)
    _check(files, data, run.recorder.systems[-1])
    _restore(run, data)
    writer = Writer(files, every, text["pieces"], text["counts"], text["seconds"])
    writer.time, writer.finished = run.state.time, Status[text["status"]].ok
    return writer


def _check(files: RunFiles, data: dict[str, np.ndarray], system: System) -> None:
    shapes = {"numbers": (N_NUMBERS,), **dict.fromkeys(("q", "v", "a", "origin"), (system.n_dofs,))}
    names = [*shapes, "missed", "jerk", "before", *(f"sum_{name}" for name in SUMS),
             *(f"forces_{field.name}" for field in fields(Forces))]  # fmt: skip
    if any(name not in data or data[name].shape != shapes.get(name, data[name].shape) for name in names):
        raise files.refused(STATE, "is no state of a run")


def _restore(run: Run, data: dict[str, np.ndarray]) -> None:
    recorder, book = run.recorder, run.book
    if recorder.systems[-1] is not run.system:
        run.solver.close()
        run._on(recorder.systems[-1])
    numbers = data["numbers"].tolist()
    time, dt, run.dt, run.shortest, run.farthest, run.hardest, energy, effort, done, strikes, turnover, tries = numbers
    jerk, before = (data[name] if data[name].size else None for name in ("jerk", "before"))
    run.state = State(time, data["q"], data["v"], data["a"], dt, jerk, before)
    run.solver.energy, run.solver.effort = energy, Effort(int(effort))
    run.solver.forget()
    recorder.done, book.turnover = int(done), turnover
    run.strikes = run.strikes[len(run.strikes) - int(strikes) :]
    run.impulses.missed, run.origin = data["missed"], data["origin"]
    book.sums = {name: data[f"sum_{name}"] if data[f"sum_{name}"].ndim else float(data[f"sum_{name}"]) for name in SUMS}
    forces = {field.name: data[f"forces_{field.name}"] for field in fields(Forces)}
    book.before = Forces(float(forces.pop("time")), **forces)
    run.mark_here(int(tries))


def read_motion(system: System, folder: AnyPath) -> Motion:
    """What a run has written to its folder, without computing: of one that was cut off, or still goes on.

    Parameters
    ----------
    system : System
        The problem on the mesh with which the run began; settings of the run are not asked for.
    folder : str or Path
        Of the run's :class:`Checkpoint`.

    Returns
    -------
    Motion
        Until the last write, or until the run stopped by itself, with its reason; of a process that was killed, or still
        goes on, the status is ``UNFINISHED``.

    Raises
    ------
    InputError
        For a folder without a run, a run of another problem, mesh or theory, and files that are damaged.

    Examples
    --------
    >>> motion = sk.read_motion(system, "run")
    >>> motion.times[-1], motion.status
    """
    instance("system", system, System, SYSTEM)
    files = RunFiles(as_path("folder", folder))
    if not (files.folder / STATE).exists():
        raise InputError(f"folder '{files.folder}': holds no run; give the folder of a Checkpoint")
    text, data = files.read_state()
    if (files.folder / STOPPED).exists():
        text, data = files.read_state(STOPPED)
    known = files.read_asked()
    difference = asked_problem(system, known.settings["begin"], known.settings["end"]).difference(known)
    if difference:
        raise InputError(f"folder '{files.folder}': {difference}; {PROBLEM}")
    names: dict[str, Any] = dict.fromkeys(known.settings["record"])
    outputs = known.settings["outputs"]
    recorder = Recorder(None if outputs == "steps" else np.array(outputs), names)
    at = system.undeformed
    kept = Kept(recorder, [], Book(system, State(known.settings["begin"], at, np.zeros_like(at), np.zeros_like(at))))
    files.read_kept(text, kept, system)
    _check(files, data, recorder.systems[-1])
    time = float(data["numbers"][0])
    recorder.end(State(time, data["q"], data["v"], data["a"]))
    status, message = Status[text["status"]], text["message"]
    if status is Status.UNFINISHED:
        message = f"written until t = {time:.6g} s of {known.settings['end']:.6g} s"
    return Motion(recorder.stretches, tuple(kept.steps), kept.book.ledger(), recorder.records, status, message,
                  text["seconds"])  # fmt: skip
