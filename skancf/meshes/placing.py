"""Node positions along one direction of a graded mesh: an exact number of cells, nodes on the region centres."""

import numpy as np

from skancf.meshes.sizes import CellLine, Sizes
from skancf.tolerances import ONE_COUNT, ROOT

# Neighbouring cells never differ by more; a centre that would need it gets no node.
LARGEST_RATIO = 2.0
# Nor is any cell stretched or shrunk by more than this to move a node onto a centre.
LARGEST_STRETCH = 1.4


def place(sizes: Sizes, cells: int) -> np.ndarray:
    """Exactly ``cells`` cells, as close to the wanted lengths as that allows: (cells + 1,) increasing positions.

    The coarse length is scaled, and the fine ones with it, until the real count is ``cells``; nodes at whole counts
    then keep every ratio of neighbours within ``sizes.growth``. Where a region centre falls between two nodes, the
    cells on either side of it are stretched uniformly to move the nearest node there, as long as no two neighbours
    differ by more than ``LARGEST_RATIO`` and nothing is stretched by more than ``LARGEST_STRETCH``; where not every
    centre can have a node, stronger regions are served first.
    """
    if not sizes.centres.size:
        return np.linspace(sizes.low, sizes.high, cells + 1)
    line = sizes.line(coarse_for(sizes, cells))
    kept = np.array([])
    for centres in _strongest_first(sizes, line, cells):
        more = np.union1d(kept, centres)
        if _fits(line, more, cells):
            kept = more
    return _through(line, kept, cells)


def place_natural(sizes: Sizes, coarse: float) -> np.ndarray:
    """As many cells as the coarse length asks for, or one more where this gives more region centres a node."""
    cells = max(1, round(sizes.count(coarse)))
    choices = [place(sizes, cells), place(sizes, cells + 1)]
    return max(choices, key=lambda nodes: np.isin(sizes.centres, nodes).sum())


def coarse_for(sizes: Sizes, cells: float) -> float:
    """The coarse length with which the domain holds ``cells`` cells (a real number)."""
    from scipy.optimize import brentq  # not at the top: graded meshes alone need it, and it is slow to load

    # h lies between the finest fraction of the coarse length and the coarse length itself.
    shortest = (sizes.high - sizes.low) / cells
    longest = shortest / sizes.fractions.min(initial=1.0)

    def missing(coarse: float) -> float:
        return sizes.count(coarse) - cells

    return brentq(missing, 0.999 * shortest, 1.001 * longest, xtol=ROOT * shortest, rtol=ROOT)


def largest_ratio(nodes: np.ndarray) -> float:
    """The largest ratio of neighbouring lengths, at least 1."""
    steps = np.log(np.diff(nodes))
    return float(np.exp(np.abs(np.diff(steps)).max(initial=0.0)))


def _strongest_first(sizes: Sizes, line: CellLine, cells: int) -> list[np.ndarray]:
    """Groups of centres that shall have a node.

    A centre is the stronger the shorter its wanted length, and among equals the closer it is to a node. Centres that
    are equal in both, such as mirror images, form one group, so a symmetric problem keeps a symmetric mesh.
    """
    centres = sizes.centres[(sizes.centres > sizes.low) & (sizes.centres < sizes.high)]
    # Regions above each other have the same coordinate to rounding; they share a node.
    _, first = np.unique(np.round((centres - sizes.low) / (sizes.high - sizes.low), 9), return_index=True)
    centres = centres[first]
    s = line.cells_at(centres)
    lengths = line.h[np.searchsorted(line.x, centres)] / line.h.min()
    off = np.abs(s - np.rint(s))
    # Half a cell off in the very middle: either neighbour would break a symmetry.
    usable = ~((np.abs(s - cells / 2) < ONE_COUNT) & (off > 0.25))
    keys = np.round(np.stack([lengths, off])[:, usable] / ONE_COUNT)
    _, rank = np.unique(keys, axis=1, return_inverse=True)
    rank = np.ravel(rank)
    return [centres[usable][rank == r] for r in range(rank.max(initial=-1) + 1)]


def _fits(line: CellLine, centres: np.ndarray, cells: int) -> bool:
    """Can all of these centres have a node?"""
    numbers, x = _numbers(line, centres, cells)
    wanted, given = np.diff(line.cells_at(x)), np.diff(numbers)
    if (np.maximum(wanted, given) > LARGEST_STRETCH * np.minimum(wanted, given)).any():
        return False
    return largest_ratio(_through(line, centres, cells)) <= LARGEST_RATIO


def _through(line: CellLine, centres: np.ndarray, cells: int) -> np.ndarray:
    """Nodes with one on every centre."""
    numbers, x = _numbers(line, centres, cells)
    nodes = line.position(np.interp(np.arange(cells + 1), numbers, line.cells_at(x)))
    nodes[numbers] = x
    return nodes


def _numbers(line: CellLine, centres: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """The nearest nodes to both ends and the centres, by number, and where they shall lie."""
    x = np.concatenate([line.x[:1], centres, line.x[-1:]])
    s = line.cells_at(x)
    # Ties are rounded away from the middle, so that mirror images stay mirror images.
    return np.rint(s + ONE_COUNT * np.sign(s - cells / 2)).astype(int), x
