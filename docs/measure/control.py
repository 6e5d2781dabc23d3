"""Does the step control reach the asked error? Motions of several kinds, by the default rule: docs/decisions/control.csv.

From the folder of the repository, in some ten minutes of a processor:

    .venv/bin/python docs/measure/control.py

Names of motions run these only, and write nothing; ``impulses``, ``scales`` or ``spins`` that table alone. The error is the
mass-weighted root mean square of positions, where nothing is held less their mean, against a run with ``rtol=1e-4``, over
the largest displacement.
``impulses``: what a free bar has of the impulse of a load, docs/decisions/impulses.csv. ``scales``: steps under other loads
and in other units, docs/decisions/scales.csv. ``spins``: a strip that a clamp spins up, docs/decisions/spins.csv.
"""

import sys
import warnings
from collections.abc import Callable, Iterator
from math import cos, pi, sin
from typing import Any

import numpy as np
from tables import write

import skancf as sk
from skancf.system.system import System

ALUMINIUM, STEEL = sk.Isotropic(70e9, 0.3, 2700.0), sk.Isotropic(210e9, 0.3, 7850.0)
Motions = Iterator[tuple[str, sk.Problem, tuple[int, int], float, dict]]


def held() -> Motions:
    """Plates and strips on supports."""
    square, strip, narrow = sk.Rectangle(1.0, 1.0), sk.Rectangle(1.0, 0.3), sk.Rectangle(0.2, 0.02)
    simply, soft = [sk.SimpleSupport("boundary", kind="hard")], sk.Isotropic(1e6, 0.3, 1e3)
    load = sk.SurfaceLoad((0, 0, 0.1))
    yield "simply supported plate, sudden 0.1 Pa", sk.Problem(square, 0.01, ALUMINIUM, simply, [load]), (4, 4), 0.03, {}
    load = sk.SurfaceLoad((0, 0, -2e4), history=sk.Pulse(0.01))
    yield "the same, pulse of 20 kPa", sk.Problem(square, 0.01, ALUMINIUM, simply, [load]), (4, 4), 0.03, {}
    push = sk.PointForce((0.2, 0.01), (0, 0, 3.0), history=sk.Ramp(0.05))
    yield "cantilever, ramp to 3 N", sk.Problem(narrow, 0.001, STEEL, [sk.Clamp("left")], [push]), (4, 1), 0.2, {}
    for name, size, history in (("smooth", 0.5, lambda t: np.sin(3 * t) ** 2), ("sudden", 0.2, None)):
        load = sk.EdgeLoad("right", (0, 0, size), history=history)
        yield f"soft cantilever, {name} load", sk.Problem(strip, 0.02, soft, [sk.Clamp("left")], [load]), (6, 2), 1.5, {}
    corners = sk.Problem(square, 0.05, sk.Isotropic(0.2e6, 0.0, 2000), [sk.Pin("corners")],
                         [sk.PointForce((0.5, 0.5), (0, 0, -20))])  # fmt: skip
    yield "plate on four corners", corners, (6, 6), 0.5, {}


def along(history: Callable, supports: list) -> sk.Problem:
    """A bar of unit length that is pushed along; waves run at 1 km/s."""
    push = sk.EdgeLoad("left", (5.0, 0, 0), history=history)
    return sk.Problem(sk.Rectangle(1.0, 0.02), 0.005, sk.Isotropic(1e9, 0.0, 1000.0), supports, [push])


def moving() -> Motions:
    """Waves and bodies that turn."""
    short = 0.3e-3
    guided = [sk.Roller("boundary"), sk.Roller("boundary", (0, 1, 0))]
    wave = along(lambda t: sin(pi * t / short) ** 2 if t <= short else 0.0, guided)
    yield "wave along a bar", wave, (16, 1), 1.5e-3, {}
    cloth = sk.Problem(sk.Rectangle(0.6, 0.3), 0.01, sk.Isotropic(1e5, 0.3, 7810), [sk.Pin((0, 0))], [sk.Gravity()])
    yield "plate pendulum", cloth, (4, 2), 0.4, {}
    stiff = sk.Problem(sk.Rectangle(1.0, 0.1), 0.02, sk.Isotropic(70e9, 0.0, 2700.0), [sk.Pin("left")], [sk.Gravity()])
    yield "stiff pendulum", stiff, (2, 1), 1.2, {}
    free = sk.Problem(sk.Rectangle(1, 0.5), 0.02, sk.Isotropic(1e6, 0.3, 1e3))
    for name, speed in (("tumbling plate", 0.0), ("the same at 100 m/s", 100.0)):
        yield name, free, (4, 2), 1.0, {"velocity": sk.RigidVelocity((speed, 0, 0), (2.0, 6.0, 1.0))}


def size(system: System, change: np.ndarray) -> np.ndarray:
    """Root mean squares at each time, (n, n_dofs) to (n,)."""
    weights = np.abs(system.shares[:, 0]) / np.abs(system.shares[:, 0]).sum()
    positions = change.reshape(len(change), -1, 4, 3)[:, :, 0]
    if not system.constraints.fixed.any():
        positions = positions - np.einsum("n,tni->ti", weights, positions)[:, None]
    return np.sqrt(np.einsum("n,tni->t", weights, positions**2))


def reached(words: list[str]) -> list[list[Any]]:
    rows = []
    for name, problem, (nx, ny), t_end, options in (*held(), *moving()):
        if words and not any(word in name for word in words):
            continue
        system = problem.on(sk.meshes.uniform(problem.surface, nx, ny), "kirchhoff")
        asked = {"outputs": 41, "progress": False, **options}
        fine = sk.simulate(system, t_end, rtol=1e-4, **asked).unwrap()
        whole = size(system, fine.q - system.undeformed).max()
        for rtol in (1e-2, 1e-3):
            motion = sk.simulate(system, t_end, rtol=rtol, check=True, **asked).unwrap()
            error = size(system, motion.q - fine.q).max() / whole
            steps = sum(step.accepted for step in motion.steps)
            guess = float(np.nanmax(motion.error)) / whole
            rows.append([name, f"{rtol:g}", f"{error:.1e}", f"{error / rtol:.2f}", f"{guess / error:.1f}", steps,
                         len(motion.steps) - steps, f"{motion.iterations / len(motion.steps):.1f}",
                         f"{motion.ledger.numerical[-1] / motion.ledger.strain.max():.0e}"])  # fmt: skip
            print(*rows[-1], sep="; ", flush=True)
    return rows


def impulses() -> list[list[Any]]:
    """Momentum of a free bar after a load, over the load's impulse."""
    span, rows = 1.5e-3, []

    def bump(begin: float, length: float) -> Callable:
        return lambda t: sin(pi * (t - begin) / length) ** 2 if begin <= t <= begin + length else 0.0

    for name, history, integral in (
        ("a bump of 0.2 T at the start", bump(0.0, 0.2 * span), 0.1 * span),
        ("a late one of 0.04 T", bump(0.71 * span, 0.04 * span), 0.02 * span),
        ("a late rectangle of 0.013 T", lambda t: float(0.6137 * span <= t <= 0.6267 * span), 0.013 * span),
    ):
        problem = along(history, [])
        system = problem.on(sk.meshes.uniform(problem.surface, 16, 1), "kirchhoff")
        for rtol in (1e-2, 1e-3):
            motion = sk.simulate(system, span, rtol=rtol, progress=False).unwrap()
            steps = sum(step.accepted for step in motion.steps)
            rows.append([name, f"{rtol:g}", steps, f"{motion.ledger.linear[-1, 0] / (5.0 * 0.02 * integral):.4f}"])
            print(*rows[-1], sep="; ", flush=True)
    return rows


def scales() -> list[list[Any]]:
    """A cantilever under a sudden force, its curve over the force compared with that of the first."""
    rows, first = [], None
    for force, unit, name in ((1e-2, 1.0, "m"), (1e-4, 1.0, "m"), (1e-6, 1.0, "m"), (1e-2, 1e3, "mm")):
        material = STEEL if unit == 1.0 else sk.Isotropic(210e3, 0.3, 7850e-12)
        surface, tip = sk.Rectangle(0.2 * unit, 0.03 * unit), (0.2 * unit, 0.015 * unit)
        problem = sk.Problem(surface, 0.002 * unit, material, [sk.Clamp("left")], [sk.PointForce(tip, (0, 0, force))])
        system = problem.on(sk.meshes.uniform(surface, 4, 1), "kirchhoff")
        motion = sk.simulate(system, 0.06, rtol=1e-2, outputs=41, progress=False).unwrap()
        curve = motion.displacement(tip)[:, 2] / force / unit
        first = curve if first is None else first
        difference = np.abs(curve - first).max() / np.abs(first).max()
        rows.append([f"{force:g}", name, sum(step.accepted for step in motion.steps),
                     f"{np.abs(curve).max() * force / 0.002:.1e}", f"{difference:.0e}"])  # fmt: skip
        print(*rows[-1], sep="; ", flush=True)
    return rows


def spins() -> list[list[Any]]:
    """A strip of 10 m that a clamp spins up to 6 rad/s in 15 s (Simo and Vu-Quoc 1986): its tip lags, and is drawn out."""
    length, bending, stretching, per_length, spin, ramp = 10.0, 1.4e4, 2.8e7, 1.2, 6.0, 15.0
    h = np.sqrt(12 * bending / stretching)
    law = sk.Isotropic(stretching / h, 0.0, per_length / h)

    def angle(t: float) -> float:
        return spin * (0.5 * t * t + (ramp / 2 / pi) ** 2 * (cos(2 * pi * t / ramp) - 1)) / ramp if t < ramp else (
            spin * (t - ramp / 2))  # fmt: skip

    surface, rows = sk.Rectangle(length, 1.0), []
    clamp = sk.DrivenClamp("left", axis=(0.0, -1.0, 0.0), angle=angle)
    system = sk.Problem(surface, h, law, [clamp]).on(sk.meshes.uniform(surface, 8, 1), "kirchhoff")
    for name, options in (("0.05 s", {"dt": 0.05}), ("0.02 s", {"dt": 0.02}), ("rtol = 1e-2", {"rtol": 1e-2})):
        motion = sk.simulate(system, 20.0, outputs="steps", progress=False, **options).unwrap()
        turned, place = np.array([angle(t) for t in motion.times]), motion.displacement((length, 0.5))
        x, z = place[:, 0] + length, place[:, 2]
        along, across = x * np.cos(turned) + z * np.sin(turned), z * np.cos(turned) - x * np.sin(turned)
        drawn = (along[motion.times > 16] - length).mean()
        rows.append([name, len(motion.times) - 1, f"{-across.min():.3f}", f"{drawn:.3e}"])
        print(*rows[-1], sep="; ", flush=True)
    return rows


HEAD = ("motion; asked; reached; reached / asked; error of check over reached; steps; rejected; iterations per step; "
        "dissipated by the rule, over the largest strain energy")  # fmt: skip


def main() -> None:
    warnings.simplefilter("ignore", sk.OutOfDepth)
    words = sys.argv[1:]
    if not words:
        write("control.csv", HEAD, reached([]))
    if not words or words == ["impulses"]:
        write("impulses.csv", "load; asked; steps; momentum / impulse", impulses())
    if not words or words == ["scales"]:
        write("scales.csv", "force (N); lengths in; steps; largest deflection / thickness; curve differs by", scales())
    if not words or words == ["spins"]:
        write("spins.csv", "steps of; steps; largest lag (m); drawn out in the steady spin (m)", spins())
    if words and words[0] not in ("impulses", "scales", "spins"):
        reached(words)


if __name__ == "__main__":
    main()
