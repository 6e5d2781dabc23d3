"""Error bars against true errors: corners of all kinds, holes, shells, poles, numbers that are zero.

Each number is asked for with a few tolerances; a bar over the true error is its efficiency. The truth is exact, or that of
docs/measure/polygons.py, or, marked "own", the corrected value of a run of a tenth of the smallest tolerance. Writes
docs/decisions/bars.csv, and prints a summary. From the folder of the repository, in some minutes:

    .venv/bin/python docs/measure/bars.py [part of a name]
"""

import csv
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi, radians
from pathlib import Path
from typing import Any

import numpy as np

import skancf as sk

OUT = Path(__file__).resolve().parent.parent / "decisions" / "bars.csv"
T, NU = 0.01, 0.3
MATERIAL = sk.Isotropic(12 * (1 - NU**2) / T**3, NU, 1 / T)
"""With D = rho t = 1."""
DOWN, HARD = sk.SurfaceLoad((0.0, 0.0, 1.0)), sk.SimpleSupport("boundary", "hard")
L_SHAPE = sk.Rectangle(3.0, 2.0, origin=(-1.0, -1.0))
L_MESH = sk.meshes.uniform(L_SHAPE, 6, 4, openings=[((0.0, 2.0), (-1.0, 0.0))])
"""Legs of 1 and 2."""


@dataclass
class Scene:
    """A number, its truth or None, and the tolerances it is asked for with."""

    problem: sk.Problem
    quantity: Any
    truth: float | None
    rtols: tuple[float, ...] = (1e-2, 1e-3)
    more: dict[str, Any] = field(default_factory=lambda: {"linear": True})


def plate(surface: Any, supports: list, loads: list, material: Any = MATERIAL) -> sk.Problem:
    thickness = None if isinstance(material, sk.Laminate) else T
    return sk.Problem(surface, thickness, material, supports, loads)


def skew(degrees: float) -> sk.Parallelogram:
    return sk.Parallelogram(1.0, 1.0, radians(degrees))


def trapezium() -> sk.MappedSurface:
    return sk.MappedSurface(lambda x, y: (x * (1 - 0.7 * y) + 0.5 * y, 0.8 * y, 0 * x), ((0.0, 1.0), (0.0, 1.0)))


SKEW = {35: (6.52404165e-4, 6.71374008e-5, 49.3763395), 50: (1.71570658e-3, 2.55681816e-4, 30.4376599)}
"""Deflection of the middle, energy and first eigenvalue of the membrane, by polygons.py."""
TRAPEZIUM, L_SIMPLE = (8.88511684e-4, 9.63726167e-5, 41.6188138), (0.0108598822, 0.0100499435)


def corners() -> Iterator[tuple[str, Scene]]:
    """Obtuse, re-entrant, between two kinds of support; of one material and of two layers; bent, stretched, vibrating."""
    for degrees, (w, energy, membrane) in SKEW.items():
        problem = plate(skew(degrees), [HARD], [DOWN])
        yield f"skew {degrees}, deflection", Scene(problem, sk.Displacement((0.5, 0.5)), w)
        yield f"skew {degrees}, energy", Scene(problem, sk.StrainEnergy(), energy)
        yield f"skew {degrees}, frequency", Scene(problem, sk.Eigenfrequency(), membrane / 2 / pi, more={})
    w, energy, membrane = TRAPEZIUM
    problem = plate(trapezium(), [HARD], [DOWN])
    yield "trapezium, deflection", Scene(problem, sk.Displacement((0.5, 0.5)), w)
    yield "trapezium, energy", Scene(problem, sk.StrainEnergy(), energy)
    yield "trapezium, frequency", Scene(problem, sk.Eigenfrequency(), membrane / 2 / pi, more={})
    on_l = {"linear": True, "mesh": L_MESH}
    ply = sk.Orthotropic(young=(12e6, 0.8e6, 0.8e6), poisson=(0.25, 0.25, 0.25), shear=(0.5e6,) * 3, density=1.0)
    crossed = sk.Laminate([sk.Layer(ply, T / 2), sk.Layer(ply, T / 2, angle=pi / 2)])
    simple, clamped = plate(L_SHAPE, [HARD], [DOWN]), plate(L_SHAPE, [sk.Clamp("boundary")], [DOWN])
    yield "L, deflection", Scene(simple, sk.Displacement((1.0, 0.5)), L_SIMPLE[0], more=on_l)
    yield "L, energy", Scene(simple, sk.StrainEnergy(), L_SIMPLE[1], more=on_l)
    yield "L, frequency", Scene(simple, sk.Eigenfrequency(), None, more={"mesh": L_MESH})
    yield "L clamped, energy", Scene(clamped, sk.StrainEnergy(), None, more=on_l)
    yield "L clamped, mean moment", Scene(clamped, sk.SectionForce("M11", within=((0.0, 0.5), (0.0, 0.5))), None, more=on_l)
    layered = plate(L_SHAPE, [HARD], [DOWN], crossed)
    yield "L of two layers, energy", Scene(layered, sk.StrainEnergy(), None, more=on_l)
    yield "L of two layers, deflection", Scene(layered, sk.Displacement((1.0, 0.5)), None, more=on_l)
    half = [HARD, sk.Clamp(lambda x, y: (y < 1e-9) & (x < 0.5 + 1e-9))]
    yield "clamped for a half edge, energy", Scene(plate(sk.Rectangle(1.0, 0.7), half, [DOWN]), sk.StrainEnergy(), None)
    free = [sk.Clamp("top"), sk.SimpleSupport(lambda x, y: (y < 1e-9) & (x < 0.5 + 1e-9))]
    yield "free for a half edge, deflection", Scene(
        plate(sk.Rectangle(1.0, 0.7), free, [DOWN]), sk.Displacement((1.0, 0.0)), None)  # fmt: skip
    pulled = plate(L_SHAPE, [sk.Clamp("left"), sk.Roller("boundary")], [sk.EdgeLoad("right", (1.0, 0.0, 0.0))])
    yield "L pulled, energy", Scene(pulled, sk.StrainEnergy(), None, more=on_l)


def holes() -> Iterator[tuple[str, Scene]]:
    """Membrane forces by a hole of radius 1 in a plate under shear, cut out at R = 4 with the exact tractions."""

    def stress(r: float, y: float) -> tuple[float, float, float]:
        return ((1 - 4 / r**2 + 3 / r**4) * np.sin(2 * y), -(1 + 3 / r**4) * np.sin(2 * y),
                (1 + 2 / r**2 - 3 / r**4) * np.cos(2 * y))  # fmt: skip

    def traction(x, y):
        along, _, across = stress(x, y)
        return np.stack([along * np.cos(y) - across * np.sin(y), along * np.sin(y) + across * np.cos(y), 0 * x * y])

    sector = sk.AnnulusSector(1.0, 4.0, pi / 2, start=pi / 4)
    problem = plate(sector, [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller("outer")], [sk.EdgeLoad("outer", traction)])
    for at in ((1.0, 0.75 * pi), (1.0, 0.25 * pi), (1.0, 2.0), (1.5, 1.2), (2.6, 2.1)):
        for number, component in enumerate(("N11", "N22", "N12")):
            truth = float(stress(*at)[number])
            if abs(truth) > 0.1:
                yield f"hole, {component} at r = {at[0]:g}, {at[1]:.2f}", Scene(
                    problem, sk.SectionForce(component, at=at), truth)  # fmt: skip


def shells() -> Iterator[tuple[str, Scene]]:
    """Moments and membrane forces at points of shells that are pinched, pulled, loaded by their weight."""
    sphere = sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2)
    pulled = sk.Problem(
        sphere, 0.04, sk.Isotropic(6.825e7, 0.3, 1.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller((pi / 2, 0.0))],
        [sk.PointForce((pi / 2, 0.0), (1.0, 0, 0)), sk.PointForce((pi / 2, pi / 2), (0, -1.0, 0))],
    )  # fmt: skip
    for name, at in (("M11", (1.1, 0.4)), ("M22", (0.8, 1.2)), ("M22", (1.3, 0.9))):
        yield f"hemisphere, {name} at {at}", Scene(pulled, sk.SectionForce(name, at=at), None, (1e-2,))
    yield "hemisphere, deflection", Scene(pulled, sk.Displacement((pi / 2, 0.0), (1, 0, 0)), None)
    tube = sk.CylinderSector(300.0, 300.0, pi / 2, start=pi / 2)
    pinched = sk.Problem(
        tube, 3.0, sk.Isotropic(3e6, 0.3, 1.0),
        [sk.Prescribed("left", (None, 0.0, 0.0)), sk.Symmetry("start"), sk.Symmetry("end"), sk.Symmetry("right")],
        [sk.PointForce((300.0, pi / 2), (0, 0, -0.25))],
    )  # fmt: skip
    for name, at in (("M11", (120.0, 2.1)), ("M22", (200.0, 2.9)), ("N22", (60.0, 1.8))):
        yield f"pinched tube, {name} at {at}", Scene(pinched, sk.SectionForce(name, at=at), None, (1e-2,))
    roof = sk.Problem(
        sk.CylinderSector(25.0, 25.0, radians(40), start=radians(50)), 0.25, sk.Isotropic(4.32e8, 0.0, 1.0),
        [sk.Prescribed("left", (None, 0.0, 0.0)), sk.Symmetry("right"), sk.Symmetry("end")],
        [sk.SurfaceLoad((0, 0, -90.0))],
    )  # fmt: skip
    yield "roof, deflection of the free edge", Scene(roof, sk.Displacement((25.0, radians(50))), None)
    yield "roof, M12 on the axis", Scene(roof, sk.SectionForce("M12", at=(12.0, radians(90))), 0.0, (1e-2, 1e-3))


def poles() -> Iterator[tuple[str, Scene]]:
    """Clamped discs in sectors, under pressure and a force at the pole; a dome."""
    for angle in (pi / 3, pi / 2, pi, 2 * pi):
        closed = angle > 6
        mirrors = [] if closed else [sk.Symmetry("start"), sk.Symmetry("end")]
        disc, name = sk.AnnulusSector(0.0, 1.0, angle, closed=closed), f"disc of {np.degrees(angle):.0f}"
        problem, at = plate(disc, [sk.Clamp("outer"), *mirrors], [DOWN]), (0.4, 0.3)
        both = (1e-2, 1e-4)
        moment = ((1 + NU) - (3 + NU) * at[0] ** 2) / 16
        yield f"{name}, deflection", Scene(problem, sk.Displacement((0.0, 0.0)), 1 / 64, both)
        yield f"{name}, energy", Scene(problem, sk.StrainEnergy(), angle / 768, both)
        yield f"{name}, moment", Scene(problem, sk.SectionForce("M11", at=at), moment, both)
        yield f"{name}, moment at the edge", Scene(problem, sk.SectionForce("M11", at=(1.0, 0.3)), -1 / 8, both)
        yield f"{name}, M12", Scene(problem, sk.SectionForce("M12", at=at), 0.0, (1e-3,))
        yield f"{name}, frequency", Scene(problem, sk.Eigenfrequency(), 3.1962206**2 / 2 / pi, both, {})
        pushed = plate(disc, [sk.Clamp("outer"), *mirrors], [sk.PointForce((0.0, 0.0), (0, 0, angle / 2 / pi))])
        yield f"{name}, force", Scene(pushed, sk.Displacement((0.0, 0.0)), 1 / 16 / pi, (1e-2, 2e-3))
    cap = sk.SphereSector(1.0, (0.0, 0.7), pi / 3)
    dome = sk.Problem(cap, 0.02, sk.Isotropic(1e6, 0.3, 1.0), [
        sk.Symmetry("start"), sk.Symmetry("end"), sk.Pin(lambda x, y: np.abs(x - 0.7) < 1e-9)], [DOWN])  # fmt: skip
    yield "dome, deflection of the pole", Scene(dome, sk.Displacement((0.0, 0.0)), None, (1e-2, 1e-4))
    yield "dome, M11", Scene(dome, sk.SectionForce("M11", at=(0.5, 0.4)), None, (1e-2,))


def navier(x: float, y: float, side: float = 0.7) -> tuple[float, float, float]:
    """Moments M11, M22 and M12 of a plate 1 by a side with q = D = 1, by his series."""
    a, b = np.meshgrid(pi * np.arange(1, 400, 2), pi * np.arange(1, 400, 2) / side, indexing="ij")
    w = 16 / (a * b * side) / (a**2 + b**2) ** 2
    both = w * np.sin(a * x) * np.sin(b * y)
    return (float((both * (a**2 + NU * b**2)).sum()), float((both * (b**2 + NU * a**2)).sum()),
            float(-(1 - NU) * (w * a * b * np.cos(a * x) * np.cos(b * y)).sum()))  # fmt: skip


def rectangles() -> Iterator[tuple[str, Scene]]:
    """Moments against Navier's series; supports that move, heat, numbers that are zero."""
    surface = sk.Rectangle(1.0, 0.7)
    simple = plate(surface, [HARD], [DOWN])
    for at in ((0.31, 0.22), (0.5, 0.35), (0.77, 0.6), (0.12, 0.08)):
        for component, truth in zip(("M11", "M22", "M12"), navier(*at), strict=True):
            quantity = sk.SectionForce(component, at=at)
            yield f"rectangle, {component} at {at}", Scene(simple, quantity, 0.0 if abs(truth) < 1e-12 else truth)
    yield "rectangle, N11", Scene(simple, sk.SectionForce("N11", at=(0.31, 0.22)), 0.0, (1e-3,))
    moved = plate(surface, [sk.Clamp("left"), sk.Prescribed("right", (0, 0, 0.01))], [])
    for component, at in (("M11", (0.3, 0.35)), ("M12", (0.3, 0.35)), ("M11", (1.0, 0.35))):
        zero = component == "M12" or at[0] == 1.0
        yield f"rectangle with a lifted edge, {component} at {at}", Scene(
            moved, sk.SectionForce(component, at=at), 0.0 if zero else None)  # fmt: skip
    hot = sk.Problem(surface, T, sk.Isotropic(1e7, NU, 1.0, expansion=1e-5), [sk.Clamp("left")], [sk.Temperature(10.0)])
    yield "hot rectangle, stretch", Scene(hot, sk.Displacement((1.0, 0.35), (1, 0, 0)), None)
    yield "hot rectangle, drift of the axis", Scene(hot, sk.Displacement((1.0, 0.35), (0, 1, 0)), 0.0)


def scenes() -> dict[str, Scene]:
    return dict(pair for part in (corners, holes, shells, poles, rectangles) for pair in part())


def truth_of(scene: Scene) -> float:
    if scene.truth is not None:
        return scene.truth
    finer = sk.adapt(scene.problem, scene.quantity, min(scene.rtols) / 10, max_dofs=60_000, **scene.more)
    return finer.corrected


def measured(name: str, scene: Scene) -> Iterator[list[Any]]:
    truth = truth_of(scene)
    for rtol in scene.rtols:
        begun = time.perf_counter()
        found = sk.adapt(scene.problem, scene.quantity, rtol, max_dofs=60_000, **scene.more)
        error, size = abs(found.value - truth), abs(truth) or found.error_bar or 1.0
        yield [name, f"{rtol:.0e}", found.status.name.lower() + (", zero" if found.is_zero else ""), len(found.levels),
               found.solution.system.n_dofs, f"{found.error_bar / size:.1e}", f"{error / size:.1e}",
               f"{min(found.error_bar / max(error, 1e-300), 999):.2f}", "own" if scene.truth is None else "",
               f"{time.perf_counter() - begun:.1f}"]  # fmt: skip


HEAD = ["number", "rtol", "outcome", "meshes", "coordinates", "bar", "true error", "bar / error", "truth", "seconds"]


def main(part: str = "") -> None:
    warnings.simplefilter("ignore", sk.OutOfDepth)
    rows = []
    for name, scene in scenes().items():
        if part in name:
            for row in measured(name, scene):
                rows.append(row)
                print(*row, sep=" | ", flush=True)
    if not part:
        with OUT.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([HEAD, *rows])
    print(f"{len(rows)} runs, {sum(row[2].startswith('reached') for row in rows)} reached")
    for what, are_zero in (("zeros", True), ("others", False)):
        chosen = [row for row in rows if ("zero" in row[2]) == are_zero]
        values, first = np.array([float(row[7]) for row in chosen]), np.array([row[3] == 1 for row in chosen], bool)
        least = [values[on].min(initial=np.inf) for on in (first, ~first)]
        print(f"{what}: {len(chosen)}, bar / error: median {np.median(values):.2f}, least {least[0]:.2f} on first meshes "
              f"and {least[1]:.2f} on later ones, above 3 in {(values > 3).sum()}")  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])
