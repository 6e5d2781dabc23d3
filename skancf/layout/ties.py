r"""Nodes that are one point of the surface: the two ends of a closed parameter, and the side that shrinks to a pole.

Along a closed seam the nodal vectors of both ends are equal, so that the nodes are one. At a pole all nodes share the
position, the slope along the side is zero, and the other slopes lie in the tangent plane of the pole: with two vectors t1
and t2 that span it, as nodal vectors of the pole,

.. math:: r_{,x}(y_j) = a_j t_1 + b_j t_2, \qquad r_{,xy}(y_j) = a'_j t_1 + b'_j t_2,

and the surface stays C1 there however it moves.
"""

from dataclasses import dataclass

import numpy as np
import skfem

from skancf.errors import InputError
from skancf.showing import short
from skancf.surfaces import Surface, check_regular, closed_directions
from skancf.theories import Theory
from skancf.tolerances import MOVED_OF_EDGE, ONE_DIRECTION, ONE_PLACE, SINGLE_PRECISION


@dataclass(frozen=True)
class Ties:
    """Which nodes of a mesh are one, and how the nodal vectors of a mesh node come from those of its own.

    Attributes
    ----------
    node_of : (n_mesh_nodes,) int array
        The node with the unknowns; -1 where it hangs and has none.
    representative : (n_nodes,) int array
        A mesh node for each of those.
    mix : (n_mesh_nodes, 4, 4) array
        From the vectors of the node to r, r_x, r_y and the fourth vector at the mesh node.
    poles : mapping from node to (t1, t2), (2, 3) array
    """

    node_of: np.ndarray
    representative: np.ndarray
    mix: np.ndarray
    poles: dict[int, np.ndarray]

    __repr__ = short


def find_ties(mesh: skfem.MeshQuad, surface: Surface, theory: Theory) -> Ties:
    """Ties of a mesh on a surface, with the nodal vectors of a theory.

    Raises
    ------
    InputError
        Where the nodes of the two ends of a closed parameter do not match, an element is its own neighbour across a seam, a
        side shrinks to a point that has no tangent plane, or another node has none.
    """
    first = np.arange(mesh.p.shape[1])
    hanging = np.zeros(len(first), dtype=bool)
    hanging[getattr(mesh, "hanging", [])] = True
    mix = np.tile(np.eye(4), (len(first), 1, 1))
    for axis, closed in enumerate(closed_directions(surface)):
        if closed:
            _close(mesh, surface, axis, first, hanging)
    collapsed = _collapsed(mesh, surface)
    at_poles = np.concatenate([nodes for nodes, _ in collapsed]) if collapsed else np.empty(0, dtype=int)
    check_regular(surface, *np.delete(mesh.p, at_poles, axis=1))
    tangents: dict[int, np.ndarray] = {}
    for nodes, axis in collapsed:
        root = int(first[nodes].min())
        first[nodes] = root
        tangents[root] = _pole(mesh, surface, nodes, axis, theory, mix)
    representative, number = np.unique(first[~hanging], return_inverse=True)
    node_of = np.full(len(first), -1, dtype=np.int32)
    node_of[~hanging] = number
    poles = {int(node_of[root]): t for root, t in tangents.items()}
    return Ties(node_of, representative, mix, poles)


def _close(mesh: skfem.MeshQuad, surface: Surface, axis: int, first: np.ndarray, hanging: np.ndarray) -> None:
    low, high = surface.bounds[axis]  # type: ignore[attr-defined]
    slack, other = ONE_PLACE * (high - low), mesh.p[1 - axis]
    ends = [np.flatnonzero((np.abs(mesh.p[axis] - end) <= slack) & ~hanging) for end in (low, high)]
    start, end = (nodes[np.argsort(other[nodes])] for nodes in ends)
    # Single precision may have left them apart, by less than would exchange neighbours.
    steps = [np.diff(other[nodes]).min(initial=np.inf) for nodes in (start, end)]
    reach = max(ONE_PLACE * np.ptp(other), min(SINGLE_PRECISION * np.abs(other).max(), MOVED_OF_EDGE * min(steps)))
    if len(start) != len(end) or (np.abs(other[start] - other[end]) > reach).any():
        raise InputError(f"the surface is closed in {'xy'[axis]}, but the mesh has other nodes at {low:.6g} than at "
                         f"{high:.6g}; give both ends the same nodes, or a surface that is not closed")  # fmt: skip
    first[end] = first[start]
    quads = np.sort(first[mesh.t], axis=0)
    if (quads[1:] == quads[:-1]).any():
        raise InputError(f"the surface is closed in {'xy'[axis]}, but the mesh has one element around it, whose two ends "
                         "would be the same nodes; take at least two elements around, better eight")  # fmt: skip


def _collapsed(mesh: skfem.MeshQuad, surface: Surface) -> list[tuple[np.ndarray, int]]:
    """Nodes of each whole side of the parameter plane that is one point of space, and the parameter along it."""
    size = np.ptp(surface.position(*mesh.p), axis=1).max()
    found = []
    for along in (0, 1):
        across = mesh.p[1 - along]
        for end in (across.min(), across.max()):
            nodes = np.flatnonzero(np.abs(across - end) <= ONE_PLACE * np.ptp(across))
            x, y = mesh.p[:, nodes]
            slope = np.linalg.norm(surface.derivatives(x, y)[along], axis=0).max()
            apart = np.ptp(surface.position(x, y), axis=1).max()
            if len(nodes) > 1 and max(apart, slope * np.ptp(mesh.p[along, nodes])) <= ONE_PLACE * size:
                found.append((nodes, along))
    return found


def _pole(
    mesh: skfem.MeshQuad, surface: Surface, nodes: np.ndarray, along: int, theory: Theory, mix: np.ndarray
) -> np.ndarray:
    """Tangents (2, 3) of a pole; writes the mixes of its nodes."""
    x, y = mesh.p[:, nodes]
    slopes = surface.derivatives(x, y)[1 - along].T
    twists = surface.second_derivatives(x, y)[1].T
    _, sizes, basis = np.linalg.svd(np.concatenate([slopes, twists]))
    if sizes[2] > ONE_DIRECTION * sizes[0] or sizes[1] < ONE_DIRECTION * sizes[0]:
        place = ", ".join(f"{v:.4g}" for v in surface.position(x[:1], y[:1])[:, 0])
        raise InputError(f"a side of the surface shrinks to the point ({place}), where it has no tangent plane; "
                         "leave a small hole there")  # fmt: skip
    tangents = basis[:2] * np.abs(slopes @ basis[:2].T).max()
    square = (tangents[0] ** 2).sum()
    mix[nodes, 1:] = 0.0
    mix[nodes, 2 - along, 1:3] = slopes @ tangents.T / square
    mix[nodes, 3] = theory.fourth_at_pole(twists @ tangents.T / square)
    return np.asarray(tangents)
