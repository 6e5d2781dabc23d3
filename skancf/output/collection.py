"""Collections (.pvd): which file shows which time."""

import math
import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

from skancf.atomic import check_folder, replacing
from skancf.errors import InputError
from skancf.solution import Solution


def write_collection(path: Path, states: Iterable[Solution], write_one: Callable[[Solution, Path], None]) -> Path:
    """Write every state into a new folder, then move the files into place, then the list of them."""
    folder = check_folder(path.with_suffix(""))
    new = check_folder(path.parent / f".{path.stem}.{secrets.token_hex(4)}.part")
    try:
        keys: list[tuple[float | None, float]] = []
        names: list[str] = []
        for state in states:
            keys.append(_next_key(keys, state))
            names.append(f"{path.stem}_{len(names):05d}.vtu")
            write_one(state, new / names[-1])
        if not names:
            raise InputError(f"states: there is nothing to write to '{path}'; give at least one")
        for name in names:
            os.replace(new / name, folder / name)
    finally:
        shutil.rmtree(new, ignore_errors=True)
    with replacing(path) as part:
        part.write_bytes(_listing(_times(keys), [f"{folder.name}/{name}" for name in names]))
    _remove_frames(folder, path.stem, keep=set(names))
    return path


def read_collection(path: Path) -> list[tuple[float, Path]]:
    """Times and files of a collection."""
    try:
        root = ElementTree.parse(path).getroot()
        if root.tag != "VTKFile" or root.get("type") != "Collection":
            raise ValueError(f"its root is <{root.tag} type={root.get('type')!r}>, not <VTKFile type='Collection'>")
        rows = [(float(row.attrib["timestep"]), path.parent / row.attrib["file"]) for row in root.iter("DataSet")]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        what = f"an entry lacks {error}" if isinstance(error, KeyError) else error
        raise InputError(f"file '{path}': is no .pvd collection, or is damaged ({what}); write it again") from error
    for time, file in rows:
        if not math.isfinite(time):
            raise InputError(f"file '{path}': time {time} of '{file.name}' is not finite; write it again")
        if not file.is_file():
            raise InputError(f"file '{path}': lists '{file}', which is not there; keep the folder next to the .pvd file")
    return rows


def _next_key(keys: list[tuple[float | None, float]], state: Solution) -> tuple[float | None, float]:
    if not isinstance(state, Solution):
        raise InputError(f"states: state {len(keys)}: give Solutions, not {type(state).__name__}")
    before = keys[-1][0] if keys else None
    if state.time is not None and before is not None and not state.time > before:
        raise InputError(f"state {len(keys)}: time {state.time} s follows {before} s; give states in the order of "
                         "time, each time once")  # fmt: skip
    return state.time, state.load_factor


def _times(keys: list[tuple[float | None, float]]) -> list[float]:
    """Times, or else load factors if they increase, or else numbers."""
    times = [time for time, _ in keys if time is not None]
    if len(times) == len(keys):
        return times
    factors = [factor for _, factor in keys]
    increasing = all(b > a for a, b in pairwise(factors))
    return factors if increasing else [float(k) for k in range(len(keys))]


def _listing(times: list[float], files: list[str]) -> bytes:
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    rows = ElementTree.SubElement(root, "Collection")
    for time, file in zip(times, files, strict=True):
        ElementTree.SubElement(rows, "DataSet", timestep=repr(float(time)), group="", part="0", file=file)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _remove_frames(folder: Path, stem: str, keep: set[str]) -> None:
    """Remove the files of an earlier, longer run; whatever else lies there is not ours."""
    ours = re.compile(re.escape(stem) + r"_\d{5,}\.vtu")
    for file in folder.iterdir():
        if ours.fullmatch(file.name) and file.name not in keep:
            file.unlink()
