"""Objects as groups, datasets and attributes of an HDF5 file, and back: see the page "The file format".

Everything has a checksum of HDF5: data are in chunks with Fletcher's, and the rest is in structures of version 1.10, which
have their own. So texts are of fixed length, since those of variable length are kept without.
"""

import json
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any

import numpy as np
import skfem
from skfem.generic_utils import OrientedBoundary

from skancf.errors import InputError
from skancf.meshes import MeshQuadTree
from skancf.meshes.quadtree_file import tree_arrays, tree_of
from skancf.rows import Rows
from skancf.solving import Status
from skancf.storage.describe import Keep, build, describe, refuse
from skancf.storage.registry import ANSWERS, KINDS, class_named, fields_of, kind_of
from skancf.storage.rows import FileRows
from skancf.system.build import rebuilt
from skancf.system.system import System
from skancf.tolerances import ONE_PLACE

TYPE, NAME, MOVE = "type", "name", "_moved"
ROWS = ("Step", "MeshEvent")
"""Classes of numbers only, of which many are kept as columns."""
CHUNK = 2**20
"""Bytes that are checked and read together."""
SHORT = 1000
"""Bytes of a text that is an attribute; longer ones are datasets."""


class Putter:
    """Writes values below a group; what stands in several places is written once, and linked.

    ``keep`` is asked for what takes the place of functions.
    """

    def __init__(self, keep: Keep = refuse) -> None:
        self.keep = keep
        self._seen: dict[int, tuple[Any, Any]] = {}

    def put(self, group: Any, name: str, value: Any, owner: Any = None) -> None:
        """Write a value under a name; None is left out."""
        if value is None:
            return
        if id(value) in self._seen:
            group[name] = self._seen[id(value)][1]
            return
        put_plain(group, name, value) if is_plain(value) else self._put_object(group, name, value, owner)
        if name in group:
            self._seen[id(value)] = value, group[name]

    def _put_object(self, group: Any, name: str, value: Any, owner: Any) -> None:
        if isinstance(value, System):
            self._put_system(group, name, value)
        elif isinstance(value, skfem.MeshQuad):
            put_mesh(group, name, value)
        elif kind_of(value, KINDS):
            put_text(group, name, json.dumps(describe(value, self.keep), allow_nan=False), kind_of(value, KINDS))
        elif kind := kind_of(value, ANSWERS):
            self.members(group, name, kind, {field: getattr(value, field) for field in fields_of(type(value))}, value)
        elif isinstance(value, Mapping):
            self.members(group, name, "mapping", {str(k): item for k, item in enumerate(value.values())}, value)
            put_array(group[name], "names", np.array(list(value), dtype=str))
        elif isinstance(value, list | tuple):
            self._put_list(group, name, value)
        elif isinstance(value, np.ndarray):
            self.members(group, name, "ragged", {str(k): item for k, item in enumerate(value.ravel())}, value)
        else:
            self.put(group, name, self.keep(owner, name, value), owner)

    def members(self, group: Any, name: str, kind: str, parts: Mapping[str, Any], owner: Any = None) -> Any:
        """A group of named parts."""
        made = group.create_group(name)
        put_plain(made, TYPE, kind)
        for field, part in parts.items():
            self.put(made, field, part, owner)
        return made

    def _put_list(self, group: Any, name: str, value: Any) -> None:
        kind = type(value[0]).__name__ if value else ""
        if kind in ROWS and all(type(item) is type(value[0]) for item in value):
            columns = {field: np.array([getattr(item, field) for item in value]) for field in fields_of(type(value[0]))}
            put_plain(self.members(group, name, "rows", columns), NAME, kind)
        else:
            made = self.members(group, name, "list", {str(k): item for k, item in enumerate(value)}, value)
            put_plain(made, "length", len(value))

    def _put_system(self, group: Any, name: str, system: System) -> None:
        parts = {"problem": system.problem, "mesh": system.mesh, "theory": system.geometry.theory, "choice": system.choice,
                 "undeformed": system.undeformed, "state": system.terms.state()}  # fmt: skip
        self.members(group, name, "System", parts)


def is_plain(value: Any) -> bool:
    """Whether a value is one dataset or one attribute."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "biufU"
    if isinstance(value, list | tuple):
        kinds = {type(item) for item in value}
        return len(kinds) == 1 and kinds <= {bool, int, float}
    return isinstance(value, bool | int | float | str | np.generic | Enum | Rows)


def put_plain(group: Any, name: str, value: Any) -> None:
    """A dataset or an attribute."""
    if isinstance(value, Enum):
        value = value.name
    if isinstance(value, list | tuple):
        put_array(group, name, np.array(value))
        group[name].attrs[TYPE] = np.bytes_(b"row")
    elif isinstance(value, np.ndarray | Rows) and value.ndim:
        put_array(group, name, value)
    elif not isinstance(value, str):
        group.attrs[name] = value
    elif len(value.encode()) > SHORT:
        put_text(group, name, value, "text")
    else:
        group.attrs[name] = np.bytes_(value.encode() or b"\0")


def put_text(group: Any, name: str, text: str, kind: str | None) -> None:
    """A text of any length."""
    data = np.array([text.encode()])
    group.create_dataset(name, data=data, chunks=(1,), fletcher32=True).attrs[TYPE] = np.bytes_(str(kind).encode())


def put_array(group: Any, name: str, array: Any) -> Any:
    """A dataset, written in pieces where it is read from a file itself."""
    if array.dtype.kind == "U":
        array = np.char.encode(array, "utf-8") if array.size else array.astype("S1")
    if 0 in array.shape:
        return group.create_dataset(name, data=np.asarray(array))
    made = group.create_dataset(name, array.shape, array.dtype, chunks=chunks(array.shape, array.dtype), fletcher32=True)
    step = made.chunks[0] if isinstance(array, Rows) else len(array)
    for k in range(0, len(array), step):
        made[k : k + step] = array[k : k + step]
    return made


def chunks(shape: tuple[int, ...], dtype: Any) -> tuple[int, ...]:
    """Whole rows, as many as there are bytes for."""
    row = max(1, int(np.prod(shape[1:], dtype=np.int64)) * np.dtype(dtype).itemsize)
    return (min(max(1, CHUNK // row), max(1, shape[0])), *(max(1, n) for n in shape[1:]))


def put_mesh(group: Any, name: str, mesh: skfem.MeshQuad) -> None:
    """A mesh: a quadtree by its coarse mesh and its cells, and the elements that they make."""
    made = group.create_group(name)
    tree = isinstance(mesh, MeshQuadTree)
    put_plain(made, TYPE, "MeshQuadTree" if tree else "MeshQuad")
    put_array(made, "nodes", mesh.p)
    put_array(made, "elements", mesh.t)
    if tree:
        cells = made.create_group("tree")
        for part, array in tree_arrays(mesh).items():
            put_array(cells, part, array)
        return
    for title, sets in (("boundaries", mesh.boundaries), ("subdomains", mesh.subdomains)):
        names = made.create_group(title)
        put_array(names, "names", np.array(list(sets or {}), dtype=str))
        for k, members in enumerate((sets or {}).values()):
            put_array(names, str(k), np.asarray(members))
            if getattr(members, "ori", None) is not None:
                put_array(names, f"{k} orientation", members.ori)


class Getter:
    """Reads what :class:`Putter` wrote; what was one object is one again. Large arrays are read when they are asked for."""

    def __init__(self, lazily: Callable[[Any], bool] = lambda dataset: False) -> None:
        self.lazily = lazily
        self._seen: dict[int, Any] = {}

    def get(self, item: Any) -> Any:
        """The value of a group or dataset."""
        import h5py

        place = h5py.h5o.get_info(item.id).addr
        if place not in self._seen:
            self._seen[place] = self._dataset(item) if isinstance(item, h5py.Dataset) else self._group(item)
        return self._seen[place]

    def member(self, group: Any, name: str) -> Any:
        """One of a group, dataset or attribute; None where there is none."""
        if name in group:
            return self.get(group[name])
        return plain_value(group.attrs[name]) if name in group.attrs else None

    def _dataset(self, dataset: Any) -> Any:
        kind = plain_value(dataset.attrs[TYPE]) if TYPE in dataset.attrs else ""
        if kind in KINDS:
            return build(json.loads(dataset[0].decode()), kind)
        if kind == "text":
            return dataset[0].decode()
        if kind == "row":
            return tuple(dataset[()].tolist())
        if self.lazily(dataset):
            return FileRows.of(dataset)
        array = dataset[()]
        return np.char.decode(array, "utf-8") if array.dtype.kind == "S" else array

    def _group(self, group: Any) -> Any:
        kind = plain_value(group.attrs[TYPE])
        if kind in READERS:
            return READERS[kind](self, group)
        cls = class_named(kind)
        values = {name: self.member(group, name) for name in fields_of(cls)}
        if values.get("status") is not None:
            values["status"] = Status[values["status"]]
        if kind in MOVED:
            _move(values)
        return cls(**{name: value for name, value in values.items() if value is not None})


MOVED = ("Solution", "Segment")
"""Classes whose coordinates ``q`` are those of a system."""


def _move(values: dict[str, Any]) -> None:
    """Keep the displacements where the system is the same to rounding and not to the last bit: with a surface that is kept
    as a table, or on another machine."""
    moved = getattr(values["system"], MOVE, None)
    if moved is None:
        return
    small, q = values.get("small"), values["q"]
    if small is not None:
        values["q"] = values["system"].undeformed + small
    elif isinstance(q, FileRows):
        q.moved = moved
    else:
        values["q"] = q + moved


def plain_value(value: Any) -> Any:
    """An attribute as a number or a text."""
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.generic) else value


def _mapping(getter: Getter, group: Any) -> dict[str, Any]:
    names = getter.get(group["names"]).tolist()
    return {name: getter.member(group, str(k)) for k, name in enumerate(names)}


def _list(getter: Getter, group: Any) -> tuple[Any, ...]:
    return tuple(getter.member(group, str(k)) for k in range(int(group.attrs["length"])))


def _rows(getter: Getter, group: Any) -> tuple[Any, ...]:
    cls = class_named(plain_value(group.attrs[NAME]))
    columns = [getter.get(group[name]).tolist() for name in fields_of(cls)]
    return tuple(cls(*row) for row in zip(*columns, strict=True))


def _ragged(getter: Getter, group: Any) -> np.ndarray:
    values = [getter.member(group, str(k)) for k in range(len(group) + len(group.attrs) - 1)]
    out = np.empty(len(values), dtype=object)
    out[:] = values
    return out


def _mesh(getter: Getter, group: Any) -> skfem.MeshQuad:
    boundaries, subdomains = (_named_sets(getter, group[title]) for title in ("boundaries", "subdomains"))
    nodes, elements = getter.get(group["nodes"]), getter.get(group["elements"])
    return skfem.MeshQuad(nodes, elements, _boundaries=boundaries or None, _subdomains=subdomains or None)


def _named_sets(getter: Getter, group: Any) -> dict[str, Any]:
    out = {}
    for k, name in enumerate(getter.get(group["names"]).tolist()):
        members, turned = getter.get(group[str(k)]), getter.member(group, f"{k} orientation")
        out[name] = members if turned is None else OrientedBoundary(members, turned)
    return out


def _tree(getter: Getter, group: Any) -> MeshQuadTree:
    return tree_of({name: getter.get(part) for name, part in group["tree"].items()})


def _system(getter: Getter, group: Any) -> System:
    problem, mesh, theory, choice, state = (
        getter.member(group, name) for name in ("problem", "mesh", "theory", "choice", "state")
    )
    system = rebuilt(problem, mesh, theory, state, choice)
    kept, made = getter.get(group["undeformed"]), system.undeformed
    if kept.shape != made.shape or np.abs(system.layout.positions(kept - made)).max() > ONE_PLACE * np.abs(made).max():
        raise InputError("the surface and the mesh of the file do not make the undeformed state that is in it")
    if not np.array_equal(kept, made):
        setattr(system, MOVE, made - kept)
    return system


READERS: dict[str, Callable[[Getter, Any], Any]] = {
    "mapping": _mapping, "list": _list, "rows": _rows, "ragged": _ragged, "MeshQuad": _mesh, "MeshQuadTree": _tree,
    "System": _system,
}  # fmt: skip
"""How groups are read that are no object of the lists of classes."""
