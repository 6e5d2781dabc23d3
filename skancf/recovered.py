r"""Moments and stresses of theory `full` where its elements do not say them well: at their corners and edges.

The director d is bilinear, so that curvatures are of first order there, and of second order in the middles of elements. What
its slopes make of moments is taken from polynomials through the middles (:class:`Patches`). Where the section couples
stretch and bending, membrane strains follow the curvatures of their element, so that its membrane forces are kept:

.. math:: \Delta s = P[s_d] - s_d, \qquad N^* = N, \quad M^* = M + \Delta M - B A^{-1} \Delta N,

with the part :math:`s_d = (N_d, M_d)` of the section forces that slopes of the director make. No polynomial reaches across a
line or about a point where moments may jump or have no limit: supports and loads inside the surface, borders of zones,
re-entrant corners, ends of supported edges.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from skancf.history import FULL, Case
from skancf.layout.geometry import Geometry
from skancf.layout.patches import STENCIL, Cuts, Patches
from skancf.layout.places import NONE
from skancf.layout.singularities import Singularity, nodes_at
from skancf.materials import Section
from skancf.materials.heights import Depth, depth_of
from skancf.system.regularity import singularities
from skancf.system.system import System
from skancf.terms.shells.full import BENDING
from skancf.tolerances import SAME_POINT

IN_PLANE = [0, 1, 5]
TURNS_IN = np.radians(210)
"""Material about a node of the boundary beyond which it is a re-entrant corner, not a vertex of a curved hole's polygon."""
_patches: "WeakKeyDictionary[System, Patches]" = WeakKeyDictionary()


def patches_of(system: System) -> Patches:
    """Those of all elements, kept as long as the system is."""
    if system not in _patches:
        _patches[system] = Patches.about(system.geometry, cuts(system))
    return _patches[system]


def section_forces(
    system: System,
    q: np.ndarray,
    points: np.ndarray,
    case: Case = FULL,
    small: bool = False,
    elements: np.ndarray | None = None,
) -> np.ndarray:
    """N and M (m, 6, n) as :meth:`System.section_forces` has them; in theory `full` recovered."""
    raw = system.shell.section_forces(q, points, case, small, elements)
    if system.assembly.recovers_bending:
        forces, moments = np.split(_excess(system, q, points, elements), 2, axis=1)
        coupled = _coupled(system.assembly.section.at(points, elements))[1]
        raw[:, 3:] += moments - np.einsum(f"{'ep' * (coupled.ndim > 2)}ji,eip->ejp", coupled, forces)
    return raw


def strain_excess(
    system: System, q: np.ndarray, points: np.ndarray, z: Depth, elements: np.ndarray | None = None
) -> np.ndarray:
    """What recovery adds to the strains at a depth, (m, n, 6); zero in theory `kirchhoff`."""
    assembly: Any = system.assembly
    if not assembly.recovers_bending:
        return np.zeros((system.geometry.n_elements if elements is None else len(elements), points.shape[1], 6))
    nodal = system.shell.nodal(q)

    def bending(at: np.ndarray, some: np.ndarray | None = None) -> np.ndarray:
        return np.asarray(assembly.bending_strains(nodal, at, depth_of(assembly.section.at(at, some), z), some))

    patches = patches_of(system)
    needed = None if elements is None else patches.need(elements)
    said = bending(system.geometry.inside(STENCIL), needed).swapaxes(1, 2)
    out = patches.values(said, points, elements).swapaxes(1, 2) - bending(points, elements)
    forces = _excess(system, q, points, elements)[:, :3]
    compliance = _coupled(assembly.section.at(points, elements))[0]
    out[..., IN_PLANE] -= np.einsum(f"{'ep' * (compliance.ndim > 2)}ij,ejp->epi", compliance, forces)
    return np.asarray(out)


def gradient(
    system: System, q: np.ndarray, element: int, point: np.ndarray, weights: np.ndarray, case: Case | None = None
) -> np.ndarray:
    """Derivative (n_dofs,) of weights (6,) times the recovered section forces at a local point (2, 1) of an element, in a
    case where heat is inside the law; None in answers to first order."""
    assembly: Any = system.assembly if case is None else system.shell.at(case)
    nodal, here = system.shell.nodal(q), np.array([element])
    out = assembly.section_force_gradient(nodal, here, point, weights.reshape(1, 6, 1))
    if assembly.recovers_bending:
        coupled = _coupled(assembly.section.at(point, here))[1].reshape(3, 3)
        changed = np.concatenate([-coupled.T @ weights[3:], weights[3:]]).reshape(1, 6, 1)
        members, said = Patches.about(system.geometry, cuts(system), here).transposed(point, changed)
        stencil = system.geometry.inside(STENCIL)
        out = out + assembly.section_force_gradient(nodal, members, stencil, said, BENDING)
        out = out - assembly.section_force_gradient(nodal, here, point, changed, BENDING)
    return system.shell.flat(np.asarray(out))


def _excess(system: System, q: np.ndarray, points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
    """Polynomials of what slopes of the director make of the section forces, less that itself: (m, 6, n)."""
    assembly: Any = system.assembly
    nodal = system.shell.nodal(q)
    patches = patches_of(system)
    needed = None if elements is None else patches.need(elements)
    said = assembly.bending_forces(nodal, system.geometry.inside(STENCIL), needed)
    recovered = patches.values(said, points, elements)
    return np.asarray(recovered - assembly.bending_forces(nodal, points, elements))


def _coupled(section: Section) -> tuple[np.ndarray, np.ndarray]:
    """The inverse of A, and B A^-1, of the laws as the elements have them, (3, 3) each."""
    z, w, laws = section.through(2)
    laws = laws[..., IN_PLANE, :][..., IN_PLANE]
    inverse = np.linalg.inv(np.einsum("z...,z...ij->...ij", w, laws))
    return inverse, np.einsum("z...,z...ij->...ij", w * z, laws) @ inverse


def cuts(system: System) -> Cuts:
    """Lines of the mesh across which moments may jump or have a kink, and points where they may have no limit."""
    geometry, mesh = system.geometry, system.mesh
    broken, node_of = np.zeros(mesh.facets.shape[1], dtype=bool), geometry.ties.node_of
    if not isinstance(system.assembly.section, Section):
        broken |= system.assembly.section.borders
    ends = np.isin(node_of, list(reentrant_corners(geometry)))
    for each in singularities(system):
        if each.moves:
            continue
        if each.holds:
            lines, points = _of_support(geometry, each)
            broken |= lines
            ends |= points
        elif each.line is not None:
            broken |= _along(geometry, *each.line.T)
        for point in () if each.holds else each.alone.T:
            ends |= _near(geometry, point - mesh.p.T)
    return Cuts(np.flatnonzero(broken | ends[mesh.facets].any(axis=0)), np.flatnonzero(ends))


def _of_support(geometry: Geometry, support: Singularity) -> tuple[np.ndarray, np.ndarray]:
    """Facets (n_facets,) between held nodes, unless all about them is held, and nodes (n_mesh_nodes,) that are held alone or
    at an end of held edges."""
    mesh, node_of = geometry.mesh, geometry.ties.node_of
    facets = support.facets
    of_facets = geometry.ends(facets).ravel()
    nodes = np.union1d(nodes_at(geometry, support.points), of_facets[of_facets >= 0])
    # A hanging node is held where the ends of its edge are.
    held = np.isin(node_of, nodes)
    held[geometry.hanging.nodes] = held[geometry.hanging.ends].all(axis=0)
    whole, beside_free = held[mesh.t].all(axis=0), np.zeros(mesh.facets.shape[1], dtype=bool)
    beside_free[mesh.t2f[:, ~whole]] = True
    along = held[mesh.facets].all(axis=0) & beside_free
    ends = node_of[mesh.facets[:, facets]] if len(facets) else np.empty((2, 0), dtype=int)
    once = np.flatnonzero(np.bincount(ends[ends >= 0].ravel(), minlength=geometry.n_nodes) == 1)
    alone = NONE if whole.any() or along.any() else np.setdiff1d(nodes, ends)
    return along, np.isin(node_of, np.concatenate([once, alone]))


def _along(geometry: Geometry, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Facets on a straight line of the parameter plane."""
    way, p = end - start, geometry.mesh.p.T
    share = np.clip(((p - start) @ way) / (way @ way), 0.0, 1.0)
    return np.asarray(_near(geometry, start + share[:, None] * way - p)[geometry.mesh.facets].all(axis=0))


def _near(geometry: Geometry, apart: np.ndarray) -> np.ndarray:
    """Which differences (n, 2) of places are zero, across a seam too."""
    apart = apart - geometry.whole_turns(apart.T).T
    return np.asarray(np.abs(apart / np.ptp(geometry.mesh.p, axis=1)).max(axis=1) < SAME_POINT)


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
