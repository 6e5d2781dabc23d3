r"""
A sandwich bends by shear
=========================

.. image:: /pictures/gallery/18_sandwich.jpg
   :alt: A sandwich plate that bends under pressure.
   :class: example-picture

Two thin, stiff faces on a thick, soft core: a sandwich is stiff and light, because the faces are far apart. What holds them
together is the core, in shear, and that is where such plates yield. The square plate of NAFEMS' benchmark R0031/3
(*Composites Benchmarks*) has a side of 10 in, hinged edges, and 100 psi on it. The middle sinks by 0.123 in, of which
bending is less than two thirds; the stress in the middle of a face is 34 449 psi along its stiff direction.

A shear strain that is constant through the thickness would give the stiff faces most of the shear stress, and the sandwich
several times its shear stiffness. Equilibrium says otherwise: stress along x grows with the moment, and the shear stress at
a height holds what is below it,

.. math:: \tau(z) = -\int_{bottom}^z \frac{\partial \sigma_{11}}{\partial x} \, dz, \qquad
    \frac{Q^2}{2 K} = \int \frac{\tau^2}{2 G} \, dz .

The second makes the shear stiffness K of the section, and skancf gives it to laminates.

This example shows the shear stiffness of laminates, what the thin theory leaves out, ``"auto"``. It builds on the
laminate that curls.
"""

# %%
# The plate
# ---------
# Inches and pounds. A quarter of the plate, with hard hinges.
import argparse
import os
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk

# sphinx_gallery_thumbnail_path = "pictures/gallery/18_sandwich.jpg"

FACE = sk.Orthotropic(young=(10e6, 4e6, 4e6), poisson=(0.3, 0.3, 0.3), shear=(1.875e6,) * 3, density=1.0)
CORE = sk.Orthotropic(young=(10.0, 10.0, 10.0), poisson=(0, 0, 0), shear=(10.0, 3e4, 1.2e4), density=1.0)
SKIN, THICK, SIDE, PRESSURE = 0.028, 0.75, 10.0, 100.0
LAYERS = [sk.Layer(FACE, SKIN), sk.Layer(CORE, THICK), sk.Layer(FACE, SKIN)]
DEFLECTION, STRESS = -0.123, 34449.0  # in, psi


def plate(theory: str, n: int) -> sk.Solution:
    """Small deflections of a quarter on n x n elements."""
    quarter = sk.Rectangle(SIDE / 2, SIDE / 2)
    problem = sk.Problem(
        surface=quarter,
        material=sk.Laminate(LAYERS),
        supports=[sk.Symmetry("left"), sk.Symmetry("bottom"), sk.SimpleSupport(["right", "top"], kind="hard")],
        loads=[sk.SurfaceLoad((0, 0, -PRESSURE))],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)  # says of the thin theory what the table below shows
        return sk.solve_linear(problem.on(sk.meshes.uniform(quarter, n, n), theory))


# %%
# Navier's series
# ---------------
# The exact answer of a plate with bending stiffness D and shear stiffness K, term by term.


def series(D: np.ndarray, K: np.ndarray, terms: int = 200) -> float:
    """Deflection of the middle."""
    m, n = np.meshgrid(np.arange(1, terms, 2), np.arange(1, terms, 2))
    a, b, both = m * np.pi / SIDE, n * np.pi / SIDE, D[0, 1] + D[2, 2]
    rows = [[K[0] * a**2 + K[1] * b**2, K[0] * a, K[1] * b],
            [K[0] * a, D[0, 0] * a**2 + D[2, 2] * b**2 + K[0], both * a * b],
            [K[1] * b, both * a * b, D[2, 2] * a**2 + D[1, 1] * b**2 + K[1]]]  # fmt: skip
    matrix = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
    load = np.zeros((*m.shape, 3, 1))
    load[..., 0, 0] = -16 * PRESSURE / (np.pi**2 * m * n)
    w = np.linalg.solve(matrix, load)[..., 0, 0]
    return float((np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2) * w).sum())


# %%
# Shear stress through the thickness
# ----------------------------------
# Of a unit shear force along x, written out here: stress along x is Q11 z times the curvature, summed below a height.


def shear_stress(z: np.ndarray) -> np.ndarray:
    """Per unit of the shear force, at heights z (1/in)."""
    factor = 1 / (1 - 0.3**2 * 0.4)
    outer, inner = THICK / 2 + SKIN, THICK / 2
    stiff, soft = factor * 10e6, 10.0
    D = 2 / 3 * (stiff * (outer**3 - inner**3) + soft * inner**3)
    inside, at = np.abs(z) < inner, np.abs(z)
    return np.where(inside, stiff * (outer**2 - inner**2) + soft * (inner**2 - at**2), stiff * (outer**2 - at**2)) / (2 * D)


# %%
# Pictures
# --------


def draw(axes: plt.Axes, solutions: dict[str, sk.Solution]) -> None:
    """Deflection along the middle line."""
    x = np.linspace(0, SIDE / 2, 41)
    for (name, solution), colour in zip(solutions.items(), ("#0072B2", "#D55E00"), strict=True):
        w = solution.displacement(np.column_stack([x, np.zeros_like(x)]))[:, 2]
        axes.plot(np.concatenate([-x[::-1], x]), np.concatenate([w[::-1], w]), color=colour, lw=2, label=f"theory '{name}'")
    axes.plot(0, DEFLECTION, "kD", ms=7, label="NAFEMS R0031/3")
    axes.set(xlabel="x (in)", ylabel="deflection (in)", title="The middle line of the plate")
    axes.legend(frameon=False, loc="upper center")
    axes.grid(color="#e0e0e0")


def draw_stress(axes: plt.Axes) -> None:
    """Shear stress of a unit shear force, and the mean of one layer."""
    outer = THICK / 2 + SKIN
    z = np.linspace(-outer, outer, 801)
    axes.plot(shear_stress(z), z, color="#0072B2", lw=2, label="in equilibrium")
    moduli = np.where(np.abs(z) < THICK / 2, 3e4, 1.875e6)
    constant = moduli / (2 * SKIN * 1.875e6 + THICK * 3e4)
    axes.plot(constant, z, color="#D55E00", lw=1.5, ls="--", label="constant shear strain")
    axes.set(xlabel="shear stress over shear force (1/in)", ylabel="z (in)", title="Through the thickness")
    axes.legend(frameon=False, loc="center right")
    axes.grid(color="#e0e0e0")


# %%
# The run
# -------
# The numbers to hit: the deflection is that of Navier's series to 0.5 % and that of the source to 1 %, the stress in the
# middle of a face that of the source to 1 %, and the shear stress written out here has the energy of the section's
# stiffness. The thin theory has less than two thirds of the deflection, and ``"auto"`` takes the other one.


def main(size: str = "full", out: str = "out") -> dict[str, float]:
    """Solve in both theories, print a table, save a picture; returns the deflections."""
    n = 16 if size == "full" else 8
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    section = sk.Laminate(LAYERS).section()
    K = np.diag(section.shear_stiffness())
    exact = series(section.abd()[3:, 3:], K)
    summed = 5 / 6 * np.array([2 * SKIN * 1.875e6 + THICK * 3e4, 2 * SKIN * 1.875e6 + THICK * 1.2e4])
    stiff = series(section.abd()[3:, 3:], summed)
    solutions = {theory: plate(theory, n) for theory in ("kirchhoff", "full")}
    middle = np.argmin(np.abs(solutions["full"].system.mesh.p).sum(axis=0))
    stresses = {name: solution.nodal_stresses(-(THICK + SKIN) / 2)[middle, 0] for name, solution in solutions.items()}
    found = {name: float(solution.displacement((0.0, 0.0))[2]) for name, solution in solutions.items()}
    print("                                 deflection (in)   S11 in a face (psi)")
    for name in solutions:
        print(f"theory '{name}'{'':<{17 - len(name)}}    {found[name]:18.4f} {stresses[name]:18.0f}")
    print(f"NAFEMS R0031/3                {DEFLECTION:18.4f} {STRESS:18.0f}")
    print(f"Navier's series               {exact:18.4f}\n... with the sum of 5/6 G t    {stiff:18.4f}")

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    draw(left, solutions)
    draw_stress(right)
    figure.savefig(folder / "sandwich.png", dpi=120)

    assert np.isclose(found["full"], exact, rtol=5e-3) and np.isclose(found["full"], DEFLECTION, rtol=1e-2), found
    assert np.isclose(stresses["full"], STRESS, rtol=1e-2), stresses
    z, dz = (np.arange(200000) + 0.5) / 200000 * 2 * (THICK / 2 + SKIN) - THICK / 2 - SKIN, 2 * (THICK / 2 + SKIN) / 200000
    tau, G = shear_stress(z), np.where(np.abs(z) < THICK / 2, 3e4, 1.875e6)
    assert np.isclose((tau**2 / G).sum() * dz * K[0], 1.0, rtol=1e-4)
    assert found["kirchhoff"] / found["full"] < 2 / 3 and abs(stiff / exact - 1) > 0.25
    assert plate("auto", 4).system.choice.theory == "full"
    return found


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A sandwich bends by shear")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())
