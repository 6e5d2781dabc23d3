"""Fields of one mesh on another of the same tree: where its nodes are, and turned with the surface where meshes differ."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError
from skancf.kernels.constants import AXES, VECTORS
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Part, nodal
from skancf.meshes import MeshQuadTree
from skancf.meshes.forest import Leaves
from skancf.solution import Solution
from skancf.system.system import System
from skancf.tolerances import ONE_PLACE, ROUNDED_VALUE

# Places of nodes in the elements of another mesh of the same tree are multiples of this.
FINEST = 2.0**20


class Interpolation:
    r"""From fields on one mesh to those on another, by their values and slopes at its nodes.

    Two meshes interpolate a curved surface in two ways: where the new one has new nodes, its undeformed surface X differs
    from the interpolant :math:`P X` of the old one by a gap of order h^4 (`kirchhoff`). Positions carry that gap along as
    the surface has turned at each node,

    .. math:: r_{new} = P r + R\, (X_{new} - P X), \qquad \dot r_{new} = P \dot r + \dot R\, (X_{new} - P X),

    with the rotation R of the frame of r_x and the normal. So what moves rigidly is without strain on both meshes. A mesh
    that has fewer nodes takes over what is there; on flat surfaces nothing is added.

    Attributes
    ----------
    matrix : (4 n_new, 4 n_old) sparse array
        P.
    """

    def __init__(self, old: Geometry, new: Geometry, others: Sequence[Part] = ()):
        self.old, self.new, self.others = old, new, others
        self.matrix = prolongation(old, new)

    @classmethod
    def of(cls, old: System, new: System) -> "Interpolation":
        """Between systems, with the unknowns that do not belong to their plates.

        Raises
        ------
        InputError
            Where these are others on the new mesh.
        """
        mine, others = old.layout.parts[1:], new.layout.parts[1:]
        if [(p.name, p.nodal) for p in mine] != [(p.name, p.nodal) for p in others] or any(
            len(a) != len(b) and not a.nodal for a, b in zip(mine, others, strict=True)
        ):
            raise InputError("transfer: unknowns that belong to no mesh are others in the two systems; a part that is to be "
                             "interpolated with the mesh says nodal=True")  # fmt: skip
        return cls(old.geometry, new.geometry, mine)

    def field(self, values: np.ndarray) -> np.ndarray:
        """P times nodal coordinates, (n_new_dofs,); unknowns that belong to no mesh stay as they are."""
        return self._each(self.matrix, values, self.old.n_nodes)

    def transposed(self, forces: np.ndarray) -> np.ndarray:
        """What forces on the new nodes do on the old ones, (n_old_dofs,)."""
        return self._each(self.matrix.T, forces, self.new.n_nodes)

    def _each(self, matrix: sp.spmatrix, values: np.ndarray, n_nodes: int) -> np.ndarray:
        """A matrix times the values of the plate and of other parts with a block for each node; the rest as it is."""
        vectors, out, at = values.reshape(-1, AXES), [], 0
        for n, interpolated in [(n_nodes, True), *[(n_nodes if p.nodal else len(p), p.nodal) for p in self.others]]:
            part = vectors[at : at + VECTORS * n]
            out.append((matrix @ part if interpolated else part).ravel())
            at += VECTORS * n
        return np.asarray(out[0] if len(out) == 1 else np.concatenate(out))

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Nodal coordinates of a state, (n_new_dofs,)."""
        out, (nodes, frames, gap) = nodal(self.field(q)), self._gap
        if nodes.size:
            out[nodes] += gap @ (_frames(out[nodes])[0] @ frames.swapaxes(1, 2)).swapaxes(1, 2)
        return out.ravel()

    def unknowns(self, state: Solution) -> np.ndarray:
        """Those of the model of a state: its positions, or the field of a small change."""
        return self.field(state.change) if state.linear else self.positions(state.q)

    def rates(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Those of its rate v, (n_new_dofs,)."""
        out, (nodes, frames, gap) = nodal(self.field(v)), self._gap
        if nodes.size:
            turning = _frames(nodal(self.field(q))[nodes], out[nodes])[1]
            out[nodes] += gap @ (turning @ frames.swapaxes(1, 2)).swapaxes(1, 2)
        return out.ravel()

    @cached_property
    def _gap(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodes (m,) with a gap, the frames (m, 3, 3) of the old undeformed surface there, and the gap (m, 4, 3)."""
        before = nodal(np.asarray((self.matrix @ self.old.undeformed.reshape(-1, AXES)).ravel()))
        gap = self.new.undeformed - before
        nodes = np.flatnonzero(np.abs(gap).max(axis=(1, 2)) > ROUNDED_VALUE * np.abs(before).max())
        return nodes, _frames(before[nodes])[0], gap[nodes]


def multipliers_on(state: Solution, system: System) -> np.ndarray:
    """Those of a state on another mesh, (n,), none of a system without conditions.

    Raises
    ------
    InputError
        For a state that has none though its system has conditions.
    """
    conditions = state.system.conditions
    if not conditions:
        return np.zeros(0)
    if state.multipliers is None:
        names = ", ".join(map(repr, conditions.names))
        raise InputError(f"state: it has no multipliers, and its system has conditions: {names}; give what solve, "
                         "solve_linear or trace found")  # fmt: skip
    return conditions.carried(state.multipliers, system.conditions)


def _frames(vectors: np.ndarray, rates: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal frames (n, 3, 3), columns along r_x, across it in the surface, and normal; and their rates."""
    (a, b), (da, db) = (np.moveaxis(v[:, 1:3], 1, 0) for v in (vectors, np.zeros_like(vectors) if rates is None else rates))
    first, first_rate = _unit(a, da)
    normal, normal_rate = _unit(np.cross(a, b), np.cross(da, b) + np.cross(a, db))
    across = np.cross(normal, first)
    across_rate = np.cross(normal_rate, first) + np.cross(normal, first_rate)
    return np.stack([first, across, normal], axis=2), np.stack([first_rate, across_rate, normal_rate], axis=2)


def _unit(v: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (n, 3) along v, and their rates."""
    size = np.linalg.norm(v, axis=1, keepdims=True)
    unit = v / size
    return unit, (rate - (unit * rate).sum(axis=1, keepdims=True) * unit) / size


def prolongation(old: Geometry, new: Geometry) -> sp.csr_matrix:
    """Nodal vectors of a position field of one mesh at the nodes of another: (4 n_new, 4 n_old).

    A node's vectors are r, r_x, r_y, and r_xy or r_z of the field there; those of a node that both have, to the last bit.
    """
    kept, source = shared_nodes(old, new)
    is_kept = np.zeros(new.n_nodes, dtype=bool)
    is_kept[kept] = True
    others = np.flatnonzero(~is_kept)
    elements, places = old.locate_all(new.points[:, others])
    places = np.round(places * FINEST) / FINEST
    first, last = (old.mesh.p[:, old.mesh.t[corner, elements]] for corner in (0, 2))
    table = old.theory.nodal_table(places.T) / _scales(last - first, old)[:, None]
    rows = np.broadcast_to(4 * others + np.arange(4)[:, None, None], table.shape)
    columns = np.broadcast_to(16 * elements + np.arange(16)[:, None], table.shape)
    used = table != 0
    at_nodes = sp.csr_matrix((table[used], (rows[used], columns[used])), shape=(4 * new.n_nodes, 16 * old.n_elements))
    same = [(4 * nodes[:, None] + np.arange(4)).ravel() for nodes in (kept, source)]
    at_kept = sp.csr_matrix((np.ones(same[0].size), tuple(same)), shape=(4 * new.n_nodes, 4 * old.n_nodes))
    return _at_poles(old, new, sp.csr_matrix(at_nodes @ old.local_matrix + at_kept))


def shared_nodes(old: Geometry, new: Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Nodes with unknowns that both meshes have: their numbers in the new one and in the old one, (m,) each."""
    (keys, nodes), (new_keys, new_nodes) = _keys_of_nodes(old), _keys_of_nodes(new)
    _, one, other = np.intersect1d(keys, new_keys, assume_unique=True, return_indices=True)
    found, at = np.unique(new_nodes[other], return_index=True)
    return found, nodes[one[at]]


def _keys_of_nodes(geometry: Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Keys of the mesh nodes that have unknowns, and the node of each; two keys for one node of a seam."""
    leaves, mesh_nodes = geometry.mesh.leaves, geometry.mesh.t.ravel()
    keys, at = np.unique(leaves.forest.point_keys(leaves.cells), return_index=True)
    nodes = geometry.ties.node_of[mesh_nodes[at]]
    return keys[nodes >= 0], nodes[nodes >= 0].astype(np.int64)


def _scales(sides: np.ndarray, geometry: Geometry) -> np.ndarray:
    """What makes derivatives in the reference square those of parameters, (4, n)."""
    fourth = geometry.theory.fourth_factor(np.einsum("ij,in->ijn", np.eye(2), sides))
    return np.stack([np.ones_like(sides[0]), sides[0], sides[1], fourth])


def _at_poles(old: Geometry, new: Geometry, P: sp.csr_matrix) -> sp.csr_matrix:
    """The two tangents of a pole, which each mesh chooses for itself: t_new = (T_new T_old^+) t_old."""
    if not new.ties.poles:
        return P
    P = P.tolil()
    for node, tangents in new.ties.poles.items():
        other = min(old.ties.poles, key=lambda k: np.linalg.norm(old.undeformed[k, 0] - new.undeformed[node, 0]))
        P[4 * node : 4 * node + 4] = 0.0
        P[4 * node, 4 * other] = 1.0
        P[4 * node + 1 : 4 * node + 3, 4 * other + 1 : 4 * other + 3] = tangents @ np.linalg.pinv(old.ties.poles[other])
        if new.theory.directors:
            P[4 * node + 3, 4 * other + 3] = 1.0
    return P.tocsr()


def require_one_tree(old: Geometry, new: Geometry) -> None:
    if not all(isinstance(g.mesh, MeshQuadTree) for g in (old, new)):
        raise InputError("transfer: both meshes must be quadtrees; make the coarse one by sk.meshes.quadtree(mesh)")
    one, two = (g.mesh.leaves.forest for g in (old, new))
    if one is not two and not (np.array_equal(one.points, two.points) and np.array_equal(one.corners, two.corners)):
        raise InputError("transfer: the meshes grow from different coarse meshes; refine or coarsen one and the same")
    here, there = (g.surface.position(*one.points) for g in (old, new))
    if one.closed != two.closed or np.abs(here - there).max() > ONE_PLACE * np.abs(here).max():
        raise InputError("transfer: the meshes lie on different surfaces")
    if old.theory.nodal_vectors != new.theory.nodal_vectors:
        raise InputError(f"transfer: the state is one of theory {old.theory.name!r}, the system of {new.theory.name!r}; "
                         "their nodal vectors are different")  # fmt: skip


def is_finer(new: Leaves, old: Leaves) -> bool:
    """Does every leaf lie in one of the old ones?"""
    return bool((ancestors_in(old, new) >= 0).all())


def ancestors_in(coarse: Leaves, fine: Leaves) -> np.ndarray:
    """The coarse leaf in which each fine one lies, (n_fine,)."""
    cells, found = fine.cells, coarse.find(fine.cells)
    while (found < 0).any() and cells.level.max() > 0:
        cells = cells.parents
        found = np.where(found < 0, coarse.find(cells), found)
    return found
