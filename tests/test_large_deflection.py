"""Large rotations against the elastica: accuracy, load steps, iterations, solvers."""

from functools import cache

import numpy as np
import pytest
from reference import elastica
from scipy.integrate import solve_bvp

import skancf as sk
from skancf.linear import available_backends
from skancf.solving import Status

YOUNG, THICKNESS, WIDTH = 1.2e6, 0.1, 1.0
RIGIDITY = YOUNG * WIDTH * THICKNESS**3 / 12
LOADS = (1.0, 2.0, 4.0, 7.0, 10.0)


def strip(length, load):
    material = sk.Isotropic(YOUNG, 0.0, 1.0)
    return sk.Problem(sk.Rectangle(length, WIDTH), THICKNESS, material, [sk.Clamp("left")], [load])


def pushed(n, alpha, length=10.0, assumed=True):
    """A cantilever under a transverse dead force P L^2 / E I = alpha at its end."""
    problem = strip(length, sk.EdgeLoad("right", (0, 0, alpha * RIGIDITY / length**2 / WIDTH)))
    return problem.on(sk.meshes.uniform(problem.surface, n, 1), sk.Full(assumed=assumed))


@cache
def bent(n, alpha):
    return sk.solve(pushed(n, alpha))


@cache
def rolled(n, turns, assumed=True, length=12.0):
    """-u and w at the tip of a strip under an end moment."""
    problem = strip(length, sk.EdgeMoment("right", (0, -turns * 2 * np.pi * RIGIDITY / length, 0)))
    system = problem.on(sk.meshes.uniform(problem.surface, n, 1), sk.Full(assumed=assumed))
    u = sk.solve(system).unwrap().displacement((length, WIDTH / 2))
    return -u[0], u[2]


def tip_error(result, alpha, length=10.0):
    """Of the displacement of the tip, over the length."""
    u = result.solution.displacement((length, WIDTH / 2)) / length
    along, across = elastica.tip(alpha)
    assert abs(u[1]) < 1e-9, "the strip stays in its plane"
    return np.hypot(u[0] + along, u[2] - across)


# --- the reference ---------------------------------------------------------------------------------------------------


def test_elastica_agrees_with_published_and_integrated_values():
    # Mattiasson (1981), Int. J. Numer. Meth. Eng. 17, 145-153, table of the cantilever: w / L and u / L.
    for alpha, across, along in ((1.0, 0.30172, 0.05643), (5.0, 0.71379, 0.38763), (10.0, 0.81061, 0.55500)):
        assert np.allclose(elastica.tip(alpha), (along, across), rtol=0, atol=6e-6)
    for alpha in (1.0, 10.0):
        s = np.linspace(0, 1, 41)
        ode = solve_bvp(
            lambda s, y, alpha=alpha: np.array([y[1], -alpha * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
            lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
            s, np.array([s, 1 - s, s, s * s / 2]), tol=1e-9,
        )  # fmt: skip
        assert np.allclose(elastica.tip(alpha), (1 - ode.y[2, -1], ode.y[3, -1]), atol=1e-8)


# --- end force -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("alpha", LOADS)
def test_elastica_in_one_load_step(alpha):
    """Measured, percent of the length: 16 elements 0.007 to 0.26, 32 elements 0.003 to 0.07."""
    for n, allowed in ((16, 0.005), (32, 0.001)):
        result = bent(n, alpha)
        assert result.status is Status.CONVERGED and len(result.path) == 2, "the whole load at once"
        assert tip_error(result, alpha) < allowed


def test_elastica_converges_with_order_two():
    errors = [tip_error(bent(n, 10.0), 10.0) for n in (8, 16, 32)]
    # The strip has axial and shear strain, 1e-4 of the length at this load, which the elastica has not.
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 1.6).all()


def test_plain_element_locks_where_the_assumed_one_does_not():
    system = pushed(8, 10.0, assumed=False)
    plain = tip_error(sk.solve(system), 10.0)
    assert plain > 3 * tip_error(bent(8, 10.0), 10.0)


def test_linear_answer_is_the_start_of_the_curve():
    alpha = 1e-3
    w = elastica.tip(alpha)[1]
    assert np.isclose(w, alpha / 3, rtol=1e-5)
    for n in (16, 32):
        linear = sk.solve_linear(pushed(n, alpha)).displacement((10.0, 0.5))[2] / 10.0
        full = sk.solve(pushed(n, alpha)).solution.displacement((10.0, 0.5))[2] / 10.0
        assert np.isclose(linear, full, rtol=1e-5)  # (w / L)^2 is 1e-7
        assert np.isclose(linear, w, rtol=0.5 / n**2 + 1e-4)  # bending by order 2, shear 1e-4
    far = sk.solve_linear(pushed(16, 4.0)).displacement((10.0, 0.5))[2] / 10.0
    assert far > 1.9 * elastica.tip(4.0)[1], "the linear answer is of no use here"


# --- end moment: roll-up ---------------------------------------------------------------------------------------------

# Tip (-u, w), length 12; computed independently beforehand with the same strains on another implementation.
PLAIN = {(8, 0.25): (3.006, 6.628), (16, 0.25): (4.211, 7.545)}
ASSUMED = {
    (16, 0.25): (4.381, 7.651), (16, 0.5): (12.128, 7.555), (16, 1.0): (11.467, 0.080),
    (32, 0.25): (4.366, 7.642), (32, 0.5): (12.035, 7.616), (32, 1.0): (11.859, 0.005),
}  # fmt: skip


@pytest.mark.parametrize("case", ASSUMED, ids=str)
def test_roll_up(case):
    n, turns = case
    tip = rolled(n, turns)
    assert np.allclose(tip, ASSUMED[case], rtol=0, atol=1.5e-3)  # printed to three decimals, Newton to 1e-7
    error = np.hypot(*np.subtract(tip, elastica.rolled(turns, 12.0))) / 12.0
    # Order 2 in the angle that one element turns: measured 0.044 to 0.055 of the length times its square.
    assert error < 0.06 * (turns * 16 / n) ** 2


@pytest.mark.parametrize("case", PLAIN, ids=str)
def test_plain_element_locks_in_roll_up(case):
    """Bilinear directors shorten between nodes: thickness strain, -13 % of the deflection on 8 elements."""
    tip = rolled(*case, assumed=False)
    assert np.allclose(tip, PLAIN[case], rtol=0, atol=1.5e-3)
    exact = elastica.rolled(case[1], 12.0)
    assert np.hypot(*np.subtract(tip, exact)) > 5 * np.hypot(*np.subtract(rolled(case[0], case[1]), exact))


# --- Newton's method -------------------------------------------------------------------------------------------------


def test_mixed_tangent_needs_fewer_iterations_for_the_same_answer():
    plain = sk.solve(pushed(16, 4.0), mixed=False)
    mixed = bent(16, 4.0)
    assert mixed.iterations <= 9  # measured 7
    assert plain.status is Status.CONVERGED and plain.iterations >= 2 * mixed.iterations
    assert np.abs(plain.solution.q - mixed.solution.q).max() < 1e-5  # both to 1e-7 of the energy norm, length 10


def test_backends_agree():
    backends = available_backends()
    if len(backends) < 2:
        pytest.skip("one solver only on this machine")
    answers = [sk.solve(pushed(8, 4.0), backend=name, rtol=1e-9) for name in backends]
    for answer in answers[1:]:
        assert answer.iterations == answers[0].iterations
        assert np.abs(answer.solution.q - answers[0].solution.q).max() < 1e-8


def test_load_path_does_not_matter():
    """Elastic: the same end by one step or by many."""
    system = pushed(8, 4.0)
    steps = sk.solve(system, control=sk.statics.HalveAndGrow(first=0.2, growth=1.0))
    assert len(steps.path) == 6
    assert np.allclose([s.load_factor for s in steps.path], np.linspace(0, 1, 6), atol=1e-12)
    assert np.abs(steps.solution.q - bent(8, 4.0).solution.q).max() < 1e-5
    energies = [s.strain_energy for s in steps.path]
    assert (np.diff(energies) > 0).all()
