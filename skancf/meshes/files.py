"""Meshes from other programs, and for them: files of gmsh, Abaqus, VTK and whatever else meshio knows."""

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np
import skfem

from skancf.arguments import MESH, instance, text
from skancf.atomic import AnyPath, as_path, check_file, replacing
from skancf.errors import InputError
from skancf.meshes.check import check_mesh
from skancf.meshes.finder import element_finder
from skancf.tolerances import SEVEN_DIGITS

QUADS = ("quad", "quad8", "quad9")
EDGES = ("line", "line3")
POINTS = ("vertex",)
FORMATS: dict[str, dict[str, Any]] = {
    ".msh": {"file_format": "gmsh22", "binary": False},
    ".inp": {"file_format": "abaqus"},
    ".vtu": {},
    ".vtk": {},
}
"""Those that are written, and the options of those that have names of edges and elements; in the others scikit-fem keeps
names as data of the elements."""


def from_file(path: AnyPath) -> skfem.MeshQuad:
    """Read a mesh of quadrilaterals of the parameter plane, with the names of its edges and parts.

    Named groups of edges, such as physical groups of gmsh, become boundaries, which supports and loads name as their
    place. Named groups of elements become subdomains, which :func:`within` makes the place of a zone. An outline without
    names is still ``"boundary"``, and holes are ``"openings"``; a group without a name has its number.

    Of elements of second order the corners are kept: a curved shape belongs into the surface. Nodes without an element,
    such as centres of arcs, are left out. Coordinates are x and y; z must be one number for all.

    Parameters
    ----------
    path : str or Path
        Any format of meshio, such as ``.msh`` (gmsh), ``.inp`` (Abaqus, CalculiX), ``.vtu``, ``.vtk``, ``.med``, ``.xdmf``.

    Raises
    ------
    InputError
        For a file that cannot be read; for triangles and volumes, and meshes with them; for nodes that are not in a plane of
        constant z; for named edges that are no edges of the elements; and for what :func:`check_mesh` refuses.

    Examples
    --------
    >>> mesh = sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 4, 4)
    >>> again = sk.meshes.from_file(sk.meshes.to_file(mesh, "plate.msh"))
    >>> again.nelements, sorted(again.boundaries)
    (16, ['bottom', 'left', 'right', 'top'])
    """
    file = as_path("path", path)
    found = _read(file)
    _check_kinds(file, found)
    points, old = _in_plane(file, np.asarray(found.points, dtype=float)), _cells(found, QUADS, 4)
    # Gmsh repeats an element for each of its groups.
    _, first, number = np.unique(np.sort(old, axis=1), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    number = np.argsort(order)[number.ravel()]
    old = old[first[order]]
    used, corners = np.unique(old, return_inverse=True)
    quads = corners.reshape(old.shape).T.astype(np.int32)
    places = np.ascontiguousarray(points[used].T)
    mesh = skfem.MeshQuad(places, quads, sort_t=False)
    check_mesh(mesh)
    sides, parts = _groups(found, EDGES), _groups(found, QUADS)
    edges = _cells(found, EDGES, 2)
    boundaries = {name: _facets(file, name, mesh, used, edges[members]) for name, members in sides.items()}
    subdomains = {name: np.unique(number[members]).astype(np.int32) for name, members in parts.items()}
    kept = mesh if len(number) > len(old) else _kept_by_skfem(found, mesh)
    boundaries.update(kept.boundaries or {})
    subdomains.update(kept.subdomains or {})
    return skfem.MeshQuad(places, quads, boundaries or None, subdomains or None, sort_t=False)


def to_file(mesh: skfem.MeshQuad, path: AnyPath) -> Path:
    """Write a mesh of the parameter plane with its names; an older file stays as it was until the new one is whole.

    Parameters
    ----------
    mesh : skfem.MeshQuad
        Without hanging nodes; :func:`save` keeps quadtrees.
    path : str or Path
        In ``.msh`` (gmsh) and ``.inp`` (Abaqus, CalculiX) named edges are groups of lines; in ``.vtu`` and ``.vtk`` names
        are data of the elements, as scikit-fem writes and reads them.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For what is no mesh, a mesh with hanging nodes, and another format.

    Examples
    --------
    >>> path = sk.meshes.to_file(sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 4, 4), "plate.inp")
    """
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    if len(getattr(mesh, "hanging", ())):
        raise InputError("mesh: it has hanging nodes, which files of other programs cannot have; sk.meshes.save keeps it")
    file = check_file(path, *FORMATS)
    import meshio

    options = FORMATS[file.suffix.lower()]
    out = _with_names(mesh) if options else _as_data(mesh)
    # Meshio prints what it thinks of a format.
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), replacing(file) as part:
        meshio.write(part, out, **options)
    return file


def within(mesh: skfem.MeshQuad, name: str) -> Any:
    """A function of (x, y) that is true in the elements of a subdomain, for ``where`` of a :class:`~skancf.Zone`.

    Raises
    ------
    InputError
        For a name that no subdomain of the mesh has.

    Examples
    --------
    >>> mesh = sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 4, 4).with_subdomains({"patch": lambda x: x[0] < 0.5})
    >>> zone = sk.Zone("patch", sk.meshes.within(mesh, "patch"), thickness=0.02)
    """
    instance("mesh", mesh, skfem.MeshQuad, MESH)
    known = mesh.subdomains or {}
    if text("name", name) not in known:
        raise InputError(f"name = {name!r}: no subdomain of this mesh; it has {sorted(known)}")
    inside = np.zeros(mesh.nelements, dtype=bool)
    inside[np.asarray(known[name])] = True
    finder = element_finder(mesh)

    def where(x: Any, y: Any) -> Any:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return inside[finder(x.ravel(), y.ravel())].reshape(x.shape)

    return where


def _read(file: Path) -> Any:
    """What meshio makes of a file; it prints and ends the program where it fails."""
    import meshio

    if not file.is_file():
        raise InputError(f"path = '{file}': there is no such file")
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(file)
    except (Exception, SystemExit) as wrong:
        why = " ".join(said.getvalue().split()) or str(wrong)
        raise InputError(f"path = '{file}': is no file of a mesh that meshio reads, or is damaged ({why[:200]})") from wrong


def _check_kinds(file: Path, found: Any) -> None:
    """InputError for all but quadrilaterals and edges."""
    counts: dict[str, int] = {}
    for block in found.cells:
        counts[block.type] = counts.get(block.type, 0) + len(block.data)
    others = {kind: n for kind, n in counts.items() if kind not in (*QUADS, *EDGES, *POINTS)}
    if any(kind.startswith("triangle") for kind in others):
        n = sum(n for kind, n in others.items() if kind.startswith("triangle"))
        raise InputError(f"path = '{file}': {n} of its elements are triangles; have quadrilaterals made of them, in gmsh by "
                         "'Recombine Surface' or the option Mesh.RecombineAll = 1")  # fmt: skip
    if others:
        what = ", ".join(f"{n} {kind}" for kind, n in others.items())
        raise InputError(f"path = '{file}': has {what}; give a mesh of quadrilaterals of the parameter plane")
    if not any(kind in counts for kind in QUADS):
        raise InputError(f"path = '{file}': has no quadrilaterals; in gmsh, generate the mesh of dimension 2 and save it")


def _in_plane(file: Path, points: np.ndarray) -> np.ndarray:
    """The first two coordinates, (n, 2)."""
    if points.shape[1] > 2:
        low, high = points.min(axis=0), points.max(axis=0)
        if high[2] - low[2] > SEVEN_DIGITS * (high - low).max():
            raise InputError(f"path = '{file}': z runs from {low[2]:.6g} to {high[2]:.6g}; a mesh is one of the parameter "
                             "plane (x, y), and the shape in space is that of the surface, as sk.MappedSurface")  # fmt: skip
    return points[:, :2]


def _cells(found: Any, kinds: tuple[str, ...], n: int) -> np.ndarray:
    """The first n nodes of all cells of some kinds, (m, n)."""
    parts = [np.asarray(block.data)[:, :n] for block in found.cells if block.type in kinds]
    return np.concatenate(parts).astype(int) if parts else np.empty((0, n), dtype=int)


def _groups(found: Any, kinds: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Numbers of cells among those of some kinds, by the names of groups."""
    own = [k for k, block in enumerate(found.cells) if block.type in kinds]
    starts = np.cumsum([0, *(len(found.cells[k].data) for k in own)])
    out: dict[str, np.ndarray] = {}
    for name, members in (found.cell_sets or {}).items():
        parts = [
            start + np.asarray(members[k], dtype=int)
            for k, start in zip(own, starts, strict=False)
            if members[k] is not None
        ]
        numbers = np.concatenate([np.empty(0, dtype=int), *parts])
        if numbers.size and not name.startswith("gmsh:"):
            out[name] = numbers
    if out or "gmsh:physical" not in found.cell_data:
        return out
    tags = [np.asarray(found.cell_data["gmsh:physical"][k]) for k in own]
    tag = np.concatenate([np.empty(0, dtype=int), *tags])
    dimension = 1 if kinds == EDGES else 2
    names = {int(number): name for name, (number, of) in (found.field_data or {}).items() if of == dimension}
    return {names.get(int(k), str(k)): np.flatnonzero(tag == k) for k in np.unique(tag) if k > 0}


def _facets(file: Path, name: str, mesh: skfem.MeshQuad, used: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Facets of a mesh that are edges (m, 2) between nodes of the file."""
    at = np.searchsorted(used, edges)
    known = (at < len(used)) & (used[np.minimum(at, len(used) - 1)] == edges)
    pairs, ends = np.sort(at, axis=1), np.sort(mesh.facets, axis=0)
    size = np.int64(len(used) + 1)
    keys, order = ends[0] * size + ends[1], np.argsort(ends[0] * size + ends[1])
    wanted = pairs[:, 0] * size + pairs[:, 1]
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    facets = order[place]
    lost = ~known.all(axis=1) | (keys[facets] != wanted)
    if lost.any():
        raise InputError(f"path = '{file}': {lost.sum()} of the {len(edges)} edges named {name!r} are no edges of the "
                         "quadrilaterals; name the edges of the surface that is meshed")  # fmt: skip
    return np.unique(facets).astype(np.int32)


def _kept_by_skfem(found: Any, mesh: skfem.MeshQuad) -> skfem.MeshQuad:
    """The mesh with names that scikit-fem keeps as data of the elements."""
    import meshio
    from skfem.io.meshio import from_meshio

    own = [k for k, block in enumerate(found.cells) if block.type in QUADS]
    data = {name: [np.concatenate([np.asarray(values[k]) for k in own])] for name, values in found.cell_data.items()
            if name.startswith("skfem:")}  # fmt: skip
    return from_meshio(meshio.Mesh(mesh.p.T, [("quad", mesh.t.T)], cell_data=data)) if data else mesh


def _in_space(mesh: skfem.MeshQuad) -> np.ndarray:
    """Nodes (n, 3) with z = 0, as many formats want them."""
    return np.column_stack([mesh.p.T, np.zeros(mesh.p.shape[1])])


def _with_names(mesh: skfem.MeshQuad) -> Any:
    """A mesh with groups of lines and elements."""
    import meshio

    sides = {name: np.asarray(facets) for name, facets in (mesh.boundaries or {}).items()}
    parts = {name: np.asarray(members) for name, members in (mesh.subdomains or {}).items()}
    cells: list[tuple[str, np.ndarray]] = [("line", mesh.facets[:, facets].T) for facets in sides.values()]
    rest = np.setdiff1d(np.arange(mesh.nelements), np.concatenate([np.empty(0, dtype=int), *parts.values()]))
    # An element is repeated for each of its groups, as gmsh does it.
    blocks = [*parts.items(), *([("", rest)] if rest.size else [])]
    cells += [("quad", mesh.t[:, members].T) for _, members in blocks]
    names = [*sides, *(name for name, _ in blocks)]
    dimensions = [1] * len(sides) + [2] * len(blocks)
    tags = [0 if not name else k for k, name in enumerate(names, 1)]
    tagged = [np.full(len(block), tag) for (_, block), tag in zip(cells, tags, strict=True)]
    sets = {name: [np.arange(len(block)) if k == number else np.empty(0, dtype=int) for k, (_, block) in enumerate(cells)]
            for number, name in enumerate(names) if name}  # fmt: skip
    field = {name: np.array([tag, dim]) for name, tag, dim in zip(names, tags, dimensions, strict=True) if name}
    return meshio.Mesh(_in_space(mesh), cells, cell_sets=sets, field_data=field,
                       cell_data={"gmsh:physical": tagged, "gmsh:geometrical": tagged})  # fmt: skip


def _as_data(mesh: skfem.MeshQuad) -> Any:
    from skfem.io.meshio import to_meshio

    plain = skfem.MeshQuad(mesh.p, mesh.t, mesh.boundaries, mesh.subdomains, sort_t=False)
    out = to_meshio(plain)
    out.points = _in_space(mesh)
    return out
