"""Hanging nodes on an L-shape: sizes of the equations, ways to eliminate, and what refinement changes of a random state.

Writes docs/decisions/hanging.csv, eliminated.csv and nested.csv. From the folder of the repository, in a few seconds:

    .venv/bin/python docs/measure/hanging.py
"""

import warnings
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
import skfem
from skfem.helpers import dd, ddot
from skfem.utils import mpc
from tables import write

import skancf as sk
from skancf.layout.hanging import Hanging
from skancf.meshes import MeshQuadTree
from skancf.theories import Kirchhoff

OPENING = [((0.0, 1.0), (0.0, 1.0))]
SURFACE = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
PLACE = (-0.5, -0.5)


def plate() -> sk.Problem:
    """The L-shape, clamped all around, with q = D = 1."""
    return sk.Problem(
        surface=SURFACE,
        thickness=0.01,
        material=sk.Isotropic(young=12 / 0.01**3, poisson=0.0, density=1.0),
        supports=[sk.Clamp("boundary")],
        loads=[sk.SurfaceLoad((0.0, 0.0, -1.0))],
    )


def at_corner(n: int, times: int) -> MeshQuadTree:
    """n x n elements, those that touch the corner quartered so many times."""
    mesh = sk.meshes.quadtree(sk.meshes.uniform(SURFACE, n, n, openings=OPENING))
    for _ in range(times):
        mesh = mesh.refined(np.flatnonzero((np.abs(mesh.p[:, mesh.t]).max(axis=0) == 0).any(axis=0)))
    return mesh


def sizes() -> list[list[Any]]:
    """Unknowns and stored entries: hanging nodes within elements, and with multipliers for their equations."""
    rows = []
    for n, times in ((8, 4), (16, 8), (32, 8)):
        mesh = at_corner(n, times)
        nodes, hanging = mesh.p.shape[1], len(mesh.hanging)
        masters = _masters(plate().on(mesh, "kirchhoff").geometry.local_matrix, mesh.nelements)
        equations, weights = 12 * hanging, 3 * int((Hanging.of(mesh, Kirchhoff()).weights != 0).sum())
        rows.append([
            mesh.nelements, nodes, hanging, 12 * (nodes - hanging), 12 * nodes + equations,
            144 * _pairs(masters), 144 * _pairs(mesh.t) + 2 * (weights + equations),
        ])  # fmt: skip
    return rows


def _masters(matrix: sp.csr_matrix, n: int) -> np.ndarray:
    """The nodes on which each element depends; four of them, (4, n_elements)."""
    found = [np.unique(matrix[16 * element : 16 * element + 16].indices // 4) for element in range(n)]
    assert {len(nodes) for nodes in found} == {4}
    return np.array(found).T


def _pairs(nodes: np.ndarray) -> int:
    """Ordered pairs of nodes (4, n_elements) that share an element."""
    pairs = np.stack([np.repeat(nodes, 4, axis=0).ravel(), np.tile(nodes, (4, 1)).ravel()])
    return int(np.unique(pairs, axis=1).shape[1])


@skfem.BilinearForm
def bending(u: Any, v: Any, _: Any) -> Any:
    return ddot(dd(u), dd(v))


@skfem.LinearForm
def load(v: Any, _: Any) -> Any:
    return -v


def eliminated() -> list[list[Any]]:
    """The deflection by scikit-fem alone, with hanging nodes eliminated in two ways, and by this library (mm)."""
    rows = []
    for n, times in ((4, 1), (4, 4), (8, 4), (16, 4)):
        mesh = at_corner(n, times)
        basis = skfem.Basis(mesh.plain(), skfem.ElementQuadBFS(), intorder=7)
        free = basis.nodal_dofs[:, ~np.isin(np.arange(mesh.p.shape[1]), mesh.facets[:, mesh.boundary_facets()])].ravel()
        K, f = bending.assemble(basis)[free][:, free], load.assemble(basis)[free]
        slaves, T = _equations(mesh, basis, free)
        masters = np.setdiff1d(np.arange(len(free)), slaves)
        P = sp.lil_matrix((len(free), len(masters)))
        P[masters], P[slaves] = sp.eye(len(masters)), T[:, masters]
        P = P.tocsr()
        A, b, _, (order, expand) = mpc(K, f, S=slaves, M=masters, T=T[:, masters])
        dropped = np.empty(len(free))
        dropped[order] = expand(_solved(A, b))
        probe = basis.probes(np.array(PLACE)[:, None]).tocsr()[:, free]
        values = [(probe @ x)[0] for x in (P @ _solved(P.T @ K @ P, P.T @ f), dropped)]
        values.append(sk.solve_linear(plate().on(mesh, "kirchhoff")).displacement(PLACE)[2])
        skew = abs(A - A.T).max() / abs(A).max()
        rows.append([mesh.nelements, len(mesh.hanging), *(f"{1000 * value:.5f}" for value in values), f"{skew:.2f}"])
    return rows


def _equations(mesh: MeshQuadTree, basis: skfem.Basis, free: np.ndarray) -> tuple[np.ndarray, sp.csr_matrix]:
    """Numbers of the hanging nodes' values among the free ones (m,), and their weights (m, n_free)."""
    hanging, dofs = Hanging.of(mesh, Kirchhoff()), basis.nodal_dofs
    T = sp.lil_matrix((basis.N, basis.N))
    for k, node in enumerate(hanging.nodes):
        for end in range(2):
            T[np.ix_(dofs[:, node], dofs[:, hanging.ends[end, k]])] = hanging.weights[end, k]
    return np.flatnonzero(np.isin(free, dofs[:, hanging.nodes])), T.tocsr()[free][:, free][
        np.isin(free, dofs[:, hanging.nodes])
    ]


def _solved(K: sp.spmatrix, f: np.ndarray) -> np.ndarray:
    return np.asarray(scipy.sparse.linalg.spsolve(sp.csc_matrix(K), f))


def nested() -> list[list[Any]]:
    """Relative changes of a random state when all elements are quartered: largest displacement at points, energy."""
    rng, rows = np.random.default_rng(0), []
    tree = at_corner(4, 3)
    points = np.array([[-0.9, 0.9, -0.03, -0.51], [-0.9, -0.3, -0.01, 0.52]])
    for theory in ("kirchhoff", "full"):
        for name, mesh in (("no", at_corner(4, 0)), ("some", tree)):
            system = plate().on(mesh, theory)
            # Across the plate: assumed membrane strains are those of each mesh.
            across = rng.standard_normal((system.n_dofs // 3, 3)) * (0.0, 0.0, 1.0)
            change = system.constraints.free_part(across.ravel())
            state = sk.Solution(system, system.undeformed + change, linear=True)
            moved = sk.transfer(state, plate().on(mesh.refined(), theory))
            before, after = (np.array([s.displacement(p) for p in points.T]) for s in (state, moved))
            energies = [s.strain_energy for s in (state, moved)]
            rows.append([theory, name, f"{np.abs(after - before).max() / np.abs(before).max():.0e}",
                         f"{abs(energies[1] / energies[0] - 1):.0e}"])  # fmt: skip
    return rows


def main() -> None:
    warnings.simplefilter("ignore")
    write("hanging.csv", "elements; nodes; hanging; unknowns; with multipliers; entries; with multipliers", sizes())
    write("eliminated.csv", "elements; hanging; T'KT; rows dropped; here; asymmetry of the second", eliminated())
    write("nested.csv", "theory; hanging nodes; displacements; energy", nested())


if __name__ == "__main__":
    main()
