"""What holds for motions."""

import tempfile
import warnings
from typing import Any

import numpy as np
from hypothesis import assume
from restarts import arrays, same

import skancf as sk
from fuzz.assessment import bounded, nodal, seen
from fuzz.moving import Moving, period_of, prepared

NEWTON = 1e-9
"""Newton's method for comparisons of two runs."""

FINE = 300
"""Steps of a run that others are compared with."""


def run(moving: Moving, system: Any, options: dict[str, Any], **more: Any) -> sk.Motion:
    """A run to its end; one that stops says why, and ends the example."""
    options = {"dt": options["t_end"] / moving.steps, "outputs": 5, "balance": None, "progress": False, **options, **more}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        motion = sk.simulate(system, options.pop("t_end"), **options)
    assert np.isfinite(motion.q).all(), "a state that is not finite"
    if not motion.ok:
        assert motion.message, f"{motion.status} without a word"
        seen[f"motion: {motion.status.value}"] += 1
    assume(motion.ok)
    return motion


def moved(motion: sk.Motion) -> np.ndarray:
    """Displacements of the nodes at the output times, (n, nodes, 3)."""
    return (motion.q - motion.system.undeformed).reshape(len(motion.times), -1, 4, 3)[:, :, 0]


def energy(moving: Moving) -> None:
    """Without loads energy never grows, with them it balances; momenta change by what acts on the body."""
    system, options = prepared(moving, period_of(moving))
    ledger = run(moving, system, options).ledger
    size = float(ledger.turnover[-1])
    assume(size > 0)
    # Newton's method ends at 1e-6 in the norm of energy, of a momentum too, in each step; and rounding of the coordinates
    # may be more of a small energy.
    places = np.abs(system.undeformed)
    noise = 1e-28 * float(places @ (abs(system.stiffness().to_scipy()) @ places))
    bounded("energy without a source", float(np.abs(ledger.balance).max()), 1e-5 * size + noise)
    if not moving.case.problem.loads:
        bounded("energy over that at the start", float(ledger.energy.max()), ledger.energy[0] * (1 + 1e-5) + noise)
    for name in ("linear", "angular"):
        have, given = getattr(ledger, name), getattr(ledger, f"{name}_impulse")
        left = np.linalg.norm(have - given - (have - given)[0], axis=1).max()
        arm = float(np.abs(nodal(system.undeformed)[:, 0]).max()) if name == "angular" else 1.0
        largest = arm * np.sqrt(2 * size * float(np.abs(system.inertia.shares[:, 0]).sum()))
        known = max(float(np.linalg.norm(part, axis=1).max()) for part in (have, given))
        allowed = 3e-6 * moving.steps * max(known, largest) + arm * np.sqrt(noise)
        bounded(f"{name} momentum without a source", float(left), allowed)


def scaling(moving: Moving) -> None:
    """Loads a millionth and half of that: so small that motions are linear in them."""
    period, parts = period_of(moving), []
    for factor in (1e-5, 5e-6):
        system, options = prepared(moving, period, factor)
        parts.append(moved(run(moving, system, options, newton_rtol=NEWTON)) / factor)
    size = float(np.abs(parts[1]).max())
    # Coordinates are rounded at 1e-16 of the body, and so are differences of strains.
    unknown = 1e-11 * float(np.abs(system.undeformed).max()) / 5e-6
    bounded("what is not linear in small loads", float(np.abs(parts[0] - parts[1]).max()), 1e-3 * size + unknown)


def restated(moving: Moving) -> None:
    """Stated in another frame, mirrored, shifted, or in other units the body moves alike."""
    period = period_of(moving)
    one, two = (run(moving, *prepared(moving, period, there=there), newton_rtol=NEWTON) for there in (False, True))
    # Whether a step that is far too long converges is up to rounding.
    assume([step.dt for step in one.steps if step.accepted] == [step.dt for step in two.steps if step.accepted])
    here, there = moved(one), moved(two) @ moving.frame.turn / moving.units[0]
    size = float(np.abs(here).max())
    unknown = 1e-10 * float(np.abs(one.system.undeformed).max())
    bounded("motions stated otherwise", float(np.abs(here - there).max()), 1e-4 * size + unknown)


class Stops(Exception):
    """Raised once on the way."""


def restart(moving: Moving) -> None:
    """A run that is stopped and goes on has the bytes of one that does not."""
    period = period_of(moving)
    system, options = prepared(moving, period)
    stops = {"yet": False}

    def half(state: sk.Solution) -> float:
        if stops["yet"] and state.time > 0.55 * options["t_end"]:
            raise Stops
        return float(np.abs(state.q).sum())

    def part(folder: str) -> sk.Motion:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", sk.OutOfDepth)
            return sk.simulate(
                system, options["t_end"], dt=options["t_end"] / moving.steps, rule=moving.rule, velocity=options["velocity"],
                balance=None, outputs="steps", record={"sum": half}, checkpoint=sk.Checkpoint(folder, every=3), resume=True,
                progress=False,
            )  # fmt: skip

    with tempfile.TemporaryDirectory() as folder:
        whole = part(f"{folder}/whole")
        assume(whole.ok)
        stops["yet"] = True
        assert not part(f"{folder}/parts").ok, "it did not stop"
        stops["yet"] = False
        differ = same(arrays(whole), arrays(part(f"{folder}/parts")))
    assert not differ, f"a restart changes {differ}"


def asked(moving: Moving) -> None:
    """The error is the asked one, three times it at most, against short fixed steps."""
    system, options = prepared(moving, period_of(moving))
    rtol = 3e-2
    one = run(moving, system, options, dt=None, rtol=rtol, outputs=11)
    two = run(moving, system, options, dt=options["t_end"] / FINE, outputs=11)
    weights = np.abs(system.inertia.shares[:, 0])

    def rms(u: np.ndarray) -> float:
        return float(np.sqrt((weights @ (u**2).sum(axis=2).T / weights.sum()).max()))

    size = rms(moved(two))
    assume(size > 1e-10 * float(np.abs(system.undeformed).max()))  # loads on what is held move nothing
    bounded("error over what was asked", rms(moved(one) - moved(two)), 3 * rtol * size)
