"""Dead forces per length, on edges and along lines."""

from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import skfem

from skancf.arguments import plain
from skancf.elements.quad_ancf import gauss
from skancf.equality import by_value
from skancf.errors import InputError, vector
from skancf.history import History
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity, at_place
from skancf.loads.acting import DeadLoad, Spread, check_distributed, values_at
from skancf.showing import short
from skancf.terms.protocols import Assembly
from skancf.tolerances import ONE_PLACE, PARALLEL_LINES


@by_value
@dataclass(frozen=True)
class EdgeLoad:
    """A dead force per undeformed length (N/m) along boundary edges; lengths are those of the surface itself.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (1e5, 0.0, 0.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> end = sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")).displacement((1.0, 0.05))
    >>> print(f"{1e6 * end[0]:.2f} micrometres")  # N L / E h
    47.62 micrometres
    """

    where: Any
    force: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_distributed(self.force, self.history)

    def on(self, assembly: Assembly) -> DeadLoad:
        geometry = assembly.geometry
        ends = partial(at_place, geometry, self.where, "force", "an EdgeLoad", single=False)
        return DeadLoad(self.spread(assembly).nodal(geometry), self.history, singular=ends)

    def spread(self, assembly: Assembly) -> Spread:
        """The forces at points of the edges."""
        return on_edges(assembly.geometry, self.where, self.force)


def on_edges(geometry: Geometry, where: Any, force: Any, name: str = "force") -> Spread:
    """What acts per length along the boundary edges of a place; errors call it ``name``."""
    elements, points, lengths = geometry.edge_quadrature(geometry.facets_on(where))
    forces = np.zeros((len(elements), 2, 3, lengths.shape[1]))
    forces[:, 0] = values_at(force, geometry.parameters(points, elements), name) * lengths[:, None]
    return Spread(elements, points, forces)


@by_value
@dataclass(frozen=True)
class LineLoad:
    """A dead force per undeformed length (N/m) along a straight line of the parameter plane.

    Parameters
    ----------
    start, end : (2,)
        Ends in the parameter plane. A closed parameter may run on beyond its bounds, across the seam.
    force : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).

    Raises
    ------
    InputError
        For a line without length, or one that leaves the surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> wall = sk.LineLoad(start=(0.0, 0.5), end=(1.0, 0.5), force=(0.0, 0.0, -200.0))
    >>> slab = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Clamp("boundary")], loads=[wall])
    >>> solution = sk.solve_linear(slab.on(sk.meshes.uniform(slab.surface, 4, 4), "kirchhoff"))
    >>> print(f"{solution.reactions()[2]:.4f} N")
    200.0000 N
    """

    start: tuple[float, float]
    end: tuple[float, float]
    force: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_distributed(self.force, self.history)
        if not np.any(vector("end", self.end, 2) - vector("start", self.start, 2)):
            raise InputError(f"start = end = {self.start}: a line needs two different ends")

    def on(self, assembly: Assembly) -> DeadLoad:
        at, spread = on_line(assembly.geometry, *self._ends, self.force)
        singular = [along_line(assembly.geometry, *self._ends, "a LineLoad")]
        return DeadLoad(spread.nodal(assembly.geometry), self.history, at.reshape(2, -1), singular)

    def spread(self, assembly: Assembly) -> Spread:
        """The forces at points of the line."""
        return on_line(assembly.geometry, *self._ends, self.force)[1]

    @property
    def _ends(self) -> tuple[np.ndarray, np.ndarray]:
        return np.asarray(self.start, float), np.asarray(self.end, float)


def on_line(
    geometry: Geometry, start: np.ndarray, end: np.ndarray, force: Any, leave: bool = False
) -> tuple[np.ndarray, Spread]:
    """Parameters (2, m, n) along a straight line, in m pieces of one element each, and what acts there per length.

    With ``leave`` the parts of the line that are outside the surface are left out; without it they are an error.
    """
    along = end - start
    cuts = _crossings(geometry, start, along) if along.any() else np.zeros(1)
    middle = start[:, None] + along[:, None] * (cuts[1:] + cuts[:-1]) / 2
    if leave:
        inside, elements, _ = geometry.locate_inside(middle)
    else:
        elements, inside = geometry.locate_all(middle)[0], np.ones(middle.shape[1], dtype=bool)
    s, w = gauss(4)
    first, piece = cuts[:-1][inside, None], np.diff(cuts)[inside, None]
    at = geometry.within(start[:, None, None] + along[:, None, None] * (first + piece * s))
    forces = np.zeros((len(elements), 2, 3, len(s)))
    if len(elements):
        slopes = np.stack(geometry.surface.derivatives(*at))
        lengths = piece * w * np.linalg.norm(np.tensordot(along, slopes, 1), axis=0)
        forces[:, 0] = values_at(force, at) * lengths[:, None]
    return at, Spread(elements, geometry.local_in(elements, at), forces)


def along_line(geometry: Geometry, start: np.ndarray, end: np.ndarray, words: str, moves: bool = False) -> Singularity:
    """A force per length along a straight line of the parameter plane."""
    line = np.column_stack([start, end])
    return Singularity("force", geometry.within(line), words, single=False, line=line, moves=moves)


def _crossings(geometry: Geometry, start: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Where a line (0 to 1) crosses edges of the mesh and of its copies beyond the seams, its ends included."""
    shifts = [np.zeros(1), np.zeros(1)]
    for axis, (low, high) in geometry.closed_bounds().items():
        turns = np.floor((np.array([start[axis], start[axis] + along[axis]]) - low) / (high - low))
        shifts[axis] = np.arange(turns.min(), turns.max() + 1) * (high - low)
    cuts = [_cuts(geometry.mesh, start - shift, along) for shift in product(*shifts)]
    return np.unique(np.round(np.concatenate([[0.0, 1.0], *cuts]), 12))


def _cuts(mesh: skfem.MeshQuad, start: np.ndarray, along: np.ndarray) -> np.ndarray:
    one, two = mesh.p[:, mesh.facets].swapaxes(0, 1)
    edge, offset = two - one, one - start[:, None]
    det = along[0] * edge[1] - along[1] * edge[0]
    crosses = np.abs(det) > PARALLEL_LINES * np.linalg.norm(along) * np.linalg.norm(edge, axis=0)
    edge, offset, det = edge[:, crosses], offset[:, crosses], det[crosses]
    on_line = (offset[0] * edge[1] - offset[1] * edge[0]) / det
    on_edge = (offset[0] * along[1] - offset[1] * along[0]) / det
    inside = (on_line > ONE_PLACE) & (on_line < 1 - ONE_PLACE) & (on_edge > -ONE_PLACE) & (on_edge < 1 + ONE_PLACE)
    return np.asarray(on_line[inside])
