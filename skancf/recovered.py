r"""Section forces and stresses of theory `full` where its elements do not say them well: at their corners and edges.

The director d is bilinear, so that its slopes are of first order there, and of second order in the middles of elements. What
they make of a section force or a stress is taken from polynomials through the middles (:class:`Patches`),

.. math:: s^*(x) = s(x) + P[s_d](x) - s_d(x), \qquad s_d: \text{the part of } e^1, e^2,

the rest, of membrane strain, thickness strain and temperature, as the element has it. No polynomial reaches across a line or
about a point where moments may jump or have no limit: supports and loads inside the surface, re-entrant corners, ends of
supported edges.
"""

from collections.abc import Iterator
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from skancf.assembly.full.assembly import BENDING, FullAssembly
from skancf.assembly.geometry import Geometry
from skancf.assembly.patches import STENCIL, Patches
from skancf.assembly.places import NONE
from skancf.assembly.system import System
from skancf.errors import InputError, finite

ON = 1e-8
"""Of the extent of the mesh: nodes this near to a line or a point are on it."""
TURNS_IN = np.radians(210)
"""Material about a node of the boundary beyond which it is a re-entrant corner, not a vertex of a curved hole's polygon."""
_patches: "WeakKeyDictionary[System, Patches]" = WeakKeyDictionary()


def patches_of(system: System) -> Patches:
    """Those of all elements, kept as long as the system is."""
    if system not in _patches:
        _patches[system] = Patches.about(system.geometry, cuts(system))
    return _patches[system]


def section_forces(
    system: System, q: np.ndarray, points: np.ndarray, factor: float = 1.0, time: float | None = None
) -> np.ndarray:
    """N and M (n_elements, 6, n) as :meth:`System.section_forces` has them; in theory `full` recovered."""
    raw, assembly = system.section_forces(q, points, factor, time), system.assembly
    if not isinstance(assembly, FullAssembly):
        return raw
    nodal = q.reshape(-1, 4, 3)
    said = assembly.bending_forces(nodal, system.geometry.inside(STENCIL))
    return np.asarray(raw + patches_of(system).values(said, points) - assembly.bending_forces(nodal, points))


def bending_excess(system: System, q: np.ndarray, points: np.ndarray, z: float) -> np.ndarray:
    """What recovery adds to the strains at a depth, (n_elements, n, 6); zero in theory `kirchhoff`."""
    assembly = system.assembly
    if not isinstance(assembly, FullAssembly):
        return np.zeros((system.geometry.n_elements, points.shape[1], 6))
    nodal = q.reshape(-1, 4, 3)
    said = assembly.bending_strains(nodal, system.geometry.inside(STENCIL), z).swapaxes(1, 2)
    return np.asarray(patches_of(system).values(said, points).swapaxes(1, 2) - assembly.bending_strains(nodal, points, z))


def gradient(
    system: System, q: np.ndarray, element: int, point: np.ndarray, weights: np.ndarray
) -> np.ndarray:  # fmt: skip
    """Derivative (n_dofs,) of weights (6,) times the section forces at a local point (2, 1) of an element."""
    assembly, nodal, here, ones = system.assembly, q.reshape(-1, 4, 3), np.array([element]), weights.reshape(1, 6, 1)
    out = assembly.section_force_gradient(nodal, here, point, ones)
    if isinstance(assembly, FullAssembly):
        patch = Patches.about(system.geometry, cuts(system), here)
        members, said = patch.transposed(point, ones)
        inside = system.geometry.inside(STENCIL)
        out = out + assembly.section_force_gradient(nodal, members, inside, said, BENDING)
        out = out - assembly.section_force_gradient(nodal, here, point, ones, BENDING)
    return np.asarray(out).ravel()


def cuts(system: System) -> np.ndarray:
    """Facets of the mesh across which moments may jump or have a kink, or which end where they may have no limit."""
    geometry = system.geometry
    mesh = geometry.mesh
    broken = np.zeros(mesh.facets.shape[1], dtype=bool)
    for support in system.problem.supports:
        if hasattr(support, "where"):
            broken |= _along_support(geometry, support.where)
    points = [mesh.p[:, np.isin(geometry.ties.node_of, list(reentrant_corners(geometry)))]]
    for load in system.problem.loads:
        if hasattr(load, "start") and not callable(load.start):
            broken |= _along(geometry, finite("start", load.start), finite("end", load.end))
        points += [place[:, None] for place in _points(load)]
    for point in np.hstack(points).T:
        broken |= _near(geometry, point - mesh.p.T).T[mesh.facets].any(axis=0)
    return np.flatnonzero(broken)


def _along_support(geometry: Geometry, where: Any) -> np.ndarray:
    """Facets between held nodes inside the surface, unless all about them is held, and those at ends of held edges."""
    mesh, node_of = geometry.mesh, geometry.ties.node_of
    try:
        nodes, facets = geometry.points_and_facets(where)
    except InputError:
        return np.zeros(mesh.facets.shape[1], dtype=bool)
    # A hanging node is held where the ends of its edge are.
    held = np.isin(node_of, nodes)
    held[geometry.hanging.nodes] = held[geometry.hanging.ends].all(axis=0)
    whole, beside_free = held[mesh.t].all(axis=0), np.zeros(mesh.facets.shape[1], dtype=bool)
    beside_free[mesh.t2f[:, ~whole]] = True
    along = held[mesh.facets].all(axis=0) & beside_free
    ends = node_of[mesh.facets[:, facets]] if len(facets) else np.empty((2, 0), dtype=int)
    once = np.flatnonzero(np.bincount(ends[ends >= 0].ravel(), minlength=geometry.n_nodes) == 1)
    alone = np.setdiff1d(nodes, ends) if not whole.any() and not along.any() else NONE
    return along | np.isin(node_of[mesh.facets], np.concatenate([once, alone])).any(axis=0)


def _along(geometry: Geometry, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Facets on a straight line of the parameter plane."""
    way, p = end - start, geometry.mesh.p.T
    share = np.clip(((p - start) @ way) / (way @ way), 0.0, 1.0)
    return np.asarray(_near(geometry, start + share[:, None] * way - p)[geometry.mesh.facets].all(axis=0))


def _near(geometry: Geometry, apart: np.ndarray) -> np.ndarray:
    """Which differences (n, 2) of places are none, across a seam too."""
    extent = np.ptp(geometry.mesh.p, axis=1)
    for axis, (low, high) in geometry.closed_bounds().items():
        apart[:, axis] -= (high - low) * np.round(apart[:, axis] / (high - low))
    return np.asarray(np.abs(apart / extent).max(axis=1) < ON)


def _points(load: Any) -> Iterator[np.ndarray]:
    """Where a load acts at single points."""
    if hasattr(load, "at") and not callable(load.at) and not hasattr(load, "radius"):
        yield finite("at", load.at)


def reentrant_corners(geometry: Geometry) -> dict[int, float]:
    """Nodes of the boundary at which it turns inwards, and the angle of material there in the parameter plane (rad)."""
    corners = geometry.mesh.p[:, geometry.mesh.t]
    after, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross, dot = after[0] * before[1] - after[1] * before[0], (after * before).sum(axis=0)
    nodes, here = geometry.ties.node_of[geometry.mesh.t], np.abs(np.arctan2(cross, dot))
    own = nodes >= 0  # hanging nodes are no corners
    angles = np.bincount(nodes[own], here[own], minlength=geometry.n_nodes)
    # At a pole the angles of the parameter plane are not those of the surface.
    on_boundary = np.setdiff1d(geometry.ends(geometry.boundary), list(geometry.ties.poles))
    return {int(node): float(angles[node]) for node in on_boundary if angles[node] > TURNS_IN}
