"""Runs one variant of a program on one scene, in the program's own environment, and prints a line of JSON for each run.

    python -m benchmarks.worker PROGRAM VARIANT SCENE SIZE [SIZE ...] [--runs 2]

What is timed is from the statement of the model to the numbers: mesh, assembly, solution. The start of the interpreter and
imports are not, nor is a first small run that loads what is loaded once. Programs that are started as a process of their
own are timed with it.
"""

import argparse
import contextlib
import importlib
import json
import resource
import sys
import time
import traceback
from typing import Any

from benchmarks.programs.program import Program
from benchmarks.scenes import SCENES, Scene

# A run shorter than this is repeated.
SHORT = 1.0


def program(name: str) -> Program:
    """The program of a module in ``benchmarks/programs``."""
    found: Program = importlib.import_module(f"benchmarks.programs.{name}").PROGRAM
    return found


def cpu() -> float:
    """CPU seconds of this process and of those that it has waited for, to microseconds (``os.times`` counts hundredths)."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def timed(peer: Program, variant: str, scene: Scene, size: float) -> dict[str, Any]:
    """One run: its values, their error, and what it cost."""
    wall, before = time.perf_counter(), cpu()
    outcome = peer.run(scene, variant, size)
    spent, wall = cpu() - before, time.perf_counter() - wall
    return {
        "size": size, "values": {k: outcome.values[k] for k in scene.quantities}, "dofs": int(outcome.dofs),
        "error": scene.error(outcome.values, peer.variants[variant].theory), "cpu": spent, "wall": wall,
        "note": outcome.note,
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("variant")
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("sizes", type=float, nargs="+")
    parser.add_argument("--runs", type=int, default=2, help="of every size that takes less than a second")
    arguments = parser.parse_args()
    peer, scene = program(arguments.program), SCENES[arguments.scene]
    peer.prepare()
    tell({"version": peer.version()})
    # The cheapest run loads what is loaded once; whether it succeeds is told below.
    with contextlib.suppress(Exception):
        timed(peer, arguments.variant, scene, arguments.sizes[0])
    for size in arguments.sizes:
        try:
            for _ in range(arguments.runs):
                row = timed(peer, arguments.variant, scene, size)
                tell(row)
                if row["wall"] > SHORT:
                    break
        except Exception as error:
            traceback.print_exc(file=sys.stderr)
            tell({"size": size, "failed": f"{type(error).__name__}: {error}"[:300]})


def tell(row: dict[str, Any]) -> None:
    print("@" + json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
