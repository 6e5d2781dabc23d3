r"""Nodes in the middle of a larger element's edge: their nodal vectors are those of that edge.

With the ends 0 and 1 of an edge of the parameter vector s, along which t and across which n are directions of the
parameter plane, the cubic Hermite function gives at the middle

.. math::
    r = \tfrac12 (r_0 + r_1) + \tfrac18 |s| (r_{,t0} - r_{,t1}), \qquad
    r_{,t} = \tfrac{3}{2 |s|} (r_1 - r_0) - \tfrac14 (r_{,t0} + r_{,t1}).

On the bicubic element the same holds for the pair :math:`r_{,n}, r_{,nt}`: the field is C1 across the edge, and what the
larger elements can be, smaller ones can. In theory `full`, :math:`r_{,n}` and :math:`r_{,z}` are the means of the ends'.
For :math:`r_{,z}`, which is linear along an edge, nothing is lost by that; :math:`r_{,n}` of the larger element is a cubic
that depends on all its nodes, and only its linear part is kept.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.layout.layout import FOURTH, R_X, R_Y, R
from skancf.theories import Theory


@dataclass(frozen=True)
class Hanging:
    """Hanging nodes of a mesh.

    Attributes
    ----------
    nodes : (m,) int array
    ends : (2, m) int array
        Nodes of the mesh at the ends of the larger element's edge; they do not hang.
    weights : (2, m, 4, 4) array
        From the four vectors at each end to those of the node.
    """

    nodes: np.ndarray
    ends: np.ndarray
    weights: np.ndarray

    @classmethod
    def of(cls, mesh: Any, theory: Theory) -> "Hanging":
        """Those of a mesh; a conforming one has none."""
        nodes = np.asarray(getattr(mesh, "hanging", np.empty(0, dtype=int)))
        ends = np.asarray(getattr(mesh, "hanging_ends", np.empty((2, 0), dtype=int)))
        way = mesh.p[:, ends[1]] - mesh.p[:, ends[0]]
        along_x = np.abs(way[0]) > np.abs(way[1])
        return cls(nodes, ends, _weights(np.where(along_x, way[0], way[1]), along_x, theory.twist))


def _weights(way: np.ndarray, along_x: np.ndarray, twist: bool) -> np.ndarray:
    """Weights (2, m, 4, 4) of edges of signed lengths (m,) along x or y."""
    out = np.zeros((2, len(way), 4, 4))
    edge = np.arange(len(way))
    t, n = np.where(along_x, R_X, R_Y), np.where(along_x, R_Y, R_X)
    for end, sign in enumerate((1.0, -1.0)):
        for value, slope in ((R, t), (n, FOURTH)) if twist else ((R, t),):
            out[end, edge, value, value] = 0.5
            out[end, edge, value, slope] = sign * way / 8
            out[end, edge, slope, value] = -sign * 1.5 / way
            out[end, edge, slope, slope] = -0.25
        if not twist:
            out[end, edge, n, n] = out[end, edge, FOURTH, FOURTH] = 0.5
    return out
