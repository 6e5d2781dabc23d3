"""Fuzz until a time is over: ``python -m fuzz --minutes 60``; what fails is kept in ``out/fuzz/`` as Python."""

import argparse
import random
import time
from pathlib import Path

from fuzz.assessment import seen
from fuzz.properties import PROPERTIES
from fuzz.run import Failure, keep, run

ROUND = 25
"""Examples of a property before the next one's turn."""


def main() -> int:
    """Number of failures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("--only", nargs="*", default=list(PROPERTIES), choices=list(PROPERTIES), metavar="PROPERTY")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"))
    asked = parser.parse_args()
    print(f"seed {asked.seed}, {asked.minutes:g} minutes, {len(asked.only)} properties", flush=True)
    end, rounds, failures = time.monotonic() + 60 * asked.minutes, 0, 0
    while time.monotonic() < end:
        for name in asked.only:
            try:
                run(name, PROPERTIES[name], ROUND, chance=asked.seed + rounds)
            except Failure as failure:
                failures += 1
                path = keep(failure, asked.out, asked.seed + rounds)
                print(f"FAILED {name}: {str(failure.error).splitlines()[0]}\n       {path}", flush=True)
            if time.monotonic() > end:
                break
        rounds += 1
    counts = ", ".join(f"{n} {what}" for what, n in seen.most_common())
    print(f"{rounds} rounds of {ROUND} examples, {failures} failures; {counts}")
    return failures


if __name__ == "__main__":
    raise SystemExit(min(main(), 1))
