"""A rigid rod between two points of the surface."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.arguments import plain, text
from skancf.conditions import distance
from skancf.conditions.condition import Condition, Joint
from skancf.conditions.rows import cells_of, extent_of, in_space
from skancf.equality import by_value
from skancf.errors import InputError, vector
from skancf.history import Case
from skancf.kernels.constants import AXES, VECTORS
from skancf.layout.layout import Layout, vectors
from skancf.layout.singularities import Singularity
from skancf.showing import short
from skancf.terms.blocks import Blocks
from skancf.tolerances import ONE_PLACE


@by_value
@dataclass(frozen=True)
class RigidLink(Joint):
    r"""A rigid rod, hinged at both ends, between two points of the mid-surface.

    .. math:: |r(a) - r(b)|^2 = L^2

    Their distance stays what it is undeformed. The multiplier is the force in the rod (N), positive if it pulls.

    Parameters
    ----------
    a, b : (2,)
        Points of the parameter plane.
    name : str
        By which results and messages know it.

    Raises
    ------
    InputError
        For invalid points; on a mesh, for one off the surface, and for two that are one place, whose link has no
        direction.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> strut = sk.RigidLink((0.0, 0.05), (1.0, 0.05), name="strut")
    >>> strip = sk.Problem(
    ...     sk.Rectangle(1.0, 0.1), 0.002, steel,
    ...     supports=[sk.Pin([(0.0, 0.0), (0.0, 0.1)]), sk.Roller([(1.0, 0.0), (1.0, 0.1)])],
    ...     loads=[sk.EdgeLoad("right", (1000.0, 0.0, 0.0))], conditions=[strut],
    ... )
    >>> solution = sk.solve(strip.on(sk.meshes.uniform(strip.surface, 4, 2), "kirchhoff")).unwrap()
    >>> print(f"{solution.conditions['strut']:.1f} N")
    76.8 N
    """

    a: tuple[float, float]
    b: tuple[float, float]
    name: str = "rigid link"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("a", self.a, 2)
        vector("b", self.b, 2)
        text("name", self.name)

    @property
    def points(self) -> tuple[Any, ...]:
        """Its ends."""
        return self.a, self.b

    def on(self, shell: Any, layout: Layout) -> "Distance":
        rows = shell.position_rows(*shell.geometry.locate_all(np.array([self.a, self.b], float).T))
        difference = sp.csr_matrix(rows[1] - rows[0])
        difference.eliminate_zeros()
        extent = extent_of(layout)
        way = (difference @ vectors(layout.undeformed))[0]
        if not np.linalg.norm(way) > ONE_PLACE * extent:
            raise InputError(f"{self.name} from {tuple(self.a)} to {tuple(self.b)}: its length is zero, for both points are "
                             "at one place in space; give two that are apart, or a Hinge for edges that meet")  # fmt: skip
        ends = shell.geometry.within(np.array([self.a, self.b], float).T)
        return Distance(self.name, difference, way, extent, ends)


class Distance(Condition):
    """The condition of a :class:`RigidLink`, on weights (1, 4 n_blocks) that make the vector between its ends (2, 2)."""

    n = 1

    def __init__(self, name: str, difference: sp.csr_matrix, way: np.ndarray, extent: float, ends: np.ndarray) -> None:
        self.name, self.length, self.scales, self._ends = name, float(np.linalg.norm(way)), np.array([extent]), ends
        self._in_space, self._way = in_space(difference), way / self.length
        self._cells = cells_of(difference)
        weights = np.zeros((self._cells.shape[1], VECTORS))
        blocks, kinds = np.divmod(difference.indices, VECTORS)
        weights[np.searchsorted(self._cells[0], blocks), kinds] = difference.data
        self._outer = np.kron(np.outer(weights, weights), distance.curvature(self.length))

    def couples(self) -> np.ndarray:
        return self._cells

    def value(self, q: np.ndarray, case: Case) -> np.ndarray:
        return np.array([distance.value(self._apart(q), self.length)])

    def gradient(self, q: np.ndarray) -> sp.csr_matrix:
        along = sp.csr_matrix(distance.gradient(self._apart(q), self.length)[None])
        return sp.csr_matrix(along @ self._in_space)

    def add_curvature(self, q: np.ndarray, multipliers: np.ndarray, blocks: Blocks) -> None:
        blocks.add(self._cells, multipliers[0] * self._outer[None])

    def rows(self) -> list[str]:
        return ["its length"]

    def singularities(self, case: Case) -> list[Singularity]:
        """A force at both ends, along the undeformed rod."""
        return [Singularity("force", self._ends, "a RigidLink", vector=self._way)]

    def resultant(self, direction: np.ndarray | None) -> np.ndarray:
        if direction is not None:
            raise InputError(f"condition {self.name!r}: the force of a rod is along it; leave the direction out")
        return np.ones(1)

    def forces(self, multipliers: np.ndarray) -> float:
        """The force in the rod (N), positive if it pulls."""
        return float(multipliers[0])

    def _apart(self, q: np.ndarray) -> np.ndarray:
        return np.asarray(self._in_space @ q).reshape(AXES)
