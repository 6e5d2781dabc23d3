"""Newton iterations by the way a load step starts: the table of decision 0005.

From the folder of the repository, in half a minute:

    .venv/bin/python docs/measure/load_steps.py

It writes docs/decisions/load_steps.csv. Counted are all iterations, those of failed steps too; solves that wander before
they fail feel rounding, so that counts differ a little between machines.
"""

import csv
from collections.abc import Callable
from math import pi, radians
from pathlib import Path

import skancf as sk
from skancf.linear import DirectSolver
from skancf.statics import newton
from skancf.system.system import System

TABLE = Path(__file__).resolve().parent.parent / "decisions" / "load_steps.csv"


def hemisphere() -> System:
    """With a hole of 18 degrees, four radial forces (Sze, Liu and Lo 2004, 3.4), a quarter of it."""
    surface = sk.SphereSector(10.0, (radians(18), pi / 2), pi / 2)
    shell = sk.Problem(
        surface, 0.04, sk.Isotropic(6.825e7, 0.3, 1.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Prescribed((pi / 2, 0.0), (None, None, 0.0))],
        [sk.PointForce((pi / 2, 0.0), (200.0, 0, 0)), sk.PointForce((pi / 2, pi / 2), (0, -200.0, 0))],
    )  # fmt: skip
    return shell.on(sk.meshes.uniform(surface, 16, 16), "kirchhoff")


def roll_up() -> System:
    """A strip bent into a circle by a moment at its end (3.2)."""
    moment = 2 * pi * 1.2e6 * 0.1**3 / 12 / 12.0
    strip = sk.Problem(sk.Rectangle(12.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0),
                       [sk.Clamp("left")], [sk.EdgeMoment("right", (0, -moment, 0))])  # fmt: skip
    return strip.on(sk.meshes.uniform(strip.surface, 16, 1), "kirchhoff")


def end_shear() -> System:
    """A strip under a force at its end (3.1)."""
    strip = sk.Problem(sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0),
                       [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 4.0))])  # fmt: skip
    return strip.on(sk.meshes.uniform(strip.surface, 16, 1), "kirchhoff")


def annulus() -> System:
    """A slit annulus lifted along the slit (3.3)."""
    surface = sk.AnnulusSector(6.0, 10.0, 2 * pi)
    plate = sk.Problem(surface, 0.03, sk.Isotropic(21e6, 0.0, 1.0), [sk.Clamp("end")],
                       [sk.EdgeLoad("start", (0, 0, 0.8))])  # fmt: skip
    return plate.on(sk.meshes.uniform(surface, 4, 24), "kirchhoff")


def cylinder() -> System:
    """A tube with open ends, pulled apart by two forces in the middle (3.5), an eighth of it."""
    surface = sk.CylinderSector(4.953, 5.175, pi / 2, start=0.0)
    shell = sk.Problem(
        surface, 0.094, sk.Isotropic(10.5e6, 0.3125, 1.0),
        [sk.Symmetry("left"), sk.Symmetry("start"), sk.Symmetry("end")],
        [sk.PointForce((0.0, pi / 2), (0, 0, 40e3 / 4))],
    )  # fmt: skip
    return shell.on(sk.meshes.uniform(surface, 16, 16), "kirchhoff")


CASES: dict[str, Callable[[], System]] = {
    "hemisphere, 16 x 16": hemisphere, "roll-up, 16 x 1": roll_up, "slit annulus, 4 x 24": annulus,
    "end shear, 16 x 1": end_shear, "open cylinder, 16 x 16": cylinder,
}  # fmt: skip


def extrapolated(system: System) -> str:
    """The loop of ``solve`` with steps that start from a guess, linear in the load through the last two equilibria."""
    control, count, accepted = sk.HalveAndGrow(), 0, 0
    q, last, done, step = system.undeformed, None, 0.0, 1.0
    with DirectSolver(system.pattern, system.constraints) as solver:
        while done < 1.0 and step >= control.smallest:
            aim = min(1.0, done + step)
            guess = q if last is None else q + (aim - done) / (done - last[0]) * (q - last[1])
            result = newton(system, guess, solver, load_factor=aim)
            count += len(result.residual_norms)
            if result.ok:
                last, q, done, accepted = (done, q), result.q, aim, accepted + 1
            step = control.next_step(step, result)
    return f"{count} in {accepted}" if done == 1.0 else f"stops at {done:.3g} after {count}"


def stepped(system: System, mixed: bool) -> str:
    """By ``solve``."""
    result = sk.solve(system, mixed=mixed)
    if result.status is not sk.Status.CONVERGED:
        return f"stops at {result.solution.load_factor:.3g} after {result.iterations}"
    return f"{result.iterations} in {len(result.path) - 1}"


def followed(system: System) -> str:
    """By ``trace``."""
    path = sk.trace(system, until=1.0).unwrap()
    return f"{path.iterations} in {len(path.solutions) - 1}"


def main() -> None:
    head = ["case", "from the last equilibrium", "from an extrapolated guess", "plain Newton", "trace"]
    rows = []
    for name, make in CASES.items():
        system = make()
        rows.append([name, stepped(system, True), extrapolated(system), stepped(system, False), followed(system)])
        print(*rows[-1], sep=" | ", flush=True)
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main()
