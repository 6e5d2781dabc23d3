"""Where a symmetric matrix of small dense blocks has entries: one block for each pair of nodes that share a cell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.showing import short


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Upper triangle, diagonal included, of a symmetric graph of nodes in compressed rows.

    Parameters
    ----------
    n_nodes : int
    block : int
        Unknowns per node; unknown ``k`` of node ``i`` has the number ``i * block + k``.
    indptr : (n_nodes + 1,) int32 array
    indices : (n_blocks,) int32 array
        Column of each block, ascending in each row, so that the first block of a row is the diagonal one.
    coordinates : (d, n_nodes) array
        Where the nodes are. Used for the order of elimination and nothing else.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(system.pattern.n_nodes, system.pattern.block)
    49 12
    """

    n_nodes: int
    block: int
    indptr: np.ndarray
    indices: np.ndarray
    coordinates: np.ndarray

    __repr__ = short

    @classmethod
    def from_cells(
        cls, cells: np.ndarray | tuple[np.ndarray, ...], n_nodes: int, block: int, coordinates: np.ndarray
    ) -> "BlockPattern":
        """The pattern in which all nodes of a cell are coupled.

        Parameters
        ----------
        cells : (m, n_cells) int array, or a tuple of several
        coordinates : (d, n_nodes) array

        Raises
        ------
        InputError
            For a node number outside the mesh or coordinates of another number of nodes.
        """
        every = [np.asarray(each) for each in (cells if isinstance(cells, tuple) else [cells])]
        coordinates = np.asarray(coordinates, float)
        for each in every:
            if each.size and not (each.min() >= 0 and each.max() < n_nodes):
                raise InputError(f"cells name the nodes {each.min()} to {each.max()}, the mesh has 0 to {n_nodes - 1}")
        if coordinates.ndim != 2 or coordinates.shape[1] != n_nodes:
            raise InputError(f"coordinates of shape {coordinates.shape}: give (d, {n_nodes}), one column per node")
        diagonal = np.arange(n_nodes, dtype=np.int64) * (n_nodes + 1)
        keys = np.unique(np.concatenate([diagonal, *[_upper_keys(each, n_nodes).ravel() for each in every]]))
        rows, columns = np.divmod(keys[keys >= 0], n_nodes)
        indptr = np.searchsorted(rows, np.arange(n_nodes + 1))
        return cls(n_nodes, block, indptr.astype(np.int32), columns.astype(np.int32), coordinates)

    @property
    def n_blocks(self) -> int:
        """Number of stored blocks."""
        return self.indices.size

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the matrix."""
        return self.n_nodes * self.block, self.n_nodes * self.block

    @property
    def diagonal_slots(self) -> np.ndarray:
        """(n_nodes,) number of the diagonal block of each node."""
        return self.indptr[:-1]

    @cached_property
    def rows(self) -> np.ndarray:
        """(n_blocks,) int32 row of each block."""
        return np.repeat(np.arange(self.n_nodes, dtype=np.int32), np.diff(self.indptr))

    def slots(self, cells: np.ndarray) -> np.ndarray:
        """Where the blocks of each cell stand among the values.

        Parameters
        ----------
        cells : (m, n_cells) int array

        Returns
        -------
        (n_cells, m, m) int32 array
            Entry (c, a, b): number of the block (cells[a, c], cells[b, c]), or -1 below the diagonal.

        Raises
        ------
        InputError
            For two nodes of a cell which the pattern does not couple.
        """
        return self._at(_upper_keys(np.asarray(cells), self.n_nodes))

    def find(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Where blocks (rows, columns) of the upper triangle stand among the values, int32.

        Raises
        ------
        InputError
            For two nodes which the pattern does not couple.
        """
        return self._at(rows.astype(np.int64) * self.n_nodes + columns)

    def _at(self, wanted: np.ndarray) -> np.ndarray:
        """The same by keys, row * n_nodes + column; -1 for negative ones."""
        stored = self.rows.astype(np.int64) * self.n_nodes + self.indices
        found = np.minimum(np.searchsorted(stored, wanted), self.n_blocks - 1)
        strange = (wanted >= 0) & (stored[found] != wanted)
        if strange.any():
            pair = divmod(int(wanted[strange][0]), self.n_nodes)
            raise InputError(f"nodes {pair[0]} and {pair[1]} are not coupled in this pattern; build it from these cells")
        return np.where(wanted >= 0, found, -1).astype(np.int32)

    def sources(self, order: np.ndarray | None = None) -> sp.csr_matrix:
        """The full symmetric matrix as places among the stored values.

        Parameters
        ----------
        order : (n_nodes,) int array, optional
            ``order[k]`` is the node that comes to place k.

        Returns
        -------
        (n, n) csr_matrix of int64
            ``values.ravel()[sources.data]`` are the entries of the full matrix.
        """
        indptr, columns, slot = self._both_triangles(order)
        inside = np.arange(self.block**2).reshape(self.block, self.block)
        stored = np.where(slot < 0, ~slot, slot)[:, None, None] * self.block**2
        places = stored + np.where((slot < 0)[:, None, None], inside.T, inside)
        return sp.bsr_matrix((places, columns, indptr), shape=self.shape).tocsr()

    def neighbours(self) -> tuple[np.ndarray, np.ndarray]:
        """``indptr`` and ``indices`` of the whole graph, both triangles and the diagonal."""
        return self._both_triangles(None)[:2]

    def _both_triangles(self, order: np.ndarray | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and block numbers of the full matrix; ``~number`` for a block to be transposed."""
        slot = np.arange(self.n_blocks, dtype=np.int64)
        off = self.rows != self.indices
        rows = np.concatenate([self.rows, self.indices[off]])
        columns = np.concatenate([self.indices, self.rows[off]])
        if order is not None:
            place = np.empty(self.n_nodes, np.int32)
            place[order] = np.arange(self.n_nodes, dtype=np.int32)
            rows, columns = place[rows], place[columns]
        sort = np.lexsort((columns, rows))
        indptr = np.searchsorted(rows[sort], np.arange(self.n_nodes + 1)).astype(np.int32)
        return indptr, columns[sort], np.concatenate([slot, ~slot[off]])[sort]


def _upper_keys(cells: np.ndarray, n_nodes: int) -> np.ndarray:
    """(n_cells, m, m) int64: row * n_nodes + column for each pair of nodes of a cell, -1 below the diagonal."""
    nodes = np.ascontiguousarray(cells.T, dtype=np.int64)
    row, column = nodes[:, :, None], nodes[:, None, :]
    return np.where(row <= column, row * n_nodes + column, -1)
