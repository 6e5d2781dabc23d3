"""The potential of gravity."""

import numpy as np
import pytest

import skancf as sk

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
G = np.array([1.0, -2.0, -9.81])
SURFACE = sk.CylinderSector(1.0, 2.0, 1.0)


def weight_of(system):
    return system.loads.applied(system.undeformed, None, sk.Case(), potential=True)


def system_on(theory, *loads):
    problem = sk.Problem(SURFACE, 0.05, sk.Isotropic(1e6, 0.3, 2000.0), [sk.Clamp("start")], list(loads))
    return problem.on(sk.meshes.uniform(SURFACE, 3, 3), theory)


@theories
def test_weight_is_the_force_of_gravity(theory, rng):
    system = system_on(theory, sk.Gravity(tuple(G)), sk.SurfaceLoad((0, 0, 5.0)))
    alone = system_on(theory, sk.Gravity(tuple(G)))
    q = system.undeformed + 0.01 * rng.normal(size=system.n_dofs)
    assert np.array_equal(weight_of(system), alone.external_force(q, sk.Case(time=3.0)))
    assert not np.allclose(weight_of(system), system.external_force(q, sk.Case(time=3.0))), "the other load is no weight"
    # Raising the whole body: minus the weight times the height; the mass is that of the mass matrix.
    raised = np.zeros((system.geometry.n_nodes, 4, 3))
    raised[:, 0] = [0.1, 0.2, 0.3]
    unit = np.zeros_like(raised)
    unit[:, 0, 0] = 1.0
    mass = 2 * system.kinetic_energy(unit.ravel())
    assert np.isclose(-weight_of(system) @ raised.ravel(), -mass * G @ [0.1, 0.2, 0.3], rtol=1e-12)


@theories
def test_two_add_and_one_in_time_does_not_count(theory):
    one, two = system_on(theory, sk.Gravity(tuple(G))), system_on(theory, sk.Gravity(tuple(G)), sk.Gravity(tuple(2 * G)))
    assert np.allclose(weight_of(two), 3 * weight_of(one), rtol=1e-14)
    varying = system_on(theory, sk.Gravity(tuple(G), history=lambda t: 1.0))
    assert not weight_of(varying).any() and varying.external_force(varying.undeformed, sk.Case(time=0.0)).any()
    none = system_on(theory)
    assert weight_of(none).shape == (none.n_dofs,) and not weight_of(none).any()


def test_weight_that_turns_with_the_normals_is_left_out():
    laminate = sk.Laminate([sk.Layer(sk.Isotropic(1e6, 0.3, 2000.0), 0.05)], offset=0.02)
    problem = sk.Problem(SURFACE, material=laminate, supports=[sk.Clamp("start")], loads=[sk.Gravity(tuple(G))])
    system = problem.on(sk.meshes.uniform(SURFACE, 3, 3), "kirchhoff")
    assert not weight_of(system).any() and system.external_force(system.undeformed).any()
