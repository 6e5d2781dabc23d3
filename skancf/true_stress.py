"""Stresses per deformed area, and how far the thickness has changed."""

from typing import Any

import numpy as np

from skancf.materials.heights import Depth
from skancf.tensors import cauchy


class TrueStresses:
    """What a state with strains and stresses has besides; the base of :class:`~skancf.Solution`."""

    strains: Any
    stresses: Any
    linear: Any

    def cauchy_stresses(self, points: np.ndarray, z: Depth | None = None, elements: np.ndarray | None = None) -> np.ndarray:
        r"""Cauchy stress, force per deformed area, at points (2, n) of every element: (n_elements, n, 6) (Pa).

        .. math:: \sigma = \frac{1}{J} U S U, \qquad U = \sqrt{C}, \quad J = \det U, \quad C = 1 + 2 E

        in the local frame of the undeformed surface, turned with the material. S is the second Piola-Kirchhoff stress of
        :meth:`~skancf.Solution.stresses`, E the strain of :meth:`~skancf.Solution.strains`, whose strain across counts in J:
        linear laws of plane stress have none in theory `full`, and there J is the change of area alone. A small-deflection
        answer has one stress.

        Parameters
        ----------
        points : (2, n) array
            In the reference square.
        z : float or {"top", "middle", "bottom"}
            Depth (m), undeformed.
        elements : (m,) int array, optional
            Some elements instead of all.
        """
        stress, strain = self.stresses(points, z, elements), self.strains(points, z, elements)
        return np.asarray(stress) if self.linear else cauchy(stress, strain)

    def thickness_stretch(
        self, points: np.ndarray, z: Depth | None = None, elements: np.ndarray | None = None
    ) -> np.ndarray:
        r"""Stretch across, :math:`\sqrt{C_{33}} = \sqrt{1 + 2 E_{33}}`, at points (2, n) of every element and depth z:
        (n_elements, n).

        Of rubber that is stretched by :math:`\lambda` all around it is :math:`\lambda^{-2}`.
        """
        return np.asarray(np.sqrt(1 + 2 * self.strains(points, z, elements)[..., 2]))
