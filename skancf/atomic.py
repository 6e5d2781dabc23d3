"""Files that are whole or not there: written next to their place under another name, then moved."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skancf.errors import InputError, shown

AnyPath = str | os.PathLike[str]


@contextmanager
def replacing(path: AnyPath) -> Iterator[Path]:
    """A path to write to, with the suffix of ``path``; moved onto ``path`` at the end, removed on an exception.

    An older file stays as it was until the new one is whole.
    """
    final = Path(path)
    # Not tempfile: its files are readable by their owner only, and the finished file would be too.
    part = final.with_name(f".{final.stem}.{secrets.token_hex(4)}.part{final.suffix}")
    try:
        yield part
        os.replace(part, final)
    finally:
        part.unlink(missing_ok=True)


def as_path(what: str, path: AnyPath) -> Path:
    """``path`` as a Path, or InputError for what names no file or folder."""
    if not isinstance(path, str | os.PathLike) or isinstance(os.fspath(path), bytes):
        raise InputError(f"{what} = {shown(path)}: give a path, as text or a pathlib.Path")
    if not str(path) or "\0" in str(path):
        raise InputError(f"{what} '{path!s}': this is no path; give a name")
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        pass
    except (OSError, UnicodeEncodeError) as wrong:  # such as names that are too long
        raise InputError(f"{what} = {shown(path)}: this is no path ({wrong.args[-1]}); give another name") from wrong
    return Path(path)


def check_folder(path: AnyPath) -> Path:
    """Make sure that files can be written to a folder, before a long computation relies on it.

    Makes the folder if it does not exist, writes a small file into it and removes that file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the folder cannot be made or written.
    """
    folder = as_path("folder", path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _probe(folder / f".probe.{secrets.token_hex(4)}")
    except OSError as error:
        raise InputError(f"folder '{folder}': cannot be written ({reason(error)}); "
                         "choose another folder, free the name, or ask for the right to write") from error  # fmt: skip
    return folder


def _probe(file: Path) -> None:
    try:
        file.write_bytes(b"skancf")
    finally:
        file.unlink(missing_ok=True)


def check_file(path: AnyPath, *suffixes: str) -> Path:
    """Make sure that a file of one of some suffixes can be written at ``path``.

    Raises
    ------
    InputError
        For another suffix, a folder of that name, or a folder around it that cannot be written.
    """
    file = as_path("file", path)
    if file.suffix.lower() not in suffixes:
        raise InputError(f"file '{file}': its name ends in '{file.suffix}'; end it in {' or '.join(suffixes)}")
    check_folder(file.parent)
    if file.is_dir():
        raise InputError(f"file '{file}': there is a folder of that name; choose another name")
    return file


def reason(error: OSError) -> str:
    """What the system says, in words, and of which file."""
    where = f": '{error.filename}'" if error.filename else ""
    return f"{error.strerror or error}{where}"
