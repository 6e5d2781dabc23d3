r"""
A rubber sheet, stretched and pinched
=====================================

.. image:: /pictures/gallery/22_rubber_sheet.jpg
   :alt: A rubber sheet pressed at its crown until it folds.
   :class: example-picture

A sheet of incompressible neo-Hookean rubber, 157 mm by 100 mm and 6 mm thick. It is first pulled to twice its length between
grips that let its width shrink. The force has a closed form,

.. math:: F = \mu \, b \, t \, (\lambda - \lambda^{-2}) .

Then another one of its kind is vulcanised as half of a tube. It stands with its two straight edges in grooves, and is
pinched along its crown until it gives way, snaps through and hangs from the grooves.

This example shows rubber that is pulled, bent and snaps, how work on a path is stored, and what theory `full` makes of
rubber. It builds on a balloon past its limit point.
"""

# %%
# Pulled
# ------
# One element would do: the state is uniform, and positions are linear.
import argparse
import os
from math import pi
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/22_rubber_sheet.jpg"

RADIUS, WIDTH, THICKNESS, MU, DENSITY = 0.1, 0.1, 6e-3, 4.225e5, 1000.0
LENGTH = pi / 2 * RADIUS
RUBBER = sk.NeoHooke(MU, DENSITY)
SOFTER = sk.NeoHooke(MU, DENSITY, poisson=0.45)


def pulled(stretches: np.ndarray, theory: str, law: sk.NeoHooke) -> np.ndarray:
    """Forces of the grips (N)."""
    supports = [sk.Roller("left", (1, 0, 0)), sk.Roller("bottom", (0, 1, 0)), sk.Roller("boundary"),
                sk.Prescribed("right", (LENGTH, None, None))]  # fmt: skip
    surface = sk.Rectangle(LENGTH, WIDTH)
    system = sk.Problem(surface, THICKNESS, law, supports).on(sk.meshes.uniform(surface, 2, 2), theory)
    states = [sk.solve(system, load_factor=float(l) - 1, rtol=1e-12).unwrap() for l in stretches]
    return np.array([state.reactions("right")[0] for state in states])


# %%
# Pinched
# -------
# A quarter of the half-tube, with the planes of symmetry; its outer edge is free. The load on the crown is dead, and its
# path by arc length goes through the maximum, the jump and on to where the sheet hangs. Only symmetric motions are followed:
# a whole arch without guides may sway aside before.
SURFACE = sk.CylinderSector(RADIUS, WIDTH / 2, pi / 2)
LOAD, CROWN, CORNER = 20.0, (0.0, pi / 2), (WIDTH / 2, pi / 2)


def pinched(n: int, theory: str = "kirchhoff", law: sk.NeoHooke = RUBBER) -> sk.PathResult:
    """The path on n elements along a quarter of the arch."""
    supports = [sk.Pin("start"), sk.Symmetry(["end", "left"])]
    problem = sk.Problem(SURFACE, THICKNESS, law, supports, [sk.EdgeLoad("end", (0.0, 0.0, -LOAD / 2))])
    system = problem.on(sk.meshes.uniform(SURFACE, max(2, n // 4), n), theory)
    end = sk.DisplacementReached(CROWN, (0, 0, -1), 1.8 * RADIUS)
    return sk.trace(system, sk.ArcLength(first=0.05), until=end).unwrap()


def descent(state: sk.Solution) -> float:
    """Mean of the crown, over the radius: what the load does work on."""
    at = np.linspace(0.0, WIDTH / 2, 41)
    down = -state.displacement(np.stack([at, np.full(41, pi / 2)], axis=1))[:, 2]
    return float(np.trapezoid(down, at) / (WIDTH / 2)) / RADIUS


def stored(path: sk.PathResult) -> tuple[float, float]:
    """Strain energy at the end, and the work of the load along the path (J)."""
    turned = CubicSpline(np.arange(len(path.solutions)), np.stack([
        [descent(s) * RADIUS, s.load_factor * LOAD / 2 * WIDTH / 2] for s in path.solutions]))  # fmt: skip
    steps = np.linspace(0.0, len(path.solutions) - 1.0, 4001)
    down, force = turned(steps).T
    return path.solution.strain_energy, float(np.trapezoid(force, down))


# %%
# Pictures
# --------
COLOURS = {"kirchhoff": "#0072B2", "full": "#D55E00"}


def draw_pull(axes: plt.Axes, stretches: np.ndarray, forces: np.ndarray) -> None:
    fine = np.linspace(1.0, 2.0, 100)
    axes.plot(fine, MU * WIDTH * THICKNESS * (fine - fine**-2), color="#505050", lw=1, label="exact")
    axes.plot(stretches, forces, "o", mfc="none", color=COLOURS["kirchhoff"], label="on the mesh")
    axes.set(xlabel="stretch", ylabel="force of a grip (N)", title="Pulled")
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


def draw_paths(axes: plt.Axes, paths: dict[str, sk.PathResult]) -> None:
    for (name, path), style in zip(paths.items(), ("-", "--", ":"), strict=False):
        down, load = (np.array(part) for part in zip(
            *((descent(s), s.load_factor * LOAD) for s in path.solutions), strict=True))  # fmt: skip
        axes.plot(down, load, style, color=COLOURS[name.split(",")[0]], marker=".", ms=4, label=name)
    top = next(iter(paths.values())).events[0].solution
    axes.plot(descent(top), top.load_factor * LOAD, "^", color="#505050", ms=8, label="limit point")
    axes.axhline(0, color="#a0a0a0", lw=0.8)
    axes.set(xlabel="descent of the crown over the radius", ylabel="load along the crown (N/m)", title="Pinched")
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


def draw_shapes(axes: plt.Axes, states: list[sk.Solution]) -> None:
    """Both halves in some states, side by side, coloured by height."""
    for k, state in enumerate(states):
        surface = output.sample(state, 4)
        whole = [surface.points * [a, b, 1] for a in (-1, 1) for b in (-1, 1)]
        for points in whole:
            cells = points[surface.cells] + [0, 2.5 * RADIUS * k, 0]
            height = (surface.points[surface.cells][..., 2].mean(axis=1) + RADIUS) / (2.2 * RADIUS)
            output.draw_cells(axes, cells, plt.colormaps["viridis"](height), light=(0.5, -0.4, 0.8))
    axes.set(xlim=(-0.06, 0.06), ylim=(-0.11, 0.61), zlim=(-0.09, 0.11))
    axes.set_box_aspect((0.12, 0.72, 0.2), zoom=2.0)
    axes.view_init(elev=20, azim=-20)
    axes.set_title("at rest, at the limit point, snapped", y=0.9, fontsize=11)


# %%
# The run
# -------
# The numbers to hit: the force of the grips to nine digits; the limit load on twice as many elements to two per mille; the
# strain energy at the end, which is the work of the load on the way, negative parts of it included, to half a per
# mille. Rubber that can be squeezed a little, with Poisson's ratio of 0.45, is in theory `full`, too, whose thickness may
# change and which knows transverse shear. Its error falls with the square of the elements, so that two meshes say where it
# goes: one per cent below theory `kirchhoff`.


def main(size: str = "full", out: str = "out") -> dict[str, sk.PathResult]:
    """Pull and pinch, print what comes out, save a picture; returns the paths."""
    n = 8 if size == "full" else 4
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    stretches = np.linspace(1.0, 2.0, 6)[1:]
    forces = pulled(stretches, "kirchhoff", RUBBER)
    exact = MU * WIDTH * THICKNESS * (stretches - stretches**-2)
    print("stretch " + " ".join(f"{l:8.2f}" for l in stretches))
    print("force   " + " ".join(f"{f:8.3f}" for f in forces) + " N")
    print("exact   " + " ".join(f"{f:8.3f}" for f in exact) + " N\n")
    assert np.allclose(forces, exact, rtol=1e-9)

    paths = {"kirchhoff": pinched(n), "kirchhoff, 0.45": pinched(n, law=SOFTER),
             "full, 0.45": pinched(2 * n, "full", SOFTER)}  # fmt: skip
    most = {name: LOAD * path.events[0].load_factor for name, path in paths.items()}
    for name, path in paths.items():
        top = path.events[0]
        strain = np.abs(top.solution.strains(np.array([[0.5], [0.5]]), "top")).max()
        print(f"{name:<16} limit load {most[name]:.3f} N/m where the crown is {descent(top.solution):.3f} R lower, strains "
              f"to {strain:.2f}; {path.iterations / (len(path.solutions) - 1):.1f} iterations a step")  # fmt: skip
        assert [event.kind for event in path.events][:1] == ["limit point"]
    energy, work = stored(paths["kirchhoff"])
    print(f"\nstored at the end {1e3 * energy:.4f} mJ, work of the load {1e3 * work:.4f} mJ")
    assert np.isclose(energy, work, rtol=5e-4)
    if size == "full":
        finer, coarser = (LOAD * pinched(m, *of).events[0].load_factor for m, of in ((2 * n, ()), (n, ("full", SOFTER))))
        print(f"kirchhoff on twice as many elements each way: {finer:.3f} N/m")
        goes_to = (4 * most["full, 0.45"] - coarser) / 3
        print(f"full, 0.45, from {coarser:.3f} and {most['full, 0.45']:.3f} N/m on two meshes: {goes_to:.3f} N/m")
        assert np.isclose(most["kirchhoff"], finer, rtol=2e-3)
        assert np.isclose(goes_to, most["kirchhoff, 0.45"], rtol=1.5e-2)

    figure = plt.figure(figsize=(14, 7.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=[1, 0.9])
    draw_pull(figure.add_subplot(grid[0, 0]), stretches, forces)
    draw_paths(figure.add_subplot(grid[0, 1]), paths)
    path = paths["kirchhoff"]
    draw_shapes(figure.add_subplot(grid[1, :], projection="3d"), [path.solutions[0], path.events[0].solution, path.solution])
    figure.savefig(folder / "rubber_sheet.png", dpi=110)
    return paths


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A rubber sheet, stretched and pinched")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
