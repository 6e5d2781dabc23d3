r"""
How square plates vibrate, and how they buckle
==============================================

.. image:: /pictures/gallery/08_plate_modes.jpg
   :alt: A vibration mode of a free square plate.
   :class: example-picture

E. F. F. Chladni strewed sand on plates and stroked them with a bow (*Entdeckungen über die Theorie des Klanges*, Leipzig
1787). The sand gathers where the plate is at rest, along the nodal lines of a mode. Here are the modes of square plates that
are free, clamped, or held at their corners. Their frequencies :math:`\omega` depend on one number each,

.. math:: \hat\omega = \omega\, a^2 \sqrt{\rho h / D}, \qquad D = \frac{E h^3}{12 (1 - \nu^2)} .

The values to compare with are for :math:`\nu = 0.3` and come from Ritz' method with polynomials of degree 20. Those of the
free plate are the NAFEMS benchmark FV12 (1.622, 2.360, 2.922 and 4.190 Hz for the plate below); for a survey see A. W.
Leissa, The free vibration of rectangular plates, *Journal of Sound and Vibration* 31 (1973), 257-293.

In the second part a supported plate is pulled and pushed in its plane. With the line load N, tension positive, across the
edges x = 0 and x = a, the mode with m and n half waves along x and y has

.. math:: \rho h\, \omega^2 = D \left[\frac{\pi^2}{a^2} (m^2 + n^2)\right]^2 + N \left(\frac{m \pi}{a}\right)^2 ,

a straight line in N. Where it meets zero the plate buckles, first at :math:`N = -4 \pi^2 D / a^2` (S. P. Timoshenko and
J. M. Gere, *Theory of Elastic Stability*, 2nd ed., 1961, article 9.2).

This example shows frequencies and modes, prestress, linear buckling. It builds on the roof that snaps through.
"""

# %%
# The plate
# ---------
import argparse
import os
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/08_plate_modes.jpg"

SIDE, THICKNESS, YOUNG, POISSON, DENSITY = 10.0, 0.05, 200e9, 0.3, 8000.0
BENDING = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
UNIT = np.sqrt(BENDING / (DENSITY * THICKNESS)) / SIDE**2  # of omega, 1/s
SURFACE = sk.Rectangle(SIDE, SIDE)
SUPPORTS: dict[str, list[Any]] = {"free": [], "clamped": [sk.Clamp("boundary")], "held at the corners": [sk.Pin("corners")]}
CONVERGED = {
    "free": (13.46820, 19.59614, 24.27020, 34.80089, 34.80089),
    "clamped": (35.98519, 73.39385, 73.39385, 108.2165, 131.5808),
    "held at the corners": (7.11088, 15.77024, 15.77024, 19.59614, 38.43154),
}


def plate(n: int, supports: list, loads: tuple = ()) -> Any:
    """The plate on n x n elements of the thin theory."""
    material = sk.Isotropic(YOUNG, POISSON, DENSITY)
    return sk.Problem(SURFACE, THICKNESS, material, supports, loads).on(sk.meshes.uniform(SURFACE, n, n), "kirchhoff")


# %%
# Frequencies
# -----------
# A free plate has six rigid motions, which ``modes`` finds, counts and puts first.


def first_modes(n: int) -> dict[str, tuple[sk.statics.Modes, int]]:
    """Modes of the three plates, with the number of the first that is not rigid; prints the table."""
    found = {}
    print("plate                 mode        Hz   omega a^2 sqrt(rho h / D)  converged   error")
    for name, supports in SUPPORTS.items():
        rigid = 0 if supports else 6
        modes = sk.modes(plate(n, supports), rigid + 5)
        assert modes.n_rigid == rigid and not modes.n_unstable, (name, modes.eigenvalues)
        found[name] = modes, rigid
        for k, (value, exact) in enumerate(zip(modes.omega[rigid:] / UNIT, CONVERGED[name], strict=True)):
            print(f"{name:<20}  {k + 1:4d}  {modes.frequencies[rigid + k]:8.4f}   {value:24.5f}  {exact:9.5f}  "
                  f"{value / exact - 1:6.0e}")  # fmt: skip
    return found


# %%
# Nodal lines
# -----------
# Two modes with the same frequency may be mixed at will, and a computation returns any mixture. We take the two that a
# reflection at the middle keeps, but for their sign.


def heights(modes: sk.statics.Modes, i: int, cells: int) -> np.ndarray:
    """Deflection of a mode on a regular grid, ``cells`` to an element's side; first axis y."""
    surface = output.sample(modes.shape(i, size=1.0), cells)
    elements = int(np.sqrt(len(surface.rims)))
    column, row = np.rint((surface.points - surface.displacement)[:, :2].T / SIDE * cells * elements).astype(int)
    grid = np.zeros((cells * elements + 1, cells * elements + 1))
    grid[row, column] = surface.displacement[:, 2]
    return grid


def separated(first: np.ndarray, second: np.ndarray) -> list[np.ndarray]:
    """Two deflections of one frequency, mixed so that each is even or odd in x."""
    basis, _ = np.linalg.qr(np.stack([first.ravel(), second.ravel()], axis=1))
    mirrored = np.stack([column.reshape(first.shape)[:, ::-1].ravel() for column in basis.T], axis=1)
    _, mix = np.linalg.eigh(basis.T @ mirrored)
    return [column.reshape(first.shape) for column in (basis @ mix).T]


def shapes_of(modes: sk.statics.Modes, first: int, cells: int) -> list[np.ndarray]:
    """The five modes after the rigid ones on a grid, pairs of one frequency separated."""
    shapes = [heights(modes, first + k, cells) for k in range(5)]
    omega = modes.omega[first:]
    for k in range(4):
        if abs(omega[k + 1] / omega[k] - 1) < 1e-6:
            shapes[k : k + 2] = separated(*shapes[k : k + 2])
    return shapes


# %%
# Prestress
# ---------
# ``modes(system, state=...)`` takes the tangent of a state of equilibrium, with its stresses. ``buckling`` gives the load
# factors at which the linear answer's stresses make that tangent singular. The load is that of the first buckling: load
# factor 1 is :math:`N = -4 \pi^2 D / a^2`, negative ones are tension.
HALF_WAVES = ((1, 1), (2, 1), (1, 2))
CRITICAL = 4 * np.pi**2 * BENDING / SIDE**2


def compressed(n: int) -> Any:
    """The supported plate whose edges may move in its plane; three coordinates are held against rigid motions."""
    held = [
        sk.Roller("boundary", kind="hard"),
        sk.Prescribed((SIDE / 2, SIDE / 2), (0.0, 0.0, None)),
        sk.Prescribed((SIDE, SIDE / 2), (None, 0.0, None)),
    ]
    return plate(n, held, (sk.EdgeLoad("left", (CRITICAL, 0, 0)), sk.EdgeLoad("right", (-CRITICAL, 0, 0))))


def lines(factors: np.ndarray) -> np.ndarray:
    """omega^2 over that of the first mode without load, for the three pairs of half waves: (3, n)."""
    return np.array([((m**2 + n**2) ** 2 - 4 * factors * m**2) / 4 for m, n in HALF_WAVES])


def prestressed(system: Any, factors: np.ndarray) -> np.ndarray:
    """The three lowest omega^2 over that of the first mode without load, (n, 3)."""
    first = (2 * np.pi**2 * UNIT) ** 2
    states = [sk.solve(system, load_factor=factor, relax=False).solution for factor in factors]
    return np.array([sk.modes(system, 3, state=state).eigenvalues for state in states]) / first


# %%
# Pictures
# --------


def draw_modes(figure: plt.Figure, found: dict[str, tuple[sk.statics.Modes, int]], cells: int) -> None:
    """A row of plates for each support, sand on the nodal lines."""
    grid = figure.subplots(3, 5)
    for row, (name, (modes, first)) in zip(grid, found.items(), strict=True):
        for k, (axes, w) in enumerate(zip(row, shapes_of(modes, first, cells), strict=True)):
            x = np.linspace(0, 1, len(w))[1:-1]  # supported edges are at rest as a whole
            axes.imshow(w / np.abs(w).max(), origin="lower", extent=(0, 1, 0, 1), cmap="RdBu_r", vmin=-1.3, vmax=1.3,
                        interpolation="bilinear")  # fmt: skip
            if np.ptp(w) > 1.01 * np.abs(w).max():  # else rounding near clamped corners would be drawn
                axes.contour(x, x, w[1:-1, 1:-1], levels=[0.0], colors="#202020", linewidths=2)
            axes.set(xticks=[], yticks=[], title=f"{modes.omega[first + k] / UNIT:.3f}")
        row[0].set_ylabel(name, fontsize=12)


def draw_lines(axes: plt.Axes, factors: np.ndarray, values: np.ndarray, critical: np.ndarray) -> None:
    """omega^2 against the load factor."""
    fine = np.linspace(factors[0], 1.7, 50)
    for (m, n), line, colour in zip(HALF_WAVES, lines(fine), ("#0072B2", "#D55E00", "#009E73"), strict=True):
        axes.plot(fine, line, color=colour, lw=1.5, label=f"formula, {m} x {n} half waves")
    for k in range(3):
        axes.plot(factors, values[:, k], "o", color="#303030", ms=5, label=None if k else "modes(system, state=...)")
    axes.plot(critical, 0 * critical, "D", color="#CC79A7", ms=9, zorder=4, label="buckling(system)")
    axes.axhline(0, color="k", lw=0.8)
    axes.set(title="Supported plate, loaded in its plane", xlabel="load factor (1: first buckling load; negative: tension)",
             ylabel=r"$\omega^2$ / $\omega_1^2$ without load", xlim=(factors[0] - 0.05, 1.7), ylim=(-1, 11))  # fmt: skip
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


# %%
# The run
# -------
# The numbers to hit, on 16 x 16 elements: the frequencies of the free plate and of that held at its corners to 5e-5, those
# of the clamped one, whose shapes bend most at the edges, to 2e-4; buckling at the load factors 1 and 25/16 to 5e-5; and
# the lines of the prestressed plate to 1e-3 of :math:`\omega_1^2`. Its straight lines leave out what the load does to the
# size of the plate, a strain of 1e-4. Beyond the buckling load the flat state still is an equilibrium, and ``modes`` says
# that it is not stable: its first :math:`\omega^2` is negative.


def main(size: str = "full", out: str = "out") -> dict[str, np.ndarray]:
    """Print frequencies and load factors, save pictures; returns the frequencies of each plate."""
    n, rough, rough_clamped = (16, 5e-5, 2e-4) if size == "full" else (8, 5e-4, 3e-3)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    found = first_modes(n)
    system = compressed(n)
    buckled = sk.buckling(system, 2)
    print(f"\nbuckling at the load factors {buckled.load_factors}; exact: 1 and 25/16 = 1.5625")
    factors = np.linspace(-1.0, 1.4, 13 if size == "full" else 5)
    values = prestressed(system, factors)
    exact = np.sort(lines(factors), axis=0).T
    print("\nload factor   omega^2 / omega_1^2 of three modes      largest difference from the formula")
    for factor, row, off in zip(factors, values, np.abs(values - exact).max(axis=1), strict=True):
        print(f"{factor:11.2f}   {row[0]:10.5f} {row[1]:10.5f} {row[2]:10.5f}      {off:.0e}")

    sheet = plt.figure(figsize=(12, 8), layout="constrained")
    draw_modes(sheet, found, 96 // n)
    sheet.suptitle(r"Modes of square plates, $\omega\, a^2 \sqrt{\rho h / D}$; black: nodal lines", fontsize=14)
    sheet.savefig(folder / "plate_modes.png", dpi=120)
    chart, axes = plt.subplots(figsize=(8, 5.5), layout="constrained")
    draw_lines(axes, factors, values, buckled.load_factors)
    chart.savefig(folder / "plate_prestress.png", dpi=120)

    frequencies = {name: modes.omega[first:] / UNIT for name, (modes, first) in found.items()}
    for name, omega in frequencies.items():
        assert np.allclose(omega, CONVERGED[name], rtol=rough_clamped if name == "clamped" else rough), (name, omega)
    assert np.allclose(buckled.load_factors, [1.0, 25 / 16], rtol=rough), buckled.load_factors
    assert np.abs(values - exact).max() < (1e-3 if size == "full" else 3e-3), np.abs(values - exact).max()
    assert (values[factors > 1.001, 0] < 0).all() and (values[factors < 0.999] > 0).all()
    return frequencies


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="How square plates vibrate, and how they buckle")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
