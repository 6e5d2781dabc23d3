"""A state as a surface of small linear quadrilaterals, for viewers that know no cubic plate elements."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skancf.arguments import whole
from skancf.materials.heights import Depth, depth_of
from skancf.memory import require_much
from skancf.showing import short
from skancf.solution import Solution
from skancf.states import StateLike, solution_of


class Grid(NamedTuple):
    """The reference square cut into k x k cells.

    Attributes
    ----------
    points : (2, (k + 1)^2) array
    cells : (k^2, 4) int array
        Point numbers, counter-clockwise in (xi, eta).
    rim : (4 k + 1,) int array
        Point numbers around the square, the first one again at the end.
    """

    points: np.ndarray
    cells: np.ndarray
    rim: np.ndarray

    def __repr__(self) -> str:
        return short(self)


@dataclass(frozen=True)
class SampledSurface:
    """A state at one depth, sampled. Points are not shared between elements, because stress jumps there.

    Attributes
    ----------
    points : (n, 3) array
        Deformed positions (m).
    cells : (m, 4) int array
    elements : (m,) int array
        The element that each cell is part of.
    rims : (n_elements, 4 k + 1) int array
        Points around each element: its curved edges.
    displacement : (n, 3) array
        Distance from the mid-surface (m).
    velocity : (n, 3) array or None
        m/s.
    """

    points: np.ndarray
    cells: np.ndarray
    elements: np.ndarray
    rims: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray | None

    __repr__ = short


@dataclass(frozen=True)
class Samples(SampledSurface):
    """A sampled state with its strain and stress.

    Attributes
    ----------
    strain : (n, 6) array
        Green-Lagrange strain in the local frame, order 11, 22, 33, 23, 13, 12, shear strains doubled.
    stress : (n, 6) array
        Second Piola-Kirchhoff stress in the local frame, same order (Pa).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> found = sk.output.sample(sk.solve_linear(system), z="bottom")
    >>> print(found.strain.shape[1], found.displacement.shape[1])
    6 3
    """

    strain: np.ndarray
    stress: np.ndarray

    __repr__ = short


def grid(subdivisions: int) -> Grid:
    """The reference square cut into ``subdivisions`` squared cells."""
    k = whole("subdivisions", subdivisions)
    require_points(k, 1)
    eta, xi = np.meshgrid(*[np.linspace(0, 1, k + 1)] * 2, indexing="ij")
    number = np.arange((k + 1) ** 2).reshape(k + 1, k + 1)
    corners = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    rim = (number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[::-1, 0])
    return Grid(
        points=np.stack([xi.ravel(), eta.ravel()]),
        cells=np.stack([corner.ravel() for corner in corners], axis=1),
        rim=np.concatenate(rim),
    )


def require_points(subdivisions: int, n_elements: int) -> None:
    """Refuse a number of cells along an element's edge whose points would not fit into memory."""
    n = n_elements * (whole("subdivisions", subdivisions) + 1) ** 2
    require_much(EACH * n, f"subdivisions = {subdivisions}", f"a surface of {n} points", "take fewer")


EACH = 300
"""Bytes of a point with its cell, displacement, strain and stress."""


def sample_surface(solution: StateLike, subdivisions: int = 4, z: Depth = 0.0) -> SampledSurface:
    """Positions, displacements and velocities of a state; see :func:`sample`."""
    solution = solution_of("solution", solution)
    require_points(subdivisions, solution.system.geometry.n_elements)
    cut, geometry = grid(subdivisions), solution.system.geometry
    first = np.arange(geometry.n_elements)[:, None] * cut.points.shape[1]
    theory, side = geometry.theory, geometry.side
    inside, table = geometry.inside(cut.points), geometry.theory.position_table(cut.points)[0]
    depth = depth_of(solution.system.assembly.section.at(cut.points), z)
    away, heights = bool(np.any(depth)), depth[:, None] if np.ndim(depth) else depth

    def at_depth(vectors: np.ndarray, normals: np.ndarray | float) -> np.ndarray:
        middle = np.einsum("an,eai->ein", table, vectors, optimize=True)
        return np.asarray((middle + heights * normals).swapaxes(1, 2).reshape(-1, 3))

    def local(q: np.ndarray) -> np.ndarray:
        return np.asarray(geometry.local(solution.system.shell.nodal(q)))

    def position(q: np.ndarray) -> np.ndarray:
        return at_depth(local(q), theory.normals(local(q), inside, side) if away else 0.0)

    def rate(q: np.ndarray, change: np.ndarray) -> np.ndarray:
        return at_depth(local(change), theory.normal_rates(local(q), local(change), inside, side) if away else 0.0)

    places = position(solution.system.undeformed)
    displacement = solution.model.rise(position, solution.unknowns, rate)
    velocity = None if solution.velocity is None else rate(solution.q, solution.velocity)
    return SampledSurface(
        points=places + displacement,
        cells=(first[:, :, None] + cut.cells).reshape(-1, 4),
        elements=np.repeat(np.arange(geometry.n_elements), len(cut.cells)),
        rims=first + cut.rim,
        displacement=displacement,
        velocity=velocity,
    )


def sample_strain(solution: StateLike, subdivisions: int = 4, z: Depth = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Strain and stress (n, 6) at the points of :func:`sample`, in theory `full` recovered: see
    :meth:`Solution.recovered_section_forces`."""
    solution = solution_of("solution", solution)
    require_points(subdivisions, solution.system.geometry.n_elements)
    points = grid(subdivisions).points
    return solution.recovered_strains(points, z).reshape(-1, 6), solution.recovered_stresses(points, z).reshape(-1, 6)


def sample(solution: Solution, subdivisions: int = 4, z: Depth = 0.0) -> Samples:
    """A state at depth z, each element cut into ``subdivisions`` squared linear quadrilaterals.

    Parameters
    ----------
    solution : Solution
    subdivisions : int
        Cells along an element's edge, at least 1.
    z : float or {"top", "middle", "bottom"}
        Depth, from the bottom face to the top face (m). Default: the reference surface, z = 0, where bending leaves no
        strain, and no stress in a plate of one material; give a face, ``"top"`` or ``"bottom"``, for what it does there.

    Returns
    -------
    Samples

    Raises
    ------
    InputError
        For subdivisions that are no positive whole number and a depth outside the plate.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> found = sk.output.sample(sk.solve_linear(system), subdivisions=2, z="top")
    >>> print(found.points.shape, found.stress.shape)
    (324, 3) (324, 6)
    """
    strain, stress = sample_strain(solution, subdivisions, z)
    return Samples(**vars(sample_surface(solution, subdivisions, z)), strain=strain, stress=stress)
