"""What supports and hinges hold of the nodes of bricks: linear equations, each with a displacement that no other has."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from skancf.conditions import Hinge
from skancf.errors import InputError, shown, unit_vector
from skancf.export.bricks import Bricks
from skancf.functions import values_at
from skancf.supports import Clamp, NoRotation, Pin, Prescribed, Roller, SimpleSupport, Symmetry
from skancf.supports.conditions import edges
from skancf.tolerances import CONTRADICTION, DEPENDENT, SEVEN_DIGITS
from skancf.vectors import cross

AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class Spots:
    """Lines of a place and, where it is an edge, its direction there.

    Attributes
    ----------
    lines : (m,) int array
        A line once for each edge that passes it.
    tangents, normals : (m, 3) arrays
        Unit vectors along the edge and of the surface; tangents are zero at single points.
    """

    lines: np.ndarray
    tangents: np.ndarray
    normals: np.ndarray

    @property
    def outwards(self) -> np.ndarray:
        """In the surface across the edge, (m, 3)."""
        return np.asarray(cross(self.tangents.T, self.normals.T).T)

    @property
    def along_edges(self) -> bool:
        return bool(self.tangents.any(axis=1).all())


def spots(bricks: Bricks, where: Any) -> Spots:
    """Those of a place, see :class:`~skancf.supports.Support`."""
    geometry = bricks.system.geometry
    alone = [np.zeros(2)]
    at_nodes = [(geometry.ties.node_of[node], way) for node, ways in edges(geometry, where).items() for way in ways or alone]
    facets = geometry.points_and_facets(where)[1]
    lines = np.array([*(line for line, _ in at_nodes), *bricks.lines_of_facets(facets)], dtype=int)
    ways = np.array([*(way for _, way in at_nodes), *geometry.facet_directions(facets).T])
    slopes = np.stack(geometry.surface.derivatives(*bricks.at[:, lines]))
    tangents = np.einsum("md,dim->mi", ways.reshape(-1, 2), slopes)
    size = np.linalg.norm(tangents, axis=1)[:, None]
    return Spots(lines, np.divide(tangents, size, out=np.zeros_like(tangents), where=size > 0), bricks.normals[:, lines].T)


@dataclass
class Equations:
    """Rows of weights times displacements = values; unknown 3 n + axis is that of node n."""

    bricks: Bricks
    rows: list[sp.csr_matrix] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)

    def add(self, weights: sp.csr_matrix, directions: np.ndarray, values: Any = 0.0) -> None:
        """The component along directions (m, 3) of what weights (m, n_nodes) make of the displacements."""
        self.rows.append(sp.hstack([weights.multiply(d[:, None]) for d in directions.T], format="csr"))
        self.values.append(np.broadcast_to(np.asarray(values, float), len(directions)))

    def hold_position(self, lines: np.ndarray, directions: np.ndarray, values: Any = 0.0) -> None:
        self.add(self.bricks.weights[0][lines], directions, values)

    def hold_tilt(self, lines: np.ndarray, directions: np.ndarray) -> None:
        self.add(self.bricks.weights[1][lines], directions)

    def hold_all(self, lines: np.ndarray, directions: np.ndarray) -> None:
        """Every node of the lines."""
        belongs = sp.csr_matrix((np.ones(self.bricks.n_nodes), (self.bricks.line_of, np.arange(self.bricks.n_nodes))))[lines]
        row = np.repeat(np.arange(len(lines)), np.diff(belongs.indptr))
        shape = (belongs.nnz, self.bricks.n_nodes)
        self.add(sp.csr_matrix((np.ones(belongs.nnz), (np.arange(belongs.nnz), belongs.indices)), shape), directions[row])

    def reduced(self) -> tuple[list["Equation"], list["Equation"]]:
        """Single displacements that are given, and equations between several; no first unknown of one is in another.

        Raises
        ------
        InputError
            For supports that contradict each other.
        """
        if not self.rows:
            return [], []
        n = self.bricks.n_nodes
        by_axis = sp.vstack(self.rows, format="coo")
        column = 3 * (by_axis.col % n) + by_axis.col // n
        matrix = sp.csr_matrix((by_axis.data, (by_axis.row, column)), by_axis.shape)
        matrix.eliminate_zeros()
        values = np.concatenate(self.values)
        at = matrix.tocoo()
        node = sp.csr_matrix((np.ones(at.nnz), (at.row, at.col // 3)), (len(values), n))
        group = connected_components(node @ node.T, directed=False)[1]
        found: list[Equation] = []
        order = np.argsort(group, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
            part = matrix[rows].tocsc()
            used = np.flatnonzero(np.diff(part.indptr))
            found += _reduced(part[:, used].toarray(), values[rows], used)
        return [each for each in found if len(each.unknowns) == 1], [each for each in found if len(each.unknowns) > 1]


@dataclass(frozen=True)
class Equation:
    """Coefficients times unknowns = value; the first coefficient is one."""

    unknowns: list[int]
    coefficients: list[float]
    value: float


def _reduced(matrix: np.ndarray, values: np.ndarray, unknowns: np.ndarray) -> list[Equation]:
    """Gauss and Jordan's elimination with full pivoting; rows that depend on others are left out."""
    work, left = np.column_stack([matrix, values]), np.arange(len(matrix))
    scale, pivots = np.abs(matrix).max(), []
    while left.size:
        sizes = np.abs(work[left, :-1])
        first, column = (int(k) for k in np.unravel_index(np.argmax(sizes), sizes.shape))
        if sizes[first, column] <= DEPENDENT * scale:
            break
        pivot = int(left[first])
        work[pivot] /= work[pivot, column]
        others = np.arange(len(work)) != pivot
        work[others] -= np.outer(work[others, column], work[pivot])
        pivots.append((pivot, column))
        left = np.delete(left, first)
    if left.size and np.abs(work[left, -1]).max() > CONTRADICTION * np.abs(values).max():
        raise InputError("supports: two prescribe different displacements of the same place")
    out = []
    for pivot, column in pivots:
        row = work[pivot, :-1]
        rest = np.flatnonzero((np.abs(row) > DEPENDENT) & (np.arange(len(row)) != column))
        chosen = [column, *rest]
        out.append(Equation(unknowns[chosen].tolist(), row[chosen].tolist(), float(work[pivot, -1])))
    return out


def _clamp(bricks: Bricks, support: Clamp, out: Equations) -> None:
    """Nothing moves in the surface, and the reference surface not at all: the thickness stays free."""
    place = _edges(bricks, support)
    out.hold_all(place.lines, place.tangents)
    out.hold_all(place.lines, place.outwards)
    _pin(bricks, support, out)


def _pin(bricks: Bricks, support: Any, out: Equations) -> None:
    lines = spots(bricks, support.where).lines
    for axis in AXES:
        out.hold_position(lines, np.tile(axis, (len(lines), 1)))


def _no_rotation(bricks: Bricks, support: NoRotation, out: Equations) -> None:
    place = _edges(bricks, support)
    out.hold_tilt(place.lines, place.outwards)


def _simple(bricks: Bricks, support: SimpleSupport, out: Equations) -> None:
    _pin(bricks, support, out)
    if support.kind == "hard":
        place = _edges(bricks, support)
        out.hold_tilt(place.lines, place.tangents)


def _roller(bricks: Bricks, support: Roller, out: Equations) -> None:
    place = spots(bricks, support.where)
    out.hold_position(place.lines, np.tile(unit_vector("direction", support.direction), (len(place.lines), 1)))
    if support.kind == "hard":
        place = _edges(bricks, support)
        out.hold_tilt(place.lines, place.tangents)


def _symmetry(bricks: Bricks, support: Symmetry, out: Equations) -> None:
    place = _edges(bricks, support)
    out.hold_all(place.lines, place.outwards)


def _prescribed(bricks: Bricks, support: Prescribed, out: Equations) -> None:
    if support.rotation is not None:
        raise InputError(f"support {shown(support)}: a prescribed rotation is not exported; a displacement is")
    lines = spots(bricks, support.where).lines
    for axis, u in zip(AXES, support.components(bricks.system.geometry), strict=True):
        if u is not None:
            values = values_at("displacement", u, bricks.at[:, lines])
            out.hold_position(lines, np.tile(axis, (len(lines), 1)), values)


def _edges(bricks: Bricks, support: Any) -> Spots:
    place = spots(bricks, support.where)
    if not place.along_edges:
        raise InputError(f"support {shown(support)}: at single points it holds a rotation, which a brick does not have; "
                         "give an edge, or export a Pin")  # fmt: skip
    return place


SUPPORTS: dict[type, Callable[[Bricks, Any, Equations], None]] = {
    Clamp: _clamp, Pin: _pin, NoRotation: _no_rotation, SimpleSupport: _simple, Roller: _roller, Symmetry: _symmetry,
    Prescribed: _prescribed,
}  # fmt: skip


def equations(bricks: Bricks) -> Equations:
    """What the supports and hinges of a problem hold.

    Raises
    ------
    InputError
        For supports and conditions that are not exported.
    """
    problem, out = bricks.system.problem, Equations(bricks)
    for support in problem.supports:
        if type(support) not in SUPPORTS:
            raise InputError(f"support {shown(support)}: class {type(support).__name__} is not exported; these are: "
                             f"{', '.join(kind.__name__ for kind in SUPPORTS)}")  # fmt: skip
        SUPPORTS[type(support)](bricks, support, out)
    for condition in problem.conditions:
        if type(condition) is not Hinge:
            raise InputError(f"condition {condition.name!r}: class {type(condition).__name__} is not exported; Hinge is")
        _hinge(bricks, condition, out)
    return out


def _hinge(bricks: Bricks, hinge: Hinge, out: Equations) -> None:
    first, second = (np.unique(spots(bricks, where).lines) for where in hinge.wheres.values())
    places = bricks.places.T
    distance, nearest = cKDTree(places[second]).query(places[first])
    size = np.ptp(places[first], axis=0).max()
    if len(first) != len(second) or distance.max() > SEVEN_DIGITS * size or len(np.unique(nearest)) < len(nearest):
        raise InputError(f"condition {hinge.name!r}: the elements of its two edges do not match; give both as many, of "
                         "the same lengths")  # fmt: skip
    apart = sp.csr_matrix(bricks.weights[0][first] - bricks.weights[0][second[nearest]])
    for axis in AXES:
        out.add(apart, np.tile(axis, (len(first), 1)))
