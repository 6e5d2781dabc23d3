"""The first use on a machine compiles kernels: whoever waits for that sees it, and how long it took."""

import atexit
import logging
import sys
import threading
import time
from functools import cache
from typing import Any

from numba.core import event

from skancf.progress import Line, clear_bar, is_watched

logger = logging.getLogger(__name__)

TICK = 0.25
"""Seconds from one drawing of the line to the next."""
OVER = 1.5
"""Seconds without a compilation after which it counts as finished."""
EXPECTED = "once per machine, about 30 s"


class Announcer(event.Listener, Line):
    """Hears of every compilation by numba, and tells of those of this package.

    While one is on, a line on stderr counts kernels and seconds, if someone watches; another one gives their sum when no
    more come. The logger gets both in any case.

    Attributes
    ----------
    kernels : int
        Functions compiled since the last sum, of those that are called from Python.
    seconds : float
        How long they took.
    total : int
        Functions compiled in this process.
    """

    def __init__(self) -> None:
        super().__init__()
        self.kernels, self.seconds, self.total = 0, 0.0, 0
        self._depth, self._begun, self._ended = 0, 0.0, 0.0
        self._wide, self._told = 0, False
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    def on_start(self, event: Any) -> None:
        if not is_ours(event):
            return
        self._depth += 1
        if self._depth > 1:
            return
        self._begun = time.perf_counter()
        if not self._told:
            self._told = True
            logger.info("compiling kernels (%s)", EXPECTED)
        if is_watched():
            clear_bar()
            self._draw()
            if self._thread is None:
                self._thread = threading.Thread(target=self._tick, name="skancf compiling", daemon=True)
                self._thread.start()

    def on_end(self, event: Any) -> None:
        if not is_ours(event):
            return
        self._depth -= 1
        if self._depth:
            return
        self._ended = time.perf_counter()
        took = self._ended - self._begun
        self.kernels, self.seconds, self.total = self.kernels + 1, self.seconds + took, self.total + 1
        logger.info("compiled %s in %.1f s", _name(event), took)
        # What the user prints next is to begin a line of its own.
        self._clear()

    @property
    def is_on(self) -> bool:
        """Whether a compilation is on."""
        return self._depth > 0

    def finish(self) -> None:
        """Say how long it took, if it was shown and is over."""
        if self.is_on or self._thread is None or not self.kernels:
            return
        self._write(f"compiled {self.kernels} kernels in {self.seconds:.0f} s; later runs load them\n")
        self.kernels, self.seconds, self._thread = 0, 0.0, None

    def _tick(self) -> None:
        while self._thread is threading.current_thread():
            time.sleep(TICK)
            if self.is_on:
                self._draw()
            elif time.perf_counter() - self._ended > OVER:
                self.finish()

    def _draw(self) -> None:
        with self._lock:
            if self.is_on:
                seconds = self.seconds + time.perf_counter() - self._begun
                text = f"compiling kernels ({EXPECTED}): {self.kernels} done, {seconds:.0f} s"
                self._write(f"\r{text}")
                self._wide = len(text)

    def _clear(self) -> None:
        with self._lock:
            if self._wide:
                self._write(f"\r{' ' * self._wide}\r")
                self._wide = 0

    @staticmethod
    def _write(text: str) -> None:
        sys.stderr.write(text)
        sys.stderr.flush()


def is_ours(event: Any) -> bool:
    """Whether an event belongs to a function of this package."""
    return str(event.data["dispatcher"].py_func.__module__).startswith("skancf.")


def _name(event: Any) -> str:
    function = event.data["dispatcher"].py_func
    return f"{function.__module__}.{function.__name__}"


@cache
def announce() -> Announcer:
    """Begin to listen, once in a process."""
    announcer = Announcer()
    event.register("numba:compile", announcer)
    announcer.share()
    atexit.register(announcer.finish)
    return announcer
