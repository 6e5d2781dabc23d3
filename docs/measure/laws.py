"""Laws at points: the tables of decision 0026.

From the folder of the repository, in a minute on one core:

    .venv/bin/python docs/measure/laws.py

It writes docs/decisions/laws_*.csv. Costs are the best of many runs, in processor time.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
import tables

import skancf as sk
from benchmarks import laws as costs
from skancf.materials import section_of
from skancf.materials.through_thickness import heights, through_thickness

MU, RHO = 1.5e6, 1000.0
OGDEN = [(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)]
TENSION = {"neo-Hooke": 1.105598565, "Mooney-Rivlin": 1.099905842, "Ogden": 1.088778638}
"""Volumes at the stretch 2, nu = 0.45, of the unit tests of G+Smo."""
BALLOON = {"neo-Hooke": (5236.73, 1.38309), "Mooney-Rivlin": (5945.96, 1.53519), "Ogden": (5494.12, 1.37405)}
"""Largest pressure and its stretch, of the closed form."""
FLEXURE = {0.05: 0.016654, 0.1: 0.033234, 0.2: 0.065883, 0.4: 0.127431}
"""Moment over mu h^2 by the angle per undeformed thickness (Rivlin 1949, in plane strain)."""


def rubbers(mu: float, **more: float) -> dict[str, Any]:
    terms = [(m * mu / 4.225e5, alpha) for m, alpha in OGDEN]
    return {"neo-Hooke": sk.NeoHooke(mu, RHO, **more), "Mooney-Rivlin": sk.MooneyRivlin(7 / 16 * mu, mu / 16, RHO, **more),
            "Ogden": sk.Ogden(terms, RHO, **more)}  # fmt: skip


def in_tension(law: Any, stretch: float) -> tuple[float, float]:
    """Volume and Cauchy stress where nothing pulls across."""
    C22 = 1 / stretch
    for _ in range(30):
        found = law.plane_stress([[stretch**2], [C22], [0.0]])
        C22 -= 2 * found.stress[1, 0] / found.stiffness[1, 0]
    J = stretch * np.sqrt(C22 * found.stretch33[0])
    return float(J), float(found.stress[0, 0] * stretch**2 / J)


def pressure(law: Any, stretch: np.ndarray) -> np.ndarray:
    """Of a sphere of radius 10 and thickness 0.1."""
    C = np.array([stretch**2, stretch**2, 0 * stretch])
    return np.asarray(0.02 * law.plane_stress(C).stress[0] / stretch)


def largest(law: Any, near: float) -> tuple[float, float]:
    stretch = near + np.linspace(-0.02, 0.02, 401)
    fit = np.polynomial.Polynomial.fit(stretch, pressure(law, stretch), 6)
    top = min((r.real for r in fit.deriv().roots() if abs(r.imag) == 0), key=lambda r: abs(r - near))
    return float(fit(top)), float(top)


def moment(angle: float, points: int, squared: bool = True) -> float:
    """Of a plate of thickness 1 and shear modulus 1 that turns by an angle per length; without the square of z it is the
    thin-shell strain eps + z kappa."""
    law = sk.NeoHooke(1.0, RHO)
    z, w = heights(section_of(law, 1.0), points)

    def of(stretch: float) -> tuple[float, float]:
        if squared:
            along = np.array([[1.0], [0.0], [0.0]])
            found = through_thickness(law, z, w, (stretch**2 - 1) / 2 * along, stretch * angle * along, 0 * along)
            forces = found.forces[:, 0]
            return float(forces[0]), float(forces[3] * stretch)
        C = stretch**2 + 2 * z * angle * stretch
        S = law.plane_stress(np.array([C, np.ones_like(z), 0 * z])).stress[0]
        return float(S @ w), float((S * z) @ w * stretch)

    stretch = bisected(lambda l: of(l)[0], 0.6, 1.4)
    return of(stretch)[1]


def bisected(function: Callable[[float], float], low: float, high: float) -> float:
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return (low + high) / 2


def bent(law: Any, thickness: float, mixed: bool) -> int:
    """Iterations that roll a strip to half a circle by a moment at its end, of shear modulus 0.4225 MPa."""
    surface, value = sk.Rectangle(1.0, 0.1), 4 * 4.225e5 * thickness**3 / 12 * np.pi
    supports, load = [sk.Clamp("left"), sk.Symmetry(["top", "bottom"])], sk.EdgeMoment("right", (0.0, -value, 0.0))
    problem = sk.Problem(surface, thickness, law, supports, [load])
    result = sk.solve(problem.on(sk.meshes.uniform(surface, 8, 1), "kirchhoff"), mixed=mixed, rtol=1e-8)
    result.unwrap()
    return int(result.iterations)


def softest(law: Any, stretch: float) -> float:
    """Smallest eigenvalue of the stiffness D of a sheet stretched in both directions, over the shear modulus."""
    found = law.plane_stress([[stretch**2], [stretch**2], [0.0]]).stiffness[:, 0]
    D = np.array([[found[0], found[3], found[4]], [found[3], found[1], found[5]], [found[4], found[5], found[2]]])
    return float(np.linalg.eigvalsh(D)[0] / law.shear_modulus)


def sheet(load: float, n: int) -> Any:
    """A quarter of a square sheet 1 m wide and 1 cm thick, held along its edges, under a load across (Pa)."""
    surface = sk.Rectangle(0.5, 0.5)
    supports = [sk.Symmetry(["left", "bottom"]), sk.SimpleSupport(["right", "top"])]
    law = sk.NeoHooke(1e6, 1000.0, poisson=0.45)
    problem = sk.Problem(surface, 0.01, law, supports, [sk.SurfaceLoad((0.0, 0.0, load))])
    return sk.solve(problem.on(sk.meshes.quadtree(sk.meshes.uniform(surface, n, n)), "kirchhoff")).unwrap()


def estimates() -> list[list[str]]:
    """Estimates over true errors, which are those against 8 x 8 and 16 x 16 elements, extrapolated by the order 4."""
    deflection, energy = sk.Displacement((0.0, 0.0), (0.0, 0.0, 1.0)), sk.StrainEnergy()
    rows = []
    for load in (60e3, 130e3):
        states = {n: sheet(load, n) for n in (2, 4, 8, 16)}

        def limit(number: Callable[[Any], float], states: dict[int, Any] = states) -> float:
            coarse, fine = number(states[8]), number(states[16])
            return fine + (fine - coarse) / 15

        def potential(state: Any) -> float:
            return float(state.strain_energy - state.work)

        strain = states[16].strains(np.zeros((2, 1)), "middle")[0, 0, 0]
        for n in (2, 4):
            state, true = states[n], potential(states[n]) - limit(potential)
            parts = [sk.goal_estimate(state, each).error / (limit(each.value) - each.value(state))
                     for each in (deflection, energy)]  # fmt: skip
            parts += [float(each(state).sum()) / true for each in (sk.recovery_indicator, sk.residual_indicator)]
            rows.append([f"{load / 1e3:.0f}", f"{strain:.2f}", f"{n} x {n}", *(f"{part:.2f}" for part in parts)])
    return rows


def main() -> None:
    small, stiff = rubbers(MU, poisson=0.45), rubbers(4.225e5)
    rows = []
    for name, law in small.items():
        J, cauchy = in_tension(law, 2.0)
        p, at = largest(stiff[name], BALLOON[name][1])
        rows.append([name, f"{J:.10f}", f"{abs(J - TENSION[name]):.0e}", f"{cauchy / 1e6:.6f}", f"{p:.3f}", f"{at:.6f}"])
    tables.write("laws_points.csv", "law; volume at stretch 2; less that of G+Smo; Cauchy stress (MPa); largest pressure in "
                 "a balloon (Pa); at the stretch", rows)  # fmt: skip
    rows = []
    for angle, exact in FLEXURE.items():
        errors = [moment(angle, points) / exact - 1 for points in (2, 3, 4, 30)]
        linear = moment(angle, 30, squared=False) / exact - 1
        rows.append([f"{angle:g}", f"{exact:.6f}", f"{100 * linear:.2f}", *(f"{100 * each:.3f}" for each in errors)])
    tables.write("laws_flexure.csv", "h / R; M / mu h^2; eps + z kappa (%); C(z), 2 points (%); 3 points (%); 4 points (%); "
                 "30 points (%)", rows)  # fmt: skip
    laws = {**stiff, "linear": sk.Isotropic(3 * 4.225e5, 0.4999, RHO)}
    kinds = [(t, mixed) for t in (0.02, 0.005) for mixed in (True, False)]
    rows = [[name, *(str(bent(law, *kind)) for kind in kinds)] for name, law in laws.items()]
    tables.write("laws_newton.csv", "law; t / L = 0.02, mixed; plain; t / L = 0.005, mixed; plain", rows)
    stretches = (1.0, 1.25, 1.5, 2.0, 3.0)
    rows = [[name, *(f"{softest(law, stretch):.3f}" for stretch in stretches)] for name, law in stiff.items()]
    tables.write("laws_softest.csv", "law; stretch 1; 1.25; 1.5; 2; 3", rows)
    tables.write("laws_errors.csv", "load (kPa); strain of the middle; elements; deflection; energy; recovery indicator; "
                 "residual indicator", estimates())  # fmt: skip
    rows = [[row.name, f"{row.by_hand:.3f}", f"{row.own:.3f}", f"{row.own / row.by_hand:.1f}"] for row in costs.measure()]
    tables.write("laws_cost.csv", "energy; by hand (us); own (us); ratio", rows)


if __name__ == "__main__":
    main()
