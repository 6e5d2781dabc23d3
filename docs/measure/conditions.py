"""How stiff the product of conditions is to be: passes of linear solves, iterations of Newton's method; the force along a
hinge, and what estimates of errors make of it.

From the folder of the repository, in a minute:

    .venv/bin/python docs/measure/conditions.py
"""

import warnings
from typing import Any

import numpy as np
from tables import write

import skancf as sk
from skancf.linear import ConditionedSolver, DirectSolver, conditioned

RADIUS, WIDTH, YOUNG = 1.0, 0.3, 2e11
STIFFNESSES = (1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
THICKNESSES = (1e-1, 1e-2, 1e-3, 1e-4, 3e-5)
RING = sk.CylinderSector(RADIUS, WIDTH, 2 * np.pi)
USED = conditioned.STIFFNESS


def opposite(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.abs(y - np.pi) < 1e-6


def hinged(thickness: float, force: float, theory: str = "kirchhoff", rods: int = 0) -> sk.system.System:
    """A ring pulled at its hinge, with a skew link across it, perhaps several times."""
    links = [sk.RigidLink((0.0, 0.5), (WIDTH, 2.5))] * rods
    problem = sk.Problem(
        RING, thickness, sk.Isotropic(YOUNG, 0.3, 7800.0), [sk.Clamp(opposite)],
        [sk.EdgeLoad("start", (0.0, -force / WIDTH, 0.0))], conditions=[sk.Hinge("start", "end"), *links],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(RING, 2, 24), theory)


def passes(thickness: float, stiffness: float) -> list[str]:
    """What passes leave of a linear answer, in its mean displacement, and how many there are until nothing changes."""
    system = hinged(thickness, 1.0, rods=2)
    start, mass = system.undeformed, system.mass
    gradient, load = system.conditions.gradient(start), system.external_force(start)
    answers = {}
    for each in (1e3, stiffness):
        conditioned.STIFFNESS = each
        solver = ConditionedSolver(DirectSolver(system.pattern, system.constraints), gradient).factor(system.stiffness())
        zero = np.zeros(gradient.shape[0])
        answers[each] = [solver.solve_both(load, zero, count)[0] for count in (1, 2, 3, None)]
    conditioned.STIFFNESS = USED
    reference = answers[1e3][-1]
    errors = [x - reference for x in answers[stiffness]]
    off = [np.sqrt(e @ (mass @ e) / (reference @ (mass @ reference))) for e in errors]
    return [*(f"{each:.0e}" for each in off[:3]), f"{solver.passes}" if not solver.lost else f"stays at {solver.lost:.0e}"]


def iterations(thickness: float, stiffness: float, theory: str) -> str:
    """Of three load steps to half a radius."""
    conditioned.STIFFNESS = stiffness
    bending = YOUNG * thickness**3 / 12 * WIDTH
    ring = hinged(thickness, 3 * bending / RADIUS**2, theory)
    found = sk.solve(ring, control=sk.HalveAndGrow(first=1 / 3, growth=1.0), relax=False)
    conditioned.STIFFNESS = USED
    return " ".join(str(result.iterations) for _, result in found.attempts) if found.ok else "fails"


SEGMENTS, FINEST = (4, 8, 16), 32


def hinge_force(n: int, theory: str, around: int) -> Any:
    """Along a hinge with a load that varies along it."""
    tube = sk.CylinderSector(RADIUS, 1.0, 2 * np.pi)
    load = sk.EdgeLoad("start", lambda x, y: [0 * x, -np.sin(2 * x) - x, 0.2 * x**2])
    problem = sk.Problem(tube, 0.1, sk.Isotropic(YOUNG, 0.3, 7800.0), [sk.Clamp(opposite)], [load],
                         conditions=[sk.Hinge("start", "end")])  # fmt: skip
    return sk.solve_linear(problem.on(sk.meshes.uniform(tube, n, around), theory)).conditions["hinge"]


def along(found: dict[int, Any], places: int) -> list[float]:
    """Errors of the force per length in the middle half, of means over so many places in each segment."""
    errors, limit = [], found[FINEST]
    for n in SEGMENTS:
        s = (np.arange(n * 64) + 0.5) / (n * 64)
        s = s[(s > 0.25) & (s < 0.75)]
        one, two = (hinge.per_length(s).reshape(-1, places, 3).mean(axis=1) for hinge in (found[n], limit))
        errors.append(np.sqrt(((one - two) ** 2).mean() / (two**2).mean()))
    return errors


def estimated(n: int, theory: str, beside: bool) -> list[str]:
    """The relative error of a corner's displacement under a load that grows along the hinge, and the estimate of it; with
    elements beside one side of the hinge that are half as long."""
    load = sk.EdgeLoad("start", lambda x, y: [0 * x, -1 - x / WIDTH, 0 * x])
    problem = sk.Problem(RING, 0.05, sk.Isotropic(YOUNG, 0.3, 7800.0), [sk.Clamp(opposite)], [load],
                         conditions=[sk.Hinge("start", "end")])  # fmt: skip
    mesh = sk.meshes.quadtree(sk.meshes.uniform(RING, n, 8 * n))
    if beside:
        mesh = mesh.refined(np.flatnonzero(mesh.p[1, mesh.t].mean(axis=0) < 0.8))
    number = sk.Displacement((WIDTH, 0.0), (0, -1, 0))
    state, limit = (sk.solve_linear(problem.on(each, theory)) for each in (mesh, mesh.refined().refined()))
    true = number.value(limit) / number.value(state) - 1
    return [f"{true:.1e}", f"{sk.goal_estimate(state, number).error / number.value(state) / true:.2f}"]


def main() -> None:
    warnings.simplefilter("ignore", sk.OutOfDepth)
    write("conditions_passes.csv", "t / R; stiffness; 1 pass; 2; 3; passes until nothing changes",
          [[f"{t:.0e}", f"{k:.0e}", *passes(t, k)] for t in THICKNESSES for k in STIFFNESSES])  # fmt: skip
    write("conditions_newton.csv", "t / R; theory; " + "; ".join(f"{k:.0e}" for k in STIFFNESSES),
          [[f"{t:.0e}", theory, *(iterations(t, k, theory) for k in STIFFNESSES)]
           for t in THICKNESSES[1:] for theory in ("kirchhoff", "full")])  # fmt: skip
    rows = []
    for theory in ("kirchhoff", "full"):
        for around in ("four times as many", "16"):
            found = {n: hinge_force(n, theory, 16 if around == "16" else 4 * n) for n in (*SEGMENTS, FINEST)}
            for what, places in (("at places", 1), ("means of segments", 64)):
                off = along(found, places)
                rows.append([theory, around, what, *(f"{each:.2g}" for each in off), f"{np.log2(off[1] / off[2]):.2f}"])
    heads = "theory; elements around; force per length; 4 elements along the hinge; 8; 16; order"
    write("conditions_force.csv", heads, rows)
    write("conditions_estimate.csv", "theory; beside the hinge; 2 elements along it: error; estimate / error; "
          "4 elements: error; estimate / error",
          [[theory, "half as long on one side" if beside else "alike", *estimated(2, theory, beside),
            *estimated(4, theory, beside)] for theory in ("kirchhoff", "full") for beside in (False, True)])  # fmt: skip


if __name__ == "__main__":
    main()
