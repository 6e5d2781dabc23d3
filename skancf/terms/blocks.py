"""Where terms add their matrices: sums over cells of blocks."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError, SingularMatrix, shown
from skancf.kernels import gather
from skancf.kernels.constants import AXES, BLOCK, FUNCTIONS, LOCAL
from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout
from skancf.linear import BlockMatrix, BlockPattern

Known = dict[int, tuple[np.ndarray, np.ndarray]]
"""Cells and where their blocks stand, by the identity of the array of cells."""


def coupled(cells: Sequence[np.ndarray], layout: Layout) -> tuple[BlockPattern, Known]:
    """The pattern in which the blocks of each cell are coupled, and where those of these cells stand in it."""
    each = {id(some): some for some in cells if some.size}
    pattern = BlockPattern.from_cells(tuple(some.T for some in each.values()), layout.n_blocks, BLOCK, layout.places.T)
    return pattern, {key: (some, pattern.slots(some.T)) for key, some in each.items()}


class Blocks:
    """The symmetric part of a sum of matrices.

    Parameters
    ----------
    pattern : BlockPattern
    known : dict, optional
        Where the blocks of the cells of terms are, by the identity of these arrays.

    Attributes
    ----------
    values : (n_blocks, 12, 12) array
        Of the upper triangle, in the order of the pattern; made when first asked for.

    Examples
    --------
    >>> from skancf.terms.blocks import Blocks, coupled
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> cells = np.array([[0, 1]])  # the first two nodes
    >>> pattern, known = coupled([cells], system.layout)
    >>> blocks = Blocks(pattern, known)
    >>> blocks.add(cells, np.eye(24)[None])
    >>> print(blocks.matrix() @ np.ones(system.n_dofs) @ np.ones(system.n_dofs))
    24.0
    """

    skew = False
    """Whether the skew part is summed, and not the symmetric one."""

    def __init__(self, pattern: BlockPattern, known: Known | None = None) -> None:
        self.pattern, self._known = pattern, known or {}

    @cached_property
    def values(self) -> np.ndarray:
        return np.zeros((self.pattern.n_blocks, BLOCK, BLOCK))

    @property
    def is_zero(self) -> bool:
        """Whether nothing was added."""
        return "values" not in vars(self)

    def slots_of(self, cells: np.ndarray) -> np.ndarray:
        """(n_cells, n, n) int32: where the blocks of each cell (n_cells, n) stand, see :meth:`BlockPattern.slots`."""
        known, slots = self._known.get(id(cells), (None, None))
        return slots if known is cells and slots is not None else self.pattern.slots(np.asarray(cells).T)

    def add(self, cells: np.ndarray, matrices: np.ndarray) -> None:
        """Add matrices (m, 12 n, 12 n) of cells (m, n): unknowns block by block, of each block vector by vector.

        Raises
        ------
        InputError
            For matrices of another shape, and for cells that couple what no term said it does.
        """
        cells, split = np.asarray(cells), _split(np.asarray(cells), matrices)
        slots = self.slots_of(cells)
        inside = slots >= 0
        whole = 0.5 * (split + split.transpose(0, 2, 1, 4, 3))
        np.add.at(self.values, slots[inside], whole[inside])

    def matrix(self) -> BlockMatrix:
        return BlockMatrix(self.pattern, self.values)


class SkewBlocks(Blocks):
    """The skew part of a sum of matrices, which loads that follow the surface have at free edges."""

    skew = True

    def __init__(self, pattern: BlockPattern) -> None:
        super().__init__(pattern)
        self._sum: sp.csr_matrix | None = None

    def add(self, cells: np.ndarray, matrices: np.ndarray) -> None:
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
        part = sp.coo_matrix((entries.ravel(), (rows, columns)), shape=self.pattern.shape).tocsr()
        self._sum = part if self._sum is None else self._sum + part

    def skew_matrix(self) -> sp.csr_matrix | None:
        """The sum; None where it is zero."""
        return self._sum if self._sum is not None and self._sum.nnz else None


class OnElements:
    """The blocks of a plate's nodes, to which matrices of the local vectors of its elements are added."""

    def __init__(self, blocks: Any, cells: np.ndarray, geometry: Geometry, schedule: Schedule) -> None:
        self.blocks, self.cells, self.geometry, self._schedule = blocks, cells, geometry, schedule

    @property
    def skew(self) -> bool:
        """Whether the skew part of matrices is summed, and not the symmetric one."""
        return bool(self.blocks.skew)

    def add(self, elements: np.ndarray, matrices: np.ndarray) -> None:
        """Add matrices (m, 48, 48) of elements (m,), component by component.

        Raises
        ------
        InputError
            For matrices of another shape, and for elements that the mesh does not have.
        """
        elements, matrices = _of_elements(elements, matrices, len(self.cells))
        if self.skew:
            self.blocks.add(self.cells[elements], nodal_matrices(self.geometry, elements, matrices))
            return
        whole = 0.5 * (matrices + matrices.swapaxes(1, 2))
        slots = self.blocks.slots_of(self.cells)
        gather.add_local(elements.astype(np.int32), whole, self.geometry.maps, slots, self.blocks.values)

    def run(self, kernel: Any, *arguments: Any) -> None:
        """``kernel(start, stop, order, *arguments, slots, values)`` over all elements."""
        self._schedule.run(kernel, *arguments, self.blocks.slots_of(self.cells), self.blocks.values)


def _of_elements(elements: Any, matrices: Any, n_elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Both as arrays; compiled code would read what is not there."""
    elements, matrices = np.asarray(elements), np.asarray(matrices)
    if elements.ndim != 1 or elements.dtype.kind not in "iu" or not ((elements >= 0) & (elements < n_elements)).all():
        raise InputError(f"elements {shown(elements)}: give whole numbers (m,) from 0 to {n_elements - 1}")
    wanted = (len(elements), LOCAL, LOCAL)
    if matrices.shape != wanted or matrices.dtype.kind not in "fiu":
        raise InputError(f"matrices of shape {matrices.shape} for {len(elements)} elements: give {wanted}, of real numbers, "
                         "component by component of their local vectors")  # fmt: skip
    _require_finite(matrices)
    return elements, matrices


def nodal_matrices(geometry: Geometry, elements: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Matrices (m, 48, 48) of local vectors, component by component, in the coordinates of their nodes, (m, 12 n, 12 n)."""
    m = len(elements)
    maps = np.stack([geometry.dense_map(e) for e in elements])
    split = matrices.reshape(m, AXES, FUNCTIONS, AXES, FUNCTIONS)
    blocks = maps.swapaxes(1, 2)[:, None, None] @ split.transpose(0, 1, 3, 2, 4) @ maps[:, None, None]
    n = AXES * maps.shape[2]
    return np.asarray(blocks.transpose(0, 3, 1, 4, 2).reshape(m, n, n))


def _split(cells: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Blocks (m, n, n, 12, 12) of matrices of cells (m, n)."""
    if cells.ndim != 2 or cells.dtype.kind not in "iu":
        raise InputError(f"cells {shown(cells)}: give an array (m, n) of whole numbers, a row of blocks for each matrix")
    m, n = cells.shape
    if np.shape(matrices) != (m, n * BLOCK, n * BLOCK) or np.asarray(matrices).dtype.kind not in "fiu":
        raise InputError(f"matrices of shape {np.shape(matrices)} for cells of shape {(m, n)}: give "
                         f"{(m, n * BLOCK, n * BLOCK)}, {BLOCK} unknowns a block, of real numbers")  # fmt: skip
    _require_finite(matrices)
    return np.asarray(matrices).reshape(m, n, BLOCK, n, BLOCK).transpose(0, 1, 3, 2, 4)


def _require_finite(matrices: np.ndarray) -> None:
    """SingularMatrix for a tangent that is not finite, from which solvers turn back as from one that is singular."""
    if not np.isfinite(matrices).all():
        raise SingularMatrix("the tangent of a term is not finite")
