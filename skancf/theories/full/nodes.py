"""Nodes with a director: r, r_x, r_y and r_z.

In the middle of an edge r and the slope along it are a cubic (:mod:`skancf.theories.edges`); r_z and the slope across the
edge are the means of the ends'. For r_z, which is linear along an edge, nothing is lost by that; the slope across the edge
of the larger element is a cubic that depends on all its nodes, and only its linear part is kept.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from skancf.kernels.constants import AXES, CORNERS, FOURTH, FUNCTIONS, R_X, R_Y, VECTORS, R
from skancf.surfaces import Surface, normal
from skancf.theories.edges import no_weights, set_cubic, set_mean
from skancf.theories.rows import Row, Spot, condition
from skancf.vectors import cross

N_POSITION = CORNERS * FOURTH
"""Local functions of r; the others are those of the director."""


class DirectorNodes:
    """What of :class:`skancf.theories.theory.Theory` such nodes rule."""

    nodal_vectors = ("r", "r_x", "r_y", "r_z")
    continuity = 0
    directors = True
    turns = (FOURTH,)
    of_positions = (True, True, True, False)

    @cached_property
    def rows(self) -> np.ndarray:
        """Local function of each corner and nodal vector, (4, 4)."""
        of_position = np.arange(N_POSITION).reshape(CORNERS, FOURTH)
        return np.hstack([of_position, np.arange(N_POSITION, FUNCTIONS)[:, None]])

    def fourth(self, surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The normal, (3, n)."""
        return normal(surface, x, y)

    def fourth_factor(self, jacobian: np.ndarray) -> np.ndarray:
        """A director is the same in all parameters."""
        return np.ones(np.shape(jacobian)[2:])

    def fourth_at_pole(self, on_tangents: np.ndarray) -> np.ndarray:
        """A pole has its director."""
        out = np.zeros((len(on_tangents), VECTORS))
        out[:, FOURTH] = 1.0
        return out

    def hanging_weights(self, way: np.ndarray, along_x: np.ndarray) -> np.ndarray:
        """Of nodes in the middle of edges of signed lengths (m,) along x or y: (2, m, 4, 4)."""
        m = len(way)
        out = no_weights(m)
        set_cubic(out, way, np.full(m, R), np.where(along_x, R_X, R_Y))
        set_mean(out, np.where(along_x, R_Y, R_X))
        set_mean(out, np.full(m, FOURTH))
        return out

    def no_tilt(self, spot: Spot, along: np.ndarray) -> list[Row]:
        """The director does not tilt along an edge."""
        return [Row(spot.node, condition({FOURTH: 1.0}, spot.tangent(along)))]

    def no_turn(self, spot: Spot, edges: Sequence[np.ndarray]) -> list[Row]:
        """The director is held."""
        return [Row(spot.node, condition({FOURTH: 1.0}, axis)) for axis in np.eye(AXES)]

    def symmetric(self, spot: Spot, along: np.ndarray) -> list[Row] | None:
        """The director stays in the plane, and the combination of slopes that is across it in the undeformed state normal
        to it."""
        tangent, normal = spot.tangent(along), spot.normal
        out = cross(tangent, normal)
        x, y = np.linalg.lstsq(spot.vectors.T, out, rcond=None)[0]
        held = [Row(spot.node, condition({R_X: x, R_Y: y}, v), own=spot.own) for v in (tangent, normal)]
        return [Row(spot.node, condition({FOURTH: 1.0}, out)), *held]

    def turn_of(self, kind: int, rotation: np.ndarray, normal: np.ndarray, slopes: Sequence[np.ndarray]) -> np.ndarray:
        """Change (3, n) that a small rotation (3, n) makes of a normal director."""
        return cross(rotation, normal)

    def following(self, nodal: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Directors keep their components in the frame of the slopes and their normal."""
        director, slopes, moved = nodal[:, FOURTH], nodal[:, [R_X, R_Y]], rates[:, [R_X, R_Y]]
        normal = np.cross(slopes[:, 0], slopes[:, 1])
        n = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        duals = np.linalg.solve(slopes @ slopes.swapaxes(1, 2), slopes)
        turning = -np.einsum("ngi,ngj,nj->ni", duals, moved, n)
        along = np.einsum("ni,ngi,ngj->nj", director, duals, moved)
        out = rates.copy()
        out[:, FOURTH] = along + (director * n).sum(axis=1, keepdims=True) * turning
        return out

    def turned(
        self, spot: Spot, edges: Sequence[np.ndarray], rotation: np.ndarray, values: dict[int, np.ndarray],
        rates: dict[int, list[float]],
    ) -> list[Row]:  # fmt: skip
        """The director's parts along the surface are turned by a rotation."""
        tangents = np.linalg.svd(spot.normal[None])[2][1:]
        return [Row(spot.node, condition({FOURTH: 1.0}, t), float(t @ values[FOURTH])) for t in tangents]
