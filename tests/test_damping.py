"""Damping of mass and material, and dashpots: the forces that a system gives for velocities."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
UNIT = sk.Rectangle(1.0, 1.0)
C = np.array([2.0, 3.0, 5.0])
MASS = 0.1 * 2000.0
"""Of the unit plate (kg)."""


def system_on(theory, supports=(), damping=None):
    problem = sk.Problem(UNIT, 0.1, sk.Isotropic(1e6, 0.3, 2000.0), list(supports), damping=damping)
    return problem.on(sk.meshes.uniform(UNIT, 3, 2), theory)


def translation(system, velocity):
    v = np.zeros((system.geometry.n_nodes, 4, 3))
    v[:, 0] = velocity
    return v.ravel()


@theories
def test_dashpots_are_the_matrices_of_springs(theory, rng):
    for where in ((0.0, 0.0), "right", ["top", "left"], "corners"):
        system = system_on(theory, [sk.Dashpot(where, tuple(C))])
        twin = system_on(theory, [sk.Spring(where, tuple(C))])
        assert np.array_equal(system.viscous.values, twin.foundation.values)
        assert np.any(system.viscous.values) and system.foundation is None and twin.viscous is None


@theories
def test_force_of_a_translation(theory):
    """alpha m v, and c v at two points and along an edge of length one."""
    v = np.array([0.3, -0.2, 0.4])
    supports = [sk.Dashpot([(0.0, 0.0), (1.0, 0.0)], tuple(C)), sk.Dashpot("top", tuple(C))]
    for alpha, dashpots, expected in ((0.0, supports, 3 * C * v), (0.7, [], 0.7 * MASS * v),
                                      (0.7, supports, 0.7 * MASS * v + 3 * C * v)):  # fmt: skip
        system = system_on(theory, dashpots, sk.Damping(mass=alpha))
        force = (system.viscous @ translation(system, v)).reshape(-1, 4, 3)[:, 0].sum(axis=0)
        assert np.allclose(force, expected, rtol=1e-12)
        assert system.shell.retardation == 0.0


@theories
def test_power_is_that_of_the_velocity_at_a_point(theory, rng):
    """v . C v is c times the square of the velocity there, whatever the rest of the plate does."""
    system = system_on(theory, [sk.Dashpot((1.0, 1.0), tuple(C))])
    v = rng.normal(size=system.n_dofs)
    at = sk.Solution(system, v).position((1.0, 1.0))
    assert np.isclose(v @ (system.viscous @ v), C @ at**2, rtol=1e-12)


def test_none_and_what_integrators_read():
    assert system_on("full").viscous is None and system_on("full").shell.retardation == 0.0
    system = system_on("full", damping=sk.Damping(stiffness=1e-3))
    assert system.viscous is None and system.shell.retardation == 1e-3
    assert system_on("full", damping=sk.Damping(mass=1.0)).viscous.values.any()


def test_dashpots_hold_nothing_at_rest():
    with pytest.raises(InputError, match="leave free"):
        sk.solve_linear(system_on("kirchhoff", [sk.Dashpot("boundary", tuple(C))]))


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.Damping(mass=-1.0), "mass = -1.0 1/s: .*zero or more"),
    (lambda: sk.Damping(stiffness=-1e-3), "stiffness = -0.001 s: .*zero or more"),
    (lambda: sk.Damping(stiffness=np.inf), "stiffness.*finite"),
    (lambda: sk.Damping(mass="much"), "mass = 'much'"),
    (lambda: sk.Dashpot("left", (1.0, -1.0, 0.0)), "damping = .*negative"),
    (lambda: sk.Dashpot("left", (0.0, 0.0, 0.0)), "one of them is positive"),
    (lambda: sk.Dashpot("left", 3.0), "damping"),
    (lambda: system_on("full", damping=0.1), "damping = 0.1: give a Damping"),
    (lambda: system_on("full", damping=sk.Damping), "give a Damping"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()
