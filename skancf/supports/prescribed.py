"""Displacements and rotations that are given, as numbers or as functions of place."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts2, chebvander

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, shown, vector
from skancf.functions import is_function, values_at
from skancf.history import History, check_history
from skancf.kernels.constants import R_X, R_Y, R
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, at_place
from skancf.showing import short
from skancf.supports.alone import edges_or_points
from skancf.supports.conditions import Edges, SpotOfMesh, Support, single_points
from skancf.surfaces import normal
from skancf.theories.rows import Row, condition
from skancf.tolerances import ROUNDED_VALUE

N_EDGE = 9
"""Points on an edge at which functions are differentiated: exact to degree eight."""


@by_value
@dataclass(frozen=True)
class Prescribed(Support):
    r"""Displacement given in some directions of space, free in the others, and the rotation of the normal if it is given.

    Along an edge the slopes follow: :math:`u_{,s}` is the derivative of the given function along it, exact for polynomials
    of degree eight on each element. Where a function has a kink at a node, the slope there is the mean of both sides.

    With the rotation :math:`\theta` (rad) the normal or director moves by :math:`\theta \times n`, as for small ones. On
    the thin element, where the rest follows from the displacements, it is that about the edge,

    .. math:: n \cdot u_{,x} = n \cdot (\theta \times X_{,x})

    and its derivative along the edge, with x across it; at points it is that about both tangents. In theory `full` it is
    that of :math:`r_{,z}`, whose length stays free. Without it rotations are free where the displacement leaves them so.

    Parameters
    ----------
    where
        Place.
    displacement : three of float, None or callable, or callable
        None leaves a direction free; a function of the parameters (x, y) gives one component, or three of them, of which
        those that are None are free.
    history : callable, optional
        Factor as a function of time, in dynamics; statics takes the values as they are given, times the load factor.
    rotation : (3,) or callable, optional
        :math:`\theta` about the axes of space, a constant or a function of (x, y) that returns (3, ...).

    Raises
    ------
    InputError
        For other entries than these, and where neither a displacement nor a rotation is given; on a mesh, for values of a
        function that are not finite or of another shape.

    Examples
    --------
    A plate bent to :math:`w = x^2 - y^2` by its edges:

    >>> edge = sk.Prescribed("boundary", lambda x, y: (None, None, x**2 - y**2), rotation=lambda x, y: (-2 * y, -2 * x, 0))
    """

    where: Any
    displacement: Any = (None, None, None)
    history: History | None = None
    rotation: Any = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        if self.rotation is not None and not is_function(self.rotation):
            vector("rotation", self.rotation, 3)
        if is_function(self.displacement):
            return
        if not _three(self.displacement):
            raise InputError(f"displacement = {shown(self.displacement)}: give three entries, None where it is free, or a "
                             "function of (x, y)")  # fmt: skip
        finite("displacement", [u for u in self.displacement if u is not None and not is_function(u)])
        if self.rotation is None and all(u is None for u in self.displacement):
            raise InputError("displacement = (None, None, None): nothing is prescribed; give a component or a rotation")

    def rows(self, geometry: Geometry) -> list[Row]:
        place = edges_or_points("Prescribed", geometry, self.where)
        fields = Fields(geometry, self.where, place)
        rows = []
        for axis, u in zip(np.eye(3), self.components(geometry), strict=True):
            if u is not None:
                rows += fields.rows(place, axis, lambda at, u=u: values_at("displacement", u, at))
        return rows if self.rotation is None else rows + self._rotated(geometry, place, fields)

    def singularities(self, geometry: Geometry) -> list[Singularity]:
        given = [u is not None for u in self.components(geometry)]
        kinds = ("position",) * all(given) or ("part",) * any(given)
        return at_place(geometry, self.where, kinds + ("normal",) * (self.rotation is not None), "a Prescribed")

    def components(self, geometry: Geometry) -> list[Any]:
        """A number or a function of (x, y) for each direction, None where it is free."""
        whole = self.displacement
        if not is_function(whole):
            return list(whole)
        try:
            first = whole(*geometry.mesh.p[:, 0].tolist())
        except Exception:  # it may need arrays; what else is wrong with it is told where it is evaluated
            first = (0.0, 0.0, 0.0)
        if not _three(first):
            raise InputError(f"displacement returns {shown(first)}: a function of (x, y) must return three components, None "
                             "where it is free; give three entries if each has a function of its own")  # fmt: skip
        free = [u is None for u in first]

        def component(k: int) -> Any:
            def values(*at: Any) -> Any:
                found = whole(*at)
                return found[k]

            return values

        if all(free) and self.rotation is None:
            raise InputError("displacement returns (None, None, None): nothing is prescribed; give a component")
        return [None if free[k] else component(k) for k in range(3)]

    def _rotated(self, geometry: Geometry, place: Edges, fields: "Fields") -> list[Row]:
        def rotation(at: np.ndarray) -> np.ndarray:
            return values_at("rotation", self.rotation, at, 3)

        theory = geometry.theory

        def turn_of(kind: int) -> Any:
            def values(at: np.ndarray) -> np.ndarray:
                slopes = geometry.surface.derivatives(*at)
                return theory.turn_of(kind, rotation(at), normal(geometry.surface, *at), slopes)

            return values

        found = {kind: fields.nodal(turn_of(kind)) for kind in theory.turns}
        rates = {kind: fields.slopes(turn_of(kind)) for kind in theory.turns} if theory.continuity else {}
        nodes = [(node, directions) for node, directions in place.items() if directions]
        nodes += [(node, []) for node in single_points(geometry, place)]
        rows = []
        for node, directions in nodes:
            here = {kind: values[..., node] for kind, values in found.items()}
            along = {kind: slopes[node] for kind, slopes in rates.items()}
            turn = np.zeros(3) if directions else rotation(geometry.mesh.p[:, [node]])[:, 0]
            rows += theory.turned(SpotOfMesh(geometry, node), directions, turn, here, along)
        return rows


def _three(value: Any) -> bool:
    """Whether it has three entries in an order."""
    if isinstance(value, np.ndarray):
        return value.shape[:1] == (3,)
    return isinstance(value, Sequence) and not isinstance(value, str | bytes | bytearray) and len(value) == 3


class Fields:
    """Functions of place at the nodes of a place, and their derivatives along its edges."""

    def __init__(self, geometry: Geometry, where: Any, place: Edges):
        self.geometry, self.place = geometry, place
        self.ends = geometry.mesh.facets[:, geometry.points_and_facets(where)[1]]
        start, end = geometry.mesh.p[:, self.ends].swapaxes(0, 1)
        points = chebpts2(N_EDGE)
        self.at = start[:, :, None] + (end - start)[:, :, None] * (1 + points) / 2
        self.at[:, :, -1] = end
        to_coefficients = np.linalg.inv(chebvander(points, N_EDGE - 1))
        derivative = chebvander(np.array([-1.0, 1.0]), N_EDGE - 2) @ chebder(to_coefficients)
        self.along = end - start
        self.weights = derivative * 2  # by the part of the edge, 0 to 1

    def nodal(self, function: Any) -> np.ndarray:
        """Values at the nodes of the place, (..., n_mesh_nodes); zero elsewhere."""
        nodes = np.array(list(self.place), dtype=int)
        found = _without_noise(np.asarray(function(self.geometry.mesh.p[:, nodes])), 0.0)
        out = np.zeros((*found.shape[:-1], self.geometry.mesh.p.shape[1]))
        out[..., nodes] = found
        return out

    def slopes(self, function: Any) -> dict[int, list[float]]:
        """For each node of the place the derivatives along its directions, in the parameter plane."""
        if not self.ends.size:
            return {node: [] for node in self.place}
        values = np.asarray(function(self.at))
        found = _without_noise(values @ self.weights.T, float(np.abs(values).max()))
        sizes = np.linalg.norm(self.along, axis=0)
        units, found = self.along / sizes, found / sizes[:, None]
        of_node: dict[tuple[Any, ...], list[float]] = {}
        for k, pair in enumerate(self.ends.T.tolist()):
            for end, node in enumerate(pair):
                key, sign = self._line(node, units[:, k])
                of_node.setdefault(key, []).append(sign * float(found[k, end]))
        out: dict[int, list[float]] = {}
        for node, directions in self.place.items():
            lines = [self._line(node, along) for along in directions]
            out[node] = [sign * float(np.mean(of_node[key])) for key, sign in lines]
        return out

    def _line(self, node: int, along: np.ndarray) -> tuple[tuple[Any, ...], float]:
        """A line through a node, the same from both sides of a seam, and the sign of a direction along it."""
        own = int(self.geometry.ties.node_of[node])
        seen = (own, -1) if own >= 0 and own not in self.geometry.ties.poles else (own, node)
        x, y = np.round(self.geometry.in_extents(along), 6).tolist()
        sign = 1.0 if (x, y) > (0.0, 0.0) else -1.0
        return (*seen, sign * x + 0.0, sign * y + 0.0), sign

    def rows(self, place: Edges, direction: np.ndarray, function: Any) -> list[Row]:
        """Positions moved in a direction of space as a function says, with the slopes along the edges of the place."""
        values, slopes = self.nodal(function), self.slopes(function)
        rows = []
        for node, tangents in place.items():
            rows.append(Row(node, condition({R: 1.0}, direction), float(values[node])))
            rows += [
                Row(node, condition({R_X: t[0], R_Y: t[1]}, direction), slope)
                for t, slope in zip(tangents, slopes[node], strict=True)
            ]
        return rows


def _without_noise(values: np.ndarray, scale: float) -> np.ndarray:
    """Rounding of what is zero would contradict that of the same place seen from elsewhere, as on a seam."""
    size = max(scale, float(np.abs(values).max(initial=0.0)))
    return np.where(np.abs(values) < ROUNDED_VALUE * size, 0.0, values)
