"""One loop for load steps, paths, motions and meshes: whatever ends it, what was computed is kept."""

import logging
from collections.abc import Callable

from skancf.errors import is_silenced
from skancf.solving.status import Status

End = tuple[Status, str]
"""How a run ended, and why in words."""


def run_steps(
    step: Callable[[], End | None],
    interrupted: Callable[[], str | None],
    failed: Callable[[Exception], str | None],
    log: logging.Logger,
) -> End:
    """Step until one is the last; an interruption and an error are ends like others.

    Parameters
    ----------
    step : callable
        One step; returns how the run ended, or None to go on. What it computes it keeps where the caller finds it.
    interrupted, failed : callable
        What is to be said of an interruption from the keyboard, after these words, and of an error: of a load, a record, a
        disk or the machine. None if nothing was computed that could be kept: then it is raised.
    log : logging.Logger
        Is told how it ended: on level INFO where it worked, else WARNING.
    """
    status, message = _end(step, interrupted, failed)
    log.log(
        logging.INFO if status.ok or is_silenced() else logging.WARNING, "%s%s", status.value, message and f": {message}"
    )
    return status, message


def _end(
    step: Callable[[], End | None], interrupted: Callable[[], str | None], failed: Callable[[Exception], str | None]
) -> End:
    try:
        while (end := step()) is None:
            pass
        return end
    except KeyboardInterrupt:
        if (where := interrupted()) is None:
            raise
        return Status.INTERRUPTED, f"interrupted from the keyboard{where}"
    except Exception as error:
        if (what := failed(error)) is None:
            raise
        return Status.FAILED, what
