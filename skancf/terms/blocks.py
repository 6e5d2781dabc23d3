"""Where terms add their matrices: sums over cells of blocks."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.kernels import gather
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.layout import AXES, BLOCK, VECTORS
from skancf.linear import BlockMatrix, BlockPattern

LOCAL = 16
"""Local functions of an element; its local vectors are (16, 3), and their matrices (48, 48) go component by component."""


class Blocks:
    """The symmetric part of a sum of matrices.

    Attributes
    ----------
    pattern : BlockPattern
    values : (n_blocks, 12, 12) array
        Of the upper triangle, in the order of the pattern.
    slots : dict
        Where the blocks of known cells are, kept from sum to sum.
    """

    skew = False

    def __init__(self, pattern: BlockPattern, slots: dict[int, Any] | None = None, values: np.ndarray | None = None) -> None:
        self.pattern, self._slots = pattern, {} if slots is None else slots
        self.values = np.zeros((pattern.n_blocks, BLOCK, BLOCK)) if values is None else values

    def slots_of(self, cells: np.ndarray) -> np.ndarray:
        """(n_cells, n, n) int32: where the blocks of each cell (n_cells, n) stand, see :meth:`BlockPattern.slots`."""
        if id(cells) not in self._slots:
            self._slots[id(cells)] = cells, self.pattern.slots(np.asarray(cells).T)
        return np.asarray(self._slots[id(cells)][1])

    def add(self, cells: np.ndarray, matrices: np.ndarray) -> None:
        """Add matrices (m, 12 n, 12 n) of cells (m, n): unknowns block by block, of each block vector by vector.

        Raises
        ------
        InputError
            For matrices of another shape, and for cells that couple what no term said it does.
        """
        cells = np.asarray(cells)
        split = _split(cells, matrices)
        slots = self.slots_of(cells)
        inside = slots >= 0
        whole = 0.5 * (split + split.transpose(0, 2, 1, 4, 3))
        np.add.at(self.values, slots[inside], whole[inside])

    def matrix(self) -> BlockMatrix:
        return BlockMatrix(self.pattern, self.values)


class SkewBlocks:
    """The skew part of a sum of matrices, which loads that follow the surface have at free edges."""

    skew = True

    def __init__(self, pattern: BlockPattern) -> None:
        self.pattern = pattern
        self._parts: list[sp.csr_matrix] = []

    def add(self, cells: np.ndarray, matrices: np.ndarray) -> None:
        """As :meth:`Blocks.add`."""
        cells = np.asarray(cells)
        split = _split(cells, matrices)
        half = 0.5 * (split - split.transpose(0, 2, 1, 4, 3))
        if not half.any():
            return
        m, n = cells.shape
        entries = half.transpose(0, 1, 3, 2, 4).reshape(m, n * BLOCK, n * BLOCK)
        places = (BLOCK * cells[:, :, None].astype(int) + np.arange(BLOCK)).reshape(m, -1)
        size = places.shape[1]
        rows, columns = np.repeat(places, size, axis=1).ravel(), np.tile(places, (1, size)).ravel()
        self._parts.append(sp.coo_matrix((entries.ravel(), (rows, columns)), shape=self.pattern.shape).tocsr())

    def matrix(self) -> sp.csr_matrix | None:
        """The sum; None where it is zero."""
        total = sum(self._parts[1:], self._parts[0]) if self._parts else None
        return total if total is not None and total.nnz else None


class OnElements:
    """The blocks of a plate's nodes, to which matrices of the local vectors of its elements are added."""

    def __init__(self, blocks: Any, cells: np.ndarray, geometry: Geometry, schedule: Schedule) -> None:
        self.blocks, self.cells, self.geometry, self._schedule = blocks, cells, geometry, schedule

    @property
    def skew(self) -> bool:
        """Whether the skew part of matrices is summed, and not the symmetric one."""
        return bool(self.blocks.skew)

    def add(self, elements: np.ndarray, matrices: np.ndarray) -> None:
        """Add matrices (m, 48, 48) of elements (m,), component by component."""
        if self.skew:
            self.blocks.add(self.cells[elements], nodal_matrices(self.geometry, elements, matrices))
            return
        whole = 0.5 * (matrices + matrices.swapaxes(1, 2))
        slots = self.blocks.slots_of(self.cells)
        gather.add_local(np.asarray(elements, np.int32), whole, self.geometry.maps, slots, self.blocks.values)

    def run(self, kernel: Any, *arguments: Any) -> None:
        """``kernel(start, stop, order, *arguments, slots, values)`` over all elements."""
        self._schedule.run(kernel, *arguments, self.blocks.slots_of(self.cells), self.blocks.values)


def nodal_matrices(geometry: Geometry, elements: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Matrices (m, 48, 48) of local vectors, component by component, in the coordinates of the four nodes, (m, 48, 48)."""
    m = len(elements)
    maps = np.stack([geometry.dense_map(e) for e in elements])
    split = matrices.reshape(m, AXES, LOCAL, AXES, LOCAL)
    blocks = maps.swapaxes(1, 2)[:, None, None] @ split.transpose(0, 1, 3, 2, 4) @ maps[:, None, None]
    return np.asarray(blocks.transpose(0, 3, 1, 4, 2).reshape(matrices.shape))


def _split(cells: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Blocks (m, n, n, 12, 12) of matrices of cells (m, n)."""
    m, n = cells.shape
    if np.shape(matrices) != (m, n * BLOCK, n * BLOCK):
        raise InputError(f"matrices of shape {np.shape(matrices)} for cells of shape {(m, n)}: give "
                         f"{(m, n * BLOCK, n * BLOCK)}, {BLOCK} unknowns a block")  # fmt: skip
    return np.asarray(matrices).reshape(m, n, BLOCK, n, BLOCK).transpose(0, 1, 3, 2, 4)


__all__ = ["AXES", "BLOCK", "LOCAL", "VECTORS", "Blocks", "OnElements", "SkewBlocks", "nodal_matrices"]
