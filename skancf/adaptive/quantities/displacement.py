"""The displacement at a point, in one direction."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skancf.adaptive.quantities.quantity import Smooth
from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import unit_vector, vector
from skancf.showing import short
from skancf.solution import Solution
from skancf.statics.controls import displacement_row


@by_value
@dataclass(frozen=True)
class Displacement(Smooth):
    r"""Displacement :math:`d \cdot u(x, y)` of the reference surface along a unit direction d of space (m).

    Parameters
    ----------
    at : (2,)
        Point of the parameter plane.
    direction : (3,)
        Of any length.

    Raises
    ------
    InputError
        For a direction of length zero; with a state, for a point outside its surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> down = sk.Displacement(at=(0.5, 0.5), direction=(0.0, 0.0, -1.0))
    >>> print(f"{1000 * down.value(sk.solve_linear(system)):.4f} mm")
    0.0658 mm
    """

    at: tuple[float, float]
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    unit: ClassVar[str] = "m"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("at", self.at, 2)
        unit_vector("direction", self.direction)

    def _value(self, state: Solution, q: np.ndarray) -> float:
        return float(self._gradient(state, q) @ (q - state.system.undeformed))

    def _gradient(self, state: Solution, q: np.ndarray) -> np.ndarray:
        return displacement_row(state.system, self.at, self.direction)
