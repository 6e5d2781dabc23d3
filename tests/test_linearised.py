"""A system to first order: its answers are the derivatives of those of the system itself, about the undeformed state."""

from math import pi

import numpy as np
import pytest

import skancf as sk
from skancf.history import Case
from skancf.statics.tangents import state_tangent
from skancf.system.linearised import Exact, Linearised, Model

CASE = Case(0.7)
WARM = sk.Isotropic(2e9, 0.3, 1000.0, expansion=1e-5)


def panel(theory):
    """A heated cylinder panel on springs: every kind of energy takes part."""
    surface = sk.CylinderSector(1.0, 0.8, 0.6, start=pi / 2 - 0.3)
    problem = sk.Problem(
        surface, 0.03, WARM, [sk.Clamp("left"), sk.Foundation(1e4), sk.Prescribed("right", (None, None, 1e-3))],
        [sk.Temperature(5.0, 20.0), sk.SurfaceLoad((10.0, 0.0, -50.0)), sk.FollowerPressure(30.0)],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, 3, 2), theory)


@pytest.fixture(params=["kirchhoff", "full"])
def system(request):
    return panel(request.param)


@pytest.fixture
def change(system):
    return 1e-3 * np.random.default_rng(1).standard_normal(system.n_dofs) * system.layout.scales.ravel()


def models(system):
    return Exact(system), Linearised(system)


# The step of the central differences: its square, and rounding over it, are both near 1e-9 of the derivatives.
STEP = 1e-4


def rate(function, system, change):
    """Central difference about the undeformed state."""
    ends = [np.asarray(function(system.undeformed + sign * STEP * change)) for sign in (1.0, -1.0)]
    return (ends[0] - ends[1]) / (2 * STEP)


def close(one, other, part=1e-6):
    assert np.abs(one - other).max() <= part * np.abs(other).max()


def test_forces_are_the_first_order_of_those_of_the_system(system, change):
    exact, linear = models(system)
    close(linear.internal_force(change), rate(exact.internal_force, system, change))
    assert np.array_equal(linear.external_force(change, CASE), linear.external_force(0 * change, CASE)), "dead"
    close(linear.external_force(change, CASE), exact.external_force(system.undeformed, CASE), 1e-14)
    close(linear.tangent(change) @ change, linear.internal_force(change), 1e-9)
    assert linear.skew(change, CASE) is None


def test_energies_are_quadratic_and_their_derivative_is_the_force(system, change):
    _, linear = models(system)
    energies = [linear.strain_energy(factor * change, CASE) for factor in (-1.0, 0.0, 1.0, 2.0)]
    # A parabola through three of them predicts the fourth.
    assert energies[3] == pytest.approx(3 * energies[2] - 3 * energies[1] + energies[0], rel=1e-9)
    held = system.shell.initial_stress_force(system.undeformed, CASE)
    slope = (energies[2] - energies[0]) / 2
    assert slope == pytest.approx(float(-held @ change), rel=1e-6)
    assert linear.work(change, CASE) == pytest.approx(0.35 * float(system.applied_force(system.undeformed) @ change))


def test_quantities_are_their_value_at_rest_and_the_linear_part(system, change):
    exact, linear = models(system)
    shell, points = system.shell, np.array([[0.3], [0.6]])

    def forces(q):
        return shell.section_forces(q, points, CASE)

    rest = forces(system.undeformed)
    close(linear.value(forces, change) - rest, rate(forces, system, change), 1e-5)
    there = system.undeformed + change
    assert np.array_equal(exact.value(forces, there), forces(there))
    assert np.abs(forces(there) - linear.value(forces, change)).max() > 1e-6 * np.abs(rest).max(), "it is bent"


def test_states_ask_their_model(system):
    small = sk.solve_linear(system)
    assert isinstance(small.model, Linearised) and small.unknowns is small.small and small.about is system.undeformed
    large = sk.Solution(system, small.q)
    assert isinstance(large.model, Exact) and large.unknowns is large.q is large.about
    for state in (small, large):
        assert isinstance(state.model, Model) and np.array_equal(state.model.q(state.unknowns), state.q)
        again = sk.Solution.of(state.model, state.unknowns, state.load_factor)
        assert again.linear is state.linear and again.strain_energy == state.strain_energy


def test_the_linear_answer_is_the_equilibrium_of_its_model(system):
    small = sk.solve_linear(system)
    model, u = small.model, small.unknowns
    residual = system.constraints.free_part(model.internal_force(u) - model.external_force(u))
    assert np.abs(residual).max() < 1e-9 * np.abs(model.external_force(u)).max()
    assert np.abs(system.constraints.fixed_part(u - model.held(1.0))).max() < 1e-15
    other = system.constraints.free_part(system.internal_force(small.q) - system.external_force(small.q))
    assert np.abs(other).max() > 1e-6 * np.abs(model.external_force(u)).max(), "of large changes it is none"


def test_the_prestressed_tangent_has_the_stresses_of_the_answer_on_the_undeformed_place(system):
    small = sk.solve_linear(system)
    stresses = small.model.strained(small.unknowns)[1]
    direct = system.tangent(system.undeformed, small.case, stresses).values
    # The difference of two matrices, of which the smaller part is 1e-3, loses that many digits of 1e-15.
    close(state_tangent(system, small).values - system.stiffness().values, direct - system.stiffness().values, 1e-8)
    assert np.abs(direct - system.stiffness().values).max() > 1e-6 * np.abs(direct).max()
