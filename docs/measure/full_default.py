"""What adaptive runs of theory `full` cost by the marking, and edge moments: docs/decisions/full_default.csv and
full_moments.csv.

Cost is counted in nodal coordinates of all systems that are solved, those of estimates too. From the folder of the
repository, in a minute:

    .venv/bin/python docs/measure/full_default.py
"""

import time
import warnings
from math import pi
from typing import Any

import numpy as np
from tables import write

import skancf as sk
from skancf.adaptive.refined import Refined

MATERIAL, DOWN = sk.Isotropic(1e7, 0.3, 1.0), sk.SurfaceLoad((0.0, 0.0, -1.0))
SQUARE, L_SHAPE = sk.Rectangle(1.0, 1.0), sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
ROOF = sk.CylinderSector(1.0, 1.0, 0.8, start=pi / 2 - 0.4)
MARKINGS = {"Doerfler(0.9)": sk.Doerfler(0.9), "Even(0.65)": sk.Even(0.65)}
MOST = 15_000
RITZ = 0.04935
"""Edge moment over q a^2 of the clamped square, a/h = 10."""


def plate(surface: Any, thickness: float, support: Any) -> sk.Problem:
    return sk.Problem(surface, thickness, MATERIAL, [support], [DOWN])


def cases() -> dict[str, tuple[sk.Problem, Any, Any, float]]:
    middle, clamp = sk.Displacement((0.5, 0.5), (0, 0, -1)), sk.Clamp("boundary")
    corner = sk.meshes.uniform(L_SHAPE, 4, 4, openings=[((0.0, 1.0), (-1.0, 0.0))])
    return {
        "clamped square, a/h = 10": (plate(SQUARE, 0.1, clamp), middle, None, 1e-3),
        "clamped square, a/h = 25": (plate(SQUARE, 0.04, clamp), middle, None, 1e-3),
        "hard square, a/h = 7": (plate(SQUARE, 1 / 7, sk.SimpleSupport("boundary", "hard")), middle, None, 1e-3),
        "soft square, a/h = 20": (plate(SQUARE, 0.05, sk.SimpleSupport("boundary", "soft")), middle, None, 1e-3),
        "clamped L, deflection": (
            plate(L_SHAPE, 0.1, clamp), sk.Displacement((-0.5, 0.5), (0, 0, -1)), corner, 3e-3,
        ),
        "clamped L, energy": (plate(L_SHAPE, 0.1, clamp), sk.StrainEnergy(), corner, 3e-3),
        "roof, R/h = 50": (plate(ROOF, 0.02, clamp), sk.Displacement((0.5, pi / 2), (0, 0, -1)), None, 1e-3),
    }  # fmt: skip


def run(problem: sk.Problem, quantity: Any, mesh: Any, rtol: float, marking: Any) -> tuple[sk.AdaptiveResult, int, float]:
    """The result, the nodal coordinates of all systems, and seconds."""
    solved, begin = [], Refined.__init__

    def counted(self: Refined, *arguments: Any, **options: Any) -> None:
        begin(self, *arguments, **options)
        solved.append(self.system.n_dofs)

    Refined.__init__ = counted  # type: ignore[method-assign]
    begun = time.perf_counter()
    try:
        result = sk.adapt(problem, quantity, rtol, theory="full", linear=True, mesh=mesh, max_dofs=MOST, marking=marking)
    finally:
        Refined.__init__ = begin  # type: ignore[method-assign]
    return result, sum(solved) + sum(level.n_dofs for level in result.levels), time.perf_counter() - begun


def costs() -> list[list[Any]]:
    rows = []
    for name, (problem, quantity, mesh, rtol) in cases().items():
        for marking, policy in MARKINGS.items():
            result, spent, seconds = run(problem, quantity, mesh, rtol, policy)
            rows.append([name, marking, f"{rtol:g}", "yes" if result.ok else "no",
                         f"{result.error_bar / abs(result.value):.1e}", len(result.levels), result.levels[-1].n_dofs,
                         round(spent, -3), f"{seconds:.1f}"])  # fmt: skip
    return rows


def moments() -> list[list[Any]]:
    """Per cent of the Ritz value: as the elements have it, and recovered."""
    rows = []
    for n in (8, 16, 32, 64):
        state = sk.solve_linear(plate(SQUARE, 0.1, sk.Clamp("boundary")).on(sk.meshes.uniform(SQUARE, n, n), "full"))
        node = int(np.argmin(np.abs(state.system.mesh.p - np.array([[0.0], [0.5]])).sum(axis=0)))
        at = [element for element in range(n * n) if node in state.system.mesh.t[:, element]]
        corner = [int(np.argmax(state.system.mesh.t[:, element] == node)) for element in at]
        own = state.section_forces()[at, 3, corner].mean()
        rows.append([n, *(f"{100 * (value / RITZ - 1):.1f}" for value in (own, state.nodal_section_forces()[node, 3]))])
    return rows


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    write("full_moments.csv", "elements a side; elements' own (%); recovered (%)", moments())
    write("full_default.csv", "problem; marking; rtol; reached; bar / value; meshes; coordinates of the last; of all "
          "systems; seconds", costs())  # fmt: skip
