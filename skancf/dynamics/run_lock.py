"""One process at a time writes into the folder of a run."""

import json
import os
import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from skancf.errors import InputError

LOCK = "lock"
"""Name of the file; with the number and the host of the process that writes. The lock itself is the system's, which takes
it away from a process that ends in any way, killed ones too."""

if sys.platform == "win32":
    import msvcrt

    FAR = 1 << 30
    """Bytes that nobody reads: locked ones cannot be."""

    def _lock(file: int) -> bool | None:
        os.lseek(file, FAR, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
else:
    import fcntl

    def _lock(file: int) -> bool | None:
        """Is the lock taken now? None where the file system has no locks."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            return None
        return True


class RunLock:
    """Held from :meth:`take` to :meth:`release`."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / LOCK
        self._file: int | None = None

    def take(self) -> None:
        """Become the one that writes.

        Raises
        ------
        InputError
            While another process or thread writes, or where one of another host may.
        """
        while self._file is None:
            file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                taken, owner = _lock(file), _read(file)
                if taken is False:
                    raise InputError(f"folder '{self.path.parent}': {_named(owner)} is writing its run into it; wait for "
                                     "its end, or choose another folder. read_motion reads it meanwhile")  # fmt: skip
                if not self._is_there(file):
                    continue  # the one before took its file away after it was opened here
                self._refuse_far(owner, taken)
                os.lseek(file, 0, os.SEEK_SET)
                os.truncate(file, 0)
                os.write(file, json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode())
                self._file, file = file, -1
            finally:
                if file >= 0:
                    os.close(file)

    def release(self) -> None:
        """Let others write."""
        if self._file is None:
            return
        file, self._file = self._file, None
        if sys.platform == "win32":
            os.close(file)  # an open file cannot be removed there
            with suppress(OSError):
                self.path.unlink()
            return
        if self._is_there(file):
            with suppress(OSError):
                self.path.unlink()
        os.close(file)

    def _is_there(self, file: int) -> bool:
        try:
            return os.path.samestat(os.fstat(file), os.stat(self.path))
        except FileNotFoundError:
            return False

    def _refuse_far(self, owner: dict[str, Any] | None, taken: bool | None) -> None:
        """Locks need not reach from host to host, and not every file system has them."""
        if owner is None:
            return
        far = owner.get("host") != socket.gethostname()
        if far or (taken is None and _lives(owner.get("pid"))):
            raise InputError(f"folder '{self.path.parent}': {_named(owner)} may still be writing its run into it; if it has "
                             f"ended, remove '{self.path}'; else wait for its end, or choose another folder")  # fmt: skip


def _read(file: int) -> dict[str, Any] | None:
    os.lseek(file, 0, os.SEEK_SET)
    try:
        owner = json.loads(os.read(file, 4096))
    except (ValueError, OSError):
        return None
    return owner if isinstance(owner, dict) else None


def _named(owner: dict[str, Any] | None) -> str:
    if owner is None:
        return "another process"
    if owner.get("pid") == os.getpid() and owner.get("host") == socket.gethostname():
        return "this process"
    return f"process {owner.get('pid')} on '{owner.get('host')}'"


def _lives(pid: Any) -> bool:
    if not isinstance(pid, int) or pid <= 0:
        return False
    if sys.platform == "win32":
        return True  # a signal would end it
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
