r"""
The elastica: a strip bent by a force at its end
================================================

.. image:: /pictures/gallery/02_elastica.jpg
   :alt: A strip, clamped at one end, at growing loads at its other end.
   :class: example-picture

A straight cantilever of length :math:`L` is loaded at its free end by a force :math:`P` that stays normal to the
*undeformed* strip. An inextensible strip without shear strain obeys

.. math:: EI\,\varphi''(s) = -P \cos\varphi(s), \qquad \varphi(0) = 0, \qquad \varphi'(L) = 0,

with :math:`\varphi` the angle of its tangent. Its solution in elliptic integrals is as old as 1945 (Bisshopp and Drucker,
*Quarterly of Applied Mathematics* 3, 272-275) and depends on the one number :math:`\alpha^2 = P L^2 / EI`. We bend the
strip up to :math:`\alpha^2 = 10`, where its end points to within eight degrees of the direction of the force.

This example shows large rotations in one load step, a comparison with exact numbers, the error against the number of
elements.
"""

# %%
# The exact shape
# ---------------
# Let :math:`\varphi_0` be the angle at the end, :math:`m = (1 + \sin\varphi_0) / 2` and
# :math:`\sin\theta_1 = 1 / \sqrt{2m}`. With the elliptic integrals :math:`F(\theta, m)` and :math:`E(\theta, m)` the
# condition for :math:`\varphi_0` is :math:`F(\pi/2, m) - F(\theta_1, m) = \alpha`, and the strip runs along
#
# .. math::
#    x = \frac{\sqrt2}{\alpha} \left(\sqrt{\sin\varphi_0} - \sqrt{\sin\varphi_0 - \sin\varphi}\right), \qquad
#    y = s - \frac{2}{\alpha} [E(\theta, m) - E(\theta_1, m)], \qquad
#    s = \frac{1}{\alpha} [F(\theta, m) - F(\theta_1, m)]
#
# for :math:`\theta_1 \le \theta \le \pi/2`, all in units of :math:`L`, where :math:`1 + \sin\varphi = 2 m \sin^2\theta`.

import argparse
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/02_elastica.jpg"


def exact(load: float, n: int = 101) -> tuple[np.ndarray, np.ndarray]:
    """x / L and y / L of n points of the strip under P L^2 / EI = load."""
    alpha = np.sqrt(load)

    def start(phi_0: float) -> tuple[float, float]:
        m = (1 + np.sin(phi_0)) / 2
        return m, np.arcsin(1 / np.sqrt(2 * m))

    def missing(phi_0: float) -> float:
        m, theta_1 = start(phi_0)
        return ellipkinc(np.pi / 2, m) - ellipkinc(theta_1, m) - alpha

    phi_0 = brentq(missing, 1e-9, np.pi / 2 - 1e-9, xtol=1e-14)
    m, theta_1 = start(phi_0)
    theta = np.linspace(theta_1, np.pi / 2, n)
    sine = 2 * m * np.sin(theta) ** 2 - 1
    x = np.sqrt(2) / alpha * (np.sqrt(np.sin(phi_0)) - np.sqrt(np.maximum(np.sin(phi_0) - sine, 0)))
    s = (ellipkinc(theta, m) - ellipkinc(theta_1, m)) / alpha
    return x, s - 2 / alpha * (ellipeinc(theta, m) - ellipeinc(theta_1, m))


# %%
# The strip
# ---------
# A thousand times longer than thick, so that stretch and shear, which the elastica leaves out, change its end by less
# than one part in ten thousand. With ``poisson=0`` the plate bends exactly like a beam of :math:`EI = E b h^3 / 12`.
# It is narrow, because one element across has an error of its own, which falls like the square of the width. The whole
# load comes in one step.

LENGTH, WIDTH, THICKNESS, YOUNG = 10.0, 0.2, 0.01, 1.2e6
EI = YOUNG * WIDTH * THICKNESS**3 / 12


def bend(load: float, n: int, assumed: bool = True) -> sk.statics.StaticResult:
    """Equilibrium of n elements under P L^2 / EI = load."""
    force = load * EI / LENGTH**2
    strip = sk.Problem(
        surface=sk.Rectangle(LENGTH, WIDTH),
        thickness=THICKNESS,
        material=sk.Isotropic(YOUNG, 0.0, density=1.0),
        supports=[sk.Clamp("left")],
        loads=[sk.EdgeLoad("right", (0.0, 0.0, force / WIDTH))],
    )
    return sk.solve(strip.on(sk.meshes.uniform(strip.surface, n, 1), sk.Full(assumed=assumed)))


def points_along(solution: sk.Solution, n: int = 101) -> tuple[np.ndarray, np.ndarray]:
    """x / L and y / L of n points of the middle line."""
    along = np.column_stack([np.linspace(0, LENGTH, n), np.full(n, WIDTH / 2)])
    x, _, z = solution.position(along).T / LENGTH
    return x, z


def end_error(solution: sk.Solution, load: float) -> float:
    """Distance of the strip's end from the exact one, in lengths of the strip."""
    (x, y), (x_exact, y_exact) = points_along(solution, 2), exact(load)
    return float(np.hypot(x[-1] - x_exact[-1], y[-1] - y_exact[-1]))


# %%
# Tables and charts
# -----------------


def table(loads: list[float], counts: list[int]) -> dict[str, list[float]]:
    """Errors of the strip's end for each load and number of elements; prints them as it goes."""
    columns: dict[str, list[float]] = {"P L^2/EI": [], "elements": [], "error (L)": [], "iterations": []}
    print("P L^2/EI  elements  error of the end (L)  Newton iterations, one step")
    for load in loads:
        for n in counts:
            result = bend(load, n)
            solution = result.unwrap()
            row = (load, n, end_error(solution, load), result.iterations)
            print("{:8g}  {:8d}  {:20.5f}  {:d}".format(*row))
            for column, value in zip(columns.values(), row, strict=True):
                column.append(value)
    return columns


# %%
# Pictures
# --------


def chart_of_shapes(loads: list[float], n: int) -> plt.Figure:
    """The bent strips on the exact curves."""
    figure, axes = plt.subplots(figsize=(6, 5.4), layout="constrained")
    for load in loads:
        solution = bend(load, n).unwrap()
        (line,) = axes.plot(*exact(load), lw=5, alpha=0.3)
        axes.plot(*points_along(solution), lw=1.2, color=line.get_color())
        nodes = points_along(solution, n + 1)
        axes.plot(*nodes, "o", ms=3, color=line.get_color(), label=f"{load:g}")
    axes.set(xlabel="x / L", ylabel="y / L", aspect="equal", xlim=(0, 1.02), ylim=(-0.02, 0.86),
             title=f"{n} elements (thin lines, dots: nodes) on the exact elastica (wide)")  # fmt: skip
    axes.legend(title="$P L^2 / EI$", loc="upper left", frameon=False)
    return figure


def chart_of_errors(columns: dict[str, list[float]], load: float, plain: list[float]) -> plt.Figure:
    """Error against the number of elements, with and without assumed strains."""
    here = np.array(columns["P L^2/EI"]) == load
    counts, errors = np.array(columns["elements"])[here], np.array(columns["error (L)"])[here]
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    axes.loglog(counts, errors, "o-", label="assumed strains (default)")
    axes.loglog(counts, plain, "s--", color="tab:gray", label="plain element, Full(assumed=False)")
    axes.loglog(counts, errors[0] * (counts[0] / counts) ** 2, "k:", lw=1, label="slope -2")
    axes.set(xlabel="elements along the strip", ylabel="error of the end / L", xticks=counts,
             xticklabels=[f"{n:g}" for n in counts], title=f"$P L^2 / EI = {load:g}$, thickness L / 1000")  # fmt: skip
    axes.minorticks_off()
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


# %%
# The run
# -------
# One function does it all. The command line calls it, the tests call it with ``size="small"``, and this page was made by
# it. It ends with the numbers that it must hit: the end within 0.1 % of L with 32 elements (0.3 % with 16, in the small
# run), in one load step, and an error that falls like the square of the element length.


def main(size: str = "full", out: str = "out") -> dict[str, list[float]]:
    """Bend the strip, print the table, save charts; returns the columns of the table."""
    loads, counts = ([1.0, 2.0, 5.0, 10.0], [8, 16, 32, 64]) if size == "full" else ([2.0, 10.0], [8, 16])
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    columns = table(loads, counts)
    output.save_table(folder / "elastica.csv", columns)
    plain = [end_error(bend(loads[-1], n, assumed=False).unwrap(), loads[-1]) for n in counts]
    chart_of_shapes(loads, 16).savefig(folder / "elastica_shapes.png", dpi=120)
    chart_of_errors(columns, loads[-1], plain).savefig(folder / "elastica_errors.png", dpi=120)

    errors = np.array(columns["error (L)"]).reshape(len(loads), len(counts))
    assert errors[:, counts.index(16)].max() < 3e-3, errors
    if size == "full":
        assert errors[:, counts.index(32)].max() < 1e-3, errors
    rates = np.log2(errors[:, :-1] / errors[:, 1:])
    assert rates.min() > 1.75, rates  # theory: 2
    assert plain[0] > 30 * errors[-1, 0], "the plain element should lock: the thin strip was not tested"
    return columns


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="The elastica: a strip bent by a force at its end")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for charts and table")
    return vars(parser.parse_args())


if __name__ == "__main__":
    main(**arguments())

# %%
# What to try next
# ----------------
# * Replace the force by ``sk.EdgeMoment("right", (0, -2 * np.pi * EI / LENGTH / WIDTH, 0))``: the strip rolls up into a
#   full circle. Use a thickness of 0.1 and 32 elements, and look at ``result.path``: one step is no longer enough.
# * Make the strip wide and give it a Poisson's ratio: it becomes a plate, stiffer by :math:`1 / (1 - \nu^2)`.
# * ``sk.solve(..., mixed=False)`` is the plain Newton method. Count its iterations.
