"""States on another mesh: exactly to a finer one, by projection in the mass norm to a coarser one."""

import numpy as np
import scipy.sparse as sp

from skancf.assembly.geometry import Geometry
from skancf.assembly.system import System
from skancf.errors import InputError
from skancf.linear import BlockMatrix, DirectSolver
from skancf.meshes import MeshQuadTree
from skancf.meshes.forest import Leaves
from skancf.meshes.quadtree import grown
from skancf.solution import Solution

# Places of nodes in the elements of another mesh of the same tree are multiples of this.
FINEST = 2.0**20


def transfer(state: Solution, system: System) -> Solution:
    r"""A state on another mesh of the same quadtree, with the same theory.

    Where the new mesh is finer, the position field is the same function there: in theory `kirchhoff` spaces are nested, and
    positions, slopes and the velocity do not change. (In theory `full` slopes across edges jump; there the new nodes take
    those of one side.) Where it is coarser somewhere, the positions are the projection in the mass norm,

    .. math:: \int \rho t\, (r_{new} - r) \cdot \delta r_{new} \, dA = 0,

    on what supports leave free; so the linear momentum of a free body stays the same.

    Raises
    ------
    InputError
        For meshes that do not grow from one coarse mesh, and for another theory.
    """
    old, new = state.system.geometry, system.geometry
    _require_one_tree(old, new)
    fields = [state.q.reshape(-1, 3)] if state.velocity is None else [v.reshape(-1, 3) for v in (state.q, state.velocity)]
    if _is_finer(new.mesh.leaves, old.mesh.leaves):
        P = prolongation(old, new)
        moved = [P @ field for field in fields]
    else:
        held = system.undeformed + state.load_factor * system.prescribed(state.time)
        moved = _projected(fields, [held, np.zeros_like(held)], old, system)
    q, *velocity = (field.ravel() for field in moved)
    return Solution(
        system, q, velocity[0] if velocity else None, time=state.time, load_factor=state.load_factor, linear=state.linear
    )


def prolongation(old: Geometry, new: Geometry) -> sp.csr_matrix:
    """Nodal vectors of a position field of one mesh at the nodes of another: (4 n_new, 4 n_old).

    A node's vectors are r, r_x, r_y, and r_xy or r_z of the field there.
    """
    elements, places = old.locate_all(new.points)
    places = np.round(places * FINEST) / FINEST
    first, last = (old.mesh.p[:, old.mesh.t[corner, elements]] for corner in (0, 2))
    table = old.theory.nodal_table(places.T) / _scales(last - first, old.theory.twist)[:, None]
    n = new.n_nodes
    rows = np.broadcast_to(4 * np.arange(n) + np.arange(4)[:, None, None], table.shape)
    columns = np.broadcast_to(16 * elements + np.arange(16)[:, None], table.shape)
    used = table != 0
    at_nodes = sp.csr_matrix((table[used], (rows[used], columns[used])), shape=(4 * n, 16 * old.n_elements))
    return _at_poles(old, new, sp.csr_matrix(at_nodes @ old.local_matrix))


def _scales(sides: np.ndarray, twist: bool) -> np.ndarray:
    """What makes derivatives in the reference square those of parameters, (4, n)."""
    one = np.ones_like(sides[0])
    return np.stack([one, sides[0], sides[1], sides[0] * sides[1] if twist else one])


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
        if not new.theory.twist:
            P[4 * node + 3, 4 * other + 3] = 1.0
    return P.tocsr()


def _require_one_tree(old: Geometry, new: Geometry) -> None:
    if not all(isinstance(g.mesh, MeshQuadTree) for g in (old, new)):
        raise InputError("transfer: both meshes must be quadtrees; make the coarse one by sk.meshes.quadtree(mesh)")
    one, two = (g.mesh.leaves.forest for g in (old, new))
    if one is not two and not (np.array_equal(one.points, two.points) and np.array_equal(one.corners, two.corners)):
        raise InputError("transfer: the meshes grow from different coarse meshes; refine or coarsen one and the same")
    if old.theory.name != new.theory.name:
        raise InputError(f"transfer: the state is one of theory {old.theory.name!r}, the system of {new.theory.name!r}; "
                         "their nodal vectors are different")  # fmt: skip


def _is_finer(new: Leaves, old: Leaves) -> bool:
    """Does every leaf lie in one of the old ones?"""
    return bool((ancestors_in(old, new) >= 0).all())


def _common(one: Leaves, two: Leaves) -> Leaves:
    """The coarsest leaves that are finer than both."""
    cells = one.cells.join(two.cells)
    cells = cells.take(np.unique(cells.keys, return_index=True)[1])
    above, taken = cells, [np.empty(0, dtype=np.int64)]
    for _ in range(int(cells.level.max())):
        above = above.parents
        taken.append(np.unique(above.keys))
    return Leaves(one.forest, cells.take(np.flatnonzero(~np.isin(cells.keys, np.concatenate(taken)))))


def _projected(
    fields: list[np.ndarray], held: list[np.ndarray], old: Geometry, system: System
) -> list[np.ndarray]:
    new, section = system.geometry, system.problem
    bare = type(section)(section.surface, section.thickness, section.material)
    mesh = grown(_common(old.mesh.leaves, new.mesh.leaves))
    common = bare.on(mesh, new.theory)
    P_old, P_new = (prolongation(geometry, common.geometry) for geometry in (old, new))
    weighted = P_new.T @ common.mass.to_scipy()[::3, ::3]
    matrix = _in_blocks(sp.csr_matrix(weighted @ P_new), system)
    out = []
    with DirectSolver(system.pattern, system.constraints) as solver:
        solver.factor(matrix)
        for field, values in zip(fields, held, strict=True):
            fixed = system.constraints.fixed_part(values)
            rhs = (weighted @ (P_old @ field)).ravel() - matrix @ fixed
            out.append((solver.solve(rhs, refinements=2) + fixed).reshape(-1, 3))
    return out


def _in_blocks(matrix: sp.csr_matrix, system: System) -> BlockMatrix:
    """A matrix (4 n_nodes, 4 n_nodes), the same for each component, in the blocks of a system."""
    pattern = system.pattern
    blocks = np.zeros((pattern.n_blocks, 4, 3, 4, 3))
    rows, columns = np.repeat(np.arange(4), 4), np.tile(np.arange(4), 4)
    for row, column in zip(rows, columns, strict=True):
        values = np.asarray(matrix[4 * pattern.rows + row, 4 * pattern.indices + column]).ravel()
        for i in range(3):
            blocks[:, row, i, column, i] = values
    return BlockMatrix(pattern, blocks.reshape(-1, 12, 12))


def ancestors_in(coarse: Leaves, fine: Leaves) -> np.ndarray:
    """The coarse leaf in which each fine one lies, (n_fine,)."""
    cells, found = fine.cells, coarse.find(fine.cells)
    while (found < 0).any() and cells.level.max() > 0:
        cells = cells.parents
        found = np.where(found < 0, coarse.find(cells), found)
    return found
