"""A membrane force or a moment, at a point or as a mean."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from skancf.adaptive.quantities.quantity import Smooth
from skancf.arguments import choice, plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, vector
from skancf.layout.geometry import Geometry
from skancf.recovered import gradient, section_forces
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of
from skancf.system.system import System

COMPONENTS = ("N11", "N22", "N12", "M11", "M22", "M12")

Range = tuple[float, float]


@by_value
@dataclass(frozen=True)
class SectionForce(Smooth):
    r"""A membrane force (N/m) or moment (N) per length in the local frame, at a point or its mean over a region,

    .. math:: \bar N_{11} = \frac{1}{A} \int_A N_{11} \, dA,

    with the undeformed area of the integration points whose parameters lie in a rectangle.

    At a point it is that of one element that holds it: section forces jump from one to the next, by less on finer meshes. In
    theory `full` it is recovered from the elements around, as in :meth:`Solution.recovered_section_forces`.
    For a mean choose a rectangle of whole elements, so that all meshes mean the same region. A point may have no limit where
    a mean has one: see :func:`skancf.adaptive.no_limit`.

    Parameters
    ----------
    component : {"N11", "N22", "N12", "M11", "M22", "M12"}
    at : (2,), optional
        Point of the parameter plane.
    within : ((x0, x1), (y0, y1)), optional
        Rectangle of the parameter plane. A closed parameter may run over its end. Without ``at`` and ``within`` the mean
        over the whole surface.

    Raises
    ------
    InputError
        For an unknown component, for both a point and a rectangle, for an invalid rectangle; with a state, for a point
        outside the surface and for a rectangle that holds no integration point.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> moment = sk.SectionForce("M11", at=(0.5, 0.5))
    >>> print(f"{moment.value(sk.solve_linear(system)):.2f} N")  # 0.0229 p a^2
    -23.74 N
    """

    component: str
    at: tuple[float, float] | None = None
    within: tuple[Range, Range] | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        choice("component", self.component, COMPONENTS)
        if self.at is not None:
            vector("at", self.at, 2)
            if self.within is not None:
                raise InputError(f"at = {self.at} and within = {self.within}: give a point or a rectangle, not both")
        if self.within is not None:
            bounds = finite("within", self.within)
            if bounds.shape != (2, 2) or not (bounds[:, 0] < bounds[:, 1]).all():
                raise InputError(f"within = {self.within}: give a rectangle ((x0, x1), (y0, y1)) with x0 < x1 and y0 < y1")

    @property
    def unit(self) -> str:
        """N/m of a membrane force, N of a moment."""
        return "N/m" if self.component.startswith("N") else "N"

    def _value(self, state: Solution, q: np.ndarray) -> float:
        of_state = state.system.shell.section_forces if self.at is None else partial(section_forces, state.system)
        return sum(
            float(np.vdot(of_state(q, points, state.case, state.linear)[elements, self._row], weights))
            for elements, points, weights in self._of_kinds(state.system)
        )

    def _gradient(self, state: Solution, q: np.ndarray) -> np.ndarray:
        if self.at is not None:
            elements, points, _ = self.weights(state.system)
            case = None if state.linear else state.case
            return gradient(state.system, q, int(elements[0]), points, np.eye(len(COMPONENTS))[self._row], case)
        out, shell = np.zeros(q.shape), state.system.shell
        assembly: Any = shell.assembly if state.linear else shell.at(state.case)
        for elements, points, weights in self._of_kinds(state.system):
            of_all = np.zeros((len(elements), len(COMPONENTS), points.shape[1]))
            of_all[:, self._row] = weights
            out += shell.flat(assembly.section_force_gradient(shell.nodal(q), elements, points, of_all))
        return out

    def scale(self, state: StateLike) -> float:
        """Mean size of the component over the surface: a value that is much smaller is zero at its place."""
        state = solution_of("state", state)
        areas, integration = state.system.assembly.areas, state.system.geometry.integration
        sizes = integration.gathered(lambda points, e: np.abs(state.section_forces(points)[e, self._row]))
        return float(np.vdot(sizes, areas) / areas.sum())

    @property
    def _row(self) -> int:
        return COMPONENTS.index(self.component)

    def weights(self, system: System) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Elements (m,), local points (2, n), or those of each, (m, 2, n), and weights (m, n) that sum to one."""
        geometry = system.geometry
        if self.at is not None:
            element, point = geometry.locate(self.at)
            return np.array([element]), geometry.inside(point[:, None]), np.ones((1, 1))
        points, weights = geometry.integration.local, system.assembly.areas
        if self.within is not None:
            weights = weights * self._inside(geometry, geometry.parameters(points))
        elements = np.flatnonzero(weights.any(axis=1))
        if not elements.size:
            raise InputError(f"within = {self.within}: no integration point of the mesh lies there, which spans "
                             f"{geometry.mesh.p.min(axis=1).tolist()} to {geometry.mesh.p.max(axis=1).tolist()}; give a "
                             "rectangle of at least one element")  # fmt: skip
        return elements, points if points.ndim == 2 else points[elements], weights[elements] / weights.sum()

    def _of_kinds(self, system: System) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """:meth:`weights` of elements that have the same points."""
        elements, points, weights = self.weights(system)
        if points.ndim == 2:
            yield elements, points, weights
            return
        kinds = system.geometry.integration.kinds[elements]
        for kind in np.unique(kinds):
            yield elements[kinds == kind], system.geometry.integration.points[kind], weights[kinds == kind]

    def _inside(self, geometry: Geometry, at: np.ndarray) -> np.ndarray:
        """Which parameters (2, ...) lie in the rectangle."""
        out = np.ones(at.shape[1:], bool)
        closed = geometry.closed_bounds()
        for axis, (low, high) in enumerate(finite("within", self.within)):
            past = at[axis] - low
            if axis in closed:
                past = past % (closed[axis][1] - closed[axis][0])
            out &= (past >= 0) & (past <= high - low)
        return out
