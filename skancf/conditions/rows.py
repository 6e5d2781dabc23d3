"""Rows of weights of vectors, and the blocks that they reach."""

from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from skancf.kernels.constants import AXES, VECTORS
from skancf.layout.layout import Layout


def in_space(rows: sp.csr_matrix) -> sp.csr_matrix:
    """Rows (3 m, n_dofs) of each component of weights (m, 4 n_blocks) of nodal vectors."""
    return sp.csr_matrix(sp.kron(rows, sp.eye(AXES), format="csr"))


def cells_of(rows: sp.csr_matrix) -> np.ndarray:
    """Cells (m, k) of the blocks that weights (m, 4 n_blocks) of nodal vectors reach; shorter ones repeat a block."""
    each = [np.unique(rows.indices[a:b] // VECTORS) for a, b in pairwise(rows.indptr)]
    each = [blocks for blocks in each if blocks.size]
    if not each:
        return np.empty((0, 1), dtype=int)
    width = max(map(len, each))
    padded = np.array([np.concatenate([blocks, np.full(width - len(blocks), blocks[0])]) for blocks in each])
    return np.unique(padded, axis=0)


def extent_of(layout: Layout) -> float:
    """Largest extent of the undeformed body along an axis (m)."""
    return float(np.ptp(layout.positions(layout.undeformed), axis=0).max())
