"""All that is measured of speed and of error bars, one after the other, and the results page made of it.

    python -m benchmarks.bench [all | quick]

``all`` takes about an hour and a half and stores its results in ``benchmarks/results``, where they are kept with the
code; the page goes to ``docs/results``. ``quick`` takes five minutes and keeps its results, and its page, in ``out/bench``.
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "bench"
STEPS = {
    "all": (
        ("start-up", ["benchmarks.startup"]),
        ("guard", ["benchmarks.guard", "check"]),
        ("kernels", ["benchmarks.kernel"]),
        ("linear solvers", ["benchmarks.solvers"]),
        ("growth", ["benchmarks.growth"]),
        ("comparison", ["benchmarks.compare"]),
        ("error bars", ["benchmarks.bars.run"]),
        ("page", ["benchmarks.page"]),
    ),
    "quick": (
        ("kernels", ["benchmarks.kernel", "--largest", "2000"]),
        ("comparison", ["benchmarks.compare", "--quick"]),
        ("page", ["benchmarks.page", "--out", str(OUT)]),
    ),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("set", nargs="?", choices=STEPS, default="all")
    chosen, began, failed = parser.parse_args().set, time.perf_counter(), []
    environment = dict(os.environ)
    if chosen == "quick":
        environment["SKANCF_RESULTS"] = str(OUT)
    for number, (name, module) in enumerate(STEPS[chosen], 1):
        minutes = (time.perf_counter() - began) / 60
        print(f"\n== {name} ({number} of {len(STEPS[chosen])}, {minutes:.0f} minutes so far)", flush=True)
        if subprocess.run([sys.executable, "-m", *module], cwd=ROOT, env=environment, check=False).returncode:
            failed.append(name)
    print(f"\n{(time.perf_counter() - began) / 60:.0f} minutes" + (f"; failed: {', '.join(failed)}" if failed else ""))
    return len(failed)


if __name__ == "__main__":
    sys.exit(main())
