"""What a step in time costs: seconds per Newton iteration of a run against those of a static solve, in pairs.

    python benchmarks/dynamics.py [--elements 32] [--runs 3] [--csv FOLDER]

A step may keep the factors of an earlier one; a static iteration never does. Everything that a run does besides counts with
its iterations: error estimate, ledger, output, records. Ratios within one run mean something; the median of pairs is
printed.
"""

import argparse
import csv
import statistics
import time
from pathlib import Path

import numpy as np

import skancf as sk
from skancf.dynamics.recorder import Recorder
from skancf.dynamics.run import Run, Settings
from skancf.progress import Progress

RULES = [sk.GeneralizedAlpha(0.8), sk.EnergyMomentum(), sk.ImplicitMidpoint(), sk.Trapezoidal()]
STEPS = 20


def plate(loads: list) -> sk.Problem:
    return sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(1e7, 0.3, 1000.0), [sk.Clamp("left")], loads)


def static_iteration(n: int, theory: str) -> float:
    """Seconds per iteration of a large bending, set-up of the system left out."""
    problem = plate([sk.EdgeLoad("right", (0.0, 0.0, 5.0))])
    system = problem.on(sk.meshes.uniform(problem.surface, n, n), theory)
    began = time.perf_counter()
    result = sk.solve(system, progress=False)
    return (time.perf_counter() - began) / result.iterations


def run(n: int, theory: str, rule: object, dt: float) -> tuple[float, float, float]:
    """Seconds per iteration of a run, iterations and factorisations per step."""
    problem = plate([sk.EdgeLoad("right", (0.0, 0.0, 5.0))])
    system = problem.on(sk.meshes.uniform(problem.surface, n, n), theory)
    settings = Settings(rule, sk.FixedStep(dt), 0.0, STEPS * dt)
    recorder = Recorder(np.linspace(0, STEPS * dt, 11), {})
    loop = Run(system, settings, recorder, system.undeformed.copy(), np.zeros(system.n_dofs))
    began = time.perf_counter()
    with Progress("", settings.end, shown=False) as bar:
        loop.go(bar)
    seconds = time.perf_counter() - began
    loop.close()
    iterations = sum(step.iterations for step in loop.steps)
    return seconds / iterations, iterations / len(loop.steps), sum(s.factorisations for s in loop.steps) / len(loop.steps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, default=32, help="on a side")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args()
    rows = []
    print(f"{'theory':<11}{'rule':<18}{'dt (s)':>8}{'iterations':>12}{'factors':>9}{'of a static iteration':>23}")
    for theory in ("kirchhoff", "full"):
        for rule in RULES:
            for dt in (1e-3, 2e-2):
                run(2, theory, rule, dt)  # loads, or compiles, what is timed
                pairs = [(static_iteration(arguments.elements, theory), run(arguments.elements, theory, rule, dt))
                         for _ in range(arguments.runs)]  # fmt: skip
                ratio = statistics.median(step[0] / static for static, step in pairs)
                _, iterations, factors = pairs[0][1]
                name = type(rule).__name__
                print(f"{theory:<11}{name:<18}{dt:>8g}{iterations:>12.1f}{factors:>9.2f}{ratio:>23.2f}", flush=True)
                rows.append({"theory": theory, "rule": name, "dt": dt, "iterations per step": round(iterations, 1),
                             "factorisations per step": round(factors, 2), "ratio": round(ratio, 2)})  # fmt: skip
    if arguments.csv:
        with (arguments.csv / "step_cost.csv").open("w", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
