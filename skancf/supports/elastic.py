"""Supports that give way: springs, elastic foundations and dashpots."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.assembly.geometry import Geometry
from skancf.assembly.protocols import Assembly
from skancf.errors import InputError, positive, unit_vector, vector
from skancf.supports.conditions import Support


def not_negative(name: str, value: Any) -> np.ndarray:
    """Three numbers along x, y and z, none of which is negative."""
    k = vector(name, value, 3)
    if (k < 0).any() or not k.any():
        raise InputError(f"{name} = {tuple(k.tolist())}: give factors that are not negative, and one of them is positive")
    return k


def spring_matrices(table: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Matrices (m, 48, 48) of springs (m, n, 3, 3) at points where the local functions of r are (m, 16, n)."""
    return np.einsum("man,mnij,mbn->miajb", table, stiffness, table, optimize=True).reshape(-1, 48, 48)


def on_place(geometry: Geometry, where: Any, factors: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """Elements and matrices (m, 48, 48) of forces along x, y and z: per length on the edges of a place, at its points."""
    k = np.diag(factors)
    nodes, facets = geometry.points_and_facets(where)
    parts = []
    if len(facets):
        elements, points, lengths = geometry.edge_quadrature(facets)
        table = np.stack([geometry.theory.position_table(p)[0] for p in points])
        parts.append((elements, spring_matrices(table, lengths[:, :, None, None] * k)))
    alone = np.setdiff1d(nodes, geometry.ends(facets))
    for node in alone:
        element, corner = geometry.corner_of(node)
        table = np.zeros((1, 16, 1))
        table[0, geometry.theory.rows[corner, 0]] = 1.0
        parts.append((np.array([element]), spring_matrices(table, k[None, None])))
    return parts


@dataclass(frozen=True)
class Spring(Support):
    r"""Linear springs along the axes of space: at points (N/m), or along edges per length (N/m2).

    Their energy is :math:`\tfrac12 u \cdot k u` at a point, and its integral along an edge.

    Parameters
    ----------
    where
        Place, as for other supports.
    stiffness : (3,)
        Along x, y and z.
    """

    where: Any
    stiffness: tuple[float, float, float]

    def __post_init__(self) -> None:
        not_negative("stiffness", self.stiffness)

    def springs(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        return on_place(assembly.geometry, self.where, self.stiffness)


@dataclass(frozen=True)
class Dashpot(Support):
    r"""Linear dashpots along the axes of space: at points (N s/m), or along edges per length (N s/m2).

    Their force on the plate is :math:`-c v` at a point, and its integral along an edge: none at rest, so that in statics a
    dashpot holds nothing.

    Parameters
    ----------
    where
        Place, as for other supports.
    damping : (3,)
        Along x, y and z.

    Raises
    ------
    InputError
        For a factor that is negative or not finite, and where all are zero.
    """

    where: Any
    damping: tuple[float, float, float]

    def __post_init__(self) -> None:
        not_negative("damping", self.damping)

    def dashpots(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        return on_place(assembly.geometry, self.where, self.damping)


@dataclass(frozen=True)
class Foundation(Support):
    r"""An elastic foundation (Winkler): a linear spring per area under the whole surface (N/m3).

    Its energy is :math:`\tfrac12 \int k (u \cdot d)^2 \, dA` with the undeformed normal, or a direction of space, d.

    Parameters
    ----------
    stiffness : float
        k (N/m3).
    direction : (3,), optional
        Default: the undeformed normal.
    """

    stiffness: float
    direction: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        positive("stiffness", self.stiffness, "N/m3")
        if self.direction is not None:
            unit_vector("direction", self.direction, "a foundation needs a direction in which it pushes")

    def springs(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        geometry, theory = assembly.geometry, assembly.geometry.theory
        points = theory.quadrature[0]
        if self.direction is None:
            d = theory.normals(geometry.undeformed_local, points, geometry.side)
            d = d / np.linalg.norm(d, axis=1, keepdims=True)
        else:
            d = np.broadcast_to(unit_vector("direction", self.direction)[:, None], (geometry.n_elements, 3, points.shape[1]))
        stiffness = self.stiffness * np.einsum("en,ein,ejn->enij", assembly.areas, d, d)
        table = np.broadcast_to(theory.position_table(points)[0], (geometry.n_elements, 16, points.shape[1]))
        return [(np.arange(geometry.n_elements), spring_matrices(table, stiffness))]
