"""Does statics arrive? Scenes that Newton's method alone does not solve, and random sheets: the tables of decision 0014.

From the folder of the repository, in some ten minutes:

    .venv/bin/python docs/measure/arrival.py

It writes docs/decisions/arrival.csv and arrival_sheets.csv. Every scene is solved without an option; "without relaxation" is
``solve(relax=False)``, load steps alone. Right is a stable equilibrium at the whole load that passed its checks.
"""

import csv
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

import skancf as sk
from skancf.system.system import System

TABLES = Path(__file__).resolve().parent.parent / "decisions"
THEORIES = ("kirchhoff", "full")
Scene = tuple[System, Callable[[sk.Solution], float], float]
"""A system, a displacement of its answer, and what others publish for it, NaN where nobody does."""


def on(problem: sk.Problem, nx: int, ny: int, theory: str) -> System:
    return problem.on(sk.meshes.uniform(problem.surface, nx, ny), theory)


def films(theory: str) -> Iterator[Scene]:
    """Square films pinned all round: w / h over Q^(1/3), which is 0.2865 for a membrane."""
    for a, h, young, pressure in (
        (1.0, 1e-3, 210e9, 1e6), (1.0, 1e-4, 3e9, 1e3), (0.3, 16e-6, 70e9, 50.0), (10.0, 2.5e-6, 3e9, 9e-6),
    ):  # fmt: skip
        problem = sk.Problem(sk.Rectangle(a, a), h, sk.Isotropic(young, 0.3, 1400.0), [sk.Pin("boundary")],
                             [sk.SurfaceLoad((0.0, 0.0, pressure))])  # fmt: skip
        scale = h * (pressure * a**4 / (young * h**4)) ** (1 / 3)
        yield on(problem, 8, 8, theory), lambda s, a=a, c=scale: s.displacement((a / 2, a / 2))[2] / c, 0.2865


def pulled_cylinders(theory: str) -> Iterator[Scene]:
    """An open cylinder pulled apart (Sze, Liu and Lo 2004, 3.5), an eighth of it; the point that moves in by 4.551."""
    surface = sk.CylinderSector(4.953, 5.175, pi / 2)
    problem = sk.Problem(
        surface, 0.094, sk.Isotropic(10.5e6, 0.3125, 1.0), [sk.Symmetry("left"), sk.Symmetry("start"), sk.Symmetry("end")],
        [sk.PointForce((0.0, pi / 2), (0, 0, 10e3))],
    )  # fmt: skip
    for n, m in ((8, 12), (16, 24)):
        yield on(problem, n, m, theory), lambda s: float(np.linalg.norm(s.displacement((0.0, 0.0)))), 4.551


def pinched_cylinders(theory: str) -> Iterator[Scene]:
    """With rigid diaphragms, pinched by two forces (3.6), an eighth; 83.1 under the force."""
    surface = sk.CylinderSector(100.0, 100.0, pi / 2, start=pi / 2)
    problem = sk.Problem(
        surface, 1.0, sk.Isotropic(30e3, 0.3, 1.0),
        [sk.Prescribed("left", (None, 0.0, 0.0)), sk.Symmetry("start"), sk.Symmetry("end"), sk.Symmetry("right")],
        [sk.PointForce((100.0, pi / 2), (0, 0, -3000.0))],
    )  # fmt: skip
    for n in (8, 12, 16, 24):
        yield on(problem, n, n, theory), lambda s: -s.displacement((100.0, pi / 2))[2], 83.10


def semi_cylinders(theory: str) -> Iterator[Scene]:
    """Clamped at one end, pushed down at the other (3.7): isotropic, and cross-ply laminates; 171.5, 201.0 and 178.4."""
    surface = sk.CylinderSector(101.6, 304.8, pi / 2, start=pi / 2)
    ply = sk.Orthotropic((2068.5, 517.125, 517.125), (0.3, 0.3, 0.3), (795.6, 795.6, 198.894), 1.0)
    materials: list[tuple[float | None, Any, float]] = [(3.0, sk.Isotropic(2068.5, 0.3, 1.0), 171.505)]
    for angles, reference in (((0.0, pi / 2, 0.0), 200.983), ((pi / 2, 0.0, pi / 2), 178.386)):
        materials.append((None, sk.Laminate([sk.Layer(ply, 1.0, angle) for angle in angles]), reference))
    for thickness, material, reference in materials:
        problem = sk.Problem(
            surface, thickness, material,
            [sk.Clamp("left"), sk.Symmetry("start"), sk.Roller("end", (0, 0, 1)), sk.NoRotation("end")],
            [sk.PointForce((304.8, pi / 2), (0, 0, -1000.0))],
        )  # fmt: skip
        for n in (8, 16):
            yield on(problem, n, n, theory), lambda s: -s.displacement((304.8, pi / 2))[2], reference


def roofs(theory: str) -> Iterator[Scene]:
    """Hinged roofs beyond their snap (3.8), a quarter; 12.7 thick, 28.2 under the whole load by interpolation."""
    surface = sk.CylinderSector(2540.0, 254.0, 0.1, start=pi / 2 - 0.1)
    for thickness, reference in ((12.7, 28.67), (6.35, np.nan)):
        problem = sk.Problem(
            surface, thickness, sk.Isotropic(3102.75, 0.3, 1.2e-9),
            [sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
            [sk.PointForce((254.0, pi / 2), (0.0, 0.0, -750.0))],
        )  # fmt: skip
        yield on(problem, 8, 8, theory), lambda s: -s.displacement((254.0, pi / 2))[2], reference


def airbags(theory: str) -> Iterator[Scene]:
    """A quarter of one of two square sheets joined at their edges; some 0.21 to 0.22 in the middle."""
    side = 0.6 / np.sqrt(2)
    problem = sk.Problem(
        sk.Rectangle(side, side), 6e-4, sk.Isotropic(588e6, 0.4, 1000.0),
        [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Roller(["right", "top"])], [sk.FollowerPressure(5e3)],
    )  # fmt: skip
    for n in (8, 12):
        yield on(problem, n, n, theory), lambda s: s.displacement((0.0, 0.0))[2], 0.217


def struts(theory: str) -> Iterator[Scene]:
    """A cantilever under 1.5 times Euler's load; the elastica's end is 0.7886 of the length aside."""
    length, width, thickness = 1.2, 0.08, 0.004
    euler = pi**2 * 70e9 * thickness**3 / 12 / (4 * length**2)
    problem = sk.Problem(sk.Rectangle(length, width), thickness, sk.Isotropic(70e9, 0.0, 2700.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (-1.5 * euler, 0.0, 0.0))])  # fmt: skip
    for n in (8, 24):
        yield on(problem, n, 1, theory), lambda s: abs(s.displacement((1.2, 0.04))[2]) / 1.2, 0.78858


GROUPS = {
    "films": films, "pulled cylinders": pulled_cylinders, "pinched cylinders": pinched_cylinders,
    "semi-cylinders": semi_cylinders, "roofs that snap": roofs, "airbags": airbags, "struts": struts,
}  # fmt: skip


def is_right(result: sk.StaticResult) -> bool:
    return result.status.name == "CONVERGED" and not result.negative_pivots and all(check.passed for check in result.checks)


def scenes() -> Iterator[list[Any]]:
    for name, group in GROUPS.items():
        for theory in THEORIES:
            made = list(group(theory))
            begun = time.perf_counter()
            results = [sk.solve(system) for system, _, _ in made]
            seconds = time.perf_counter() - begun
            alone = [sk.solve(system, relax=False) for system, _, _ in made]
            off = [probe(r.solution) / reference - 1 for r, (_, probe, reference) in zip(results, made, strict=True)]
            right = [f"{sum(map(is_right, some))} of {len(made)}" for some in (alone, results)]
            row = [
                f"{name}, {theory}", *right, sum(result.iterations for result in results), f"{seconds:.1f}",
                ", ".join("" if np.isnan(part) else f"{100 * part:+.1f}" for part in off),
            ]  # fmt: skip
            print(*row, sep=" | ", flush=True)
            yield row


SIDES = {"rectangle": ("left", "right", "bottom", "top"), "cylinder": ("left", "right", "start", "end"),
         "sphere": ("top", "bottom", "start", "end"), "annulus": ("inner", "outer", "start", "end")}  # fmt: skip


def sheet(seed: int) -> System:
    """A sheet of random shape, size, thickness (1e-5 to 2e-2 of its size), law, support, load (1e-3 to 1e7 E h^4 / L^4)."""
    rng = np.random.default_rng(seed)
    a = 10 ** rng.uniform(-2, 1)
    b = a * 10 ** rng.uniform(-0.7, 0.7)
    shape = str(rng.choice(list(SIDES)))
    surface: Any = {
        "rectangle": lambda: sk.Rectangle(a, b),
        "cylinder": lambda: sk.CylinderSector(a, b, rng.uniform(0.1, 2.5)),
        "sphere": lambda: sk.SphereSector(a, (rng.uniform(0.1, 0.6), rng.uniform(0.8, 1.5)), rng.uniform(0.3, 1.5)),
        "annulus": lambda: sk.AnnulusSector(a, a + b, rng.uniform(0.3, 3.0)),
    }[shape]()
    size = min(a, b)
    thickness, young = size * 10 ** rng.uniform(-5, -1.7), 10 ** rng.uniform(5, 11.5)
    one, other, third, fourth = SIDES[shape]
    supports = [
        [sk.Pin("boundary")], [sk.Clamp("boundary")], [sk.Clamp(one)], [sk.Pin([one, other])],
        [sk.Clamp(third), sk.Pin(fourth)],
    ][rng.integers(5)]  # fmt: skip
    pressure = rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 7) * young * thickness**4 / size**4
    load = sk.FollowerPressure(pressure) if rng.random() < 0.3 else sk.SurfaceLoad(pressure * rng.normal(size=3) / 1.7)
    material = sk.Isotropic(young, rng.uniform(0, 0.45), 1000.0)
    problem = sk.Problem(surface, thickness, material, supports, [load])
    return on(problem, *(int(n) for n in rng.integers(3, 9, 2)), theory=THEORIES[seed % 2])


def out_of_balance(system: System, solution: sk.Solution) -> float:
    loads = solution.load_factor * system.external_force(solution.q).reshape(-1, 4, 3)[:, 0]
    return float(np.abs(loads.sum(axis=0) + solution.reactions()).max() / np.linalg.norm(loads, axis=1).sum())


def sheets(count: int = 300) -> Iterator[list[Any]]:
    ends: Counter[str] = Counter()
    iterations, worst = 0, 0.0
    for seed in range(count):
        system = sheet(seed)
        result = sk.solve(system)
        iterations += result.iterations
        ends[result.status.value + (", not stable, and says so" if result.negative_pivots else "")] += 1
        if result.status.name == "CONVERGED":
            worst = max(worst, out_of_balance(system, result.solution))
    for end, number in ends.most_common():
        yield [end, number]
    yield ["iterations of all", iterations]
    yield ["largest imbalance of what is called converged, of the loads", f"{worst:.1e}"]


def write(name: str, head: list[str], rows: Iterator[list[Any]]) -> None:
    with (TABLES / name).open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])


def main() -> None:
    warnings.simplefilter("ignore", sk.OutOfDepth)
    head = ["scenes", "right without relaxation", "right", "iterations", "seconds", "off the published value, %"]
    write("arrival.csv", head, scenes())
    write("arrival_sheets.csv", ["random sheets that end", "number"], sheets())


if __name__ == "__main__":
    main()
