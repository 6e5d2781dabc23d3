"""The dissipative energy-momentum rule: what it does to one mode, and that no step makes a free body gain anything."""

from functools import cache

import numpy as np
import pytest

import skancf as sk

pytestmark = pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")  # of coarse laminates, and of rough motions
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
PERIODS = 20
OMEGA_DT = 0.2


def simulate(system, t_end, **options):
    return sk.simulate(system, t_end, progress=False, **{"balance": None, "outputs": "steps"} | options)


# --- one bending mode ------------------------------------------------------------------------------------------------


@cache
def bending(theory):
    """A cantilever with its first mode, so small that nothing but that mode moves."""
    surface = sk.Rectangle(0.9, 0.25)
    problem = sk.Problem(surface, 0.06, sk.Isotropic(3e6, 0.2, 1500.0), [sk.Clamp("left")])
    system = problem.on(sk.meshes.uniform(surface, 2, 1), theory)
    found = sk.modes(system, 1)
    mode = found.shapes[0]
    return system, 1e-5 * mode / np.abs(mode.reshape(-1, 4, 3)[:, 0]).max(), float(found.omega[0])


class Alternating:
    """A step, a longer one, and again."""

    smallest = 1e-6

    def __init__(self, short, ratio):
        self.lengths = short, ratio * short

    def first(self, guess):
        return self.lengths[0]

    def accepts(self, attempt):
        return True

    def next_step(self, attempt):
        return self.lengths[int(attempt.dt < 0.5 * sum(self.lengths))]


def oscillation(rule, theory, n, control):
    """Coordinates of the mode at the ends of n steps, (n + 1,), over that at the start."""
    system, mode, _ = bending(theory)
    span = sum(control(k) for k in range(n)) if callable(control) else n * control
    steps = {"dt": control} if not callable(control) else {"steps": Alternating(control(0), control(1) / control(0))}
    start = sk.Solution(system, system.undeformed + mode)
    motion = simulate(system, span, rule=rule, newton_rtol=1e-9, start=start, **steps)
    assert len(motion.steps) == n
    x = (motion.q - system.undeformed) @ (system.mass @ mode)
    return x / x[0]


def frequency_and_damping(x):
    """Angle and damping ratio of a sample, of x_{k+2} = 2 rho cos(theta) x_{k+1} - rho^2 x_k."""
    (minus_square, twice), *_ = np.linalg.lstsq(np.stack([x[:-2], x[1:-1]], axis=1), x[2:], rcond=None)
    rho = np.sqrt(-minus_square)
    theta = np.arccos(twice / (2 * rho))
    return theta, -np.log(rho) / theta


@pytest.mark.parametrize(("rho_inf", "theory"), [(1 / 3, "kirchhoff"), (0.6, "full"), (0.8, "kirchhoff")])
def test_what_twenty_periods_do_to_a_mode(rho_inf, theory):
    """Measured 1 % below c and 2 % below chi / 4: the next terms are of order (omega dt)^2 = 4 % of these."""
    rule, omega = sk.EnergyMomentum(rho_inf), bending(theory)[2]
    n = int(PERIODS * 2 * np.pi / OMEGA_DT)
    x = oscillation(rule, theory, n, OMEGA_DT / omega)
    theta, ratio = frequency_and_damping(x[10:])
    assert (1 - theta / OMEGA_DT) / OMEGA_DT**2 == pytest.approx(1 / 12 + rule.chi / 2, rel=0.03)
    assert ratio / OMEGA_DT**3 == pytest.approx(rule.chi / 4, rel=0.03)
    # The same by eye: the amplitude of the last period, and the phase at the end, which is off by half a radian.
    assert np.abs(x[-40:]).max() == pytest.approx(np.exp(-rule.chi / 4 * OMEGA_DT**3 * n * OMEGA_DT), rel=0.01)
    behind = n * OMEGA_DT**3 * (1 / 12 + rule.chi / 2)
    assert behind > 0.4
    k = np.arange(n - 40, n + 1)
    assert np.abs(x[k] - np.abs(x[-40:]).max() * np.cos(k * OMEGA_DT * (1 - behind / (n * OMEGA_DT)))).max() < 0.03
    # Without dissipation, and with that of another radius, all of this fails.
    for other in (sk.EnergyMomentum(1.0), sk.EnergyMomentum(0.5)):
        assert abs(other.chi / rule.chi - 1) > 0.06


@theories
def test_the_mode_is_kept_without_dissipation(theory):
    x = oscillation(sk.EnergyMomentum(1.0), theory, 100, OMEGA_DT / bending(theory)[2])
    theta, ratio = frequency_and_damping(x)
    assert abs(ratio) < 1e-8, "rounding of the fit"
    assert (1 - theta / OMEGA_DT) / OMEGA_DT**2 == pytest.approx(1 / 12, rel=0.01)


def recurrence(rule, omega, lengths, n):
    """The scalar oscillator under formulas of the rule with steps of these lengths in turn, from rest at one."""
    x, v, last, earlier, out = 1.0, 0.0, 0.0, None, [1.0]
    for k in range(n):
        dt = lengths[k % len(lengths)]
        r = 0.0 if earlier is None else min(1.0, dt / earlier)
        chi = rule.chi
        # (v' - v) / dt + omega^2 [ x/2 + x'/2 + chi (x' - x) - chi r last ] = 0, and x' - x = dt (v + v') / 2.
        u = dt * (v - 0.5 * dt * omega**2 * (x - chi * r * last)) / (1 + 0.5 * dt**2 * omega**2 * (0.5 + chi))
        x, v, last, earlier = x + u, 2 * u / dt - v, u, dt
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("rho_inf", [1 / 3, 0.8])
def test_steps_that_alternate_are_those_of_the_scalar_oscillator(rho_inf):
    """1 : 1.6. What is out of phase is of order two; what a step that grows takes is chi (dt - dt_old) of the rate."""
    rule, omega, ratio, n = sk.EnergyMomentum(rho_inf), bending("kirchhoff")[2], 1.6, 120
    phases, decays = [], []
    for size in (OMEGA_DT, OMEGA_DT / 2):
        lengths = np.array([1, ratio]) * size / omega * 2 / (1 + ratio)
        x = oscillation(rule, "kirchhoff", n, lambda k: lengths[k % 2])  # noqa: B023
        # Newton's method ends at 1e-9; the other modes and the nonlinear terms are 1e-5 of this one.
        assert np.abs(x - recurrence(rule, omega, lengths, n)).max() < 1e-4
        theta, decay = frequency_and_damping(x[10::2])
        phases.append(1 - theta / (2 * size))
        decays.append(decay)
        short = lengths[0] * omega
        assert decay == pytest.approx(rule.chi * short * ratio * (ratio - 1) / (2 * (1 + ratio)), rel=0.05)
    assert np.log2(phases[0] / phases[1]) == pytest.approx(2, abs=0.05)
    assert np.log2(decays[0] / decays[1]) == pytest.approx(1, abs=0.1)
    wrong = recurrence(rule, omega, lengths[::-1], n)
    assert np.abs(x - wrong).max() > 1e-2, "lengths in another order are not told apart"


@theories
@pytest.mark.parametrize("rho_inf", [1 / 3, 0.6, 0.8, 0.95])
def test_order_two_by_halving(rho_inf, theory):
    """Of the mode after a fixed time, against the cosine: measured 1.97 to 2.01."""
    omega, errors = bending(theory)[2], []
    for n in (40, 80):
        dt = 8 / n / omega
        x = oscillation(sk.EnergyMomentum(rho_inf), theory, n, dt)
        errors.append(np.abs(x - np.cos(omega * dt * np.arange(n + 1))).max())
    assert 1.9 < np.log2(errors[0] / errors[1]) < 2.1, errors


# --- bodies that are free --------------------------------------------------------------------------------------------

PLATE = sk.Rectangle(0.6, 0.5)
PLY = sk.Orthotropic(young=(9e9, 2e9, 2e9), poisson=(0.25, 0.1, 0.3), shear=(1e9, 8e8, 7e8), density=1600.0)
CORE = sk.Isotropic(4e8, 0.3, 300.0)
LAYERS = sk.Laminate([sk.Layer(PLY, 0.001, 0.4), sk.Layer(CORE, 0.004), sk.Layer(PLY, 0.0015, -0.9)], 0.002)
N = 12


@cache
def l_shape(theory, stiffness=0.0):
    damping = sk.Damping(stiffness=stiffness) if stiffness else None
    problem = sk.Problem(PLATE, None, LAYERS, damping=damping)
    mesh = sk.meshes.tensor(PLATE, np.linspace(0, 0.6, 4), np.linspace(0, 0.5, 4), openings=[((0.2, 0.6), (1 / 6, 0.5))])
    return problem.on(mesh, theory)


@cache
def slowest_period(theory):
    return float(2 * np.pi / sk.modes(l_shape(theory), 7).omega[6])


def rough(system, seed):
    """Every node by chance, besides a flight that tumbles: no step but the shortest resolves it."""
    rng = np.random.default_rng(seed)
    v = np.zeros((system.n_dofs // 12, 4, 3))
    v[:, 0], v[:, 1:3] = rng.standard_normal((len(v), 3)), 5 * rng.standard_normal((len(v), 2, 3))
    if system.geometry.theory.directors:
        v[:, 3] = 5 * rng.standard_normal((len(v), 3))
    return v.ravel() + sk.RigidVelocity((1.0, 2.0, 3.0), (3.0, -5.0, 4.0)).at(system.undeformed)


def gains(ledger):
    """Largest energy over the first, less one, and the largest relative change of both momenta."""
    drifts = [np.linalg.norm(p - p[0], axis=1).max() / np.linalg.norm(p[0]) for p in (ledger.linear, ledger.angular)]
    return ledger.energy.max() / ledger.energy[0] - 1, max(drifts)


@theories
@pytest.mark.parametrize("stiffness", [0.0, 1e-5])
@pytest.mark.parametrize("part", [1e-5, 1e-4, 1e-3, 1e-2, 1e-1])
def test_a_free_body_never_gains(part, stiffness, theory):
    """Layers off the reference surface, an L, at steps of so many periods of its slowest mode."""
    system, dt = l_shape(theory, stiffness), part * slowest_period(theory)
    ledger = simulate(system, N * dt, dt=dt, velocity=rough(system, 5)).ledger
    assert ledger.times[-1] == pytest.approx(N * dt)
    gained, drift = gains(ledger)
    # What Newton's method leaves, 1e-6 in the norm of energy: measured 0 and 1.3e-8.
    assert gained <= 1e-9 and drift < 1e-7
    # What the rule takes is booked.
    assert np.abs(ledger.balance).max() < 1e-7 * ledger.energy[0]
    assert (ledger.dissipation[-1] > 1e-4 * ledger.energy[0]) == (stiffness > 0)
    if part >= 1e-3:
        assert ledger.numerical[-1] > 1e-5 * ledger.energy[0], "there was nothing to take out"
        assert ledger.strain.max() > 1e-3 * ledger.energy[0], "nothing was strained"


def test_a_free_body_never_gains_in_steps_of_any_length():
    """Lengths by chance over a factor of ten."""
    system, rng = l_shape("kirchhoff"), np.random.default_rng(11)

    class ByChance(Alternating):
        def next_step(self, attempt):
            return self.lengths[0] * 10 ** rng.uniform(0, 1)

    dt = 1e-3 * slowest_period("kirchhoff")
    motion = simulate(system, 200 * dt, steps=ByChance(dt, 1.0), velocity=rough(system, 6))
    gained, drift = gains(motion.ledger)
    assert len(motion.steps) > 30 and len({step.dt for step in motion.steps}) > 30
    assert gained <= 1e-9 and drift < 1e-7


@pytest.mark.parametrize(("rule", "which", "least"), [(sk.ImplicitMidpoint(), 0, 1e-4), (sk.GeneralizedAlpha(), 1, 1e-5)],
                         ids=["energy", "momentum"])  # fmt: skip
@theories
def test_other_rules_gain(theory, rule, which, least):
    """What the tests above measure is no matter of course."""
    system, dt = l_shape(theory), 3e-2 * slowest_period(theory)
    ledger = simulate(system, 2 * N * dt, dt=dt, rule=rule, velocity=rough(system, 5)).ledger
    assert gains(ledger)[which] > least


@pytest.mark.parametrize("rho_inf", [0.3, 1.01, 0.0, -1.0, np.nan])
def test_radii_that_the_rule_does_not_have(rho_inf):
    with pytest.raises(sk.InputError, match="rho_inf"):
        sk.EnergyMomentum(rho_inf)
    with pytest.raises(sk.InputError, match="rho_inf"):
        sk.simulate(l_shape("full"), 1.0, rho_inf=rho_inf, progress=False)
