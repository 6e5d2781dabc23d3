"""Motion: order, frequencies, energy, step control, and runs that stop."""

import numpy as np
import pytest

import skancf as sk
from skancf.solving import Status

YOUNG, POISSON, DENSITY = 1e6, 0.3, 1000.0


def plate(thickness=0.1, supports=(), loads=()):
    return sk.Problem(sk.Rectangle(1.0, 1.0), thickness, sk.Isotropic(YOUNG, POISSON, DENSITY), supports, loads)


def cantilever(n=4, loads=()):
    problem = plate(0.1, [sk.Clamp("left")], loads)
    return problem.on(sk.meshes.uniform(problem.surface, n, n))


def quiet(system, t_end, **options):
    return sk.simulate(system, t_end, progress=False, **options)


# Frequencies omega a^2 sqrt(rho h / D) of Reissner-Mindlin plates with a / h = 10, nu = 0.3, rotary inertia, by the Ritz
# method; the thin-plate values are 19.739 and 35.985 (Leissa, 1973, Journal of Sound and Vibration 31, 257-293).
@pytest.mark.parametrize(
    ("support", "expected"), [(sk.SimpleSupport("boundary", "hard"), 19.0650), (sk.Clamp("boundary"), 32.5243)]
)
def test_free_vibration_has_the_eigenfrequency(support, expected):
    thickness = 0.1
    loaded = plate(thickness, [support], [sk.SurfaceLoad((0, 0, -1e-3))])
    system = loaded.on(sk.meshes.uniform(loaded.surface, 16, 16))
    start = sk.solve_linear(system)
    free = plate(thickness, [support]).on(system.mesh)
    rigidity = YOUNG * thickness**3 / (12 * (1 - POISSON**2))
    omega = expected * np.sqrt(rigidity / (DENSITY * thickness))
    period = 2 * np.pi / omega
    at_rest = sk.Solution(free, start.q)
    motion = quiet(free, 3 * period, dt=period / 60, rho_inf=1.0, start=at_rest, outputs=361, newton_rtol=1e-8)
    # The static shape as a weight leaves the first mode and little else.
    signal = (motion.q - free.undeformed) @ (free.mass @ (start.q - free.undeformed))
    crossings = np.flatnonzero(np.diff(np.sign(signal)))
    at = motion.times[crossings] - signal[crossings] * np.diff(motion.times)[crossings] / np.diff(signal)[crossings]
    measured = np.pi * (len(at) - 1) / (at[-1] - at[0])
    assert measured == pytest.approx(omega, rel=0.01)
    # Thin-plate theory is off by more than that, so the test can tell the two apart.
    thin = {19.0650: 19.7392, 32.5243: 35.9852}[expected]
    assert abs(thin / expected - 1) > 0.03


def test_order_two_in_position_and_velocity():
    load = sk.EdgeLoad("right", (0, 0, 5.0), history=lambda t: np.sin(20 * t) ** 2)
    system, t_end = cantilever(2, [load]), 0.2
    fine = quiet(system, t_end, dt=t_end / 1280, outputs=2, newton_rtol=1e-10)
    errors = []
    for n in (40, 80, 160):
        motion = quiet(system, t_end, dt=t_end / n, outputs=2, newton_rtol=1e-10)
        assert len(motion.steps) == n
        difference = [(a[-1] - b[-1]).reshape(-1, 4, 3)[:, 0] for a, b in ((motion.q, fine.q), (motion.v, fine.v))]
        errors.append([np.abs(d).max() for d in difference])
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates[-1] > 1.8).all(), rates
    # Final error against the motion's own size; the reference's error is 64 times smaller than the finest one's.
    size = [np.abs(fine.q[-1] - system.undeformed).max(), np.abs(fine.v[-1]).max()]
    assert (np.array(errors[-1]) < [2e-3 * size[0], 2e-2 * size[1]]).all(), (errors, size)


def test_step_control_follows_its_tolerance():
    load = sk.EdgeLoad("right", (0, 0, 10.0))
    system, t_end = cantilever(2, [load]), 0.3
    fine = quiet(system, t_end, rtol=1e-7, outputs=31, newton_rtol=1e-9)
    errors, counts = [], []
    for rtol in (1e-3, 1e-4, 1e-5):
        motion = quiet(system, t_end, rtol=rtol, outputs=31)
        errors.append(np.abs(motion.displacement((1, 0.5)) - fine.displacement((1, 0.5))).max())
        counts.append(len(motion.steps))
        assert motion.ok and len({step.dt for step in motion.steps}) > 1
    assert errors[0] > errors[1] > errors[2]
    assert counts[0] < counts[1] < counts[2]
    assert any(not step.accepted for step in fine.steps), "no step was ever rejected"
    assert errors[2] < 0.01 * np.abs(fine.displacement((1, 0.5))).max()


def test_energy_of_a_swinging_plate_balances_the_work_of_gravity():
    system = cantilever(3, [sk.Gravity((0, 0, -0.2))])
    motion = quiet(system, 1.0, dt=0.002, rho_inf=1.0, outputs=11, newton_rtol=1e-9)
    weight = system.external_force(system.undeformed)
    for state in motion.states:
        balance = state.kinetic_energy + state.strain_energy - weight @ (state.q - system.undeformed)
        # The rule with rho_inf = 1 conserves energy to second order; its drift here is below 1 % of what moves.
        assert abs(balance) < 0.01 * max(state.kinetic_energy + state.strain_energy, 1e-6)
    assert motion.at(1.0).strain_energy > 1e-3, "nothing moved"


def test_damping_of_high_frequencies_grows_as_rho_falls():
    system = cantilever(2, [sk.EdgeLoad("right", (5000.0, 0, 0))])
    runs = [quiet(system, 0.5, dt=0.01, rule=sk.GeneralizedAlpha(rho), outputs=2, balance=None) for rho in (0.95, 0.0)]
    kinetic = [run.at(0.5).kinetic_energy for run in runs]
    assert kinetic[1] < 0.5 * kinetic[0]


def test_a_free_plate_flies_straight_and_spins_without_strain():
    problem = plate(0.1)
    system = problem.on(sk.meshes.uniform(problem.surface, 2, 2))
    velocity = np.zeros((system.n_dofs // 12, 4, 3))
    velocity[:, 0] = (1.0, 2.0, -3.0)
    motion = quiet(system, 0.5, dt=0.05, velocity=velocity, outputs=3)
    # Rounding only: constant velocity is in the rule exactly.
    assert motion.at(0.5).displacement((0.3, 0.7)) == pytest.approx([0.5, 1.0, -1.5], abs=1e-10)
    assert motion.at(0.5).strain_energy < 1e-18


def test_output_times_do_not_change_the_run():
    system = cantilever(2, [sk.EdgeLoad("right", (0, 0, 5.0))])
    few, many = quiet(system, 0.1, outputs=2), quiet(system, 0.1, outputs=[0.0, 0.013, 0.05, 0.1])
    assert [s.dt for s in few.steps] == [s.dt for s in many.steps]
    assert np.array_equal(few.q[-1], many.q[-1])
    assert many.times.tolist() == [0.0, 0.013, 0.05, 0.1]


def test_records_hold_every_accepted_step():
    system = cantilever(2, [sk.EdgeLoad("right", (0, 0, 5.0))])
    motion = quiet(system, 0.1, record={"tip": lambda state: state.displacement((1, 0.5))[2]})
    times, values = motion.records["tip"]
    assert len(times) == 1 + sum(step.accepted for step in motion.steps) == len(values)
    assert values[-1] == pytest.approx(motion.displacement((1, 0.5))[-1, 2], abs=1e-14)


def test_prescribed_motion_is_followed():
    problem = plate(0.1, [sk.Prescribed("left", (0.0, 0.0, 0.01), history=lambda t: t)])
    system = problem.on(sk.meshes.uniform(problem.surface, 2, 2))
    motion = quiet(system, 0.5, outputs=6)
    edge = motion.displacement((0.0, 0.25))
    # Exact at the end of a step; between steps the cubic uses the rule's rates, which start from rest.
    assert edge[-1, 2] == pytest.approx(0.005, abs=1e-12)
    assert edge[:, 2] == pytest.approx(0.01 * motion.times, rel=1e-3)


def test_factors_are_reused():
    motion = quiet(cantilever(3, [sk.EdgeLoad("right", (0, 0, 5.0))]), 0.2, dt=0.002)
    assert sum(step.factorisations for step in motion.steps) < len(motion.steps) / 5


def test_a_diverging_run_keeps_what_it_has_and_says_where():
    load = sk.PointForce((1.0, 1.0), (0, 0, 1e3), history=lambda t: 1.0 if t < 0.05 else 1e300)
    motion = quiet(cantilever(2, [load]), 0.2, dt=0.01)
    assert motion.status is Status.STEP_TOO_SMALL
    assert "t = 0.0" in motion.message and "(x, y) =" in motion.message
    assert len(motion.times) == len(motion.q) > 1 and np.isfinite(motion.q).all()
    with pytest.raises(sk.DidNotConverge, match="the run stopped"):
        motion.unwrap()


def test_a_load_that_becomes_nan_keeps_what_it_has():
    load = sk.PointForce((1.0, 1.0), (0, 0, 1.0), history=lambda t: 1.0 if t < 0.05 else np.nan)
    motion = quiet(cantilever(2, [load]), 0.2, dt=0.01)
    assert motion.status is Status.FAILED
    assert "history at t" in motion.message
    assert motion.times[-1] > 0.03


def test_an_interrupted_run_keeps_what_it_has():
    def interrupt(state):
        if state.time > 0.05:
            raise KeyboardInterrupt

    motion = quiet(cantilever(2, [sk.EdgeLoad("right", (0, 0, 5.0))]), 0.2, dt=0.01, record={"stop": interrupt})
    assert motion.status is Status.INTERRUPTED
    assert 0.04 < motion.times[-1] < 0.1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"t_end": 0.0}, "t_end = 0.0"),
        ({"t_end": -1.0}, "t_end = -1.0"),
        ({"t_end": np.nan}, "t_end = nan"),
        ({"t_end": 1.0, "dt": 0.0}, "dt = 0.0"),
        ({"t_end": 1.0, "rtol": -1e-3}, "rtol = -0.001"),
        ({"t_end": 1.0, "rho_inf": 1.5}, "rho_inf = 1.5"),
        ({"t_end": 1.0, "outputs": 1}, "outputs = 1"),
        ({"t_end": 1.0, "outputs": [0.0, 2.0]}, "ascending times between"),
        ({"t_end": 1.0, "velocity": np.zeros(5)}, "velocity has 5 entries"),
        ({"t_end": 1.0, "velocity": np.full(9 * 12, np.nan)}, "velocity"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(sk.InputError, match=message):
        quiet(cantilever(2), **options)


def test_a_time_outside_the_motion_is_refused():
    motion = quiet(cantilever(2), 0.1, dt=0.05)
    with pytest.raises(sk.InputError, match=r"known from 0\.0 to 0\.1"):
        motion.at(0.2)


def test_a_state_of_another_mesh_is_refused():
    other = quiet(cantilever(2), 0.1, dt=0.05).at(0.1)
    with pytest.raises(sk.InputError, match="another mesh"):
        quiet(cantilever(2), 0.1, start=other)


def test_a_record_that_fails_loses_nothing():
    def broken(state):
        if state.time > 0.03:
            raise ValueError("my own mistake")

    motion = quiet(cantilever(2, [sk.EdgeLoad("right", (0, 0, 5.0))]), 0.2, dt=0.01, record={"x": broken})
    assert motion.status is Status.FAILED and "my own mistake" in motion.message
    assert motion.times[-1] > 0.02


def test_outputs_may_end_before_the_run():
    motion = quiet(cantilever(2), 0.1, dt=0.02, outputs=[0.0, 0.04])
    assert motion.steps[-1].time == pytest.approx(0.1) and motion.times.tolist() == [0.0, 0.04]


def test_a_jump_of_a_prescribed_displacement_is_refused():
    problem = plate(0.1, [sk.Prescribed("left", (0.0, 0.0, 0.01))])
    with pytest.raises(sk.InputError, match=r"jumps by 0\.01 at the start"):
        quiet(problem.on(sk.meshes.uniform(problem.surface, 2, 2)), 0.1)


def test_velocity_at_a_clamp_is_that_of_the_clamp():
    system = cantilever(2)
    motion = quiet(system, 0.01, dt=0.005, velocity=np.ones(system.n_dofs), outputs=3)
    assert np.abs(system.constraints.fixed_part(motion.v[0])).max() < 1e-12
    assert np.abs(motion.v[0]).max() == 1.0


def test_reactions_of_a_moving_state_are_refused():
    motion = quiet(cantilever(2, [sk.EdgeLoad("right", (0, 0, 5.0))]), 0.1, dt=0.05)
    with pytest.raises(sk.InputError, match="inertia"):
        motion.at(0.1).reactions()
