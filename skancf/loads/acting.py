"""What a load is on a mesh, and the ways that forces get to the nodes."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from skancf import functions
from skancf.errors import vector
from skancf.history import Case, History, check_history
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, places_of
from skancf.showing import short
from skancf.terms.blocks import OnElements
from skancf.terms.protocols import Assembly


class Acting:
    """A load on a given mesh; a kind of load overrides what it has. ``q`` has the shape (n_nodes, 4, 3).

    Examples
    --------
    >>> from skancf.loads.acting import Acting
    >>> class Lift(Acting):
    ...     follows = False
    ...     def __init__(self, nodal):
    ...         self.nodal = nodal
    ...     def force(self, q, case):
    ...         return case.amplitude(self.history) * self.nodal
    >>> Lift(np.zeros((4, 4, 3))).force(np.zeros((4, 4, 3)), sk.Case()).shape
    (4, 4, 3)
    """

    history: History | None = None
    follows: bool = True
    """Whether its force depends on the configuration."""

    def histories(self) -> list[Any]:
        """Its functions of time, among them None for one that is constant."""
        return [self.history]

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        """External force (n_nodes, 4, 3) in the configuration q, with the factor ``case.amplitude(self.history)``."""
        return np.zeros_like(q)

    def add_stiffness(self, q: np.ndarray, case: Case, blocks: OnElements) -> None:
        """Add minus the derivative of the force, by ``blocks.add(elements, matrices)``. Default: zero, the force is dead."""

    def initial_stresses(self, case: Case) -> np.ndarray | None:
        """Stresses (n_elements, n_strains, n_points) that suppress a free strain; None without any."""
        return None

    def temperature(self, points: np.ndarray, case: Case) -> np.ndarray | None:
        """Temperature change T0 and T1 at local points (2, n) of every element, (2, n_elements, n); None without one."""
        return None

    def couple(self, case: Case, points: np.ndarray, elements: np.ndarray) -> np.ndarray | None:
        """Dead force per area times the height above the surface where it acts (N/m), (3,), or at local points (2, n) of
        elements (m,), (3, m, n); None where it acts on the surface."""
        return None

    def edge_moments(self, facets: np.ndarray, at: np.ndarray, case: Case) -> np.ndarray | None:
        """Moments per length that it applies along boundary facets (m,), at their points (2, m, n) of the parameter plane:
        (3, m, n); None without any."""
        return None

    def singularities(self, case: Case) -> list[Singularity]:
        """What it does that is not smooth; of a force at a point its force. Default: nothing."""
        return []

    def places(self, case: Case) -> np.ndarray:
        """Points (2, n) of the parameter plane at which it acts, if it is at some only; else (2, 0). Default: the single
        points of its singularities."""
        return places_of(self.singularities(case))

    def impulse(self, q: np.ndarray) -> tuple[float, np.ndarray] | None:
        """A time (s) and the impulse (n_nodes, 4, 3) that acts then; None of what acts all the time."""
        return None

    def weight(self) -> np.ndarray | None:
        """Nodal forces (n_nodes, 4, 3) of a weight that changes with neither time nor configuration; None of any other."""
        return None


class DeadLoad(Acting):
    """A force (n_nodes, 4, 3) that does not depend on the configuration; spread over points (2, n) if it is at some only.

    Its singularities may be a function that finds them when they are asked for.
    """

    follows = False

    def __init__(
        self, nodal: np.ndarray, history: History | None, at: np.ndarray | None = None,
        singular: Sequence[Singularity] | Callable[[], Sequence[Singularity]] = (),
    ):  # fmt: skip
        self.nodal, self.history, self.at, self.singular = nodal, history, at, singular

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        return np.asarray(case.amplitude(self.history) * self.nodal)

    def singularities(self, case: Case) -> list[Singularity]:
        return list(self.singular() if callable(self.singular) else self.singular)

    def places(self, case: Case) -> np.ndarray:
        return super().places(case) if self.at is None else self.at


class Load(Protocol):
    """What a problem knows of a load.

    Examples
    --------
    >>> class Pair:
    ...     def on(self, assembly):
    ...         return sk.EdgeLoad(["left", "right"], (0.0, 0.0, -10.0)).on(assembly)
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Pin("corners")], loads=[Pair()])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 4), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.2f} N")
    20.00 N
    """

    def on(self, assembly: Assembly) -> Any:
        """The load on a given mesh, an :class:`Acting`."""


class Spread(NamedTuple):
    """Forces at points of elements: elements (m,), local points (m, 2, n), forces on r and r_z (m, 2, 3, n)."""

    elements: np.ndarray
    points: np.ndarray
    forces: np.ndarray

    def __repr__(self) -> str:
        return short(self)

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

    def local(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
        table = geometry.theory.position_table(points)
        return np.einsum("vap,evip->eai", table, forces[elements, : len(table)], optimize=True)

    return geometry.nodal(geometry.integration.gathered(local), np.arange(geometry.n_elements))


def at_points(elements: Any, local: np.ndarray, forces: np.ndarray) -> Spread:
    """Forces (m, 3) at local points (m, 2) of elements (m,)."""
    on_both = np.stack([forces, np.zeros_like(forces)], axis=1)[..., None]
    return Spread(np.asarray(elements), local[:, :, None], on_both)
