"""Inertia of everything: mass, kinetic energy, momenta."""

import numpy as np

from skancf.layout.layout import Layout
from skancf.linear import BlockMatrix
from skancf.vectors import sum_of_cross


class Inertia:
    """Of the constant mass matrix of a layout.

    Attributes
    ----------
    shares : (n_blocks, 4) array
        What the mass makes of a unit translation at the vectors of the blocks (kg).
    total : float
        Mass of everything, the sum of the shares at positions (kg).
    """

    def __init__(self, mass: BlockMatrix, layout: Layout) -> None:
        self.mass, self.layout = mass, layout
        ones = np.zeros_like(layout.undeformed)
        ones[layout.moving, 0, 0] = 1.0
        self.shares = np.asarray(layout.nodal(mass @ ones.ravel())[:, :, 0])
        self.total = float(self.shares[layout.moving, 0].sum())

    def centre(self, q: np.ndarray) -> np.ndarray:
        """Mass times the place of its centre, (3,) (kg m)."""
        return np.asarray(np.einsum("nk,nki->i", self.shares, self.layout.nodal(q)))

    def momenta(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        r"""Linear momentum (N s) and angular momentum about the origin (N m s), (2, 3).

        What M v does on a translation and on a spin of everything: with the vectors :math:`q_i, (M v)_i` of all blocks,
        :math:`\sum_i (M v)_i` over positions, and :math:`\sum_i q_i \times (M v)_i` over all.
        """
        flow = self.layout.nodal(self.mass @ v)
        return np.stack([self.layout.positions(flow).sum(axis=0), sum_of_cross(self.layout.nodal(q), flow)])
