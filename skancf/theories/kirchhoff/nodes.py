r"""Nodes of the bicubic Hermite element: r, r_x, r_y and r_xy, of a surface whose normals are those of its slopes.

In the middle of an edge along t and across n the pairs :math:`r, r_{,t}` and :math:`r_{,n}, r_{,nt}` are cubics
(:mod:`skancf.theories.edges`): the field is C1 across the edge, and what larger elements can be, smaller ones can.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from skancf.kernels.constants import CORNERS, FOURTH, FUNCTIONS, R_X, R_Y, VECTORS, R
from skancf.surfaces import Surface
from skancf.theories.edges import no_weights, set_cubic
from skancf.theories.rows import Row, Spot, across, condition
from skancf.tolerances import ONE_DIRECTION
from skancf.vectors import cross


class HermiteNodes:
    """What of :class:`skancf.theories.theory.Theory` the nodes of the bicubic element rule."""

    nodal_vectors = ("r", "r_x", "r_y", "r_xy")
    continuity = 1
    directors = False
    turns = (R_X, R_Y)
    of_positions = (True, True, True, True)

    @cached_property
    def rows(self) -> np.ndarray:
        """Local function of each corner and nodal vector, (4, 4)."""
        return np.arange(FUNCTIONS).reshape(CORNERS, VECTORS)

    def fourth(self, surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """X_xy, (3, n)."""
        return surface.second_derivatives(x, y)[1]

    def fourth_factor(self, jacobian: np.ndarray) -> np.ndarray:
        """Of the derivative by both of other parameters, along which (2, 2, ...) parameters change: (...)."""
        return np.asarray(jacobian[0, 0] * jacobian[1, 1] + jacobian[0, 1] * jacobian[1, 0])

    def fourth_at_pole(self, on_tangents: np.ndarray) -> np.ndarray:
        """A pole has no r_xy: that of a node there is made of the pole's tangents, as it is in the undeformed state."""
        out = np.zeros((len(on_tangents), VECTORS))
        out[:, R_X : R_Y + 1] = on_tangents
        return out

    def hanging_weights(self, way: np.ndarray, along_x: np.ndarray) -> np.ndarray:
        """Of nodes in the middle of edges of signed lengths (m,) along x or y: (2, m, 4, 4)."""
        t, n, m = np.where(along_x, R_X, R_Y), np.where(along_x, R_Y, R_X), len(way)
        out = no_weights(m)
        set_cubic(out, way, np.full(m, R), t)
        set_cubic(out, way, n, np.full(m, FOURTH))
        return out

    def no_tilt(self, spot: Spot, along: np.ndarray) -> list[Row]:
        """The normal does not tilt along an edge, as the edge itself does not."""
        return [Row(spot.node, condition({R_X: along[0], R_Y: along[1]}, spot.normal))]

    def no_turn(self, spot: Spot, edges: Sequence[np.ndarray]) -> list[Row]:
        r"""The slope across an edge stays in the tangent plane, :math:`n \cdot r_{,x} = 0` all along it: the stretch of the
        surface at the edge is free. Its derivative along the edge is :math:`n \cdot r_{,xy} + n_{,y} \cdot r_{,x} = 0`. At a
        point :math:`n \cdot r_{,x} = n \cdot r_{,y} = 0`."""
        n = spot.normal
        if not edges:
            return [Row(spot.node, condition({kind: 1.0}, n), own=spot.own) for kind in self.turns]
        rows = []
        for along in edges:
            kind = across(along)
            rows += [Row(spot.node, condition({kind: 1.0}, n)), Row(spot.node, _along_edge(spot, n, kind))]
        return rows

    def symmetric(self, spot: Spot, along: np.ndarray) -> list[Row] | None:
        """The slope across the edge stays normal to the plane all along it."""
        tangent, normal, kind = spot.tangent(along), spot.normal, across(along)
        slope = spot.slopes[kind - 1]
        if np.linalg.norm(cross(slope, cross(tangent, normal))) > ONE_DIRECTION * np.linalg.norm(slope):
            return None
        return [Row(spot.node, condition({k: 1.0}, v)) for k in (kind, FOURTH) for v in (tangent, normal)]

    def turn_of(self, kind: int, rotation: np.ndarray, normal: np.ndarray, slopes: Sequence[np.ndarray]) -> np.ndarray:
        """Change along the normal that a small rotation (3, n) makes of the slope r_x or r_y, (n,)."""
        return np.asarray((cross(rotation, slopes[kind - 1]) * normal).sum(axis=0))

    def following(self, nodal: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """All are those of positions."""
        return rates

    def turned(
        self, spot: Spot, edges: Sequence[np.ndarray], rotation: np.ndarray, values: dict[int, np.ndarray],
        rates: dict[int, list[float]],
    ) -> list[Row]:  # fmt: skip
        """As :meth:`no_turn`, turned by a rotation."""
        n, node = spot.normal, spot.node
        if not edges:
            return [
                Row(node, condition({kind: 1.0}, n), float(n @ np.cross(rotation, spot.vectors[kind - 1])), spot.own)
                for kind in self.turns
            ]
        rows = []
        for k, along in enumerate(edges):
            kind = across(along)
            sign = along[2 - kind]  # the derivative by the parameter itself
            rows.append(Row(node, condition({kind: 1.0}, n), float(values[kind])))
            rows.append(Row(node, _along_edge(spot, n, kind), rates[kind][k] / sign))
        return rows


def _along_edge(spot: Spot, n: np.ndarray, kind: int) -> np.ndarray:
    """Coefficients (12,) of the derivative along the edge of n . r_,x, x across it."""
    return condition({FOURTH: 1.0, kind: spot.normal_slopes[kind - 1 ^ 1]}, n)
