"""Asks ``adapt`` for every number of the scenes, and assesses its error bars by the right values.

    python -m benchmarks.bars.run [--only TEXT ...] [--jobs 1] [--seconds 60] [--max-dofs 25000] [--name bars]

Writes ``results/bars.json`` with every mesh of every run, and ``bars.md`` beside it. The exit code is 1 where the rule is
broken: see ``assessment.py``.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import skancf as sk
from benchmarks.bars import assessment
from benchmarks.bars.statement import FOLDER, Goal, Scene, scenes
from benchmarks.machine import RESULTS, facts, with_threads, write

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 2.0
"""A scene whose runs take so many times their seconds is ended: the first mesh has no limit of its own."""


def references() -> dict[str, Any]:
    return dict(json.loads((FOLDER / "references.json").read_text(encoding="utf-8")))


def head(scene: Scene, asked: Goal, rtol: float, right: dict[str, Any]) -> dict[str, Any]:
    """What is known of a run before it is begun."""
    return {
        "scene": scene.name, "asked": asked.name, "kinds": list(scene.kinds), "rtol": rtol, "right": right["value"],
        "uncertainty": right["uncertainty"],
    }  # fmt: skip


def run(scene: Scene, asked: Goal, rtol: float, right: dict[str, Any], seconds: float, max_dofs: int) -> dict[str, Any]:
    """One run as it is stored."""
    out = head(scene, asked, rtol, right)
    begun = time.perf_counter()
    try:
        result = sk.adapt(scene.problem, asked.quantity, rtol, max_seconds=seconds, max_dofs=max_dofs, **scene.options())
    except Exception as failed:
        return {**out, "failed": f"{type(failed).__name__}: {failed}", "seconds": round(time.perf_counter() - begun, 2)}
    levels = [
        {"value": level.value, "error": level.error, "bar": level.bar, "dofs": level.n_dofs, "elements": level.n_elements,
         "rejected": level.rejected, "seconds": round(level.total_seconds, 3)}
        for level in result.levels
    ]  # fmt: skip
    return {**out, "value": result.value, "bar": result.error_bar, "corrected": result.corrected,
            "outcome": result.status.name, "message": result.message, "levels": levels,
            "seconds": round(time.perf_counter() - begun, 2)}  # fmt: skip


def stopped(found: dict[str, Any], rtol: float) -> dict[str, Any]:
    """A run as it would have ended with a larger tolerance, on which its meshes do not depend."""
    if found.get("failed"):
        return {**found, "rtol": rtol}
    best = None
    for n, level in enumerate(found["levels"]):
        best = best if level["rejected"] else level
        if best["bar"] <= rtol * abs(best["value"]):
            seconds = round(sum(one["seconds"] for one in found["levels"][: n + 1]), 2)
            return {
                **found, "rtol": rtol, "value": best["value"], "bar": best["bar"],
                "corrected": best["value"] + best["error"],
                "outcome": "REACHED", "message": "", "levels": found["levels"][: n + 1], "seconds": seconds,
            }  # fmt: skip
    return {**found, "rtol": rtol}


def of_scene(name: str, only: list[str], seconds: float, max_dofs: int) -> Iterator[dict[str, Any]]:
    """The runs of a scene; but for zeros those of larger tolerances are read off that of the smallest."""
    warnings.simplefilter("ignore", sk.OutOfDepth)
    right = references()
    scene = next(scene for scene in scenes() if scene.name == name)
    for asked in scene.asked:
        if not wanted(scene, asked, only):
            continue
        *larger, smallest = sorted(asked.tolerances, reverse=True)
        strict = run(scene, asked, smallest, right[scene.name][asked.name], seconds, max_dofs)
        for rtol in larger:
            if strict["right"] == 0:
                yield run(scene, asked, rtol, right[scene.name][asked.name], seconds, max_dofs)
            else:
                yield stopped(strict, rtol)
        yield strict


def wanted(scene: Scene, asked: Goal, only: list[str]) -> bool:
    """Is one of the texts in the names, or a kind of the scene?"""
    title = f"{scene.name}: {asked.name}"
    return not only or any(text in title or text in scene.kinds for text in only)


def in_process(scene: Scene, arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """All runs of a scene, in a process of its own that is ended where it hangs."""
    command = [sys.executable, "-m", "benchmarks.bars.run", "--one", scene.name, "--seconds", str(arguments.seconds),
               "--max-dofs", str(arguments.max_dofs), "--only", *arguments.only]  # fmt: skip
    asked = [(one, rtol) for one in scene.asked if wanted(scene, one, arguments.only) for rtol in one.tolerances]
    limit = 60 + PATIENCE * arguments.seconds * len(asked)
    began = time.perf_counter()
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=with_threads(1), capture_output=True, text=True, timeout=limit, check=False
        )
        said, last = done.stdout, done.stderr.strip().splitlines()[-1:] or [""]
    except subprocess.TimeoutExpired as over:
        said, last = (over.stdout or b"").decode(), [f"ended after {limit:.0f} s"]
    runs = [json.loads(line[1:]) for line in said.splitlines() if line.startswith("@")]
    right = references()[scene.name]
    for one, rtol in asked[len(runs) :]:
        seconds = round(time.perf_counter() - began, 2)
        runs.append({**head(scene, one, rtol, right[one.name]), "failed": f"no answer: {last[0]}", "seconds": seconds})
    for one in runs:
        tell(one)
    return runs


def tell(found: dict[str, Any]) -> None:
    what = "; ".join(assessment.broken(found))
    if not found.get("failed"):
        end = assessment.last(found)
        size = "   -" if end.efficiency is None else f"{end.efficiency:4.3g}"
        what = f"{size} {found['outcome']:<9}{end.dofs:>7} dofs {found['seconds']:>5.1f} s" + (
            f"  BROKEN {what}" if what else ""
        )
    print(f"{assessment.title(found):<70.70} {what}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[], metavar="TEXT", help="in names of scenes and quantities, or a kind")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--seconds", type=float, default=60.0, help="max_seconds of each run, long, so that a busy machine decides nothing"
    )
    parser.add_argument("--max-dofs", type=int, default=25_000)
    parser.add_argument("--name", default="bars", help="of the files in benchmarks/results")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        for found in of_scene(arguments.one, arguments.only, arguments.seconds, arguments.max_dofs):
            print("@" + json.dumps(found), flush=True)
        return 0
    chosen = [scene for scene in scenes() if any(wanted(scene, one, arguments.only) for one in scene.asked)]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        runs = [found for part in pool.map(lambda scene: in_process(scene, arguments), chosen) for found in part]
    machine = facts()
    write(
        f"{arguments.name}.json",
        {"machine": machine, "seconds": arguments.seconds, "max_dofs": arguments.max_dofs, "runs": runs},
    )
    (RESULTS / f"{arguments.name}.md").write_text(assessment.markdown(runs), encoding="utf-8")
    total = assessment.summary(runs)
    print(assessment.told(total), RESULTS / f"{arguments.name}.md", sep="", end=os.linesep)
    return 0 if total.holds else 1


if __name__ == "__main__":
    sys.exit(main())
