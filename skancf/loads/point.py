"""Forces at a point and on a small disk."""

from dataclasses import dataclass
from math import pi

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, positive, vector
from skancf.history import History, check_history
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity
from skancf.loads.acting import DeadLoad, Spread, at_points
from skancf.loads.pole import covered_pole
from skancf.showing import short
from skancf.terms.protocols import Assembly
from skancf.tolerances import ONE_PLACE, VANISHED

NEWTON = 30


@by_value
@dataclass(frozen=True)
class PointForce:
    """A force (N) at a point of the parameter plane.

    In theory `full` the deflection under it has no limit as the mesh is refined: it grows with the logarithm of the
    element size. :class:`DiskForce` has a limit.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.PointForce((0.5, 0.5), (0.0, 0.0, -100.0))],
    ... )
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 8, 8), "kirchhoff"))
    >>> print(f"{1000 * solution.displacement((0.5, 0.5))[2]:.4f} mm")  # 0.00560 F a^2 / D
    -0.0290 mm
    """

    at: tuple[float, float]
    force: tuple[float, float, float]
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        vector("at", self.at, 2)
        vector("force", self.force, 3)

    def on(self, assembly: Assembly) -> DeadLoad:
        geometry = assembly.geometry
        at = geometry.within(np.asarray(self.at, float)[:, None])
        nodal = self.spread(assembly).nodal(geometry)
        return DeadLoad(nodal, self.history, singular=[Singularity("force", at, "a PointForce", self.force)])

    def spread(self, assembly: Assembly) -> Spread:
        """The force at its point of a mesh."""
        element, local = assembly.geometry.locate(self.at)
        return at_points([element], local[None], np.array([self.force]))


@by_value
@dataclass(frozen=True)
class DiskForce:
    """A force (N) spread evenly over a small disk of the mid-surface, round where it is seen along the normal at its centre.

    Parameters
    ----------
    at : (2,)
        Centre in the parameter plane.
    radius : float
        In space (m).
    force : (3,)
        The whole force.

    Raises
    ------
    InputError
        For a radius that is not positive and entries that are not finite; on a mesh, for a disk that reaches over the
        edge of the surface, or so far around it that it has no one point under each of the disk.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> foot = sk.DiskForce(at=(0.5, 0.5), radius=0.05, force=(0.0, 0.0, -100.0))
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Clamp("boundary")], loads=[foot])
    >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 8, 8), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.4f} N")
    100.0000 N
    """

    at: tuple[float, float]
    radius: float
    force: tuple[float, float, float]
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        vector("at", self.at, 2)
        positive("radius", self.radius, "m")
        vector("force", self.force, 3)

    def on(self, assembly: Assembly) -> DeadLoad:
        points, spread = self._spread(assembly.geometry)
        return DeadLoad(spread.nodal(assembly.geometry), self.history, assembly.geometry.within(points))

    def spread(self, assembly: Assembly) -> Spread:
        """The forces at points of the disk."""
        return self._spread(assembly.geometry)[1]

    def _spread(self, geometry: Geometry) -> tuple[np.ndarray, Spread]:
        # Rings of equal area about the centre; 16 x 48 points follow a disk that covers several elements.
        n_rings, n_angles = 16, 48
        radii = self.radius * np.sqrt((np.arange(n_rings) + 0.5) / n_rings)
        angles = 2 * pi * (np.arange(n_angles) + 0.5) / n_angles
        offsets = np.stack([np.outer(radii, f(angles)).ravel() for f in (np.cos, np.sin)])
        pole = covered_pole(geometry, self.at, self.radius)
        if pole is None:
            points, shares = self._points(geometry, offsets), np.full(offsets.shape[1], 1 / offsets.shape[1])
        else:
            fan = pole.fan(geometry, self.radius, n_rings, n_angles)
            if fan is None:
                raise self._over_the_edge()
            points, shares = fan
        try:
            elements, local = geometry.locate_all(points)
        except InputError as outside:
            raise self._over_the_edge() from outside
        forces = np.outer(shares, np.asarray(self.force, float))
        return points, at_points(elements, local, forces)

    def _points(self, geometry: Geometry, offsets: np.ndarray) -> np.ndarray:
        """Parameters (2, n) of the points that are at offsets (2, n) from the centre, seen along the normal there."""
        surface, centre = geometry.surface, np.asarray(self.at, float)
        slopes = np.stack(surface.derivatives(*centre), axis=1)
        frame, triangle = np.linalg.qr(slopes)
        sizes = np.abs(triangle.diagonal())
        if sizes.min() < VANISHED * sizes.max():
            raise self._too_far_around()
        points = centre[:, None] + np.linalg.solve(triangle, offsets)
        origin, scale = surface.position(*centre)[:, None], np.abs(points - centre[:, None]).max()
        for _ in range(NEWTON):
            points_now = geometry.within(points)
            gap = offsets - frame.T @ (surface.position(*points_now) - origin)
            if np.abs(gap).max() < ONE_PLACE * self.radius:
                return points
            matrix = np.einsum("ik,dim->mkd", frame, np.stack(surface.derivatives(*points_now)))
            if (np.abs(np.linalg.det(matrix)) < VANISHED * abs(np.linalg.det(triangle))).any():
                raise self._too_far_around()
            step = np.linalg.solve(matrix, gap.T[:, :, None])[:, :, 0].T
            points = points + step * min(1.0, scale / np.abs(step).max())
        raise self._too_far_around()

    def _over_the_edge(self) -> InputError:
        return InputError(f"disk at {tuple(self.at)} of radius {self.radius} m reaches over the edge of the surface; "
                          "make it smaller or move it")  # fmt: skip

    def _too_far_around(self) -> InputError:
        return InputError(f"disk at {tuple(self.at)} of radius {self.radius} m reaches over the edge of the surface, or so "
                          "far around it that not all of it is over the surface, seen along the normal at its centre; make "
                          "it smaller, or use a PointForce, or a SurfaceLoad that is zero elsewhere")  # fmt: skip
