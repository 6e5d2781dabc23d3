"""Finding and loading Intel's MKL from its wheel."""

import ctypes
import importlib.metadata
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

LP64, INTEL_THREADS, SEQUENTIAL = 0, 0, 1
WINDOWS = sys.platform == "win32"
MKL = re.compile(r"mkl_rt\.\d+\.dll" if WINDOWS else r"libmkl_rt\.so\.\d+")
OPENMP = "libiomp5md.dll" if WINDOWS else "libiomp5.so"


@cache
def load() -> ctypes.CDLL | None:
    """The single dynamic library of MKL with 32-bit integers, or None where no one works."""
    for path in _candidates():
        try:
            if WINDOWS:
                os.add_dll_directory(str(path.parent))  # type: ignore[attr-defined, unused-ignore]
            library = ctypes.CDLL(str(path))
        except OSError:
            continue
        # Bit 0 of the answer is set when someone has already chosen 64-bit integers for this process.
        if library.MKL_Set_Interface_Layer(LP64) & 1:
            continue
        # MKL ends the process when its threading library is missing, so look first. Intel's OpenMP is a private copy
        # next to the OpenMP or TBB pool of numba; the two pools take turns because we call one after the other.
        library.MKL_Set_Threading_Layer(INTEL_THREADS if _loads(path.with_name(OPENMP)) else SEQUENTIAL)
        # Plain addresses, which take a tenth of the time of casts and references.
        library.pardiso.argtypes, library.pardiso.restype = [ctypes.c_void_p] * 16, None
        return library
    return None


def n_threads() -> int:
    """Threads that MKL uses at most; the environment variable ``MKL_NUM_THREADS`` sets it."""
    library = load()
    return 1 if library is None else int(library.MKL_Get_Max_Threads())


def _candidates() -> Iterator[Path]:
    """Files that may be the library: those of the distribution first, then those of this environment."""
    try:
        files = importlib.metadata.files("mkl") or []
    except importlib.metadata.PackageNotFoundError:
        files = []
    yield from (Path(str(file.locate())).resolve() for file in files if MKL.fullmatch(file.name))
    folder = Path(sys.prefix) / ("Library/bin" if WINDOWS else "lib")
    if folder.is_dir():
        yield from sorted(file for file in folder.iterdir() if MKL.fullmatch(file.name))


def _loads(path: Path) -> bool:
    try:
        ctypes.CDLL(str(path))
    except OSError:
        return False
    return True
