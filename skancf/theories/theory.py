"""What the rest of the library knows of a theory."""

from typing import Protocol

import numpy as np

from skancf.surfaces import Surface


class Theory(Protocol):
    """Which strains are made of the position field.

    Attributes
    ----------
    name : str
    assumed : bool
        Whether strains that would lock are assumed.
    twist : bool
        Whether the fourth nodal vector is r_xy (a derivative, scaled by both sides of an element) or r_z.
    rows : (4, 4) int array
        Local function of each corner and nodal vector.
    """

    @property
    def name(self) -> str: ...
    @property
    def assumed(self) -> bool: ...
    @property
    def twist(self) -> bool: ...
    @property
    def rows(self) -> np.ndarray: ...
    @property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Integration points (2, 16) of the reference square and their weights."""

    def fourth(self, surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The fourth nodal vector of the undeformed surface, (3, n)."""

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
