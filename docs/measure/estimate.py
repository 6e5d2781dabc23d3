"""Estimated against true errors on the clamped L-shape, and starts of Newton's method on a hemisphere.

The true error is against the corrected value of an adaptive run to 1e-5, which is right to some 1e-6. Writes
docs/decisions/estimate.csv and starts.csv, and what the smallest elements leave over to docs/theory/adaptive_floor.csv. From
the folder of the repository, in two minutes:

    .venv/bin/python docs/measure/estimate.py
"""

import csv
import warnings
from math import pi, radians
from pathlib import Path
from typing import Any

import numpy as np

import skancf as sk
from skancf.adaptive.enriched import Enriched
from skancf.adaptive.grow import SMALLEST, may_be_quartered
from skancf.adaptive.interpolation import prolongation
from skancf.adaptive.quantities import Quantity
from skancf.adaptive.singular import singular_points, touching
from skancf.adaptive.transfer import transfer
from skancf.meshes import MeshQuadTree
from skancf.solving import Status
from skancf.statics import HalveAndGrow
from skancf.statics.equilibrium import equilibrium

OUT = Path(__file__).resolve().parent.parent / "decisions"
EXTRA = (0, 1, 2, 4, 6)
RHOMBUS = 6.52404165e-4
"""Deflection of its middle, by docs/measure/polygons.py."""
OPENING = [((0.0, 1.0), (0.0, 1.0))]


def plate() -> sk.Problem:
    """The L-shape, clamped all around, with q = D = 1."""
    return sk.Problem(
        surface=sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0)),
        thickness=0.01,
        material=sk.Isotropic(young=12 / 0.01**3, poisson=0.0, density=1.0),
        supports=[sk.Clamp("boundary")],
        loads=[sk.SurfaceLoad((0.0, 0.0, -1.0))],
    )


def quantities() -> dict[str, Quantity]:
    return {
        "strain energy": sk.StrainEnergy(),
        "deflection": sk.Displacement(at=(-0.5, -0.5)),
        "mean moment": sk.SectionForce("M11", within=((-0.125, 0.125), (-0.125, 0.125))),
    }


def difference(state: sk.Solution, quantity: Quantity, extra: int) -> float:
    """What quartering all elements, and those at singular points ``extra`` times more, changes of the quantity."""
    mesh, points = state.system.mesh, singular_points(state.system)
    leaves = mesh.leaves.refined(np.arange(mesh.nelements))
    for _ in range(extra):
        at_points = touching(leaves, points)
        leaves = leaves.refined(at_points[may_be_quartered(leaves, state.system.geometry.surface, SMALLEST / 4)[at_points]])
    with Enriched(state, mesh.regrown(leaves)) as enriched:
        return float(quantity.value(enriched.corrected) - quantity.value(state))


def meshes() -> dict[str, MeshQuadTree]:
    """Uniform ones, and some of an adaptive run."""
    problem = plate()
    coarse = sk.meshes.uniform(problem.surface, 4, 4, openings=OPENING)
    found = {f"uniform {n} x {n}": sk.meshes.quadtree(sk.meshes.uniform(problem.surface, n, n, openings=OPENING))
             for n in (4, 8, 16)}  # fmt: skip
    run = sk.adapt(problem, quantities()["deflection"], rtol=1e-4, mesh=coarse, linear=True)
    return found | {f"adaptive, {level.n_elements} elements": level.mesh for level in run.levels[1:]}


def effectivities() -> list[list[Any]]:
    """Estimated over true error, by quantity, mesh and number of extra refinements."""
    problem, rows = plate(), []
    coarse = sk.meshes.uniform(problem.surface, 4, 4, openings=OPENING)
    on = {name: sk.solve_linear(problem.on(mesh, "kirchhoff")) for name, mesh in meshes().items()}
    for what, quantity in quantities().items():
        limit = sk.adapt(problem, quantity, rtol=1e-5, mesh=coarse, linear=True, max_dofs=40_000).corrected
        for mesh, state in on.items():
            value = quantity.value(state)
            found = [difference(state, quantity, extra) / (limit - value) for extra in EXTRA]
            error = f"{100 * abs(value / limit - 1):.3g}"
            used = sk.goal_estimate(state, quantity).error / (limit - value)
            rows.append([what, mesh, error, *(f"{x:.2f}" for x in found), f"{used:.2f}"])
            print(*rows[-1], sep="  ")
    return rows


def starts() -> list[list[Any]]:
    """Newton iterations on each mesh of an adaptive run, from two starting states."""
    surface = sk.SphereSector(10.0, polar=(radians(18), pi / 2), angle=pi / 2)
    A, B, rows = (pi / 2, 0.0), (pi / 2, pi / 2), []
    for force in (50.0, 100.0, 200.0, 400.0):
        shell = sk.Problem(
            surface=surface,
            thickness=0.04,
            material=sk.Isotropic(6.825e7, 0.3, density=1.0),
            supports=[sk.Symmetry("start"), sk.Symmetry("end"), sk.Prescribed((pi / 2, pi / 4), (None, None, 0.0))],
            loads=[sk.PointForce(A, (force / 2, 0.0, 0.0)), sk.PointForce(B, (0.0, -force / 2, 0.0))],
        )
        quantity = sk.Displacement(at=A, direction=(1.0, 0.0, 0.0))
        run = sk.adapt(shell, quantity, rtol=2e-3, max_levels=8)
        for before, level in zip(run.levels, run.levels[1:], strict=False):
            rows.append([f"{force:g}", level.n_elements, *both(shell, before.mesh, level.mesh)])
            print(*rows[-1], sep="  ")
    return rows


def both(shell: sk.Problem, coarse: MeshQuadTree, fine: MeshQuadTree) -> list[str]:
    """From the equilibrium of the mesh before, and from its correction on the richer mesh, interpolated."""
    state = sk.solve(shell.on(coarse, "kirchhoff")).unwrap()
    system = shell.on(fine, "kirchhoff")
    with Enriched(state) as enriched:
        better = enriched.corrected
    q = (prolongation(better.system.geometry, system.geometry) @ better.q.reshape(-1, 3)).ravel()
    at_supports = system.undeformed + system.prescribed()
    found = []
    for start in (transfer(state, system), sk.Solution(system, q + system.constraints.fixed_part(at_supports - q))):
        result = equilibrium(system, 1.0, control=HalveAndGrow(smallest=0.99), start=start, rtol=1e-5)
        found.append(str(result.iterations) if result.status is Status.CONVERGED else f"none ({result.iterations})")
    return found


def floor() -> list[list[Any]]:
    """An adaptive run beyond what the smallest elements can: a rhombus with hard supports and corners of 145 degrees."""
    supports = [sk.SimpleSupport("boundary", "hard")]
    loads = [sk.SurfaceLoad((0.0, 0.0, 1.0))]
    material, surface = sk.Isotropic(10.92 / 0.01**3, 0.3, 1.0), sk.Parallelogram(1.0, 1.0, radians(35))
    problem = sk.Problem(surface, 0.01, material, supports, loads)
    run = sk.adapt(problem, sk.Displacement((0.5, 0.5)), rtol=1e-6, linear=True, max_dofs=20_000)
    return [[level.n_elements, level.mesh.levels.max(), f"{abs(level.error / level.value):.1e}",
             f"{abs(level.value / RHOMBUS - 1):.1e}"] for level in run.levels]  # fmt: skip


def write(name: str, header: list[str], rows: list[list[Any]]) -> None:
    with (OUT / name).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([header, *rows])


def main() -> None:
    warnings.simplefilter("ignore")
    of_extra = [f"{extra} more" for extra in EXTRA]
    write("estimate.csv", ["quantity", "mesh", "error (%)", *of_extra, "as used"], effectivities())
    header = ["elements", "largest level", "estimated error", "error"]
    write("../theory/adaptive_floor.csv", header, floor())
    write("starts.csv", ["force (N)", "elements", "from the transferred state", "from the better one"], starts())


if __name__ == "__main__":
    main()
