"""Stresses per deformed area, and how far the thickness has changed."""

from typing import Any

import numpy as np

from skancf.materials.heights import Depth

ROWS, COLUMNS = [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]
"""Of the components 11, 22, 33, 23, 13, 12."""


def tensors(voigt: np.ndarray, doubled: float = 1.0) -> np.ndarray:
    """Symmetric tensors (..., 3, 3) of components (..., 6), whose shear entries are ``doubled`` times too large."""
    out = np.empty((*voigt.shape[:-1], 3, 3))
    out[..., ROWS, COLUMNS] = out[..., COLUMNS, ROWS] = voigt / ([1.0] * 3 + [doubled] * 3)
    return out


class TrueStresses:
    """What a state with strains and stresses has besides; the base of :class:`~skancf.Solution`."""

    strains: Any
    stresses: Any
    linear: Any

    def cauchy_stresses(self, points: np.ndarray, z: Depth | None = None) -> np.ndarray:
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
        """
        stress, strain = self.stresses(points, z), self.strains(points, z)
        if self.linear:
            return np.asarray(stress)
        squares, axes = np.linalg.eigh(np.eye(3) + 2 * tensors(strain, 2.0))
        stretches = np.sqrt(np.where(squares > 0, squares, np.nan))
        U = np.einsum("...ik,...k,...jk->...ij", axes, stretches, axes)
        true = U @ tensors(stress) @ U / stretches.prod(axis=-1)[..., None, None]
        return np.asarray(true[..., ROWS, COLUMNS])

    def thickness_stretch(self, points: np.ndarray, z: Depth | None = None) -> np.ndarray:
        r"""Stretch across, :math:`\sqrt{C_{33}} = \sqrt{1 + 2 E_{33}}`, at points (2, n) of every element and depth z:
        (n_elements, n).

        Of rubber that is stretched by :math:`\lambda` all around it is :math:`\lambda^{-2}`.
        """
        return np.asarray(np.sqrt(1 + 2 * self.strains(points, z)[..., 2]))
