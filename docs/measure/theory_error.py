"""What leaving shear out changes, estimated from thin fields alone, against the truth: tables of decision 0020.

From the folder of the repository, in about three minutes:

    .venv/bin/python docs/measure/theory_error.py

It writes theory_error_*.csv in docs/decisions. The truth is Ritz's method with shear (tests/reference), Saint-Venant's
torsion, and converged answers of theory `full`.
"""

import csv
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import skfem

import skancf as sk
from skancf.system.system import System
from skancf.thinness import form

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from reference import coupled_ritz, thick_ritz  # noqa: E402

NU = 0.3
OUTER, UP = ["left", "bottom"], (0.0, 0.0, 1.0)


def save(name: str, head: list[str], rows: list[list[object]]) -> None:
    path = ROOT / "docs" / "decisions" / f"theory_error_{name}.csv"
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    print(name, head, *rows, sep="\n   ", flush=True)


def isotropic(h: float) -> sk.Isotropic:
    """D = 1, mass 1 per area."""
    return sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1 / h)


def quarter(supports: list, h: float, loads: list, n: int = 4) -> System:
    surface = sk.Rectangle(0.5, 0.5)
    problem = sk.Problem(surface, h, isotropic(h), [*supports, sk.Symmetry("right"), sk.Symmetry("top")], loads)
    return problem.on(sk.meshes.uniform(surface, n, n), "kirchhoff")


BENT = {"hard": [sk.SimpleSupport(OUTER, kind="hard")], "soft": [sk.SimpleSupport(OUTER)], "clamped": [sk.Clamp(OUTER)],
        "two free": [sk.SimpleSupport("left", kind="hard")]}  # fmt: skip
PRESSED = {"hard": [sk.Roller(OUTER, UP, kind="hard")], "soft": [sk.Roller(OUTER, UP)],
           "clamped": [sk.Roller(OUTER, UP, kind="hard"), sk.NoRotation(OUTER)],
           "two free": [sk.Roller("left", UP, kind="hard")]}  # fmt: skip


def square_plates() -> None:
    """Estimate over true change on 4 x 4 elements a quarter; true change of the energy in per cent."""
    rows: list[list[object]] = []
    for edges in BENT:
        for slenderness in (10, 20, 50):
            h = 1 / slenderness
            solution = sk.solve_linear(quarter(BENT[edges], h, [sk.SurfaceLoad(UP)]))
            thick, thin = thick_ritz.uniform(edges, h, 12, NU), thick_ritz.uniform(edges, 0.0, 10, NU)
            centre, mean = (0.5, 0.5), sk.SectionForce("M11", within=((0.375, 0.5), (0.375, 0.5)))
            found = [sk.theory_error(solution, q).value for q in (sk.Displacement(at=centre), None, mean)]
            true = [thick.deflection(*centre) - thin.deflection(*centre), (thick.energy - thin.energy) / 4,
                    thick.mean_moment(0.375, 0.625) - thin.mean_moment(0.375, 0.625)]  # fmt: skip
            effectivity = [f"{one / two:.2f}" for one, two in zip(found, true, strict=True)]
            if edges == "hard":
                effectivity[2] = ""  # none is left out
            found_modes = sk.modes(quarter(BENT[edges], h, [], 6), 1).theory_errors
            found_loads = sk.buckling(quarter(PRESSED[edges], h, [sk.EdgeLoad("left", (1.0, 0, 0))], 6), 1).theory_errors
            for errors, kind in ((found_modes, "frequency"), (found_loads, "buckling")):
                ratio = thick_ritz.lowest(edges, h, kind, 10, NU) / thick_ritz.lowest(edges, 0.0, kind, 8, NU)
                effectivity.append(f"{errors[0] / (ratio - 1):.2f}")
            rows.append([edges, slenderness, f"{100 * (thick.energy / thin.energy - 1):.2f}", effectivity[0], effectivity[1],
                         *effectivity[2:]])  # fmt: skip
    save("plates", ["edges", "a/h", "true change of U (%)", "w in the middle", "U", "mean of M11", "first frequency",
                    "buckling load"], rows)  # fmt: skip


def strips() -> None:
    """Turn per length of a strip between its thirds."""
    rows: list[list[object]] = []
    n = np.arange(1, 200, 2)
    for width in (3, 4, 5, 7, 10, 20):
        surface = sk.Rectangle(3.0 * width, float(width))
        problem = sk.Problem(surface, 1.0, sk.Isotropic(2.6, NU, 1.0), [sk.Clamp("left")],
                             [sk.EdgeMoment("right", (1e-6, 0, 0))])  # fmt: skip
        solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 18, 6), "kirchhoff"))
        change = value = 0.0
        for x, sx in ((width, -1), (2 * width, 1)):
            for y, sy in ((0, -1), (width, 1)):
                part = sk.Displacement(at=(float(x), float(y)))
                change += sx * sy * sk.theory_error(solution, part).value
                value += sx * sy * part.value(solution)
        left = 1 - 192 / np.pi**5 / width * (np.tanh(n * np.pi * width / 2) / n**5).sum()
        true, found = 1 / left - 1, change / value
        rows.append([width, f"{100 * true:.2f}", f"{100 * found:.2f}", f"{found / true:.3f}",
                     f"{found / (1 - found) / true:.3f}"])  # fmt: skip
    save("strips", ["b/h", "true change (%)", "F (%)", "F / true", "F / (1 - F) / true"], rows)


def cornered(h: float) -> Iterator[tuple[str, sk.Problem, skfem.MeshQuad | None]]:
    """Plates with singular points."""
    line = np.linspace(-1, 1, 5)
    mesh = skfem.MeshQuad.init_tensor(line, line)
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.flatnonzero((x > 0) & (y < 0)))
    law, load = isotropic(h), [sk.SurfaceLoad(UP)]
    square = sk.Rectangle(1.0, 1.0)
    yield "L, clamped", sk.Problem(sk.Plane(), h, law, [sk.Clamp("boundary")], load), mesh
    yield "L, soft", sk.Problem(sk.Plane(), h, law, [sk.SimpleSupport("boundary")], load), mesh
    yield "L, one side clamped", sk.Problem(sk.Plane(), h, law, [sk.Clamp(lambda x, y: abs(x + 1) < 1e-9)], load), mesh
    yield "square, one side clamped", sk.Problem(square, h, law, [sk.Clamp("left")], load), None
    for degrees, support in ((60, sk.Clamp), (60, sk.SimpleSupport), (30, sk.SimpleSupport)):
        surface = sk.Parallelogram(1.0, 1.0, np.radians(degrees))
        kind = "clamped" if support is sk.Clamp else "soft"
        yield f"rhombus {degrees} degrees, {kind}", sk.Problem(surface, h, law, [support("boundary")], load), None


def corners() -> None:
    """Share on meshes graded to singular points, all fields counted and as they are, against theory `full`."""
    rows: list[list[object]] = []
    for h in (0.05, 0.02):
        for name, problem, mesh in cornered(h):
            full = sk.adapt(problem, sk.StrainEnergy(), 1e-3, mesh=mesh, theory="full", linear=True, max_dofs=40_000)
            thin = sk.adapt(problem, sk.StrainEnergy(), 1e-4, mesh=mesh, linear=True, max_dofs=12_000)
            reach, shares = form.REACH, []
            for form.REACH in (1e-6, reach):
                shares.append(thin.solution.shear_share)
            true = full.corrected / thin.corrected - 1
            rows.append([name, f"1/{1 / h:.0f}", f"{100 * true:.2f}", f"{100 * shares[0]:.3g}", f"{100 * shares[1]:.2f}",
                         f"{shares[1] / true:.2f}"])  # fmt: skip
    save("corners", ["plate", "h", "true change of U (%)", "F everywhere (%)", "F (%)", "F / true"], rows)


def large_deflections() -> None:
    """Clamped squares under q a^4 / E h^4 = Q: deflection of the middle, against two meshes of theory `full`."""
    rows: list[list[object]] = []
    surface, quantity = sk.Rectangle(0.5, 0.5), sk.Displacement(at=(0.5, 0.5))
    for slenderness, load in ((10, 25), (20, 25), (20, 50), (20, 100), (50, 100)):
        h = 1 / slenderness
        problem = sk.Problem(surface, h, sk.Isotropic(1.0, NU, 1.0),
                             [sk.Clamp(OUTER), sk.Symmetry("right"), sk.Symmetry("top")],
                             [sk.SurfaceLoad((0, 0, load * h**4))])  # fmt: skip
        thin, coarse, fine = (sk.solve(problem.on(sk.meshes.uniform(surface, n, n), theory)).solution
                              for n, theory in ((6, "kirchhoff"), (8, "full"), (16, "full")))  # fmt: skip
        values = [quantity.value(state) for state in (thin, coarse, fine)]
        true, found = values[2] + (values[2] - values[1]) / 3 - values[0], sk.theory_error(thin, quantity).value
        rows.append([slenderness, load, f"{values[0] / h:.3f}", f"{100 * true / values[0]:.2f}",
                     f"{100 * found / values[0]:.2f}", f"{found / true:.2f}"])  # fmt: skip
    save("large", ["a/h", "Q", "w / h", "true change (%)", "F (%)", "F / true"], rows)


def angles() -> None:
    """A layer with E1 / E2 = 25 at an angle to the edges, a/h = 20."""
    rows: list[list[object]] = []
    surface = sk.Rectangle(1.0, 1.0)
    for angle in (0.0, 0.1, 0.2, 0.5, np.pi / 4):
        law = sk.Orthotropic((25e6, 1e6, 1e6), (0.25, 0.25, 0.25), (0.5e6, 0.5e6, 0.2e6), 1.0, angle=angle)
        row: list[object] = [f"{np.degrees(angle):.0f}"]
        for edges, support in (("soft", sk.SimpleSupport("boundary")), ("clamped", sk.Clamp("boundary")),
                               ("one clamped", sk.Clamp("left"))):  # fmt: skip
            problem = sk.Problem(surface, 0.05, law, [support], [sk.SurfaceLoad(UP)])
            share = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 16, 16), "kirchhoff")).shear_share
            D, S = (tuple(map(tuple, m)) for m in (problem.section.abd()[3:, 3:], problem.section.shear_stiffness()))
            true = coupled_ritz.energy(edges, D, S, 14) / coupled_ritz.energy(edges, D, None, 12) - 1
            row += [f"{100 * true:.1f}", f"{share / true:.2f}"]
        rows.append(row)
    save("angles", ["angle", "soft: true (%)", "F / true", "clamped: true (%)", "F / true", "one side clamped: true (%)",
                    "F / true"], rows)  # fmt: skip


if __name__ == "__main__":
    warnings.simplefilter("ignore", sk.OutOfDepth)
    for table in [square_plates, strips, large_deflections, angles, corners]:
        if not sys.argv[1:] or table.__name__ in sys.argv[1:]:
            table()
