"""Loads: forces on the mid-surface and moments on its edges, each with an optional function of time.

Statics takes every load at its full amplitude times the load factor; dynamics multiplies it by ``history(t)``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple, Protocol

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.assembly.sections import Sections
from skancf.errors import InputError, finite, positive, vector
from skancf.history import History, amplitude, check_history
from skancf.supports import D
from skancf.theories.full import position_table


def check_distributed(force: Any, history: Any) -> None:
    """InputError for a force that is neither three numbers nor a function, or a history that is no function."""
    check_history(history)
    if not callable(force):
        vector("force", force, 3)


class Spread(NamedTuple):
    """Forces at points of elements: elements (m,), local points (m, 2, n), forces on r and d (m, 2, 3, n)."""

    elements: np.ndarray
    points: np.ndarray
    forces: np.ndarray

    def nodal(self, geometry: Geometry) -> np.ndarray:
        """Nodal forces (n_nodes, 4, 3) that do the same work."""
        local = np.empty((len(self.elements), 16, 3))
        same = len(self.points) > 1 and (self.points == self.points[0]).all()
        table = position_table(self.points[0]) if same else None
        for k, points in enumerate(self.points):
            local[k] = np.einsum("vap,vip->ai", position_table(points) if table is None else table, self.forces[k])
        return geometry.nodal(local, self.elements)


class DeadLoad:
    """A force that does not depend on the configuration."""

    def __init__(self, nodal: np.ndarray, history: History | None):
        self.nodal, self.history = nodal, history

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        return amplitude(self.history, time) * self.nodal

    def stiffness(self, q: np.ndarray, time: float | None) -> None:
        return None


class Load(Protocol):
    """What a problem knows of a load."""

    def on(self, geometry: Geometry, sections: Sections) -> Any:
        """The load on a given mesh: see :class:`skancf.assembly.system.Loading`."""


@dataclass(frozen=True)
class PointForce:
    """A force (N) at a point of the parameter plane.

    In theory `full` the deflection under it has no limit as the mesh is refined: it grows with the logarithm of the
    element size. :class:`DiskForce` has a limit.
    """

    at: tuple[float, float]
    force: tuple[float, float, float]
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        vector("at", self.at, 2)
        vector("force", self.force, 3)

    def on(self, geometry: Geometry, sections: Sections) -> DeadLoad:
        element, local = geometry.locate(self.at)
        return DeadLoad(point_forces(geometry, [element], local[None], np.array([self.force])), self.history)


def point_forces(geometry: Geometry, elements: Any, local: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Nodal forces of forces (m, 3) at local points (m, 2) of elements (m,)."""
    on_both = np.stack([forces, np.zeros_like(forces)], axis=1)[..., None]
    return Spread(np.asarray(elements), local[:, :, None], on_both).nodal(geometry)


@dataclass(frozen=True)
class DiskForce:
    """A force (N) spread evenly over a small disk of the mid-surface.

    Parameters
    ----------
    at : (2,)
        Centre in the parameter plane.
    radius : float
        In space (m).
    force : (3,)
        The whole force.
    """

    at: tuple[float, float]
    radius: float
    force: tuple[float, float, float]
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        vector("at", self.at, 2)
        positive("radius", self.radius, "m")
        vector("force", self.force, 3)

    def on(self, geometry: Geometry, sections: Sections) -> DeadLoad:
        # Rings of equal area about the centre; 16 x 48 points follow a disk that covers several elements.
        n_rings, n_angles = 16, 48
        radii = self.radius * np.sqrt((np.arange(n_rings) + 0.5) / n_rings)
        angles = 2 * pi * (np.arange(n_angles) + 0.5) / n_angles
        offsets = np.stack([np.outer(radii, f(angles)).ravel() for f in (np.cos, np.sin)])
        slopes = np.stack(geometry.surface.derivatives(*np.asarray(self.at, float)), axis=1)
        triangle = np.linalg.qr(slopes)[1]
        points = np.asarray(self.at, float)[:, None] + np.linalg.solve(triangle, offsets)
        try:
            located = [geometry.locate(point) for point in points.T]
        except InputError as outside:
            raise InputError(f"disk at {tuple(self.at)} of radius {self.radius} m reaches over the edge of the surface; "
                             "make it smaller or move it") from outside  # fmt: skip
        forces = np.tile(np.asarray(self.force, float) / len(located), (len(located), 1))
        elements, local = zip(*located, strict=True)
        return DeadLoad(point_forces(geometry, list(elements), np.array(local), forces), self.history)


@dataclass(frozen=True)
class SurfaceLoad:
    """A dead force per undeformed area (Pa).

    Parameters
    ----------
    force : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).
    """

    force: Any
    history: History | None = None

    def __post_init__(self) -> None:
        check_distributed(self.force, self.history)

    def on(self, geometry: Geometry, sections: Sections) -> DeadLoad:
        points = geometry.theory.quadrature[0]
        forces = np.zeros((geometry.n_elements, 2, 3, points.shape[1]))
        forces[:, 0] = _values(self.force, geometry.parameters(points)) * sections.areas[sections.shape][:, None]
        return DeadLoad(_over_elements(geometry, forces), self.history)


def _values(force: Any, at: np.ndarray) -> np.ndarray:
    """A constant or a function at (2, n_elements, n): (n_elements, 3, n)."""
    value = finite("force", force(*at) if callable(force) else force)
    if value.shape[:1] != (3,):
        raise InputError(f"force of shape {value.shape}: a function of (x, y) must return three components first, (3, ...)")
    value = value.reshape(3, 1, 1) if value.ndim == 1 else value
    try:
        return np.moveaxis(np.broadcast_to(value, (3, *at.shape[1:])), 0, 1)
    except ValueError as wrong:
        raise InputError(f"force of shape {value.shape}: a function of (x, y) must return {(3, *at.shape[1:])}") from wrong


def _over_elements(geometry: Geometry, forces: np.ndarray) -> np.ndarray:
    points = geometry.theory.quadrature[0]
    local = np.einsum("vap,evip->eai", position_table(points), forces, optimize=True)
    return geometry.nodal(local, np.arange(geometry.n_elements))


@dataclass(frozen=True)
class Gravity:
    """Dead weight of the whole body under an acceleration (m/s2)."""

    acceleration: tuple[float, float, float] = (0.0, 0.0, -9.80665)
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        vector("acceleration", self.acceleration, 3)

    def on(self, geometry: Geometry, sections: Sections) -> DeadLoad:
        moments = sections.moments[sections.shape][:, :2]
        forces = np.einsum("evp,i->evip", moments, np.asarray(self.acceleration, float))
        return DeadLoad(_over_elements(geometry, forces), self.history)


@dataclass(frozen=True)
class EdgeLoad:
    """A dead force per undeformed length (N/m) along boundary edges."""

    where: Any
    force: Any
    history: History | None = None

    def __post_init__(self) -> None:
        check_distributed(self.force, self.history)

    def on(self, geometry: Geometry, sections: Sections) -> DeadLoad:
        elements, points, lengths = geometry.edge_quadrature(geometry.facets_on(self.where))
        forces = np.zeros((len(elements), 2, 3, lengths.shape[1]))
        at = np.stack([geometry.parameters(p, np.array([e]))[:, 0] for e, p in zip(elements, points, strict=True)], 1)
        forces[:, 0] = _values(self.force, at) * lengths[:, None]
        return DeadLoad(Spread(elements, points, forces).nodal(geometry), self.history)


@dataclass(frozen=True)
class EdgeMoment:
    r"""A moment per undeformed length (N) on boundary edges that turns the director, whatever way it already points.

    Its virtual work is :math:`m \cdot (d \times \delta d) / d \cdot d`, summed over the nodes of the edge.
    """

    where: Any
    moment: tuple[float, float, float]
    history: History | None = None

    def __post_init__(self) -> None:
        check_history(self.history)
        vector("moment", self.moment, 3)

    def on(self, geometry: Geometry, sections: Sections) -> "MomentOnDirectors":
        facets = geometry.facets_on(self.where)
        _, _, lengths = geometry.edge_quadrature(facets)
        nodes, position = np.unique(geometry.mesh.facets[:, facets], return_inverse=True)
        shares = np.bincount(position.ravel(), np.tile(lengths.sum(axis=1) / 2, 2))
        return MomentOnDirectors(nodes, np.outer(shares, self.moment), self.history)


class MomentOnDirectors:
    """Moments (m, 3) on the directors of nodes (m,)."""

    def __init__(self, nodes: np.ndarray, moments: np.ndarray, history: Callable[[float], float] | None):
        self.nodes, self.moments, self.history = nodes, moments, history

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        out, d = np.zeros_like(q), q[self.nodes, D]
        out[self.nodes, D] = np.cross(self.moments, d) / (d * d).sum(axis=1, keepdims=True)
        return amplitude(self.history, time) * out

    def stiffness(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, np.ndarray]:
        """The symmetric part of minus the force's derivative, exact for motions in a plane."""
        d, m = q[self.nodes, D], amplitude(self.history, time) * self.moments
        square = (d * d).sum(axis=1)[:, None, None]
        turn = 2 * np.einsum("ni,nj->nij", np.cross(m, d), d) / square**2
        blocks = np.zeros((len(self.nodes), 12, 12))
        blocks[:, 9:, 9:] = (turn + turn.transpose(0, 2, 1)) / 2
        return self.nodes, blocks
