"""What rounding leaves of small elements, thin sections and small loads: the table of docs/decisions/0018-rounding.rst.

From the folder of the repository, in a minute:

    .venv/bin/python docs/measure/rounding.py

Each row is computed twice: with products by the strains of elements, and with those of the assembled entries.
"""

import warnings
from collections.abc import Callable

import numpy as np
from skfem import MeshQuad
from tables import write

import skancf as sk
from skancf.linear import BlockMatrix
from skancf.system.system import System

STEEL = sk.Isotropic(210e9, 0.3, 7850.0)
PLATE = sk.Rectangle(1.5, 0.6)


def of_entries(system: System) -> System:
    """The same system, whose stiffness is applied by its assembled entries."""
    whole = system.stiffness()
    vars(system)["_stiffness"] = BlockMatrix(whole.pattern, whole.values)
    return system


def found(number: Callable[[System], float], system: System) -> tuple[float, str]:
    """A number, and the first warning or error."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            value = number(system)
        except sk.SkancfError as error:
            return np.nan, type(error).__name__
    return value, "warning" if said else ""


def row(name: str, size: str, make: Callable[[], System], number: Callable[[System], float], right: float) -> list[str]:
    out = [name, size]
    for system in (make(), of_entries(make())):
        value, said = found(number, system)
        off = "" if np.isnan(value) else f"{abs(value / right - 1):.0e}"
        out += [", ".join(part for part in (off, said) if part)]
    return out


def slivers(ratio: float) -> Callable[[], System]:
    """A clamped plate with one row of elements so many times as long as wide."""
    lines = np.sort([*np.linspace(0, 0.6, 7), 0.3 + 0.25 / ratio])
    mesh = MeshQuad.init_tensor(np.linspace(0, 1.5, 7), lines)
    return lambda: sk.Problem(PLATE, 0.006, STEEL, [sk.Clamp("boundary")], [sk.SurfaceLoad((0, 0, -100.0))]).on(
        mesh, theory="kirchhoff")  # fmt: skip


def corner(halvings: int) -> Callable[[], System]:
    """A plate with a free corner that is halved so many times."""
    mesh = sk.meshes.quadtree(sk.meshes.uniform(PLATE, 5, 2), PLATE)
    for _ in range(halvings):
        there = np.flatnonzero((np.abs(mesh.p - [[1.5], [0.6]]) < 1e-12).all(axis=0))
        mesh = mesh.refined(np.flatnonzero(np.isin(mesh.t, there).any(axis=0)))
    problem = sk.Problem(PLATE, 0.006, STEEL, [sk.Clamp("left")], [sk.SurfaceLoad((0, 0, -100.0))])
    return lambda: problem.on(mesh, theory="kirchhoff")


def strip(theory: str, slenderness: float) -> Callable[[], System]:
    surface = sk.Rectangle(1.0, 0.1)
    problem = sk.Problem(surface, slenderness, sk.Isotropic(1e10, 0.0, 1000.0), [sk.Clamp("left")], [])
    return lambda: problem.on(sk.meshes.uniform(surface, 16, 2), theory=theory)


def pressed(theory: str, load: float) -> Callable[[], System]:
    """A simply supported plate, pressed by a part of its critical load."""
    surface, D = sk.Rectangle(0.4, 0.2), 210e9 * 0.002**3 / 12 / 0.91
    critical = 4 * np.pi**2 * D / 0.2**2
    supports = [sk.Roller("boundary"), sk.Roller("left", direction=(1, 0, 0)), sk.Roller("bottom", direction=(0, 1, 0))]
    problem = sk.Problem(surface, 0.002, STEEL, supports, [sk.EdgeLoad("right", (-critical * load, 0, 0))])
    return lambda: problem.on(sk.meshes.uniform(surface, 12, 6), theory=theory)


def frequency(system: System) -> float:
    return float(sk.modes(system, 1).frequencies[0])


def deflection(system: System) -> float:
    return float(sk.solve_linear(system).displacement((0.7, 0.3))[2])


def reaction(system: System) -> float:
    return float(sk.solve_linear(system).reactions()[2])


def main() -> None:
    rows = []
    for ratio in (500.0, 5e3, 5e4, 1e6):
        right = [number(slivers(50.0)()) for number in (frequency, deflection)]
        rows += [row("one row of slivers: frequency", f"1 : {ratio:g}", slivers(ratio), frequency, right[0]),
                 row("deflection", f"1 : {ratio:g}", slivers(ratio), deflection, right[1])]  # fmt: skip
    for halvings in (8, 13, 18):
        right = [frequency(corner(4)()), 100.0 * 0.9]
        rows += [row("free corner: frequency", f"h/L = 2^-{halvings}", corner(halvings), frequency, right[0]),
                 row("sum of reactions", f"h/L = 2^-{halvings}", corner(halvings), reaction, right[1])]  # fmt: skip
    for theory, sizes in (("kirchhoff", (1e-3, 1e-5, 1e-7)), ("full", (1e-3, 1e-5, 1e-6, 1e-7))):
        right = frequency(strip(theory, 1e-2)()) / 1e-2
        rows += [row(f"strip, {theory}: frequency", f"t/L = {t:g}", strip(theory, t), frequency, right * t) for t in sizes]
    for theory in ("kirchhoff", "full"):
        right = sk.buckling(pressed(theory, 1.0)(), 1).load_factors[0]
        rows += [
            row(f"buckling, {theory}", f"load {load:g} of the critical one", pressed(theory, load),
                lambda system: float(sk.buckling(system, 1).load_factors[0]), right / load)
            for load in (1e-6, 1e-12, 1e-20)
        ]  # fmt: skip
    write("rounding.csv", "number; where; error, by strains; error, by entries", rows)


if __name__ == "__main__":
    main()
