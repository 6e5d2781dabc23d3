"""Control of the steps: the asked error is the error, the asked balance the balance, and what stops a run."""

from functools import cache

import numpy as np
import pytest

import skancf as sk
from skancf.solving import Status

MATERIAL = sk.Isotropic(1e6, 0.3, 1000.0)


def on(surface, thickness, material, supports, loads, n, theory):
    problem = sk.Problem(surface, thickness, material, supports, loads)
    return problem.on(sk.meshes.uniform(surface, *n), theory)


def cantilever(theory):
    load = sk.EdgeLoad("right", (0.0, 0.0, 0.5), history=lambda t: np.sin(3 * t) ** 2)
    return on(sk.Rectangle(1.0, 0.3), 0.02, MATERIAL, [sk.Clamp("left")], [load], (4, 1), theory), 1.5, None


def pendulum(theory):
    soft = sk.Isotropic(1e5, 0.3, 7810.0)
    return on(sk.Rectangle(0.6, 0.3), 0.01, soft, [sk.Pin((0, 0))], [sk.Gravity()], (4, 2), theory), 0.5, None


def tumbling(theory):
    return on(sk.Rectangle(1.0, 0.5), 0.02, MATERIAL, [], [], (2, 1), theory), 0.5, sk.RigidVelocity(spin=(2.0, 6.0, 1.0))


PROBLEMS = {"cantilever": cantilever, "pendulum": pendulum, "tumbling": tumbling}
CASES = [("cantilever", "kirchhoff"), ("cantilever", "full"), ("pendulum", "kirchhoff"), ("tumbling", "kirchhoff")]
FINE, OUTPUTS = 1e-4, 41


def quiet(system, t_end, **options):
    return sk.simulate(system, t_end, progress=False, **{"balance": None, "outputs": 2} | options)


@cache
def reference(name, theory):
    system, t_end, velocity = PROBLEMS[name](theory)
    return system, t_end, velocity, quiet(system, t_end, velocity=velocity, rtol=FINE, outputs=OUTPUTS)


def rms(system, u):
    """Mass-weighted root mean square of positions."""
    one = np.zeros((system.n_dofs // 12, 4, 3))
    one[:, 0, 0] = 1
    weights = np.abs((system.mass @ one.ravel()).reshape(-1, 4, 3)[:, 0, 0])
    return np.sqrt(weights @ (u.reshape(-1, 4, 3)[:, 0] ** 2).sum(axis=1) / weights.sum())


# --- local error -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rtol", [3e-2, 3e-3])
@pytest.mark.parametrize(("name", "theory"), CASES)
def test_the_asked_error_is_the_error(name, theory, rtol):
    """Largest at an output time: not three times the asked one, nor less than a fifth of it; measured 0.27 to 0.93."""
    system, t_end, velocity, fine = reference(name, theory)
    motion = quiet(system, t_end, velocity=velocity, rtol=rtol, outputs=OUTPUTS)
    assert motion.ok
    size = max(rms(system, q - system.undeformed) for q in fine.q)
    error = max(rms(system, u) for u in motion.q - fine.q) / size
    assert rtol / 5 < error < 3 * rtol, error / rtol
    assert any(not step.accepted for step in motion.steps), "no step was ever rejected"
    assert len({step.dt for step in motion.steps}) > 3
    assert sum(not step.accepted for step in motion.steps) < 0.35 * len(motion.steps)


def test_rejected_steps_leave_nothing_behind():
    system, t_end, _, _ = reference("cantilever", "kirchhoff")
    motion = quiet(system, t_end, rtol=1e-3, record={"tip": lambda state: state.displacement((1.0, 0.3))[2]})
    accepted = [step for step in motion.steps if step.accepted]
    assert len(accepted) < len(motion.steps)
    times = np.cumsum([step.dt for step in accepted])
    assert np.allclose([step.time for step in accepted], times, rtol=1e-12)
    for found in (motion.ledger.times, motion.records["tip"][0]):
        assert np.allclose(found, [0.0, *times], rtol=1e-12, atol=0)
    again = quiet(system, t_end, steps=Given([step.dt for step in accepted]))
    # Factors of other steps were at hand: Newton's method ends at 1e-5 in the energy norm.
    assert np.abs(again.q[-1] - motion.q[-1]).max() < 1e-4 * np.abs(motion.q[-1] - system.undeformed).max()


class Given:
    """Steps from a list: a control of the user's own."""

    smallest = 1e-6

    def __init__(self, lengths):
        self.lengths = list(lengths)

    def first(self, guess):
        return self.lengths.pop(0)

    def accepts(self, attempt):
        return True

    def next_step(self, attempt):
        return self.lengths.pop(0) if self.lengths else attempt.dt


class RejectsTheFirst(Given):
    """Tries a long step, and takes it back."""

    def accepts(self, attempt):
        return attempt.dt < 0.1


def test_a_rejected_step_changes_nothing_that_follows():
    """Not the tolerance of Newton's method either, which goes with the largest energy of the motion."""
    system = reference("cantilever", "kirchhoff")[0]
    lengths = [0.01] * 200
    plain, tried = (quiet(system, 0.3, steps=control) for control in (Given(lengths), RejectsTheFirst([0.2, *lengths])))
    assert not tried.steps[0].accepted and tried.steps[0].dt == 0.2
    assert [step.dt for step in tried.steps[1:]] == [step.dt for step in plain.steps]
    assert np.array_equal(tried.q[-1], plain.q[-1]) and np.array_equal(tried.v[-1], plain.v[-1])


def test_largest_step_is_kept_and_a_sudden_load_needs_short_ones():
    system, t_end, _, _ = reference("cantilever", "kirchhoff")
    longest = t_end / 100
    motion = quiet(system, t_end, steps=sk.LocalError(1e-2, largest=longest))
    assert max(step.dt for step in motion.steps) <= longest * (1 + 1e-12) and len(motion.steps) >= 100


# --- energy balance --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3])
@pytest.mark.parametrize("rule", [sk.ImplicitMidpoint(), sk.Trapezoidal()], ids=["midpoint", "trapezoidal"])
def test_the_asked_balance_is_kept(rule, rtol):
    """What a step gains and the next one loses counts twice: the sum stays below, by a factor of 4 to 5."""
    system, t_end, _, _ = reference("pendulum", "kirchhoff")
    motion = quiet(system, t_end, steps=sk.EnergyBalance(rtol), rule=rule)
    ledger = motion.ledger
    found = np.abs(ledger.balance).max() / ledger.turnover[-1]
    assert motion.ok and rtol / 10 < found < rtol, found / rtol
    assert any(not step.accepted for step in motion.steps)


def test_the_asked_balance_is_kept_by_generalised_alpha():
    system, t_end, _, _ = reference("pendulum", "kirchhoff")
    motion = quiet(system, t_end, steps=sk.EnergyBalance(5e-2), rule=sk.GeneralizedAlpha())
    assert motion.ok and abs(motion.ledger.balance[-1]) < 5e-2 * motion.ledger.turnover[-1]
    assert any(not step.accepted for step in motion.steps)
    # Its acceleration belongs to another time than its state: what that moves to and fro does not fall with the step.
    stopped = quiet(system, t_end, steps=sk.EnergyBalance(1e-3), rule=sk.GeneralizedAlpha())
    assert stopped.status is Status.STEP_TOO_SMALL and "energy without a source" in stopped.message


# --- iterations, output times, cuts ----------------------------------------------------------------------------------


@pytest.mark.parametrize("iterations", [3, 5, 8])
def test_newton_count_keeps_near_its_count(iterations):
    system, t_end, _, _ = reference("pendulum", "kirchhoff")
    motion = quiet(system, t_end, steps=sk.NewtonCount(t_end / 200, iterations))
    assert motion.ok
    assert np.mean([step.iterations for step in motion.steps]) == pytest.approx(iterations, rel=0.25)


def test_output_times_do_not_change_the_run():
    system, t_end, _, _ = reference("cantilever", "kirchhoff")
    runs = [quiet(system, t_end, rtol=1e-3, outputs=outputs) for outputs in (2, 57, [0.0, 0.1234, 0.1235, 1.4999, t_end])]
    for other in runs[1:]:
        assert [step.dt for step in other.steps] == [step.dt for step in runs[0].steps]
        assert np.array_equal(other.q[-1], runs[0].q[-1])
    assert [len(run.times) for run in runs] == [2, 57, 5]


def test_steps_that_fail_are_halved_and_the_run_goes_on():
    """A heavy load that comes at once, in steps in which a plate folds over."""
    load = sk.EdgeLoad("right", (0.0, 0.0, 300.0), history=lambda t: 1.0 if t > 0.1 else 0.0)
    system = on(sk.Rectangle(1.0, 0.3), 0.02, MATERIAL, [sk.Clamp("left")], [load], (4, 1), "kirchhoff")
    motion = quiet(system, 0.2, dt=0.02, rule=sk.GeneralizedAlpha(0.2))
    failed = [k for k, step in enumerate(motion.steps) if not step.accepted]
    assert motion.ok and failed, "no step was ever cut"
    for k in failed:
        assert motion.steps[k + 1].dt == pytest.approx(0.5 * motion.steps[k].dt)
        assert np.isinf(motion.steps[k].error)
    lengths = [step.dt for step in motion.steps if step.accepted]
    assert sum(lengths) == pytest.approx(0.2) and min(lengths) < 0.02
    stopped = quiet(system, 0.2, steps=sk.FixedStep(0.02, smallest=0.9), rule=sk.GeneralizedAlpha(0.2))
    assert stopped.status is Status.STEP_TOO_SMALL and "fell to 1.0e-02 s" in stopped.message
    assert stopped.ledger.times[-1] == pytest.approx(stopped.steps[-1].time - 0.02)


# --- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.LocalError(0.0), "rtol = 0.0"), (lambda: sk.LocalError(-1e-3), "rtol = -0.001"),
    (lambda: sk.LocalError(np.nan), "rtol = nan"), (lambda: sk.LocalError(1e-3, largest=0.0), "largest = 0.0 s"),
    (lambda: sk.LocalError(1e-3, largest=np.nan), "largest = nan s"),
    (lambda: sk.LocalError(smallest=0.0), "smallest = 0.0"),
    (lambda: sk.EnergyBalance(-0.1), "rtol = -0.1"), (lambda: sk.EnergyBalance(0.1, largest=-1.0), "largest = -1.0 s"),
    (lambda: sk.FixedStep(0.0), "dt = 0.0"), (lambda: sk.FixedStep(np.inf), "dt = inf"),
    (lambda: sk.FixedStep(0.1, smallest=-1.0), "smallest = -1.0"), (lambda: sk.NewtonCount(0.0), "dt = 0.0"),
    (lambda: sk.NewtonCount(0.1, 0), "iterations = 0"), (lambda: sk.NewtonCount(0.1, 2.5), "iterations = 2.5"),
    (lambda: sk.NewtonCount(0.1, 5, largest=-1.0), "largest = -1.0 s"),
    (lambda: sk.GeneralizedAlpha(1.2), "rho_inf = 1.2"), (lambda: sk.GeneralizedAlpha(-0.1), "rho_inf = -0.1"),
    (lambda: sk.GeneralizedAlpha(np.nan), "rho_inf"),
])  # fmt: skip
def test_controls_that_cannot_be_are_refused(build, words):
    with pytest.raises(sk.InputError, match=words):
        build()


@pytest.mark.parametrize(("options", "words"), [
    ({"rho_inf": 0.5, "rule": sk.Trapezoidal()}, "rho_inf = 0.5 and rule"),
    ({"rule": "trapezoidal"}, "rule = 'trapezoidal'"),
    ({"rule": sk.Trapezoidal}, "rule = .*give a rule"),
    ({"balance": 0.0}, "balance = 0.0"), ({"balance": -1}, "balance = -1"),
    ({"newton_rtol": 0.0}, "newton_rtol = 0.0"), ({"steps": 0.01}, "steps = 0.01"),
    ({"steps": sk.FixedStep}, "steps = .*give a step control"),
    ({"steps": sk.EnergyBalance(0.01), "rule": sk.EnergyMomentum()}, "balances at any step"),
    ({"record": {"x": 3.0}}, r"record\['x'\] = 3.0"),
])  # fmt: skip
def test_runs_that_cannot_be_are_refused(options, words):
    with pytest.raises(sk.InputError, match=words):
        quiet(reference("cantilever", "kirchhoff")[0], 0.1, **options)
