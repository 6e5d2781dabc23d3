"""Microseconds per element for residual and tangent, scatter included, and memory per element.

    python -m benchmarks.kernel [--threads 1] [--largest 100000]

The best of several runs is printed, of one thread in processor time: other work on the machine only ever adds to it. The
last column is the share of the peak that the tangent reaches: the arithmetic of its matrix products, as coded and counted in
:func:`products`, over its time and what a large matrix product of numpy does per second on as many cores. That product runs
in a process of its own, with one thread and without ``OPENBLAS_CORETYPE``, which where it is set makes numpy use the
instructions of another processor.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np


def best(function: Callable[[], object], clock: Callable[[], float], seconds: float = 1.0) -> float:
    """Shortest run of a function within a budget of time."""
    shortest, end = np.inf, time.perf_counter() + seconds
    while True:
        start = clock()
        function()
        shortest = min(shortest, clock() - start)
        if time.perf_counter() > end:
            return shortest


def megabytes(*objects: object) -> float:
    """Memory of the arrays in objects, one level deep."""
    parts = [o if isinstance(o, tuple) else vars(o).values() if hasattr(o, "__dict__") else [o] for o in objects]
    return sum(a.nbytes for part in parts for a in part if isinstance(a, np.ndarray)) / 1e6


def gigaflops() -> float:
    """What a matrix product of numpy does per second on one core, in 1e9 multiplications and additions."""
    program = """
import time
import numpy as np
a = np.random.default_rng(0).random((1200, 1200))
best, end = np.inf, time.perf_counter() + 3
while time.perf_counter() < end:
    start = time.thread_time()
    a @ a
    best = min(best, time.thread_time() - start)
print(2e-9 * 1200**3 / best)
"""
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_CORETYPE"}
    environment |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    return float(run.stdout)


def products(theory: str) -> list[tuple[int, int, int]]:
    """The matrix products in the tangent of a flat element of one class: rows, terms of each sum, columns.

    In the order of the kernels. 16 points and 16 functions; pairs of components are 9, or the 6 upper ones. What else is
    done at the points, gather, symmetric part and scatter are not counted.
    """
    if theory == "kirchhoff":
        return [
            (3, 16, 80),  # jets
            (6, 16, 256),  # normals . S
            (16 * 2 * 9, 5, 16),  # A
            (9 * 16, 32, 16),  # A . slopes
            (16 * 9, 2, 16), (16 * 9, 2, 16),  # gradients and forces of the membrane strains at the points
            (16, 16, 48), (16, 16, 48), (16, 16, 48),  # G, the same for the rest, law . G
            (9 * 16, 16, 16),  # G . Z
        ]  # fmt: skip
    n_rows = 80 if theory == "full, plain" else 28
    return [
        # Law of the sampled strains . their gradient: of plain strains diagonal, five entries at each point.
        (5 * 16, 1, 48) if theory == "full, plain" else (n_rows, n_rows, 48),
        (6 * 16, n_rows, 16),  # gradient . that
        (64 * 6, 4, 16),  # W
        (6 * 16, 32, 16),  # W . slopes of r
        (6 * 16, 32, 4),  # W . slopes of d
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--largest", type=int, default=100_000)
    arguments = parser.parse_args()
    os.environ["SKANCF_THREADS"] = str(arguments.threads)
    start = time.perf_counter()
    import skancf as sk
    from benchmarks.machine import facts, write

    print(f"import {time.perf_counter() - start:.2f} s, {arguments.threads} thread(s)")
    clock = time.thread_time if arguments.threads == 1 else time.perf_counter
    peak = gigaflops()
    print(f"matrix product of numpy on one core: {peak:.0f} GFlop/s")
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(0.2e6, 0.3, 2000.0))
    theories = {"full, plain": sk.Full(assumed=False), "full": sk.Full(), "kirchhoff": sk.Kirchhoff()}
    rows: list[dict[str, Any]] = []
    print(f"{'theory':<13}{'elements':>9}{'residual us':>13}{'stress us':>11}{'tangent us':>12}"
          f"{'set-up us':>11}{'matrix kB':>11}{'other kB':>10}{'kFlop':>7}{'of peak':>9}")  # fmt: skip
    for name, theory in theories.items():
        for n in (10, 32, 100, 316):
            count = n * n
            if count > arguments.largest:
                continue
            start = time.perf_counter()
            system = plate.on(sk.meshes.uniform(plate.surface, n, n), theory)
            setup = time.perf_counter() - start
            q = system.undeformed + 1e-3 * np.random.default_rng(0).standard_normal(system.n_dofs) / n
            if n == 10:
                start = time.perf_counter()
                system.internal_force(q)
                stresses = system.stresses(q)
                matrix = system.tangent(q, stresses=stresses)
                print(f"{name:<13}first call {time.perf_counter() - start:.2f} s (compiles, or loads what was compiled)")
            stresses = system.stresses(q)
            matrix = system.tangent(q, stresses=stresses)
            figures = [
                1e6 / count * best(call, clock)
                for call in (
                    partial(system.internal_force, q), partial(system.stresses, q), partial(system.tangent, q, stresses),
                )
            ]  # fmt: skip
            matrix_kb = 1e3 * megabytes(matrix.values) / count
            parts = system.assembly.sections, system.geometry, system.geometry.maps, system.pattern, stresses, q
            other = 1e3 * megabytes(*parts) / count
            work = 2e-3 * sum(m * terms * n for m, terms, n in products(name))
            share = work / figures[2] / (arguments.threads * peak)
            rows.append({
                "theory": name, "elements": count, "residual": figures[0], "stresses": figures[1], "tangent": figures[2],
                "kiloflops": work, "share": share,
            })  # fmt: skip
            print(f"{name:<13}{count:>9}{figures[0]:>13.2f}{figures[1]:>11.2f}{figures[2]:>12.2f}"
                  f"{1e6 * setup / count:>11.1f}{matrix_kb:>11.2f}{other:>10.2f}{work:>7.0f}{share:>9.0%}",
                  flush=True)  # fmt: skip
    found = {"machine": facts(), "threads": arguments.threads, "peak_gigaflops": peak, "rows": rows}
    print(write("kernels.json", found))


if __name__ == "__main__":
    main()
