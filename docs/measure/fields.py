"""Sections as fields: the tables of decision 0029.

From the folder of the repository, in a minute on one core:

    .venv/bin/python docs/measure/fields.py

It writes docs/decisions/fields_*.csv. Times are the best of many, in processor time.
"""

import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
import tables

import skancf as sk

L, B, H, E, RHO = 1.0, 0.1, 0.01, 2e11, 7800.0
STRIP = sk.Rectangle(L, B)
NO_POISSON = sk.Isotropic(E, 0.0, RHO)
TAPERS = {0.25: (0.41165264, 2 / 3), 0.5: (0.54517744, 1.0), 0.75: (0.84158663, 2.0)}
"""w E I0 / P L^3 and w E I0 / M L^2 of strips h0 (1 - a x / L)."""
SQUARES = {0.5: 0.00209968, 1.0: 0.00123662}
"""w D0 / q a^4 in the centre of simply supported squares h0 (1 + l x / a), nu = 0.3, by sine series of six digits."""
STRETCH = 1e-6


def strip(n: int, load: Any, thickness: Any = H, zones: Any = (), theory: Any = "kirchhoff") -> sk.Solution:
    problem = sk.Problem(STRIP, thickness, NO_POISSON, [sk.Clamp("left")], [load], zones=zones)
    return sk.solve_linear(problem.on(sk.meshes.quadtree(sk.meshes.with_lines(STRIP, n, 1, zones), STRIP), theory))


def tapers() -> list[list[Any]]:
    rows: list[list[Any]] = []
    force, moment = sk.EdgeLoad("right", (0, 0, 1.0)), sk.EdgeMoment("right", (0, -1.0, 0))
    for share, both in TAPERS.items():
        for name, load, exact in zip(("force", "moment"), (force, moment), both, strict=True):
            found = [strip(n, load, lambda x, y, a=share: H * (1 - a * x / L)).displacement((L, B / 2))[2] * E * H**3 / 12
                     for n in (4, 8, 16)]  # fmt: skip
            rows.append([f"strip, a = {share:g}, end {name}", f"{exact:.8f}", f"{found[-1]:.8f}", *errors(found, exact)])
    plate, D = sk.Rectangle(1.0, 1.0), E * H**3 / 12 / (1 - 0.3**2)
    for growth, exact in SQUARES.items():
        problem = sk.Problem(plate, lambda x, y, l=growth: H * (1 + l * x), sk.Isotropic(E, 0.3, RHO),
                             [sk.SimpleSupport("boundary", kind="hard")], [sk.SurfaceLoad((0, 0, 1.0))])  # fmt: skip
        found = [sk.solve_linear(problem.on(sk.meshes.uniform(plate, n, n), "kirchhoff")).displacement((0.5, 0.5))[2] * D
                 for n in (4, 8, 16)]  # fmt: skip
        rows.append([f"square, l = {growth:g}, uniform load", f"{exact:.8f}", f"{found[-1]:.8f}", *errors(found, exact)])
    return rows


def errors(found: list[float], exact: float) -> list[str]:
    return [f"{value / exact - 1:.1e}" for value in found]


def jumps() -> list[list[Any]]:
    """A strip whose second half is twice as thick, pulled; and with a doubler on one side, bent."""
    rows: list[list[Any]] = []
    cases = {
        "pulled": (sk.EdgeLoad("right", (E * H * STRETCH, 0, 0)), 0.0, (1.0, 0, 0), 0.75 * STRETCH),
        "bent, one side": (sk.EdgeMoment("right", (0, -1.0, 0)), H / 2, (0, 0, 1.0), (3 / 8 + 1 / 64) / (E * H**3 / 12)),
    }
    for name, (load, offset, along, exact) in cases.items():
        zone = sk.Zone("thick", ((0.5, L), (0.0, B)), thickness=2 * H, offset=offset)
        end = sk.Displacement((L, B / 2), along)
        for theory in ("full", sk.theories.Kirchhoff(assumed=False), "kirchhoff"):
            said = theory if isinstance(theory, str) else "kirchhoff, not assumed"
            for n in (4, 8, 16, 32, 64):
                seen = sk.goal_estimate(strip(n, load, zones=[zone], theory=theory), end)
                error = exact - seen.value
                rows.append([name, said, n, f"{error / exact:.1e}", f"{seen.error / error:.2f}", f"{seen.bar / error:.2f}"])
    return rows


def refined() -> list[list[Any]]:
    """Unknowns and errors in theory full on uniform meshes, with rows of thin elements beside the lines, and adapted: of the
    strip that is pulled, and of a square sheet with a doubler in its middle, against a finer mesh with a thinner row."""
    half = sk.Zone("thick", ((0.5, L), (0.0, B)), thickness=2 * H)
    bar = sk.Problem(STRIP, H, NO_POISSON, [sk.Clamp("left")], [sk.EdgeLoad("right", (E * H * STRETCH, 0, 0))], zones=[half])
    plate = sk.Rectangle(1.0, 1.0)
    patch = sk.Zone("doubler", ((0.25, 0.75), (0.25, 0.75)), thickness=2 * H)
    sheet = sk.Problem(plate, H, sk.Isotropic(E, 0.3, RHO), [sk.Clamp("left")], [sk.EdgeLoad("right", (1e3, 0, 0))],
                       zones=[patch])  # fmt: skip

    def uniform(problem: sk.Problem, end: Any, n: int, m: int, beside: float | None = None) -> tuple[float, int]:
        mesh = sk.meshes.with_lines(problem.surface, n, m, problem.zones, beside=beside)  # type: ignore[arg-type]
        system = problem.on(mesh, "full")
        return end.value(sk.solve_linear(system)), system.n_dofs

    of_bar, of_sheet = (sk.Displacement((1.0, y), (1.0, 0, 0)) for y in (B / 2, 0.5))
    exact, rows = uniform(sheet, of_sheet, 48, 48, H / 4)[0], []
    for name, problem, end, value, meshes in (("strip", bar, of_bar, 0.75 * STRETCH, ((8, 1), (32, 3), (128, 12))),
                                              ("sheet", sheet, of_sheet, exact, ((8, 8), (16, 16), (32, 32)))):  # fmt: skip
        for n, m in meshes:
            found, unknowns = uniform(problem, end, n, m)
            rows.append([name, f"{n} x {m}", unknowns, f"{1 - found / value:.1e}", ""])
        for n, m in meshes[:2]:
            found, unknowns = uniform(problem, end, n, m, H / 2)
            rows.append([name, f"{n} x {m}, row of t / 2", unknowns, f"{1 - found / value:.1e}", ""])
        for rtol in (5e-3, 1e-3):
            adapted = sk.adapt(problem, end, rtol=rtol, theory="full", linear=True)
            rows.append([name, f"adapted to {rtol:g}", adapted.solution.system.n_dofs, f"{1 - adapted.value / value:.1e}",
                         f"{adapted.error_bar / value:.1e}"])  # fmt: skip
    return rows


def costs() -> list[list[Any]]:
    """Of 32 x 32 elements, in theory kirchhoff and full: a plate, a constant function, a taper along x and in both."""
    plate = sk.Rectangle(1.0, 1.0)
    given = {
        "a number": H, "a constant function": lambda x, y: H, "a taper along x": lambda x, y: H * (1 + x),
        "a taper along x and y": lambda x, y: H * (1 + x) * (1 + y),
    }  # fmt: skip
    rows: list[list[Any]] = []
    mesh = sk.meshes.uniform(plate, 32, 32)
    for theory in ("kirchhoff", "full"):
        for name, thickness in given.items():
            problem = sk.Problem(plate, thickness, sk.Isotropic(E, 0.3, RHO))
            system = problem.on(mesh, theory)
            made = fastest(lambda problem=problem, theory=theory: problem.on(mesh, theory), 5)
            q = system.undeformed + 1e-4 * np.random.default_rng(0).normal(size=system.n_dofs)
            times = [fastest(lambda f=f, q=q: f(q), 20) for f in (system.internal_force, system.tangent)]
            rows.append([theory, name, len(system.assembly.sections.law), f"{1e3 * made:.0f}",
                         *(f"{1e6 * t / mesh.nelements:.1f}" for t in times)])  # fmt: skip
    return rows


def fastest(function: Callable[[], Any], times: int) -> float:
    best = np.inf
    for _ in range(times):
        start = time.process_time()
        function()
        best = min(best, time.process_time() - start)
    return float(best)


def main() -> None:
    warnings.simplefilter("ignore", sk.OutOfDepth)
    tables.write("fields_tapers.csv", "plate; exact; 16 elements; error on 4; on 8; on 16", tapers())
    tables.write("fields_jumps.csv", "strip; theory; elements; error; estimate over it; bar over it", jumps())
    tables.write("fields_refined.csv", "plate; mesh; unknowns; error; error bar", refined())
    tables.write("fields_costs.csv", "theory; thickness; classes; made (ms); a force (us per element); a tangent", costs())


if __name__ == "__main__":
    main()
