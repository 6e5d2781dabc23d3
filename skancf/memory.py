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


def require(needed: int, subject: str, what: str, way_out: str = WAY_OUT) -> None:
    """Raise :class:`~skancf.errors.NotEnoughMemory` where ``needed`` bytes are not available.

    ``subject`` is how much was asked for, as in "5000 unknowns", and ``what`` needs the memory.
    """
    left = available()
    if left is not None and needed > left:
        raise NotEnoughMemory(
            f"{subject}: {what} needs {_gigabytes(needed)} GB, and {left / 1e9:.3g} GB are available; {way_out}"
        )


def _gigabytes(needed: int) -> str:
    return f"{needed / 1e9:.3g}" if needed < 10**300 else "more than 1e291"


SMALL = 1 << 26
"""Bytes that are not asked about: to read what is available takes longer than to solve a small problem."""


def require_much(needed: int, subject: str, what: str, way_out: str = WAY_OUT) -> None:
    """:func:`require`, where ``needed`` is more than a small problem takes."""
    if needed > SMALL:
        require(needed, subject, what, way_out)


MESH, SYSTEM = 400, 9_200
"""Bytes for each element of a mesh, and of a system on it in the theory that takes least; measured on equal elements, the
least there are."""


def require_mesh(n_elements: int, each: int = SYSTEM) -> None:
    """Refuse a mesh of more elements than a system would fit on; :data:`MESH` of bytes each where some are cut out."""
    many = f"{n_elements}" if n_elements < 10**12 else f"{min(n_elements, 10**300):.3g}"
    require_much(each * n_elements, f"{many} elements", "a mesh" if each == MESH else "a mesh with a system on it")


def require_shapes(n_shapes: int, each: int, theory: str) -> None:
    """Refuse elements of different shapes whose laws, of ``each`` bytes, would not fit into memory."""
    require_much(
        each * n_shapes, f"{n_shapes} elements of different shapes", f"the set-up of theory '{theory}'",
        f"take equal elements (sk.meshes.uniform, or a quadtree of it), which share what they need; {WAY_OUT}",
    )  # fmt: skip


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
