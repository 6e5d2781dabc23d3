"""Microseconds per element for residual and tangent, scatter included, and memory per element.

    python benchmarks/kernel.py [--threads 1] [--largest 100000]

The best of several runs is printed: other work on the machine only ever adds time.
"""

import argparse
import os
import time
from collections.abc import Callable
from functools import partial

import numpy as np


def best(function: Callable[[], object], seconds: float = 1.0) -> float:
    """Shortest run of a function within a budget of time."""
    shortest, end = np.inf, time.perf_counter() + seconds
    while True:
        start = time.perf_counter()
        function()
        shortest = min(shortest, time.perf_counter() - start)
        if time.perf_counter() > end:
            return shortest


def megabytes(*objects: object) -> float:
    """Memory of the arrays in objects, one level deep."""
    parts = [o if isinstance(o, tuple) else vars(o).values() if hasattr(o, "__dict__") else [o] for o in objects]
    return sum(a.nbytes for part in parts for a in part if isinstance(a, np.ndarray)) / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--largest", type=int, default=100_000)
    arguments = parser.parse_args()
    os.environ["SKANCF_THREADS"] = str(arguments.threads)
    start = time.perf_counter()
    import skancf as sk

    print(f"import {time.perf_counter() - start:.2f} s, {arguments.threads} thread(s)")
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(0.2e6, 0.3, 2000.0))
    theories = {"full, plain": sk.Full(assumed=False), "full": sk.Full(), "kirchhoff": sk.Kirchhoff()}
    print(f"{'theory':<13}{'elements':>9}{'residual us':>13}{'stress us':>11}{'tangent us':>12}"
          f"{'set-up us':>11}{'matrix kB':>11}{'other kB':>10}")  # fmt: skip
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
                matrix = system.tangent(q, stresses)
                print(f"{name:<13}first call {time.perf_counter() - start:.2f} s (compiles, or loads what was compiled)")
            stresses = system.stresses(q)
            matrix = system.tangent(q, stresses)
            figures = [
                1e6 / count * best(call)
                for call in (
                    partial(system.internal_force, q), partial(system.stresses, q), partial(system.tangent, q, stresses),
                )
            ]  # fmt: skip
            matrix_kb = 1e3 * megabytes(matrix.values) / count
            parts = system.assembly.sections, system.geometry, system.geometry.maps, system.pattern, stresses, q
            other = 1e3 * megabytes(*parts) / count
            print(f"{name:<13}{count:>9}{figures[0]:>13.2f}{figures[1]:>11.2f}{figures[2]:>12.2f}"
                  f"{1e6 * setup / count:>11.1f}{matrix_kb:>11.2f}{other:>10.2f}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
