"""Problems, meshes and results to HDF5 files and back."""

from pathlib import Path
from secrets import token_hex
from typing import Any

import skfem

from skancf.arguments import choice
from skancf.atomic import AnyPath, as_path, check_file, replacing
from skancf.dynamics import Motion
from skancf.errors import InputError, shown
from skancf.problem import Problem
from skancf.storage.describe import refuse
from skancf.storage.hdf5 import Getter, Putter, plain_value, put_plain
from skancf.storage.registry import ANSWERS, KINDS, kind_of
from skancf.storage.rows import ID
from skancf.storage.splined import Sampler
from skancf.storage.stored import fields_of_result
from skancf.system.system import System
from skancf.version import __version__

FORMAT, VERSION = "skancf", 1
SUFFIXES = (".h5", ".hdf5")
LIBRARY = ("v110", "v110")
"""Structures of HDF5 that have checksums; programs with HDF5 1.10 or later read them."""
LAZY = 2**26
"""Bytes from which on arrays of a motion stay in the file until they are asked for."""
WHAT = ("all", "arrays")
THINGS = "a Problem, a system, a mesh, a Solution or the result of an analysis"


def save(thing: Any, path: AnyPath, *, what: str = "all") -> Path:
    """Write a problem, a system, a mesh, a solution or a result to an HDF5 file.

    The page "The file format" says what is in it, for other programs. There is no code in it. An older file stays as it was
    until the new one is whole.

    Parameters
    ----------
    thing
        A :class:`~skancf.Problem`, a system, a mesh, a :class:`~skancf.Solution`, or a result: of :func:`~skancf.solve`,
        :func:`~skancf.trace`, :func:`~skancf.modes`, :func:`~skancf.buckling`, :func:`~skancf.simulate` or
        :func:`~skancf.adapt`; any part of a problem, such as a law or a load.
    path : str or Path
        ``*.h5`` or ``*.hdf5``.
    what : {"all", "arrays"}
        ``"all"``: the problem too, so that what :func:`load` returns answers all that the original does. ``"arrays"``:
        fields at nodes and corners of elements, energies and tables, which need no problem; :func:`load` gives
        :class:`~skancf.storage.StoredFields`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For a file that cannot be written, for what is none of these, and for a function in the problem that cannot be kept;
        the message names it.

    Warns
    -----
    OutOfDepth
        Where functions of time (of a motion) or of place are kept as tables of their values, with the errors of these.

    Examples
    --------
    >>> steel = sk.Isotropic(210e9, 0.3, 7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, [sk.Clamp("left")], [sk.Gravity()])
    >>> result = sk.solve(plate.on(sk.meshes.uniform(plate.surface, 4, 4)))
    >>> sk.load(sk.save(result, "plate.h5")) == result
    True
    """
    choice("what", what, WHAT)
    file = check_file(path, *SUFFIXES)
    if not _can_be_kept(thing):
        raise InputError(f"thing = {shown(thing)}: give {THINGS}")
    sampler = Sampler(_surface_of(thing), _span_of(thing), refuse)
    kept = fields_of_result(thing) if what == "arrays" else thing
    with replacing(file) as part, created(part, type(thing).__name__) as root:
        Putter(sampler).put(root, "content", kept)
    sampler.warn()
    return file


def created(path: Path, content: str) -> Any:
    """A new file, open, with its head."""
    import h5py

    root = h5py.File(path, "w", libver=LIBRARY)
    head = {"format": FORMAT, "version": VERSION, "skancf": __version__, "holds": content, ID: token_hex(16)}
    for name, value in head.items():
        put_plain(root, name, value)
    return root


def load(path: AnyPath) -> Any:
    """Read what :func:`save` wrote. No code in the file is run.

    Systems are built anew from their problems, meshes and theories. Of motions of more than 64 MB the states stay in the
    file and are read when they are asked for; a file that is read so must stay where it is.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    object
        What was saved; :class:`~skancf.storage.StoredFields` of what was saved as arrays.

    Raises
    ------
    InputError
        For a file that is not there, is not one of :func:`save`, is of a later version, is damaged, or whose parts do not
        fit together.

    Examples
    --------
    >>> steel = sk.Isotropic(210e9, 0.3, 7850.0)
    >>> file = sk.save(steel, "steel.h5")
    >>> sk.load(file).young
    210000000000.0
    """
    import h5py

    file = as_path("file", path)
    if not file.is_file():
        raise InputError(f"file '{file}': there is no such file; sk.save(result, '{file}') writes one")
    try:
        is_hdf5 = h5py.is_hdf5(file)
        if is_hdf5:
            with h5py.File(file, "r") as root:
                return _content(root)
    except _Refused as why:
        raise InputError(f"file '{file}': {why}") from None
    except InputError as why:
        raise InputError(f"file '{file}': does not fit together: {why}") from why
    except Exception as why:  # damage shows in many ways: in HDF5's structures, in checksums, in what is missing
        said = " ".join(str(why).split()) or type(why).__name__
        raise InputError(f"file '{file}': is damaged, or is not a file of sk.save ({said}); write it again") from why
    raise InputError(f"file '{file}': is no HDF5 file; give one that sk.save has written")


class _Refused(Exception):
    """A file that is whole and not for this library."""


def _content(root: Any) -> Any:
    if "format" not in root.attrs or plain_value(root.attrs["format"]) != FORMAT:
        raise _Refused("is an HDF5 file, but not one of sk.save")
    version = int(root.attrs["version"])
    if version > VERSION:
        raise _Refused(f"is of version {version} of the format, written by skancf {plain_value(root.attrs['skancf'])}; this "
                       f"is skancf {__version__}, which reads up to version {VERSION}: update it")  # fmt: skip
    return Getter(lambda dataset: dataset.ndim == 2 and dataset.nbytes > LAZY).get(root["content"])


def _can_be_kept(thing: Any) -> bool:
    return isinstance(thing, System | skfem.MeshQuad) or bool(kind_of(thing, KINDS) or kind_of(thing, ANSWERS))


def _problem_of(thing: Any) -> Any:
    """The problem in a thing; None where there is none."""
    if isinstance(thing, Problem):
        return thing
    for name in ("system", "solution", "state", "linear", "segments"):
        part = getattr(thing, name, None) if name != "system" or not isinstance(thing, Motion) else None
        if part is not None:
            return part.problem if isinstance(part, System) else _problem_of(part[0] if name == "segments" else part)
    return getattr(thing, "problem", None)


def _surface_of(thing: Any) -> Any:
    return getattr(_problem_of(thing), "surface", None)


def _span_of(thing: Any) -> tuple[float, float] | None:
    """The times of a motion."""
    if not isinstance(thing, Motion):
        return None
    return float(thing.segments[0].times[0]), float(thing.segments[-1].times[-1])
