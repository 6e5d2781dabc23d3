"""Runs one variant of a program on one scene, in the program's own environment, and prints a line of JSON for each run.

    python -m benchmarks.worker PROGRAM VARIANT SCENE SIZE [SIZE ...] [--runs 3]

What is timed is from the statement of the model to the numbers: mesh, assembly, solution. The start of the interpreter and
imports are not, nor is a first small run that loads what is loaded once. Programs that are started as a process of their
own are timed with it.
"""

import argparse
import importlib
import json
import os
import sys
import time
import traceback
from typing import Any

from benchmarks.programs.program import Program
from benchmarks.scenes import SCENES, Scene

# A run shorter than this is repeated.
SHORT = 2.0


def program(name: str) -> Program:
    """The program of a module in ``benchmarks/programs``."""
    found: Program = importlib.import_module(f"benchmarks.programs.{name}").PROGRAM
    return found


def cpu() -> float:
    """CPU seconds of this process and of those that it has waited for."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


def timed(peer: Program, variant: str, scene: Scene, size: float) -> dict[str, Any]:
    """One run: its values, their error, and what it cost."""
    wall, own = time.perf_counter(), time.process_time()
    before = cpu()
    outcome = peer.run(scene, variant, size)
    wall, own, total = time.perf_counter() - wall, time.process_time() - own, cpu() - before
    # process_time resolves nanoseconds, os.times only hundredths of a second but children, too.
    children = total - own if total - own > 0.02 else 0.0
    return {
        "size": size, "values": {k: outcome.values[k] for k in scene.quantities}, "dofs": int(outcome.dofs),
        "error": scene.error(outcome.values, peer.variants[variant].theory), "cpu": own + children, "wall": wall,
        "note": outcome.note,
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("variant")
    parser.add_argument("scene", choices=SCENES)
    parser.add_argument("sizes", type=float, nargs="+")
    parser.add_argument("--runs", type=int, default=3, help="of every size that takes less than two seconds")
    arguments = parser.parse_args()
    peer, scene = program(arguments.program), SCENES[arguments.scene]
    peer.prepare()
    tell({"version": peer.version()})
    warm = False
    for size in arguments.sizes:
        try:
            if not warm:
                # Loads what is loaded once. The cheapest run there is.
                timed(peer, arguments.variant, scene, arguments.sizes[0])
                warm = True
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
