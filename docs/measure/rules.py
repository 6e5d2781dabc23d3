"""Rules of integration on the free ruler: docs/theory/free_ruler.csv.

From the folder of the repository, in some ten minutes of a processor:

    .venv/bin/python docs/measure/rules.py

The ruler and what is read from its runs are those of demos/plot_13_free_ruler.py. Rows that the table has are kept:
delete it to make it anew.
"""

import csv
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

DOCS = Path(__file__).resolve().parent.parent
HEAD = ["theory", "P (N)", "step (ms)", "rule", "end (ms)", "energy", "angular momentum", "steps", "halved",
        "iterations per step"]  # fmt: skip


def row(theory: str, load: float, dt: float, rule: str, found: SimpleNamespace) -> list[str]:
    """A line of the table; energies are relative to that at 4 ms."""
    doubled = found.doubled is not None
    energy = f"doubled at {1000 * found.doubled:.1f} ms" if doubled else f"{found.deviation:.1e}"
    if found.end <= 4e-3:
        doubled, energy = True, ""
    return [
        theory, f"{load:.0f}", f"{1000 * dt:g}", rule, f"{1000 * found.end:.4g}", energy,
        "" if doubled else f"{found.turning:.0e}", str(found.steps), str(found.halved),
        f"{found.iterations / found.steps:.1f}",
    ]  # fmt: skip


def main() -> None:
    demo = SimpleNamespace(**run_path(str(DOCS.parent / "demos" / "plot_13_free_ruler.py"), run_name="ruler"))
    cases = [(theory, demo.LOAD, demo.STEP) for theory in ("kirchhoff", "full")]
    cases += [("kirchhoff", load, dt) for load, dt in demo.MORE]
    file = DOCS / "theory" / "free_ruler.csv"
    rows = list(csv.reader(file.read_text().splitlines()))[1:] if file.exists() else []
    known = {tuple(found[:4]) for found in rows}
    for theory, load, dt in cases:
        for rule in demo.RULES:
            if (theory, f"{load:.0f}", f"{1000 * dt:g}", rule) in known:
                continue
            found = demo.figures(demo.run(demo.ruler(load, theory), rule, dt, outputs=2))
            rows.append(row(theory, load, dt, rule, found))
            print(*rows[-1], flush=True)
            with file.open("w", newline="") as out:
                csv.writer(out, lineterminator="\n").writerows([HEAD, *rows])


if __name__ == "__main__":
    main()
