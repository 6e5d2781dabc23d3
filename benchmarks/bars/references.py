"""Computes the right values of the scenes and stores them, with what they are uncertain by, in ``references.json``.

    python -m benchmarks.bars.references [--only TEXT ...]

``adapt`` and its estimates have no part in them: they are formulas, series, one-dimensional Ritz, two membranes for simply
supported polygons, and else values of the same theory on uniform meshes, or on meshes that are graded to given points
without an estimate, extrapolated. About five minutes on one core.
"""

import argparse
import json
import time
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

import skancf as sk
from benchmarks.bars.formulas import FORMULAS, Value
from benchmarks.bars.statement import FOLDER, Goal, Scene, scenes
from benchmarks.bars.two_membranes import Plate
from skancf.adaptive.quantities.quantity import Smooth
from skancf.atomic import replacing

FILE = FOLDER / "references.json"
SMOOTH_ORDERS, POINT_ORDERS = (4, 5, 6, 7, 8), (2, 3, 4, 5, 6)
"""Powers of the element size in the errors of the thin element, and of a force at a point."""
FULL_ORDERS = (2, 4, 6, 8, 10)
LEVELS, TIMES = (4, 6, 8), 4
"""Of graded meshes: how often the elements at the points are quartered, and on how many meshes, all elements quartered
in between."""
LEAST = 1e-9
"""Relative uncertainty that is always there."""
LAYERS, DEGREES = {False: 8, True: 11}, {False: (6, 7), True: (4, 5)}
"""Of polynomials on polygons, without and with a re-entrant corner."""


def romberg(values: list[float], orders: tuple[int, ...]) -> tuple[float, float]:
    """Limit of values on meshes of halved size, and its distance from that without the finest mesh."""
    # Of the columns of the table the one that changes least when the finest mesh is left out.
    rows = [list(values)]
    for n in range(1, len(values)):
        rows.append([b + (b - a) / (2 ** orders[n - 1] - 1) for a, b in zip(rows[-1], rows[-1][1:], strict=False)])
    change, limit = min((abs(row[-1] - row[-2]), row[-1]) for row in rows if len(row) > 1)
    return limit, change


def aitken(a: float, b: float, c: float) -> float:
    """Limit of a sequence whose differences fall geometrically."""
    return c if c - b == b - a else c - (c - b) ** 2 / ((c - b) - (b - a))


def values_on(scene: Scene, quantities: list[Any], mesh: Any) -> np.ndarray:
    """The quantities on a mesh."""
    # The plain element has the same limit, and a cleaner error on fine meshes.
    system = scene.problem.on(mesh, sk.Kirchhoff(assumed=False) if scene.theory == "kirchhoff" else scene.theory)

    @cache
    def state() -> sk.Solution:
        return sk.solve_linear(system) if scene.linear else sk.solve(system, rtol=1e-10).unwrap()

    def value(quantity: Any) -> float:
        if isinstance(quantity, sk.BucklingLoad):
            return float(sk.buckling(system, quantity.number + 1).load_factors[quantity.number])
        if isinstance(quantity, sk.Eigenfrequency):
            rigid = 0 if scene.problem.supports else 6
            found = sk.modes(system, quantity.number + 1 + rigid, state=state() if quantity.loaded else None)
            return float(found.frequencies[quantity.number + rigid])
        if scene.linear and isinstance(quantity, Smooth):
            # The change itself: its sum with the place loses digits.
            rest = sk.Solution(system, system.undeformed, load_factor=state().load_factor, linear=True)
            return float(quantity.value(rest) + quantity.gradient(state()) @ state().change)
        return float(quantity.value(state()))

    return np.array([value(quantity) for quantity in quantities])


def uniform(scene: Scene, asked: list[Goal]) -> list[Value]:
    by = asked[0].by
    (nx, ny, times), along = by["uniform"], by.get("along", "xy")
    counts = [(nx * 2**k if "x" in along else nx, ny * 2**k if "y" in along else ny) for k in range(times)]
    rows = np.array([values_on(scene, [one.quantity for one in asked], scene.mesh(*count)) for count in counts])
    source = "uniform meshes of up to {} x {}, extrapolated".format(*counts[-1])
    return [(*limit_of(scene, one.quantity, values.tolist()), source) for one, values in zip(asked, rows.T, strict=True)]


def limit_of(scene: Scene, quantity: Any, values: list[float]) -> tuple[float, float]:
    """Limit of values on uniform meshes, and its uncertainty; the order that they show themselves has a say."""
    told(values)
    at_point = isinstance(quantity, sk.SectionForce) and quantity.at is not None
    orders = FULL_ORDERS if scene.theory == "full" else POINT_ORDERS if at_point else SMOOTH_ORDERS
    limit, doubt = romberg(values, orders[: len(values) - 1])
    free, last = aitken(*values[-3:]), abs(values[-1] - values[-2])
    if abs(free - values[-1]) < last:
        doubt = max(doubt, min(abs(free - limit), last) / 4)
    return limit, doubt


def graded(scene: Scene, asked: list[Goal]) -> list[Value]:
    """For each fineness the limit in the number of levels; of these the limit in the fineness."""
    by, limits = asked[0].by, []
    for times in range(TIMES):
        meshes = [graded_mesh(scene, by, levels, times) for levels in LEVELS]
        rows = np.array([values_on(scene, [one.quantity for one in asked], mesh) for mesh in meshes])
        limits.append([aitken(*values) for values in rows.T.tolist()])
    source = f"meshes graded to {len(by['points'])} point(s), extrapolated"
    out = []
    for values in np.transpose(limits).tolist():
        told(values)
        out.append((*romberg(values, SMOOTH_ORDERS), source))
    return out


def graded_mesh(scene: Scene, by: dict[str, Any], levels: int, times: int) -> Any:
    """Elements at the points quartered ``levels`` times, then all of them ``times`` times."""
    mesh = sk.meshes.quadtree(scene.mesh(*by["graded"]), scene.problem.surface)
    for _ in range(levels):
        corners = mesh.p[:, mesh.t]
        near = np.zeros(mesh.nelements, bool)
        for point in np.array(by["points"], float):
            near |= (np.hypot(*(corners - point[:, None, None])) < 1e-12).any(axis=0)
        mesh = mesh.refined(np.flatnonzero(near))
    for _ in range(times):
        mesh = mesh.refined()
    return mesh


def polygon(scene: Scene, asked: list[Goal]) -> list[Value]:
    (x, y), corner = asked[0].by["polygon"], asked[0].by.get("corner", False)
    surface, found = scene.problem.surface, []

    def value(plate: Plate, quantity: Any) -> float:
        match quantity:
            case sk.Displacement():
                return plate.deflection(surface.position(*np.array(quantity.at)[:, None])[:2, 0])
            case sk.StrainEnergy():
                return plate.energy
        return 10 * plate.eigenvalue() / (2 * np.pi)

    for degree in DEGREES[corner]:
        plate = Plate(x, y, corner, surface.position, LAYERS[corner], degree)
        found.append([value(plate, one.quantity) for one in asked])
    source = f"two membranes, polynomials of degree {DEGREES[corner][1]}"
    return [(two, abs(two - one), source) for one, two in zip(*found, strict=True)]


def formula(scene: Scene, asked: list[Goal]) -> list[Value]:
    return [FORMULAS[one.by["formula"][0]](*one.by["formula"][1:]) for one in asked]


def given(scene: Scene, asked: list[Goal]) -> list[Value]:
    return [(one.by["value"], 0.0, one.by["source"]) for one in asked]


def zero(scene: Scene, asked: list[Goal]) -> list[Value]:
    return [(0.0, 0.0, one.by["zero"]) for one in asked]


WAYS: dict[str, Callable[[Scene, list[Goal]], list[Value]]] = {
    "formula": formula, "polygon": polygon, "uniform": uniform, "graded": graded, "value": given, "zero": zero,
}  # fmt: skip


def told(values: list[float]) -> None:
    print("    " + " ".join(f"{v:.10g}" for v in values), flush=True)


def found(only: list[str]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for scene in scenes():
        wanted = [one for one in scene.asked if not only or any(text in f"{scene.name}: {one.name}" for text in only)]
        for way, find in WAYS.items():
            if not (asked := [one for one in wanted if way in one.by]):
                continue
            begun = time.perf_counter()
            values = find(scene, asked)
            print(f"{scene.name}: {way}, {time.perf_counter() - begun:.1f} s", flush=True)
            for one, (value, doubt, source) in zip(asked, values, strict=True):
                doubt = max(float(doubt), LEAST * abs(value))
                part = doubt / abs(value) if value else 0.0
                print(f"  {one.name} = {value:.10g} +- {part:.1e}", flush=True)
                yield scene.name, one.name, {"value": float(value), "uncertainty": doubt, "source": source}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="TEXT", help="scenes and quantities with this in their names"
    )
    only = parser.parse_args().only
    warnings.simplefilter("ignore", sk.OutOfDepth)
    stored: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() and only else {}
    for scene, asked, value in found(only):
        stored.setdefault(scene, {})[asked] = value
        with replacing(FILE) as part:
            part.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
