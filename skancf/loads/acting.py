"""What a load is on a mesh, and the ways that forces get to the nodes."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from skancf import functions
from skancf.errors import vector
from skancf.history import History, amplitude, check_history
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity
from skancf.terms.protocols import Assembly


class Acting:
    """A load on a given mesh; a kind of load overrides what it has. See :class:`skancf.terms.protocols.Loading`."""

    history: History | None = None

    def histories(self) -> list[Any]:
        return [self.history]

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        return np.zeros_like(q)

    def add_stiffness(
        self, q: np.ndarray, time: float | None, factor: float, slots: np.ndarray, out: np.ndarray
    ) -> None:
        """A load that does not follow the motion has none."""

    def skew(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, np.ndarray] | None:
        return None

    def initial_stresses(self, time: float | None) -> np.ndarray | None:
        return None

    def temperature(self, points: np.ndarray, time: float | None) -> np.ndarray | None:
        return None

    def couple(self, time: float | None) -> np.ndarray | None:
        return None

    def edge_moments(self, facets: np.ndarray, at: np.ndarray, time: float | None) -> np.ndarray | None:
        return None

    def singularities(self, time: float | None) -> list[Singularity]:
        return []

    def places(self, time: float | None) -> np.ndarray:
        return np.hstack([np.empty((2, 0)), *[each.alone for each in self.singularities(time) if each.at_rest]])

    def impulse(self, q: np.ndarray) -> tuple[float, np.ndarray] | None:
        return None

    def weight(self) -> np.ndarray | None:
        return None


class DeadLoad(Acting):
    """A force (n_nodes, 4, 3) that does not depend on the configuration; spread over points (2, n) if it is at some only."""

    def __init__(
        self, nodal: np.ndarray, history: History | None, at: np.ndarray | None = None, singular: Sequence[Singularity] = ()
    ):
        self.nodal, self.history, self.at, self.singular = nodal, history, at, singular

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        return np.asarray(amplitude(self.history, time) * self.nodal)

    def singularities(self, time: float | None) -> list[Singularity]:
        return list(self.singular)

    def places(self, time: float | None) -> np.ndarray:
        return super().places(time) if self.at is None else self.at


class Load(Protocol):
    """What a problem knows of a load."""

    def on(self, assembly: Assembly) -> Any:
        """The load on a given mesh: see :class:`skancf.terms.protocols.Loading`."""


class Spread(NamedTuple):
    """Forces at points of elements: elements (m,), local points (m, 2, n), forces on r and r_z (m, 2, 3, n)."""

    elements: np.ndarray
    points: np.ndarray
    forces: np.ndarray

    def nodal(self, geometry: Geometry) -> np.ndarray:
        """Nodal forces (n_nodes, 4, 3) that do the same work."""
        local = np.empty((len(self.elements), 16, 3))
        same = len(self.points) > 1 and (self.points == self.points[0]).all()
        table = geometry.theory.position_table(self.points[0]) if same else None
        for k, points in enumerate(self.points):
            values = geometry.theory.position_table(points) if table is None else table
            local[k] = np.einsum("vap,vip->ai", values, self.forces[k, : len(values)])
        return geometry.nodal(local, self.elements)


def check_distributed(force: Any, history: Any) -> None:
    """InputError for a force that is neither three numbers nor a function, or a history that is no function."""
    check_history(history)
    if not functions.is_function(force):
        vector("force", force, 3)


def values_at(given: Any, at: np.ndarray, name: str = "force") -> np.ndarray:
    """A constant or a function at (2, n_elements, n): (n_elements, 3, n)."""
    return np.moveaxis(functions.values_at(name, given, at, 3), 0, 1)


def over_elements(geometry: Geometry, forces: np.ndarray) -> np.ndarray:
    """Nodal forces of forces (n_elements, 1 or 2, 3, n_points) at the integration points."""
    table = geometry.theory.position_table(geometry.theory.quadrature[0])
    local = np.einsum("vap,evip->eai", table, forces[:, : len(table)], optimize=True)
    return geometry.nodal(local, np.arange(geometry.n_elements))


def point_forces(geometry: Geometry, elements: Any, local: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Nodal forces of forces (m, 3) at local points (m, 2) of elements (m,)."""
    on_both = np.stack([forces, np.zeros_like(forces)], axis=1)[..., None]
    return Spread(np.asarray(elements), local[:, :, None], on_both).nodal(geometry)
