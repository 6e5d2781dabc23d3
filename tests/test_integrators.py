"""The four rules of integration: order, with damping and driven edges too, error constants, damping of a mode."""

from functools import cache

import numpy as np
import pytest

import skancf as sk

RULES = {
    "generalised alpha": sk.GeneralizedAlpha(),
    "midpoint": sk.ImplicitMidpoint(),
    "trapezoidal": sk.Trapezoidal(),
    "energy momentum": sk.EnergyMomentum(),
}
rules = pytest.mark.parametrize("rule", RULES)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
T_END = 0.1
TIGHT = 1e-9


def cantilever(theory, supports=(), loads=(), damping=None, n=2):
    surface = sk.Rectangle(1.0, 0.4)
    held = [sk.Clamp("left"), *supports]
    problem = sk.Problem(surface, 0.1, sk.Isotropic(1e6, 0.3, 1000.0), held, list(loads), damping)
    return problem.on(sk.meshes.uniform(surface, n, 1), theory)


def run(system, t_end, n, rule, **options):
    motion = sk.simulate(system, t_end, dt=t_end / n, rule=rule, progress=False, newton_rtol=TIGHT, balance=None, **options)
    assert motion.ok and len(motion.steps) == n
    return motion


# --- order -----------------------------------------------------------------------------------------------------------


DAMPED = sk.Damping(mass=1.0, stiffness=2e-3)


def smooth(t):
    """Three derivatives vanish at the start, so that no mode is struck that the steps do not resolve."""
    return np.sin(30 * t) ** 4


def driven(t):
    """Begins with an acceleration."""
    return 1 - np.cos(30 * t)


PULL = sk.EdgeLoad("right", (0.0, 0.0, 8.0), history=smooth)
CASES = {
    "loaded": lambda theory: cantilever(theory, loads=[PULL]),
    "damped": lambda theory: cantilever(theory, [sk.Dashpot("right", (3.0, 3.0, 20.0))], [PULL], DAMPED),
    "driven": lambda theory: cantilever(theory, [sk.Prescribed((1.0, 0.0), (None, None, 0.05), driven)], damping=DAMPED),
}


def positions(a):
    return a.reshape(-1, 4, 3)[:, 0]


@cache
def reference(theory, case):
    """End of a fine run, and its error of order two taken out: positions and velocities."""
    system = CASES[case](theory)
    coarse, fine = (run(system, T_END, n, sk.GeneralizedAlpha(), outputs=2) for n in (256, 512))
    return system, [positions((4 * getattr(fine, k)[-1] - getattr(coarse, k)[-1]) / 3) for k in ("q", "v")]


@theories
@pytest.mark.parametrize("case", CASES)
@rules
def test_order_two_in_position_and_velocity(rule, case, theory):
    system, exact = reference(theory, case)
    sizes = [np.abs(exact[0] - positions(system.undeformed)).max(), np.abs(exact[1]).max()]
    errors = []
    for n in (64, 128):
        motion = run(system, T_END, n, RULES[rule], outputs=2)
        found = [positions(values[-1]) for values in (motion.q, motion.v)]
        errors.append([np.abs(a - b).max() / size for a, b, size in zip(found, exact, sizes, strict=True)])
    rates = np.log2(np.divide(*errors))
    # Measured 1.93 to 2.08.
    assert (rates > 1.85).all() and (rates < 2.2).all(), (rates, errors)
    # Measured: at most 6e-5 of the displacement and 4e-4 of the velocity.
    assert (np.array(errors[-1]) < [1e-4, 6e-4]).all(), errors


def test_a_lower_order_would_be_seen():
    """Backward differences of the same motion: Newmark's formulas with gamma = 1 have order one."""

    class FirstOrder(sk.Trapezoidal):
        gamma, beta = 1.0, 0.5

    system, exact = reference("kirchhoff", "loaded")
    errors = [np.abs(positions(run(system, T_END, n, FirstOrder(), outputs=2).q[-1]) - exact[0]).max() for n in (64, 128)]
    assert 0.7 < np.log2(errors[0] / errors[1]) < 1.3


@theories
def test_generalised_alpha_without_damping_is_the_midpoint_rule(theory):
    system = CASES["damped"](theory)
    one, two = (run(system, T_END, 40, rule, outputs=2) for rule in (sk.GeneralizedAlpha(1.0), sk.ImplicitMidpoint()))
    size = np.abs(two.q[-1] - system.undeformed).max()
    # Newton's method ends at 1e-9 of the motion.
    assert np.abs(one.q[-1] - two.q[-1]).max() < 1e-7 * size
    assert np.abs(one.v[-1] - two.v[-1]).max() < 1e-6 * np.abs(two.v[-1]).max()
    other = run(system, T_END, 40, sk.GeneralizedAlpha(0.9), outputs=2)
    assert np.abs(one.q[-1] - other.q[-1]).max() > 1e-5 * size


# --- a linear oscillator ---------------------------------------------------------------------------------------------


@cache
def first_mode(theory):
    system = cantilever(theory, n=3)
    found = sk.modes(system, 1)
    return system, found.shapes[0], float(found.omega[0])


def frequency_and_damping(system, mode, rule, dt, n=60):
    """Of the free vibration in a mode, from the recurrence of the states: x_{k+2} = 2 rho cos(theta) x_{k+1} - rho^2 x_k."""
    small = 1e-4 * mode / np.abs(positions(mode)).max()
    motion = run(system, n * dt, n, rule, start=sk.Solution(system, system.undeformed + small), outputs=n + 1)
    x = ((motion.q - system.undeformed) @ (system.mass @ mode))[10:]
    (minus_square, twice), *_ = np.linalg.lstsq(np.stack([x[:-2], x[1:-1]], axis=1), x[2:], rcond=None)
    rho = np.sqrt(-minus_square)
    theta = np.arccos(twice / (2 * rho))
    return theta / dt, -np.log(rho) / theta


@theories
@pytest.mark.parametrize("rule", [*RULES.values(), sk.GeneralizedAlpha(0.0), sk.GeneralizedAlpha(1.0)])
def test_error_constant_is_that_of_the_frequency(rule, theory):
    r"""omega (1 - c (omega dt)^2), so that a step adds c dt^3 of the third derivative; and what it damps, of order three."""
    system, mode, omega = first_mode(theory)
    constants, ratios = [], []
    for step in (0.2, 0.1):
        found, ratio = frequency_and_damping(system, mode, rule, step / omega)
        constants.append((1 - found / omega) / step**2)
        ratios.append(ratio)
    # The next term is of order (omega dt)^2; it is largest with rho_inf = 0, 0.01 of c = 0.46 at the finer step.
    extrapolated = (4 * constants[1] - constants[0]) / 3
    assert extrapolated == pytest.approx(rule.error_constant, rel=5e-3)
    assert abs(constants[1] - rule.error_constant) < abs(constants[0] - rule.error_constant)
    if getattr(rule, "rho_inf", 1.0) < 1:
        assert np.log2(ratios[0] / ratios[1]) == pytest.approx(3, abs=0.2)
    else:
        assert np.abs(ratios).max() < 1e-7, "rounding of the fit"


@theories
@rules
@pytest.mark.parametrize("damping", [(0.1, 0.0), (0.0, 0.1), (0.1, 0.06)])
def test_damping_ratio_of_a_mode(damping, rule, theory):
    undamped, mode, omega = first_mode(theory)
    alpha, beta = damping[0] * omega, damping[1] / omega
    system = cantilever(theory, damping=sk.Damping(mass=alpha, stiffness=beta), n=3)
    ratio = alpha / (2 * omega) + beta * omega / 2
    frequency, found = frequency_and_damping(system, mode, RULES[rule], 0.1 / omega)
    # The fit gives ln rho / theta; the steps' own error is c (omega dt)^2 = 1e-3.
    assert found == pytest.approx(ratio / np.sqrt(1 - ratio**2), rel=3e-3)
    assert frequency == pytest.approx(omega * np.sqrt(1 - ratio**2), rel=1.5e-3)
    assert abs(frequency_and_damping(undamped, mode, RULES[rule], 0.1 / omega)[1]) < 1e-5
