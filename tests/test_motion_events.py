"""What happens in a run: initial velocities, impulses, and a force that moves over a strip."""

from itertools import pairwise

import numpy as np
import pytest

import skancf as sk

UNIT = sk.Rectangle(1.0, 0.5)
MATERIAL = sk.Isotropic(1e6, 0.3, 1000.0)
MASS = 1000.0 * 0.5 * 0.05
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def free(theory, *loads):
    return sk.Problem(UNIT, 0.05, MATERIAL, [], list(loads)).on(sk.meshes.uniform(UNIT, 2, 2), theory)


def quiet(system, t_end, **options):
    return sk.simulate(system, t_end, progress=False, **options)


# --- initial velocities ----------------------------------------------------------------------------------------------


@theories
def test_a_rigid_velocity_carries_the_body(theory):
    system, v = free(theory), (1.0, 2.0, -3.0)
    motion = quiet(system, 0.5, dt=0.05, velocity=sk.RigidVelocity(v), outputs=6)
    for point in ((0.0, 0.0), (0.7, 0.2)):
        assert np.allclose(motion.displacement(point), np.outer(motion.times, v), rtol=0, atol=1e-10)
    assert motion.ledger.strain.max() < 1e-15 and np.allclose(motion.ledger.linear, MASS * np.array(v), rtol=1e-10)


@theories
def test_a_slow_spin_turns_the_body(theory):
    """A turn of 1 rad about the normal, so slow that the plate stretches by rho (omega a)^2 / E = 1e-5."""
    system, spin = free(theory), 0.1
    motion = quiet(system, 10.0, dt=0.5, velocity=sk.RigidVelocity(spin=(0, 0, spin), about=(0.5, 0.25, 0.0)),
                   rule=sk.EnergyMomentum(), outputs=2)  # fmt: skip
    angle = 20 * 2 * np.arctan(0.25 * spin)  # what the rule makes of 20 steps
    arm, end = np.array([0.5, 0.25]), motion.at(10.0).position((1.0, 0.5))
    c, s = np.cos(angle), np.sin(angle)
    assert np.allclose(end[:2], [0.5 + c * arm[0] - s * arm[1], 0.25 + s * arm[0] + c * arm[1]], atol=1e-4)
    assert end[2] == pytest.approx(0.0, abs=1e-9)


@theories
def test_a_function_gives_the_velocity_of_the_surface(theory):
    """A bilinear velocity field: its momenta, and the displacement of the first moment."""
    system = free(theory)

    def field(x, y):
        return np.stack([0 * x, 0 * x, 1.0 + 2.0 * x - y])

    motion = quiet(system, 1e-4, dt=1e-5, velocity=field, outputs=2)
    first = motion.ledger
    assert np.allclose(first.linear[0], [0, 0, MASS * (1 + 2 * 0.5 - 0.25)], rtol=1e-10, atol=1e-10)
    for x, y in ((0.0, 0.0), (1.0, 0.5), (0.3, 0.4)):
        moved = motion.at(1e-4).displacement((x, y))[2]
        assert moved == pytest.approx(1e-4 * (1 + 2 * x - y), rel=2e-3)


def test_at_a_support_the_support_overrules():
    problem = sk.Problem(UNIT, 0.05, MATERIAL, [sk.Clamp("left")])
    system = problem.on(sk.meshes.uniform(UNIT, 2, 2), "kirchhoff")
    motion = quiet(system, 0.01, dt=1e-3, velocity=sk.RigidVelocity((0, 0, 1.0)), outputs=3)
    assert np.abs(motion.displacement((0.0, 0.25))).max() < 1e-12 and motion.displacement((1.0, 0.25))[-1, 2] > 5e-3


# --- impulses --------------------------------------------------------------------------------------------------------


@theories
def test_impulses_make_velocities_jump(theory):
    """At the start, and twice at times that are no steps: momentum jumps by each, and steps land on the times."""
    blows = [((0.5, 0.25), (0.0, 0.0, 0.5), 0.0), ((1.0, 0.5), (0.02, 0.0, -0.1), 0.0337),
             ((0.0, 0.0), (0.0, 0.03, 0.1), 0.06)]  # fmt: skip
    system = free(theory, *(sk.Impulse(*blow) for blow in blows))
    motion = quiet(system, 0.1, dt=0.01, rule=sk.EnergyMomentum(1.0), outputs=11, balance=None)
    ledger = motion.ledger
    for at, impulse, time in blows:
        k = np.flatnonzero(np.abs(ledger.times - time) < 1e-15)
        assert len(k) == 2, "before and after"
        assert np.allclose(np.diff(ledger.linear[k], axis=0)[0], impulse, rtol=0, atol=1e-12)
        place = motion.at(time).position(at)
        assert np.allclose(np.diff(ledger.angular[k], axis=0)[0], np.cross(place, impulse), rtol=0, atol=1e-11)
        assert ledger.strain[k[0]] == pytest.approx(ledger.strain[k[1]], rel=1e-12, abs=1e-20), "positions do not jump"
    assert np.allclose(ledger.linear[-1], np.sum([blow[1] for blow in blows], axis=0), rtol=1e-10)
    assert np.abs(ledger.balance).max() < 1e-9 * ledger.turnover[-1]
    # Steps are those asked for but for the cut ones before the times.
    lengths = [step.dt for step in motion.steps]
    assert np.isclose(lengths, 0.01).sum() == len(lengths) - 2 and sum(lengths) == pytest.approx(0.1)


def test_segments_meet_at_an_impulse():
    times = (0.0337, 0.06)
    loads = [sk.Impulse((1.0, 0.5), (0.0, 0.0, 1.0), t) for t in times]
    motion = quiet(free("kirchhoff", *loads), 0.1, dt=0.01, outputs=11, balance=None)
    parts = motion.segments
    assert [part.times[0] for part in parts] == pytest.approx([0.0, *times])
    assert [part.times[-1] for part in parts] == pytest.approx([*times, 0.1])
    for one, two in pairwise(parts):
        assert np.array_equal(one.q[-1], two.q[0]) and np.abs(two.v[0] - one.v[-1]).max() > 0.01
    assert np.allclose(motion.times, np.linspace(0, 0.1, 11))
    for t in times:  # after the event where it is asked for; before, the corner was at rest or slower
        speeds = [motion.at(moment).velocity.reshape(-1, 4, 3)[-1, 0, 2] for moment in (t - 1e-6, t)]
        assert speeds[1] - speeds[0] > 0.05


def test_two_halves_at_one_time_are_one():
    half, whole = (0.0, 0.1, 0.5), (0.0, 0.2, 1.0)
    runs = [quiet(free("full", *loads), 0.05, dt=0.005, outputs=2, balance=None)
            for loads in ([sk.Impulse((1.0, 0.5), half, 0.02)] * 2, [sk.Impulse((1.0, 0.5), whole, 0.02)])]  # fmt: skip
    assert np.allclose(runs[0].q[-1], runs[1].q[-1], rtol=0, atol=1e-12) and len(runs[0].segments) == 2


# --- a moving force --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.25, 0.5])
def test_a_force_moves_over_a_simply_supported_strip(ratio):
    r"""The middle under a constant force at a part ``ratio`` of the critical speed, L. Fryba, Vibration of Solids and
    Structures under Moving Loads (1972), section 1.3: with :math:`w_0 = 2 P L^3 / \pi^4 E I` and :math:`\omega = \pi c / L`,

    .. math:: w(x, t) = w_0 \sum_n \frac{\sin(n \pi x / L)}{n^2 (n^2 - \alpha^2)}
        \left( \sin n \omega t - \frac{\alpha}{n} \sin \omega_n t \right).
    """
    length, width, thickness, young, density, force = 1.0, 0.1, 0.01, 1e8, 1000.0, 1e-3
    stiffness, per_length = young * width * thickness**3 / 12, density * width * thickness
    first = (np.pi / length) ** 2 * np.sqrt(stiffness / per_length)
    speed = ratio * first * length / np.pi
    t_end = length / speed
    strip = sk.Rectangle(length, width)
    problem = sk.Problem(
        strip, thickness, sk.Isotropic(young, 0.0, density),
        [sk.SimpleSupport(["left", "right"]), sk.Symmetry(["bottom", "top"])],
        [sk.MovingForce(lambda t: (speed * t, 0.5 * width), (0.0, 0.0, force))],
    )  # fmt: skip
    motion = quiet(problem.on(sk.meshes.uniform(strip, 8, 1), "kirchhoff"), t_end, dt=t_end / 200, outputs=101)
    t, n = motion.times, np.arange(1, 40)[:, None]
    omega = np.pi * speed / length
    series = np.sin(n * omega * t) - ratio / n * np.sin(n**2 * first * t)
    w0 = 2 * force * length**3 / (np.pi**4 * stiffness)
    exact = w0 * (np.sin(0.5 * n * np.pi) / (n**2 * (n**2 - ratio**2)) * series).sum(axis=0)
    found = motion.displacement((0.5 * length, 0.5 * width))[:, 2]
    error = np.abs(found - exact).max() / exact.max()
    assert motion.ok and error < 0.01, error
    static = w0 * (np.sin(0.5 * n * np.pi) * np.sin(n * omega * t) / n**4).sum(axis=0)
    assert np.abs(static - exact).max() > 0.1 * exact.max(), "inertia takes part"


def test_a_run_that_goes_on_is_not_struck_again():
    problem = sk.Problem(sk.Rectangle(1.0, 0.3), 0.02, sk.Isotropic(1e6, 0.3, 1e3), [sk.Clamp("left")],
                         [sk.Impulse((1.0, 0.15), (0, 0, 0.02), time=0.125)])  # fmt: skip
    system = problem.on(sk.meshes.uniform(problem.surface, 4, 1), "kirchhoff")
    first = sk.simulate(system, 0.125, dt=0.125 / 8, progress=False)
    then = sk.simulate(system, 0.125, dt=0.125 / 8, start=first.at(0.125), progress=False)
    assert then.ledger.kinetic[0] == pytest.approx(first.ledger.kinetic[-1]) and first.ledger.kinetic[-1] > 0
