"""What loads do to the nodes and faces of bricks."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.errors import InputError, shown
from skancf.export.bricks import Bricks
from skancf.functions import values_at
from skancf.loads import (
    DiskForce,
    EdgeLoad,
    EdgeMoment,
    FollowerPressure,
    Gravity,
    LineLoad,
    PointForce,
    PointMoment,
    SurfaceLoad,
    Temperature,
)
from skancf.surfaces import normal

MIDDLE = np.array([[0.5], [0.5]])
LOADS = (DiskForce, EdgeLoad, EdgeMoment, FollowerPressure, Gravity, LineLoad, PointForce, PointMoment, SurfaceLoad,
         Temperature)  # fmt: skip


@dataclass
class Forces:
    """The loads of a problem on bricks.

    Attributes
    ----------
    nodal : (n_nodes, 3) array
        Dead forces (N).
    pressure : (n_elements,) array or None
        Along the normal of the deformed surface (Pa), that in the middle of each element.
    acceleration : (3,) array or None
        Of gravity (m/s2).
    temperature : (n_nodes,) array or None
        Change at the nodes (K).
    """

    bricks: Bricks
    nodal: np.ndarray = field(init=False)
    pressure: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    temperature: np.ndarray | None = None

    def __post_init__(self) -> None:
        self.nodal = np.zeros((self.bricks.n_nodes, 3))

    @classmethod
    def of(cls, bricks: Bricks, nonlinear: bool) -> "Forces":
        """Those of all loads.

        Raises
        ------
        InputError
            For loads that are not exported.
        """
        out = cls(bricks)
        for load in bricks.system.problem.loads:
            if type(load) not in LOADS:
                raise InputError(f"load {shown(load)}: class {type(load).__name__} is not exported; these are: "
                                 f"{', '.join(kind.__name__ for kind in LOADS)}")  # fmt: skip
            if nonlinear and isinstance(load, EdgeMoment | PointMoment):
                raise InputError(f"load {shown(load)}: bricks take a moment as a couple of dead forces, which does not turn "
                                 "with them; export it with nonlinear=False")  # fmt: skip
            out._add(load)
        return out

    def _add(self, load: Any) -> None:
        assembly = self.bricks.system.assembly
        at = self.bricks.system.geometry.parameters(MIDDLE)[:, :, 0]
        if isinstance(load, Gravity):
            self.acceleration = _sum(self.acceleration, np.asarray(load.acceleration, float))
        elif isinstance(load, FollowerPressure):
            self.pressure = _sum(self.pressure, values_at("pressure", load.pressure, at))
        elif isinstance(load, Temperature):
            change, gradient = load.values(self.bricks.at)
            line = self.bricks.line_of
            self.temperature = _sum(self.temperature, change[line] + self.bricks.levels * gradient[line])
        elif isinstance(load, EdgeMoment | PointMoment):
            self._add_moments(*load.spread(assembly))
        else:
            self._add_forces(*load.spread(assembly))

    def _add_forces(self, elements: np.ndarray, points: np.ndarray, forces: np.ndarray) -> None:
        """Forces (m, 2, 3, n) on positions and directors at local points (m, 2, n) of elements (m,)."""
        shapes = self.bricks.at_points(elements, points)
        for weights, part in zip(self.bricks.weights, forces.swapaxes(0, 1), strict=True):
            self.nodal += weights.T @ (shapes.T @ part.swapaxes(1, 2).reshape(-1, 3))

    def _add_moments(self, elements: np.ndarray, points: np.ndarray, moments: np.ndarray) -> None:
        """Moments (m, 3, n): the force on a director d is moment x d."""
        geometry = self.bricks.system.geometry
        n = normal(geometry.surface, *geometry.parameters(points, elements)).swapaxes(0, 1)
        on_directors = np.cross(moments, n, axis=1)
        self._add_forces(elements, points, np.stack([np.zeros_like(on_directors), on_directors], axis=1))


def _sum(one: np.ndarray | None, other: np.ndarray) -> np.ndarray:
    return other if one is None else one + other
