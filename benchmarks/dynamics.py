"""What a step in time costs, in pairs of runs.

    python benchmarks/dynamics.py [iterations | rules] [--elements 32] [--runs 3] [--csv FOLDER]

``iterations``: seconds per Newton iteration of a run against those of a static solve. A step may keep the factors of an
earlier one; a static iteration never does. ``rules``: the default rule against generalised-alpha at the same fixed steps, on
plates of 12 x 12 elements and a cantilever; ``step_cost.csv``. Everything that a run does besides counts: error estimate,
ledger, output, records. Ratios within one process mean something; the median of pairs is printed.
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
from skancf.progress import Bar

RULES = [sk.EnergyMomentum(), sk.EnergyMomentum(1.0), sk.GeneralizedAlpha(0.8), sk.ImplicitMidpoint(), sk.Trapezoidal()]
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
    with Bar("", settings.end) as bar:
        loop.go(bar)
    seconds = time.perf_counter() - began
    loop.close()
    iterations = sum(step.iterations for step in loop.steps)
    return seconds / iterations, iterations / len(loop.steps), sum(s.factorisations for s in loop.steps) / len(loop.steps)


def corners(theory: str) -> tuple[sk.system.System, float]:
    """The plate of the paper, and the length of its run (s)."""
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.05, sk.Isotropic(0.2e6, 0.0, 2000.0), [sk.Pin("corners")],
                         [sk.PointForce((0.5, 0.5), (0.0, 0.0, -20.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, 12, 12), theory), 0.3


def cantilever(theory: str) -> tuple[sk.system.System, float]:
    """A strip that a force bends by half of its length."""
    surface = sk.Rectangle(0.2, 0.02)
    push = sk.PointForce((0.2, 0.01), (0.0, 0.0, 3.0), history=sk.Ramp(0.05))
    problem = sk.Problem(surface, 0.001, sk.Isotropic(210e9, 0.3, 7850.0), [sk.Clamp("left")], [push])
    return problem.on(sk.meshes.uniform(surface, 16, 2), theory), 0.2


BODIES = {"plate on four corners, 12 x 12": (corners, (2e-2, 5e-3)), "cantilever, 16 x 2": (cantilever, (2e-3, 5e-4))}


def timed(system: sk.system.System, end: float, dt: float, rule: sk.dynamics.rule.Rule) -> tuple[float, sk.Motion]:
    """Milliseconds per step, of the processor, and the run."""
    began = time.process_time()
    motion = sk.simulate(system, end, dt=dt, rule=rule, progress=False, balance=None)
    return 1e3 * (time.process_time() - began) / len(motion.steps), motion


def rules(runs: int) -> list[dict]:
    """The default rule against generalised-alpha."""
    rows = []
    for name, (body, lengths) in BODIES.items():
        for theory in ("kirchhoff", "full"):
            system, end = body(theory)
            for dt in lengths:
                pair = (sk.GeneralizedAlpha(0.8), sk.EnergyMomentum())
                for rule in pair:
                    timed(system, 2 * dt, dt, rule)  # loads, or compiles, what is timed
                found = [[timed(system, end, dt, rule) for rule in pair] for _ in range(runs)]
                row = {"body": name, "theory": theory, "step (ms)": f"{1e3 * dt:g}"}
                for k in range(2):
                    steps, short = found[0][k][1].steps, "GA" if k == 0 else "EM"
                    row[f"{short}: iterations"] = f"{sum(step.iterations for step in steps) / len(steps):.1f}"
                    row[f"{short}: factorisations"] = f"{sum(step.factorisations for step in steps) / len(steps):.2f}"
                    row[f"{short}: ms"] = f"{statistics.median(one[k][0] for one in found):.1f}"
                row["time, EM / GA"] = f"{statistics.median(one[1][0] / one[0][0] for one in found):.2f}"
                print(*row.values(), sep="; ", flush=True)
                rows.append(row)
    return rows


def iterations(elements: int, runs: int) -> list[dict]:
    """Each rule against statics."""
    rows = []
    print(f"{'theory':<11}{'rule':<22}{'dt (s)':>8}{'iterations':>12}{'factors':>9}{'of a static iteration':>23}")
    for theory in ("kirchhoff", "full"):
        for rule in RULES:
            for dt in (1e-3, 2e-2):
                run(2, theory, rule, dt)  # loads, or compiles, what is timed
                pairs = [(static_iteration(elements, theory), run(elements, theory, rule, dt)) for _ in range(runs)]
                ratio = statistics.median(step[0] / static for static, step in pairs)
                _, count, factors = pairs[0][1]
                name = f"{type(rule).__name__}({getattr(rule, 'rho_inf', '')})"
                print(f"{theory:<11}{name:<22}{dt:>8g}{count:>12.1f}{factors:>9.2f}{ratio:>23.2f}", flush=True)
                rows.append({"theory": theory, "rule": name, "dt": dt, "iterations per step": round(count, 1),
                             "factorisations per step": round(factors, 2), "ratio": round(ratio, 2)})  # fmt: skip
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="?", choices=("iterations", "rules"), default="iterations")
    parser.add_argument("--elements", type=int, default=32, help="on a side, of iterations")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--csv", type=Path)
    arguments = parser.parse_args()
    rows = rules(arguments.runs) if arguments.what == "rules" else iterations(arguments.elements, arguments.runs)
    if arguments.csv:
        file = "step_cost.csv" if arguments.what == "rules" else "iteration_cost.csv"
        with (arguments.csv / file).open("w", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
