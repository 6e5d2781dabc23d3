"""Quadtree meshes as files of plain arrays."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import skfem

from skancf.arguments import instance
from skancf.atomic import AnyPath, as_path, check_file, replacing
from skancf.errors import InputError
from skancf.meshes.coarse import forest_of
from skancf.meshes.forest import AROUND, DEEPEST, Cells, Forest, Leaves
from skancf.meshes.names import Names
from skancf.meshes.quadtree import MeshQuadTree, grown

FORMAT = "skancf quadtree 1"
ARRAYS = {"points": (2, -1), "corners": (4, -1), "cells": (4, -1)}


def save(mesh: MeshQuadTree, path: AnyPath) -> Path:
    """Write a mesh to ``*.npz``; an older file stays as it was until the new one is whole.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> tree = sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate).refined([0])
    >>> file = sk.meshes.save(tree, "tree.npz")
    >>> sk.meshes.load("tree.npz").nelements
    7
    """
    instance("mesh", mesh, MeshQuadTree, "a quadtree, or save any mesh by skancf.save(mesh, 'mesh.h5')")
    file = check_file(path, ".npz")
    with replacing(file) as part, part.open("wb") as stream:
        np.savez_compressed(stream, format=np.array(FORMAT), **tree_arrays(mesh))  # type: ignore[arg-type]
    return file


def tree_arrays(mesh: MeshQuadTree) -> dict[str, np.ndarray]:
    """A quadtree as arrays by name."""
    forest, names = mesh.leaves.forest, Names.of(mesh)
    return {
        "points": forest.points, "corners": forest.corners, "closed": np.array(forest.closed),
        "cells": np.stack(mesh.leaves.cells),
        "sides": np.array(list(names.sides), dtype=str), "side_masks": _stacked(names.sides, (4, len(mesh.leaves))),
        "parts": np.array(list(names.elements), dtype=str),
        "part_masks": _stacked(names.elements, (len(mesh.leaves),)),
    }  # fmt: skip


def _stacked(masks: dict[str, np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    return np.stack(list(masks.values())) if masks else np.zeros((0, *shape), dtype=bool)


def load(path: AnyPath) -> MeshQuadTree:
    """Read what :func:`save` wrote; no code in the file is run.

    Raises
    ------
    InputError
        For a file that is not there, is no such file, or holds no mesh that fits together; the reason is named.

    Examples
    --------
    >>> plate = sk.Rectangle(1.0, 1.0)
    >>> file = sk.meshes.save(sk.meshes.quadtree(sk.meshes.uniform(plate, 2, 2), plate), "tree.npz")
    >>> sk.meshes.load(file).nelements
    4
    """
    file = as_path("file", path)
    if not file.is_file():
        raise InputError(f"file '{file}': there is no such file")
    try:
        with np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
    except Exception as error:  # damage shows in many ways: in numpy's headers, in the archive, in what it unpacks
        raise InputError(f"file '{file}': is no quadtree mesh, or is damaged ({error}); write it again") from error
    try:
        if str(arrays.get("format")) != FORMAT:
            raise Unfit(f"is {arrays.get('format')}, this version reads '{FORMAT}'")
        return tree_of(arrays)
    except Unfit as reason:
        raise InputError(f"file '{file}': {reason}; write it again") from reason


class Unfit(Exception):
    """What does not fit in a file."""


def tree_of(data: Mapping[str, Any]) -> MeshQuadTree:
    """The quadtree of :func:`tree_arrays`; Unfit where they do not fit together."""
    for name, shape in ARRAYS.items():
        array = data.get(name)
        kind = "f" if name == "points" else "iu"
        if array is None or array.ndim != 2 or array.shape[0] != shape[0] or array.dtype.kind not in kind:
            raise Unfit(f"{name} is missing or has another shape than {shape}")
    forest = _forest(data["points"], data["corners"].astype(np.int64), data.get("closed"))
    cells = Cells(*data["cells"].astype(np.int64))
    _check_cells(forest, cells)
    leaves = Leaves(forest, cells)
    if any((leaves.find(forest.beside(cells, *step).parents.parents) >= 0).any() for step in AROUND):
        raise Unfit("neighbouring elements differ by more than one level")
    return grown(leaves, Names(*(_masks(data, *keys, shape) for keys, shape in (
        (("sides", "side_masks"), (4, len(leaves))), (("parts", "part_masks"), (len(leaves),))))))  # fmt: skip


def _forest(points: np.ndarray, corners: np.ndarray, closed: Any) -> Forest:
    if not corners.size or not ((corners >= 0) & (corners < points.shape[1])).all():
        raise Unfit("corners names what is not there")
    if closed is None or closed.dtype != bool or closed.shape != (2,):
        raise Unfit("closed is missing or has another shape than (2,)")
    try:
        forest = forest_of(skfem.MeshQuad(points, corners), (bool(closed[0]), bool(closed[1])))
    except InputError as error:
        raise Unfit(f"its coarse mesh is invalid: {error}") from error
    if not (np.array_equal(forest.points, points) and np.array_equal(forest.corners, corners)):
        raise Unfit("a coarse element is no aligned rectangle with its lower left corner first")
    return forest


def _check_cells(forest: Forest, cells: Cells) -> None:
    level = cells.level
    if not ((cells.root >= 0) & (cells.root < forest.n_roots) & (level >= 0) & (level <= DEEPEST)).all():
        raise Unfit("an element has no root or a level out of range")
    if not ((cells.x >= 0) & (cells.y >= 0) & (np.maximum(cells.x, cells.y) >> level == 0)).all():
        raise Unfit("an element lies outside of its root")
    keys = cells.keys
    ancestors = cells
    covered = np.bincount(cells.root, 0.25**level, minlength=forest.n_roots)
    overlap = len(np.unique(keys)) < len(keys)
    for _ in range(int(level.max(initial=0))):
        ancestors = ancestors.parents
        overlap |= bool(np.isin(ancestors.keys[ancestors.root >= 0], keys).any())
    if overlap or not (covered == 1).all():
        raise Unfit("the elements overlap or leave a gap")


def _masks(data: Mapping[str, Any], names: str, masks: str, shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    found, values = (np.asarray(data.get(name)) for name in (names, masks))
    if found.ndim != 1 or found.dtype.kind != "U" or values.dtype != bool or values.shape != (len(found), *shape):
        raise Unfit(f"{names} and {masks} do not fit the elements")
    return dict(zip(found.tolist(), values, strict=True))
