"""Frequencies and buckling loads with conditions: how stiff, how many passes, penalties and counts, against the null space.

From the folder of the repository, in a minute:

    .venv/bin/python docs/measure/conditioned_modes.py

It writes docs/decisions/conditioned_modes.csv, conditioned_buckling.csv and conditioned_counts.csv.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import scipy.sparse as sp
import tables
from scipy.linalg import eigh, null_space
from scipy.sparse.linalg import eigsh

import skancf as sk
from skancf.conditions import Joint
from skancf.linear import BlockMatrix, DirectSolver
from skancf.linear.conditioned import products, row_stiffness
from skancf.statics import motions
from skancf.statics.conditioned import curved
from skancf.system import System
from skancf.system.linearised import geometric_stiffness

STEEL = sk.Isotropic(young=2e11, poisson=0.3, density=7800.0)
TUBE = sk.CylinderSector(radius=1.0, length=0.5, angle=2 * np.pi)
HINGE, ROD = sk.Hinge("start", "end"), sk.RigidLink((0.0, 0.5), (0.5, 2.5))
CLAMP = (sk.Clamp("left"),)
MODES, LOADS = 10, 4
TAKEN = [(1e4, 2), (1e7, 2), (2e7, 1), (2e7, 2), (2e7, 3), (1e8, 3)]
"""P over the stiffness against a row, and passes."""
PENALTIES = [1e4, 1e6, 1e8]
BESIDE = [1e-3, 1e-4, 1e-5, 1e-6]
RIGID = 1e-6
"""Of the first eigenvalue behind those that are compared: smaller ones are zero."""
HEAD = "; ".join([*(f"{times:.0e} and {n}" for times, n in TAKEN), *(f"penalty {times:.0e}" for times in PENALTIES)])


def tube(
    theory: str, joints: Sequence[Joint] = (HINGE, ROD), supports: Sequence[sk.Clamp] = CLAMP, thickness: float = 0.01,
    loads: Sequence[sk.PointForce] = (), n: tuple[int, int] = (3, 12),
) -> System:  # fmt: skip
    """A tube with a hinge along it and a rod across it."""
    problem = sk.Problem(TUBE, thickness, STEEL, supports, loads, conditions=joints)
    return problem.on(sk.meshes.uniform(TUBE, *n), theory)


def structures() -> Iterator[tuple[str, System]]:
    for theory in ("kirchhoff", "full"):
        yield f"hinge and rod, `{theory}`", tube(theory)
    yield "the same, t / R = 1e-4", tube("full", thickness=1e-4)
    yield "each twice, `kirchhoff`", tube("kirchhoff", (HINGE, ROD, HINGE, ROD))
    yield "free, `kirchhoff`", tube("kirchhoff", supports=())


def pressed() -> Iterator[tuple[str, System]]:
    a, b = (TUBE.position(*map(np.array, at)) for at in (ROD.a, ROD.b))
    for theory in ("kirchhoff", "full"):
        yield f"tube pressed along its rod, `{theory}`", tube(theory, loads=[sk.PointForce(ROD.b, tuple(1e5 * (a - b)))])
    strip = sk.Rectangle(1.0, 0.1)
    strut = sk.RigidLink((0.4, 0.05), (1.0, 0.05), name="strut")
    problem = sk.Problem(strip, 0.01, STEEL, CLAMP, [sk.EdgeLoad("right", (-1e4, 0.0, 0.0))], conditions=[strut])
    yield "strip with a strut, `kirchhoff`", problem.on(sk.meshes.uniform(strip, 10, 2), "kirchhoff")


@contextmanager
def taking(times: float, passes: int = motions.PASSES) -> Iterator[None]:
    """Spectra with another P and number of passes."""
    before = motions.STIFFNESS, motions.PASSES
    motions.STIFFNESS, motions.PASSES = times, passes
    try:
        yield
    finally:
        motions.STIFFNESS, motions.PASSES = before


def free_directions(system: System) -> np.ndarray:
    return motions.free_directions(system.constraints)


def null_basis(system: System) -> np.ndarray:
    """Motions that meet the conditions, by singular values of full matrices: rows (n, n_dofs)."""
    free = free_directions(system)
    rows = system.conditions.gradient(system.undeformed) @ free.T
    sizes = np.linalg.norm(rows, axis=1)
    return null_space(rows[sizes > 1e-10] / sizes[sizes > 1e-10, None], rcond=1e-10).T @ free


def among(basis: np.ndarray, *matrices: BlockMatrix) -> list[np.ndarray]:
    return [basis @ matrix.to_scipy() @ basis.T for matrix in matrices]


def eigenvalues(system: System) -> tuple[np.ndarray, int]:
    """All of the stiffness against the mass, and how many are zero; from their inverses: the low ones have all digits."""
    stiffness, mass = among(null_basis(system), system.stiffness(), system.mass)
    rough = eigh(stiffness, mass, eigvals_only=True)
    rigid = int((rough < RIGID * rough[MODES]).sum())
    shift = 0.1 * rough[rigid] if rigid else 0.0
    return 1.0 / eigh(mass, stiffness + shift * mass, eigvals_only=True)[::-1] - shift, rigid


def lanczos(system: System, stiffness: BlockMatrix, shift: float) -> np.ndarray:
    """The first eigenvalues on all free coordinates."""
    free = sp.csr_matrix(free_directions(system))
    one, other = (sp.csc_matrix(free @ matrix.to_scipy() @ free.T) for matrix in (stiffness, system.mass))
    return np.sort(eigsh(one, MODES, other, sigma=shift, tol=1e-12, return_eigenvectors=False))


def stiffened(system: System, times: float) -> BlockMatrix:
    """The stiffness with a penalty, by the rule for P."""
    rows = system.conditions.gradient(system.undeformed) @ system.constraints.free_projection
    stiffness = system.stiffness()
    held = np.zeros(rows.shape[0], dtype=bool)
    return stiffness + products(stiffness, rows, times * row_stiffness(stiffness, rows, system.constraints, held))


def worst(found: np.ndarray, expected: np.ndarray) -> str:
    return f"{np.abs(found / expected - 1).max():.0e}"


def of_modes() -> None:
    """Errors of the elastic ones among the first ten eigenvalues."""
    rows = []
    finer = "finer mesh, t / R = 1e-3, `kirchhoff`", tube("kirchhoff", thickness=1e-3, n=(3, 32))
    for name, system in (*structures(), finer):
        expected, rigid = eigenvalues(system)
        elastic = expected[rigid:MODES]
        row = [name]
        for times, passes in TAKEN:
            with taking(times, passes):
                row.append(worst(sk.modes(system, MODES).eigenvalues[rigid:], elastic))
        shift = -0.1 * elastic[0] if rigid else 0.0
        row += [worst(lanczos(system, stiffened(system, times), shift)[rigid:], elastic) for times in PENALTIES]
        rows.append(row)
    tables.write("conditioned_modes.csv", f"structure; {HEAD}", rows)


def load_factors(basis: np.ndarray, geometric: BlockMatrix, stiffness: BlockMatrix) -> np.ndarray:
    load, elastic = among(basis, geometric, stiffness)
    inverse = eigh(-load, elastic, eigvals_only=True)
    return np.sort(1.0 / inverse[inverse > 0])[:LOADS]


def of_buckling() -> None:
    """Errors of the first four buckling loads."""
    rows = []
    for name, system in pressed():
        linear, stiffness = sk.solve_linear(system), system.stiffness()
        plain = geometric_stiffness(system, linear.change)
        whole = curved(system, plain, system.undeformed, linear.multipliers)
        basis, free = null_basis(system), free_directions(system)
        expected = load_factors(basis, whole, stiffness)
        row = [name]
        for times, passes in TAKEN:
            with taking(times, passes):
                row.append(worst(sk.buckling(system, LOADS).load_factors, expected))
        row += [worst(load_factors(free, whole, stiffened(system, times)), expected) for times in PENALTIES]
        rows.append([*row, worst(load_factors(basis, plain, stiffness), expected)])
    tables.write("conditioned_buckling.csv", f"structure; {HEAD}; without curvature", rows)


def wrong_counts(system: System) -> np.ndarray:
    """How many numbers of negative pivots are wrong just below and just above each eigenvalue, for each of BESIDE."""
    stiffness, mass = system.stiffness(), system.mass
    expected, rigid = eigenvalues(system)
    elastic = expected[rigid : rigid + MODES]
    wrong = np.zeros(len(BESIDE), dtype=int)
    with DirectSolver(system.pattern, system.constraints) as solver:
        held = motions.motions_of(system, solver, system.undeformed, stiffness)
        for k, share in enumerate(BESIDE):
            for at in np.outer(elastic, (1 - share, 1 + share)).ravel().tolist():
                held.factor(stiffness + (-at) * mass)
                wrong[k] += held.negative_pivots != np.count_nonzero(expected < at)
    return wrong


def of_counts() -> None:
    """Of a hundred numbers for each share: ten eigenvalues of five structures, from both sides."""
    rows = []
    for times in (1e2, 1e4, 1e6, 2e7, 1e8, 1e9):
        with taking(times):
            wrong = sum(wrong_counts(system) for _, system in structures())
        rows.append([f"{times:.0e}", *map(str, wrong)])
    tables.write("conditioned_counts.csv", "P; " + "; ".join(f"1 +- {share:.0e}" for share in BESIDE), rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    of_modes()
    of_buckling()
    of_counts()
