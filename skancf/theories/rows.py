"""Conditions on the nodal vectors at a node, and what a theory has to know of the surface there to make them."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from skancf.kernels.constants import AXES, R_X, R_Y, VECTORS
from skancf.showing import short


class Row(NamedTuple):
    """One condition a . (e - e0) = value on the 12 coordinates e at a node of the mesh.

    Of a support with several functions of time there is a value for each.
    ``own`` says that at a pole e are r and the tangents that the pole has itself, not the slopes seen from that node.
    """

    node: int
    a: np.ndarray
    value: Any = 0.0
    own: bool = False

    def __repr__(self) -> str:
        return short(self)


class Spot(Protocol):
    """The undeformed surface at a node of the mesh."""

    @property
    def node(self) -> int: ...
    @property
    def normal(self) -> np.ndarray:
        """n, (3,)."""

    @property
    def normal_slopes(self) -> np.ndarray:
        """n_x and n_y, (2, 3)."""

    @property
    def slopes(self) -> np.ndarray:
        """r_x and r_y, (2, 3)."""

    @property
    def vectors(self) -> np.ndarray:
        """The slopes, or the two tangents that a pole has of its own: (2, 3)."""

    @property
    def own(self) -> bool:
        """Are those the tangents of a pole?"""

    def tangent(self, along: np.ndarray) -> np.ndarray:
        """Unit vector (3,) in space of a direction (2,) of the parameter plane."""


def condition(kinds: dict[int, Any], direction: np.ndarray) -> np.ndarray:
    """Coefficients (12,) of a combination of nodal vectors: each factor times the direction, or a vector of its own."""
    a = np.zeros((VECTORS, AXES))
    for kind, factor in kinds.items():
        a[kind] = factor if np.ndim(factor) else factor * direction
    return a.ravel()


def across(along: np.ndarray) -> int:
    """The nodal vector that is the slope across an edge along a parameter."""
    return R_X if abs(along[1]) > abs(along[0]) else R_Y
