r"""
A rectangular opening: stresses without limit, and forces with one
==================================================================

.. image:: /pictures/gallery/10_opening.jpg
   :alt: A plate with a rectangular opening, coloured by stress, on a mesh that is fine at a corner of it.
   :class: example-picture

A plate 2 m by 1 m with an opening of 0.5 m by 0.5 m in its middle is pulled by N per length at its ends, or bent there by
moments M per length. Above and below the opening two ligaments carry what went through the whole width b before. By
equilibrium the means over a ligament are

.. math:: \bar N_{11} = \frac{b}{b - d}\, N = 2 N, \qquad \bar M_{11} = \frac{b}{b - d}\, M = 2 M ,

which any computation must give. What they do not tell is how the force crowds at the corners of the opening. There it has no
limit: in the distance r it grows like :math:`r^{\lambda - 1}`, with the smallest positive root of

.. math:: \sin(\tfrac32 \pi \lambda) = \begin{cases} \lambda & \text{in tension}, \\
          \frac{1 - \nu}{3 + \nu}\, \lambda & \text{in bending} \end{cases}

for 270 degrees of plate between free edges (M. L. Williams, Stress singularities resulting from various boundary conditions
in angular corners of plates in extension, *Journal of Applied Mechanics* 19 (1952), 526-528, and his paper on bending of the
same year). A finer mesh shows a larger stress, and none is right. The mean over a patch of a size that matters, of a weld or
of the thickness, is a number: it is found here to 0.1 % with its error bar, for patches that halve again and again.

This example shows ``NoLimit``, means of section forces, tension and bending side by side. It builds on the clamped
L-shape.
"""

# %%
# The plate
# ---------
# Both loads are in equilibrium, so that three supports take away the rigid motions and carry nothing.
import argparse
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/10_opening.jpg"

THICKNESS, YOUNG, POISSON = 0.01, 200e9, 0.3
SURFACE = sk.Rectangle(2.0, 1.0)
X, Y = (0.75, 1.25), (0.25, 0.75)
CORNER = (X[1], Y[1])
COARSE = sk.meshes.uniform(SURFACE, 16, 8, openings=[(X, Y)])
CELL = 0.125
LIGAMENT = (X, (Y[1], 1.0))
RTOL = 1e-3


@dataclass(frozen=True)
class Case:
    """A load of one per length, the section force that it makes, and what the exponent's equation has on its right."""

    loads: tuple
    component: str
    factor: float

    @property
    def problem(self) -> sk.Problem:
        held = [
            sk.Prescribed((0.0, 0.0), (0.0, 0.0, 0.0)),
            sk.Prescribed((0.0, 1.0), (0.0, None, 0.0)),
            sk.Prescribed((2.0, 0.0), (None, None, 0.0)),
        ]
        return sk.Problem(SURFACE, THICKNESS, sk.Isotropic(YOUNG, POISSON, density=7850.0), held, self.loads)

    @property
    def exponent(self) -> float:
        """Of the section force near a corner."""
        return brentq(lambda s: np.sin(1.5 * np.pi * s) - self.factor * s, 0.4, 0.7) - 1


CASES = {
    "tension": Case((sk.EdgeLoad("left", (-1.0, 0, 0)), sk.EdgeLoad("right", (1.0, 0, 0))), "N11", 1.0),
    "bending": Case(
        (sk.EdgeMoment("left", (0, -1.0, 0)), sk.EdgeMoment("right", (0, 1.0, 0))), "M11", (1 - POISSON) / (3 + POISSON)
    ),
}


# %%
# A number without a limit
# ------------------------
# The loop does not begin. Its message says what to ask for instead.


def refusal(case: Case) -> str:
    """What is said of the section force in the corner."""
    try:
        sk.adapt(case.problem, sk.SectionForce(case.component, at=CORNER), RTOL, mesh=COARSE, linear=True)
    except sk.NoLimit as why:
        return str(why)
    raise AssertionError("a stress without a limit was computed")


# %%
# Numbers with one
# ----------------
# The ligament, and patches of side :math:`2^{-k}` m in it, at the corner. A patch is of whole elements on every mesh: the
# first one has elements of its size there, and none are merged.


def on_ligament(case: Case) -> sk.AdaptiveResult:
    """The mean over the whole ligament."""
    return sk.adapt(case.problem, sk.SectionForce(case.component, within=LIGAMENT), RTOL, mesh=COARSE, linear=True)


def patch(side: float) -> sk.meshes.Region:
    """In the ligament at the corner."""
    return sk.meshes.Region((CORNER[0] - side / 2, CORNER[1] + side / 2), (side / 2, side / 2), ratio=2.0)


def on_patch(case: Case, side: float, **options: Any) -> sk.AdaptiveResult:
    """The mean over a patch."""
    mesh = sk.meshes.refined_in(COARSE, [patch(side)], levels=round(np.log2(CELL / side)))
    mean = sk.SectionForce(case.component, within=((CORNER[0] - side, CORNER[0]), (CORNER[1], CORNER[1] + side)))
    return sk.adapt(case.problem, mean, **{"rtol": RTOL, "mesh": mesh, "linear": True, "coarsening": sk.Never(), **options})


def growth(sides: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Exponents by which the changes from patch to patch grow; a constant part of the means plays no role."""
    return np.diff(np.log(np.abs(np.diff(means)))) / np.log(sides[1] / sides[0])


# %%
# Pictures
# --------


def draw(found: dict, sides: np.ndarray, study: dict, folder: Path) -> None:
    """Meshes, means over patches, errors and estimates, and the section forces in the plate."""
    near = found["tension"][-1]
    meshes = {"start": near.levels[0].mesh, "tension": near.levels[-1].mesh, "bending": found["bending"][-1].levels[-1].mesh}
    output.mesh_levels(
        list(meshes.values()), folder / "opening_meshes.png", surface=SURFACE,
        titles=[f"{name}, {mesh.nelements} elements" for name, mesh in meshes.items()],
    )  # fmt: skip
    curves, ratios = {}, {}
    for name, (truth, results) in study.items():
        for how, result in results.items():
            table = np.array([(level.n_dofs, truth - level.value, level.error) for level in result.levels[:-1]]).T
            curves[f"{name}, {how}"] = table[0], np.abs(table[1] / truth)
            ratios[f"{name}, {how}"] = table[0], table[2] / table[1]
    title = f"Mean over a patch of {sides[0]:g} m"
    slope = -round(1 + CASES["tension"].exponent, 4)
    output.convergence(curves, folder / "opening_errors.png", slopes=(slope, -2), title=title)
    output.effectivity(ratios, folder / "opening_estimates.png", band=(0.8, 1.25), title=title)
    figure, axes = plt.subplots(figsize=(7.0, 5.0), layout="constrained")
    for (name, results), colour, mark in zip(found.items(), ("#0072B2", "#D55E00"), "os", strict=True):
        bars = [result.error_bar for result in results]
        axes.errorbar(sides, [result.value for result in results], bars, fmt=mark + "-", color=colour, capsize=4, label=name)
    axes.axhline(2.0, color="#202020", lw=1, ls="--", label="mean over the ligament")
    axes.set(xscale="log", yscale="log", xlabel="side of the patch (m)", ylabel="mean over the patch / load at the ends",
             title="The smaller the patch, the larger the mean")  # fmt: skip
    axes.set_yticks([2, 2.5, 3, 4, 5], ["2", "2.5", "3", "4", "5"])
    axes.minorticks_off()
    axes.grid(color="#d0d0d0")
    axes.legend(frameon=False)
    figure.savefig(folder / "opening_means.png", dpi=150)
    plt.close(figure)
    state = found["tension"][-1].solution
    output.picture(
        state, folder / "opening_tension.png", field="N11", limits=(0.0, 4.0), view=(0.0, -0.01, 1.0), size=(1400, 800),
        title="Tension: N11 / N, colours end at 4",
    )  # fmt: skip
    bent = found["bending"][-1].solution
    scale = 0.25 / np.abs(bent.q - bent.system.undeformed).reshape(-1, 4, 3)[:, 0, 2].max()
    output.picture(
        bent, folder / "opening_bending.png", field="M11", limits=(0.0, 4.0), scale=scale, size=(1400, 800),
        title=f"Bending: M11 / M, colours end at 4, deflection times {scale:.2g}",
    )  # fmt: skip
    _, axes = plt.subplot_mosaic(
        [["meshes"] * 6, ["tension"] * 3 + ["bending"] * 3, ["means"] * 2 + ["errors"] * 2 + ["estimates"] * 2],
        figsize=(14, 12), layout="constrained",
    )  # fmt: skip
    for name, axis in axes.items():
        axis.imshow(plt.imread(folder / f"opening_{name}.png"))
        axis.set_axis_off()


# %%
# The run
# -------


def main(size: str = "full", out: str = "out") -> dict[str, np.ndarray]:
    """Print means with their error bars, save pictures; returns the means over the patches of both cases."""
    strict, uniform_dofs = {"full": (50, 100_000), "small": (5, 7_000)}[size]
    folder = Path(out)
    output.check_folder(folder)
    sides = 0.5 ** np.arange(3, 9)
    found = {}
    for name, case in CASES.items():
        print(f"{name}, in the corner: {refusal(case)}")
        ligament = on_ligament(case)
        print(f"{name}, mean over the ligament: {ligament}")
        assert ligament.ok and abs(ligament.value / 2 - 1) < RTOL, ligament
        found[name] = [on_patch(case, side) for side in sides]
    print(f"\n{'patch (m)':>10}{'mean of N11 / N':>26}{'mean of M11 / M':>26}")
    for side, *results in zip(sides, *found.values(), strict=True):
        print(f"{side:>10.5f}" + "".join(f"{r.value:>16.4f} +- {r.error_bar:.4f}" for r in results))
    means = {name: np.array([result.value for result in results]) for name, results in found.items()}
    for name, case in CASES.items():
        print(f"{name}: the changes grow with the exponents {np.round(growth(sides, means[name]), 3)}, "
              f"theory {case.exponent:.4f}")  # fmt: skip
    study = {}
    for name, case in CASES.items():
        both = {
            "adaptive": on_patch(case, sides[0], rtol=RTOL / strict),
            "uniform": on_patch(case, sides[0], marking=sk.AllElements(), rtol=RTOL / strict, max_dofs=uniform_dofs),
        }
        study[name] = both["adaptive"].corrected, both
        for how, result in both.items():
            print(f"\n{name}, patch of {sides[0]:g} m, {how}:\n{result.table()}\n{result}")
    draw(found, sides, study, folder)

    assert all(result.ok for results in found.values() for result in results)
    for name, (truth, both) in study.items():
        assert both["adaptive"].ok and abs(means[name][0] - truth) < 1.5 * found[name][0].error_bar, name
    for name, case in CASES.items():
        assert abs(growth(sides, means[name])[-1] - case.exponent) < 0.05, (name, growth(sides, means[name]))
    assert (means["tension"] > means["bending"]).all()
    return means


# %%
# Tension crowds more than bending: in each patch the mean is larger, and by theory it also grows faster. The exponents that
# come out of the smallest patches are near those of the corner; the largest patches see the rest of the plate too.
if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A plate with a rectangular opening")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"))
    arguments, _ = parser.parse_known_args()
    main(arguments.size, arguments.out)
