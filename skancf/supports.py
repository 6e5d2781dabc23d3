"""Supports: which nodal coordinates are held, or moved as prescribed.

A place is the name of a boundary (``"left"``, ``"boundary"`` for all of it, ``"corners"``), a list of names, a point (x,
y) of the parameter plane or a list of them (nodes must be there), or a function of (x, y) that is true at the nodes meant.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.errors import InputError, finite, vector
from skancf.history import History, check_history

R, R_X, R_Y, D = range(4)


class Row(NamedTuple):
    """One condition a . (e - e0) = value on the 12 coordinates e of a node."""

    node: int
    a: np.ndarray
    value: float = 0.0


class Support(Protocol):
    """What a problem knows of a support."""

    where: Any

    def rows(self, geometry: Geometry) -> list[Row]:
        """The conditions on a given mesh."""


def condition(kinds: dict[int, float], direction: np.ndarray) -> np.ndarray:
    """Coefficients (12,) of a combination of nodal vectors, in one direction of space."""
    a = np.zeros((4, 3))
    for kind, factor in kinds.items():
        a[kind] = factor * direction
    return a.ravel()


def edges(geometry: Geometry, where: Any) -> dict[int, list[np.ndarray]]:
    """For each node of a place the directions, in the parameter plane, of its boundary edges there."""
    nodes, facets = geometry.points_and_facets(where)
    out: dict[int, list[np.ndarray]] = {int(n): [] for n in nodes}
    for facet, along in zip(facets, geometry.facet_directions(facets).T, strict=True):
        for node in geometry.mesh.facets[:, facet]:
            if all(abs(np.cross([*along, 0], [*known, 0])[2]) > 1e-8 for known in out[int(node)]):
                out[int(node)].append(along)
    return out


def held_along(geometry: Geometry, where: Any, directions: np.ndarray) -> list[Row]:
    """Positions held in some directions of space, with the slopes along the edges of the place."""
    rows = []
    for node, tangents in edges(geometry, where).items():
        for direction in directions:
            rows.append(Row(node, condition({R: 1.0}, direction)))
            rows += [Row(node, condition({R_X: t[0], R_Y: t[1]}, direction)) for t in tangents]
    return rows


def space_tangent(geometry: Geometry, node: int, along: np.ndarray) -> np.ndarray:
    """Unit vector in space of a direction of the parameter plane at a node."""
    tangent = along @ geometry.undeformed[node, [R_X, R_Y]]
    return tangent / np.linalg.norm(tangent)


def no_tilt_along(geometry: Geometry, where: Any) -> list[Row]:
    """The director does not tilt along the edge."""
    return [
        Row(node, condition({D: 1.0}, space_tangent(geometry, node, along)))
        for node, tangents in edges(geometry, where).items()
        for along in tangents
    ]


def checked_kind(kind: str) -> str:
    if kind not in ("soft", "hard"):
        raise InputError(f"kind = {kind!r}: a simple support is 'soft' (the director is free to tilt along the edge) "
                         "or 'hard' (it is not)")  # fmt: skip
    return kind


@dataclass(frozen=True)
class Pin:
    """Positions held; rotations are free."""

    where: Any

    def rows(self, geometry: Geometry) -> list[Row]:
        return held_along(geometry, self.where, np.eye(3))


@dataclass(frozen=True)
class Clamp:
    """Positions and directors held along an edge; at single points all of the node."""

    where: Any

    def rows(self, geometry: Geometry) -> list[Row]:
        rows = held_along(geometry, self.where, np.eye(3))
        for node, tangents in edges(geometry, self.where).items():
            kinds = [D] if tangents else [R_X, R_Y, D]
            rows += [Row(node, condition({kind: 1.0}, axis)) for kind in kinds for axis in np.eye(3)]
        return rows


@dataclass(frozen=True)
class SimpleSupport:
    """A hinged edge: positions held, rotation about the edge free.

    Parameters
    ----------
    where
        Place.
    kind : {"soft", "hard"}
        ``"hard"`` also keeps the director from tilting along the edge, as a diaphragm does; most series solutions are for
        hard supports. ``"soft"`` leaves it free.
    """

    where: Any
    kind: str = "soft"

    def __post_init__(self) -> None:
        checked_kind(self.kind)

    def rows(self, geometry: Geometry) -> list[Row]:
        rows = held_along(geometry, self.where, np.eye(3))
        return rows + no_tilt_along(geometry, self.where) if self.kind == "hard" else rows


@dataclass(frozen=True)
class Roller:
    """Positions held in one direction of space only (by default z).

    Parameters
    ----------
    where
        Place.
    direction : (3,)
        Direction in which it is held.
    kind : {"soft", "hard"}
        As for :class:`SimpleSupport`.
    """

    where: Any
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    kind: str = "soft"

    def __post_init__(self) -> None:
        checked_kind(self.kind)
        if not np.any(vector("direction", self.direction, 3)):
            raise InputError("direction = (0, 0, 0): a roller needs a direction in which it holds")

    def rows(self, geometry: Geometry) -> list[Row]:
        unit = np.array(self.direction) / np.linalg.norm(self.direction)
        rows = held_along(geometry, self.where, unit[None])
        return rows + no_tilt_along(geometry, self.where) if self.kind == "hard" else rows


@dataclass(frozen=True)
class Symmetry:
    """The edge lies in a plane of symmetry of the undeformed body and stays in it."""

    where: Any

    def rows(self, geometry: Geometry) -> list[Row]:
        rows = []
        for node, tangents in edges(geometry, self.where).items():
            if not tangents:
                raise InputError(f"Symmetry({self.where!r}): a plane of symmetry needs an edge, not a point")
            normal = geometry.undeformed[node, D]
            for along in tangents:
                tangent = space_tangent(geometry, node, along)
                across = np.cross(tangent, normal)
                # The parameter direction whose slope is across the plane in the undeformed state.
                x, y = np.linalg.lstsq(geometry.undeformed[node, [R_X, R_Y]].T, across, rcond=None)[0]
                rows += [Row(node, condition({R: 1.0}, across)), Row(node, condition({D: 1.0}, across))]
                rows.append(Row(node, condition({R_X: along[0], R_Y: along[1]}, across)))
                rows += [Row(node, condition({R_X: x, R_Y: y}, v)) for v in (tangent, normal)]
        return rows


@dataclass(frozen=True)
class Prescribed:
    """Displacement given in some directions of space, free in the others.

    Parameters
    ----------
    where
        Place.
    displacement : three of float or None
        None leaves a direction free.
    history : callable, optional
        Factor as a function of time.
    """

    where: Any
    displacement: tuple[float | None, float | None, float | None]
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        if not isinstance(self.displacement, Sequence) or len(self.displacement) != 3:
            raise InputError(f"displacement = {self.displacement}: give three entries, None where it is free")
        finite("displacement", [u for u in self.displacement if u is not None])

    def rows(self, geometry: Geometry) -> list[Row]:
        rows = []
        for axis, u in zip(np.eye(3), self.displacement, strict=True):
            if u is not None:
                held = held_along(geometry, self.where, axis[None])
                rows += [row._replace(value=u) if np.any(row.a[:3]) else row for row in held]
        return rows
