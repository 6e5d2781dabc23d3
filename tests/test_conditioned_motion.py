"""Motion with conditions: energy and momenta as without, a pendulum on rods, a ringing ring, ledger and restart."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
import restarts
import scipy.sparse as sp
from scipy.integrate import solve_ivp

import skancf as sk
from skancf.conditions import Condition, Joint, distance
from skancf.conditions.rows import cells_of, in_space
from skancf.dynamics.pulls import Pulls
from skancf.solving import Status

SOFT = sk.Isotropic(1e7, 0.3, 1000.0)
TUBE = sk.CylinderSector(radius=1.0, length=0.3, angle=2 * np.pi)
HINGE, ROD = sk.Hinge("start", "end"), sk.RigidLink((0.0, np.pi / 2), (0.0, 3 * np.pi / 2), name="rod")
RODS = (HINGE, ROD, ROD)
"""The rod is there twice: these conditions depend on each other."""
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
pytestmark = pytest.mark.filterwarnings("ignore:the sides 'start' and 'end'", "ignore:Check failed. numerical dissipation",
                                        "ignore:velocity. .* is against the conditions")  # fmt: skip


@cache
def tube(conditions=RODS, theory="kirchhoff", n=(1, 8), supports=(), loads=()):
    problem = sk.Problem(TUBE, 0.02, SOFT, list(supports), list(loads), conditions=list(conditions))
    return problem.on(sk.meshes.uniform(TUBE, *n), theory)


def tumbling(x, y):
    """Velocities of a tube that flies, turns, and is bent by half of its energy on the way."""
    bend, turn = 0.75 * np.cos(2 * y), 2 * np.sin(y)
    return np.stack([0.3 + 0 * x, bend * np.cos(y) + 0.1 - 2 * (x - 0.15), bend * np.sin(y) + turn + 0.5])


def run(system, t_end, dt, **options):
    options = {"velocity": tumbling, "outputs": "steps", "progress": False, "rho_inf": 1.0} | options
    options = options if "rule" not in options else {k: v for k, v in options.items() if k != "rho_inf"}
    return sk.simulate(system, t_end, **({} if dt is None else {"dt": dt}), **options)


def missed(motion):
    """How far the conditions are from being met at the ends of steps, in their scales."""
    conditions = motion.system.conditions
    return max(conditions.missed(conditions.value(q, sk.Case(time=t))) for q, t in zip(motion.q, motion.times, strict=True))


def drifts(ledger):
    """Largest relative changes of linear and angular momentum that have no source."""
    return [np.abs(ledger.momentum_balance[:, k]).max() / np.linalg.norm(getattr(ledger, name), axis=1).max()
            for k, name in enumerate(("linear", "angular"))]  # fmt: skip


# --- energy and momenta ----------------------------------------------------------------------------------------------


@theories
def test_energy_and_momenta_are_those_of_a_body_without_conditions(theory):
    """Over a hundred steps, a rod that is there twice: what Newton's method leaves adds up to 2e-12."""
    system = tube(RODS, theory)
    motion = run(system, 0.25, 2.5e-3, newton_rtol=1e-11)
    ledger = motion.ledger
    assert motion.ok and len(motion.steps) == 100 and not ledger.work[-1]
    assert np.ptp(ledger.energy) < 1e-10 * ledger.energy[0] and max(drifts(ledger)) < 1e-10, drifts(ledger)
    assert missed(motion) < 1e-12
    assert ledger.strain.max() > 0.2 * ledger.energy[0]
    # Without conditions the slit opens, and the width changes.
    free = system.conditions.value(run(tube((), theory), 0.1, 5e-3).q[-1])
    assert system.conditions.missed(free) > 1e-3
    forces = motion.history(lambda state: [state.conditions["rod 1"], state.conditions["rod 2"]])
    assert np.abs(forces).max() > 1.0 and np.abs(forces[1:, 0] - forces[1:, 1]).max() < 1e-6 * np.abs(forces).max()


@theories
@pytest.mark.parametrize("dt", [5e-3, 0.03])
def test_the_dissipative_rule_keeps_momenta_and_never_gains_energy(dt, theory):
    """At long steps, which are halved where they do not converge, as at short ones."""
    motion = run(tube(RODS, theory), 12 * dt, dt, rho_inf=0.8, newton_rtol=1e-11)
    energy = motion.ledger.energy
    assert motion.ok and energy.max() == energy[0] and energy[-1] < 0.999 * energy[0]
    assert max(drifts(motion.ledger)) < 1e-10 and missed(motion) < 1e-12
    balance = motion.ledger.balance
    assert np.abs(balance).max() < 1e-10 * energy[0]  # what is lost is booked as numerical


def test_steps_that_are_far_too_long_are_halved():
    """A step of a quarter of the first period, with half of the energy in bending; energy and momenta stay."""
    motion = run(tube(), 0.3, 0.3, newton_rtol=1e-11)
    assert motion.ok and any(not step.accepted for step in motion.steps)
    assert np.ptp(motion.ledger.energy) < 1e-10 * motion.ledger.energy[0] and max(drifts(motion.ledger)) < 1e-10


def test_a_run_that_may_not_halve_its_steps_says_where_it_fails():
    motion = sk.simulate(tube(), 0.6, steps=sk.FixedStep(0.3, smallest=0.9), velocity=tumbling, rho_inf=1.0, progress=False)
    assert not motion.ok and "its step fell to" in motion.message and "t = 0 s" in motion.message


def test_the_midpoint_rule_does_not_keep_the_energy():
    """So the test of energy can fail."""
    motion = run(tube(), 0.4, 0.02, rule=sk.ImplicitMidpoint(), balance=None, newton_rtol=1e-9)
    assert motion.ok and np.ptp(motion.ledger.energy) > 1e-3 * motion.ledger.energy[0] and drifts(motion.ledger)[1] < 1e-8


# --- against exact motions -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Hung(Joint):
    """A rod from a point of the surface to a point of space."""

    at: tuple
    to: tuple
    name: str = "rod"
    pulled: float = 0.0
    """By so much the rod grows as time squared (m/s2)."""

    def on(self, shell, layout):
        return OnRod(self, shell, layout)


class OnRod(Condition):
    n, scales = 1, np.ones(1)

    def __init__(self, rod, shell, layout):
        weights = shell.position_rows(*shell.geometry.locate_all(np.array([rod.at]).T))
        self.name, self.place, self.cells, self.end = rod.name, in_space(weights), cells_of(weights), np.array(rod.to)
        self.length, self.pulled = np.linalg.norm(self.apart(layout.undeformed.ravel())), rod.pulled
        self.part = self.place[:, (12 * self.cells[0][:, None] + np.arange(12)).ravel()].toarray()

    def apart(self, q):
        return self.place @ q - self.end

    def couples(self):
        return self.cells

    def value(self, q, case):
        time = case.time or 0.0
        return np.array([distance.value(self.apart(q), self.length) - self.pulled * time**2])

    def gradient(self, q):
        return sp.csr_matrix(distance.gradient(self.apart(q), self.length)[None]) @ self.place

    def add_curvature(self, q, multipliers, blocks):
        blocks.add(self.cells, multipliers[0] * (self.part.T @ distance.curvature(self.length) @ self.part)[None])


LENGTH, G, ANGLE, PERIOD = 1.0, 9.81, 1.0, 2.0
MASS = 1000.0 * 0.6 * 0.2 * 0.01


def swing(theory="kirchhoff", pulled=0.0, extra=()):
    """A stiff plate hung at its centre line by two rods as long as LENGTH, at an angle from the vertical."""
    surface = sk.Rectangle(0.6, 0.2)
    ends = [(x - LENGTH * np.sin(ANGLE), 0.1 + LENGTH * np.cos(ANGLE), 0.0) for x in (0.0, 0.6)]
    rods = [Hung((x, 0.1), end, f"rod {k}", pulled) for k, (x, end) in enumerate(zip((0.0, 0.6), ends, strict=True))]
    stiff = sk.Isotropic(1e11, 0.0, 1000.0)
    problem = sk.Problem(surface, 0.01, stiff, [], [sk.Gravity((0.0, -G, 0.0)), *extra], conditions=rods)
    return problem.on(sk.meshes.uniform(surface, 3, 1), theory)


@cache
def exact_swing():
    """Angle and its rate over time, of a pendulum of length LENGTH."""
    return solve_ivp(lambda t, y: [y[1], -G / LENGTH * np.sin(y[0])], (0.0, PERIOD), [ANGLE, 0.0], rtol=1e-12, atol=1e-13,
                     dense_output=True).sol  # fmt: skip


@theories
@pytest.mark.parametrize("rule", [sk.EnergyMomentum(1.0), sk.EnergyMomentum(0.8), sk.GeneralizedAlpha(0.8)], ids=str)
def test_a_plate_on_two_rods_swings_as_a_pendulum(rule, theory):
    """It does not turn, so that each point moves on a circle: order two in the step, and half of the tension in each rod.

    Gravity begins at once and leaves waves in the plate, of which the dissipative rules take most within a few steps.
    """
    system, errors, pulls = swing(theory), [], []
    for n in (40, 80):
        motion = sk.simulate(system, PERIOD, dt=PERIOD / n, rule=rule, outputs="steps", newton_rtol=1e-9, progress=False)
        angle, rate = exact_swing()(motion.times)
        where = LENGTH * np.stack([np.sin(angle) - np.sin(ANGLE), np.cos(ANGLE) - np.cos(angle), 0 * angle], axis=1)
        errors.append(np.abs(motion.displacement((0.3, 0.1)) - where).max())
        forces = motion.history(lambda state: [state.conditions["rod 0"][0], state.conditions["rod 1"][0]])
        exact = 0.5 * MASS * (G * np.cos(angle) + LENGTH * rate**2)
        late = motion.times > 0.2 * PERIOD
        pulls.append(np.abs(forces - exact[:, None])[late].max() / exact.max())
        assert motion.ok and missed(motion) < 1e-9
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1) and errors[1] < 4e-3 * LENGTH, errors
    if rule != sk.EnergyMomentum(1.0):
        assert np.log2(pulls[0] / pulls[1]) > 1.5 and pulls[1] < 5e-3, pulls


@theories
def test_a_hinged_ring_rings_at_its_frequency(theory):
    """Small motion from a mode: a sine with the frequency that the midpoint rule makes of it, of order two in the step."""
    system = tube((HINGE,), theory)
    modes = sk.modes(system, 8)
    k = modes.n_rigid
    omega, shape = 2 * np.pi * modes.frequencies[k], modes.shapes[k]
    shape = shape / np.sqrt(shape @ (system.mass @ shape))
    speed, errors = 1e-5 * omega / np.abs(shape).max(), []
    for n in (20, 40):
        dt = 2 * np.pi / omega / n
        motion = run(system, 1.5 * n * dt, dt, velocity=speed * shape, newton_rtol=1e-8)
        signal = (motion.q - system.undeformed) @ (system.mass @ shape) * omega / speed
        own = 2 * np.arctan(omega * dt / 2) / dt
        # Large motion adds the square of its size, 1e-5, and strains of positions are rounded.
        assert np.abs(signal - np.sin(own * motion.times)).max() < 1e-4
        errors.append(np.abs(signal - np.sin(omega * motion.times)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1) and errors[1] < 0.03, errors


# --- the ledger ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(1.0), sk.EnergyMomentum(0.8), sk.GeneralizedAlpha(0.8)], ids=str)
def test_a_condition_that_moves_does_work(rule):
    """Rods that become longer let the plate down: their work is negative, and with it energy and momenta balance."""
    motion = sk.simulate(swing(pulled=0.5), 1.0, dt=0.01, rule=rule, newton_rtol=1e-10, outputs="steps", progress=False)
    ledger = motion.ledger
    assert motion.ok and ledger.work[-1] < -0.1 * ledger.turnover[-1] and missed(motion) < 1e-9
    if rule.balance > 1e-2:  # of second order
        assert np.abs(ledger.balance).max() < 2e-3 * ledger.turnover[-1] and max(drifts(ledger)) < 2e-2
    else:
        assert np.abs(ledger.balance).max() < 1e-8 * ledger.turnover[-1] and max(drifts(ledger)) < 1e-8
        assert swing().conditions.n == 2 and sk.simulate(swing(), 0.1, dt=0.01, progress=False).ledger.work[-1] == 0.0


def test_an_impulse_keeps_the_conditions():
    """Rates after it keep them, its work is that on the mean of the rates, and momenta jump by it alone."""
    blow = (3.0, 2.0, 1.0)
    motion = run(tube(loads=(sk.Impulse((0.1, 0.5), blow, time=0.05),)), 0.1, 5e-3, newton_rtol=1e-11)
    ledger, (before, after) = motion.ledger, motion.segments
    conditions = motion.system.conditions
    assert motion.ok and len(motion.segments) == 2 and np.array_equal(before.q[-1], after.q[0])
    assert np.abs(conditions.gradient(after.q[0]) @ after.v[0]).max() < 1e-12
    assert np.abs(after.v[0] - before.v[-1]).max() > 0.1
    assert np.abs(ledger.linear[-1] - ledger.linear[0] - blow).max() < 1e-9
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1] and max(drifts(ledger)) < 1e-10


@pytest.mark.parametrize("held", ["back", "seam"])
def test_supports_take_what_conditions_bring(held):
    """Held along its back, or along one edge of the hinge: momenta change by loads and supports."""
    where = "start" if held == "seam" else lambda x, y: abs(y - np.pi) < 1e-6
    load = sk.EdgeLoad("end", (0.0, 30.0, 0.0), history=sk.Ramp(0.05))
    system = tube(RODS, supports=(sk.Clamp(where),), loads=(load, sk.Gravity((0.0, 0.0, -1.0))))
    motion = run(system, 0.2, 5e-3, velocity=None, newton_rtol=1e-11)
    ledger = motion.ledger
    assert motion.ok and ledger.strain.max() > 0.0 and np.abs(ledger.linear_impulse).max() > 0.01
    assert max(drifts(ledger)) < 1e-8 and np.abs(ledger.balance).max() < 1e-8 * ledger.turnover[-1]


RUBBER = {"kirchhoff": sk.NeoHooke(3.8e6, 1000.0), "full": sk.NeoHooke(3.8e6, 1000.0, bulk=8e6)}
BACK, SIDE = (lambda x, y: abs(y - np.pi) < 1e-6), (0.0, np.pi / 4)
COMPANY = {
    "rubber": lambda theory: {"material": RUBBER[theory]},
    "damping": lambda theory: {"thickness": lambda x, y: 0.02 + 0.01 * np.cos(y), "damping": sk.Damping(0.5, 1e-3),
                               "supports": [sk.Dashpot(SIDE, (30.0, 20.0, 10.0))]},
    "driven supports": lambda theory: {
        "supports": [sk.Prescribed(BACK, (0, 0, 0.1), history=lambda t: np.sin(20 * t) ** 2), sk.Spring(SIDE, (30, 20, 9))],
        "loads": [sk.FollowerPressure(10.0), sk.Gravity()]},
}  # fmt: skip


@theories
@pytest.mark.parametrize("name", COMPANY)
def test_the_ledger_balances_with_what_else_there_is(name, theory):
    what = {"thickness": 0.02, "material": SOFT, "conditions": list(RODS)} | COMPANY[name](theory)
    system = sk.Problem(TUBE, **what).on(sk.meshes.uniform(TUBE, 1, 8), theory)
    velocity = None if name == "driven supports" else tumbling
    motion = run(system, 0.05, 5e-3, velocity=velocity, newton_rtol=1e-11)
    ledger = motion.ledger
    assert motion.ok and missed(motion) < 1e-12 and max(drifts(ledger)) < 1e-10
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1]
    sources = {"damping": ledger.dissipation, "driven supports": ledger.work}
    assert np.abs(sources.get(name, ledger.strain)).max() > 0.01 * ledger.turnover[-1]


# --- multipliers over time -------------------------------------------------------------------------------------------


def test_multipliers_are_those_of_their_time():
    """Straight lines come back whatever the steps and where in them multipliers act, and what alternates does not show."""
    ends = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    for stage in (0.5, 0.6, 1.0):
        uneven = np.array([0.0, 0.2, 0.5, 1.5, 1.7])
        acting = np.append(0.0, uneven[:-1] + stage * np.diff(uneven))
        line = Pulls(uneven, acting, 3 + 2 * acting[:, None])
        for t in (0.0, 0.1, 0.5, 1.6, 1.7):
            assert line.at(t)[0] == pytest.approx(3 + 2 * t, abs=1e-14)
    ripple = Pulls(ends, np.append(0.0, ends[1:] - 0.5), np.array([0.0, 1, -1, 1, -1])[:, None])
    assert np.abs(ripple.at_ends).max() < 1e-14
    assert Pulls(ends[:1], ends[:1], np.full((1, 2), 7.0)).at(0.0).tolist() == [7.0, 7.0]
    assert Pulls(ends[:2], np.array([0.0, 0.5]), np.array([[1.0], [2.0]])).at(1.0)[0] == pytest.approx(3.0)


def test_forces_over_time_by_name():
    motion = run(tube(), 0.1, 5e-3, outputs=11)
    totals = motion.history(lambda state: state.conditions["hinge"].total)
    assert totals.shape == (11, 3) and np.abs(totals).max() > 1.0
    assert motion.at(0.05).conditions["hinge"].total == pytest.approx(totals[5])
    quantity = {"rod": lambda state: state.conditions["rod 1"][0]}
    motion = sk.simulate(swing(), 1.0, dt=0.02, record=quantity, newton_rtol=1e-9, progress=False)
    times, rod = motion.records["rod"]
    late = np.array([motion.at(t).conditions["rod 1"][0] for t in times])
    # At the end of a run they are the same; on the way the next step is not known yet.
    assert rod[-1] == late[-1] and np.abs(rod - late)[times > 0.4].max() < 0.01 * np.abs(rod).max()
    plain = run(tube(()), 0.02, 5e-3)
    assert plain.at(0.01).conditions == {} and plain.at(0.01).multipliers is None


# --- restart ---------------------------------------------------------------------------------------------------------


class Cut(BaseException):
    """No exception that a run would catch."""


def start(folder, cut=None, conditions=RODS, **options):
    def watch(state):
        if cut is not None and state.time > cut:
            raise Cut
        return state.conditions["rod 1"]

    blow = sk.Impulse((0.1, 0.5), (1.0, 2.0, 1.0), time=0.05)
    return run(tube(conditions, loads=(blow,)), 0.1, 5e-3, rho_inf=0.8, outputs=7, resume=True,
               checkpoint=sk.Checkpoint(folder, 4), record={"rod": watch}, **options)  # fmt: skip


def arrays(motion):
    pulls = {f"pulls_{name}_{k}": getattr(part.pulls, name) for k, part in enumerate(motion.segments)
             for name in ("ends", "acting", "values")}  # fmt: skip
    return restarts.arrays(motion) | pulls


@pytest.mark.parametrize("cut", [0.028, 0.071])
def test_a_run_that_was_cut_off_goes_on_bit_for_bit(cut, tmp_path):
    whole = start(tmp_path / "whole")
    with pytest.raises(Cut):
        start(tmp_path / "run", cut)
    read = sk.read_motion(whole.system, tmp_path / "run")
    assert read.status is Status.UNFINISHED and read.at(0.02).conditions["rod 1"] != 0.0
    again = start(tmp_path / "run")
    assert again.ok and restarts.same(arrays(whole), arrays(again)) == []
    assert restarts.same(arrays(whole), arrays(sk.read_motion(whole.system, tmp_path / "run"))) == []


def test_a_run_with_other_conditions_is_refused(tmp_path):
    with pytest.raises(Cut):
        start(tmp_path / "run", 0.028)
    other = sk.RigidLink((0.0, 1.5), (0.0, 3 * np.pi / 2), name="rod")
    with pytest.raises(sk.InputError, match="another conditions"):
        start(tmp_path / "run", conditions=(HINGE, other, other))


# --- what a run is given ---------------------------------------------------------------------------------------------


def test_a_velocity_against_the_conditions_is_told():
    """Of two edges that fly apart nothing is left; the rest of the motion is the nearest that is allowed."""
    system = tube((HINGE,))
    apart = system.undeformed * 0
    apart.reshape(-1, 4, 3)[[0, 1], 0] = [0.0, 3.0, 0.0]
    with pytest.warns(sk.OutOfDepth, match=r"velocity: .* in the norm of the mass, is against the conditions \('hinge'\)"):
        motion = run(system, 5e-3, 5e-3, velocity=apart)
    v = motion.v[0]
    assert np.abs(system.conditions.gradient(motion.q[0]) @ v).max() < 1e-12
    # Nearest in the norm of the mass: what was taken out is perpendicular to what is left.
    assert (apart - v) @ (system.mass @ v) == pytest.approx(0.0, abs=1e-12 * (apart @ (system.mass @ apart)))


def test_a_velocity_that_keeps_them_is_left_alone(recwarn):
    spin = sk.RigidVelocity((0.1, 0.2, 0.3), (1.0, 2.0, 3.0))
    motion = run(tube(), 5e-3, 5e-3, velocity=spin)
    assert np.abs(motion.v[0] - spin.at(motion.system.undeformed)).max() < 1e-12
    assert not [each for each in recwarn if "velocity" in str(each.message)]


def test_a_start_that_does_not_meet_the_conditions_is_refused():
    system = tube()
    q = system.undeformed.copy()
    q.reshape(-1, 4, 3)[0, 0] += [0.0, 0.1, 0.0]
    with pytest.raises(sk.InputError, match=r"the start at t = 0\.0 does not meet the conditions: condition 'hinge'"):
        run(system, 0.1, 1e-2, start=sk.Solution(system, q))


def test_a_run_goes_on_from_the_end_of_another():
    system = tube()
    once, first = run(system, 0.1, 5e-3, newton_rtol=1e-11), run(system, 0.05, 5e-3, newton_rtol=1e-11)
    second = run(system, 0.05, 5e-3, newton_rtol=1e-11, start=first.at(0.05), velocity=None)
    assert np.abs(second.q[-1] - once.q[-1]).max() < 1e-3  # rates begin without what alternates in them
    assert missed(second) < 1e-12


def test_what_cannot_take_conditions_says_so():
    with pytest.raises(sk.InputError, match=r"Trapezoidal\(\) cannot take conditions, and this system has 'hinge', 'rod 1'"):
        run(tube(), 0.1, 1e-2, rule=sk.Trapezoidal())


WAYS = {
    "generalised-alpha": {"dt": 5e-3, "rule": sk.GeneralizedAlpha(0.5)},
    "midpoint": {"dt": 5e-3, "rule": sk.ImplicitMidpoint()},
    "asked accuracy": {"dt": None, "rtol": 3e-2},
    "iterations": {"dt": None, "steps": sk.NewtonCount(5e-3)},
    "energy": {"dt": None, "steps": sk.EnergyBalance(2e-3), "rule": sk.GeneralizedAlpha(0.8)},
}


@cache
def finest():
    return run(tube(), 0.05, 1e-3)


@pytest.mark.parametrize("way", WAYS)
def test_rules_and_controls(way):
    """All come to about the same place, with the conditions met."""
    motion = run(tube(), 0.05, balance=None, **WAYS[way])
    here, best = (np.linalg.norm(each.displacement((0.0, 0.0)), axis=1)[-1] for each in (motion, finest()))
    assert motion.ok and missed(motion) < 1e-9 and here == pytest.approx(best, rel=0.03)


def test_the_error_is_estimated():
    motion, best = run(tube(), 0.05, 2.5e-3, check=True, rho_inf=0.8), run(tube(), 0.05, 5e-4, rho_inf=0.8)
    apart = motion.system.layout.positions(motion.q[-1] - best.q[-1])
    mass = motion.system.inertia.shares[: len(apart), 0]
    true = np.sqrt((mass @ (apart**2).sum(axis=1)) / mass.sum())
    assert 0.2 < motion.error[-1] / true < 5
