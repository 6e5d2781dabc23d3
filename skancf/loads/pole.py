"""A disk over a pole of the surface, where parameters are not those of a plane: along the lines that run together there."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.elements.quad_ancf import gauss
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.tolerances import ONE_PLACE

STEPS, HALVINGS = 256, 60


@dataclass(frozen=True)
class Pole:
    """A pole under a disk: its mesh nodes, and the centre (3,) and the plane (3, 2) of the disk in space."""

    nodes: np.ndarray
    centre: np.ndarray
    plane: np.ndarray

    __repr__ = short

    def fan(self, geometry: Geometry, radius: float, n: int, n_lines: int) -> tuple[np.ndarray, np.ndarray] | None:
        """Points (2, m) of the parameter plane under the disk and their shares of its area (m,).

        On every line from the pole there are n Gauss points up to the rim of the disk, which it crosses once; the area is
        that seen along the normal at the centre. None where the surface does not go all around the pole, or ends before.
        """
        at, mesh = geometry.mesh.p[:, self.nodes], geometry.mesh.p
        along = int(np.ptp(at[1]) > np.ptp(at[0]))  # the parameter along the side that is the pole
        if along not in geometry.closed_bounds():
            return None
        low, high = geometry.closed_bounds()[along]
        across = 1 - along
        begin = at[across, 0]
        end = max((mesh[across].min(), mesh[across].max()), key=lambda bound: abs(bound - begin))
        lines = low + (high - low) * (np.arange(n_lines) + 0.5) / n_lines

        def place(s: np.ndarray) -> np.ndarray:
            """Parameters at parts s (n_lines, ...) of the way from the pole."""
            rest = np.broadcast_to(lines.reshape(-1, *[1] * (s.ndim - 1)), s.shape)
            return np.stack([begin + (end - begin) * s, rest] if along else [rest, begin + (end - begin) * s])

        def outside(s: np.ndarray) -> np.ndarray:
            return np.linalg.norm(self._seen(geometry, place(s)), axis=0) > radius

        steps = outside(np.broadcast_to(np.linspace(0, 1, STEPS + 1), (n_lines, STEPS + 1)))
        if not steps.any(axis=1).all():
            return None
        far = steps.argmax(axis=1) / STEPS
        near = far - 1 / STEPS
        for _ in range(HALVINGS):
            middle = (near + far) / 2
            beyond = outside(middle)
            near, far = np.where(beyond, near, middle), np.where(beyond, middle, far)
        s, weights = gauss(n)
        points = place(far[:, None] * s)
        slopes = np.einsum("ik,dimn->dkmn", self.plane, np.stack(geometry.surface.derivatives(*points)))
        areas = np.abs(slopes[0, 0] * slopes[1, 1] - slopes[0, 1] * slopes[1, 0]) * far[:, None] * weights
        return points.reshape(2, -1), (areas / areas.sum()).ravel()

    def _seen(self, geometry: Geometry, points: np.ndarray) -> np.ndarray:
        """Places (2, ...) in the plane of the disk, from its centre."""
        return np.tensordot(self.plane.T, np.asarray(geometry.surface.position(*points)), 1) - (
            self.plane.T @ self.centre
        ).reshape(2, *[1] * (points.ndim - 1))


def covered_pole(geometry: Geometry, at: Any, radius: float) -> Pole | None:
    """The pole that is under a disk, if there is one."""
    point = np.asarray(at, float)
    centre = np.asarray(geometry.surface.position(*point), float)
    for node, tangents in geometry.ties.poles.items():
        away = geometry.undeformed[node, 0] - centre
        if np.linalg.norm(away) < ONE_PLACE * radius:
            slopes = tangents.T
        else:
            slopes = np.stack(geometry.surface.derivatives(*point), axis=1)
        plane = np.linalg.qr(slopes)[0]
        seen = plane.T @ away
        height = away - plane @ seen
        if np.linalg.norm(seen) <= radius and np.linalg.norm(height) <= radius:
            return Pole(np.flatnonzero(geometry.ties.node_of == node), centre, plane)
    return None
