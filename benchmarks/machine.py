"""What the numbers of a benchmark depend on: the machine, the versions, the threads; and the files that hold them."""

import importlib.metadata
import json
import os
import platform
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from skancf.atomic import replacing
from skancf.linear import mkl
from skancf.threads import n_threads

RESULTS = Path(os.environ.get("SKANCF_RESULTS") or Path(__file__).parent / "results")
PACKAGES = ("skancf", "numpy", "scipy", "numba", "scikit-fem", "mkl", "rslab")


def facts() -> dict[str, Any]:
    """Processor, cores, memory (GB), versions (None where not installed) and threads of this process."""
    return {
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "memory_gb": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1),
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in PACKAGES},
        "threads": {"skancf": n_threads(), "mkl": mkl.n_threads()},
    }


def peak_memory() -> float:
    """Largest resident memory of this process since :func:`forget_peak` (GB); NaN where there is no /proc."""
    return _status("VmHWM")


def resident_memory() -> float:
    """Resident memory of this process (GB); NaN where there is no /proc."""
    return _status("VmRSS")


def forget_peak() -> None:
    """Let :func:`peak_memory` begin anew, where the system allows it."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def clock() -> float:
    """Seconds: of the processor where this process has one thread, which other work on the machine does not slow down."""
    return time.process_time() if n_threads() == 1 else time.perf_counter()


def with_threads(n: int) -> dict[str, str]:
    """The environment of a process in which every library may use ``n`` threads, and all instructions of the processor."""
    names = ("SKANCF_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    kept = {name: value for name, value in os.environ.items() if name not in ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")}
    return {**kept, **{name: str(n) for name in names}}


def write(name: str, content: dict[str, Any]) -> Path:
    """``results/name`` as JSON; an older file stays until the new one is whole."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    with replacing(RESULTS / name) as part:
        part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return RESULTS / name


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())


def _status(name: str) -> float:
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return float("nan")
    return float(next(line.split()[1] for line in lines if line.startswith(name))) / 1e6


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None
