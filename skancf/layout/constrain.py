r"""Conditions of supports on the nodal coordinates, turned into constraints in nodal frames.

Nodal coordinates have units of their own, m, m per unit of x, m per unit of y and so on, so that a condition of several of
them, such as that of no rotation about the normal, is compared with others, and called zero, in multiples of their
:attr:`~skancf.layout.geometry.Geometry.scales` s: :math:`a \cdot e = \sum a_i s_i \, (e_i / s_i)`.
"""

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from skancf.errors import InputError, finite, shown, vector
from skancf.functions import Noted, is_ours
from skancf.history import Case, no_case
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout
from skancf.linear import Constraints
from skancf.tolerances import ABOVE_ZERO, PARALLEL, SAME_VALUE


class PrescribedMotion:
    """Prescribed changes of the coordinates: a sum of vectors, each with its function of time."""

    def __init__(self, n_dofs: int, parts: list[tuple[np.ndarray, Any]]):
        self.n_dofs, self.parts = n_dofs, parts

    def histories(self) -> list[Any]:
        """The functions of time."""
        return [history for _, history in self.parts]

    @property
    def without_time(self) -> list[str]:
        """What is to be said where values are taken without a time."""
        return sorted({hint for history in self.histories() if (hint := getattr(history, "without_time", None))})

    def values(self, case: Case) -> np.ndarray:
        """(n_dofs,); in statics at full amplitude, and at rest without a time: see ``without_time``."""
        if not isinstance(case, Case):
            raise no_case(case)
        total = np.zeros(self.n_dofs)
        for change, history in self.parts:
            total += case.amplitude(history) * change
        return total


def constrain(geometry: Geometry, supports: Sequence[Any], layout: Layout) -> tuple[Constraints, PrescribedMotion]:
    """Constraints and prescribed motion of all supports together, on a layout whose first blocks are the plate's nodes.

    Raises
    ------
    InputError
        Where two supports ask for different values of the same coordinate.
    """
    histories: list[Any] = [None]
    for history in chain.from_iterable(support.histories for support in supports):
        if not any(history is known for known in histories):
            histories.append(history)
    conditions = [_conditions(geometry, support, histories) for support in supports]
    if not geometry.theory.directors:
        none = np.hstack([np.eye(12)[9:], np.zeros((3, len(histories)))])  # a pole has three vectors only
        conditions += [(np.full(3, node), none) for node in geometry.ties.poles]
    nodes, rows = np.empty(0, dtype=int), np.empty((0, 12 + len(histories)))
    if conditions:
        nodes, rows = (np.concatenate(parts) for parts in zip(*conditions, strict=True))
    order = np.argsort(nodes, kind="stable")
    held, first = np.unique(nodes[order], return_index=True)
    fixed = layout.held.copy()
    changes = np.zeros((len(histories), layout.n_blocks, 12))
    frame_nodes, frames = [], []
    known: dict[bytes, tuple[np.ndarray, np.ndarray | None, np.ndarray]] = {}
    for node, begin, end in zip(held.tolist(), first, [*first[1:], len(order)], strict=False):
        part, scales = order[begin:end], geometry.scales[node]
        key = rows[part].tobytes() + scales.tobytes()
        if key not in known:  # nodes along a straight edge are alike
            known[key] = _held(geometry, node, rows[part, :12], rows[part, 12:], scales)
        axes, frame, change = known[key]
        fixed[node, axes] = True
        if frame is not None:
            frame_nodes.append(node)
            frames.append(frame)
        changes[:, node] = change.T
    constraints = Constraints(fixed, np.array(frame_nodes, dtype=np.int64), np.array(frames).reshape(-1, 12, 12))
    parts = [(change.ravel(), history) for change, history in zip(changes, histories, strict=True) if change.any()]
    return constraints, PrescribedMotion(fixed.size, parts)


def _conditions(geometry: Geometry, support: Any, histories: list[Any]) -> tuple[np.ndarray, np.ndarray]:
    """The nodes (m,) that a support holds, and of each of its conditions the unit vector a s and the values for all
    histories, (m, 12 + n_histories)."""
    found = support.rows(geometry) if is_ours(support) else _own_rows(geometry, support)
    ties, nodes = geometry.ties, np.array([row.node for row in found], dtype=int)
    given = np.array([row.a for row in found]).reshape(-1, 12)
    seen = np.array([not row.own for row in found], dtype=bool)  # with the slopes seen from that node of the mesh
    a, terms = given.copy(), np.abs(given)
    mix = ties.mix[nodes[seen]]
    a[seen] = np.einsum("nkl,nki->nli", mix, given[seen].reshape(-1, 4, 3)).reshape(-1, 12)
    terms[seen] = np.einsum("nkl,nki->nli", np.abs(mix), terms[seen].reshape(-1, 4, 3)).reshape(-1, 12)
    numbers = [next(k for k, known in enumerate(histories) if known is history) for history in support.histories]
    values = np.zeros((len(found), len(histories)))
    if found:
        values[:, numbers] = np.array([row.value for row in found]).reshape(len(found), -1)
    nodes = ties.node_of[nodes]
    a, terms = a * geometry.scales[nodes], terms * geometry.scales[nodes]
    sizes = np.linalg.norm(a, axis=1)
    kept = sizes > PARALLEL * np.linalg.norm(terms, axis=1)  # a vector that a pole does not have needs no holding
    return nodes[kept], np.hstack([a, values])[kept] / sizes[kept, None]


def shares_of_supports(
    geometry: Geometry, supports: Sequence[Any], force: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    r"""The nodes (m,) that each support holds, and its share (n_nodes, 12) of the forces (n_nodes, 12) on what is held.

    The force on a condition :math:`a \cdot e` is a multiple of a: those of each node are the smallest ones that add up to
    the force there, so that conditions of several supports that are one share it equally.
    """
    histories = list(dict.fromkeys(chain([None], *(support.histories for support in supports))))
    held = [_conditions(geometry, support, histories) for support in supports]
    nodes = np.concatenate([np.empty(0, dtype=int), *(nodes for nodes, _ in held)])
    rows = np.concatenate([np.empty((0, 12)), *(rows[:, :12] for _, rows in held)])
    owner = np.repeat(np.arange(len(held)), [len(nodes) for nodes, _ in held])
    out = np.zeros((len(held), len(force), 12))
    order = np.argsort(nodes, kind="stable")
    found, first = np.unique(nodes[order], return_index=True)
    for node, part in zip(found, np.split(order, first[1:]), strict=True):
        A, scales = rows[part], geometry.scales[node]
        shares = np.linalg.lstsq(A.T, force[node] * scales, rcond=PARALLEL)[0]
        np.add.at(out[:, node], owner[part], shares[:, None] * A / scales)
    return [(np.unique(nodes), share) for (nodes, _), share in zip(held, out, strict=True)]


def _own_rows(geometry: Geometry, support: Any) -> list[Any]:
    """The conditions of a support of the user's own."""
    with Noted("support.rows"):
        rows = list(support.rows(geometry))
        for row in rows:
            if not all(hasattr(row, name) for name in ("node", "a", "value", "own")):
                raise InputError(f"support.rows of {shown(support)}: {shown(row)} is no condition; give a Row of "
                                 "skancf.supports.conditions")  # fmt: skip
            vector("a, of a row of support.rows,", row.a, 12)
            finite("value, of a row of support.rows,", row.value)
            if not 0 <= row.node < geometry.mesh.p.shape[1]:
                raise InputError(f"node = {shown(row.node)} of a row of support.rows: the mesh has nodes 0 to "
                                 f"{geometry.mesh.p.shape[1] - 1}")  # fmt: skip
    return rows


def _held(
    geometry: Geometry, node: int, A: np.ndarray, values: np.ndarray, scales: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Which coordinates (rank,) are held, those of a frame (12, 12) or without one, and how they change (12, n_histories).

    The conditions A (n, 12) are those on coordinates in multiples of their scales (12,).
    """
    span = _span(A)
    change = span.T @ np.linalg.lstsq(A @ span.T, values, rcond=None)[0]
    _check_consistent(geometry, node, A @ change, values)
    change *= scales[:, None]
    axes = np.flatnonzero((np.abs(span) > PARALLEL).any(axis=0))
    if len(axes) == len(span):
        frame, held = None, np.eye(12)[axes]
    else:
        frame = _frame(span, scales)
        axes = np.arange(len(span))
        held = frame[axes]
    return axes, frame, held.T @ (held @ change)


def _span(A: np.ndarray) -> np.ndarray:
    """Orthonormal rows that span those of A."""
    counts = np.abs(A) > PARALLEL
    if (counts.sum(axis=1) == 1).all():
        return np.eye(12)[counts.any(axis=0)]
    _, sizes, rows = np.linalg.svd(A)
    return np.asarray(rows[: int((sizes > PARALLEL * sizes[0]).sum())])


def _frame(span: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """An orthonormal frame (12, 12) of coordinates as they are, of which the first rows are those held.

    Of all of them the one that mixes no more coordinates than a condition does, and is orthogonal in multiples of the scales
    too, so that a direction has one scale: the bending stiffness of a thin plate would be lost in the rounding of a
    membrane stiffness that a frame mixes with it.
    """
    projector = span.T @ span
    n, part = connected_components(sp.csr_matrix(np.abs(projector) > PARALLEL), directed=False)
    held: list[np.ndarray] = []
    free: list[np.ndarray] = []
    for k in range(n):
        own = np.flatnonzero(part == k)
        shares, vectors = np.linalg.eigh(projector[np.ix_(own, own)])
        for rows, of, factors in ((held, shares > 0.5, 1 / scales[own]), (free, shares < 0.5, scales[own])):
            basis = np.zeros((np.count_nonzero(of), 12))
            basis[:, own] = np.linalg.svd(factors[:, None] * vectors[:, of], full_matrices=False)[0].T
            rows.append(basis)
    frame = np.vstack([*held, *free])
    return np.asarray(1.5 * frame - 0.5 * frame @ frame.T @ frame)  # orthonormal to the last digit


def _check_consistent(geometry: Geometry, node: int, found: np.ndarray, values: np.ndarray) -> None:
    if np.abs(found - values).max() > SAME_VALUE * max(ABOVE_ZERO, np.abs(values).max()):
        raise InputError(f"supports at the node {tuple(geometry.points[:, node].tolist())} prescribe different values "
                         "for the same coordinate; let one of them go")  # fmt: skip
