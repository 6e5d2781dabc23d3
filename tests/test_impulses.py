"""Impulses: momentum and angular momentum that they give, their times, and that statics does not see them."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.linear import Constraints, DirectSolver

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
UNIT = sk.Rectangle(1.0, 1.0)
ONE = (0.3, -0.2, 0.7)


def system_on(theory, *loads, surface=UNIT, supports=()):
    problem = sk.Problem(surface, 0.1, sk.Isotropic(1e6, 0.3, 2000.0), list(supports), list(loads))
    return problem.on(sk.meshes.uniform(surface, 3, 3), theory)


def jump(system, impulse):
    """M^-1 of an impulse, of a free body."""
    free = Constraints(np.zeros((system.geometry.n_nodes, 12), dtype=bool))
    with DirectSolver(system.pattern, free) as solver:
        solver.factor(system.mass)
        return solver.solve(impulse, refinements=2)


@theories
def test_a_free_body_gets_the_momentum(theory):
    at = (0.37, 0.81)
    system = system_on(theory, sk.Impulse(at, ONE, time=0.5))
    [(time, impulse)] = system.loads.impulses()
    momenta = system.momenta(system.undeformed, jump(system, impulse))
    assert time == 0.5
    assert np.allclose(momenta, [ONE, np.cross([*at, 0.0], ONE)], rtol=0, atol=1e-10)


@theories
def test_along_an_edge(theory):
    """Its length times a constant, and the integral of a function; about the origin too."""
    system = system_on(theory, sk.EdgeImpulse("right", ONE))
    [(_, impulse)] = system.loads.impulses()
    assert np.allclose(impulse.reshape(-1, 4, 3)[:, 0].sum(axis=0), ONE, rtol=1e-12)
    angular = system.momenta(system.undeformed, jump(system, impulse))[1]
    assert np.allclose(angular, np.cross([1.0, 0.5, 0.0], ONE), rtol=0, atol=1e-10)
    sector = sk.CylinderSector(2.0, 3.0, 0.5)
    system = system_on(theory, sk.EdgeImpulse("left", lambda x, y: np.stack([0 * x, y, 0 * x])), surface=sector)
    [(_, impulse)] = system.loads.impulses()
    assert np.isclose(impulse.reshape(-1, 4, 3)[:, 0, 1].sum(), 2.0 * 0.5**2 / 2, rtol=1e-10), "radius times angles"


def test_equal_times_come_together_in_order():
    loads = [sk.Impulse((0.2, 0.2), ONE, 2.0), sk.PointForce((0.5, 0.5), (0, 0, 1.0)), sk.Impulse((0.8, 0.2), ONE, 1.0),
             sk.EdgeImpulse("left", ONE, 2.0)]  # fmt: skip
    system = system_on("full", *loads)
    found = system.loads.impulses()
    assert [time for time, _ in found] == [1.0, 2.0]
    alone = [system_on("full", load).loads.impulses()[0][1] for load in (loads[2], loads[0], loads[3])]
    assert np.allclose(found[0][1], alone[0], rtol=1e-14) and np.allclose(found[1][1], alone[1] + alone[2], rtol=1e-14)
    assert system_on("full").loads.impulses() == []


@theories
def test_no_force_at_any_time(theory):
    system = system_on(theory, sk.Impulse((0.5, 0.5), ONE, 1.0), supports=[sk.Clamp("left")])
    for time in (None, 0.0, 1.0):
        assert not system.external_force(system.undeformed, sk.Case(time=time)).any()
    assert np.abs(sk.solve_linear(system).displacements).max() == 0.0


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.Impulse((0.5, 0.5), (0, 0)), "impulse = .*give 3 numbers"),
    (lambda: sk.Impulse((0.5,), ONE), "at = .*give 2 numbers"),
    (lambda: sk.Impulse((0.5, 0.5), ONE, np.nan), "time.*not finite"),
    (lambda: sk.EdgeImpulse("left", 3.0), "impulse = 3.0: give 3 numbers"),
    (lambda: system_on("full", sk.Impulse((1.5, 0.5), ONE)), "outside the surface"),
    (lambda: system_on("full", sk.EdgeImpulse((0.0, 0.0), ONE)), "no edge of the boundary"),
    (lambda: system_on("full", sk.EdgeImpulse("left", lambda x, y: (1.0, 2.0))), "impulse of shape"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()
