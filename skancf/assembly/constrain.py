"""Conditions of supports on the nodal coordinates, turned into constraints in nodal frames."""

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.errors import InputError, finite, shown, vector
from skancf.functions import Noted, is_ours
from skancf.history import amplitude
from skancf.linear import BlockMatrix, Constraints

PARALLEL = 1e-9


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

    def values(self, time: float | None) -> np.ndarray:
        """(n_dofs,); without a time at full amplitude, and at rest where there is none: see ``without_time``."""
        total = np.zeros(self.n_dofs)
        for change, history in self.parts:
            total += amplitude(history, time) * change
        return total


def constrain(geometry: Geometry, supports: Sequence[Any]) -> tuple[Constraints, PrescribedMotion]:
    """Constraints and prescribed motion of all supports together.

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
    if geometry.theory.twist:
        none = np.hstack([np.eye(12)[9:], np.zeros((3, len(histories)))])  # a pole has three vectors only
        conditions += [(np.full(3, node), none) for node in geometry.ties.poles]
    nodes, rows = np.empty(0, dtype=int), np.empty((0, 12 + len(histories)))
    if conditions:
        nodes, rows = (np.concatenate(parts) for parts in zip(*conditions, strict=True))
    order = np.argsort(nodes, kind="stable")
    held, first = np.unique(nodes[order], return_index=True)
    fixed = np.zeros((geometry.n_nodes, 12), dtype=bool)
    changes = np.zeros((len(histories), geometry.n_nodes, 12))
    frame_nodes, frames = [], []
    known: dict[bytes, tuple[np.ndarray, int, np.ndarray, np.ndarray | None]] = {}
    for node, begin, end in zip(held.tolist(), first, [*first[1:], len(order)], strict=False):
        part = order[begin:end]
        key = rows[part].tobytes()
        if key not in known:  # nodes along a straight edge are alike
            known[key] = _held(geometry, node, rows[part, :12], rows[part, 12:])
        frame, rank, local, axes = known[key]
        if axes is not None:
            fixed[node, axes] = True
        else:
            fixed[node, :rank] = True
            frame_nodes.append(node)
            frames.append(frame)
        changes[:, node] = (frame[:rank].T @ local).T
    constraints = Constraints(fixed, np.array(frame_nodes, dtype=np.int64), np.array(frames).reshape(-1, 12, 12))
    parts = [(change.ravel(), history) for change, history in zip(changes, histories, strict=True) if change.any()]
    return constraints, PrescribedMotion(fixed.size, parts)


def _conditions(geometry: Geometry, support: Any, histories: list[Any]) -> tuple[np.ndarray, np.ndarray]:
    """The nodes (m,) that a support holds, and of each of its conditions the unit vector and the values for all histories,
    (m, 12 + n_histories)."""
    found = support.rows(geometry) if is_ours(support) else _own_rows(geometry, support)
    ties, nodes = geometry.ties, np.array([row.node for row in found], dtype=int)
    given = np.array([row.a for row in found]).reshape(-1, 12)
    seen = np.array([not row.own for row in found], dtype=bool)  # with the slopes seen from that node of the mesh
    a = given.copy()
    a[seen] = np.einsum("nkl,nki->nli", ties.mix[nodes[seen]], given[seen].reshape(-1, 4, 3)).reshape(-1, 12)
    numbers = [next(k for k, known in enumerate(histories) if known is history) for history in support.histories]
    values = np.zeros((len(found), len(histories)))
    if found:
        values[:, numbers] = np.array([row.value for row in found]).reshape(len(found), -1)
    sizes = np.linalg.norm(a, axis=1)
    kept = sizes > PARALLEL * np.linalg.norm(given, axis=1)  # a vector that a pole does not have needs no holding
    return ties.node_of[nodes[kept]], np.hstack([a, values])[kept] / sizes[kept, None]


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
    geometry: Geometry, node: int, A: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, int, np.ndarray, np.ndarray | None]:
    """Frame, rank and values of :func:`_frame`, and the coordinates that are held where these need no frame."""
    frame, rank, local = _frame(A, values)
    _check_consistent(geometry, node, A, frame[:rank], local, values)
    axes = np.abs(frame[:rank]).argmax(axis=1)
    plain = np.allclose(np.abs(frame[:rank, axes]), np.eye(rank), atol=PARALLEL)
    return frame, rank, local, axes if plain else None


def _frame(A: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, int, np.ndarray]:
    """An orthonormal frame (12, 12) whose first rows span those of A, their number, and the values along them."""
    axes = np.flatnonzero((np.abs(A) > PARALLEL).any(axis=0))
    if ((np.abs(A) > PARALLEL).sum(axis=1) == 1).all():
        rank = len(axes)
        frame = np.eye(12)[np.concatenate([axes, np.setdiff1d(np.arange(12), axes)])]
    else:
        _, sizes, frame = np.linalg.svd(A)
        rank = int((sizes > PARALLEL * sizes[0]).sum())
    local = np.linalg.lstsq(A @ frame[:rank].T, values, rcond=None)[0]
    return frame, rank, local


def _check_consistent(
    geometry: Geometry, node: int, A: np.ndarray, span: np.ndarray, local: np.ndarray, values: np.ndarray
) -> None:
    error = np.abs(A @ span.T @ local - values).max()
    if error > 1e-9 * max(1e-300, np.abs(values).max()):
        raise InputError(f"supports at the node {tuple(geometry.points[:, node].tolist())} prescribe different values "
                         "for the same coordinate; let one of them go")  # fmt: skip


AXES = np.eye(3)


def rigid_motions(undeformed: np.ndarray, size: float) -> np.ndarray:
    """The six rigid motions about the centre, linear, of nodal coordinates (n_nodes, 4, 3): shape (6, n_dofs).

    Positions count in units of ``size``, so that slopes and positions compare.
    """
    centred = undeformed.copy()
    centred[:, 0] = (undeformed[:, 0] - undeformed[:, 0].mean(axis=0)) / size
    modes = np.zeros((6, *undeformed.shape))
    for i, axis in enumerate(AXES):
        modes[i, :, 0] = axis
        modes[3 + i] = np.cross(axis, centred)
    return modes.reshape(6, -1)


def free_rigid_motions(
    undeformed: np.ndarray, constraints: Constraints, foundation: BlockMatrix | None = None
) -> list[str]:
    """The rigid motions that the constraints, and springs if there are any, leave free, in words."""
    nodal = undeformed.reshape(-1, 4, 3)
    centre = nodal[:, 0].mean(axis=0)
    size = float(np.abs(nodal[:, 0] - centre).max())
    modes = rigid_motions(nodal, size)
    held = np.array([constraints.to_frame(mode)[constraints.fixed.ravel()] for mode in modes])
    if foundation is not None:
        resisting = np.array([foundation @ mode for mode in modes])
        held = np.hstack([held, resisting / np.abs(resisting).max()])
    vectors, sizes, _ = np.linalg.svd(np.hstack([held, np.zeros((6, 6))]), full_matrices=False)
    free = vectors[:, sizes < 1e-9 * max(1.0, sizes[0])].T
    pure = [i for i in range(6) if not held.size or np.abs(held[i]).max() < 1e-9]
    rest = free - free[:, pure] @ np.eye(6)[pure] if pure else free
    _, sizes, rows = np.linalg.svd(rest) if rest.size else (None, np.zeros(0), np.zeros((0, 6)))
    others = rows[: int((sizes > 1e-6).sum())]
    names = [f"translation along {'xyz'[i]}" if i < 3 else f"rotation about {'xyz'[i - 3]}" for i in pure]
    return names + [_motion_in_words(row[:3] * size, row[3:], centre) for row in others]


def _motion_in_words(translation: np.ndarray, rotation: np.ndarray, centre: np.ndarray) -> str:
    """A rigid motion given by the translation of the centre and the rotation about it."""
    def text(v: np.ndarray) -> str:
        return "(" + ", ".join(f"{x + 0.0:.4g}" for x in np.round(v, 12)) + ")"

    turn = np.linalg.norm(rotation)
    if turn * np.linalg.norm(centre) < 1e-9 * np.linalg.norm(translation) or turn < 1e-12:
        return f"translation along {text(translation / np.linalg.norm(translation))}"
    axis = rotation / turn
    point = centre + np.cross(rotation, translation) / turn**2
    slide = "" if abs(axis @ translation) < 1e-9 * np.linalg.norm(translation) else " with a slide along it"
    return f"rotation about the line through {text(point)} along {text(axis)}{slide}"
