"""A free plate that tumbles and bends for 20 000 steps: what the energy-momentum rule without dissipation keeps;
docs/theory/tumbling.csv.

From the folder of the repository; some two minutes of a processor for each of the two theories:

    .venv/bin/python docs/measure/tumbling.py

Names of theories run these only, a number before them other than 20 000 steps. The table is written anew after every
tenth of a run. ``newton`` instead makes docs/theory/tumbling_newton.csv, from 2000 steps with other tolerances of Newton's
method.
"""

import csv
import sys
from pathlib import Path

import numpy as np

import skancf as sk
from skancf.dynamics.initial import initial_velocity

THEORY = Path(__file__).resolve().parent.parent / "theory"
FILE = THEORY / "tumbling.csv"
SURFACE = sk.Rectangle(0.3, 0.2, origin=(-0.15, -0.1))
SPIN, BENDING = sk.RigidVelocity(velocity=(1.0, 0.5, 2.0), spin=(20.0, 30.0, 50.0)), 20.0
STEP, NEWTON, STEPS, PARTS = 1e-4, 1e-12, 20_000, 10
HEAD = ["theory", "steps", "turns", "strain energy at most", "energy", "energy per 1e5 steps", "linear momentum",
        "angular momentum", "angular momentum per 1e5 steps", "Newton iterations per step"]  # fmt: skip


def thrown(theory: str) -> sk.Solution:
    """A steel plate of 300 x 200 x 4 mm on 3 x 2 elements that begins to turn about an oblique axis and to bend."""
    problem = sk.Problem(SURFACE, 0.004, sk.Isotropic(206e9, 0.3, density=7800.0))
    system = problem.on(sk.meshes.uniform(SURFACE, 3, 2), theory)

    def bending(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.stack([0 * x, 0 * x, BENDING * ((x / 0.15) ** 2 - 1 / 3)])

    q = system.undeformed
    return sk.Solution(system, q, SPIN.at(q) + initial_velocity(system, q, bending), 0.0)


class Record:
    """Books of the parts of a run, one after the other."""

    def __init__(self, theory: str):
        self.theory, self.iterations = theory, 0
        self.energy, self.strain, self.linear, self.angular = (np.zeros((0, *shape)) for shape in ((), (), (3,), (3,)))

    def add(self, motion: sk.Motion) -> None:
        ledger, begin = motion.ledger, 1 if len(self.energy) else 0
        for name in ("energy", "strain", "linear", "angular"):
            setattr(self, name, np.concatenate([getattr(self, name), getattr(ledger, name)[begin:]]))
        self.iterations += motion.iterations

    def row(self) -> list[str]:
        """Deviations relative to the values at the start, and slopes of straight lines fitted to them."""
        n = len(self.energy) - 1
        energy = self.energy / self.energy[0] - 1
        linear, angular = (np.linalg.norm(p - p[0], axis=1) / np.linalg.norm(p[0]) for p in (self.linear, self.angular))
        turns = n * STEP * np.linalg.norm(SPIN.spin) / (2 * np.pi)
        along = np.arange(n + 1) / 1e5
        slopes = [np.polyfit(along, values, 1)[0] for values in (energy, angular)]
        return [
            self.theory, str(n), f"{turns:.0f}", f"{self.strain.max() / self.energy[0]:.0%}",
            f"{np.abs(energy).max():.1e}", f"{slopes[0]:+.1e}", f"{linear.max():.1e}", f"{angular.max():.1e}",
            f"{slopes[1]:+.1e}", f"{self.iterations / n:.1f}",
        ]  # fmt: skip


def store(row: list[str]) -> None:
    """Put a theory's row into the table."""
    rows: dict[str, list[str]] = {}
    if FILE.exists():
        with FILE.open(newline="") as file:
            rows = {found[0]: found for found in list(csv.reader(file))[1:]}
    with FILE.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([HEAD, *(rows | {row[0]: row}).values()])


def measure(theory: str, steps: int) -> None:
    """One run, in parts that go on where the last one ended."""
    state, record = thrown(theory), Record(theory)
    for _ in range(PARTS):
        motion = sk.simulate(
            state.system, steps // PARTS * STEP, dt=STEP, rho_inf=1.0, start=state, newton_rtol=NEWTON,
            outputs=2, progress=False,
        ).unwrap()  # fmt: skip
        record.add(motion)
        state = list(motion.states)[-1]
        print(*record.row(), flush=True)
        store(record.row())


def newton() -> None:
    """What other tolerances of Newton's method leave."""
    rows = [["newton_rtol", "energy", "linear momentum", "angular momentum", "Newton iterations per step"]]
    state = thrown("kirchhoff")
    for tolerance in (1e-9, 1e-12, 1e-14):
        motion = sk.simulate(state.system, 2000 * STEP, dt=STEP, rho_inf=1.0, start=state, outputs=2,
                             newton_rtol=tolerance, progress=False).unwrap()  # fmt: skip
        record = Record("kirchhoff")
        record.add(motion)
        row = record.row()
        rows.append([f"{tolerance:.0e}", row[4], row[6], row[7], row[9]])
        print(*rows[-1], flush=True)
    with (THEORY / "tumbling_newton.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def main() -> None:
    words = sys.argv[1:]
    if words == ["newton"]:
        return newton()
    steps = int(words.pop(0)) if words and words[0].isdigit() else STEPS
    for theory in words or ("kirchhoff", "full"):
        measure(theory, steps)


if __name__ == "__main__":
    main()
