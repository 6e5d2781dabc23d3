r"""
A laminate that curls when it cools
===================================

.. image:: /pictures/gallery/07_laminate.jpg
   :alt: A square sheet that has curled into a cylinder.
   :class: example-picture

A sheet of two carbon fibre layers, the fibres of the lower one along x and those of the upper one along y, is cured hot and
flat. When it cools, each layer wants to shrink across its fibres and is held by the other: the sheet curls. Classical
lamination theory (R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., 1999, chapter 4) says into a saddle: with
:math:`(N_T, M_T) = \int Q \alpha \, \Delta T \, (1, z) \, dz`

.. math:: \begin{bmatrix} A & B \\ B & D \end{bmatrix} \begin{bmatrix} \varepsilon \\ \kappa \end{bmatrix} =
    \begin{bmatrix} N_T \\ M_T \end{bmatrix}, \qquad \kappa_y = -\kappa_x .

Small sheets do that. But a saddle has to stretch, because its Gaussian curvature :math:`\kappa_x \kappa_y` is not zero, and
the more so the larger it is. M. W. Hyer found that large sheets become *cylinders* instead, about x or about y, and that
they snap from one to the other (Some observations on the cured shape of thin unsymmetric laminates, *Journal of Composite
Materials* 15, 1981, 175-194). A cylinder does not stretch; lamination theory gives its curvature too, when :math:`\kappa_y`
is set to zero and the moment :math:`M_y` left out.

This example shows laminates, temperature, stresses in layers, two stable shapes. It builds on the roof that snaps
through.
"""

# %%
# Lamination theory
# -----------------
# Written out here, so that it shares nothing with the library.
import argparse
import os
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/07_laminate.jpg"

E1, E2, NU12, G12, ALPHA1, ALPHA2 = 140e9, 9e9, 0.3, 5e9, -0.3e-6, 28e-6
PLY, COOLING = 0.25e-3, -120.0


def layers() -> list[tuple[np.ndarray, np.ndarray, float, float]]:
    """Plane stress stiffness, expansion and lower and upper face of the layer along x, then of that along y."""
    factor = 1 / (1 - NU12**2 * E2 / E1)
    along_x = np.array([[factor * E1, factor * NU12 * E2, 0], [factor * NU12 * E2, factor * E2, 0], [0, 0, G12]])
    swap = [1, 0, 2]
    alpha = np.array([ALPHA1, ALPHA2, 0.0])
    return [(along_x, alpha, -PLY, 0.0), (along_x[np.ix_(swap, swap)], alpha[swap], 0.0, PLY)]


def free_shape(flat_along_y: bool = False) -> np.ndarray:
    """Strains and curvatures (6,) of the cooled sheet, with or without curvature along y."""
    stiffness, thermal = np.zeros((6, 6)), np.zeros(6)
    for Q, alpha, low, high in layers():
        moments = [(high**k - low**k) / k for k in (1, 2, 3)]
        stiffness += np.block([[moments[0] * Q, moments[1] * Q], [moments[1] * Q, moments[2] * Q]])
        thermal += np.concatenate([moments[0] * Q @ alpha, moments[1] * Q @ alpha]) * COOLING
    free = [0, 1, 2, 3, 5] if flat_along_y else [0, 1, 2, 3, 4, 5]
    out = np.zeros(6)
    out[free] = np.linalg.solve(stiffness[np.ix_(free, free)], thermal[free])
    return out


def stress_of(shape: np.ndarray, layer: int, z: np.ndarray) -> np.ndarray:
    """Stresses 11, 22, 12 of a shape (6,) in a layer at depths z (n,): (n, 3)."""
    Q, alpha, _, _ = layers()[layer]
    return (shape[:3] + z[:, None] * shape[3:] - alpha * COOLING) @ Q


# %%
# The sheet
# ---------
# A quarter of a square, with two planes of symmetry. A small moment on the edge makes it a little imperfect, so that it
# chooses a cylinder when it cools in steps; then the moment is taken away.
FIBRES = sk.Orthotropic((E1, E2, E2), (NU12, NU12, 0.4), (G12, G12, 3e9), density=1600.0, expansion=(ALPHA1, ALPHA2, ALPHA2))
LAMINATE = sk.Laminate([sk.Layer(FIBRES, PLY), sk.Layer(FIBRES, PLY, angle=np.pi / 2)])
IMPERFECTION = 0.1  # N, a moment per length


def sheet(mesh: Any, moment: float = 0.0) -> Any:
    """A quarter of the sheet, cooled, with a moment per length on its edge."""
    side = mesh.p.max()
    problem = sk.Problem(
        surface=sk.Rectangle(side, side),
        material=LAMINATE,
        supports=[sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Prescribed((0.0, 0.0), (None, None, 0.0))],
        loads=[sk.Temperature(COOLING), sk.EdgeMoment("right", (0.0, moment, 0.0))],
    )
    return problem.on(mesh, "kirchhoff")


def mesh_of(side: float, n: int) -> Any:
    """n x n elements on the quarter of a sheet."""
    return sk.meshes.uniform(sk.Rectangle(side / 2, side / 2), n, n)


def saddle(side: float, n: int) -> sk.StaticResult:
    """The symmetric shape, stable or not."""
    return sk.solve(sheet(mesh_of(side, n)), relax=False)


def settled(side: float, n: int, sign: float = 1.0) -> sk.StaticResult:
    """The stable shape on one side: cooled in steps with an imperfection, which is then taken away."""
    mesh = mesh_of(side, n)
    cooled = sk.solve(sheet(mesh, -sign * IMPERFECTION), control=sk.HalveAndGrow(first=0.05, growth=1.3)).unwrap()
    return sk.solve(sheet(mesh), start=cooled)


def at_centre(solution: sk.Solution) -> np.ndarray:
    """Strains of the mid-surface and curvatures (6,) in the middle of the sheet."""
    corner = np.zeros((2, 1))
    element, corner[:, 0] = solution.system.geometry.locate((0.0, 0.0))
    below, above = (solution.strains(corner, z)[element, 0, [0, 1, 5]] for z in (-PLY, PLY))
    return np.concatenate([(above + below) / 2, (above - below) / (2 * PLY)])


# %%
# Stress through the thickness
# ----------------------------
# ``Solution.stresses(points, z)`` takes the law of the layer at z, of the lower one at the interface: the stress along x and
# that along y jump there, where the fibres turn.


def stress_through(solution: sk.Solution, z: np.ndarray) -> np.ndarray:
    """Stresses 11 and 22 in the middle of the sheet at depths z (n,): (n, 2) (Pa)."""
    corner = np.zeros((2, 1))
    element, corner[:, 0] = solution.system.geometry.locate((0.0, 0.0))
    return np.array([solution.stresses(corner, depth)[element, 0, :2] for depth in z])


# %%
# Tables
# ------


def shapes_table(sides: np.ndarray, n: int) -> dict[str, np.ndarray]:
    """For all sides -kappa_x of the saddle (m,), -kappa_x and kappa_y of the settled shape (m, 2), and whether the saddle is
    stable (m,)."""
    saddles, shapes, stable = [], [], []
    print("side (mm)   saddle: curvatures -+ (1/m)      settled: along x, along y")
    for side in sides:
        symmetric, other = saddle(side, n), settled(side, n)
        assert not other.negative_pivots, "the settled shape should be stable"
        saddles.append(-at_centre(symmetric.unwrap())[3])
        shapes.append(at_centre(other.unwrap())[[3, 4]])
        stable.append(not symmetric.negative_pivots)
        print(f"{1e3 * side:9.1f}   {saddles[-1]:8.4f} {'stable' if stable[-1] else 'not stable':<12}"
              f"      {shapes[-1][0]:19.4f} {shapes[-1][1]:8.4f}")  # fmt: skip
    return {"saddle": np.array(saddles), "settled": np.array(shapes) * (-1, 1), "stable": np.array(stable)}


def critical_side(side: float, n: int) -> float:
    """Side from which on the saddle is not stable.

    The path of a sheet that cools has a bifurcation at a part of the cooling. While rotations are small only cooling times
    the side squared counts, so that the whole cooling has its bifurcation at the side times the root of that part.
    """
    path = sk.trace(sheet(mesh_of(side, n)), until=1.0).unwrap()
    first = next(event for event in path.events if event.kind == "bifurcation")
    print(f"\na sheet of {1e3 * side:g} mm leaves the saddle after a cooling of {-COOLING * first.load_factor:.2f} K")
    return float(side * np.sqrt(first.load_factor))


# %%
# Pictures
# --------


def draw_shapes(axes: plt.Axes, sides: np.ndarray, found: dict[str, np.ndarray], critical: float) -> None:
    """Curvatures against the side: a pitchfork."""
    mm, stable, curvature = 1e3 * sides, found["stable"], found["saddle"]
    fork = 1e3 * critical
    turn = np.interp(fork, mm, curvature)
    blue, orange = "#0072B2", "#D55E00"
    axes.plot([*mm[stable], fork], [*curvature[stable], turn], color=blue, lw=2, label="saddle, stable")
    axes.plot([fork, *mm[~stable]], [turn, *curvature[~stable]], "--", color=orange, lw=1.8, label="saddle, not stable")
    for k, style in ((1, "o-"), (0, "s-")):
        axes.plot([fork, *mm[~stable]], [turn, *found["settled"][~stable, k]], style, ms=4, color=blue, lw=2, mfc="white",
                  label="cylinder, " + (r"$-\kappa_x$", r"$\kappa_y$")[k])  # fmt: skip
    axes.plot(fork, turn, "D", color="#009E73", ms=8, label="bifurcation")
    values = [abs(free_shape(flat)[3]) for flat in (False, True)]
    for value in values:
        axes.axhline(value, color="k", lw=1, ls=":")
    axes.text(mm[-1], values[0] + 0.07, "lamination theory: saddle {:.2f}, cylinder {:.2f}".format(*values), ha="right",
              fontsize=9)  # fmt: skip
    axes.set(xlabel="side of the sheet (mm)", ylabel=r"$-\kappa_x$ and $\kappa_y$ in the middle (1/m)", xlim=(0, None),
             ylim=(-0.5, 6), title="Saddle or cylinder")  # fmt: skip
    axes.legend(frameon=False, loc="center right", bbox_to_anchor=(1.0, 0.52))
    axes.grid(color="#e0e0e0")


def draw_stress(axes: plt.Axes, solution: sk.Solution) -> None:
    """Stress through the thickness of the cylinder, with lamination theory's lines."""
    for layer, (_, _, low, high) in enumerate(layers()):
        z = np.linspace(low, high, 7)
        inside = z + 1e-3 * PLY * np.linspace(1, -1, 7)
        lines, found = stress_of(free_shape(True), layer, z), stress_through(solution, inside)
        for k, (colour, name) in enumerate((("#0072B2", "along x"), ("#D55E00", "along y"))):
            axes.plot(1e-6 * lines[:, k], 1e3 * z, color=colour, lw=1.5)
            axes.plot(1e-6 * found[:, k], 1e3 * z, "o", color=colour, ms=5, label=None if layer else f"stress {name}")
    axes.axhline(0, color="k", lw=0.8)
    axes.text(0.02, 0.97, "fibres along y", transform=axes.transAxes, va="top", color="#505050")
    axes.text(0.02, 0.03, "fibres along x", transform=axes.transAxes, color="#505050")
    axes.set(xlabel="stress (MPa)", ylabel="z (mm)", title="Cylinder: stress in the layers (lines: lamination theory)")
    axes.legend(frameon=False, loc="upper right")
    axes.grid(color="#e0e0e0")


def draw_sheet(axes: plt.Axes, solution: sk.Solution, title: str, enlarged: float = 1.0) -> None:
    """The whole sheet, mirrored from its quarter, coloured by its height."""
    surface = output.sample(solution, 3)
    side = float(solution.system.mesh.p.max())
    points = surface.points / side
    height = points[:, 2] - points[:, 2].mean()
    share = (height - height.min()) / np.ptp(height)
    quarter = np.column_stack([points[:, :2], enlarged * height])
    mirrors = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)]
    cells = np.concatenate([(quarter * mirror)[surface.cells] for mirror in mirrors])
    colour = plt.colormaps["viridis"](0.15 + 0.8 * share[surface.cells].mean(axis=1))
    output.draw_cells(axes, cells, np.tile(colour, (4, 1)), light=(0.5, -0.3, 0.81))
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.35, 0.35))
    axes.set_box_aspect((2, 2, 0.7), zoom=1.05)
    axes.view_init(elev=24, azim=-60)
    axes.set_title(title, y=0.93, fontsize=11)


# %%
# The run
# -------
# The numbers to hit: the small-deflection answer has lamination theory's saddle and its stresses in every layer to one part
# in a million, whatever the side; the smallest sheet that is run has its curvature to 3 %. The strains in the middle of the
# largest are those of lamination theory's cylinder to 2 % of the larger one, its curvature to 3 %, and the curvature along
# the axis is below 2 % of it. That curvature nears its limit slowly and from both sides, because what happens at the ends of
# a cylinder reaches far along it. The bifurcation that the path of a cooling sheet has lies between the sides where the
# table changes from stable to not stable, and both cylinders are mirror images.


def main(size: str = "full", out: str = "out") -> dict[str, np.ndarray]:
    """Cool the sheets, print tables, save pictures; returns the curvatures."""
    n = 12 if size == "full" else 6
    sides = np.array([10, 15, 20, 25, 30, 35, 40, 45, 48, 52, 55, 60, 70, 80, 100, 125, 150]
                     if size == "full" else [10, 25, 40, 60, 100, 150]) / 1e3  # fmt: skip
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    found = shapes_table(sides, n)
    critical = critical_side(0.06, n)
    print(f"so that with a cooling of {-COOLING:g} K saddles end at a side of {1e3 * critical:.2f} mm")

    small = saddle(0.04, n).unwrap()
    large, turned = (settled(sides[-1], n, sign).unwrap() for sign in (1.0, -1.0))
    figure = plt.figure(figsize=(13, 9), layout="constrained")
    grid = figure.add_gridspec(2, 6, height_ratios=[1, 1.3])
    titles = ("40 mm: saddle, heights x 5", "150 mm: a cylinder ...", "... and the other one, as stable")
    for k, (solution, title) in enumerate(zip((small, large, turned), titles, strict=True)):
        draw_sheet(figure.add_subplot(grid[0, 2 * k : 2 * k + 2], projection="3d"), solution, title, 1.0 if k else 5.0)
    draw_shapes(figure.add_subplot(grid[1, :3]), sides, found, critical)
    draw_stress(figure.add_subplot(grid[1, 3:]), large)
    figure.savefig(folder / "laminate.png", dpi=120)

    linear, z = sk.solve_linear(sheet(mesh_of(0.1, n))), np.array([-0.9, -0.1]) * PLY
    assert np.allclose(at_centre(linear), free_shape(), atol=1e-6 * abs(free_shape()[3])), at_centre(linear)
    for layer in (0, 1):
        depths = z + layer * PLY
        assert np.allclose(stress_through(linear, depths), stress_of(free_shape(), layer, depths)[:, :2], rtol=1e-6)
    assert np.isclose(found["saddle"][0], abs(free_shape()[3]), rtol=3e-2)
    cylinder, theory = at_centre(large), free_shape(True)
    assert np.allclose(cylinder[:2], theory[:2], atol=2e-2 * abs(theory[0])), (cylinder, theory)
    assert np.isclose(cylinder[3], theory[3], rtol=3e-2) and abs(cylinder[4]) < 0.02 * abs(theory[3]), (cylinder, theory)
    assert sides[found["stable"]].max() < critical < sides[~found["stable"]].min()
    assert np.allclose(at_centre(turned)[[3, 4]], -at_centre(large)[[4, 3]], rtol=1e-3, atol=1e-3)
    return found


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A laminate that curls when it cools")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
