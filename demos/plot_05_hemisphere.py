r"""
A pinched hemisphere
====================

.. image:: /pictures/gallery/05_hemisphere.jpg
   :alt: A hemisphere with a hole, pulled out at two ends and pushed in between, shaped like a lemon.
   :class: example-picture

A hemisphere of radius 10 and thickness 0.04, with a hole of 18 degrees at its top and a free edge at its equator, is pulled
outwards at two opposite points of the equator and pushed inwards at the two points between them, each by a force P up to
400 (:math:`E = 6.825 \cdot 10^7`, :math:`\nu = 0.3`). It bends almost without stretching, which is what thin curved elements
find hard: where cubics cannot make the membrane strain zero, they lock.

Example 3.4 of K. Y. Sze, X. H. Liu and S. H. Lo (2004), Popular benchmark problems for geometric nonlinear analysis of
shells, *Finite Elements in Analysis and Design* 40, 1551-1569. Their numbers are from one mesh of S4R elements.

This example shows a doubly curved shell, symmetry, membrane locking, and what mixed Newton saves. It builds on the
strip rolled up.
"""

# %%
# The published curve
# -------------------
# P / 400, the outward displacement at A, the inward one at B.
import argparse
import os
from math import pi, radians
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output
from skancf.output import von_mises

# sphinx_gallery_thumbnail_path = "pictures/gallery/05_hemisphere.jpg"

PUBLISHED = np.array([
    (0.05, 0.855, 0.955), (0.10, 1.499, 1.840), (0.15, 1.969, 2.604), (0.20, 2.321, 3.261), (0.25, 2.596, 3.833),
    (0.30, 2.819, 4.339), (0.35, 3.002, 4.790), (0.40, 3.158, 5.196), (0.45, 3.291, 5.565), (0.50, 3.406, 5.902),
    (0.55, 3.508, 6.212), (0.60, 3.598, 6.497), (0.65, 3.678, 6.761), (0.70, 3.750, 7.006), (0.75, 3.816, 7.234),
    (0.80, 3.875, 7.448), (0.85, 3.929, 7.647), (0.90, 3.979, 7.835), (0.95, 4.025, 8.011), (1.00, 4.067, 8.178),
])  # fmt: skip

# %%
# A quarter of it
# ---------------
# Two planes of symmetry leave a quarter, on whose edges act halves of the forces. One point is held along z, which
# carries no force. The parameters of the surface are the polar angle and the longitude.
RADIUS, THICKNESS, FORCE = 10.0, 0.04, 400.0
SURFACE = sk.SphereSector(RADIUS, polar=(radians(18), pi / 2), angle=pi / 2)
A, B = (pi / 2, 0.0), (pi / 2, pi / 2)
QUARTER = sk.Problem(
    surface=SURFACE,
    thickness=THICKNESS,
    material=sk.Isotropic(6.825e7, 0.3, density=1.0),
    supports=[sk.Symmetry("start"), sk.Symmetry("end"), sk.Prescribed((pi / 2, pi / 4), (None, None, 0.0))],
    loads=[sk.PointForce(A, (FORCE / 2, 0.0, 0.0)), sk.PointForce(B, (0.0, -FORCE / 2, 0.0))],
)


def system_on(n: int, theory: sk.Kirchhoff | None = None) -> Any:
    """n x n elements on the quarter."""
    return QUARTER.on(sk.meshes.uniform(SURFACE, n, n), theory or sk.Kirchhoff())


def pinch(solution: sk.Solution) -> tuple[float, float]:
    """Displacement outwards at A and inwards at B."""
    return float(solution.displacement(A)[0]), -float(solution.displacement(B)[1])


def curve(n: int) -> tuple[np.ndarray, sk.Solution]:
    """Displacements at A and B for the loads of the published table, (20, 2), each solved from the one before."""
    system, rows = system_on(n), []
    state: Any = None
    for factor in PUBLISHED[:, 0]:
        state = sk.solve(system, load_factor=factor, start=state).unwrap()
        rows.append(pinch(state))
    return np.array(rows), state


# %%
# Locking, and the iterations
# ---------------------------
# ``Kirchhoff(assumed=False)`` takes membrane strains as they are. ``mixed=False`` is the plain Newton method; the default
# keeps the stresses as unknowns of their own while it iterates, which changes the way to the answer and not the answer.


def convergence(counts: list[int]) -> dict[str, np.ndarray]:
    """Displacements (n, 2) at full load of both elements on all meshes, by their name; prints a table."""
    columns: dict[str, list[tuple[float, float]]] = {"assumed": [], "as they are": []}
    print("membrane strains  elements   at A     at B   load steps  iterations")
    for name, rows in columns.items():
        for n in counts:
            result = sk.solve(system_on(n, sk.Kirchhoff(assumed=name == "assumed")))
            rows.append(pinch(result.unwrap()))
            print(f"{name:<16}  {n:3d} x {n:<3d} {rows[-1][0]:7.4f}  {rows[-1][1]:7.4f}  "
                  f"{len(result.path) - 1:10d}  {result.iterations:10d}")  # fmt: skip
    return {name: np.array(rows) for name, rows in columns.items()}


def newton_table(n: int) -> dict[str, sk.StaticResult]:
    """Solves the whole load by both methods and prints what it took."""
    results = {"mixed": sk.solve(system_on(n)), "plain": sk.solve(system_on(n), mixed=False)}
    print(f"\nNewton on {n} x {n}   load steps  iterations, failed attempts included")
    for name, result in results.items():
        print(f"{name:<15}  {len(result.path) - 1:10d}  {result.iterations:10d}   at A {pinch(result.unwrap())[0]:.5f}")
    return results


def curve_table(found: np.ndarray) -> None:
    """Prints the curve next to the published one."""
    print("\nP / 400     at A  published        at B  published")
    for (factor, *published), values in zip(PUBLISHED, found, strict=True):
        print(f"{factor:7.2f}  {values[0]:7.3f}  {published[0]:9.3f}     {values[1]:7.3f}  {published[1]:9.3f}")


# %%
# Pictures
# --------
# The whole shell is the quarter, mirrored at its two planes of symmetry.


def draw_shell(axes: plt.Axes, state: sk.Solution, limit: float) -> None:
    """The whole shell, coloured by von Mises' stress on the outer face up to a limit."""
    surface = output.sample(state, 2, z=THICKNESS / 2)
    stress = von_mises(surface.stress)[surface.cells].mean(axis=1)
    colours = plt.colormaps["viridis"](stress / limit)
    mirrors = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)]
    cells = np.concatenate([(surface.points * mirror)[surface.cells] for mirror in mirrors])
    output.draw_cells(axes, cells, np.tile(colours, (4, 1)), light=(0.4, -0.6, 0.7))
    axes.set(xlim=(-14, 14), ylim=(-14, 14), zlim=(-6, 13))
    axes.set_box_aspect((28, 28, 19), zoom=1.42)
    axes.view_init(elev=24, azim=-68)
    axes.set_title(f"P = {FORCE * state.load_factor:g}", y=0.95)


def draw_curve(axes: plt.Axes, found: np.ndarray, n: int) -> None:
    """Load against both displacements."""
    load = FORCE * np.concatenate([[0.0], PUBLISHED[:, 0]])
    for k, (name, colour) in enumerate((("outwards at A", "#0072B2"), ("inwards at B", "#D55E00"))):
        axes.plot(np.concatenate([[0.0], found[:, k]]), load, color=colour, label=f"{name}, {n} x {n}")
        axes.plot(PUBLISHED[:, k + 1], load[1:], "o", mfc="none", color=colour, label="published")
    axes.set(xlabel="displacement", ylabel="P", title="Load and displacements")
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


def draw_convergence(axes: plt.Axes, counts: list[int], columns: dict[str, np.ndarray]) -> None:
    """Displacement at A against the number of elements."""
    for (name, rows), style in zip(columns.items(), ("o-", "s--"), strict=True):
        axes.plot(counts, rows[:, 0], style, label=f"membrane strains {name}")
    axes.axhline(PUBLISHED[-1, 1], color="k", lw=1, ls=":", label="published")
    axes.set_xscale("log", base=2)
    axes.set(xlabel="elements along a side of the quarter", ylabel="displacement at A", xticks=counts,
             xticklabels=[str(n) for n in counts], title="Full load: locking and convergence")  # fmt: skip
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


def draw_newton(axes: plt.Axes, results: dict[str, sk.StaticResult]) -> None:
    """Residual against the iterations, all attempts one after the other."""
    for (name, result), colour in zip(results.items(), ("#0072B2", "#D55E00"), strict=True):
        axes.plot([], [], color=colour, label=f"{name}: {result.iterations} in {len(result.path) - 1} load steps")
        done = 0
        for _, attempt in result.attempts:
            norms = np.array(attempt.residual_norms)
            axes.semilogy(done + np.arange(len(norms)), norms, ".-" if attempt.ok else "x:", color=colour)
            done += len(norms)
    axes.set_ylim(bottom=1e-15)
    axes.set(xlabel="iteration", ylabel="residual norm", title="Newton (crosses: attempts that failed)")
    axes.legend(frameon=False, loc="lower right")
    axes.grid(color="#e0e0e0")


# %%
# The run
# -------
# The numbers to hit: all along the curve 0.2 % of the published displacement at A and 1 % of that at B; 4.069 and 8.142 on
# 16 x 16 elements at full load; and on 8 x 8 the assumed strains less than half as far from the limit as the others.
#
# At B we stay below the published values, by 0.8 % where the difference is largest, and a finer mesh does not close that
# gap: 32 x 32 elements give 8.1488 at full load and 64 x 64 give 8.1493, where the table has 8.178.


def main(size: str = "full", out: str = "out") -> dict[str, np.ndarray]:
    """Pinch the shell, print tables, save pictures; returns the displacements at full load by kind of strain."""
    counts, fine = ([4, 8, 16, 32], 32) if size == "full" else ([4, 8, 16], 16)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    columns = convergence(counts)
    newton = newton_table(16)
    found, state = curve(fine)
    curve_table(found)

    figure = plt.figure(figsize=(14, 9.5), layout="constrained")
    grid = figure.add_gridspec(2, 6, height_ratios=[1, 1])
    states = [sk.solve(state.system, load_factor=factor).unwrap() for factor in (0.05, 0.25)] + [state]
    shells = [figure.add_subplot(grid[0, 2 * k : 2 * k + 2], projection="3d") for k in range(3)]
    for place, shown in zip(shells, states, strict=True):
        draw_shell(place, shown, 4e5)
    bar = plt.cm.ScalarMappable(plt.Normalize(0, 400), plt.colormaps["viridis"])
    figure.colorbar(bar, ax=shells, shrink=0.7, extend="max", label="von Mises stress on the outer face / 1000")
    axes = [figure.add_subplot(grid[1, 2 * k : 2 * k + 2]) for k in range(3)]
    draw_curve(axes[0], found, fine)
    draw_convergence(axes[1], counts, columns)
    draw_newton(axes[2], newton)
    figure.savefig(folder / "hemisphere.png", dpi=120)

    off = np.abs(found / PUBLISHED[:, 1:] - 1).max(axis=0)
    print(f"\nlargest difference from the published curve: {100 * off[0]:.2f} % at A, {100 * off[1]:.2f} % at B")
    assert off[0] < 2e-3 and off[1] < 1e-2, off
    assert newton["plain"].iterations > 3 * newton["mixed"].iterations
    at_16, at_8 = counts.index(16), counts.index(8)
    assert np.allclose(columns["assumed"][at_16], (4.0626, 8.1292), rtol=1e-3)
    limit = 4.0742  # 64 x 64 elements
    assert abs(columns["assumed"][at_8, 0] - limit) < 0.5 * abs(columns["as they are"][at_8, 0] - limit)
    return columns


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A pinched hemisphere")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
