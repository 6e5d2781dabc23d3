r"""
A roof that snaps through
=========================

.. image:: /pictures/gallery/06_snap_through.jpg
   :alt: A cylindrical roof that has snapped through and hangs below its supports.
   :class: example-picture

A shallow cylindrical roof is hinged at its two straight edges, free at the curved ones, and pushed down by a force P at its
centre. Under a growing load it gives way suddenly and ends up hanging below its supports. What is in between are
equilibria too, :math:`R(q, \lambda) = 0` with P = 3000 :math:`\lambda`, but unstable ones, and no load that only grows can
reach them: the load factor :math:`\lambda` has to become an unknown, with the length of the path in its place. Where the
tangent :math:`K = \partial R / \partial q` has negative eigenvalues the equilibrium is unstable; where one becomes zero
there is a limit point or another branch crosses.

Example 3.8 of K. Y. Sze, X. H. Liu and S. H. Lo (2004), Popular benchmark problems for geometric nonlinear analysis of
shells, *Finite Elements in Analysis and Design* 40, 1551-1569: radius 2540, length 508, half opening angle 0.1, thickness
12.7 or 6.35, :math:`E = 3102.75`, :math:`\nu = 0.3` (mm, N).

This example shows equilibrium paths beyond limit points, stability, bifurcations, snap-back. It builds on the pinched
hemisphere.
"""

# %%
# The published path
# ------------------
# P / 3000 and deflection of the centre, thickness 12.7, from S4R elements.
import argparse
import os
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from scipy.interpolate import CubicSpline

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/06_snap_through.jpg"

PUBLISHED = np.array([
    (0.0877, 0.693), (0.1980, 1.638), (0.3473, 3.087), (0.4686, 4.477), (0.5647, 5.802), (0.6381, 7.057),
    (0.6908, 8.237), (0.7246, 9.339), (0.7412, 10.358), (0.7421, 11.293), (0.7286, 12.141), (0.7023, 12.903),
    (0.6649, 13.583), (0.6182, 14.188), (0.5643, 14.728), (0.5055, 15.217), (0.4442, 15.676), (0.3830, 16.125),
    (0.3245, 16.590), (0.2717, 17.094), (0.2272, 17.657), (0.1940, 18.299), (0.1750, 19.028), (0.1729, 19.852),
    (0.1905, 20.771), (0.2303, 21.780), (0.2950, 22.875), (0.3871, 24.049), (0.4443, 24.663), (0.5093, 25.293),
    (0.5826, 25.940), (0.6644, 26.601), (0.7551, 27.276), (0.8549, 27.964), (0.9643, 28.663), (1.0835, 29.374),
])  # fmt: skip

# %%
# The roof
# --------
# The whole of it, not a quarter: symmetry conditions would forbid the roof to tip aside, and it may want to.
LENGTH, ANGLE, FORCE, THICK, THIN = 508.0, 0.2, 3000.0, 12.7, 6.35
SURFACE = sk.CylinderSector(2540.0, LENGTH, ANGLE, start=pi / 2 - ANGLE / 2)
CENTRE, ASIDE, DOWN = (LENGTH / 2, pi / 2), (LENGTH / 2, pi / 2 + ANGLE / 4), (0.0, 0.0, -1.0)


def roof(thickness: float, n: int, disturbance: float = 0.0) -> Any:
    """The roof on n x n elements; a part of the load acts half-way to one of its supports besides."""
    loads = [sk.PointForce(CENTRE, (0.0, 0.0, -FORCE))]
    if disturbance:
        loads.append(sk.PointForce(ASIDE, (0.0, 0.0, -disturbance * FORCE)))
    problem = sk.Problem(SURFACE, thickness, sk.Isotropic(3102.75, 0.3, density=1e-6), [sk.Pin(["start", "end"])], loads)
    return problem.on(sk.meshes.uniform(SURFACE, n, n), "kirchhoff")


def deflection(solution: sk.Solution) -> float:
    """Of the centre, downwards."""
    return -float(solution.displacement(CENTRE)[2])


def follow(system: Any, until: float | sk.DisplacementReached) -> sk.PathResult:
    """The path in steps of at most twice the first one, for smooth charts; it needs a third of them."""
    return sk.trace(system, sk.ArcLength(steps=sk.StepLength(largest=2.0)), until=until).unwrap()


# %%
# Three ways to load it
# ---------------------
# ``sk.solve`` without relaxation raises the load and stops at the limit point, which it names. With the deflection of the
# centre prescribed, one gets through, unless the deflection turns back too, as it does in the thinner roof. The length of
# the path always grows. By default ``sk.solve`` relaxes the roof at the full load: it ends where the path does, beyond the
# snap.


def three_controls(n: int) -> sk.StaticResult:
    """Prints how far load, displacement and path control come, for both roofs; returns the load steps of the thick one."""
    results: dict[str, dict[str, Any]] = {}
    print("roof   control        status           P / 3000  deflection")
    for name, thickness in (("thick", THICK), ("thin", THIN)):
        system = roof(thickness, n)
        results[name] = {
            "load": sk.solve(system, control=sk.HalveAndGrow(first=0.1, smallest=1e-3), relax=False),
            "displacement": sk.trace(system, sk.DisplacementControl(CENTRE, DOWN, 29.0)),
            "path": sk.trace(system, until=1.0),
            "relaxed": sk.solve(system),
        }
        for control, result in results[name].items():
            at = result.solution
            print(f"{name:<6} {control:<13}  {result.status.value:<15}  {at.load_factor:8.4f}  {deflection(at):10.3f}")
    print(f"\nThe load steps say: {results['thick']['load'].message}")
    assert results["thin"]["load"].status.name == "LIMIT_POINT" == results["thick"]["load"].status.name
    assert results["thick"]["displacement"].status.name == "CONVERGED"
    assert results["thin"]["displacement"].status.name == "TURNED_BACK"
    for name in results:
        ends = [deflection(results[name][control].solution) for control in ("relaxed", "path")]
        assert np.isclose(ends[0], ends[1], rtol=1e-4), (name, ends)
    return results["thick"]["load"]


def event_table(paths: dict[str, sk.PathResult]) -> None:
    """Prints the limit points and bifurcations of all paths."""
    print("\nroof            event           P / 3000  deflection")
    for name, path in paths.items():
        for event in path.events:
            print(f"{name:<15} {event.kind:<14}  {event.load_factor:8.4f}  {deflection(event.solution):10.3f}")


def distance_to_published(path: sk.PathResult) -> float:
    """Largest distance of a published point from the path, in a chart whose axes are one for P = 3000 and for 30 mm."""
    points = np.array([(state.load_factor, deflection(state) / 30) for state in path.solutions])
    curve = CubicSpline(np.arange(len(points)), points)(np.linspace(0, len(points) - 1, 20 * len(points)))
    return float(np.linalg.norm((PUBLISHED * (1, 1 / 30))[:, None] - curve, axis=2).min(axis=1).max())


# %%
# Pictures
# --------
STABLE: dict[str, Any] = {"color": "#0072B2", "lw": 2}
UNSTABLE: dict[str, Any] = {"color": "#D55E00", "lw": 1.8, "ls": "--"}
MARKS: dict[str, dict[str, Any]] = {
    "limit point": {"marker": "^", "color": "black"}, "bifurcation": {"marker": "D", "color": "#009E73"},
}  # fmt: skip


def with_events(path: sk.PathResult) -> list[tuple[float, float, int | None]]:
    """Deflection, load and number of negative eigenvalues along the path; None at events, put between their neighbours."""
    known = zip(path.solutions, path.negative_pivots, strict=True)
    states: list[tuple[sk.Solution, int | None]] = [(state, int(pivots)) for state, pivots in known]
    for event in path.events:

        def detour(k: int, q: np.ndarray = event.solution.q) -> float:
            a, b = states[k][0].q, states[k + 1][0].q
            return float(np.linalg.norm(q - a) + np.linalg.norm(q - b) - np.linalg.norm(b - a))

        states.insert(min(range(len(states) - 1), key=detour) + 1, (event.solution, None))
    return [(deflection(state), FORCE * state.load_factor, pivots) for state, pivots in states]


def draw_path(axes: plt.Axes, path: sk.PathResult) -> None:
    """Stable parts as full lines, unstable ones broken, parted at the events."""
    points = with_events(path)
    places = np.array([point[:2] for point in points])
    length = np.concatenate([[0.0], np.linalg.norm(np.diff(places / (30, FORCE), axis=0), axis=1).cumsum()])
    curve = CubicSpline(length, places)
    for k, (a, b) in enumerate(pairwise(points)):
        known = [pivots for pivots in (a[2], b[2]) if pivots is not None]
        stable = bool(known) and not any(known)
        axes.plot(
            *curve(np.linspace(length[k], length[k + 1], 12)).T, **(STABLE if stable else {**UNSTABLE, "ls": (0, (2.5, 1))})
        )
    for event in path.events:
        axes.plot(deflection(event.solution), FORCE * event.load_factor, ls="", ms=7, zorder=5, **MARKS[event.kind])


def legend(axes: plt.Axes, *others: Line2D, **where: Any) -> None:
    lines = [Line2D([], [], label="stable", **STABLE), Line2D([], [], label="unstable", **UNSTABLE)]
    lines += [Line2D([], [], ls="", ms=7, label=kind, **mark) for kind, mark in MARKS.items()]
    axes.legend(handles=[*lines, *others], frameon=False, **where)


def draw_thick(axes: plt.Axes, path: sk.PathResult, after: sk.Solution) -> None:
    """The path of the thick roof on the published points, and the jump under a growing load."""
    draw_path(axes, path)
    axes.plot(PUBLISHED[:, 1], FORCE * PUBLISHED[:, 0], "o", mfc="none", mec="#707070", ms=6, zorder=1)
    top = path.events[0]
    axes.annotate("", (deflection(after), FORCE * after.load_factor), (deflection(top.solution), FORCE * top.load_factor),
                  arrowprops={"arrowstyle": "->", "color": "#707070", "shrinkA": 8})  # fmt: skip
    axes.text(19, FORCE * top.load_factor + 40, "snaps under a growing load", color="#505050", ha="center")
    axes.set(xlabel="deflection of the centre (mm)", ylabel="P (N)", title="Thickness 12.7", xlim=(-0.5, 31), ylim=(0, 3300))
    legend(axes, Line2D([], [], ls="", marker="o", mfc="none", mec="#707070", label="published"), loc="upper left")
    axes.grid(color="#e0e0e0")


def draw_thin(axes: plt.Axes, path: sk.PathResult, tipped: sk.PathResult) -> None:
    """The path of the thin roof, and that of the disturbed one."""
    draw_path(axes, path)
    load = FORCE * tipped.load_factors
    centre = np.array([deflection(state) for state in tipped.solutions])
    axes.plot(centre, load, color="#CC79A7", lw=1.6, marker=".", ms=5)
    axes.set(xlabel="deflection of the centre (mm)", ylabel="P (N)", title="Thickness 6.35", xlim=(-0.5, 31),
             ylim=(-480, 1250))  # fmt: skip
    line = Line2D([], [], color="#CC79A7", marker=".", label="with 1 % of the load off the centre (stability not shown)")
    legend(axes, line, loc="upper left")
    axes.grid(color="#e0e0e0")


def draw_roof(axes: plt.Axes, state: sk.Solution, title: str, limits: tuple[float, float]) -> None:
    """A state with its heights enlarged, coloured by its deflection."""
    surface = output.sample(state, 3)
    cells = surface.points[surface.cells]
    share = (-surface.displacement[surface.cells][:, :, 2].mean(axis=1) - limits[0]) / np.diff(limits)
    output.draw_cells(axes, cells, plt.colormaps["viridis"](share), light=(0.6, -0.35, 0.72), stretch=(1, 1, 5))
    axes.set(xlim=(0, LENGTH), ylim=(-LENGTH / 2, LENGTH / 2), zlim=(2505, 2545))
    axes.set_box_aspect((1, 1, 40 * 5 / LENGTH), zoom=0.98)
    axes.view_init(elev=20, azim=-35)
    axes.set_title(title, y=0.9, fontsize=11)


def tilt(state: sk.Solution) -> float:
    """How much lower one half of the roof hangs than the other."""
    return float(abs(np.diff(state.displacement([ASIDE, (ASIDE[0], pi - ASIDE[1])])[:, 2])[0]))


def picture(paths: dict[str, sk.PathResult], before: sk.Solution, after: sk.Solution, file: Path) -> None:
    """Both charts, and states below them."""
    figure = plt.figure(figsize=(14, 9.5), layout="constrained")
    grid = figure.add_gridspec(2, 4, height_ratios=[1.6, 1])
    draw_thick(figure.add_subplot(grid[0, :2]), paths["thick"], after)
    draw_thin(figure.add_subplot(grid[0, 2:]), paths["thin"], paths["thin, disturbed"])
    tipped = max(paths["thin, disturbed"].solutions, key=tilt)
    unloaded = sk.Solution(before.system, before.system.undeformed)
    states = {
        "unloaded": unloaded,
        f"thick, at the limit point, P = {FORCE * before.load_factor:.0f}": before,
        "thick, after it snapped, same P": after,
        f"thin, tipped aside, P = {FORCE * tipped.load_factor:.0f}": tipped,
    }
    axes = [figure.add_subplot(grid[1, k], projection="3d") for k in range(4)]
    limits = (-2.0, 28.0)
    for place, (title, state) in zip(axes, states.items(), strict=True):
        draw_roof(place, state, title, limits)
    bar = plt.cm.ScalarMappable(plt.Normalize(*limits), plt.colormaps["viridis"])
    figure.colorbar(bar, ax=axes, shrink=0.7, label="deflection (mm)\nheights drawn x 5")
    figure.savefig(file, dpi=120)


# %%
# The run
# -------
# The numbers to hit, thick roof: the published limit points 0.7421 and 0.1729, the first to 0.2 %, the second to 2 %; no
# published point farther than 1 % of the chart from the path. The second limit point converges to 0.1703 on finer meshes,
# below the published one. Between its limit points the thick roof has two bifurcations, where it is unstable already.
#
# The thin roof is another matter: 11 % below its limit point another branch crosses, and beyond it the roof is unstable.
# With a hundredth of the load off the centre it tips aside there and never sees the limit point. A quarter model with
# conditions of symmetry, as usual in publications, cannot show that.


def main(size: str = "full", out: str = "out") -> dict[str, sk.PathResult]:
    """Follow the paths, print tables, save pictures; returns the paths."""
    n = 16 if size == "full" else 6
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    stopped = three_controls(n)
    paths = {
        "thick": follow(roof(THICK, n), 1.08),
        "thin": follow(roof(THIN, n), 0.4),
        "thin, disturbed": follow(roof(THIN, n, 0.01), sk.DisplacementReached(CENTRE, DOWN, 21.0)),
    }
    event_table(paths)
    limits = [event.load_factor for event in paths["thick"].events if event.kind == "limit point"]
    top = next(event for event in paths["thick"].events if event.kind == "limit point")
    far = paths["thick"].solution
    after = sk.solve(far.system, load_factor=top.load_factor, start=far).unwrap()
    print(f"\nAt the limit point: deflection {deflection(top.solution):.2f}, after the snap {deflection(after):.2f}")
    distance = distance_to_published(paths["thick"])
    print(f"largest distance of a published point from the path: {100 * distance:.2f} % of the chart")
    picture(paths, top.solution, after, folder / "snap_through.png")

    exact = 2e-3 if size == "full" else 5e-3
    assert np.allclose(limits[0], 0.7421, rtol=exact) and np.allclose(limits[1], 0.1729, rtol=2e-2), limits
    assert np.isclose(stopped.solution.load_factor, limits[0], rtol=2e-3)
    assert distance < 1e-2, distance
    first = paths["thin"].events[0]
    assert first.kind == "bifurcation" and first.load_factor < 0.9 * paths["thin"].events[1].load_factor
    assert paths["thin, disturbed"].load_factors.max() < first.load_factor
    return paths


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A roof that snaps through")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
