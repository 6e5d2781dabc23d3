r"""What is eliminated: vectors that come from those of other blocks, :math:`q = T z`.

Nodes of a mesh that are one along a seam or at a pole, and those that hang in the middle of a larger element's edge, have no
unknowns of their own. A :class:`Map` says of every target from which blocks its vectors come; an extension across a cut edge
or a bond to a body would be maps too. Elements see the unknowns through triples made of it, for the compiled kernels.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
import skfem

from skancf.kernels.constants import FOURTH, R_X, VECTORS, R
from skancf.kernels.gather import Maps
from skancf.layout.hanging import Hanging
from skancf.layout.ties import Ties
from skancf.showing import short
from skancf.theories import Theory
from skancf.tolerances import ROUNDED_SUM


@dataclass(frozen=True, eq=False)
class Map:
    """Vectors of targets from those of blocks.

    Parameters
    ----------
    sources : (n_targets, s) int array
        Blocks on which each target depends, at most s.
    weights : (n_targets, s, 4, 4) array
        From the four vectors of each of these to those of the target; zero where there are fewer.
    n_blocks : int
        How many blocks there are.
    """

    sources: np.ndarray
    weights: np.ndarray
    n_blocks: int

    __repr__ = short

    @classmethod
    def of_mesh(cls, ties: Ties, hanging: Hanging) -> "Map":
        """That of the nodes of a mesh."""
        n, n_blocks = len(ties.node_of), len(ties.representative)
        own = cls(np.maximum(ties.node_of, 0)[:, None], ties.mix[:, None], n_blocks)
        if not len(hanging.nodes):
            return own
        sources = np.arange(n)[:, None].repeat(2, axis=1)
        weights = np.zeros((n, 2, VECTORS, VECTORS))
        weights[:, 0] = np.eye(VECTORS)
        sources[hanging.nodes], weights[hanging.nodes] = hanging.ends.T, hanging.weights.swapaxes(0, 1)
        return own.after(cls(sources, weights, n))

    def after(self, then: "Map") -> "Map":
        """The map of the targets of another one, whose blocks are the targets of this one."""
        n = len(then.sources)
        weights = then.weights[:, :, None] @ self.weights[then.sources]
        return Map(self.sources[then.sources].reshape(n, -1), weights.reshape(n, -1, VECTORS, VECTORS), self.n_blocks)

    def __call__(self, nodal: np.ndarray) -> np.ndarray:
        """Vectors (n_targets, 4, 3) of those of blocks (n_blocks, 4, 3)."""
        return np.asarray((self.weights @ nodal[self.sources]).sum(axis=1))

    @cached_property
    def matrix(self) -> sp.csr_matrix:
        """T for one component, (4 n_targets, 4 n_blocks)."""
        target, k, row, column = np.nonzero(self.weights)
        places = VECTORS * target + row, VECTORS * self.sources[target, k].astype(int) + column
        shape = VECTORS * len(self.sources), VECTORS * self.n_blocks
        return sp.csr_matrix((self.weights[target, k, row, column], places), shape=shape)


def local_maps(mesh: skfem.MeshQuad, jacobian: np.ndarray, theory: Theory, of_nodes: Map) -> Maps:
    """The triples of all elements; slopes go through the nodal Jacobian, r and d are taken as they are."""
    own = np.zeros((mesh.t.shape[1], 4, VECTORS, VECTORS))  # element, corner, local vector, vector at the mesh node
    own[:, :, R, R] = 1
    own[:, :, R_X:FOURTH, R_X:FOURTH] = jacobian.transpose(3, 2, 1, 0)
    own[:, :, FOURTH, FOURTH] = theory.fourth_factor(jacobian).T
    size = np.abs(jacobian).max(axis=(0, 1, 2))
    least = np.minimum(size, theory.fourth_factor(np.multiply.outer(np.eye(2), size)))
    own[np.abs(own) < ROUNDED_SUM * least[:, None, None, None]] = 0
    return element_maps(own, mesh.t.T, theory.rows, of_nodes)


def element_maps(own: np.ndarray, corners: np.ndarray, rows: np.ndarray, of_nodes: Map) -> Maps:
    """Triples of elements, whose local vectors come from those of their corners, and these from blocks.

    Parameters
    ----------
    own : (n_elements, 4, 4, 4) array
        From the vectors at each corner to the local ones there.
    corners : (n_elements, 4) int array
        Targets of the map.
    rows : (4, 4) int array
        The number of the local vectors.
    of_nodes : Map

    Returns
    -------
    Maps
        An element sees as many blocks as the one with the most; its corners' own where these are not eliminated.
    """
    n, s = len(corners), of_nodes.sources.shape[1]
    parts = (own[:, :, None] @ of_nodes.weights[corners]).reshape(n, 4 * s, VECTORS, VECTORS)
    sources = of_nodes.sources[corners].reshape(n, 4 * s)
    element, at, vector, kind = np.nonzero(parts)
    values, local = parts[element, at, vector, kind], rows[at // s, vector]
    nodes, columns = (sources, at) if s == 1 else _distinct(sources, parts.any(axis=(2, 3)), element, at)
    pointer = np.concatenate([[0], np.cumsum(np.bincount(element, minlength=n))])
    return Maps(
        np.ascontiguousarray(nodes, dtype=np.int32), pointer, local.astype(np.int32), columns.astype(np.int32),
        kind.astype(np.int32), values,
    )  # fmt: skip


def _distinct(sources: np.ndarray, used: np.ndarray, element: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each element's blocks once, (n_elements, width), and which of them entries (element, at) belong to."""
    n_blocks = int(sources.max()) + 1
    owner, place = np.nonzero(used)
    keys, inverse = np.unique(owner * n_blocks + sources[owner, place], return_inverse=True)
    owners, blocks = np.divmod(keys, n_blocks)
    first = np.searchsorted(owners, np.arange(len(sources) + 1))
    rank = np.arange(len(keys)) - first[owners]
    nodes = np.repeat(blocks[first[:-1]][:, None], int(rank.max()) + 1, axis=1)
    nodes[owners, rank] = blocks
    columns = np.zeros(sources.shape, dtype=int)
    columns[owner, place] = rank[inverse]
    return nodes, columns[element, at]
