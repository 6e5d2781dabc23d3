"""States on another mesh: exactly to a finer one, by projection in the mass norm to a coarser one."""

import numpy as np
import scipy.sparse as sp

from skancf.assembly.geometry import Geometry
from skancf.assembly.system import System, assemble
from skancf.elements.reference import CORNERS
from skancf.errors import InputError
from skancf.linear import DirectSolver
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
    those of one side.) Of a small-deflection answer it is the displacement field. Where the new mesh is coarser somewhere,
    the positions are the projection in the mass norm,

    .. math:: \int \rho t\, (r_{new} - r) \cdot \delta r_{new} \, dA = 0,

    on what supports leave free; so the linear momentum of a free body stays the same, but for the areas of curved elements,
    which are those of each mesh. Supports hold exactly what they prescribe, at new nodes too, where the old elements are not
    quite on a curved surface; for the same reason a curved body at rest is not quite without strain on a finer mesh.

    Raises
    ------
    InputError
        For meshes that do not grow from one coarse mesh, and for another theory.
    """
    old, new = state.system.geometry, system.geometry
    _require_one_tree(old, new)
    at_supports = system.undeformed + state.load_factor * system.prescribed(state.time)
    rest, new_rest = (state.system.undeformed, system.undeformed) if state.linear else (0.0, 0.0)
    fields = [(state.q - rest).reshape(-1, 3)] + ([] if state.velocity is None else [state.velocity.reshape(-1, 3)])
    held = [at_supports - new_rest, np.zeros_like(at_supports)][: len(fields)]
    if _is_finer(new.mesh.leaves, old.mesh.leaves):
        P = prolongation(old, new)
        moved = [_held((P @ field).ravel(), values, system) for field, values in zip(fields, held, strict=True)]
    else:
        moved = _projected(fields, held, old, system)
    q, *velocity = moved
    return Solution(
        system, q + new_rest, velocity[0] if velocity else None, time=state.time, load_factor=state.load_factor,
        linear=state.linear,
    )  # fmt: skip


def _held(field: np.ndarray, values: np.ndarray, system: System) -> np.ndarray:
    """A field with the values that supports prescribe."""
    return np.asarray(field + system.constraints.fixed_part(values - field))


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
    here, there = (g.surface.position(*one.points) for g in (old, new))
    if one.closed != two.closed or np.abs(here - there).max() > 1e-9 * np.abs(here).max():
        raise InputError("transfer: the meshes lie on different surfaces")
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
    new, pieces = system.geometry, _common(old.mesh.leaves, system.mesh.leaves)
    whole = assemble(Geometry(grown(pieces), new.surface, new.theory), system.problem.section)
    mass = whole.mass_shapes[whole.sections.shape]
    (from_old, A_old), (from_new, A_new) = (_on_pieces(geometry, pieces) for geometry in (old, new))
    weighted, elements = A_new.swapaxes(1, 2) @ mass, np.arange(new.n_elements)
    on_elements = np.zeros((len(elements), 16, 16))
    np.add.at(on_elements, from_new, weighted @ A_new)
    matrix, out = system.gathered_mass(elements, on_elements), []
    with DirectSolver(system.pattern, system.constraints) as solver:
        solver.factor(matrix)
        for field, values in zip(fields, held, strict=True):
            fixed, forces = system.constraints.fixed_part(values), np.zeros((len(elements), 16, 3))
            np.add.at(forces, from_new, weighted @ (A_old @ old.local(field.reshape(-1, 4, 3))[from_old]))
            rhs = new.nodal(forces, elements).ravel() - matrix @ fixed
            out.append(solver.solve(rhs, refinements=2) + fixed)
    return out


def _on_pieces(geometry: Geometry, pieces: Leaves) -> tuple[np.ndarray, np.ndarray]:
    """The element that holds each piece, (n,), and the piece's local vectors from those of the element, (n, 16, 16)."""
    leaves, theory = geometry.mesh.leaves, geometry.theory
    holds = ancestors_in(leaves, pieces)
    cells, within = leaves.cells.take(holds), pieces.cells
    finer = within.level - cells.level
    places = np.stack([finer, within.x - (cells.x << finer), within.y - (cells.y << finer)])
    kinds, kind = np.unique(places, axis=1, return_inverse=True)
    matrices = np.empty((kinds.shape[1], 16, 16))
    for k, (levels, x, y) in enumerate(kinds.T.tolist()):
        size = 0.5**levels
        table = theory.nodal_table(size * np.add(CORNERS, (x, y)).T) * _scales(np.full((2, 1), size), theory.twist)[:, None]
        matrices[k][theory.rows] = table.transpose(2, 0, 1)
    return holds, matrices[kind.ravel()]


def ancestors_in(coarse: Leaves, fine: Leaves) -> np.ndarray:
    """The coarse leaf in which each fine one lies, (n_fine,)."""
    cells, found = fine.cells, coarse.find(fine.cells)
    while (found < 0).any() and cells.level.max() > 0:
        cells = cells.parents
        found = np.where(found < 0, coarse.find(cells), found)
    return found
