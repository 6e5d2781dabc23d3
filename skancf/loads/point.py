"""Forces at a point and on a small disk."""

from dataclasses import dataclass
from math import pi

import numpy as np

from skancf.assembly.protocols import Assembly
from skancf.errors import InputError, positive, vector
from skancf.history import History, check_history
from skancf.loads.acting import DeadLoad, point_forces


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

    def on(self, assembly: Assembly) -> DeadLoad:
        geometry = assembly.geometry
        element, local = geometry.locate(self.at)
        nodal = point_forces(geometry, [element], local[None], np.array([self.force]))
        return DeadLoad(nodal, self.history, geometry.within(np.asarray(self.at, float)[:, None]))


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

    def on(self, assembly: Assembly) -> DeadLoad:
        geometry = assembly.geometry
        # Rings of equal area about the centre; 16 x 48 points follow a disk that covers several elements.
        n_rings, n_angles = 16, 48
        radii = self.radius * np.sqrt((np.arange(n_rings) + 0.5) / n_rings)
        angles = 2 * pi * (np.arange(n_angles) + 0.5) / n_angles
        offsets = np.stack([np.outer(radii, f(angles)).ravel() for f in (np.cos, np.sin)])
        slopes = np.stack(geometry.surface.derivatives(*np.asarray(self.at, float)), axis=1)
        triangle = np.linalg.qr(slopes)[1]
        sizes = np.abs(triangle.diagonal())
        if sizes.min() < 1e-9 * sizes.max():
            raise InputError(f"disk at {tuple(self.at)}: the parameters have no inverse at a pole, so a disk cannot cover "
                             "one; use a PointForce, or a SurfaceLoad that is zero elsewhere")  # fmt: skip
        points = np.asarray(self.at, float)[:, None] + np.linalg.solve(triangle, offsets)
        try:
            elements, local = geometry.locate_all(points)
        except InputError as outside:
            raise InputError(f"disk at {tuple(self.at)} of radius {self.radius} m reaches over the edge of the surface; "
                             "make it smaller or move it") from outside  # fmt: skip
        forces = np.tile(np.asarray(self.force, float) / len(elements), (len(elements), 1))
        return DeadLoad(point_forces(geometry, elements, local, forces), self.history, geometry.within(points))
