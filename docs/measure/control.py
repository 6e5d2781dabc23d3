"""Does the step control reach the asked error? Motions of several kinds, both conserving and damping rule.

    python docs/measure/control.py

Writes docs/decisions/control.csv. The error is the mass-weighted root mean square of positions against a run some thirty
times as accurate, over the largest displacement plus the thickness.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import skancf as sk
from skancf.assembly.system import System

OUT = Path(__file__).parents[1] / "decisions" / "control.csv"


def motions() -> Iterator[tuple[str, sk.Problem, tuple[int, int], float, dict]]:
    strip, soft = sk.Rectangle(1.0, 0.3), sk.Isotropic(1e6, 0.3, 1e3)
    for name, size, history in (("smooth", 0.5, lambda t: np.sin(3 * t) ** 2), ("sudden", 0.2, None)):
        load = sk.EdgeLoad("right", (0, 0, size), history=history)
        yield f"cantilever, {name} load", sk.Problem(strip, 0.02, soft, [sk.Clamp("left")], [load]), (6, 2), 1.5, {}
    cloth = sk.Problem(sk.Rectangle(0.6, 0.3), 0.01, sk.Isotropic(1e5, 0.3, 7810), [sk.Pin((0, 0))], [sk.Gravity()])
    yield "plate pendulum", cloth, (4, 2), 0.5, {}
    corners = sk.Problem(
        sk.Rectangle(1, 1), 0.05, sk.Isotropic(0.2e6, 0.0, 2000), [sk.Pin("corners")],
        [sk.PointForce((0.5, 0.5), (0, 0, -20))],
    )  # fmt: skip
    yield "plate on four corners", corners, (6, 6), 0.5, {}
    free = sk.Problem(sk.Rectangle(1, 0.5), 0.02, soft)
    yield "tumbling plate", free, (4, 2), 1.0, {"velocity": sk.RigidVelocity((0, 0, 0), (2.0, 6.0, 1.0))}


def size(system: System, change: np.ndarray) -> np.ndarray:
    weights = np.abs(system.shares[:, 0])
    positions = change.reshape(len(change), -1, 4, 3)[:, :, 0]
    return np.sqrt(np.einsum("n,tni->t", weights / weights.sum(), positions**2))


def main() -> None:
    rows = []
    for name, problem, (nx, ny), t_end, options in motions():
        system = problem.on(sk.meshes.uniform(problem.surface, nx, ny), "kirchhoff")
        for rule in (sk.GeneralizedAlpha(0.8), sk.EnergyMomentum()):
            asked = {"rule": rule, "outputs": 41, "progress": False, "balance": None, **options}
            fine = sk.simulate(system, t_end, rtol=3e-6, **asked)
            whole = size(system, fine.q - system.undeformed).max() + problem.section.thickness
            for rtol in (1e-2, 1e-3, 1e-4):
                motion = sk.simulate(system, t_end, rtol=rtol, **asked)
                error = size(system, motion.q - fine.q).max() / whole
                rows.append({"motion": name, "rule": type(rule).__name__, "asked": rtol, "reached": f"{error:.1e}",
                             "reached / asked": f"{error / rtol:.2f}", "steps": len(motion.steps),
                             "iterations per step": f"{motion.iterations / len(motion.steps):.1f}"})  # fmt: skip
                print(*rows[-1].values(), flush=True)
    with OUT.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
