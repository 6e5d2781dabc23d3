"""The rule for error bars, and tables of what was found: pure functions of stored runs.

A *run* is one scene and quantity to one tolerance, with all its meshes. The *efficiency* of a bar is its size over the true
error. Meshes whose true error is below :data:`KNOWN` times the uncertainty of the right value have none. So have those of
numbers that are zero: their bar must hold the value, and the run must end as reached.
"""

from collections.abc import Iterable, Iterator
from statistics import median
from typing import Any, NamedTuple

LEAST, LEAST_FIRST = 0.9, 0.8
"""Smallest efficiencies on later meshes, and on the first."""
MEDIAN = 1.5
LARGE, SHARE = 3.0, 1 / 20
"""At most so large a share of runs may end with an efficiency that is larger than LARGE."""
KNOWN = 5.0
TINY = 1e-9
"""Of the right value: smaller errors are rounding."""


class Mesh(NamedTuple):
    """A mesh of a run; ``efficiency`` is None where the right value is not known well enough."""

    value: float
    bar: float
    error: float
    efficiency: float | None
    first: bool
    dofs: int


def meshes(run: dict[str, Any]) -> list[Mesh]:
    """All meshes that were not rejected."""
    out = []
    for n, level in enumerate(run["levels"]):
        if not level["rejected"]:
            error = abs(level["value"] - run["right"])
            # A zero is compared as it is: its bar must hold the value.
            floor = 0.0 if run["right"] == 0 else max(KNOWN * run["uncertainty"], TINY * abs(run["right"]))
            known = error > floor
            out.append(
                Mesh(level["value"], level["bar"], error, level["bar"] / error if known else None, n == 0, level["dofs"])
            )
    return out


def is_zero(run: dict[str, Any]) -> bool:
    return bool(run["right"] == 0)


def broken(run: dict[str, Any]) -> Iterator[str]:
    """What is wrong with a run by itself; the rules about medians and shares are those of all runs together."""
    if run.get("failed"):
        yield run["failed"]
        return
    below = [
        (mesh.efficiency, n, mesh)
        for n, mesh in enumerate(meshes(run), 1)
        if mesh.efficiency is not None and mesh.efficiency < (LEAST_FIRST if mesh.first else LEAST)
    ]
    if below:
        efficiency, n, mesh = min(below)
        yield (f"{efficiency:.2f} on mesh {n} of {mesh.dofs} dofs, bar {mesh.bar:.2g}, error {mesh.error:.2g}; too small on "
               f"{len(below)} of {len(meshes(run))}")  # fmt: skip
    if is_zero(run) and run["outcome"] != "REACHED":
        yield f"zero, and ended as {run['outcome']}"
    if run["outcome"] in ("NO_LIMIT", "FAILED"):
        yield f"{run['outcome']}: {run['message'][:120]}"


class Summary(NamedTuple):
    """Of all runs; efficiencies are those of the last meshes but for the smallest ones."""

    runs: int
    failed: int
    zeros: int
    unknown: int
    assessed: int
    reached: int
    least_first: float
    least_later: float
    median: float
    share_large: float
    broken: list[tuple[str, list[str]]]

    @property
    def holds(self) -> bool:
        return not self.broken and self.median <= MEDIAN and self.share_large <= SHARE


def last(run: dict[str, Any]) -> Mesh:
    """The mesh that the answer is from."""
    return meshes(run)[-1]


def summary(runs: list[dict[str, Any]]) -> Summary:
    done = [run for run in runs if not run.get("failed")]
    others = [run for run in done if not is_zero(run)]
    every = [mesh for run in others for mesh in meshes(run) if mesh.efficiency is not None]
    ends = [mesh.efficiency for run in others if (mesh := last(run)).efficiency is not None]
    wrong = [(title(run), found) for run in runs if (found := list(broken(run)))]
    return Summary(
        len(runs), len(runs) - len(done), len(done) - len(others), len(others) - len(ends), len(ends),
        sum(run["outcome"] == "REACHED" for run in done),
        min((m.efficiency for m in every if m.first and m.efficiency is not None), default=float("nan")),
        min((m.efficiency for m in every if not m.first and m.efficiency is not None), default=float("nan")),
        median(ends) if ends else float("nan"), sum(e > LARGE for e in ends) / max(len(ends), 1), wrong,
    )  # fmt: skip


def title(run: dict[str, Any]) -> str:
    return f"{run['scene']}: {run['asked']}, {run['rtol']:g}"


def told(found: Summary) -> str:
    """The summary as text."""
    return (f"{found.runs} runs, {found.failed} without an answer, {found.reached} reached, {found.zeros} of zeros, "
            f"{found.unknown} with errors below the reference's uncertainty, {found.assessed} assessed by their last mesh.\n"
            f"Smallest efficiency on first meshes {found.least_first:.2f}, on later ones {found.least_later:.2f}; median "
            f"{found.median:.2f}; above {LARGE:g}: {found.share_large:.1%}. Runs that break the rule: {len(found.broken)}. "
            f"The rule {'holds' if found.holds else 'is broken'}.\n")  # fmt: skip


def markdown(runs: Iterable[dict[str, Any]]) -> str:
    """The table of all runs, and those that break the rule."""
    runs = list(runs)
    found = summary(runs)
    lines = ["# Error bars", "", told(found), ""]
    if found.broken:
        lines += ["## Runs that break the rule", ""]
        lines += [f"- {name}: {'; '.join(what)}" for name, what in found.broken] + [""]
    lines += ["## Runs", "", *(_row(cells) for cells in (HEADER, ["---"] * len(HEADER)))]
    lines += [_row(_cells(run)) for run in runs]
    return "\n".join(lines) + "\n"


HEADER = ["scene", "asked", "rtol", "value", "bar", "true error", "efficiency", "on each mesh", "outcome", "dofs", "s"]


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _cells(run: dict[str, Any]) -> list[str]:
    head, seconds = [run["scene"], run["asked"], f"{run['rtol']:g}"], f"{run['seconds']:.1f}"
    if run.get("failed"):
        return [*head, "", "", "", "", "", run["failed"][:80], "", seconds]
    end = last(run)
    each = " ".join("-" if mesh.efficiency is None else f"{mesh.efficiency:.2g}" for mesh in meshes(run))
    size = "-" if end.efficiency is None else f"{end.efficiency:.2f}"
    values = [f"{end.value:.8g}", f"{end.bar:.1e}", f"{end.error:.1e}"]
    return [*head, *values, size, each, run["outcome"], str(end.dofs), seconds]
