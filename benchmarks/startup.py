"""What a process pays before its first number: import, first solve with kernels at hand and without, later solves.

    python benchmarks/startup.py [--runs 5] [--cold 1] [--out benchmarks/results/startup.json]

Each figure is the median of fresh processes, in seconds of CPU time: wall time where nothing else runs, and all that can be
compared where something does. Cold means an empty folder of compiled kernels.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from skancf.atomic import check_file, replacing

RESULTS = Path(__file__).parent / "results" / "startup.json"
THEORIES = ("kirchhoff", "full")
# Runs in a fresh process: a strip with a force at its free end, bent by two thirds of its length.
PROBE = """
import json, sys, time
begin = time.process_time()
import skancf as sk
ready, modules = time.process_time(), len(sys.modules)

def number():
    strip = sk.Problem(
        sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), supports=[sk.Clamp("left")],
        loads=[sk.EdgeLoad("right", (0.0, 0.0, 4.0))],
    )
    system = strip.on(sk.meshes.uniform(strip.surface, 8, 1), sys.argv[1])
    return sk.solve(system).unwrap().displacement((10.0, 0.5))[2]

def seconds():
    begin = time.process_time()
    assert 6.6 < number() < 6.8
    return time.process_time() - begin

first = seconds()
later = min(seconds() for _ in range(10))
print(json.dumps({"import": ready - begin, "modules": modules, "first solve": first, "later solve": later}))
"""


def probe(theory: str, cache: str | None = None) -> dict[str, float]:
    """Figures of one fresh process, with compiled kernels in a folder ``cache`` or in their usual place."""
    environment = {**os.environ, "SKANCF_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    # As an installed package is: with its byte code at hand.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    if cache:
        environment["NUMBA_CACHE_DIR"] = cache
    shown = subprocess.run(
        [sys.executable, "-c", PROBE, theory], capture_output=True, text=True, check=True, env=environment
    )
    return dict(json.loads(shown.stdout))


def cold(theory: str) -> float:
    """Seconds of a first solve that compiles."""
    with tempfile.TemporaryDirectory() as cache:
        return probe(theory, cache)["first solve"]


def measure(runs: int, cold_runs: int) -> dict[str, dict[str, float]]:
    out = {}
    for theory in THEORIES:
        probe(theory)  # compiles, writes byte code
        found = [probe(theory) for _ in range(runs)]
        out[theory] = {name: round(statistics.median(one[name] for one in found), 5) for name in found[0]}
        if cold_runs:
            out[theory]["first solve, cold"] = round(statistics.median(cold(theory) for _ in range(cold_runs)), 3)
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--cold", type=int, default=1, help="processes that compile; 0 leaves them out")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    check_file(arguments.out, ".json")
    found = measure(arguments.runs, arguments.cold)
    for name in found["kirchhoff"]:
        print(f"{name:<20}" + "".join(f"{theory:>12} {figures[name]:<10.5g}" for theory, figures in found.items()))
    with replacing(arguments.out) as file:
        file.write_text(json.dumps(found, indent=1) + "\n")
    print(f"-> {arguments.out}")


if __name__ == "__main__":
    main()
