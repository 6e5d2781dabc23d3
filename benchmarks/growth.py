"""How time and memory of each part of a Newton iteration grow, from a thousand to a million unknowns.

    python -m benchmarks.growth [--largest 1000000] [--threads 1 2]

A square plate in theory `kirchhoff`, one process for each size. Seconds are those of the processor with one thread and
of the clock with several; memory is what a part takes at most besides what was in use when it began. Exponents are
those of a least squares line through the logarithms, over the sizes on which a part takes more than NOISE. The estimate
solves on a mesh of four times as many elements, so it goes to a quarter of the largest size; its own part is counted
without that solve too.
Writes results/growth.json.
"""

import argparse
import json
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

import skancf as sk
from benchmarks.machine import clock, facts, forget_peak, peak_memory, resident_memory, with_threads, write
from skancf.adaptive.estimate import goal_estimate
from skancf.adaptive.grow import Growth
from skancf.adaptive.transfer import transfer
from skancf.linear import DirectSolver

SIDES = (9, 16, 28, 50, 90, 160, 288)
"""Elements along a side: 1.2 thousand to a million unknowns."""
NOISE = 2e-3
"""Seconds; shorter parts are not fitted."""
RUNS, PATIENCE = 5, 2.0
"""The best of so many runs counts; no further one is begun after so many seconds."""
LIMITS = {
    "set-up": 1.1, "residual": 1.02, "stresses": 1.02, "tangent": 1.02, "symbolic": 1.1, "factor": 1.5, "solve": 1.1,
    "estimate": 1.5, "estimate, own": 1.1, "refine": 1.1, "transfer": 1.1,
}  # fmt: skip
"""Parts, and exponents to stay below. The estimate contains a factorisation."""


def plate() -> sk.Problem:
    return sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(1e7, 0.3, 1000.0), [sk.Clamp("left")],
        [sk.EdgeLoad("right", (0.0, 0.0, 5.0))],
    )  # fmt: skip


class Meter:
    """Seconds and memory of the parts by their names."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.gigabytes: dict[str, float] = {}

    def take(self, name: str, work: Callable[[], Any], runs: int = RUNS) -> Any:
        forget_peak()
        before = resident_memory()
        times: list[float] = []
        while len(times) < runs and sum(times) < PATIENCE:
            begun = clock()
            out = work()
            times.append(clock() - begun)
            if len(times) == 1:
                self.gigabytes[name] = peak_memory() - before
        self.seconds[name] = min(times)
        return out


@contextmanager
def seconds_in_solvers() -> Iterator[list[float]]:
    """What calls of the direct solver take."""
    spent: list[float] = []
    names = ("__init__", "factor", "solve", "close")
    kept = {name: getattr(DirectSolver, name) for name in names}

    def timed(call: Callable[..., Any]) -> Callable[..., Any]:
        def inner(*arguments: Any, **options: Any) -> Any:
            begun = clock()
            try:
                return call(*arguments, **options)
            finally:
                spent.append(clock() - begun)

        return inner

    for name, call in kept.items():
        setattr(DirectSolver, name, timed(call))
    try:
        yield spent
    finally:
        for name, call in kept.items():
            setattr(DirectSolver, name, call)


def measure(n: int, largest: int, meter: Meter) -> dict[str, Any]:
    problem = plate()
    mesh = sk.meshes.quadtree(sk.meshes.uniform(problem.surface, n, n))
    system = meter.take("set-up", lambda: problem.on(sk.meshes.uniform(problem.surface, n, n), "kirchhoff"))
    system = problem.on(mesh, "kirchhoff")
    bent = system.undeformed.copy()
    x = system.geometry.undeformed[:, 0, 0]
    bent.reshape(-1, 4, 3)[:, :2, 2] += np.stack([0.05 * np.sin(3 * x), 0.15 * np.cos(3 * x)], axis=1)
    force = system.external_force(bent)
    meter.take("residual", lambda: system.internal_force(bent))
    stresses = meter.take("stresses", lambda: system.stresses(bent, bent - system.undeformed))
    matrix = meter.take("tangent", lambda: system.tangent(bent, stresses=stresses))
    solver = meter.take("symbolic", lambda: DirectSolver(system.pattern, system.constraints), runs=1)
    meter.take("factor", lambda: solver.factor(matrix))
    meter.take("solve", lambda: solver.solve(force))
    predicted, backend = solver.memory - matrix.values.nbytes, solver.description
    solver.close()
    state = sk.Solution(system, system.undeformed + 1e-3 * (bent - system.undeformed), linear=True)
    radius = np.hypot(*(mesh.p[:, mesh.t].mean(axis=1) - 0.3))
    points = np.zeros((2, 0))
    finer = meter.take("refine", lambda: Growth(sk.Doerfler(0.5)).next_mesh(system.geometry, np.exp(-9 * radius), points))
    fine = problem.on(finer, "kirchhoff")
    meter.take("transfer", lambda: transfer(state, fine))
    if 4 * system.n_dofs <= 1.1 * largest:
        with seconds_in_solvers() as spent:
            meter.take("estimate", lambda: goal_estimate(state, sk.Displacement((0.5, 0.5))), runs=1)
        meter.seconds["estimate, own"] = meter.seconds["estimate"] - sum(spent)
    return {
        "unknowns": system.n_dofs, "elements": mesh.nelements, "refined_elements": finer.nelements, "backend": backend,
        "predicted_gb": predicted / 1e9, "seconds": meter.seconds, "memory_gb": meter.gigabytes, "machine": facts(),
    }  # fmt: skip


def exponent(rows: list[dict[str, Any]], kind: str, name: str) -> dict[str, Any] | None:
    """Of the growth of a part, over the sizes on which it takes more than noise; None for fewer than three of them."""
    floor = NOISE if kind == "seconds" else 5e-3
    used = [(row["unknowns"], row[kind][name]) for row in rows if row[kind].get(name, 0.0) > floor]
    if len(used) < 3:
        return None
    slope = np.polyfit(*np.log(np.transpose(used)), 1)[0]
    return {"exponent": round(float(slope), 3), "from": used[0][0], "to": used[-1][0]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=1_000_000, help="unknowns")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", sk.OutOfDepth)
    if arguments.one:
        measure(3, 10_000, Meter())  # loads, or compiles, what is measured
        print(json.dumps(measure(arguments.one, arguments.largest, Meter())))
        return
    runs: list[dict[str, Any]] = []
    for threads in arguments.threads:
        rows: list[dict[str, Any]] = []
        print(f"\n{threads} thread(s); milliseconds\n{'unknowns':>9}" + "".join(f"{name:>14}" for name in LIMITS))
        for n in SIDES:
            if 12 * (n + 1) ** 2 > 1.1 * arguments.largest:
                continue
            command = [sys.executable, "-m", "benchmarks.growth", "--one", str(n), "--largest", str(arguments.largest)]
            done = subprocess.run(command, env=with_threads(threads), stdout=subprocess.PIPE, text=True, check=True)
            rows.append(json.loads(done.stdout))
            machine = rows[-1].pop("machine")
            seconds = rows[-1]["seconds"]
            print(f"{rows[-1]['unknowns']:>9}"
                  + "".join(f"{1e3 * seconds.get(name, np.nan):>14.2f}" for name in LIMITS), flush=True)  # fmt: skip
        fits = {kind: {name: exponent(rows, kind, name) for name in LIMITS} for kind in ("seconds", "memory_gb")}
        for kind, fitted in fits.items():
            print(f"{kind[:6]:>9}" + "".join(f"{fit['exponent'] if fit else '-':>14}" for fit in fitted.values()))
        print(f"{'limit':>9}" + "".join(f"{limit:>14}" for limit in LIMITS.values()))
        machine.pop("threads")
        runs.append({"threads": threads, "rows": rows, "exponents": fits})
        write("growth.json", {"machine": machine, "limits": LIMITS, "noise_seconds": NOISE, "runs": runs})


if __name__ == "__main__":
    main()
