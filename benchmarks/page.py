"""Writes the results page of the documentation, with its charts, from the stored results.

    python -m benchmarks.page [--out docs/results]
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

from benchmarks import charts, parts
from benchmarks.analysis import TARGETS, Compared, compared
from benchmarks.rst import machine, number, table, title

OUT = Path(__file__).resolve().parent.parent / "docs" / "results"

INTRODUCTION = """\
.. This page is written by benchmarks/page.py from benchmarks/results; edit that, not this.

Speed against accuracy
======================

One chart decides: error against time. Each scene below is stated once (``benchmarks/scenes``), with reference values that
are converged values of the same theory, and solved by skancf and by other programs with the settings that serve them best,
on the same machine, taking turns. ``make peers`` installs the others, ``make bench`` measures all of it (``make bench
SET=quick`` a part of it in five minutes), and this page is made of what it stored.

Time is wall time on one thread, from the statement of the model to the numbers: mesh, assembly, solution. Starting a program
and loading its libraries do not count, for none of them. The *time to an accuracy* is that of the fastest run in the part of
a ladder of meshes from which on no run is worse; an error that is small by chance, on the way from too stiff to too soft,
does not count.

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
            rows.append([
                found.scene.title, f"{100 * target:g} %",
                number(ours[0]) if ours else "none", ours[1].label if ours else "",
                number(peer[0]) if peer else "none", peer[1].label if peer else "",
                ratio, "" if found.known(target) else "yes",
            ])  # fmt: skip
    header = ["scene", "to", "ours (s)", "by", "peer (s)", "by", "ratio", "reference in doubt"]
    return table(header, rows, "Time to an accuracy: our fastest variant against the fastest variant of any other program")


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
    text += f".. image:: {scene.name}.png\n   :alt: {scene.title}: error against time and degrees of freedom\n\n"
    rows = []
    for curve in sorted(found.curves, key=lambda c: (not c.ours, c.label)):
        best = f"{min(curve.errors):.1e}" if curve.errors else "no result"
        rows.append([curve.label, curve.theory, *(number(curve.time_to(t)) for t in TARGETS), best])
    text += table(["program", "theory", *(f"{100 * t:g} % (s)" for t in TARGETS), "least error"], rows)
    notes = [f"{label}: {reason}" for label, reason in found.cannot]
    notes += [f"{curve.label}, {failure}" for curve in found.curves for failure in curve.failed]
    return text + ("Not run, or failed:\n\n" + "".join(f"- {note}\n" for note in notes) + "\n" if notes else "")


def page(folder: Path) -> Iterator[str]:
    scenes = list(compared())
    yield INTRODUCTION
    if scenes:
        charts.summary(scenes, folder / "summary.png")
        versions = {name: version for found in scenes for name, version in found.stored["versions"].items()}
        yield machine({**scenes[0].stored, "versions": versions}) + "\n\n"
        yield ".. image:: summary.png\n   :alt: time of the fastest peer over ours, by scene and accuracy\n\n"
        yield overview(scenes)
    yield from (section(found, folder) for found in scenes)
    yield from (part(folder) for part in parts.PARTS)


def main(out: Path = OUT) -> None:
    out.mkdir(parents=True, exist_ok=True)
    (out / "index.rst").write_text("".join(page(out)), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    main(parser.parse_args().out)
