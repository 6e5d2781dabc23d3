"""Elements joined edge to edge, one outline, and the whole of the surface."""

from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.sparse.csgraph import connected_components

from skancf.errors import InputError
from skancf.meshes.finder import element_finder
from skancf.meshes.openings import OPENING
from skancf.tolerances import APART_OF_EDGE, ONE_PLACE, SEVEN_DIGITS


def check_edges(mesh: skfem.MeshQuad) -> None:
    """Every edge belongs to one element, or to two on opposite sides of it."""
    owners = np.bincount(mesh.t2f.ravel(), minlength=mesh.facets.shape[1])
    wrong = (owners > 2).nonzero()[0]
    if not wrong.size:
        inner = (mesh.f2t[1] >= 0).nonzero()[0]
        start, end = mesh.p[:, mesh.facets[:, inner]].swapaxes(0, 1)
        middle = _middles(mesh)
        first, second = (_cross(end - start, middle[:, part] - start) for part in mesh.f2t[:, inner])
        wrong = inner[np.sign(first) == np.sign(second)]
    if wrong.size:
        _, elements = np.nonzero(mesh.t2f == wrong[0])
        _, which, count = np.unique(np.sort(mesh.t[:, elements], axis=0), axis=1, return_inverse=True, return_counts=True)
        twice = count.max() > 1
        elements = np.sort(elements[which.ravel() == count.argmax()] if twice else elements)
        names = " and ".join(map(str, elements))
        ends = " to ".join(f"({x:.6g}, {y:.6g})" for x, y in mesh.p[:, mesh.facets[:, wrong[0]]].T)
        if twice:
            raise InputError(f"elements {names} have the same corners: the plate would be there twice; keep one of them")
        raise InputError(f"elements {names} lie on the same side of their edge from {ends}: they overlap or are there "
                         "twice, and the plate with them; leave one of them out, or mend their corners")  # fmt: skip


def check_places(mesh: skfem.MeshQuad) -> None:
    """No two nodes at one place, between which the plate would be cut."""
    nodes = mesh.boundary_nodes()
    extent = np.ptp(mesh.p, axis=1, keepdims=True)
    ends = mesh.p[:, mesh.facets[:, mesh.boundary_facets()]] / extent[:, :, None]
    shortest = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=0).min())
    reach = min(SEVEN_DIGITS, APART_OF_EDGE * shortest)
    pairs = nodes[_near(mesh.p[:, nodes] / extent, reach)]
    if len(pairs):
        overlap = overlapping(mesh)
        if overlap:
            raise InputError(overlap)
        first, second = np.sort(pairs[0])
        raise InputError(f"nodes {first} and {second} are both at {_place(mesh.p[:, first])} ({len(pairs)} such pairs): the "
                         "plate would be cut there, with free edges; merge them into one node, or give openings= for a "
                         "real opening")  # fmt: skip


def _near(points: np.ndarray, reach: float) -> np.ndarray:
    """Pairs (n, 2) of points closer than that in both directions."""
    along = np.argsort(points[0])
    column = np.empty(len(along), dtype=int)
    column[along] = np.cumsum(np.diff(points[0, along], prepend=points[0, along[0]]) > reach)
    order = np.lexsort((points[1], column))
    close = (np.abs(np.diff(points[:, order])) <= reach).all(axis=0)
    return np.stack([order[:-1][close], order[1:][close]], axis=1)


def fills(mesh: skfem.MeshQuad, bounds: Any = None) -> bool:
    """Whether elements joined by edges cover a rectangle, the bounds or else that around the mesh, each point of it once.

    So they do where every edge of the boundary lies on the rectangle, and together they are as long as its sides: the number
    of elements over a point changes at the boundary only. There are no slits then either.
    """
    box = box_of(mesh, bounds)
    on, length = on_box(mesh, mesh.boundary_facets(), box)
    return bool(on.any(axis=(0, 1)).all() and (np.abs((on * length).sum(axis=2) - 1) < SEVEN_DIGITS).all())


def check_outline(mesh: skfem.MeshQuad, bounds: Any = None) -> None:
    """The elements are one piece without overlap, and reach to the bounds of the surface, where it has bounds.

    The boundary must be simple loops that do not cross, one around the elements and the others around holes. With bounds,
    the one around the elements lies on them, but for edges named ``"opening"``.
    """
    facets = mesh.boundary_facets()
    ends = mesh.p[:, mesh.facets[:, facets]]
    loops, areas = (_around if hasattr(mesh, "hanging") else _loops)(mesh, facets, ends)
    if bounds is None:
        return
    box = box_of(mesh, bounds)
    on, _ = on_box(mesh, facets, box)
    free = (areas[loops] > 0) & ~on.any(axis=(0, 1)) & ~np.isin(facets, (mesh.boundaries or {}).get(OPENING, []))
    if free.any():
        share = areas[areas > 0].sum() / np.prod(box[:, 1] - box[:, 0])
        middle = ends.mean(axis=1)[:, free][:, 0]
        covered = f"{100 * share:.4g} %" if share < 0.9999 else f"all but {100 * abs(1 - share):.1g} %"
        raise InputError(f"the mesh covers {covered} of the surface, which spans {_span(box)}: the edge of an "
                         f"element at {_place(middle)} is within it. What has no elements carries nothing; give a surface "
                         "of the size of the mesh, mesh all of it, or cut openings= (edges of cuts in a mesh of your own "
                         f"are the boundary {OPENING!r})")  # fmt: skip


def box_of(mesh: skfem.MeshQuad, bounds: Any) -> np.ndarray:
    """Smallest and largest x, and y, (2, 2)."""
    return np.stack([mesh.p.min(axis=1), mesh.p.max(axis=1)], axis=1) if bounds is None else np.array(bounds, float)


def on_box(mesh: skfem.MeshQuad, facets: np.ndarray, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether edges lie on x = min, x = max and y = min, y = max, (2, 2, n), and their lengths over those of these sides,
    (2, 1, n)."""
    ends = mesh.p[:, mesh.facets[:, facets]]
    size = box[:, 1] - box[:, 0]
    on = (np.abs(ends[:, None] - box[:, :, None, None]) <= ONE_PLACE * size[:, None, None, None]).all(axis=2)
    length = np.abs(ends[:, 1] - ends[:, 0]) / size[:, None]
    return on, length[::-1, None]


def _loops(mesh: skfem.MeshQuad, facets: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The loop of each edge of the boundary, and areas of loops, negative around holes; InputError where they are not
    simple."""
    count, piece = _pieces(mesh)
    if count > 1:
        other = int(np.argmax(piece != piece[0]))
        raise InputError(overlapping(mesh) or f"the mesh is {count} pieces without a common edge: element {other}, at "
                         f"{_place(_middles(mesh)[:, other])}, is in another than element 0; join them by edges, or make "
                         "a problem of each")  # fmt: skip
    at = np.bincount(mesh.facets[:, facets].ravel())
    if (at > 2).any():
        node = int(np.argmax(at > 2))
        raise InputError(overlapping(mesh) or f"elements meet at node {node}, {_place(mesh.p[:, node])}, by that node only, "
                         "which is a hinge; join them by an edge, or keep them apart by an element")  # fmt: skip
    crossing = _crossing(ends)
    loops, areas = _around(mesh, facets, ends)
    if crossing is not None or (areas > 0).sum() != 1:
        where = "" if crossing is None else f" near {_place(ends[:, :, crossing].mean(axis=1))}"
        raise InputError(overlapping(mesh) or f"elements overlap{where}: the plate would be there twice; mend the mesh")
    return loops, areas


def _pieces(mesh: skfem.MeshQuad) -> tuple[int, np.ndarray]:
    first, second = mesh.f2t[:, mesh.f2t[1] >= 0]
    n = mesh.nelements
    count, piece = connected_components(sp.coo_array((np.ones(len(first)), (first, second)), shape=(n, n)), directed=False)
    return int(count), piece


def _around(mesh: skfem.MeshQuad, facets: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    start, end = mesh.facets[:, facets]
    n = mesh.p.shape[1]
    _, label = connected_components(sp.coo_array((np.ones(len(start)), (start, end)), shape=(n, n)), directed=False)
    _, loops = np.unique(label[start], return_inverse=True)
    a, b = (ends[:, i] - mesh.p.mean(axis=1)[:, None] for i in (0, 1))
    inward = _cross(ends[:, 1] - ends[:, 0], _middles(mesh)[:, mesh.f2t[0, facets]] - ends[:, 0])
    return loops, np.bincount(loops, weights=np.sign(inward) * _cross(a, b) / 2)


def _crossing(ends: np.ndarray) -> int | None:
    """An edge that another one crosses."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    # Along the direction in which fewer edges are side by side.
    axis = int(np.argmin((high - low).sum(axis=1) / np.ptp(ends, axis=(1, 2))))
    order = np.argsort(low[axis], kind="stable")
    last = np.searchsorted(low[axis, order], high[axis, order])
    for k in range(1, int((last - np.arange(len(order))).max(initial=1))):
        i = np.flatnonzero(last - np.arange(len(order)) > k)
        one, two = ends[:, :, order[i]], ends[:, :, order[i + k]]
        across = _apart(one, two) & _apart(two, one)
        if across.any():
            return int(order[i[np.argmax(across)]])
    return None


def _apart(line: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Whether the two ends are on different sides of a line, by more than rounding."""
    along = line[:, 1] - line[:, 0]
    first, second = (_cross(along, ends[:, i] - line[:, 0]) for i in (0, 1))
    slack = SEVEN_DIGITS * (along**2).sum(axis=0)
    return np.asarray((np.minimum(first, second) < -slack) & (np.maximum(first, second) > slack))


def overlapping(mesh: skfem.MeshQuad) -> str | None:
    """Of two elements of which one holds the middle of the other."""
    middle = _middles(mesh)
    holds = element_finder(mesh)(*middle)
    other = np.flatnonzero(holds != np.arange(mesh.nelements))
    if not other.size:
        return None
    return (f"elements {holds[other[0]]} and {other[0]} overlap at {_place(middle[:, other[0]])} ({other.size} such pairs): "
            "the plate would be there twice; leave one of them out, or mend their corners")  # fmt: skip


def _middles(mesh: skfem.MeshQuad) -> np.ndarray:
    return np.asarray(mesh.p[:, mesh.t].mean(axis=1))


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def _place(point: np.ndarray) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def _span(box: np.ndarray) -> str:
    return " and ".join(f"{name} = {low:.6g} to {high:.6g}" for name, (low, high) in zip("xy", box, strict=True))
