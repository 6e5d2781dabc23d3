"""Nested dissection: an order of elimination in which the factors stay sparse.

A part of the mesh is cut across its longest extent. The nodes along the cut are eliminated last, so that the two halves
never fill each other, and each half is cut again. Reference: A. George, Nested dissection of a regular finite element
mesh, SIAM J. Numer. Anal. 10 (1973) 345-363.
"""

import numpy as np

from skancf.linear import kernels
from skancf.linear.pattern import BlockPattern
from skancf.tolerances import TINY

# Below this many nodes cutting further saves nothing. Parts of 50 have a tenth more fill, on graded meshes a seventh.
LEAF = 8
# A cut between two mesh lines is preferred to the exact median when it leaves each half at least this share.
SMALLEST_SHARE = 0.3


def nested_dissection(pattern: BlockPattern, leaf: int = LEAF) -> np.ndarray:
    """Order of elimination of the nodes.

    Parameters
    ----------
    pattern : BlockPattern
    leaf : int
        Parts of at most this many nodes are not cut.

    Returns
    -------
    (n_nodes,) int64 array
        ``order[k]`` is the node eliminated as number k.
    """
    indptr, indices = pattern.neighbours()
    part = np.zeros(pattern.n_nodes, dtype=np.int64)
    order = np.empty(pattern.n_nodes, dtype=np.int64)
    last_part = 0
    waiting = [(np.arange(pattern.n_nodes), pattern.n_nodes)]
    while waiting:
        nodes, end = waiting.pop()
        if nodes.size <= leaf:
            order[end - nodes.size : end] = nodes
            continue
        lower, upper = _halves(nodes, pattern.coordinates[:, nodes])
        part[lower], part[upper] = last_part + 1, last_part + 2
        on_lower = kernels.touches(lower, indptr, indices, part, last_part + 2)
        on_upper = kernels.touches(upper, indptr, indices, part, last_part + 1)
        last_part += 2
        if np.count_nonzero(on_lower) <= np.count_nonzero(on_upper):
            separator, lower = lower[on_lower], lower[~on_lower]
        else:
            separator, upper = upper[on_upper], upper[~on_upper]
        part[separator] = 0
        order[end - separator.size : end] = separator
        end -= separator.size
        waiting += [(upper, end), (lower, end - upper.size)]
    return order


def fill(pattern: BlockPattern, order: np.ndarray) -> int:
    """Entries of the triangular factor, diagonal included, when nodes are eliminated in an ``order``."""
    place = np.empty(pattern.n_nodes, np.int64)
    place[order] = np.arange(pattern.n_nodes)
    below = kernels.column_counts(*pattern.neighbours(), order, place)
    block = pattern.block
    return int(block**2 * below.sum() + pattern.n_nodes * block * (block + 1) // 2)


def _halves(nodes: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """``nodes`` below and above a cut across the longest extent of their ``points``, shape (d, n)."""
    extent = np.ptp(points, axis=1)
    axis = int(np.argmax(extent))
    # Rounded, so that a mesh line whose points differ in the last digits is one line.
    along = np.round((points[axis] - points[axis].min()) / max(extent[axis], TINY), 6)
    sort = np.argsort(along, kind="stable")
    middle = nodes.size // 2
    line = along[sort[middle]]
    cuts = [int(np.searchsorted(along[sort], line, side)) for side in ("left", "right")]
    cut = min(cuts, key=lambda place: abs(place - middle))
    if not SMALLEST_SHARE <= cut / nodes.size <= 1 - SMALLEST_SHARE:
        cut = middle
    return nodes[sort[:cut]], nodes[sort[cut:]]
