"""Rules of integration side by side, at fixed steps: docs/decisions/time_rules.csv, and docs/pictures/spinning.png.

From the folder of the repository, in some minutes:

    .venv/bin/python docs/measure/time_rules.py

Names of scenes run these only, and write nothing; ``picture`` makes the picture alone.
"""

import sys
import warnings
from collections.abc import Iterator
from math import sqrt
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk
from tables import write

import skancf as sk
from skancf.system.system import System

PICTURE = Path(__file__).resolve().parent.parent / "pictures" / "spinning.png"
RULES = {
    "GeneralizedAlpha(0.8)": sk.GeneralizedAlpha(0.8),
    "EnergyMomentum(1.0)": sk.EnergyMomentum(1.0),
    "EnergyMomentum(0.8)": sk.EnergyMomentum(0.8),
}
HEAD = ("scene; step (ms); rule; until (s); steps; rejected; iterations per step; energy gained; dissipated by the rule; "
        "angular momentum; seen")  # fmt: skip


class Case(NamedTuple):
    """A run at fixed steps (s), and what is looked at in it."""

    system: System
    end: float
    dt: float
    velocity: object = None
    seen: object = None
    free: bool = False
    """Whether angular momentum should be kept."""


def spinning(dt: float, theory: str = "kirchhoff", end: float = 0.3) -> Case:
    """A free strip that turns in its plane: the stress in its middle over rho omega^2 L^2 / 8, in the second half."""
    surface, spin = sk.Rectangle(1.0, 0.1, origin=(-0.5, -0.05)), 100.0
    mesh = sk.meshes.uniform(surface, 8, 2)
    system = sk.Problem(surface, 0.01, sk.Isotropic(2e11, 0.0, 7800.0)).on(mesh, theory)

    def seen(motion: sk.Motion) -> str:
        stress = spinning_stress(motion)[motion.times > 0.5 * end]
        return f"stress {stress.mean():.3f}, {stress.min():.2f} to {stress.max():.2f} of the exact one"

    return Case(system, end, dt, sk.RigidVelocity(spin=(0.0, 0.0, spin)), seen, True)


def spinning_stress(motion: sk.Motion) -> np.ndarray:
    """Stress in the middle of the strip at the output times, over the exact one."""
    middle = int(np.argmin(np.linalg.norm(motion.system.mesh.p, axis=0)))
    return motion.history(lambda state: state.nodal_stresses(0.0)[middle][0]) / (7800.0 * 100.0**2 / 8)


def tumbling(dt: float, theory: str) -> Case:
    surface = sk.Rectangle(0.4, 0.1)
    system = sk.Problem(surface, 0.002, sk.Isotropic(70e9, 0.3, 2700.0)).on(sk.meshes.uniform(surface, 4, 1), theory)
    return Case(system, 0.3, dt, sk.RigidVelocity(spin=(0.0, 20.0, 0.0), about=(0.2, 0.05, 0.0)), None, True)


def pendulum(dt: float) -> Case:
    """A stiff strip let go in the horizontal, against the period of a rigid one."""
    length, gravity = 1.0, 9.81
    surface = sk.Rectangle(length, 0.1)
    problem = sk.Problem(surface, 0.02, sk.Isotropic(70e9, 0.0, 2700.0), [sk.Pin("left")], [sk.Gravity((0, 0, -gravity))])
    period = 4 * ellipk(0.5) / sqrt(gravity * (length / 2) / (length**2 / 3))

    def seen(motion: sk.Motion) -> str:
        if not motion.ok:
            return ""
        moved = motion.displacement((length, 0.05))
        angle = np.arctan2(length + moved[:, 0], -moved[:, 2])
        k = np.flatnonzero(angle[:-1] * angle[1:] < 0)
        crossed = motion.times[k] - angle[k] * (motion.times[k + 1] - motion.times[k]) / (angle[k + 1] - angle[k])
        return f"period {2 * (crossed[1] - crossed[0]) / period - 1:+.1e}" if len(crossed) > 1 else ""

    return Case(problem.on(sk.meshes.uniform(surface, 2, 1), "kirchhoff"), 0.9 * period, dt, None, seen)


def drop(dt: float, theory: str) -> Case:
    """A damped cantilever thrown down: the energy can only fall."""
    surface = sk.Rectangle(0.3, 0.05)
    problem = sk.Problem(surface, 0.001, sk.Isotropic(210e9, 0.3, 7850.0), [sk.Clamp("left")],
                         damping=sk.Damping(stiffness=1e-5))  # fmt: skip

    def seen(motion: sk.Motion) -> str:
        return f"largest energy {motion.ledger.energy.max() / motion.ledger.energy[0]:.3g} of the first"

    return Case(problem.on(sk.meshes.uniform(surface, 6, 1), theory), 0.02, dt, sk.RigidVelocity((0.0, 0.0, -0.4)), seen)


def ruler(dt: float, load: float) -> Case:
    """The free ruler of the gallery, until 50 ms: its energy in the free flight over that at 4 ms."""
    surface = sk.Rectangle(0.3, 0.06)
    push = sk.EdgeLoad("right", (0.6 * load / 0.06, 0.0, load / 0.06), sk.Pulse(4e-3, shape="triangle"))
    problem = sk.Problem(surface, 0.002, sk.Isotropic(206e9, 0.0, 7800.0), loads=[push])

    def seen(motion: sk.Motion) -> str:
        energy = motion.ledger.energy[motion.ledger.times > 3.999e-3]
        if not energy.size:
            return ""
        return f"energy {energy.min() / energy[0]:.4g} to {energy.max() / energy[0]:.4g} of that at 4 ms"

    return Case(problem.on(sk.meshes.uniform(surface, 12, 1), "kirchhoff"), 0.05, dt, None, seen)


def cases() -> Iterator[tuple[str, Case]]:
    yield "spinning strip", spinning(1e-3)
    yield "spinning strip", spinning(3e-3)
    for theory in ("kirchhoff", "full"):
        for dt in (1e-2, 3e-3):
            yield f"tumbling plate, {theory}", tumbling(dt, theory)
    for dt in (2e-2, 5e-3):
        yield "stiff pendulum", pendulum(dt)
    for dt in (1e-4, 1e-3):
        yield "damped drop, full", drop(dt, "full")
    yield "ruler, 2 kN", ruler(2e-4, 2e3)
    yield "ruler, 20 kN", ruler(1e-4, 2e4)


def run(case: Case, rule: object) -> sk.Motion:
    """Steps are halved six times at most, and the balance is not looked at."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        return sk.simulate(case.system, case.end, steps=sk.FixedStep(case.dt, smallest=0.01), rule=rule, outputs="steps",
                           velocity=case.velocity, balance=None, progress=False)  # fmt: skip


def row(name: str, case: Case, rule: str) -> list[str]:
    motion = run(case, RULES[rule])
    ledger = motion.ledger
    accepted = sum(step.accepted for step in motion.steps)
    turned = np.linalg.norm(ledger.momentum_balance[:, 1], axis=1).max() / np.linalg.norm(ledger.angular, axis=1).max()
    return [
        name, f"{1e3 * case.dt:g}", rule, f"{ledger.times[-1]:.3g}", str(accepted), str(len(motion.steps) - accepted),
        f"{motion.iterations / max(accepted, 1):.1f}", f"{max(ledger.balance.max() / ledger.turnover[-1], 0.0):.1e}",
        f"{ledger.numerical[-1] / ledger.turnover[-1]:.1e}", f"{turned:.0e}" if case.free else "",
        case.seen(motion) if case.seen else "",
    ]  # fmt: skip


COLOURS = {"GeneralizedAlpha(0.8)": "#0072B2", "EnergyMomentum(1.0)": "#D55E00", "EnergyMomentum(0.8)": "#009E73"}


def picture() -> None:
    """The stress of the spinning strip, and the energy of a tumbling plate, over time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), layout="constrained")
    for name, rule in RULES.items():
        motion = run(spinning(1e-3, end=0.1), rule)
        stress = spinning_stress(motion)
        left.plot(1e3 * motion.times, stress, color=COLOURS[name], label=name, lw=1.3)
        motion = run(tumbling(3e-3, "kirchhoff"), rule)
        right.plot(1e3 * motion.ledger.times, motion.ledger.energy / motion.ledger.energy[0], color=COLOURS[name], lw=1.6)
    left.set(xlabel="time (ms)", ylabel="stress in the middle / exact", ylim=(0.0, 60.0),
             title="A strip that spins, steps of 1 ms")  # fmt: skip
    left.set_yscale("symlog", linthresh=3.0)
    left.set_yticks([0, 1, 2, 3, 10, 30], ["0", "1", "2", "3", "10", "30"])
    left.legend(frameon=False, loc="center right")
    right.set(xlabel="time (ms)", ylabel="energy / first", ylim=(0.8, 2.2),
              title="A thin plate that tumbles, steps of 3 ms")  # fmt: skip
    for axes in (left, right):
        axes.grid(color="#e0e0e0")
    figure.savefig(PICTURE, dpi=80)
    plt.close(figure)


def main() -> None:
    words = sys.argv[1:]
    if words == ["picture"]:
        return picture()
    rows = []
    for name, case in cases():
        if words and not any(word in name for word in words):
            continue
        for rule in RULES:
            rows.append(row(name, case, rule))
            print(*rows[-1], sep="; ", flush=True)
    if not words:
        write("time_rules.csv", HEAD, rows)
        picture()


if __name__ == "__main__":
    main()
