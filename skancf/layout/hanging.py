"""Nodes in the middle of a larger element's edge: their nodal vectors are those of that edge, as the theory has them (see
:mod:`skancf.theories.edges`)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.showing import short
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

    __repr__ = short

    @classmethod
    def of(cls, mesh: Any, theory: Theory) -> "Hanging":
        """Those of a mesh; a conforming one has none."""
        nodes = np.asarray(getattr(mesh, "hanging", np.empty(0, dtype=int)))
        ends = np.asarray(getattr(mesh, "hanging_ends", np.empty((2, 0), dtype=int)))
        way = mesh.p[:, ends[1]] - mesh.p[:, ends[0]]
        along_x = np.abs(way[0]) > np.abs(way[1])
        return cls(nodes, ends, theory.hanging_weights(np.where(along_x, way[0], way[1]), along_x))
