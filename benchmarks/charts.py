"""Charts of the stored results, with matplotlib."""

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from benchmarks.analysis import TARGETS, Compared, Curve

# Programs by colour, variants by line and mark. Ours stands out.
COLOURS = {
    "skancf": "#0072B2", "Exudyn": "#D55E00", "Kratos": "#009E73", "OpenSees": "#CC79A7", "CalculiX": "#8c6d31",
    "NGSolve": "#E69F00",
}  # fmt: skip
LINES, MARKS = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1))), "osD^v"
FLOOR = 1e-7
# What is less cannot be told from what the system does besides.
NOISE = {"seconds": 0.0, "memory_gb": 1e-3}


def style(curve: Curve, curves: tuple[Curve, ...]) -> dict[str, Any]:
    number = [c.label for c in curves if c.program == curve.program].index(curve.label)
    return {"color": COLOURS.get(curve.program, "black"), "ls": LINES[number % 5], "marker": MARKS[number % 5],
            "ms": 5 if curve.ours else 4, "lw": 2 if curve.ours else 1.2, "label": curve.label}  # fmt: skip


def scene(compared: Compared, file: Path) -> None:
    """Error against time and against degrees of freedom."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), sharey=True, layout="constrained")
    for curve in compared.curves:
        if curve.done:
            errors, seconds, dofs = (np.array(a)[curve.done] for a in (curve.errors, curve.seconds, curve.dofs))
            axes[0].loglog(seconds, np.maximum(errors, FLOOR), **style(curve, compared.curves))
            axes[1].loglog(dofs, np.maximum(errors, FLOOR), **style(curve, compared.curves))
    doubt = compared.scene.uncertainty("thin")
    for axis in axes:
        axis.axhspan(FLOOR / 10, doubt, color="#f0f0f0", zorder=0)
        for target in TARGETS:
            axis.axhline(target, color="#b0b0b0", lw=0.6, zorder=0)
        axis.grid(color="#eeeeee", which="major")
        axis.set_ylim(max(FLOOR, 0.3 * min((min(c.errors, default=1) for c in compared.curves), default=1)), 1)
    axes[0].set(xlabel="seconds, one thread", ylabel="relative error", title=compared.scene.title)
    axes[1].set(xlabel="degrees of freedom", title="grey: what the thin reference is worth")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, fontsize=8)
    finish(figure, file)


def summary(scenes: list[Compared], file: Path) -> None:
    """How many times longer the fastest peer takes than our fastest, for each scene and accuracy."""
    figure, axis = plt.subplots(figsize=(9, 0.65 * len(scenes) + 1.6), layout="constrained")
    colours, height = ("#c6dbef", "#9ecae1", "#4292c6", "#084594"), 0.2
    for k, target in enumerate(TARGETS):
        for row, found in enumerate(scenes):
            ours, peer = found.fastest(True, target), found.fastest(False, target)
            y = row + (k - 1.5) * height
            if ours and peer:
                ratio = peer[0] / ours[0]
                axis.barh(y, ratio - 1, height, left=1, color=colours[k])
                axis.text(max(ratio, 1) * 1.05, y, f"{ratio:.3g}  {peer[1].label}", va="center", fontsize=7)
            else:
                who = "no peer" if ours else "not ours" if peer else "nobody"
                axis.text(1.05, y, f"{who} below {100 * target:g} %", va="center", fontsize=7, color="#707070")
    for k, target in enumerate(TARGETS):
        axis.barh(0, 0, left=1, color=colours[k], label=f"to {100 * target:g} %")
    axis.set(yticks=range(len(scenes)), yticklabels=[found.scene.title for found in scenes], xscale="log",
             xlabel="time of the fastest peer over ours")  # fmt: skip
    axis.invert_yaxis()
    axis.axvline(1, color="black", lw=0.8)
    axis.set_xlim(0.1, axis.get_xlim()[1] * 6)
    axis.legend(frameon=False, fontsize=8, loc="lower right")
    finish(figure, file)


def growth(stored: dict[str, Any], kind: str, file: Path) -> None:
    """Seconds (``kind`` "seconds") or memory ("memory_gb") of each part of an iteration against unknowns, with exponents."""
    runs = {run["threads"]: run for run in stored["runs"]}
    size, colours = (5.2 * len(runs), 5.8), plt.colormaps["tab20"].colors
    figure, axes = plt.subplots(1, len(runs), figsize=size, sharey=True, squeeze=False, layout="constrained")
    for axis, (threads, run) in zip(axes[0], sorted(runs.items()), strict=True):
        for number, (part, fit) in enumerate(run["exponents"][kind].items()):
            points = [(row["unknowns"], row[kind][part]) for row in run["rows"] if row[kind].get(part, 0.0) > NOISE[kind]]
            label = f"{part}, N^{fit['exponent']:.2f}" if fit else part
            if points:
                axis.loglog(*zip(*points, strict=True), "o-", ms=3.5, lw=1.3, color=colours[number], label=label)
        axis.set(xlabel="unknowns", title=f"{threads} thread" + "s" * (threads > 1))
        axis.grid(color="#eeeeee")
        axis.legend(frameon=False, fontsize=7.5, ncol=3, loc="upper center", bbox_to_anchor=(0.5, -0.12))
    axes[0, 0].set_ylabel(kind.replace("_gb", " (GB)"))
    finish(figure, file)


def finish(figure: plt.Figure, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=130)
    plt.close(figure)
