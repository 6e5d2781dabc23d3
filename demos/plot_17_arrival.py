r"""
Films, struts and airbags
=========================

.. image:: /pictures/gallery/17_arrival.jpg
   :alt: A square airbag, blown up, with wrinkles at its edges.
   :class: example-picture

Three structures that a linear answer knows nothing of. A **film**, held all round, is a million times stiffer once it has
moved by a few thicknesses: its deflection first grows with the load, then with its cube root,

.. math:: \frac{w}{h} = 0.2865\, Q^{1/3}, \qquad Q = \frac{q a^4}{E h^4} \to \infty,

on a square with :math:`\nu = 0.3` (by Ritz's method for von Karman's plate at Q = 10^6, see the tests). A **strut** under
more than Euler's load has a straight equilibrium that it does not keep. An **airbag**, two slack sheets joined at their
edges, has no stiffness at all until it is stretched and wrinkled.

``sk.solve`` tries the whole load, then shorter load steps. Where these end, or where their answer is not stable, the
structure is held at the full load by a pretension, which is then released: its energy falls until it rests. No option is
set below.

This example shows statics that arrives by itself where Newton's method alone does not, and what it says it met. It
builds on the roof that snaps through.
"""

import argparse
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipk

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/17_arrival.jpg"

# %%
# A film over ten decades of load
# -------------------------------
A, H, YOUNG = 1.0, 1e-4, 3e9


def film(Q: float, n: int, theory: str) -> sk.StaticResult:
    """A square of PET, 0.1 mm thick, pinned all round."""
    pressure = Q * YOUNG * H**4 / A**4
    problem = sk.Problem(
        sk.Rectangle(A, A), H, sk.Isotropic(YOUNG, 0.3, 1400.0), [sk.Pin("boundary")],
        [sk.SurfaceLoad((0.0, 0.0, pressure))],
    )  # fmt: skip
    return sk.solve(problem.on(sk.meshes.uniform(problem.surface, n, n), theory))


# %%
# A strut beyond Euler's load
# ---------------------------
# Deflection of the free end of the elastica: :math:`P / P_{cr} = (2 K(k) / \pi)^2,\; w / L = 2 k / K(k)`.
L, B, T = 1.2, 0.08, 0.004
EULER = np.pi**2 * 70e9 * T**3 / 12 / (4 * L**2)


def strut(factor: float, n: int) -> sk.StaticResult:
    """Straight and without imperfection, clamped at one end, under a dead load."""
    problem = sk.Problem(
        sk.Rectangle(L, B), T, sk.Isotropic(70e9, 0.0, 2700.0), [sk.Clamp("left")],
        [sk.EdgeLoad("right", (-factor * EULER, 0.0, 0.0))],
    )  # fmt: skip
    return sk.solve(problem.on(sk.meshes.uniform(problem.surface, n, 1), "kirchhoff"))


def elastica(factor: float) -> float:
    """w / L of the end."""
    if factor <= 1:
        return 0.0
    k = brentq(lambda k: (2 * ellipk(k**2) / np.pi) ** 2 - factor, 1e-9, 1 - 1e-14)
    return float(2 * k / ellipk(k**2))


# %%
# An airbag
# ---------
# A quarter of one of two square sheets, 1.2 m across the corners, 5 kPa; publications agree on about 0.21 m in the middle,
# with wrinkles that no mesh here resolves.


def airbag(n: int) -> sk.StaticResult:
    """Along the edges where the sheets are joined nothing moves out of the plane between them."""
    surface = sk.Rectangle(0.6 / np.sqrt(2), 0.6 / np.sqrt(2))
    problem = sk.Problem(
        surface, 6e-4, sk.Isotropic(588e6, 0.4, 1000.0),
        [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Roller(["right", "top"])], [sk.FollowerPressure(5e3)],
    )  # fmt: skip
    return sk.solve(problem.on(sk.meshes.uniform(surface, n, n), "kirchhoff"))


# %%
# Pictures
# --------


def chart_film(axes: plt.Axes, loads: np.ndarray, found: dict[str, np.ndarray]) -> None:
    """Deflection over thickness against the load, both in decades."""
    marks = {"kirchhoff": {"marker": "o", "mfc": "none", "color": "#0072B2"}, "full": {"marker": "x", "color": "#D55E00"}}
    for theory, w in found.items():
        axes.loglog(loads, w, ls="", label=f"theory '{theory}'", **marks[theory])
    axes.loglog(loads, 0.2865 * np.cbrt(loads), "k-", lw=1, label="membrane, $0.2865\\,Q^{1/3}$")
    axes.loglog(loads, 0.0444 * loads, "k--", lw=1, label="small deflections, $0.0444\\,Q$")
    axes.set(xlabel="load $Q = q a^4 / (E h^4)$", ylabel="deflection over thickness, $w / h$", ylim=(1e-3, 1e4))
    axes.set_title("A film, held all round")
    axes.legend()


def chart_strut(axes: plt.Axes, factors: np.ndarray, found: np.ndarray) -> None:
    """Deflection of the end against the load."""
    fine = np.linspace(0.8, factors.max(), 400)
    axes.plot(fine, [elastica(factor) for factor in fine], "k-", lw=1, label="elastica")
    axes.plot(fine[fine > 1], 0 * fine[fine > 1], "k:", lw=1, label="straight, not stable")
    axes.plot(factors, found, "o", mfc="none", color="#0072B2", label="each from the straight strut")
    axes.set(xlabel="load over Euler's", ylabel="deflection of the end over length")
    axes.set_title("A strut without imperfection")
    axes.legend()


def draw_airbag(axes: plt.Axes, state: sk.Solution) -> None:
    """The whole upper sheet, by symmetry."""
    sheet = output.sample(state, 4)
    heights = sheet.points[:, 2]
    for x, y in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        cells = (sheet.points * (x, y, 1))[sheet.cells]
        colours = plt.colormaps["viridis"](cells[:, :, 2].mean(axis=1) / heights.max())
        output.draw_cells(axes, cells if x * y > 0 else cells[:, ::-1], colours, light=(0.5, -0.4, 0.75))
    axes.set(xlim=(-0.42, 0.42), ylim=(-0.42, 0.42), zlim=(0, 0.25))
    axes.set_box_aspect((0.84, 0.84, 0.25), zoom=1.1)
    axes.view_init(elev=32, azim=-60)
    axes.set_axis_off()
    axes.set_title("An airbag, one of its sheets")


# %%
# The run
# -------
# The numbers to hit: the membrane's constant to 0.5 % over the last four decades in both theories, the elastica to 2e-4 of
# the length; every answer stable, and in balance to a millionth of the load or to the rounding that it names: a film so
# thin, under next to no load, moves by less than its coordinates can hold to that accuracy.


def main(size: str = "full", out: str = "out") -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Solve all, print a table, save the picture; returns deflections of film and strut."""
    full = size == "full"
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    loads, factors = np.logspace(-1, 10, 12), np.array([0.9, 1.02, 1.1, 1.25, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0])
    films = {theory: [film(Q, 8, theory) for Q in loads] for theory in ("kirchhoff", "full")}
    struts, bag = [strut(factor, 16) for factor in factors], airbag(12 if full else 6)
    for name, one in (("film, Q = 1e8", films["kirchhoff"][9]), ("strut, 1.5 P_cr", struts[4]), ("airbag", bag)):
        print(f"{name:<16} {one.iterations:>4} iterations, {one.message.split(',')[0]}")
    for one in [*films["kirchhoff"], *films["full"], *struts, bag]:
        assert one.negative_pivots == 0 and all(check.passed for check in one.checks)
    held = [Q for Q, one in zip(loads, films["kirchhoff"], strict=True) if one.status.name == "CONVERGED"]
    print(f"film: converged from Q = {held[0]:g} on; below, rounding leaves more than 1e-6 of the load open, and it says so")
    assert held[0] <= 1e3 and all(one.status.name == "CONVERGED" for one in [*struts, bag])

    film_w = {
        name: np.array([one.solution.displacement((A / 2, A / 2))[2] / H for one in row]) for name, row in films.items()
    }
    strut_w = np.array([abs(one.solution.displacement((L, B / 2))[2]) / L for one in struts])
    for w in film_w.values():
        constant = w[-4:] / np.cbrt(loads[-4:])
        print(f"membrane's constant over the last four decades: {constant.min():.4f} to {constant.max():.4f}")
        assert np.abs(constant / 0.2865 - 1).max() < 5e-3
    error = np.abs(strut_w - [elastica(factor) for factor in factors]).max()
    height = float(bag.solution.displacement((0.0, 0.0))[2])
    print(f"largest distance from the elastica: {error:.1e} of the length; airbag {height:.3f} m high")
    assert error < 2e-4 and 0.18 < height < 0.23

    figure = plt.figure(figsize=(14, 4.8), layout="constrained")
    chart_film(figure.add_subplot(1, 3, 1), loads, film_w)
    chart_strut(figure.add_subplot(1, 3, 2), factors, strut_w)
    draw_airbag(figure.add_subplot(1, 3, 3, projection="3d"), bag.solution)
    figure.savefig(folder / "arrival.png", dpi=120)
    return film_w, strut_w


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="Films, struts and airbags")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for the picture")
    return vars(parser.parse_args())


if __name__ == "__main__":
    main(**arguments())

# %%
# What to try next
# ----------------
# * ``sk.solve(..., relax=False)`` stops where load steps do: look at its ``status`` and ``message``.
# * Push the strut with 10 and with 25 times Euler's load: the first state found has one, then two half waves more, none of
#   them stable, and all end in the same place.
# * Give the film an opening in the middle, or let one of its edges go.
