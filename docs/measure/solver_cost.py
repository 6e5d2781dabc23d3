"""What a factorisation costs: the table of decision 0002.

From the folder of the repository, in about a minute and with 1 GB of memory:

    .venv/bin/python docs/measure/solver_cost.py 80

The number is the elements along a side of a square plate; 160 asks for some 4 GB. It writes nothing; each solver runs in
a process of its own, because loading MKL changes the BLAS of the others.
"""

import subprocess
import sys
import time

import skancf as sk
from skancf.linear import DirectSolver, available_backends


def measure(backend: str, cells: int, repeats: int = 5) -> None:
    plate = sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("boundary")], [sk.Gravity()]
    )
    system = plate.on(sk.meshes.uniform(plate.surface, cells, cells))
    matrix = system.tangent(system.undeformed)
    force = system.external_force(system.undeformed)
    start = time.perf_counter()
    solver = DirectSolver(system.pattern, system.constraints, backend)
    first = time.perf_counter() - start
    factors, solves = [], []
    for _ in range(repeats if backend == "mkl" else 2):
        start = time.perf_counter()
        solver.factor(matrix)
        middle = time.perf_counter()
        solver.solve(force)
        factors.append(middle - start)
        solves.append(time.perf_counter() - middle)
    print(f"{system.n_dofs} unknowns, {backend}: pattern {first:.2f} s, factor {min(factors):.2f} s, "
          f"solve {min(solves):.3f} s", flush=True)  # fmt: skip


if __name__ == "__main__":
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 80
    if len(sys.argv) > 2:
        measure(sys.argv[2], cells)
    else:
        for backend in available_backends():
            subprocess.run([sys.executable, __file__, str(cells), backend], check=True)
