"""Frequencies and buckling loads with conditions: passes, stiffness, penalties and counts, against the null space.

From the folder of the repository, in a minute:

    .venv/bin/python docs/measure/conditioned_modes.py

It writes docs/decisions/conditioned_modes.csv, conditioned_buckling.csv and conditioned_counts.csv.
"""

import warnings
from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp
import tables
from scipy.linalg import eigh, null_space
from scipy.sparse.linalg import eigsh

import skancf as sk
from skancf.linear import BlockMatrix, DirectSolver
from skancf.linear.conditioned import products, row_stiffness
from skancf.statics import motions
from skancf.statics.conditioned import curved
from skancf.system.linearised import geometric_stiffness

STEEL = sk.Isotropic(young=2e11, poisson=0.3, density=7800.0)
TUBE = sk.CylinderSector(radius=1.0, length=0.5, angle=2 * np.pi)
HINGE, ROD = sk.Hinge("start", "end"), sk.RigidLink((0.0, 0.5), (0.5, 2.5))
CLAMP = [sk.Clamp("left")]
COUNT = 10
PASSES = [(1e4, 1), (1e4, 2), (1e7, 1), (1e7, 2), (1e7, 3)]
PENALTIES = [1e4, 1e6, 1e8]


def tube(theory: str, joints: tuple, supports: list, thickness: float = 0.01, loads: tuple = ()) -> sk.system.system.System:
    problem = sk.Problem(TUBE, thickness, STEEL, supports, list(loads), conditions=list(joints))
    return problem.on(sk.meshes.uniform(TUBE, 3, 12), theory)


def structures() -> Iterator[tuple[str, sk.system.system.System]]:
    for theory in ("kirchhoff", "full"):
        yield f"hinge and rod, `{theory}`", tube(theory, (HINGE, ROD), CLAMP)
    yield "the same, h / R = 1e-4", tube("full", (HINGE, ROD), CLAMP, 1e-4)
    yield "each twice, `kirchhoff`", tube("kirchhoff", (HINGE, ROD, HINGE, ROD), CLAMP)
    yield "free, `kirchhoff`", tube("kirchhoff", (HINGE, ROD), [])


def free_directions(system: sk.system.system.System) -> np.ndarray:
    return motions.free_directions(system.constraints)


def null_basis(system: sk.system.system.System) -> np.ndarray:
    free = free_directions(system)
    rows = system.conditions.gradient(system.undeformed) @ free.T
    sizes = np.linalg.norm(rows, axis=1)
    return null_space(rows[sizes > 1e-10] / sizes[sizes > 1e-10, None], rcond=1e-10).T @ free


def pencil(basis: np.ndarray, one: BlockMatrix, other: BlockMatrix) -> np.ndarray:
    return eigh(basis @ one.to_scipy() @ basis.T, basis @ other.to_scipy() @ basis.T, eigvals_only=True)


def lanczos(system: sk.system.system.System, stiffness: BlockMatrix, shift: float) -> np.ndarray:
    """The first eigenvalues without conditions."""
    free = sp.csr_matrix(free_directions(system))
    one, other = (sp.csc_matrix(free @ matrix.to_scipy() @ free.T) for matrix in (stiffness, system.mass))
    return np.sort(eigsh(one, COUNT, other, sigma=shift, tol=1e-12, return_eigenvectors=False))


def stiffened(system: sk.system.system.System, times: float) -> BlockMatrix:
    """The stiffness with a penalty by the same rule."""
    rows = system.conditions.gradient(system.undeformed) @ system.constraints.free_projection
    held = np.zeros(rows.shape[0], bool)
    stiffness = system.stiffness()
    return stiffness + products(stiffness, rows, times * row_stiffness(stiffness, rows, system.constraints, held))


def worst(found: np.ndarray, expected: np.ndarray) -> str:
    return f"{np.abs(found / expected - 1).max():.0e}"


def of_modes() -> None:
    rows = []
    for name, system in structures():
        expected = pencil(null_basis(system), system.stiffness(), system.mass)
        rigid = int((expected < 1e-6 * expected[COUNT]).sum())
        row, part = [name], expected[rigid:COUNT]
        for motions.STIFFNESS, motions.PASSES in PASSES:
            found = sk.modes(system, COUNT)
            row.append(worst(found.eigenvalues[rigid:], part))
        shift = -0.1 * part[0] if rigid else 0.0
        row += [worst(lanczos(system, stiffened(system, times), shift)[rigid:], part) for times in PENALTIES]
        rows.append(row)
    names = [f"{eta:.0e}, {n}" for eta, n in PASSES] + [f"penalty {times:.0e}" for times in PENALTIES]
    tables.write("conditioned_modes.csv", "structure; " + "; ".join(names), rows)


def pressed() -> Iterator[tuple[str, sk.system.system.System]]:
    a, b = (TUBE.position(*map(np.array, at)) for at in (ROD.a, ROD.b))
    for theory in ("kirchhoff", "full"):
        squeeze = (sk.PointForce(ROD.b, tuple(1e5 * (a - b))),)
        yield f"tube, pressed along its rod, `{theory}`", tube(theory, (HINGE, ROD), CLAMP, 0.01, squeeze)
    strip = sk.Rectangle(1.0, 0.1)
    strut = sk.RigidLink((0.4, 0.05), (1.0, 0.05), name="strut")
    loads = [sk.EdgeLoad("right", (-1e4, 0.0, 0.0))]
    problem = sk.Problem(strip, 0.01, STEEL, CLAMP, loads, conditions=[strut])
    yield "strip with a strut, `kirchhoff`", problem.on(sk.meshes.uniform(strip, 10, 2), "kirchhoff")


def of_buckling() -> None:
    rows = []
    for name, system in pressed():
        motions.STIFFNESS, motions.PASSES = 1e7, 2
        linear = sk.buckling(system, 4).linear
        load = geometric_stiffness(system, linear.change)
        whole = curved(system, load, system.undeformed, linear.multipliers)

        def factors(basis: np.ndarray, geometric: BlockMatrix, stiffness: BlockMatrix) -> np.ndarray:
            inverse = -pencil(basis, geometric, stiffness)
            return np.sort(1.0 / inverse[inverse > 0])[:4]

        basis = null_basis(system)
        expected = factors(basis, whole, system.stiffness())
        row = [name]
        for motions.STIFFNESS, motions.PASSES in PASSES:
            row.append(worst(sk.buckling(system, 4).load_factors, expected))
        free = free_directions(system)
        row += [worst(factors(free, whole, stiffened(system, times)), expected) for times in PENALTIES]
        rows.append([*row, worst(factors(basis, load, system.stiffness()), expected)])
    names = [f"{eta:.0e}, {n}" for eta, n in PASSES] + [f"penalty {times:.0e}" for times in PENALTIES]
    tables.write("conditioned_buckling.csv", "structure; " + "; ".join(names) + "; without curvature", rows)


def of_counts() -> None:
    rows = []
    beside = (1e-3, 1e-4, 1e-5, 1e-6)
    for eta in (1e2, 1e4, 1e6, 1e7, 1e8, 1e9):
        motions.STIFFNESS, wrong = eta, np.zeros(len(beside), int)
        for _, system in structures():
            stiffness, mass = system.stiffness(), system.mass
            expected = pencil(null_basis(system), stiffness, mass)
            elastic = np.flatnonzero(expected > 1e-6 * expected[COUNT])[:COUNT]
            with DirectSolver(system.pattern, system.constraints) as solver:
                held = motions.motions_of(system, solver, system.undeformed, stiffness)
                for k, e in enumerate(beside):
                    for at in np.outer(expected[elastic], (1 - e, 1 + e)).ravel():
                        held.factor(stiffness + (-float(at)) * mass)
                        wrong[k] += held.negative_pivots != (expected < at).sum()
        rows.append([f"{eta:.0e}", *map(str, wrong)])
    head = [f"1 +- {e:.0e}" for e in beside]
    tables.write("conditioned_counts.csv", "P, times; " + "; ".join(head), rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    of_modes()
    of_buckling()
    of_counts()
