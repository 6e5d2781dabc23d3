r"""
A plate with a doubler
======================

.. image:: /pictures/gallery/24_doubler.jpg
   :alt: A sheet with a doubler bonded on, coloured by stress.
   :class: example-picture

Where a bracket is bolted to a sheet, a second sheet is bonded on: a doubler. Here it is a :class:`~skancf.Zone`, a named
part of the parameter plane with a section of its own. Zones consist of whole elements, so that the mesh has lines where they
end: ``meshes.with_lines`` puts them there, and refinement keeps them.

The numbers to compare with are those of a beam of two thicknesses: a cantilever of the length L with an end force P, whose
thickness is doubled between a and b, moves by

.. math:: w = \frac{P}{E I} \Bigl( \int_0^a + \tfrac18 \int_a^b + \int_b^L \Bigr) (L - x)^2 \, dx .

In bending the curvature jumps where the thickness does, and cubics with slopes of their own can do that. In stretching the
strain jumps, and slopes at a node are one: theory `full` is of first order there. Its estimate of the error sees it, and
``adapt`` makes the mesh fine at the border. A row of thin elements on both sides, ``with_lines(..., beside=...)``, does so
without any search.

This example shows zones, meshes with lines where they end, stress at the faces of each place, and what a jump of the
stiffness costs. It builds on a blade that grows thinner to its tip.
"""

# %%
# A strip
# -------
import argparse
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/24_doubler.jpg"

LENGTH, WIDTH, THIN, YOUNG = 1.0, 0.1, 4e-3, 70e9
START, END = 0.3, 0.5
STRIP = sk.Rectangle(LENGTH, WIDTH)
DOUBLER = sk.Zone("doubler", ((START, END), (0.0, WIDTH)), thickness=2 * THIN)
FORCE = 1.0


def strip(loads: list, zones: tuple = (DOUBLER,)) -> sk.Problem:
    """A cantilever without lateral contraction, which is a beam."""
    return sk.Problem(STRIP, THIN, sk.Isotropic(YOUNG, 0.0, 2700.0), [sk.Clamp("left")], loads, zones=zones)


def bent() -> tuple[sk.Solution, float]:
    """The strip under an end force, and the deflection of the beam."""
    problem = strip([sk.EdgeLoad("right", (0.0, 0.0, FORCE / WIDTH))])
    state = sk.solve_linear(problem.on(sk.meshes.with_lines(STRIP, 20, 1, problem.zones), "kirchhoff"))
    part = [((LENGTH - a) ** 3 - (LENGTH - b) ** 3) / 3 for a, b in ((0, START), (START, END), (END, LENGTH))]
    return state, FORCE / (YOUNG * WIDTH * THIN**3 / 12) * (part[0] + part[1] / 8 + part[2])


# %%
# A bracket on a sheet
# --------------------
# A sheet that is held along its rim carries a force on a small disk. The doubler lies on top of it, so that its mid-plane is
# half a sheet higher: ``offset`` says so.
SHEET = sk.Rectangle(0.4, 0.3)
PATCH = ((0.14, 0.26), (0.1, 0.2))


def sheet(zones: tuple) -> sk.Solution:
    """The sheet under its force, with large deflections."""
    problem = sk.Problem(
        SHEET, 1e-3, sk.Isotropic(YOUNG, 0.33, 2700.0), [sk.Clamp("boundary")],
        [sk.DiskForce(at=(0.2, 0.15), radius=0.02, force=(0.0, 0.0, -20.0))], zones=zones,
    )  # fmt: skip
    mesh = sk.meshes.with_lines(SHEET, 16, 12, [sk.Zone("patch", PATCH, thickness=2e-3)])
    return sk.solve(problem.on(mesh, "kirchhoff")).unwrap()


# %%
# Stretched
# ---------
# Of a strip that is pulled, the exact answer is the sum of its parts, :math:`u = \\sum N l / E h`.


def pulled(n: int, beside: float | None = None) -> tuple[float, float, float]:
    """Of the end's displacement on n elements in theory `full`, with thin rows beside the borders or without: error,
    estimated error, and its bar; relative."""
    stretch = 1e-5
    problem = strip([sk.EdgeLoad("right", (YOUNG * THIN * stretch, 0.0, 0.0))])
    exact = stretch * (LENGTH - (END - START) / 2)
    tree = sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, 1, problem.zones, beside=beside), STRIP)
    state, end = sk.solve_linear(problem.on(tree, "full")), sk.Displacement((LENGTH, WIDTH / 2), (1.0, 0.0, 0.0))
    seen = sk.goal_estimate(state, end)
    return exact / seen.value - 1, seen.error / seen.value, seen.bar / seen.value


def adapted() -> sk.AdaptiveResult:
    """The same, until the error bar is below a thousandth."""
    problem = strip([sk.EdgeLoad("right", (YOUNG * THIN * 1e-5, 0.0, 0.0))])
    return sk.adapt(problem, sk.Displacement((LENGTH, WIDTH / 2), (1.0, 0.0, 0.0)), rtol=1e-3, theory="full")


# %%
# Pictures
# --------


def draw_stress(axes: plt.Axes, state: sk.Solution) -> None:
    """Stress at the top face along the strip, that of the beam in black."""
    points = np.array([[0.02, 0.98, 0.02, 0.98], [0.02, 0.02, 0.98, 0.98]])
    x = state.system.geometry.parameters(points)[0]
    order = np.argsort(x.ravel())
    top = state.stresses(points, "top")[:, :, 0]
    axes.plot(x.ravel()[order], top.ravel()[order] / 1e6, color="#D55E00", lw=2.5, label="skancf, z='top'")
    fine = np.linspace(0, LENGTH, 500)
    half = np.where((fine > START) & (fine < END), THIN, THIN / 2)
    axes.plot(fine, -FORCE * (LENGTH - fine) * 12 / (WIDTH * 8 * half**3) * half / 1e6, "k--", lw=1, label="beam")
    axes.set(xlabel="x (m)", ylabel="stress at the top face (MPa)", title="The stress falls to a quarter in the doubler")
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


# %%
# The run
# -------
# The numbers to hit: the deflection of the beam to 1e-9, as cubics are exact; a sheet that gives way by less than two thirds
# with a doubler, and has less than half of the stress; in stretching an error that halves with the elements and that the
# estimate tells to a tenth, and a twentieth of it with thin rows.


def main(size: str = "full", out: str = "out") -> dict[str, float]:
    """Print deflections and errors, save pictures; returns the deflections of the sheets."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    state, beam = bent()
    w = float(state.displacement((LENGTH, WIDTH / 2))[2])
    print(f"strip: {1e3 * w:.6f} mm, stepped beam {1e3 * beam:.6f} mm")
    assert abs(w / beam - 1) < 1e-9

    print("\nelements   error    estimate    bar     (theory full, stretched)")
    errors = []
    for n in (10, 20, 40):
        errors.append(pulled(n))
        print(f"{n:8d}  " + "  ".join(f"{value:8.1e}" for value in errors[-1]))
    values = np.array(errors)
    assert np.allclose(values[:-1, 0] / values[1:, 0], 2.0, rtol=0.25), values
    assert np.allclose(values[:, 1] / values[:, 0], 1.0, atol=0.12) and (values[:, 2] > values[:, 0]).all(), values
    thin = pulled(10, beside=THIN / 2)
    print("10, rows  " + "  ".join(f"{value:8.1e}" for value in thin))
    assert thin[0] < values[0, 0] / 20 and thin[2] > thin[0], thin
    found = adapted()
    print(found)
    assert found.ok and abs(found.value / (1e-5 * (LENGTH - (END - START) / 2)) - 1) < 1e-3

    bonded = sk.Zone("doubler", PATCH, thickness=2e-3, offset=0.5e-3)
    sheets = {"plain": sheet(()), "with a doubler": sheet((bonded,))}
    deflections = {name: float(each.displacement((0.2, 0.15))[2]) for name, each in sheets.items()}
    corners = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])  # of each element: nodes have the mean of both sides
    stresses = {name: max(np.abs(each.stresses(corners, z)[:, :, 0]).max() for z in ("top", "bottom"))
                for name, each in sheets.items()}  # fmt: skip
    for name, value in deflections.items():
        print(f"sheet, {name}: {1e3 * value:.3f} mm, largest stress S11 at the faces {stresses[name] / 1e6:.1f} MPa")
    assert 0.3 < deflections["with a doubler"] / deflections["plain"] < 2 / 3, deflections
    assert stresses["with a doubler"] < 0.5 * stresses["plain"], stresses

    chart, axes = plt.subplots(figsize=(8, 5), layout="constrained")
    draw_stress(axes, state)
    chart.savefig(folder / "doubler_stress.png", dpi=120)
    output.picture(sheets["with a doubler"], folder / "doubler_sheet.png", field="thickness", scale=50.0)
    output.picture(sheets["with a doubler"], folder / "doubler_mises.png", field="mises", scale=50.0)
    output.picture(found.solution, folder / "doubler_mesh.png", field="thickness", view=(0.0, -0.4, 1.0),
                   title="Pulled: the mesh is fine where the stiffness jumps")  # fmt: skip
    return deflections


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A plate with a doubler")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
