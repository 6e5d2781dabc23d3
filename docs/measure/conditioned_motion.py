"""Motion with conditions: what is kept over two hundred steps, and a pendulum on rods against the exact one.

From the folder of the repository, in a minute:

    .venv/bin/python docs/measure/conditioned_motion.py

It writes docs/decisions/conditioned_motion.csv and conditioned_pendulum.csv.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
import tables
from scipy.integrate import solve_ivp

import skancf as sk
from skancf.conditions import Condition, Joint, distance
from skancf.conditions.rows import cells_of, in_space
from skancf.dynamics.newmark import Newmark

TUBE = sk.CylinderSector(radius=1.0, length=0.3, angle=2 * np.pi)
SOFT = sk.Isotropic(1e7, 0.3, 1000.0)
ROD = sk.RigidLink((0.0, np.pi / 2), (0.0, 3 * np.pi / 2), name="rod")
CONDITIONS: dict[str, list[Any]] = {"none": [], "hinge, rod": [sk.Hinge("start", "end"), ROD],
                                    "hinge, rod twice": [sk.Hinge("start", "end"), ROD, ROD]}  # fmt: skip
STEP, STEPS = 2.5e-3, 200


def tumbling(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of a tube that flies, turns, and is bent by half of its energy on the way."""
    bend, turn = 0.75 * np.cos(2 * y), 2 * np.sin(y)
    return np.stack([0.3 + 0 * x, bend * np.cos(y) + 0.1 - 2 * (x - 0.15), bend * np.sin(y) + turn + 0.5])


def kept() -> list[list[Any]]:
    rows = []
    for theory in ("kirchhoff", "full"):
        for name, conditions in CONDITIONS.items():
            system = sk.Problem(TUBE, 0.02, SOFT, conditions=conditions).on(sk.meshes.uniform(TUBE, 1, 12), theory)
            for rho_inf, newton_rtol in ((1.0, 1e-11), (0.8, 1e-11), (0.8, None)):
                motion = sk.simulate(system, STEPS * STEP, dt=STEP, rho_inf=rho_inf, velocity=tumbling, outputs="steps",
                                     newton_rtol=newton_rtol, progress=False).unwrap()  # fmt: skip
                ledger, asked = motion.ledger, motion.system.conditions
                above = ledger.energy.max() / ledger.energy[0] - 1
                lost = [np.abs(ledger.momentum_balance[:, k]).max() / np.linalg.norm(getattr(ledger, part), axis=1).max()
                        for k, part in enumerate(("linear", "angular"))]  # fmt: skip
                missed = max(asked.missed(asked.value(q)) for q in motion.q)
                rows.append([f"`{theory}`", name, rho_inf, "default" if newton_rtol is None else f"{newton_rtol:g}",
                             f"{motion.iterations / len(motion.steps):.1f}", sum(s.factorisations for s in motion.steps),
                             f"{max(above, 0.0):.0e}", f"{max(lost):.0e}", f"{missed:.0e}"])  # fmt: skip
    return rows


LENGTH, G, ANGLE, END = 1.0, 9.81, 1.0, 2.0


@dataclass(frozen=True)
class Hung(Joint):
    """A rod from a point of the surface to a point of space."""

    at: tuple[float, float]
    to: tuple[float, float, float]
    name: str

    def on(self, shell: Any, layout: Any) -> Condition:
        return OnRod(self, shell, layout)


class OnRod(Condition):
    n, scales = 1, np.ones(1)

    def __init__(self, rod: Hung, shell: Any, layout: Any) -> None:
        weights = shell.position_rows(*shell.geometry.locate_all(np.array([rod.at]).T))
        self.name, self.place, self.cells, self.end = rod.name, in_space(weights), cells_of(weights), np.array(rod.to)
        self.part = self.place[:, (12 * self.cells[0][:, None] + np.arange(12)).ravel()].toarray()

    def couples(self) -> np.ndarray:
        return self.cells

    def value(self, q: np.ndarray, case: sk.Case) -> np.ndarray:
        return np.array([distance.value(self.place @ q - self.end, LENGTH)])

    def gradient(self, q: np.ndarray) -> sp.csr_matrix:
        return sp.csr_matrix(distance.gradient(self.place @ q - self.end, LENGTH)[None]) @ self.place

    def add_curvature(self, q: np.ndarray, multipliers: np.ndarray, blocks: Any) -> None:
        blocks.add(self.cells, multipliers[0] * (self.part.T @ distance.curvature(LENGTH) @ self.part)[None])


@dataclass(frozen=True)
class Refused(Newmark):
    """The trapezoidal rule, which a run with conditions refuses."""

    alpha_m = alpha_f = 0.0
    beta, gamma = 0.25, 0.5


def swing() -> sk.system.system.System:
    """A stiff plate on two rods at the height of its centre: it does not turn, and each point moves on a circle."""
    surface = sk.Rectangle(0.6, 0.2)
    ends = [(x, (x - LENGTH * np.sin(ANGLE), 0.1 + LENGTH * np.cos(ANGLE), 0.0)) for x in (0.0, 0.6)]
    rods = [Hung((x, 0.1), end, f"rod {x:g}") for x, end in ends]
    problem = sk.Problem(surface, 0.01, sk.Isotropic(1e11, 0.0, 1000.0), [], [sk.Gravity((0.0, -G, 0.0))], conditions=rods)
    return problem.on(sk.meshes.uniform(surface, 3, 1), "kirchhoff")


def pendulum() -> list[list[Any]]:
    exact = solve_ivp(lambda t, y: [y[1], -G / LENGTH * np.sin(y[0])], (0.0, END), [ANGLE, 0.0], rtol=1e-12, atol=1e-13,
                      dense_output=True).sol  # fmt: skip
    rows = []
    for rule in (sk.EnergyMomentum(1.0), sk.EnergyMomentum(0.8), sk.GeneralizedAlpha(0.8), Refused()):
        for n in (40, 80, 160):
            motion = sk.simulate(swing(), END, dt=END / n, rule=rule, outputs="steps", newton_rtol=1e-9, balance=None,
                                 progress=False).unwrap()  # fmt: skip
            angle, rate = exact(motion.times)
            where = LENGTH * np.stack([np.sin(angle) - np.sin(ANGLE), np.cos(ANGLE) - np.cos(angle), 0 * angle], axis=1)
            tension = 0.5 * 1000 * 0.6 * 0.2 * 0.01 * (G * np.cos(angle) + LENGTH * rate**2)
            pulls = motion.segments[0].pulls
            late = motion.times > 0.2 * END
            of_steps = pulls.values[:, 0], np.interp(pulls.acting, motion.times, tension)
            given = motion.history(lambda state: state.conditions["rod 0"][0])
            name = "Trapezoidal()" if isinstance(rule, Refused) else str(rule).replace("rho_inf=", "")
            rows.append(
                [
                    name,
                    n,
                    f"{np.abs(motion.displacement((0.3, 0.1)) - where).max() / LENGTH:.1e}",
                    *(f"{np.abs(a - b)[late].max() / tension.max():.1e}" for a, b in (of_steps, (given, tension))),
                ]
            )
    return rows


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    tables.write("conditioned_motion.csv", "theory; conditions; rho_inf; newton_rtol; iterations a step; factorisations; "
                 "energy above its start; momenta without a source; conditions missed", kept())  # fmt: skip
    tables.write("conditioned_pendulum.csv", "rule; steps; place, error; tension in the steps, error; "
                 "tension as it is given, error", pendulum())  # fmt: skip
