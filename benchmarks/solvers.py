"""Direct solvers on tangents of a bent shell, on uniform meshes and on meshes graded to a corner: time, memory, residual.

    python -m benchmarks.solvers [--largest 320000] [--threads 1 2] [--csv docs/decisions]

Each measurement has a process of its own, because loading MKL changes the BLAS of the others. The shell is a quarter of a
hemisphere with a hole, pulled and pushed far beyond its linear range; its state on a coarse mesh is taken to the finer ones
of the same tree. Writes results/solvers.json.
"""

import argparse
import csv
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from math import pi, radians
from pathlib import Path
from typing import Any

import numpy as np

import skancf as sk
from benchmarks.machine import clock, facts, forget_peak, peak_memory, resident_memory, with_threads, write
from skancf.adaptive.transfer import transfer
from skancf.linear import BlockMatrix, DirectSolver, available_backends
from skancf.system.system import System

ROOT, COARSE = 5, 10
"""Elements along a side: of the trees, and of the mesh on which the state is solved for."""
MESHES = (("uniform", 20), ("uniform", 40), ("uniform", 80), ("uniform", 160), ("graded", 20_000), ("graded", 80_000))
"""Uniform with elements along a side (5, 20, 79, 311 thousand unknowns); graded with about so many unknowns."""
SLOWEST = {"superlu": 100_000}
"""Most unknowns that a solver is given."""
RUNS, PATIENCE = 5, 3.0
"""The best of so many runs counts; no further one is begun after so many seconds."""
CORNER = (pi / 2, 0.0)


def shell() -> sk.Problem:
    """100 at each of the two forces of the quarter: displacements of a third of the radius."""
    return sk.Problem(
        sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2), 0.04, sk.Isotropic(6.825e7, 0.3, 1.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller(CORNER)],
        [sk.PointForce(CORNER, (100.0, 0, 0)), sk.PointForce((pi / 2, pi / 2), (0, -100.0, 0))],
    )  # fmt: skip


def uniform(problem: sk.Problem, n: int) -> Any:
    mesh = sk.meshes.quadtree(sk.meshes.uniform(problem.surface, ROOT, ROOT))
    while 4 * mesh.nelements <= n * n:
        mesh = mesh.refined()
    return mesh


def graded(problem: sk.Problem, n_dofs: int) -> Any:
    """Elements in proportion to their distance from the corner, down to 2^-14 of the side."""
    ratio, mesh = 1.0, uniform(problem, COARSE)
    while 12 * (mesh.p.shape[1] - len(mesh.hanging)) < n_dofs:
        ratio *= 0.9
        while True:
            middle, size = mesh.p[:, mesh.t].mean(axis=1), np.ptp(mesh.p[1, mesh.t], axis=0)
            distance = np.hypot(*(middle - np.array(CORNER)[:, None]))
            large = np.flatnonzero((size > ratio * distance) & (size > 2.0**-14 * pi))
            if not large.size:
                break
            mesh = mesh.refined(large)
    return mesh


def tangent(kind: str, size: int) -> tuple[System, BlockMatrix]:
    problem = shell()
    coarse = problem.on(uniform(problem, COARSE), "kirchhoff")
    state = sk.solve(coarse, backend="superlu").unwrap()
    fine = problem.on({"uniform": uniform, "graded": graded}[kind](problem, size), "kirchhoff")
    return fine, fine.tangent(transfer(state, fine).q)


def best(work: Callable[[], Any]) -> float:
    times: list[float] = []
    while len(times) < RUNS and sum(times) < PATIENCE:
        begun = clock()
        work()
        times.append(clock() - begun)
    return min(times)


def measure(backend: str, kind: str, size: int) -> dict[str, Any]:
    """One solver on one tangent, in this process."""
    system, matrix = tangent(kind, size)
    small = shell().on(uniform(shell(), ROOT), "kirchhoff")
    with DirectSolver(small.pattern, small.constraints, backend) as solver:  # loads what is measured
        solver.factor(small.stiffness())
    begin = resident_memory()
    forget_peak()
    begun = clock()
    solver = DirectSolver(system.pattern, system.constraints, backend)
    symbolic = clock() - begun
    predicted = solver.memory - matrix.values.nbytes
    analysis, analysed = peak_memory() - begin, resident_memory()
    forget_peak()
    solver.factor(matrix)
    scaled = solver._system
    rhs = np.random.default_rng(0).standard_normal(system.n_dofs)
    solution, factors = solver.solve(rhs), peak_memory() - analysed
    b = scaled.restrict(rhs)
    x = scaled.constraints.to_frame(solution) / np.where(scaled.scale == 0, 1.0, scaled.scale).ravel()
    residual = np.linalg.norm(b - scaled.multiply(x)) / (np.linalg.norm(b) + np.linalg.norm(scaled.multiply_sizes(x)))
    return {
        "mesh": kind, "elements": system.mesh.nelements, "unknowns": system.n_dofs, "backend": backend,
        "symbolic": symbolic, "factor": best(lambda: solver.factor(matrix)),
        "factor_alone": best(lambda: solver._backend.factor(scaled.values)), "solve": best(lambda: solver.solve(rhs)),
        "memory_gb": max(analysis, analysed - begin + factors), "factors_gb": factors, "predicted_gb": predicted / 1e9,
        "residual": residual, "negative_pivots": solver.negative_pivots, "machine": facts(),
    }  # fmt: skip


def table(rows: list[dict[str, Any]], path: Path) -> None:
    """The table of decision 0012."""
    columns = {"mesh": "mesh", "unknowns": "unknowns", "backend": "solver", "threads": "threads", "symbolic": "analysis s",
               "factor": "factor s", "solve": "solve s", "of_first": "of the first", "memory_gb": "GB"}  # fmt: skip
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns.values())
        writer.writerows([f"{v:.2g}" if isinstance(v := row[key], float) else v for key in columns] for row in rows)


def unknowns(kind: str, size: int) -> int:
    return 12 * (size + 1) ** 2 if kind == "uniform" else size


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=320_000, help="unknowns")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--csv", type=Path, help="folder to write a table to")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", sk.OutOfDepth)
    if arguments.one:
        backend, kind, size = arguments.one
        print(json.dumps(measure(backend, kind, int(size))))
        return
    rows = []
    print(f"{'mesh':<9}{'unknowns':>9} {'solver':<9}{'threads':>7}{'symbolic s':>12}{'factor s':>10}{'solve s':>9}"
          f"{'of 1st':>8}{'GB':>7}{'factors GB':>12}{'predicted':>11}{'residual':>10}")  # fmt: skip
    for kind, size in MESHES:
        for threads in arguments.threads:
            first = None
            for backend in available_backends():
                if unknowns(kind, size) > min(arguments.largest, SLOWEST.get(backend, arguments.largest)):
                    continue
                command = [sys.executable, "-m", "benchmarks.solvers", "--one", backend, kind, str(size)]
                done = subprocess.run(command, env=with_threads(threads), stdout=subprocess.PIPE, text=True, check=True)
                row = {"threads": threads, **json.loads(done.stdout)}
                machine = row.pop("machine")
                rows.append(row)
                total = row["factor"] + row["solve"]
                first = first or total
                row["of_first"] = total / first
                print(f"{kind:<9}{row['unknowns']:>9} {backend:<9}{threads:>7}{row['symbolic']:>12.3f}{row['factor']:>10.4f}"
                      f"{row['solve']:>9.4f}{row['of_first']:>8.2f}{row['memory_gb']:>7.2f}"
                      f"{row['factors_gb']:>12.3f}{row['predicted_gb']:>11.3f}{row['residual']:>10.1e}",
                      flush=True)  # fmt: skip
                machine.pop("threads")
                write("solvers.json", {"machine": machine, "rows": rows})
    if arguments.csv:
        table(rows, arguments.csv / "solvers.csv")


if __name__ == "__main__":
    main()
