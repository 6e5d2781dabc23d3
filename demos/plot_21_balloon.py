r"""
A balloon past its limit point
==============================

.. image:: /pictures/gallery/21_balloon.jpg
   :alt: A round rubber balloon.
   :class: example-picture

Blowing up a balloon is hard at first, and then it is easy: the pressure has a maximum. Of an incompressible sphere of radius
R and thickness t that is stretched by :math:`\lambda`, with Ogden's energy
:math:`\psi = \sum_p \tfrac{\mu_p}{\alpha_p} (\lambda_1^{\alpha_p} + \lambda_2^{\alpha_p} + \lambda_3^{\alpha_p} - 3)`,

.. math:: p = \frac{2 t}{R} \sum_p \mu_p \bigl( \lambda^{\alpha_p - 3} - \lambda^{-2 \alpha_p - 3} \bigr) .

The neo-Hookean law has one term with the exponent 2, Mooney's and Rivlin's the exponents 2 and -2, and Ogden's own three
terms fit rubber up to seven times its length. R = 10 m, t = 0.1 m, as in J. Kiendl, M.-C. Hsu, M. C. H. Wu and A. Reali
(2015), Isogeometric Kirchhoff-Love shell formulations for general hyperelastic materials, *Computer Methods in Applied
Mechanics and Engineering* 291, 280-303.

This example shows laws of rubber at points through the thickness, equilibrium paths of a pressure that follows the
surface, and how thin a balloon becomes. It builds on the roof that snaps through.
"""

# %%
# Three laws
# ----------
# All have the shear modulus :math:`\mu = 4.225 \cdot 10^5` Pa at small strain.
import argparse
import os
from math import pi
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/21_balloon.jpg"

RADIUS, THICKNESS, MU, DENSITY = 10.0, 0.1, 4.225e5, 1000.0
OGDEN = [(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)]
MOONEY = [(7 / 8 * MU, 2.0), (-MU / 8, -2.0)]
LAWS = {
    "neo-Hooke": (sk.NeoHooke(MU, DENSITY), [(MU, 2.0)], 5236.73, 1.38309),
    "Mooney-Rivlin": (sk.MooneyRivlin(7 / 16 * MU, MU / 16, DENSITY), MOONEY, 5945.96, 1.53519),
    "Ogden": (sk.Ogden(OGDEN, DENSITY), OGDEN, 5494.12, 1.37405),
}
COLOURS = {"neo-Hooke": "#0072B2", "Mooney-Rivlin": "#009E73", "Ogden": "#D55E00"}

# %%
# An eighth of a balloon
# ----------------------
# Three planes of symmetry, a pole on top, and the pressure inside, which follows the surface as it grows. The path by its
# length goes through the maximum of the pressure, where the tangent becomes singular; beyond it the sphere is an equilibrium
# that only a given volume of air can hold, so one eigenvalue is negative.
PRESSURE, AT = 5000.0, (pi / 2, pi / 4)
SURFACE = sk.SphereSector(RADIUS, (0.0, pi / 2), pi / 2)


def inflate(law: Any, n: int, to: float) -> sk.PathResult:
    """The path until the equator is stretched to ``to``."""
    supports = [sk.Symmetry(["start", "end", "bottom"])]
    problem = sk.Problem(SURFACE, THICKNESS, law, supports, [sk.FollowerPressure(PRESSURE)])
    system = problem.on(sk.meshes.uniform(SURFACE, n, n), "kirchhoff")
    end = sk.DisplacementReached(AT, (1.0, 1.0, 0.0), (to - 1) * RADIUS)
    return sk.trace(system, sk.ArcLength(first=0.1, steps=sk.StepLength(growth=1.2)), until=end).unwrap()


def stretch(state: sk.Solution) -> float:
    """Mean of the radius, over the undeformed one."""
    points = [(x, y) for x in np.linspace(0.2, 1.0, 4) * pi / 2 for y in np.linspace(0.0, pi / 2, 4)]
    return float(np.linalg.norm(state.position(points), axis=1).mean()) / RADIUS


def pressure(state: sk.Solution) -> float:
    return PRESSURE * state.load_factor


def exact(terms: list[tuple[float, float]], stretches: np.ndarray) -> np.ndarray:
    """Pressure of the membrane."""
    sums = sum(mu * (stretches ** (alpha - 3) - stretches ** (-2 * alpha - 3)) for mu, alpha in terms)
    return np.asarray(2 * THICKNESS / RADIUS * sums)


# %%
# Pictures
# --------
VIEW = pi / 4


def draw_paths(axes: plt.Axes, paths: dict[str, sk.PathResult]) -> None:
    """Pressure against stretch, and the maxima."""
    fine = np.linspace(1.0, 3.0, 300)
    for name, path in paths.items():
        axes.plot(fine, exact(LAWS[name][1], fine), color=COLOURS[name], lw=1.5, label=f"{name}, exact membrane")
        axes.plot([stretch(s) for s in path.solutions], [pressure(s) for s in path.solutions], "o", mfc="none", ms=5,
                  color=COLOURS[name])  # fmt: skip
        top = path.events[0].solution
        axes.plot(stretch(top), pressure(top), "^", color=COLOURS[name], ms=8)
    axes.plot([], [], "o", mfc="none", color="#505050", label="path on the mesh")
    axes.plot([], [], "^", color="#505050", ms=8, label="limit point")
    axes.set(xlabel="radius over undeformed radius", ylabel="pressure (Pa)", xlim=(1, 3), ylim=(0, 6300))
    axes.legend(frameon=False, loc="lower right")
    axes.grid(color="#e0e0e0")


def draw_balloon(axes: plt.Axes, states: list[sk.Solution]) -> None:
    """The eighth in some states, side by side, coloured by how thin it is."""
    side, aside = np.array([-np.sin(VIEW), np.cos(VIEW), 0.0]), 0.0
    for state in states:
        surface, thin = output.sample(state, 3), state.thickness_stretch(np.array([[0.5], [0.5]]), "middle")[:, 0]
        width = 1.5 * RADIUS * stretch(state)
        cells = surface.points[surface.cells] + (aside + 0.5 * width) * side
        aside += width
        share = np.repeat(thin, len(cells) // len(thin))
        output.draw_cells(axes, cells, plt.colormaps["viridis"](share), light=(0.9, 0.35, 0.72))
    middle = 0.5 * aside * side
    axes.set(xlim=middle[0] + [-20, 30], ylim=middle[1] + [-20, 30], zlim=(-15, 35))
    axes.set_box_aspect((1, 1, 1), zoom=1.45)
    axes.view_init(elev=22, azim=np.degrees(VIEW))
    axes.set_title("at rest, at the limit point, and at twice the radius", y=0.93, fontsize=11)
    bar = plt.colorbar(plt.cm.ScalarMappable(cmap="viridis"), ax=axes, location="bottom", shrink=0.5, pad=0.0)
    bar.set_label("thickness over undeformed thickness")


# %%
# The run
# -------
# The numbers to hit: the maximum of each law to a tenth of a per mille, its place, and the pressure at three times the
# radius to a per mille. Mooney-Rivlin rubber has a minimum of the pressure, too, beyond which the balloon is stable again.
# The shell is not a membrane, and the pressure acts on its middle surface; both count with the square of the thickness over
# the radius, which is a ten-thousandth here, and less the more it is blown up.


def main(size: str = "full", out: str = "out") -> dict[str, sk.PathResult]:
    """Follow the three paths, print a table, save a picture; returns the paths."""
    n = 6 if size == "full" else 4
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    paths = {name: inflate(law, n, 3.0) for name, (law, *_) in LAWS.items()}
    print("law             maximum (Pa)      exact   at stretch    exact   p(3) (Pa)    exact   iterations a step")
    for name, (_, terms, most, at) in LAWS.items():
        path = paths[name]
        top = path.events[0]
        end, effort = path.solution, path.iterations / (len(path.solutions) - 1)
        last = float(exact(terms, np.array(3.0)))
        print(f"{name:<15} {pressure(top.solution):12.2f} {most:10.2f} {stretch(top.solution):12.5f} {at:8.5f} "
              f"{pressure(end):11.2f} {last:8.2f} {effort:12.1f}")  # fmt: skip
        assert all(event.kind == "limit point" for event in path.events) and path.negative_pivots.max() == 1
        assert len(path.events) == (2 if name == "Mooney-Rivlin" else 1)
        assert np.isclose(pressure(top.solution), most, rtol=1e-4), (name, pressure(top.solution))
        assert np.isclose(stretch(top.solution), at, rtol=1e-3), (name, stretch(top.solution))
        assert np.isclose(pressure(end), last, rtol=1e-3), (name, pressure(end))
        assert effort < 5, (name, effort)
    path = paths["neo-Hooke"]
    twice = min(path.solutions, key=lambda state: abs(stretch(state) - 2.0))
    thin = float(twice.thickness_stretch(np.array([[0.5], [0.5]]), "middle").mean())
    print(f"\nAt a stretch of {stretch(twice):.3f} it has {thin:.4f} of its thickness, a sphere {stretch(twice) ** -2:.4f}")
    assert np.isclose(thin, stretch(twice) ** -2, rtol=2e-3)

    figure = plt.figure(figsize=(14, 5.2), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=[1, 1.15])
    draw_paths(figure.add_subplot(grid[0]), paths)
    draw_balloon(figure.add_subplot(grid[1], projection="3d"), [path.solutions[0], path.events[0].solution, twice])
    figure.savefig(folder / "balloon.png", dpi=120)
    return paths


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A balloon past its limit point")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
