"""The ledger of a run with everything on, what is seen when an entry is left out, and runs that do not balance."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import skancf as sk
from skancf.dynamics.ledger import COLUMNS
from skancf.solving import Status

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
T_END = 0.16
STRIKE = 0.08


def everything(theory):
    """Each kind of load, support and damping at once."""
    surface = sk.Rectangle(1.0, 0.5)
    return sk.Problem(
        surface, 0.05, sk.Isotropic(1e6, 0.3, 1000.0, expansion=1e-4),
        [sk.Prescribed("left", (0.0, 0.0, 0.05), history=lambda t: 1 - np.cos(15 * t)), sk.Spring((1.0, 0.0), (30, 20, 50)),
         sk.Foundation(200.0), sk.Dashpot("top", (1.0, 2.0, 3.0)), sk.Dashpot((1.0, 0.5), (0.5, 0.5, 0.5))],
        [sk.Gravity((0.0, 1.0, -3.0)), sk.FollowerPressure(30.0, history=lambda t: np.sin(20 * t)),
         sk.EdgeLoad("right", (10.0, 0.0, 5.0), history=sk.Ramp(0.5 * STRIKE)),
         sk.Temperature(20.0, 300.0, history=lambda t: np.sin(12 * t) ** 2),
         sk.MovingForce(lambda t: (0.1 + 4 * t, 0.3), (0.0, 0.0, -8.0)), sk.Impulse((0.7, 0.2), (0.0, 0.3, 1.0), STRIKE)],
        sk.Damping(mass=0.5, stiffness=1e-3),
    ).on(sk.meshes.uniform(surface, 2, 1), theory)  # fmt: skip


def run(system, n, rule, t_end=T_END, **options):
    return sk.simulate(system, t_end, dt=t_end / n, rule=rule, newton_rtol=1e-11, progress=False,
                       **{"balance": None, "outputs": 2} | options)  # fmt: skip


@cache
def booked(theory):
    return run(everything(theory), 80, sk.EnergyMomentum(), outputs=7)


def imbalances(ledger):
    """Largest parts of energy and momenta without a source."""
    momenta = [(ledger.linear, ledger.linear_impulse), (ledger.angular, ledger.angular_impulse)]
    sizes = [np.max(np.abs(pair)) for pair in momenta]
    return np.array([np.abs(ledger.balance).max() / ledger.turnover[-1],
                     *(np.abs(ledger.momentum_balance).max(axis=(0, 2)) / sizes)])  # fmt: skip


@theories
def test_energy_and_momenta_balance_with_everything_on(theory):
    ledger = booked(theory).ledger
    # Newton's method ends at 1e-11; measured 4e-12.
    assert imbalances(ledger).max() < 1e-9
    for name in ("kinetic", "strain", "potential", "work", "dissipation"):
        assert np.ptp(getattr(ledger, name)) > 0.05 * ledger.turnover[-1], f"{name} takes no part"
    assert (np.diff(ledger.dissipation) >= 0).all() and (np.abs(ledger.angular_impulse[-1]) > 0.01).all()


ENTRIES = ["work", "dissipation", "numerical", "potential", "strain", "linear_impulse", "angular_impulse"]


@theories
@pytest.mark.parametrize("entry", ENTRIES)
def test_an_entry_left_out_is_seen(entry, theory):
    ledger = booked(theory).ledger
    # All of them but what the rule takes out, which is little here, are a hundredth and more of the largest energy.
    least = 1e-6 if entry == "numerical" else 1e-2
    assert imbalances(replace(ledger, **{entry: 0 * getattr(ledger, entry)})).max() > least


@pytest.mark.parametrize(("rule", "theory", "own"), [
    (sk.GeneralizedAlpha(), "kirchhoff", 0), (sk.GeneralizedAlpha(), "full", 0), (sk.Trapezoidal(), "kirchhoff", 1),
    (sk.ImplicitMidpoint(), "kirchhoff", 2),
], ids=["alpha", "alpha, full", "trapezoidal", "midpoint"])  # fmt: skip
def test_other_rules_balance_to_order_two(rule, theory, own):
    """Energy, and momenta but for those that the rule keeps: the linear one, or both."""
    system = everything(theory)
    coarse, fine = (imbalances(run(system, n, rule).ledger) for n in (80, 160))
    kept = np.arange(3)[1 : 1 + own]
    assert (fine[kept] < 1e-11).all()  # what Newton's method leaves
    rates = np.delete(np.log2(coarse / fine), kept)
    # Measured 1.8 to 2.0, and 1e-4 at the most; a source at the wrong time of the step would give 1.0.
    assert (rates > 1.7).all() and fine.max() < 2e-4, (rates, fine)


# --- in a run --------------------------------------------------------------------------------------------------------


def test_at_output_times_it_is_between_the_steps_and_balances_there():
    motion = booked("kirchhoff")
    ledger, outputs = motion.ledger, motion.output_ledger()
    assert np.array_equal(outputs.times, motion.times) and len(outputs.times) == 7
    between = ledger.at(0.5 * (ledger.times[3] + ledger.times[4]))
    for name in COLUMNS:
        values = getattr(ledger, name)
        assert np.allclose(getattr(between, name)[0], 0.5 * (values[3] + values[4]), rtol=1e-12, atol=0)
    assert np.abs(ledger.at(np.linspace(0, T_END, 50)[5:]).balance).max() < 1e-9 * ledger.turnover[-1]


def test_table_has_a_column_of_each_number(tmp_path):
    ledger = booked("kirchhoff").ledger
    table = ledger.table()
    assert set(table) == {"time", "kinetic", "strain", "potential", "work", "dissipation", "numerical", "remeshing",
                          "balance", *(f"{name}_{i}" for name in ("linear", "angular", "linear_impulse", "angular_impulse")
                            for i in "xyz")}  # fmt: skip
    assert all(column.shape == ledger.times.shape for column in table.values())
    assert np.array_equal(table["angular_impulse_y"], ledger.angular_impulse[:, 1])
    assert np.array_equal(table["balance"], ledger.balance)
    sk.output.save_table(tmp_path / "ledger.csv", table)
    assert len((tmp_path / "ledger.csv").read_text().splitlines()) == 1 + len(ledger.times)


def falling(rule, **options):
    surface = sk.Rectangle(1.0, 0.5)
    problem = sk.Problem(surface, 0.1, sk.Isotropic(1e6, 0.3, 1000.0), [sk.Pin((0.0, 0.0))], [sk.Gravity()])
    return run(problem.on(sk.meshes.uniform(surface, 2, 1), "kirchhoff"), 50, rule, t_end=1.0, **options)


def test_a_run_out_of_balance_stops_and_keeps_what_it_has():
    """A plate that falls from one corner loses 3 % of its energy with the rule that damps most."""
    motion = falling(sk.GeneralizedAlpha(0.0), balance=0.01, outputs=11)
    assert motion.status is Status.UNBALANCED and not motion.ok
    assert "lost" in motion.message and "tolerance is 1.0%" in motion.message and "t = " in motion.message
    ledger, end = motion.ledger, motion.ledger.times[-1]
    assert 0 < end < 1.0 and f"{end:.6g}" in motion.message
    parts = np.abs(ledger.balance) / ledger.turnover
    assert parts[-1] > 0.01 and (parts[11:-1] <= 0.01).all(), "stopped at the first step that left it"
    assert motion.times[-1] <= end < motion.times[-1] + 0.1 and np.isfinite(motion.q).all()
    with pytest.raises(sk.DidNotConverge, match="energy"):
        motion.unwrap()
    assert falling(sk.GeneralizedAlpha(0.0), balance=0.1).ok and falling(sk.EnergyMomentum(), balance=1e-8).ok


def test_an_impulse_is_booked_with_its_work():
    surface = sk.Rectangle(1.0, 0.5)
    problem = sk.Problem(surface, 0.02, sk.Isotropic(1e6, 0.3, 1000.0), [], [sk.Impulse((0.2, 0.1), (0.3, 0.1, 2.0), 0.05)])
    ledger = run(problem.on(sk.meshes.uniform(surface, 2, 1), "full"), 20, sk.EnergyMomentum(), t_end=0.1).ledger
    jump = np.flatnonzero(np.diff(ledger.times) == 0)
    assert len(jump) == 1 and ledger.times[jump[0]] == pytest.approx(0.05, abs=1e-15)
    assert np.allclose(ledger.linear[-1], [0.3, 0.1, 2.0], rtol=1e-12)
    assert np.allclose(ledger.angular_impulse[-1], np.cross([0.2, 0.1, 0.0], [0.3, 0.1, 2.0]), rtol=0, atol=1e-12)
    assert ledger.work[-1] == pytest.approx(ledger.kinetic[jump[0] + 1], rel=1e-12) and ledger.work[-1] > 0
    assert imbalances(ledger).max() < 1e-10
