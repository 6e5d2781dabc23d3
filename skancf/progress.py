"""A progress bar for long work."""

import sys
import time
from types import TracebackType

WIDTH = 30


class Progress:
    """A bar on stderr that rewrites its line at most ten times a second; without a terminal it prints its end only."""

    def __init__(self, name: str, end: float, *, shown: bool = True):
        self.name, self.end, self.shown = name, end, shown
        self._start = self._last = time.perf_counter()
        self._line = ""

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.shown and self._line:
            sys.stderr.write(("\r" if sys.stderr.isatty() else "") + self._line + "\n")
            sys.stderr.flush()

    def at(self, value: float, note: str = "") -> None:
        """Show how far the work is."""
        if not self.shown:
            return
        share = min(1.0, max(0.0, value / self.end))
        bar = "#" * round(WIDTH * share)
        seconds = time.perf_counter() - self._start
        self._line = f"{self.name} [{bar:<{WIDTH}}] {100 * share:3.0f} %  {seconds:6.1f} s  {note:<40.60}"
        if sys.stderr.isatty() and time.perf_counter() - self._last > 0.1:
            self._last = time.perf_counter()
            sys.stderr.write("\r" + self._line)
            sys.stderr.flush()
