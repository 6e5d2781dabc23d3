"""Is the working tree more than a twentieth slower than a commit?

    python benchmarks/guard_commits.py BASE [--rounds 5] [--seconds 0.5]

BASE is checked out into a temporary folder, and the figures of ``guard.py`` (of this tree, for both) are measured in turns,
BASE, here, BASE, here, ..., each time in a process of its own. So both trees meet the same mood of the machine.

A ratio is slower where both are true:

- the smallest value here is more than 5 % above the smallest value of BASE (other work only ever adds time),
- the median over the rounds of here / BASE is above 1.05 as well (one lucky run of BASE is no proof).

Counts are the same in every run and are slower where they are more than 20 % larger, as in ``guard.py``. A figure that
BASE does not have, or that raises there, is noted and left out; one that raises here alone counts as slower. Exit code 1
where something is slower.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from guard import SLOWER, row, told

ROOT = Path(__file__).resolve().parents[1]
TOLD = 0.05
ROUNDS = 5
SECONDS = 0.5
"""For each ratio, in each round, of each tree."""
Pass = dict[str, dict[str, Any]]
"""What ``guard.one_pass`` returns."""


@dataclass(frozen=True)
class Pair:
    """One figure of both trees, round by round."""

    name: str
    counted: bool
    old: list[float]
    new: list[float]

    @property
    def rounds(self) -> list[float]:
        return [new / old for old, new in zip(self.old, self.new, strict=True)]

    @property
    def slower(self) -> bool:
        change = min(self.new) / min(self.old) - 1
        if self.counted:
            return change > SLOWER
        return change > TOLD and median(self.rounds) > 1 + TOLD

    def __str__(self) -> str:
        if self.counted:
            difference = min(self.new) - min(self.old)
            more = f"{difference:>+10.0f}" if difference else ""
        else:
            more = f"{median(self.rounds) - 1:>+10.1%}{min(self.rounds) - 1:>+10.1%} ..{max(self.rounds) - 1:>+7.1%}"
        return row(self.name, min(self.old), min(self.new), self.slower, more)


def pairs(old: list[Pass], new: list[Pass]) -> list[Pair]:
    """The figures that both trees have, of the rounds in which both have them."""
    found = []
    for kind in ("ratios", "counts"):
        for name in dict.fromkeys(name for one in new for name in one[kind]):
            turns = zip((one[kind] for one in old), (one[kind] for one in new), strict=True)
            both = [(a[name], b[name]) for a, b in turns if name in a and name in b]
            if both:
                found.append(Pair(name, kind == "counts", [a for a, _ in both], [b for _, b in both]))
    return found


def failures(passes: list[Pass]) -> dict[str, str]:
    """What raised in some round, and how."""
    return {name: message for one in passes for name, message in one["failed"].items()}


def compare(old: list[Pass], new: list[Pass]) -> int:
    """Print both trees side by side; 1 where the new one is slower, or raises where the old one does not."""
    print(f"{'figure':<32}{'base':>12}{'here':>12}{'change':>10}{'median':>10}{'rounds':>14}")
    compared, then, now = pairs(old, new), failures(old), failures(new)
    for pair in compared:
        print(pair)
    for name, message in then.items():
        print(f"{name}: raises in BASE, {message}")
    for name, message in now.items():
        print(f"{name}: raises here, {message}")
    broken = [name for name in now if name not in then]
    return told([pair.name for pair in compared if pair.slower] + broken, f"{TOLD:.0%} (counts: {SLOWER:.0%})")


def git(root: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"git {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout.strip()


@contextmanager
def checked_out(commit: str, root: Path = ROOT) -> Iterator[Path]:
    """A folder with the files of a commit, which is gone afterwards, whatever happens."""
    known = git(root, "rev-parse", "--verify", f"{commit}^{{commit}}")
    with tempfile.TemporaryDirectory(prefix="guard-") as folder:
        tree = Path(folder).resolve() / "base"
        try:
            git(root, "worktree", "add", "--detach", str(tree), known)
            yield tree
        finally:
            if str(tree) in git(root, "worktree", "list", "--porcelain"):
                git(root, "worktree", "remove", "--force", str(tree))


def measured(tree: Path, seconds: float) -> Pass:
    """The figures of the package in a folder, of one process."""
    # The folder must win over an installed package, and over the current folder in what the process starts.
    path = os.pathsep.join(filter(None, [str(tree), os.environ.get("PYTHONPATH")]))
    program = str(ROOT / "benchmarks" / "guard.py")
    command = [sys.executable, program, "figures", "--tree", str(tree), "--seconds", str(seconds)]
    done = subprocess.run(command, cwd=tree, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"measuring {tree} failed:\n{done.stderr[-2000:]}")
    found: Pass = json.loads(done.stdout.splitlines()[-1])
    return found


def in_turns(old: Path, new: Path, rounds: int, seconds: float, measure: Callable[[Path, float], Pass] = measured) -> int:
    """Measure both trees, after a first run of each that compiles its kernels, and compare."""
    print("compiling kernels", flush=True)
    for tree in (old, new):
        measure(tree, 0.0)
    passes: dict[Path, list[Pass]] = {old: [], new: []}
    for k in range(rounds):
        print(f"round {k + 1} of {rounds}", flush=True)
        for tree, found in passes.items():
            found.append(measure(tree, seconds))
    return compare(passes[old], passes[new])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("base", help="commit, branch or tag")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="for each ratio, in each round, of each tree")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the temporary folder is removed
    with checked_out(arguments.base) as base:
        return in_turns(base, ROOT, arguments.rounds, arguments.seconds)


if __name__ == "__main__":
    sys.exit(main())
