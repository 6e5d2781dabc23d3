"""The parts of the results page that are about skancf alone: error bars, kernels, linear solvers, growth, start-up."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks import charts
from benchmarks.bars import assessment
from benchmarks.machine import RESULTS
from benchmarks.rst import chart, machine, table, title


def kernels(stored: dict[str, Any], folder: Path) -> str:
    """What an element costs."""
    names = ("residual", "stresses", "tangent")
    rows = [
        [row["theory"], str(row["elements"]), *(f"{row[name]:.2f}" for name in names), f"{row['kiloflops']:.0f}",
         f"{row['share']:.0%}"]
        for row in stored["rows"]
    ]  # fmt: skip
    text = (f"Microseconds per element on {stored['threads']} thread(s), gather and scatter included; the arithmetic of the "
            f"tangent's matrix products, and its share of the {stored['peak_gigaflops']:.0f} GFlop/s that a large matrix "
            f"product reaches on one core. {machine(stored)}\n\n")  # fmt: skip
    header = ["theory", "elements", *(f"{name} (us)" for name in names), "kFlop", "of the peak"]
    return title("Kernels", "-") + text + table(header, rows)


def solvers(stored: dict[str, Any], folder: Path) -> str:
    """The linear solvers beside each other."""
    rows = [
        [row["mesh"], str(row["unknowns"]), str(row["threads"]), row["backend"],
         *(f"{1e3 * row[part]:.3g}" for part in ("symbolic", "factor", "solve")), f"{row['memory_gb']:.2g}",
         f"{row['of_first']:.2f}"]
        for row in stored["rows"]
    ]  # fmt: skip
    text = (f"On tangents of a shell in a bent state, each solver in a process of its own; the "
            f"ratio is of factor and solve, to the first. "
            f"{machine(stored)}\n\n")  # fmt: skip
    header = ["mesh", "unknowns", "threads", "solver", "symbolic (ms)", "factor (ms)", "solve (ms)", "GB", "ratio"]
    return title("Linear solvers", "-") + text + table(header, rows)


def growth(stored: dict[str, Any], folder: Path) -> str:
    """What the parts of an iteration cost from a thousand to a million unknowns."""
    text = title("Growth", "-")
    text += ("Seconds and memory of each part of a Newton iteration against the number of unknowns, theory ``kirchhoff``, "
             f"with the exponents of straight lines fitted to them on logarithmic axes. {machine(stored)}\n\n")  # fmt: skip
    rows = []
    for kind, name in (("seconds", "time"), ("memory_gb", "memory")):
        charts.growth(stored, kind, folder / f"growth_{kind}.png")
        text += chart(f"growth_{kind}.png", f"{name} of each part of an iteration against unknowns")
        for part, limit in stored["limits"].items():
            fits = [run["exponents"][kind][part] for run in stored["runs"]]
            cells = [f"{fit['exponent']:.2f} ({fit['from']} to {fit['to']})" if fit else "too small" for fit in fits]
            over = any(fit and fit["exponent"] > limit for fit in fits)
            aim = [f"{limit:.2f}", "no" if over else "yes"] if kind == "seconds" else ["", ""]
            rows.append([part, name, *cells, *aim])
    threads = [f"{run['threads']} thread(s)" for run in stored["runs"]]
    return text + table(["part", "of", *threads, "aimed at", "reached"], rows, "Exponents, and the sizes they are fitted to")


def startup(stored: dict[str, Any], folder: Path) -> str:
    """Import and first solves."""
    names = [n for n in ("import", "first solve", "later solve", "first solve, cold") if n in stored["kirchhoff"]]
    rows = [[theory, *(f"{stored[theory][name]:.3f}" for name in names)] for theory in ("kirchhoff", "full")]
    text = "CPU seconds of fresh processes, medians; a cold first solve compiles the kernels, once on a machine.\n\n"
    return title("Start-up", "-") + text + table(["theory", *(f"{name} (s)" for name in names)], rows)


BARS = """\
``python -m benchmarks.bars.run`` asks ``adapt`` for the numbers in ``benchmarks/bars/scenes.json``, each to up to three
tolerances, and compares its bars with right values by formulas, series, or extrapolation of meshes that no estimate has made
(``benchmarks/bars/references.py``). The scenes were written before the first run. The rule: on no mesh is a bar below
{assessment.LEAST:g} of the true error, on a first mesh {assessment.LEAST_FIRST:g}; the median is at most
{assessment.MEDIAN:g}, and at most one of twenty ends above {assessment.LARGE:g}. Errors below {assessment.KNOWN:g} times the
uncertainty of the right value are not assessed.

{told}
"""


def bars(stored: dict[str, Any], folder: Path) -> str:
    """The error bars of ``adapt`` against right values, by kinds of scenes."""
    runs = stored["runs"]
    total = assessment.summary(runs)
    text = BARS.format(assessment=assessment, told=assessment.told(total))
    rows = []
    for kind in dict.fromkeys(kind for run in runs for kind in run["kinds"]):
        found = assessment.summary([run for run in runs if kind in run["kinds"]])
        rows.append([kind, str(found.runs), str(found.reached), *(f"{v:.2f}" for v in found[6:9]),
                     f"{found.share_large:.0%}", str(len(found.broken))])  # fmt: skip
    header = ["kind", "runs", "reached", "least on first meshes", "least later", "median", "above 3", "break the rule"]
    return title("Error bars", "-") + text + table(header, rows) + f"{machine(stored)}\n\n"


PARTS: tuple[Callable[[dict[str, Any], Path], str], ...] = (bars, kernels, solvers, growth, startup)


def parts(folder: Path) -> Iterator[str]:
    """Of those of which results are stored, under their names; pictures go to the folder."""
    for part in PARTS:
        file = RESULTS / f"{part.__name__}.json"
        if file.exists():
            yield part(json.loads(file.read_text(encoding="utf-8")), folder)
