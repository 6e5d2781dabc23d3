"""Runs every program on every scene, on one thread each, and stores what came out in ``benchmarks/results``.

    python -m benchmarks.compare [--quick] [--scenes NAME ...] [--programs NAME ...]

Programs take turns: a round runs the ladder of sizes of each of them on a scene, then the next round does, so that a slow
spell of the machine meets all of them. The medians of rounds are what is charted. A ladder ends where its time is
up. Programs that are not installed (``make peers``), and scenes that a program cannot run, are stored with the reason.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.ladder import ladder
from benchmarks.machine import RESULTS, facts, write
from benchmarks.programs.program import Program
from benchmarks.scenes import SCENES, Scene
from benchmarks.setup_peers import ready
from benchmarks.worker import program

PROGRAMS = ("ours", "exudyn", "kratos", "opensees", "calculix", "ngsolve")


class Limits(NamedTuple):
    """Seconds for one ladder, rounds, and the seconds up to which a ladder's runs are repeated in later rounds."""

    ladder: float
    rounds: int
    repeated: float


FULL, QUICK = Limits(20.0, 3, 0.5), Limits(1.5, 1, 0.0)
# Scenes in which the peers need longer to reach the accuracy that is asked for.
PATIENCE = {"hemisphere": 4.0, "paper_2n": 2.0, "paper_20n": 2.0}


NO_LIMIT = "a theory with shear has no limit under a force at a point, and this plate is not so thin that it hardly matters"


class Contender(NamedTuple):
    """A variant of a program."""

    module: str
    program: Program
    variant: str

    @property
    def label(self) -> str:
        return self.program.variants[self.variant].label

    def python(self) -> Path | None:
        """The interpreter of its environment; None where there is none."""
        if self.program.environment is None:
            return Path(sys.executable)
        return ready(self.program.environment)

    def reason(self, scene: Scene) -> str | None:
        """Why it does not run a scene."""
        variant = self.program.variants[self.variant]
        if variant.theory in scene.limitless:
            return NO_LIMIT
        if scene.name not in variant.sizes:
            return variant.cannot.get(scene.name, "not set up")
        return None if self.python() else "not installed on this machine: make peers"


def contenders(names: list[str]) -> list[Contender]:
    found = [(name, program(name)) for name in names]
    return [Contender(name, peer, variant) for name, peer in found for variant in peer.variants]


class Runs:
    """What came out on one scene, by contender and size."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.rows: dict[tuple[str, str, float], dict[str, Any]] = {}
        self.versions: dict[str, str] = {}
        self.ends: dict[str, tuple[str, str]] = {}
        """By label: the module, and why a ladder was not finished in the first round, in which all of it is run."""

    def add(self, contender: Contender, line: dict[str, Any]) -> None:
        if "version" in line:
            self.versions[contender.program.name] = line["version"]
            return
        if "end" in line:
            if line["end"]:
                self.ends.setdefault(contender.label, (contender.module, line["end"]))
            return
        key = (contender.module, contender.variant, line["size"])
        theory = contender.program.variants[contender.variant].theory
        head = {
            "program": contender.program.name, "module": contender.module, "variant": contender.variant,
            "label": contender.label, "theory": theory, "size": line["size"], "on": time.strftime("%Y-%m-%d"),
        }  # fmt: skip
        row = self.rows.setdefault(key, {**head, "wall": [], "cpu": []})
        if "failed" in line:
            row["failed"] = line["failed"]
            return
        row.update({name: line[name] for name in ("values", "dofs", "error", "note")})
        row["wall"].append(round(line["wall"], 6))
        row["cpu"].append(round(line["cpu"], 6))

    def of(self, contender: Contender) -> list[dict[str, Any]]:
        """The rows of a contender."""
        own = contender.module, contender.variant
        return [row for row in self.rows.values() if (row["module"], row["variant"]) == own]

    def sizes(self, contender: Contender, repeated: float) -> list[float]:
        """Of the runs that are short enough to be repeated."""
        return [row["size"] for row in self.of(contender) if row["wall"] and min(row["wall"]) <= repeated]


def compare(scene: Scene, entered: list[Contender], limits: Limits) -> Runs:
    """All rounds on one scene."""
    runs = Runs(scene)
    able = [contender for contender in entered if contender.reason(scene) is None]
    for number in range(limits.rounds):
        for contender in able[number % max(len(able), 1) :] + able[: number % max(len(able), 1)]:
            sizes = list(contender.program.variants[contender.variant].sizes[scene.name])
            if number:
                sizes = runs.sizes(contender, limits.repeated)
            if not sizes:
                continue
            began = time.perf_counter()
            arguments = [contender.module, contender.variant, scene.name]
            limit = limits.ladder * PATIENCE.get(scene.name, 1.0)
            for line in ladder(contender.python() or Path(), arguments, sizes, limit):
                runs.add(contender, line)
            print(f"  {number + 1}/{limits.rounds}  {contender.label:<34}{time.perf_counter() - began:7.1f} s  "
                  f"{best(runs, contender)}", flush=True)  # fmt: skip
    return runs


def best(runs: Runs, contender: Contender) -> str:
    """For the progress."""
    own = runs.of(contender)
    done = [r for r in own if "error" in r]
    failed = f", {len(own) - len(done)} failed" if len(own) > len(done) else ""
    ended = runs.ends.get(contender.label, ("", ""))[1]
    found = f"least error {min(r['error'] for r in done):.1e}" if done else "no result"
    return found + failed + (ended and f", {ended}")


def stored(runs: Runs, entered: list[Contender], limits: Limits, old: dict[str, Any]) -> dict[str, Any]:
    """What goes into the file; rows of programs that did not run this time are kept."""
    scene, ran = runs.scene, {contender.module for contender in entered}
    kept = [row for row in old.get("rows", ()) if row["module"] not in ran]
    cannot = [{"module": c.module, "label": c.label, "reason": c.reason(scene)} for c in entered if c.reason(scene)]
    ends = [{"module": module, "label": label, "reason": end} for label, (module, end) in runs.ends.items()]
    machine = facts()
    machine.pop("threads")  # of this process; the workers have one
    return {
        "scene": scene.name, "machine": machine, "threads": 1, "rounds": limits.rounds, "seconds": limits.ladder,
        "versions": {**old.get("versions", {}), **runs.versions},
        "rows": sorted([*kept, *runs.rows.values()], key=lambda row: (row["label"], PROGRAMS.index(row["module"]))),
        "cannot": [*(c for c in old.get("cannot", ()) if c["module"] not in ran), *cannot],
        "apart": sorted({*old.get("apart", ()), *ran}) if kept else [],
        "unfinished": [*(c for c in old.get("unfinished", ()) if c["module"] not in ran), *ends],
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="short runs only, one round: five minutes")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS, default=list(PROGRAMS))
    arguments = parser.parse_args()
    if arguments.quick and "SKANCF_RESULTS" not in os.environ:
        parser.error("--quick would take the place of the kept results: say make bench SET=quick, or set SKANCF_RESULTS")
    limits, entered, began = QUICK if arguments.quick else FULL, contenders(arguments.programs), time.perf_counter()
    for number, name in enumerate(arguments.scenes, 1):
        minutes = (time.perf_counter() - began) / 60
        print(f"{SCENES[name].title} ({number} of {len(arguments.scenes)} scenes, {minutes:.0f} minutes so far)", flush=True)
        file = RESULTS / f"scene_{name}.json"
        runs = compare(SCENES[name], entered, limits)
        old = json.loads(file.read_text(encoding="utf-8")) if file.exists() and arguments.programs != list(PROGRAMS) else {}
        write(file.name, stored(runs, entered, limits, old))


if __name__ == "__main__":
    main()
