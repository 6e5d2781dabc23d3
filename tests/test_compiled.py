"""Compiled functions where no cache can be written, or one is damaged: right results, and one warning."""

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from numba.core.caching import IndexDataCacheFile

import skancf
from skancf.compiled import SealedFile

PACKAGE = Path(skancf.__file__).parent
KERNEL = """
    import numpy as np
    from skancf.compiled import INNER, OPTIONS, compiled

    @compiled(**INNER)
    def square(x):
        return x * x

    @compiled(**OPTIONS)
    def sum_of_squares(values):
        total = 0.0
        for v in values:
            total += square(v)
        return total

    if __name__ == "__main__":
        print(sum_of_squares(np.array([1.0, 2.0, 3.0])), sum(sum_of_squares.stats.cache_hits.values()))
"""
"""A module with two compiled functions; prints a result, and how often it came from the cache."""


@pytest.fixture
def package(tmp_path):
    """A copy of what compiled functions need, with a module of its own, away from the caches of the real one."""
    room = tmp_path / "lib" / "skancf"
    room.mkdir(parents=True)
    shutil.copy(PACKAGE / "compiled.py", room)
    (room / "__init__.py").touch()
    (room / "sums.py").write_text(textwrap.dedent(KERNEL))
    return room.parent


def run(package: Path, code: str = "", **environment: str) -> tuple[list[str], str]:
    """Words that a fresh process prints, and what it warns of."""
    inherited = {name: value for name, value in os.environ.items()
                 if not name.startswith(("NUMBA", "XDG", "PYTHON", "HOME", "TMP"))}  # fmt: skip
    ended = subprocess.run(
        [sys.executable, "-B", "-c", f"{code}\nimport runpy; runpy.run_module('skancf.sums', run_name='__main__')"],
        cwd=package, env={**inherited, **environment}, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.split(), ended.stderr


def test_a_second_process_loads_what_the_first_one_compiled(package, tmp_path):
    folder = str(tmp_path / "cache")
    assert run(package, NUMBA_CACHE_DIR=folder) == (["14.0", "0"], "")
    assert run(package, NUMBA_CACHE_DIR=folder) == (["14.0", "1"], "")


def unwritable(package: Path) -> Path:
    """A folder below a regular file: nobody can write there, not even the superuser."""
    (package.parent / "file").touch()
    return package.parent / "file" / "folder"


def test_nowhere_to_write(package):
    """A read-only installation, and no home."""
    nowhere = unwritable(package)
    shutil.rmtree(package / "skancf" / "__pycache__", ignore_errors=True)
    (package / "skancf" / "__pycache__").touch()  # a file where the folder of caches should be
    for environment in (
        {"NUMBA_CACHE_DIR": str(nowhere), "HOME": str(nowhere), "TMPDIR": str(nowhere)},
        {"HOME": str(nowhere), "XDG_CACHE_HOME": str(nowhere), "TMPDIR": str(nowhere)},
    ):
        words, warned = run(package, **environment)
        assert words == ["14.0", "0"]
        assert warned.count("NoCache") == 1
        assert "NUMBA_CACHE_DIR" in warned


FULL = """
import builtins, errno
before = builtins.open
class Full:
    def __init__(self, file): self.file = file
    def __enter__(self): return self
    def __exit__(self, *_): self.file.close()
    def write(self, data): raise OSError(errno.ENOSPC, "No space left on device")
builtins.open = lambda path, mode="r", *more, **named: (
    Full(before(path, mode)) if ".tmp." in str(path) and "w" in mode else before(path, mode, *more, **named))
"""


def test_a_full_disk(package, tmp_path):
    folder = tmp_path / "cache"
    words, warned = run(package, FULL, NUMBA_CACHE_DIR=str(folder))
    assert words == ["14.0", "0"]
    assert warned.count("NoCache") == 1
    assert "No space left" in warned
    assert not [path for path in folder.rglob("*") if path.is_file()]


def cut(data: bytes) -> bytes:
    return data[: len(data) // 2]


def flipped(data: bytes) -> bytes:
    """One bit of the last quarter: code, which can be loaded and gives wrong numbers, or crashes."""
    at = 3 * len(data) // 4
    return data[:at] + bytes([data[at] ^ 16]) + data[at + 1 :]


def garbage(data: bytes) -> bytes:
    return b"\x80\x05garbage." * 40


@pytest.mark.parametrize(("kind", "damage"),
                         [("nbi", cut), ("nbi", garbage), ("nbc", cut), ("nbc", garbage), ("nbc", flipped)])  # fmt: skip
def test_a_damaged_cache_is_written_again(package, tmp_path, kind, damage):
    folder = tmp_path / "cache"
    run(package, NUMBA_CACHE_DIR=str(folder))
    files = list(folder.rglob(f"*.{kind}"))
    assert files
    for file in files:
        file.write_bytes(damage(file.read_bytes()))
    words, warned = run(package, NUMBA_CACHE_DIR=str(folder))
    assert words == ["14.0", "0"]
    assert warned.count("NoCache") == 1
    assert "NUMBA_CACHE_DIR" in warned
    assert run(package, NUMBA_CACHE_DIR=str(folder)) == (["14.0", "1"], "")


@pytest.mark.parametrize(("kind", "right"), [(SealedFile, True), (IndexDataCacheFile, False)])
def test_processes_that_compile_at_the_same_time_keep_their_code_apart(kind, right, tmp_path, monkeypatch):
    """Both find an empty index; one writes all it has while the other has its code yet to write."""
    ours, theirs = (kind(str(tmp_path), "kernel", None) for _ in range(2))
    write = ours._save_data

    def late(name, data):
        with monkeypatch.context() as patch:
            patch.setattr(theirs, "_load_index", dict)
            theirs.save(("their signature",), "their code")
        write(name, data)

    monkeypatch.setattr(ours, "_save_data", late)
    ours.save(("our signature",), "our code")
    third = kind(str(tmp_path), "kernel", None)
    assert (third.load(("their signature",)) == "their code") is right
    assert third.load(("our signature",)) == ("our code" if right else None)


def test_an_edit_of_an_inner_function_is_seen(package, tmp_path):
    """In another file than that of the function that calls it, of which numba alone looks at the source."""
    sums, squares = package / "skancf" / "sums.py", package / "skancf" / "squares.py"
    text = sums.read_text()
    head, inner, rest = text.partition("@compiled(**INNER)\ndef square(x):\n    return x * x\n")
    imports = "from skancf.compiled import INNER, compiled\n"
    squares.write_text(imports + inner)
    sums.write_text(f"from skancf.squares import square\n{head}{rest}")
    folder = str(tmp_path / "cache")
    assert run(package, NUMBA_CACHE_DIR=folder)[0] == ["14.0", "0"]
    squares.write_text(imports + inner.replace("x * x", "2 * x * x"))
    assert run(package, NUMBA_CACHE_DIR=folder)[0] == ["28.0", "0"]
    assert run(package, NUMBA_CACHE_DIR=folder)[0] == ["28.0", "1"]


def test_all_of_the_library_loads_without_a_cache(tmp_path):
    """The real package, told to look for its cache where nothing can be."""
    (tmp_path / "lib").mkdir()
    nowhere = unwritable(tmp_path / "lib")
    code = "import sys; sys.path.insert(0, sys.argv[1]); import skancf; print('loaded')"
    ended = subprocess.run(
        [sys.executable, "-B", "-c", code, str(PACKAGE.parent)], capture_output=True, text=True, timeout=120,
        env={"PATH": os.environ["PATH"], "NUMBA_CACHE_DIR": str(nowhere),
             "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"},
    )  # fmt: skip
    assert ended.stdout.split() == ["loaded"], ended.stderr
    assert ended.stderr.count("NoCache") == 1
