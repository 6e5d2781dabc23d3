"""Supports that give way: springs, elastic foundations and dashpots."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, positive, unit_vector, vector
from skancf.functions import is_function, values_at
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL, POINTS
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, at_place
from skancf.showing import short
from skancf.supports.conditions import Support
from skancf.terms.protocols import Assembly


def check_factors(name: str, value: Any) -> None:
    """InputError unless it is a function, or three numbers of which none is negative and one is positive."""
    if is_function(value):
        return
    k = vector(name, value, 3)
    if (k < 0).any() or not k.any():
        raise InputError(f"{name} = {tuple(k.tolist())}: give factors that are not negative, and one of them is positive")


def factors_at(name: str, given: Any, at: np.ndarray, components: int | None = None) -> np.ndarray:
    """A constant or a function at points, nowhere negative."""
    k = values_at(name, given, at, components)
    if (k < 0).any():
        raise InputError(f"{name} = {k.min()} at a point: give a function of (x, y) that is nowhere negative")
    return k


def spring_matrices(table: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Matrices (m, 48, 48) of springs (m, n, 3, 3) at points where the local functions of r are (m, 16, n)."""
    return np.einsum("man,mnij,mbn->miajb", table, stiffness, table, optimize=True).reshape(-1, LOCAL, LOCAL)


def on_place(geometry: Geometry, where: Any, name: str, factors: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """Elements and matrices (m, 48, 48) of forces along x, y and z: per length on the edges of a place, at its points."""
    nodes, facets = geometry.points_and_facets(where)
    parts = []
    if len(facets):
        elements, points, lengths = geometry.edge_quadrature(facets)
        table = np.stack([geometry.theory.position_table(p)[0] for p in points])
        k = factors_at(name, factors, geometry.parameters(points, elements), 3)
        parts.append((elements, spring_matrices(table, np.einsum("mn,imn,ij->mnij", lengths, k, np.eye(3)))))
    for node in np.setdiff1d(nodes, geometry.ends(facets)):
        element, corner = geometry.corner_of(node)
        table = np.zeros((1, 16, 1))
        table[0, geometry.theory.rows[corner, 0]] = 1.0
        k = np.diag(factors_at(name, factors, geometry.points[:, [node]], 3)[:, 0])
        parts.append((np.array([element]), spring_matrices(table, k[None, None])))
    if not any(matrices.any() for _, matrices in parts):
        raise InputError(f"{name} is zero all over the place {where!r}, so that nothing acts there; give a function that is "
                         "positive somewhere")  # fmt: skip
    return parts


@by_value
@dataclass(frozen=True)
class Spring(Support):
    r"""Linear springs along the axes of space: at points (N/m), or along edges per length (N/m2).

    Their energy is :math:`\tfrac12 u \cdot k u` at a point, and its integral along an edge.

    Parameters
    ----------
    where
        Place, as for other supports.
    stiffness : (3,) or callable
        Along x, y and z: constant, or a function of the parameters (x, y) that returns (3, ...).

    Raises
    ------
    InputError
        For a factor that is negative or not finite, and where all are zero.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> strip = sk.Problem(
    ...     sk.Rectangle(1.0, 0.1), 0.01, steel,
    ...     supports=[sk.Clamp("left"), sk.Spring([(1.0, 0.05)], (0.0, 0.0, 1e4))],
    ...     loads=[sk.EdgeLoad("right", (0, 0, 100.0))],
    ... )
    >>> tip = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 2), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1000 * tip[2]:.4f} mm")
    0.6557 mm
    """

    where: Any
    stiffness: Any

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_factors("stiffness", self.stiffness)

    def springs(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        return on_place(assembly.geometry, self.where, "stiffness", self.stiffness)


@by_value
@dataclass(frozen=True)
class Dashpot(Support):
    r"""Linear dashpots along the axes of space: at points (N s/m), or along edges per length (N s/m2).

    Their force on the plate is :math:`-c v` at a point, and its integral along an edge: none at rest, so that in statics a
    dashpot holds nothing.

    Parameters
    ----------
    where
        Place, as for other supports.
    damping : (3,) or callable
        Along x, y and z: constant, or a function of the parameters (x, y) that returns (3, ...).

    Raises
    ------
    InputError
        For a factor that is negative or not finite, and where all are zero.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> strip = sk.Problem(
    ...     sk.Rectangle(1.0, 0.1), 0.01, steel,
    ...     supports=[sk.Clamp("left"), sk.Dashpot("right", (0.0, 0.0, 50.0))],
    ...     loads=[sk.Gravity()],
    ... )
    """

    where: Any
    damping: Any

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_factors("damping", self.damping)

    def dashpots(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        return on_place(assembly.geometry, self.where, "damping", self.damping)

    def singularities(self, geometry: Geometry) -> list[Singularity]:
        return at_place(geometry, self.where, self.holds, "a Dashpot", at_rest=False)


@by_value
@dataclass(frozen=True)
class Foundation(Support):
    r"""An elastic foundation (Winkler): a linear spring per area under the whole surface (N/m3).

    Its energy is :math:`\tfrac12 \int k (u \cdot d)^2 \, dA` with the undeformed normal, or a direction of space, d.

    Parameters
    ----------
    stiffness : float or callable
        k (N/m3): constant, or a function of the parameters (x, y), nowhere negative.
    direction : (3,), optional
        Default: the undeformed normal.

    Raises
    ------
    InputError
        For a stiffness that is not positive, and an invalid direction; on a mesh, for a function that is negative or not
        finite somewhere, or zero all over.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> slab = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Foundation(1e6), sk.Roller("left", (1, 0, 0)), sk.Roller("bottom", (0, 1, 0))],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> sunk = sk.solve_linear(slab.on(sk.meshes.uniform(slab.surface, 2, 2), "kirchhoff")).displacement((0.5, 0.5))
    >>> print(f"{1000 * sunk[2]:.4f} mm")  # p / k
    -1.0000 mm
    """

    stiffness: Any
    direction: tuple[float, float, float] | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not is_function(self.stiffness):
            positive("stiffness", self.stiffness, "N/m3")
        if self.direction is not None:
            unit_vector("direction", self.direction, "a foundation needs a direction in which it pushes")

    def springs(self, assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
        geometry, theory = assembly.geometry, assembly.geometry.theory
        integration, local = geometry.integration, geometry.undeformed_local
        if self.direction is None:
            d = integration.gathered(lambda points, e: theory.normals(local[e], points, geometry.side[e]))
            d = d / np.linalg.norm(d, axis=1, keepdims=True)
        else:
            d = np.broadcast_to(unit_vector("direction", self.direction)[:, None], (geometry.n_elements, AXES, POINTS))
        k = factors_at("stiffness", self.stiffness, geometry.parameters(integration.local))
        if not k.any():
            raise InputError("stiffness is zero all over the surface; give a function that is positive somewhere")
        stiffness = np.einsum("en,ein,ejn->enij", assembly.areas * k, d, d)
        table = integration.gathered(
            lambda points, e: np.broadcast_to(theory.position_table(points)[0], (len(e), FUNCTIONS, POINTS))
        )
        return [(np.arange(geometry.n_elements), spring_matrices(table, stiffness))]
