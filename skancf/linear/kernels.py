"""Compiled loops over the blocks of a symmetric matrix; each has a plain twin in the tests."""

import numpy as np

from skancf.compiled import compiled


# Reassociation lets the inner sums use vector registers; nothing here tests for nan.
@compiled(nogil=True, fastmath={"reassoc", "contract", "nsz"})
def multiply(indptr: np.ndarray, indices: np.ndarray, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
    """y = A x from the upper triangle of blocks; x and y of shape (n_nodes, block)."""
    block = values.shape[1]
    y[:] = 0.0
    for i in range(indptr.size - 1):
        first = indptr[i]
        for a in range(block):
            total = 0.0
            for c in range(block):
                total += values[first, a, c] * x[i, c]
            y[i, a] += total
        for slot in range(first + 1, indptr[i + 1]):
            j = indices[slot]
            for a in range(block):
                total = 0.0
                left = x[i, a]
                for c in range(block):
                    total += values[slot, a, c] * x[j, c]
                    y[j, c] += values[slot, a, c] * left
                y[i, a] += total


@compiled(nogil=True)
def scale_blocks(
    indptr: np.ndarray,
    indices: np.ndarray,
    values: np.ndarray,
    rotated: np.ndarray,
    scale: np.ndarray,
    out: np.ndarray,
) -> int:
    """``out`` = S A S with a one on the diagonal where ``scale`` is zero.

    A block marked in ``rotated`` already stands in ``out`` and is scaled in place, the others are read from ``values``.
    Returns the number of the first block with an entry that is not finite, or -1.
    """
    block = values.shape[1]
    for i in range(indptr.size - 1):
        for slot in range(indptr[i], indptr[i + 1]):
            j = indices[slot]
            source = out if rotated[slot] else values
            total = 0.0
            for a in range(block):
                for c in range(block):
                    entry = scale[i, a] * source[slot, a, c] * scale[j, c]
                    total += entry
                    out[slot, a, c] = entry
            if not np.isfinite(total):
                return slot
        for a in range(block):
            if scale[i, a] == 0.0:
                out[indptr[i], a, a] = 1.0
    return -1


@compiled(nogil=True)
def touches(nodes: np.ndarray, indptr: np.ndarray, indices: np.ndarray, part: np.ndarray, other: int) -> np.ndarray:
    """Mask over ``nodes``: has a neighbour of which ``part`` is ``other``."""
    mask = np.zeros(nodes.size, np.bool_)
    for k in range(nodes.size):
        for entry in range(indptr[nodes[k]], indptr[nodes[k] + 1]):
            if part[indices[entry]] == other:
                mask[k] = True
                break
    return mask


@compiled(nogil=True)
def upper_pattern(indptr: np.ndarray, indices: np.ndarray, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Compressed rows of the upper triangle of entries."""
    n_nodes = indptr.size - 1
    starts = np.empty(n_nodes * block + 1, np.int64)
    starts[0] = 0
    for i in range(n_nodes):
        for a in range(block):
            starts[i * block + a + 1] = starts[i * block + a] + (indptr[i + 1] - indptr[i]) * block - a
    columns = np.empty(starts[-1], np.int32)
    for i in range(n_nodes):
        for a in range(block):
            place = starts[i * block + a]
            for slot in range(indptr[i], indptr[i + 1]):
                for c in range(a if slot == indptr[i] else 0, block):
                    columns[place] = indices[slot] * block + c
                    place += 1
    return starts, columns


@compiled(nogil=True)
def upper_entries(indptr: np.ndarray, values: np.ndarray, out: np.ndarray) -> None:
    """Entries of the upper triangle, row by row as :func:`upper_pattern` has them."""
    block = values.shape[1]
    place = 0
    for i in range(indptr.size - 1):
        for a in range(block):
            for slot in range(indptr[i], indptr[i + 1]):
                for c in range(a if slot == indptr[i] else 0, block):
                    out[place] = values[slot, a, c]
                    place += 1


@compiled(nogil=True)
def column_counts(indptr: np.ndarray, indices: np.ndarray, order: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Entries below the diagonal in each column of the factor, nodes in ``order``, of which ``place`` is the inverse.

    Row k of the factor has an entry in every column on the way up the elimination tree from an entry of row k. Reference:
    J. Liu, The role of elimination trees in sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990) 134-172.
    """
    parent = np.full(order.size, -1, np.int64)
    seen = np.full(order.size, -1, np.int64)
    counts = np.zeros(order.size, np.int64)
    for k in range(order.size):
        seen[k] = k
        for entry in range(indptr[order[k]], indptr[order[k] + 1]):
            column = place[indices[entry]]
            while column < k and seen[column] != k:
                if parent[column] < 0:
                    parent[column] = k
                counts[column] += 1
                seen[column] = k
                column = parent[column]
    return counts
