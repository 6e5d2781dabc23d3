"""What this installation consists of, as a text for reports of errors."""

import importlib.util
import os
import platform
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import skancf.version
from skancf.compiled import VARIABLE, Sealed
from skancf.errors import SkancfError
from skancf.linear import available_backends
from skancf.threads import n_threads

NEEDED = ("scikit-fem", "numpy", "scipy", "numba", "llvmlite", "meshio", "pyvista", "vtk", "matplotlib", "h5py", "tqdm")
OPTIONAL = {
    "mkl": ("fast", "the fastest linear solver, on x86-64"),
    "rslab": ("", "the linear solver where there is no MKL"),
    "pandas": ("tables", "tables as DataFrames"),
    "imageio-ffmpeg": ("view", "films as MP4"),
    "trame": ("view", "the viewer in notebooks"),
    "gmsh": ("gmsh", "meshes by Gmsh"),
    "ipywidgets": ("", "progress bars in notebooks"),
}
"""The extra of this package that installs it, and what it is for."""
MISSING = "not installed"


@dataclass(frozen=True)
class Info:
    """What :func:`info` found; printed, it is a text to paste into a report.

    Attributes
    ----------
    parts : dict of str to dict of str
        Sections, each of names and values.
    """

    parts: dict[str, dict[str, str]]

    def __str__(self) -> str:
        wide = max(len(name) for part in self.parts.values() for name in part)
        lines = []
        for title, part in self.parts.items():
            lines += [title, *(f"  {name:<{wide}}  {value}".rstrip() for name, value in part.items()), ""]
        return "\n".join(lines[:-1])

    __repr__ = __str__


def info() -> Info:
    """Versions, linear solvers, threads, compiled kernels and whether pictures can be drawn, for a report of an error.

    Drawing is tried in another process, which takes about a second. Nothing is compiled or downloaded.

    Returns
    -------
    Info

    Examples
    --------
    >>> found = sk.info()
    >>> found.parts["skancf"]["version"] == sk.__version__
    True
    >>> print(found)  # doctest: +SKIP
    """
    return Info({
        "skancf": {
            "version": skancf.version.__version__,
            "python": f"{platform.python_version()}, {sys.executable}",
            "system": f"{platform.platform()}, {os.cpu_count()} cores",
            "folder": str(Path(skancf.version.__file__).parent),
        },
        "Dependencies": {name: installed(name) for name in NEEDED},
        "Optional packages": {name: _optional(name) for name in OPTIONAL},
        "Calculation": {
            "linear solver": f"{available_backends()[0]} (available: {', '.join(available_backends())})",
            "threads": f"{n_threads()}{_set('SKANCF_THREADS')}",
            "kernels": kernels(),
        },
        "Pictures": {"rendering": rendering()},
    })  # fmt: skip


def installed(package: str) -> str:
    """The version of an installed package, or that it is not there."""
    try:
        return version(package)
    except PackageNotFoundError:
        return MISSING


def _optional(package: str) -> str:
    extra, what = OPTIONAL[package]
    found = installed(package)
    way = f"pip install 'skancf[{extra}]'" if extra else f"pip install {package}"
    return f"{found} ({what}{'' if found != MISSING else f': {way}'})"


def kernels() -> str:
    """How many of the kernels are compiled and kept on disk, and where."""
    ready, known, folder = kept_kernels()
    if not known:
        return f"no folder for them can be written: set {VARIABLE}"
    said = f"{ready} of {known} compiled, kept in {folder}{_set(VARIABLE)}"
    return said if ready else f"{said}; the first calculation compiles them, or the command: skancf compile"


def kept_kernels() -> tuple[int, int, str]:
    """Of the kernels of all modules that are loaded: compiled ones on disk, those that can be kept there, and the folder."""
    caches = [cache for cache in map(_cache_of, _functions()) if cache is not None]
    folder = os.path.commonpath([cache.cache_path for cache in caches]) if caches else ""
    return sum(_is_kept(cache) for cache in caches), len(caches), folder


def _set(variable: str) -> str:
    """The value of an environment variable, where it is set."""
    return f" ({variable}={os.environ[variable]})" if variable in os.environ else ""


def _functions() -> list[Any]:
    """All compiled functions that are called from Python, of modules that are loaded."""
    found = {}
    for name, module in list(sys.modules.items()):
        if name.startswith("skancf."):
            for value in vars(module).values():
                function = getattr(value, "py_func", None)
                if function is not None and "forceinline" not in value.targetoptions:
                    found[function.__module__, function.__qualname__] = value
    return list(found.values())


def _cache_of(dispatcher: Any) -> Sealed | None:
    cache = dispatcher._cache
    return cache if isinstance(cache, Sealed) else None


def _is_kept(cache: Sealed) -> bool:
    try:
        return bool(cache._cache_file._load_index())
    except Exception:  # damaged, and written anew by the next calculation
        return False


def rendering() -> str:
    """Whether pictures can be drawn here, or why not."""
    if importlib.util.find_spec("vtkmodules") is None:
        return "vtk is not installed"
    from skancf.output.rendering import check_rendering

    try:
        check_rendering()
    except SkancfError as none:
        return str(none)
    screen = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")) or sys.platform in ("win32", "darwin")
    return "works, with windows" if screen else "works without a screen; no windows"
