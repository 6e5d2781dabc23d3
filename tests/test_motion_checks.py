"""What a motion says of itself: its balances, the dissipation of the rule, and the estimated error of a second run."""

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import skancf as sk
from skancf.dynamics.rule import Rule
from skancf.solving import Status

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
TAKEN = "numerical dissipation"


def of(surface, thickness, material, n, theory, supports=(), loads=(), damping=None):
    problem = sk.Problem(surface, thickness, material, list(supports), list(loads), damping)
    return problem.on(sk.meshes.uniform(surface, *n), theory)


def value(motion, name):
    (check,) = (check for check in motion.checks if name in check.name)
    return check


def simulate(system, t_end, **options):
    return sk.simulate(system, t_end, progress=False, **options)


# --- numerical dissipation -------------------------------------------------------------------------------------------


def stiff_pendulum(theory):
    """Of metal, 1.3 m long, let go at 40 degrees from the vertical: weight pulls at once, and its membrane rings."""
    angle = np.radians(40)
    weight = sk.Gravity((9.81 * np.cos(angle), 0.0, -9.81 * np.sin(angle)))
    return of(sk.Rectangle(1.3, 0.12), 0.02, sk.Isotropic(70e9, 0.3, 2700.0), (2, 1), theory, [sk.Pin("left")], [weight])


def cloth(theory):
    """A soft plate that hangs at a corner."""
    soft = sk.Isotropic(2e5, 0.3, 1100.0)
    return of(sk.Rectangle(0.6, 0.3), 0.015, soft, (2, 1), theory, [sk.Pin((0.0, 0.0))], [sk.Gravity()])


@theories
def test_a_motion_whose_vibrations_are_not_followed_says_so(theory):
    """A quarter of the strain energy that was ever there is taken out; the swing itself is right."""
    with pytest.warns(sk.OutOfDepth, match="vibrations of the stress .* are not"):
        motion = simulate(stiff_pendulum(theory), 1.0, rtol=1e-2)
    assert motion.ok and 0.1 < value(motion, TAKEN).value < 1.0
    # As a rigid body it turns by an angle phi, (l^2 / 3 + h^2 / 12) phi'' = - g l / 2 sin phi.
    tip = motion.displacement((1.3, 0.06)) + np.array([1.3, 0.06, 0.0])
    turned = np.unwrap(np.arctan2(-tip[:, 2], tip[:, 0]))
    exact = swing(np.radians(40), 9.81 * 1.3 / 2 / (1.3**2 / 3 + 0.02**2 / 12), motion.times)
    assert np.abs(turned - exact).max() < 0.015 * np.abs(exact).max()


def swing(start, square, times):
    """The angle from the start of a pendulum let go at an angle, by small steps of Verlet's rule."""
    n = 4000
    t = np.linspace(0, times[-1], n + 1)
    dt, phi, rate, out = t[1], start, 0.0, [start]
    for _ in range(n):
        rate -= 0.5 * dt * square * np.sin(phi)
        phi += dt * rate
        rate -= 0.5 * dt * square * np.sin(phi)
        out.append(phi)
    return start - np.interp(times, t, out)


@theories
@pytest.mark.parametrize("rtol", [1e-2, 3e-3])
def test_a_motion_that_is_followed_says_nothing(rtol, theory):
    with warnings.catch_warnings():
        warnings.simplefilter("error", sk.OutOfDepth)
        motion = simulate(cloth(theory), 0.4, rtol=rtol)
    assert motion.ok and all(check.passed for check in motion.checks)
    assert value(motion, TAKEN).value < 0.05 and motion.ledger.strain.max() > 0.05 * motion.ledger.turnover[-1]


def test_fixed_steps_are_judged_too():
    with pytest.warns(sk.OutOfDepth, match=TAKEN):
        simulate(stiff_pendulum("kirchhoff"), 0.3, dt=5e-3)


# --- balances --------------------------------------------------------------------------------------------------------


class Leaks(sk.EnergyMomentum):
    """A force that the stresses do not have: of momentum without a source."""

    def internal_force(self, system, u, start, dt):
        force = super().internal_force(system, u, start, dt)
        extra = (system.mass @ np.tile([0.0, 0.0, 1.0] + 9 * [0.0], system.n_dofs // 12)).ravel()
        return force + 0.5 * extra


class Feeds(sk.EnergyMomentum):
    """Stresses that do more work than they store."""

    def stresses(self, system, u, start, dt, change=None):
        return 1.02 * super().stresses(system, u, start, dt, change)


def free(theory="kirchhoff"):
    return of(sk.Rectangle(0.5, 0.3), 0.02, sk.Isotropic(1e7, 0.3, 1000.0), (2, 1), theory)


def bent(x, y):
    return np.stack([0 * x, 0 * x, 20 * (x - 0.25) ** 2 - 0.4])


@theories
def test_momenta_out_of_balance_are_no_finished_run(theory):
    velocity = sk.RigidVelocity((0.3, 0.2, 0.1), (1.0, 2.0, 3.0), (0.25, 0.15, 0.0))
    good = simulate(free(theory), 0.2, dt=5e-3, velocity=velocity)
    assert good.ok and value(good, "linear momentum").value < 1e-6
    bad = simulate(free(theory), 0.2, dt=5e-3, velocity=velocity, rule=Leaks(), balance=1e-3)
    assert not bad.ok and bad.status is Status.UNBALANCED and bad.message
    assert not value(bad, "linear momentum").passed
    with pytest.raises(sk.DidNotConverge):
        bad.unwrap()


def test_momenta_alone_out_of_balance_too():
    """Where energy hardly sees it: the rule that leaks, with a force that does no work on a plate that flies across."""
    system = free()
    motion = simulate(system, 0.02, dt=2e-3, velocity=sk.RigidVelocity((40.0, 0.0, 0.0)), rule=Leaks(), balance=1e-4)
    assert motion.status is Status.UNBALANCED and "momentum without a source" in motion.message
    assert value(motion, "energy without").passed
    assert simulate(system, 0.02, dt=2e-3, velocity=sk.RigidVelocity((40.0, 0.0, 0.0)), rule=Leaks(), balance=None).ok


@theories
def test_energy_is_balanced_to_a_thousandth(theory):
    """The default tolerance of this rule; that of others is a hundred times as much."""
    system, rule = free(theory), sk.EnergyMomentum()
    assert rule.balance == 1e-3 and sk.GeneralizedAlpha().balance == Rule.balance == 0.1
    good = simulate(system, 0.2, dt=2e-3, velocity=bent)
    assert good.ok and value(good, "energy without").bound == 1e-3 and value(good, "energy without").value < 1e-6
    bad = simulate(system, 0.2, dt=2e-3, velocity=bent, rule=Feeds())
    assert bad.status is Status.UNBALANCED and "energy" in bad.message
    assert simulate(system, 0.2, dt=2e-3, velocity=bent, rule=Feeds(), balance=0.5).ok


def test_without_a_balance_it_is_not_looked_at():
    motion = simulate(free(), 0.05, dt=2e-3, velocity=bent, balance=None)
    assert not any("without a source" in check.name for check in motion.checks)


# --- a second run ----------------------------------------------------------------------------------------------------


def cantilever():
    load = sk.EdgeLoad("right", (0.0, 0.3, 1.0), history=lambda t: np.sin(40 * t) ** 2)
    held = [sk.Clamp("left")]
    return of(sk.Rectangle(0.4, 0.15), 0.008, sk.Isotropic(2e8, 0.3, 1100.0), (2, 1), "kirchhoff", held, [load]), None


def pushed_arch():
    surface = sk.CylinderSector(0.5, 0.3, 1.0, start=np.pi / 2 - 0.5)
    load = sk.SurfaceLoad((0.0, 0.0, -150.0), history=sk.Ramp(0.02))
    return of(surface, 0.01, sk.Isotropic(1e8, 0.2, 1500.0), (1, 3), "full", [sk.Clamp("start")], [load]), None


def tumbling():
    return free(), sk.RigidVelocity((1.0, 0.0, 0.0), (2.0, 9.0, 4.0), (0.25, 0.15, 0.0))


MOTIONS = {"cantilever": (cantilever, 0.15), "arch": (pushed_arch, 0.15), "tumbling": (tumbling, 0.3)}


@cache
def fine(name):
    build, t_end = MOTIONS[name]
    system, velocity = build()
    motion = simulate(system, t_end, rtol=2e-4, velocity=velocity, outputs=21)
    return system, velocity, t_end, motion.unwrap()


def rms(system, u):
    """Mass-weighted root mean square of positions."""
    one = np.zeros((system.n_dofs // 12, 4, 3))
    one[:, 0, 0] = 1
    weights = np.abs((system.mass @ one.ravel()).reshape(-1, 4, 3)[:, 0, 0])
    return np.sqrt(weights @ (u.reshape(-1, 4, 3)[:, 0] ** 2).sum(axis=1) / weights.sum())


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@pytest.mark.parametrize("asked", [{"rtol": 5e-3}, {"dt": 1e-3}], ids=["rtol", "dt"])
@pytest.mark.parametrize("name", MOTIONS)
def test_the_estimated_error_is_the_error(name, asked):
    system, velocity, t_end, reference = fine(name)
    motion = simulate(system, t_end, velocity=velocity, outputs=21, check=True, **asked)
    true = np.array([rms(system, u) for u in motion.q - reference.q])
    assert motion.error.shape == (21,) and motion.error[0] == 0
    ratio = motion.error.max() / true.max()
    assert 0.3 < ratio < 3, ratio
    # The motion is that of a run without.
    plain = simulate(system, t_end, velocity=velocity, outputs=21, **asked)
    assert plain.error is None and np.array_equal(plain.q, motion.q) and len(plain.steps) == len(motion.steps)


@pytest.mark.parametrize("options", [
    {"steps": sk.NewtonCount(1e-3)}, {"steps": sk.EnergyBalance(0.1), "rule": sk.ImplicitMidpoint()},
], ids=["count", "balance"])  # fmt: skip
def test_controls_of_which_no_double_is_known_are_refused(options):
    with pytest.raises(sk.InputError, match="check = True"):
        simulate(free(), 0.1, velocity=bent, check=True, **options)


def test_so_are_meshes_that_follow():
    surface = sk.Rectangle(0.5, 0.3)
    mesh = sk.meshes.quadtree(sk.meshes.uniform(surface, 2, 1), surface)
    system = sk.Problem(surface, 0.02, sk.Isotropic(1e7, 0.3, 1000.0)).on(mesh, "kirchhoff")
    with pytest.raises(sk.InputError, match="follow"):
        simulate(system, 0.1, velocity=bent, check=True, follow=sk.Follow(rtol=0.2))
    with pytest.raises(sk.InputError, match="check"):
        simulate(system, 0.1, velocity=bent, check="yes")


def test_a_check_that_is_taken_out_of_the_ledger_would_be_seen():
    """Checks look at the ledger: one without the rule's dissipation does not balance where much was taken."""
    with pytest.warns(sk.OutOfDepth):
        ledger = simulate(stiff_pendulum("full"), 0.5, rtol=1e-2).ledger
    assert np.abs(ledger.balance).max() < 1e-6 * ledger.turnover[-1]
    without = replace(ledger, numerical=0 * ledger.numerical)
    assert np.abs(without.balance).max() == pytest.approx(ledger.numerical[-1], rel=1e-3)
