"""Objects as notebooks show them: a small table, and a picture where this machine can draw."""

import base64
from collections.abc import Callable, Mapping
from functools import singledispatch
from html import escape
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from skancf.adaptive import AdaptiveResult
from skancf.checks import Check
from skancf.dynamics import Ledger, Motion, Spectrum
from skancf.output.adaptive_charts import convergence
from skancf.output.charts import histories_chart
from skancf.output.pictures import picture
from skancf.output.sketch import sketch
from skancf.output.spectrum_chart import spectrum_chart
from skancf.problem import Problem
from skancf.showing import brief, in_brackets, largest_displacement, some, span
from skancf.solution import Solution
from skancf.statics import BucklingResult, Modes, PathResult, StaticResult

SIZE = (880, 630)
"""Pixels of a picture, which is shown in half of that."""
VISIBLE = 0.1
"""Displacements that are less than a fifth of this part of the surface's extent are enlarged to it."""
SHAPES = 3
"""Modes that are drawn."""

Rows = Mapping[str, Any]


def page(shown: Any) -> str:
    """HTML of an object; pictures are left out where they cannot be drawn."""
    rows, drawings = contents(shown)
    table = "".join(f"<tr><th {LEFT}>{escape(name)}</th><td {LEFT}>{escape(str(value))}</td></tr>"
                    for name, value in rows.items() if str(value))  # fmt: skip
    pictures = "".join(filter(None, (_image(words, draw) for words, draw in drawings.items())))
    return f"<div><strong>{type(shown).__name__}</strong><table>{table}</table>{pictures}</div>"


LEFT = 'style="text-align: left"'


def _image(words: str, draw: Callable[[Path], Any]) -> str:
    """A picture within the page; nothing where drawing fails, as on a machine without a screen and its drivers."""
    with TemporaryDirectory() as folder:
        try:
            file = Path(folder) / "picture.png"
            draw(file)
            data = base64.b64encode(file.read_bytes()).decode("ascii")
        except Exception:  # a notebook shows the table then
            return ""
    return f'<img alt="{escape(words)}" style="max-width: {SIZE[0] // 2}px" src="data:image/png;base64,{data}">'


Drawings = Mapping[str, Callable[[Path], Any]]


@singledispatch
def contents(shown: Any) -> tuple[Rows, Drawings]:
    """What is in the table, and drawings by what they show."""
    return {"": in_brackets(shown)}, {}


def _checks(checks: tuple[Check, ...]) -> Rows:
    return {f"check: {check.name}": f"{check.value:.1e}, at most {check.bound:.1e}: {'passed' if check.passed else 'FAILED'}"
            for check in checks}  # fmt: skip


def _state(solution: Solution) -> Rows:
    return {
        "on": solution.system,
        "time": "" if solution.time is None else f"{solution.time:.4g} s",
        "load factor": f"{solution.load_factor:.5g}",
        "largest displacement": largest_displacement(solution),
        "note": ", ".join(["small deflections"] * solution.linear + [solution.note] * bool(solution.note)),
    }


def _drawn(solution: Solution) -> Callable[[Path], Any]:
    """A picture of a state, of which small displacements are enlarged; the title says how much."""
    extent = float(np.ptp(solution.system.geometry.undeformed[:, 0], axis=0).max())
    moved = float(np.linalg.norm(solution.displacements, axis=0).max())
    scale = 1.0
    if 0 < moved < VISIBLE / 5 * extent:
        wanted = VISIBLE * extent / moved
        power = 10.0 ** np.floor(np.log10(wanted))
        scale = float(power * max(step for step in (1, 2, 5) if step * power <= wanted))
    return lambda file: picture(solution, file, size=SIZE, scale=scale)


@contents.register
def _(shown: Solution) -> tuple[Rows, Drawings]:
    return _state(shown), {"the deformed surface, coloured by the displacement": _drawn(shown)}


@contents.register
def _(shown: StaticResult) -> tuple[Rows, Drawings]:
    rows = {"status": shown.status.value, **_state(shown.solution), "iterations": shown.iterations, "message": shown.message}
    return rows | dict(_checks(shown.checks)), contents(shown.solution)[1]


@contents.register
def _(shown: PathResult) -> tuple[Rows, Drawings]:
    factors = shown.load_factors
    moved = [float(np.linalg.norm(state.displacements, axis=0).max()) for state in shown.solutions]
    rows = {"status": shown.status.value, "equilibria": len(factors), "load factors": span(factors.min(), factors.max()),
            "events": "; ".join(map(str, shown.events)), "message": shown.message}  # fmt: skip
    curve = {"largest displacement": (np.array(moved), factors)}
    return rows | dict(_checks(shown.checks)), {
        "load factor against the largest displacement": lambda file: histories_chart(
            moved, curve, file, xlabel="largest displacement (m)", ylabel="load factor"),
        **contents(shown.solution)[1],
    }  # fmt: skip


@contents.register
def _(shown: Modes) -> tuple[Rows, Drawings]:
    rows = {"on": shown.state.system, "frequencies": some(shown.frequencies, "Hz"), "without stiffness": shown.n_rigid,
            "unstable": shown.n_unstable, "note": shown.note}  # fmt: skip
    elastic = range(len(shown.eigenvalues))[shown.n_rigid :][:SHAPES]
    return rows | dict(_checks(shown.checks)), {
        f"mode {k}, {shown.frequencies[k]:.4g} Hz": _shape(shown, k, f"mode {k}, {shown.frequencies[k]:.4g} Hz")
        for k in elastic
    }


@contents.register
def _(shown: BucklingResult) -> tuple[Rows, Drawings]:
    rows = {
        "on": shown.linear.system,
        "load factors": some(shown.load_factors),
        "message": shown.message,
        "note": shown.note,
    }
    words = [f"buckling mode {k}, load factor {factor:.4g}" for k, factor in enumerate(shown.load_factors[:SHAPES])]
    return rows | dict(_checks(shown.checks)), {text: _shape(shown, k, text) for k, text in enumerate(words)}


def _shape(of: Modes | BucklingResult, k: int, title: str) -> Callable[[Path], Any]:
    return lambda file: picture(of.shape(k), file, size=SIZE, title=title)


@contents.register
def _(shown: Motion) -> tuple[Rows, Drawings]:
    times = shown.times
    rows = {"status": shown.status.value, "time": span(times[0], times[-1], "s"), "outputs": len(times),
            "on": shown.segments[-1].system, "steps": sum(step.accepted for step in shown.steps),
            "message": shown.message}  # fmt: skip
    return rows | dict(_checks(shown.checks)), {
        **contents(shown.ledger)[1],
        **contents(shown.at(float(times[-1])))[1],
    }


@contents.register
def _(shown: Ledger) -> tuple[Rows, Drawings]:
    names = [name for name in ("kinetic", "strain", "potential", "work", "dissipation") if np.any(getattr(shown, name))]
    rows = {name: f"{getattr(shown, name)[-1]:.4g} J at the end" for name in names}
    curves = {name: (shown.times, getattr(shown, name)) for name in names}
    return rows | {"without a source": f"{shown.balance[-1]:.2g} J"}, {
        "energies against time": lambda file: histories_chart(shown.times, curves, file, ylabel="energy (J)")
    }


@contents.register
def _(shown: Spectrum) -> tuple[Rows, Drawings]:
    rows = {"up to": f"{shown.nyquist:.4g} Hz", "tells apart": f"{shown.resolution:.3g} Hz",
            "largest amplitude at": f"{shown.frequencies[shown.total.argmax()]:.4g} Hz"}  # fmt: skip
    return rows, {"amplitudes against frequency": lambda file: spectrum_chart({"total": shown}, file, ylabel="amplitude")}


@contents.register
def _(shown: AdaptiveResult) -> tuple[Rows, Drawings]:
    rows = {"status": shown.status.value, "value": shown, "meshes": len(shown.levels), "message": shown.message}
    kept = [level for level in shown.levels if not level.rejected and np.isfinite(level.bar)]
    bars = {"error bar": ([level.n_dofs for level in kept], [level.bar for level in kept])}
    return rows | dict(_checks(shown.checks)), {
        "error bars against unknowns": lambda file: convergence(
            bars, file, xlabel="nodal coordinates", ylabel=f"error bar ({shown.unit})" if shown.unit else "error bar"),
        **contents(shown.solution)[1],
    }  # fmt: skip


@contents.register
def _(shown: Problem) -> tuple[Rows, Drawings]:
    named = ("surface", "thickness", "material", "offset", "damping")
    rows = {name: brief(value) for name in named if (value := getattr(shown, name)) not in (None, 0.0)}
    for name in ("zones", "supports", "loads", "conditions", "terms"):
        items = list(getattr(shown, name))
        rows[name] = ", ".join(brief(item) for item in items[:8]) + (
            f", ... {len(items) - 8} more" if len(items) > 8 else ""
        )
    return rows, {"the surface with its supports in blue and its forces as arrows": lambda file: _save_sketch(shown, file)}


def _save_sketch(problem: Problem, file: Path) -> None:
    data = BytesIO()
    sketch(problem).savefig(data, format="png", bbox_inches="tight")
    file.write_bytes(data.getvalue())
