"""Writes the results page of the documentation, with its charts, from the stored results.

python -m benchmarks.page [--out docs/results]
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from benchmarks import charts
from benchmarks.analysis import TARGETS, Compared, Curve, compared
from benchmarks.parts import parts
from benchmarks.rst import chart, literal, machine, number, table, title

OUT = Path(__file__).resolve().parent.parent / "docs" / "results"

INTRODUCTION = """\
.. This page is written by benchmarks/page.py from benchmarks/results; edit that, not this.

Speed against accuracy
======================

One chart decides: error against time. Each scene below is stated once (``benchmarks/scenes``), with reference values that
are converged values of the same theory where these are known, and solved by skancf and by other programs with the settings
that were found to serve them best, on the same machine, taking turns; runs of less than half a second in three rounds.
``make peers`` installs the others, ``make bench`` measures all of it (``make bench SET=quick`` a part of it in five
minutes), and this page is made of what it stored.

Time is wall time on one thread, from the statement of the model to the numbers: mesh, assembly, solution. Starting a program
and loading its libraries do not count, nor what a first run in the process compiles or keeps; but CalculiX is started anew
for each run, and timed with it, since it is used so. Load steps, meshes and steps in time of all programs, ours too, were
found by trial against the reference, which is more than a user can do who does not know the answer.

The *time to an accuracy* is that of the fastest run in the part of a ladder of meshes from which on no run is worse; an
error that is small by chance, on the way from too stiff to too soft, does not count. A star marks a time that no finer mesh
confirms. Programs whose theory has no reference of its own in a scene are compared with that of thin plates, and marked;
what their theory differs by is part of their error.

"""


def overview(scenes: list[Compared]) -> str:
    """Our fastest against the fastest peer."""
    rows = []
    for found in scenes:
        for target in TARGETS:
            ours, peer = found.fastest(True, target), found.fastest(False, target)
            if ours is None and peer is None:
                continue
            ratio = number(peer[0] / ours[0]) if ours and peer else ""
            doubt = [pair[1].label for pair in (ours, peer) if pair and not pair[1].known(target)]
            cells = [cell for pair in (ours, peer)
                     for cell in (time(pair[1], target) if pair else "none", pair[1].label if pair else "")]  # fmt: skip
            rows.append([found.scene.title, f"{100 * target:g} %", *cells, ratio, ", ".join(doubt)])
    header = ["scene", "to", "ours (s)", "by", "peer (s)", "by", "ratio", "reference in doubt for"]
    return table(header, rows, "Time to an accuracy: our fastest variant against the fastest variant of any other program")


def time(curve: Curve, target: float) -> str:
    """To an accuracy; with a star where no finer mesh confirms it."""
    seconds = curve.time_to(target)
    return number(seconds) + ("" if seconds is None or curve.confirmed(target) else r" \*")


def section(found: Compared, folder: Path) -> str:
    """A scene: what it is, chart, tables."""
    scene = found.scene
    charts.scene(found, folder / f"{scene.name}.png")
    text = title(scene.title, "-") + scene.text + "\n\n"
    if not scene.times:
        values = [[q.text, theory, f"{value:.8g} {q.unit}", f"{q.uncertainty[theory]:.1e}"]
                  for q in scene.quantities.values() for theory, value in q.reference.items()]  # fmt: skip
        text += table(["number", "theory", "reference", "uncertain by"], values)
    else:
        text += f"The reference series are uncertain by {scene.uncertainty('thin'):.1e}.\n\n"
    text += "\n\n".join(dict.fromkeys(q.source for q in scene.quantities.values())) + "\n\n"
    text += chart(f"{scene.name}.png", f"{scene.title}: error against time and degrees of freedom")
    apart = [curve.label for curve in found.curves if curve.module in found.stored.get("apart", ())]
    if apart:
        text += f"Measured by themselves after the others, not in turns with them: {'; '.join(apart)}.\n\n"
    rows = []
    for curve in sorted(found.curves, key=lambda c: (not c.ours, c.label)):
        best = f"{min(curve.errors):.1e}" if curve.done else "no result"
        theory = curve.theory if scene.own(curve.theory) else f"{curve.theory}, against thin"
        rows.append([curve.label, theory, *(time(curve, t) for t in TARGETS), best])
    text += table(["program", "theory", *(f"{100 * t:g} % (s)" for t in TARGETS), "least error"], rows)
    notes = [f"{label}: {literal(reason)}" for label, reason in found.cannot]
    notes += [f"{curve.label}, {literal(failure)}" for curve in found.curves for failure in curve.failed]
    return text + ("Not run, not finished, failed:\n\n" + "".join(f"- {note}\n" for note in notes) + "\n" if notes else "")


def page(folder: Path) -> Iterator[str]:
    scenes = list(compared())
    yield INTRODUCTION
    if scenes:
        charts.summary(scenes, folder / "summary.png")
        versions = {name: version for found in scenes for name, version in found.stored["versions"].items()}
        yield machine({**scenes[0].stored, "versions": versions}) + "\n\n"
        yield chart("summary.png", "time of the fastest peer over ours, by scene and accuracy")
        yield overview(scenes)
    yield from (section(found, folder) for found in scenes)
    yield from parts(folder)


def main(out: Path = OUT) -> None:
    out.mkdir(parents=True, exist_ok=True)
    (out / "index.rst").write_text("".join(page(out)), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    main(parser.parse_args().out)
