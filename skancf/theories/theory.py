"""What the rest of the library knows of a theory."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from skancf.materials import Section
from skancf.surfaces import Surface
from skancf.theories.rows import Row, Spot


class Theory(Protocol):
    """Which strains are made of the position field.

    Attributes
    ----------
    name : str
    assumed : bool
        Whether strains that would lock are assumed.
    nodal_vectors : tuple of str
        What the vectors of a node are. States of theories that have the same ones fit each other.
    order : int
        Of errors of displacements and energies where the solution is smooth. Moments have half of it, and are best at as
        many Gauss points each way.
    continuity : int
        How many derivatives of the positions are continuous. With one, elements are rectangles of the parameter plane, and
        surfaces have second derivatives.
    directors : bool
        Whether the fourth nodal vector is a director: of its own, whatever the positions are, with mass, moments that act
        on it, and a place at a pole. If not, it is a derivative of the positions, and normals are those of the surface.
    shear : bool
        Whether transverse shear is a strain. With it point forces across the surface sink in with the logarithm of the
        element size; without it is left out.
    softest : float
        Of the squared frequency of a rough motion, that of motions which no element resists much.
    bytes_per_element, bytes_per_shape : int
        Memory of a system for each element, and for each undeformed element of another shape than those before while it is
        set up; measured.
    turns : tuple of int
        The nodal vectors that tell how the normal turns.
    of_positions : tuple of bool
        Which nodal vectors the positions of the surface depend on.
    rows : (4, 4) int array
        Local function of each corner and nodal vector.
    """

    @property
    def name(self) -> str: ...
    @property
    def assumed(self) -> bool: ...
    @property
    def nodal_vectors(self) -> tuple[str, ...]: ...
    @property
    def order(self) -> int: ...
    @property
    def continuity(self) -> int: ...
    @property
    def directors(self) -> bool: ...
    @property
    def shear(self) -> bool: ...
    @property
    def softest(self) -> float: ...
    @property
    def bytes_per_element(self) -> int: ...
    @property
    def bytes_per_shape(self) -> int: ...
    @property
    def turns(self) -> tuple[int, ...]: ...
    @property
    def of_positions(self) -> tuple[bool, ...]: ...
    @property
    def rows(self) -> np.ndarray: ...

    def warn_of(self, section: Section, reach: float) -> None:
        """Warns of a section that the theory does not fit, on a body of that reach (m)."""

    @property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Integration points (2, 16) of the reference square and their weights."""

    def fourth(self, surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The fourth nodal vector of the undeformed surface, (3, n)."""

    def fourth_factor(self, jacobian: np.ndarray) -> np.ndarray:
        """Factor (...) of the fourth vector by other parameters, with derivatives (2, 2, ...) of these by those."""

    def fourth_at_pole(self, on_tangents: np.ndarray) -> np.ndarray:
        """Weights (m, 4) of a pole's vectors in the fourth vectors at its nodes, of which the undeformed r_xy have these
        components (m, 2) on its tangents."""

    def hanging_weights(self, way: np.ndarray, along_x: np.ndarray) -> np.ndarray:
        """Weights (2, m, 4, 4) of the vectors at both ends in those in the middle of edges of signed lengths (m,), along x
        or along y."""

    def no_tilt(self, spot: Spot, along: np.ndarray) -> list[Row]:
        """Conditions that the normal or director does not tilt along an edge of that direction (2,)."""

    def no_turn(self, spot: Spot, edges: Sequence[np.ndarray]) -> list[Row]:
        """Conditions that it does not turn about edges of these directions, at a single point, without any, not at all."""

    def symmetric(self, spot: Spot, along: np.ndarray) -> list[Row] | None:
        """Conditions that an edge is in a mirror, besides those of positions; None where parameter lines would have to be
        normal to it and are not."""

    def turn_of(self, kind: int, rotation: np.ndarray, normal: np.ndarray, slopes: Sequence[np.ndarray]) -> np.ndarray:
        """What small rotations (3, n) make of one of :attr:`turns` as far as it tells how the normal turns: (n,), (3, n)."""

    def following(self, nodal: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Rates (n, 4, 3) of nodal vectors (n, 4, 3), of which those of the positions are given; the others follow them as
        if they were fixed in the surface."""

    def turned(
        self, spot: Spot, edges: Sequence[np.ndarray], rotation: np.ndarray, values: dict[int, np.ndarray],
        rates: dict[int, list[float]],
    ) -> list[Row]:  # fmt: skip
        """Conditions as :meth:`no_turn` of a surface that turns by a small rotation (3,).

        For each of :attr:`turns` ``values`` has :meth:`turn_of` at the node, and, of continuous slopes, ``rates`` its
        derivatives along the edges.
        """

    def position_table(self, points: np.ndarray) -> np.ndarray:
        """Values of the local functions of r, and of r_z if there is one, at points (2, n): (1 or 2, 16, n)."""

    def nodal_table(self, points: np.ndarray) -> np.ndarray:
        """The four vectors of a node, in the reference square, of the local functions at points (2, n): (4, 16, n)."""

    def strain_forces(self, local: np.ndarray, points: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Derivative of the work of stresses (n_elements, n_strains, n) on these strains, (n_elements, 16, 3)."""

    def slope_table(self, points: np.ndarray) -> np.ndarray:
        """r_1 and r_2 of the local functions at points (2, n): (2, 16, n)."""

    def jets(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Jets (5, 3, n_elements, n) of local vectors (n_elements, 16, 3) at points (2, n); the first two are r_1, r_2."""

    def strains(self, local: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Strains (n_elements, n_strains, n) at points (2, n), before those of the undeformed state are subtracted."""

    def normals(self, local: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Director r_z or unit normal (n_elements, 3, n), on the side of the undeformed normal."""

    def normal_rates(self, local: np.ndarray, rates: np.ndarray, points: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Its rate for rates of the local vectors, (n_elements, 3, n)."""

    def bases(self, local: np.ndarray, points: np.ndarray, side: np.ndarray, z: Any) -> np.ndarray:
        """Tangent vectors at a height z, or one for each place, along the reference square and across: columns of
        (n_elements, n, 3, 3)."""


def left_per_halving(theory: Theory) -> float:
    """Part of an error that is left where elements are halved and the solution is smooth."""
    return 2.0**-theory.order
