"""How far long work is: shown as a bar, or told to a function."""

import sys
import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from skancf.arguments import flag
from skancf.errors import InputError, shown
from skancf.functions import called
from skancf.showing import short, summary

DELAY = 1.0
"""Seconds after which work counts as long: shorter work shows no bar."""
INTERVAL = 0.1
"""Seconds from one drawing of a bar to the next."""


@dataclass(frozen=True)
class Progress:
    """One step of long work, as a function given as ``progress`` receives it.

    Every function of the library that may take long has an argument ``progress``. With True, the default, a bar appears on
    stderr when the work has taken a second, if stderr is a terminal or the code runs in a notebook; elsewhere nothing
    is written. With False nothing is shown. A function is called with an object of this class after each step, and what it
    returns is not used. An exception in it ends the work as an error in a load would, and KeyboardInterrupt ends it as
    Ctrl-C does: what was computed is kept where the result can hold it.

    Attributes
    ----------
    what : str
        The work: "statics", "path", "modes", "buckling", "dynamics", "adapt", "estimate", "write" and the like.
    done : float
        How far it is, in the unit of ``total``: the part of the load, steps, seconds of the motion, or number of states.
    total : float or None
        Where it ends. None where that is not known, as for the solves of an eigenvalue problem.
    note : str
        What was found last, in words.

    Examples
    --------
    >>> seen = []
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(70e9, 0.3, 2700.0),
    ...                    [sk.Clamp("left")], [sk.EdgeLoad("right", (0.0, 0.0, 100.0))])
    >>> result = sk.solve(plate.on(sk.meshes.uniform(plate.surface, 2, 2)), progress=seen.append)
    >>> seen[-1].what, seen[-1].share
    ('statics', 1.0)
    """

    what: str
    done: float
    total: float | None
    note: str = ""

    __repr__ = short

    @property
    def share(self) -> float | None:
        """The part that is done, from 0 to 1; None where the end is not known."""
        return min(1.0, max(0.0, self.done / self.total)) if self.total else None

    @summary
    def __str__(self) -> str:
        far = f"{self.done:g}" if self.share is None else f"{self.share:.0%}"
        return f"{self.what}: {far}{', ' + self.note if self.note else ''}"


ShowProgress = bool | Callable[[Progress], Any]


def check_progress(progress: Any) -> None:
    """InputError for what is no truth value and no function."""
    if callable(progress) and not isinstance(progress, type):
        return
    try:
        flag("progress", progress)
    except InputError as wrong:
        raise InputError(f"progress = {shown(progress)}: give True, False, or a function that takes a Progress") from wrong


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config


def is_watched() -> bool:
    """Whether someone may look at stderr: it is a terminal, or the code runs in a notebook."""
    return (sys.stderr is not None and sys.stderr.isatty()) or in_notebook()


def number_of(items: Any) -> int | None:
    """How many there are; None of a generator."""
    return len(items) if hasattr(items, "__len__") else None


_outermost: ContextVar["Bar | None"] = ContextVar("_outermost", default=None)


class Line:
    """Another line of the library on the terminal, as that of the compiler: bars wait while it is on."""

    @property
    def is_on(self) -> bool:
        """Whether it is shown."""
        return False

    def finish(self) -> None:
        """Leave the terminal to a bar."""

    def share(self) -> None:
        """Let bars know of it."""
        _lines.append(self)


_lines: list[Line] = []


def clear_bar() -> None:
    """Take the bar that is shown from the terminal, until it is drawn again."""
    top = _outermost.get()
    if top is not None:
        top.clear()


class Bar:
    """A bar for the work in a ``with`` block, or calls of a function.

    Of bars inside of each other the outermost is drawn, and the notes of the others appear in it.

    Parameters
    ----------
    what : str
        Name of the work.
    total : float or None
        Where it ends; None where that is not known.
    progress : bool or callable
        See :class:`Progress`.
    """

    def __init__(self, what: str, total: float | None, progress: ShowProgress = False) -> None:
        self.what, self.total = what, total
        self._tell = progress if callable(progress) else None
        self._drawn = self._tell is None and bool(progress) and is_watched()
        self._top: Bar | None = None
        self._bar: Any = None
        self._begun = self._last = 0.0
        self.done, self._note = 0.0, ""

    def __enter__(self) -> "Bar":
        self._top = _outermost.get()
        if self._top is None and self._drawn:
            self._top, self._begun = self, time.perf_counter()
            self._last = self._begun + DELAY - INTERVAL
            _outermost.set(self)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._top is not self:
            return
        _outermost.set(None)
        if self._bar is not None:
            self._draw(self._note)
            self._bar.close()

    def at(self, done: float, note: str = "") -> None:
        """Say how far the work is."""
        self.done, self._note = done, note
        if self._tell is not None:
            called("progress", self._tell, Progress(self.what, done, self.total, note))
        if self._top is self:
            self._draw_in_time(note)
        elif self._top is not None:
            self._top._draw_in_time(f"{self._top._note}; {self.what}: {note}" if self._top._note else f"{self.what}: {note}")

    def next(self, note: str) -> None:
        """One step more."""
        self.at(self.done + 1, note)

    def counting(self, function: Callable[[Any], Any], note: str) -> Callable[[Any], Any]:
        """A function of one argument, each call of which is a step."""

        def counted(argument: Any) -> Any:
            found = function(argument)
            self.next(note)
            return found

        return counted

    def _draw_in_time(self, note: str) -> None:
        now = time.perf_counter()
        if now - self._last < INTERVAL or any(line.is_on for line in _lines):
            return
        self._last = now
        self._draw(note)

    def clear(self) -> None:
        """Take it from the terminal."""
        if self._bar is not None:
            self._bar.clear()

    def _draw(self, note: str) -> None:
        for line in _lines:
            line.finish()
        if self._bar is None:
            self._bar = _tqdm(self.what, self.total)
            self._bar.start_t = self._begun_by_clock()
        self._bar.n = self.done if self.total is None else min(self.done, self.total)
        self._bar.set_postfix_str(note, refresh=False)
        self._bar.refresh()

    def _begun_by_clock(self) -> float:
        """When the work began, by the clock of tqdm."""
        return float(self._bar._time() - (time.perf_counter() - self._begun))


def _tqdm(what: str, total: float | None) -> Any:
    from tqdm.auto import tqdm

    bar = "{bar}" if in_notebook() else "{bar:20}"
    known = "{desc}: {percentage:3.0f}%|" + bar + "| {elapsed}<{remaining}{postfix}"
    return tqdm(desc=what, total=total, file=sys.stderr, dynamic_ncols=True,
                bar_format="{desc}: {n:g} [{elapsed}{postfix}]" if total is None else known)  # fmt: skip
