"""Conditions of supports on the nodal coordinates, turned into constraints in nodal frames."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.errors import InputError
from skancf.linear import Constraints

PARALLEL = 1e-9


class Motion:
    """Prescribed changes of the coordinates: a sum of vectors, each with its function of time."""

    def __init__(self, n_dofs: int, parts: list[tuple[np.ndarray, Any]]):
        self.n_dofs, self.parts = n_dofs, parts

    def values(self, time: float | None) -> np.ndarray:
        """(n_dofs,); without a time at full amplitude."""
        total = np.zeros(self.n_dofs)
        for change, history in self.parts:
            factor = 1.0 if history is None or time is None else float(history(time))
            if not np.isfinite(factor):
                raise InputError(f"history of a prescribed displacement at t = {time} is {factor}; it must be finite")
            total += factor * change
        return total


def constrain(geometry: Geometry, supports: Sequence[Any]) -> tuple[Constraints, Motion]:
    """Constraints and prescribed motion of all supports together.

    Raises
    ------
    InputError
        Where two supports ask for different values of the same coordinate.
    """
    by_node: dict[int, list[tuple[np.ndarray, float, int]]] = defaultdict(list)
    histories: list[Any] = [None]
    for support in supports:
        history = getattr(support, "history", None)
        if not any(history is known for known in histories):
            histories.append(history)
        number = next(k for k, known in enumerate(histories) if known is history)
        for node, a, value in support.rows(geometry):
            by_node[node].append((a, value, number))
    fixed = np.zeros((geometry.n_nodes, 12), dtype=bool)
    changes = np.zeros((len(histories), geometry.n_nodes, 12))
    frame_nodes, frames = [], []
    for node, rows in by_node.items():
        A = np.array([row[0] for row in rows])
        values = np.zeros((len(rows), len(histories)))
        values[np.arange(len(rows)), [row[2] for row in rows]] = [row[1] for row in rows]
        frame, rank, local = _frame(A, values)
        _check_consistent(geometry, node, A, frame[:rank], local, values)
        axes = np.abs(frame[:rank]).argmax(axis=1)
        if np.allclose(np.abs(frame[:rank, axes]), np.eye(rank), atol=PARALLEL):
            fixed[node, axes] = True
        else:
            fixed[node, :rank] = True
            frame_nodes.append(node)
            frames.append(frame)
        changes[:, node] = (frame[:rank].T @ local).T
    constraints = Constraints(fixed, np.array(frame_nodes, dtype=np.int64), np.array(frames).reshape(-1, 12, 12))
    parts = [(change.ravel(), history) for change, history in zip(changes, histories, strict=True) if change.any()]
    return constraints, Motion(fixed.size, parts)


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


RIGID = ("translation along x", "translation along y", "translation along z",
         "rotation about x", "rotation about y", "rotation about z")  # fmt: skip


def rigid_motions(undeformed: np.ndarray) -> np.ndarray:
    """The six rigid motions about the centre, linear, of nodal coordinates (n_nodes, 4, 3): shape (6, n_dofs)."""
    centred = undeformed.copy()
    centred[:, 0] -= undeformed[:, 0].mean(axis=0)
    size = max(1e-300, float(np.abs(centred[:, 0]).max()))
    modes = np.zeros((6, *undeformed.shape))
    for i, axis in enumerate(np.eye(3)):
        modes[i, :, 0] = axis
        modes[3 + i] = np.cross(axis, centred) / size
    return modes.reshape(6, -1)


def free_rigid_motions(undeformed: np.ndarray, constraints: Constraints) -> list[str]:
    """Names of the rigid motions that the constraints leave free."""
    modes = rigid_motions(undeformed.reshape(-1, 4, 3))
    held = np.array([constraints.to_frame(mode)[constraints.fixed.ravel()] for mode in modes])
    if not held.size:
        return list(RIGID)
    vectors, sizes, _ = np.linalg.svd(held, full_matrices=True)
    sizes = np.concatenate([sizes, np.zeros(6 - len(sizes))])
    free = vectors[:, sizes < 1e-9 * max(1.0, sizes[0])].T
    if not len(free):
        return []
    pure = [name for name, row in zip(RIGID, held, strict=True) if np.abs(row).max() < 1e-9]
    rest = len(free) - len(pure)
    return pure + ([f"{rest} combination(s) of translation and rotation"] if rest else [])
