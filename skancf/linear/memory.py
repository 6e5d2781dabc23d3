"""Memory that this process can still get, and a refusal of what will not fit."""

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from skancf.errors import NotEnoughMemory

PROC, CGROUP = Path("/proc"), Path("/sys/fs/cgroup")
WAY_OUT = (
    "use a coarser mesh, let adapt put elements only where they count, or take theory 'kirchhoff', which needs fewer for "
    "thin plates"
)


def available() -> int | None:
    """Bytes that can be allocated without swapping; None where the system does not say.

    On Linux the kernel's own estimate, or what is left of the limit of a container or of a job if that is less.
    """
    limits = [*_left_of_machine(), *_left_of_groups()]
    return min(limits) if limits else None


def require(needed: int, unknowns: int, what: str) -> None:
    """Raise :class:`~skancf.errors.NotEnoughMemory` where ``needed`` bytes are not available."""
    left = available()
    if left is not None and needed > left:
        raise NotEnoughMemory(
            f"{unknowns} unknowns: {what} needs {needed / 1e9:.3g} GB, and {left / 1e9:.3g} GB are available; {WAY_OUT}"
        )


def _left_of_machine() -> Iterator[int]:
    try:
        lines = (PROC / "meminfo").read_text(encoding="ascii").splitlines()
        yield from (1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except OSError:
        names: dict[str, int] = getattr(os, "sysconf_names", {})
        if "SC_AVPHYS_PAGES" in names:
            yield os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _left_of_groups() -> Iterator[int]:
    """Limits of the control groups of this process less what is in use; pages of files count as free."""
    try:
        names = (PROC / "self/cgroup").read_text(encoding="utf-8").splitlines()
        group = next(PurePosixPath(name.removeprefix("0::/")) for name in names if name.startswith("0::/"))
    except (OSError, StopIteration):
        return
    for part in (group, *group.parents):
        try:
            folder = CGROUP / part
            limit = (folder / "memory.max").read_text(encoding="ascii").strip()
            if limit == "max":
                continue
            used = int((folder / "memory.current").read_text(encoding="ascii"))
            counts = dict(line.split() for line in (folder / "memory.stat").read_text(encoding="ascii").splitlines())
            yield max(0, int(limit) - used + int(counts.get("inactive_file", 0)))
        except (OSError, ValueError):
            continue
