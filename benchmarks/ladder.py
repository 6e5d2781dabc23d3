"""One ladder: the runs of a variant of a program on a scene, from coarse to fine, in a process of its own."""

import json
import os
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO

from benchmarks.machine import with_threads

ROOT = Path(__file__).resolve().parent.parent
# Of programs that do not listen to the usual ones.
ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1", "NGS_NUM_THREADS": "1"}
# Seconds for starting a program, which are not compared.
START = 60.0


def ladder(python: Path, arguments: list[str], sizes: list[float], limit: float) -> Iterator[dict[str, Any]]:
    """What the worker says of each run, and as ``{"end": text}`` how it ended: empty for a ladder that is done.

    The limit (s) holds from the first run on.
    """
    command = [str(python), "-m", "benchmarks.worker", *arguments, *(f"{size:g}" for size in sizes)]
    last = "its start"
    with tempfile.TemporaryFile("w+") as errors, process(command, errors) as worker:
        alarm = Alarm(worker, START)
        try:
            assert worker.stdout is not None
            for line in worker.stdout:
                if not line.startswith("@"):
                    continue
                found = json.loads(line[1:])
                if "version" in found:
                    alarm.set(limit)
                last = f"size {found['size']:g}" if "size" in found else "its first run"
                yield found
        finally:
            alarm.cancel()
        yield {"end": how_it_ended(worker, alarm, last, errors)}


def how_it_ended(worker: "subprocess.Popen[str]", alarm: "Alarm", last: str, errors: TextIO) -> str:
    if alarm.rang:
        return f"time was up after {last}"
    code = worker.wait()
    if code == 0:
        return ""
    errors.seek(0)
    said = [line.strip() for line in errors.read().splitlines() if line.strip()]
    return f"ended with code {code} after {last}: {said[-1][:200] if said else 'without a word'}"


class Alarm:
    """Ends a worker when its time is up, and remembers that."""

    def __init__(self, worker: "subprocess.Popen[str]", seconds: float) -> None:
        self.worker, self.rang = worker, False
        self.set(seconds)

    def set(self, seconds: float) -> None:
        self.cancel()
        self.timer = threading.Timer(seconds, self.ring)
        self.timer.daemon = True
        self.timer.start()

    def cancel(self) -> None:
        if hasattr(self, "timer"):
            self.timer.cancel()

    def ring(self) -> None:
        self.rang = True
        end(self.worker)


@contextmanager
def process(command: list[str], errors: TextIO) -> Iterator["subprocess.Popen[str]"]:
    """A worker on one thread, that is ended with the processes that it has started."""
    environment = {**with_threads(1), **ONE_THREAD}
    worker = subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=errors, text=True, start_new_session=True
    )
    try:
        yield worker
    finally:
        end(worker)
        worker.wait()


def end(worker: "subprocess.Popen[str]") -> None:
    with suppress(ProcessLookupError):
        os.killpg(worker.pid, 9)
