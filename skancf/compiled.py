"""How functions are compiled, and kept on disk for later processes.

A cache that cannot be written, is full, or is damaged costs time and nothing else: functions are compiled anew, and one
warning says where the cache should be.
"""

import hashlib
import io
import os
import pickle
import warnings
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

OPTIONS = {
    "nogil": True,
    "error_model": "numpy",
    # Everything but the flags that would let the compiler assume away NaN and infinity.
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
}
"""Of those that are called from Python."""
INNER = {**OPTIONS, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Of those that only compiled functions call: without entry points they compile in half the time.

Inlined by the compiler: of a function that is called, each caller's file of machine code has a copy, optimised there, and
whichever was loaded first is taken; so last bits would differ between a process that compiles and one that loads.
"""
VARIABLE = "NUMBA_CACHE_DIR"


class NoCache(UserWarning):
    """Compiled functions cannot be kept for the next process, or those of an earlier one cannot be read."""


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator that compiles a function by numba with these options, and caches it where that is possible."""

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(**options)(function)
        try:
            dispatcher._cache = Sealed(function)
        except Exception as error:
            # numba's own message for a folder that cannot be written names a function that no user knows.
            tell(f"found no folder that can be written ({error})")
        return dispatcher

    return decorate


class Sealed(FunctionCache):
    """numba's cache of one function, of which no fault reaches the caller, and that reads only what it wrote itself."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = SealedFile(self._cache_path, f"{self._impl.filename_base}-sealed", None)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function, or None, also for a file that cannot be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:
            self._replace(error)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write what was compiled, if that is possible; a damaged file is replaced."""
        try:
            super().save_overload(sig, data)
        except Exception as error:
            tell(f"cannot be written in {self._cache_path} ({_reason(error)})")

    def _replace(self, error: Exception) -> None:
        tell(f"is damaged in {self._cache_path} ({_reason(error)}), and is written again")
        try:
            self.flush()
        except Exception as again:
            tell(f"cannot be written in {self._cache_path} ({_reason(again)})")


class SealedFile(IndexDataCacheFile):
    """Files with a digest of what they hold, valid for the sources of all compiled functions.

    numba looks at the source of the outermost function only, which holds machine code of all those that it calls.
    """

    def save(self, key: Any, data: Any) -> None:
        """Write what was compiled for a signature, then the index that tells of it.

        numba counts files: two processes that compile at the same time take one name for two signatures, and a third one
        calls the code of the wrong one. Here each signature has a name of its own.
        """
        name = f"{Path(self._index_path).stem}.{_digest(repr(key).encode()).hex()}.nbc"
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})

    def _load_index(self) -> dict[Any, str]:
        try:
            data = self._unsealed(self._index_path)
        except FileNotFoundError:
            return {}
        stream = io.BytesIO(data)
        # Of another version of numba or of the sources the rest may not be readable.
        if pickle.load(stream) != [self._version, sources()]:
            return {}
        found: dict[Any, str] = pickle.load(stream)
        return found

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._seal(self._index_path, pickle.dumps([self._version, sources()]) + self._dump(overloads))

    def _load_data(self, name: str) -> Any:
        return pickle.loads(self._unsealed(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        self._seal(self._data_path(name), self._dump(data))

    def _seal(self, path: str, data: bytes) -> None:
        with self._open_for_write(path) as file:
            file.write(_digest(data) + data)

    @staticmethod
    def _unsealed(path: str) -> bytes:
        whole = Path(path).read_bytes()
        seal, data = whole[:SEAL], whole[SEAL:]
        if seal != _digest(data):
            raise ValueError(f"{os.path.basename(path)} does not hold what was written")
        return data


SEAL = 16
"""Bytes of a digest."""


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=SEAL).digest()


@lru_cache(maxsize=1)
def sources() -> bytes:
    """Digest of all files of this package that have compiled functions."""
    found = (path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py")))
    return _digest(b"".join(_digest(text) for text in found if b"skancf.compiled" in text or b"cgutils" in text))


_told: list[str] = []


def tell(what: str) -> None:
    """Warn of the cache, once in a process."""
    if not _told:
        _told.append(what)
        warnings.warn(
            f"the cache of compiled functions {what}. Results are right, but functions are compiled in this process, which "
            f"takes half a minute or more. Set the environment variable {VARIABLE} to a folder that can be written",
            NoCache, stacklevel=2,
        )  # fmt: skip


def _reason(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
