"""The files of a run, arrays by name: whole or not there, and known by the state that names them."""

import hashlib
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from skancf.atomic import reason, replacing
from skancf.dynamics.named_state import flat
from skancf.errors import InputError, SkancfError
from skancf.meshes import quadtree_file
from skancf.showing import short
from skancf.system.system import System

FORMAT = "skancf run 5"
RUN, STATE, PIECE, MESH = "run.npz", "state.npz", "piece_{:06d}.npz", "mesh_{:06d}.npz"
STOPPED, REST = "stopped.npz", "rest.npz"
"""The state where a run stopped before its end, and what came since the last piece: to look at, not to go on from."""


@dataclass
class RunFiles:
    """Reads and writes the files of one run, and knows the digests of those that it has."""

    folder: Path
    digests: dict[str, str] = field(default_factory=dict)

    __repr__ = short

    def refused(self, name: str, why: str) -> InputError:
        return InputError(f"file '{self.folder / name}': {why}; go on with what the run was begun with, or begin in another "
                          "folder")  # fmt: skip

    # --- writing ---------------------------------------------------------------------------------------------------------

    def write(self, name: str, arrays: Mapping[str, np.ndarray]) -> None:
        """One file, on the disk when this returns; SkancfError for what would be pickled."""
        for title, array in arrays.items():
            if array.dtype.hasobject:
                kind = type(array.flat[0]).__name__
                raise SkancfError(f"{title} gives what cannot be written, for example a {kind}; let it give numbers or "
                                  "texts, or arrays of one number of dimensions")  # fmt: skip
        stream = io.BytesIO()
        np.savez(stream, format=np.array(FORMAT), **arrays)  # type: ignore[arg-type]
        data = stream.getvalue()
        with replacing(self.folder / name) as part, part.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        self.digests[name] = _digest(data)

    def write_meshes(self, systems: list[System]) -> None:
        """Those that are not there and not the one before; the mesh that a run begins with is the user's."""
        for k in range(1, len(systems)):
            name = MESH.format(k)
            if systems[k] is not systems[k - 1] and name not in self.digests:
                file = quadtree_file.save(systems[k].mesh, self.folder / name)
                with file.open("rb+") as stream:
                    self.digests[name] = _digest(stream.read())
                    os.fsync(stream.fileno())

    def write_state(self, name: str, state: Mapping[str, Any]) -> None:
        """Last of all: it names the files that belong to it."""
        self.write(name, flat({"files": self.digests.copy(), **state}))
        del self.digests[name]

    def clean(self) -> None:
        """Take away what a process that was killed had not finished writing."""
        for file in self.folder.glob(".*.part.npz"):
            file.unlink(missing_ok=True)

    def remove(self, name: str) -> None:
        """Take a file away."""
        (self.folder / name).unlink(missing_ok=True)
        self.digests.pop(name, None)

    # --- reading ---------------------------------------------------------------------------------------------------------

    def bytes_of(self, name: str) -> bytes:
        try:
            data = (self.folder / name).read_bytes()
        except FileNotFoundError:
            raise self.refused(name, "is missing") from None
        except OSError as error:
            raise self.refused(name, f"cannot be read ({reason(error)})") from error
        if name not in (STATE, STOPPED) and _digest(data) != self.digests.get(name):
            raise self.refused(name, f"is damaged, or belongs to another run than '{STATE}'")
        return data

    def read(self, name: str) -> dict[str, np.ndarray]:
        """One file; no code in it is run."""
        data = self.bytes_of(name)
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                arrays = {key: file[key] for key in file.files}
        except Exception as error:  # damage shows in many ways: in numpy's headers, in the archive, in what it unpacks
            raise self.refused(name, f"is no part of a run, or is damaged ({error})") from error
        kind = str(arrays.pop("format", "no part of a run, or of an earlier version"))
        if kind != FORMAT:
            raise self.refused(name, f"is {kind}; this version reads '{FORMAT}'")
        return arrays

    def read_state(self, name: str = STATE) -> dict[str, np.ndarray]:
        """The state; from here on the digests are those it names."""
        arrays = self.read(name)
        self.digests = {file: str(digest) for file, digest in under("files", arrays).items()}
        return arrays

    def read_systems(self, n: int, first: System) -> list[System]:
        """Those of n segments; ``first`` is the one that the run began on."""
        systems = [first]
        for k in range(1, n):
            name, system = MESH.format(k), systems[-1]
            if name in self.digests:
                self.bytes_of(name)
                system = first.problem.on(quadtree_file.load(self.folder / name), first.geometry.theory)
            systems.append(system)
        return systems


def under(above: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Those whose names begin so, by the rest of their names."""
    return {name.removeprefix(f"{above}."): array for name, array in arrays.items() if name.startswith(f"{above}.")}


def _digest(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=16).hexdigest()
