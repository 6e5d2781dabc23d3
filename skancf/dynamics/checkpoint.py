r"""Runs on disk: what a run has is written while it goes on, and a run that was cut off continues bit for bit.

A folder holds what was asked for, numbered pieces, each with what came since the one before, the meshes, and one file with
the present state, which names the others and their digests. Every file is whole or not there, and the state is written last:
a crash loses what came after it, and no more.
"""

import time as clock
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import SYSTEM, flag, instance, whole
from skancf.atomic import AnyPath, as_path, check_folder, reason
from skancf.dynamics.fingerprint import Fingerprint, difference, fingerprint_of_problem
from skancf.dynamics.ledger import LedgerRecorder
from skancf.dynamics.log import Log
from skancf.dynamics.motion import Motion, Step
from skancf.dynamics.named_state import flat, nested
from skancf.dynamics.pieces import States
from skancf.dynamics.recorder import Recorder
from skancf.dynamics.run import Run, logs_of
from skancf.dynamics.run_files import PIECE, REST, RUN, STATE, STOPPED, RunFiles, under
from skancf.dynamics.run_lock import RunLock
from skancf.dynamics.state import State
from skancf.errors import InputError, SkancfError
from skancf.showing import short
from skancf.solving import Status
from skancf.system.system import System

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
        Accepted steps between two writes. With meshes that follow the motion it is done at the next check of the mesh. The
        factors of the tangent are renewed then, so that a run that starts there does the same: not too often. On 1000
        elements a write takes as long as a third of a step, and new factors as ten: with the default a tenth of the time,
        or less where factors are renewed anyway.
    in_memory : bool
        False for a run whose states do not fit into memory: those that are written are let go, and read from the folder
        when the motion is asked for them. The folder must stay where it is; :func:`~skancf.save` makes one file of it, a
        piece at a time. What is kept of every step beside its state stays in memory, 2 kB or so and its records.

    Raises
    ------
    InputError
        For an invalid number of steps.

    Notes
    -----
    The bytes of a run that was cut off are those of one that was not, if machine, packages and number of cores stay the same
    and functions given by the user give the same each time. What a policy of meshes, a control of steps, a rule or a term
    remembers is part of the run if it says so, see :class:`~skancf.dynamics.HasState`; else it must not remember anything.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> keep = sk.Checkpoint("run", every=50)
    >>> motion = sk.simulate(system, 0.005, rtol=1e-2, checkpoint=keep, progress=False)
    >>> again = sk.simulate(system, 0.005, rtol=1e-2, checkpoint=keep, resume=True, progress=False)
    >>> print(np.array_equal(motion.q, again.q))
    True
    """

    folder: AnyPath
    every: int = 100
    in_memory: bool = True

    __repr__ = short

    def __post_init__(self) -> None:
        as_path("folder", self.folder)
        object.__setattr__(self, "in_memory", flag("in_memory", self.in_memory))
        object.__setattr__(self, "every", whole("every", self.every))


class Writer:
    """Writes a run piece by piece, from its start, or from where the one in the folder is if ``resume``; nobody else may.

    Attributes
    ----------
    finished : bool
        The run in the folder has reached its end.

    Raises
    ------
    InputError
        For a folder that cannot be written, into which another process writes, or that holds a run that is not to go on or
        that was asked for something else.
    """

    def __init__(self, checkpoint: Checkpoint, run: Run, fingerprint: Fingerprint, resume: bool):
        self.files, self.every = RunFiles(check_folder(checkpoint.folder)), checkpoint.every
        self.pieces, self.since, self.counts = 0, 0, dict.fromkeys(run.logs, 0)
        self.spent, self.began, self.time, self.finished = 0.0, clock.perf_counter(), 0.0, False
        if not checkpoint.in_memory:
            run.recorder.states = States(self.files, run.recorder.logs["knots"])
        self.lock = RunLock(self.files.folder)
        self.lock.take()
        try:
            self._attach(run, fingerprint, resume)
        except BaseException:
            self.close()
            raise

    @property
    def seconds(self) -> float:
        """Wall time of all processes that this run has taken."""
        return self.spent + clock.perf_counter() - self.began

    def close(self) -> None:
        """Let other processes write into the folder."""
        self.lock.release()

    def _attach(self, run: Run, fingerprint: Fingerprint, resume: bool) -> None:
        files, folder = self.files, self.files.folder
        begun = (folder / STATE).exists()
        if begun and not resume:
            raise InputError(f"folder '{folder}': holds a run already; go on with it by resume=True, choose another "
                             "folder, or remove it")  # fmt: skip
        if not begun and (folder / PIECE.format(2)).exists():
            raise InputError(f"folder '{folder}': holds pieces of a run, but '{STATE}' is missing; bring it back, or begin "
                             "in another folder")  # fmt: skip
        files.clean()
        if begun:
            self._resume(run, fingerprint)
            return
        try:
            files.write(RUN, fingerprint)
        except OSError as error:
            raise self._failed(error) from error
        self.write(run)

    def _resume(self, run: Run, fingerprint: Fingerprint) -> None:
        """Put a run where the one in the folder is."""
        files = self.files
        arrays = files.read_state()
        differs = difference(fingerprint, files.read(RUN))
        if differs:
            raise files.refused(STATE, differs)
        head = _read(files, arrays, run.logs, run.recorder, run.system)
        try:
            run.restore(nested(under("run", arrays), run.state()))
        except ValueError as error:
            raise files.refused(STATE, f"is no state of a run ({error})") from error
        run.set_rollback(run.tries)
        self.pieces, self.spent, self.finished = head["pieces"], head["seconds"], Status[head["status"]].ok
        self._written(run)

    def _written(self, run: Run) -> None:
        self.since, self.time, self.counts = 0, run.now.time, {name: len(log) for name, log in run.logs.items()}

    def after_step(self, run: Run) -> None:
        """Write if it is time to: where a run need not go back any more."""
        self.since += 1
        if self.since >= self.every and (run.settings.follow is None or run.since_check == 0):
            self.write(run)

    def write(self, run: Run, finished: bool = False) -> None:
        """What came since the last write, then the state.

        Raises
        ------
        SkancfError
            Where the folder cannot be written any more; what it holds stays as it is.
        """
        run.solver.forget()
        status = Status.FINISHED if finished else Status.UNFINISHED
        try:
            self._write_logs(PIECE.format(self.pieces + 1), run)
            self.files.remove(STOPPED)
            self.files.remove(REST)
            self._write_state(STATE, run, self.pieces + 1, status)
        except OSError as error:
            raise self._failed(error) from error
        self.pieces += 1
        self._written(run)
        if run.recorder.states is not None:
            run.recorder.states.let_go(PIECE.format(self.pieces))

    def stopped(self, run: Run, status: Status, message: str) -> None:
        """What a run that stopped before its end has computed since the last write, where the folder still takes it."""
        with suppress(OSError, SkancfError):
            self.files.remove(STOPPED)
            self._write_logs(REST, run)
            self._write_state(STOPPED, run, self.pieces, status, message)

    def _write_logs(self, name: str, run: Run) -> None:
        if not (self.files.folder / RUN).exists():  # else a mesh might make the folder anew, without what was in it
            raise FileNotFoundError(2, "it is gone, or what was in it")
        self.files.write_meshes(run.recorder.systems)
        self.files.write(name, flat({log: rows.since(self.counts[log]) for log, rows in run.logs.items()}))

    def _write_state(self, name: str, run: Run, pieces: int, status: Status, message: str = "") -> None:
        head = {"pieces": pieces, "status": status.name, "message": message, "seconds": self.seconds}
        self.files.write_state(name, {**head, "run": run.state()})

    def _failed(self, error: OSError) -> SkancfError:
        way = f"it holds the run until t = {self.time:.6g} s. Make room, or bring it back, and go on by resume=True"
        if isinstance(error, FileNotFoundError):
            way = f"it held the run until t = {self.time:.6g} s. Bring it back and go on by resume=True, or begin in another"
        return SkancfError(f"folder '{self.files.folder}' cannot be written any more ({reason(error)}); {way}")


def _read(
    files: RunFiles, arrays: dict[str, np.ndarray], logs: dict[str, Log], recorder: Recorder, first: System
) -> dict[str, Any]:
    """All that was kept, with the systems of all segments, each of which begins with a knot; what else a state says."""
    try:
        head = {name: arrays[name].item() for name in ("pieces", "status", "message", "seconds")}
        names = [PIECE.format(k) for k in range(1, head["pieces"] + 1)]
        for log in logs.values():
            log.clear()
        for name in (*names, *({REST} & files.digests.keys())):
            piece = files.read(name)
            for title, log in logs.items():
                log.add(under(title, piece))
            if recorder.states is not None:
                recorder.states.let_go(name)
        fits = {name: len(log) for name, log in logs.items()} == under("run.counts", arrays)
    except (KeyError, ValueError, TypeError, IndexError) as error:
        if isinstance(error, InputError):
            raise
        raise files.refused(STATE, f"does not fit its pieces ({error!r})") from error
    if not fits:
        raise files.refused(STATE, "does not fit its pieces")
    recorder.systems = files.read_systems(logs["knots"][-1].segment + 1, first)
    return head


def read_motion(system: System, folder: AnyPath, *, in_memory: bool = True) -> Motion:
    """What a run has written to its folder, without computing: of one that was cut off, or still goes on.

    Parameters
    ----------
    system : System
        The problem on the mesh with which the run began; settings of the run are not asked for.
    folder : str or Path
        Of the run's :class:`Checkpoint`.
    in_memory : bool
        False: states stay in the folder, and are read when the motion is asked for them.

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
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rtol=1e-2, checkpoint=sk.Checkpoint("kept"), progress=False)
    >>> print(np.array_equal(sk.read_motion(system, "kept").q, motion.q))
    True
    """
    instance("system", system, System, SYSTEM)
    files = RunFiles(as_path("folder", folder))
    if not (files.folder / STATE).exists():
        raise InputError(f"folder '{files.folder}': holds no run; give the folder of a Checkpoint")
    arrays = files.read_state()
    if (files.folder / STOPPED).exists():
        arrays = files.read_state(STOPPED)
    known = files.read(RUN)
    differs = difference(fingerprint_of_problem(system, float(known["begin"]), float(known["end"])), known)
    if differs:
        raise InputError(f"folder '{files.folder}': {differs}; {PROBLEM}")
    outputs = known["outputs"] if known["outputs"].ndim else None
    names: dict[str, Any] = dict.fromkeys(known["record"].tolist())
    steps, recorder, ledger = Log(Step), Recorder(outputs, names), LedgerRecorder()
    if not flag("in_memory", in_memory):
        recorder.states = States(files, recorder.logs["knots"])
    head = _read(files, arrays, logs_of(steps, recorder, ledger), recorder, system)
    time, q, v = (arrays.get(f"run.now.{name}", np.empty(0)) for name in ("time", "q", "v"))
    if time.shape or not q.shape == v.shape == (recorder.systems[-1].n_dofs,):
        raise files.refused(STATE, "is no state of a run")
    recorder.end(State(float(time), q, v, np.zeros_like(v)))
    status, message = Status[head["status"]], head["message"]
    if status is Status.UNFINISHED:
        message = f"written until t = {float(time):.6g} s of {float(known['end']):.6g} s"
    return Motion(recorder.segments, tuple(steps), ledger.as_ledger(), recorder.records, status, message, head["seconds"])
