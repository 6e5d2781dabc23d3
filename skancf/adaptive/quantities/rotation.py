"""The angle by which the normal tilts at a point."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from skancf.adaptive.quantities.quantity import Smooth
from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, unit_vector, vector
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL
from skancf.layout.geometry import Geometry
from skancf.showing import short
from skancf.solution import Solution
from skancf.tolerances import ONE_DIRECTION


class Place(NamedTuple):
    """An element (1,), a local point (2, 1) in it, and n0 and t there."""

    element: np.ndarray
    point: np.ndarray
    n0: np.ndarray
    t: np.ndarray


@by_value
@dataclass(frozen=True)
class Rotation(Smooth):
    r"""Signed angle by which the normal (director) n tilts towards a direction of space (rad):

    .. math:: \varphi = \operatorname{atan2}(n \cdot t,\ n \cdot n_0)

    with the undeformed normal :math:`n_0` and the unit part t of the direction that is orthogonal to it. It is smooth
    through zero, unlike :meth:`Solution.rotation <skancf.Solution.rotation>`, and leaves out tilts to the side.

    Parameters
    ----------
    at : (2,)
        Point of the parameter plane.
    towards : (3,)
        Direction of space, of any length.

    Raises
    ------
    InputError
        For a direction of length zero; with a state, for one that is parallel to the undeformed normal, and for a point
        outside the surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> turn = sk.Rotation(at=(1.0, 0.05), towards=(-1.0, 0.0, 0.0))
    >>> print(f"{1000 * turn.value(sk.solve_linear(system)):.3f} mrad")  # F L^2 / 2 E I
    2.857 mrad
    """

    at: tuple[float, float]
    towards: tuple[float, float, float]

    unit: ClassVar[str] = "rad"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("at", self.at, 2)
        unit_vector("towards", self.towards)

    def _value(self, state: Solution, q: np.ndarray) -> float:
        geometry = state.system.geometry
        place = self._place(geometry)
        n = _normal(geometry, state.system.shell.nodal(q), place.element, place.point)
        return float(np.arctan2(n @ place.t, n @ place.n0))

    def _gradient(self, state: Solution, q: np.ndarray) -> np.ndarray:
        shell, geometry = state.system.shell, state.system.geometry
        element, point, n0, t = self._place(geometry)
        n = _normal(geometry, shell.nodal(q), element, point)
        by_normal = ((n @ n0) * t - (n @ t) * n0) / ((n @ n0) ** 2 + (n @ t) ** 2)
        # The rate of the normal is linear in that of the local vectors: one column for each of their components.
        each = np.eye(LOCAL).reshape(LOCAL, FUNCTIONS, AXES)
        rates = geometry.theory.normal_rates(geometry.local(shell.nodal(q), element), each, point,
                                             geometry.side[element])[:, :, 0]  # fmt: skip
        return shell.flat(geometry.nodal((rates @ by_normal).reshape(1, FUNCTIONS, AXES), element))

    def _place(self, geometry: Geometry) -> Place:
        number, at = geometry.locate(self.at)
        element, point = np.array([number]), geometry.inside(at[:, None])
        n0 = _normal(geometry, geometry.undeformed, element, point)
        n0 = n0 / np.linalg.norm(n0)
        towards = unit_vector("towards", self.towards)
        across = towards - (towards @ n0) * n0
        length = np.linalg.norm(across)
        if length < ONE_DIRECTION:
            raise InputError(f"Rotation at {tuple(self.at)}: towards = {tuple(self.towards)} is parallel to the undeformed "
                             f"normal ({', '.join(f'{v:.4g}' for v in n0)}), which cannot tilt that way; give a direction "
                             "with a part along the surface")  # fmt: skip
        return Place(element, point, n0, across / length)


def _normal(geometry: Geometry, nodal: np.ndarray, element: np.ndarray, point: np.ndarray) -> np.ndarray:
    local = geometry.local(nodal, element)
    return np.asarray(geometry.theory.normals(local, point, geometry.side[element])[0, :, 0])
