"""Energy and momenta of free bodies, at steps that resolve little; the same run in a turned frame."""

import numpy as np
import pytest

import skancf as sk
from skancf.dynamics.initial import initial_velocity
from skancf.solving import Status

UNIT = sk.Rectangle(1.0, 0.8)
CYLINDER = sk.CylinderSector(1.0, 1.0, 1.2)
ISOTROPIC = sk.Isotropic(1e6, 0.3, 1000.0)
PLY = sk.Orthotropic(young=(5e5, 1e5, 1e5), poisson=(0.2, 0.1, 0.3), shear=(6e4, 5e4, 4e4), density=2000.0)
LAMINATE = sk.Laminate([sk.Layer(PLY, 0.03, 0.3), sk.Layer(PLY, 0.02, -1.1)])
BODIES = {
    "flat": (sk.Problem(UNIT, 0.05, ISOTROPIC), sk.meshes.uniform(UNIT, 3, 2)),
    "curved": (sk.Problem(CYLINDER, 0.05, ISOTROPIC), sk.meshes.uniform(CYLINDER, 3, 3)),
    "hanging nodes": (sk.Problem(UNIT, 0.05, ISOTROPIC), sk.meshes.quadtree(sk.meshes.uniform(UNIT, 2, 2)).refined([0])),
    "laminate": (sk.Problem(UNIT, None, LAMINATE), sk.meshes.uniform(UNIT, 3, 2)),
}
bodies = pytest.mark.parametrize("body", BODIES)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full", sk.Full(assumed=False)], ids=["thin", "full", "plain"])

# Newton's method ends at 1e-11 in the energy norm, and what it leaves adds up over the steps; measured 2e-12.
KEPT = 1e-10


def tumbling(system):
    """Rates of a body that flies, turns and is bent and stretched on the way: U becomes 2 to 4 % of T."""
    rigid = sk.RigidVelocity((1.0, 2.0, -1.0), (2.0, 3.0, 1.0)).at(system.undeformed)

    def field(x, y):
        return np.stack([1 + 0 * x, 2 * np.sin(3 * x) * y, 4 * np.cos(2 * x) * y - 1])

    return rigid + initial_velocity(system, system.undeformed, field)


def run(system, t_end, dt, rule, rtol=1e-11, **options):
    options = {"velocity": tumbling(system), "balance": None} | options
    return sk.simulate(system, t_end, dt=dt, rule=rule, outputs=2, progress=False, newton_rtol=rtol, **options)


def drifts(ledger):
    """Largest relative changes of energy, linear and angular momentum."""
    vectors = ledger.linear, ledger.angular
    sizes = [np.linalg.norm(v, axis=1).max() for v in vectors]
    return [np.ptp(ledger.energy) / ledger.energy[0],
            *(np.abs(v - v[0]).max() / size for v, size in zip(vectors, sizes, strict=True))]  # fmt: skip


@bodies
@theories
@pytest.mark.parametrize("dt", [0.02, 0.05])
def test_energy_and_momenta_of_a_free_body(dt, theory, body):
    """The membrane's slowest frequency is about 100 rad/s: steps are one and more of its periods over 2 pi."""
    problem, mesh = BODIES[body]
    system = problem.on(mesh, theory)
    motion = run(system, 0.6, dt, sk.EnergyMomentum(1.0))
    ledger = motion.ledger
    assert motion.ok and max(drifts(ledger)) < KEPT, drifts(ledger)
    assert ledger.strain.max() > 0.01 * ledger.kinetic.max(), "nothing was bent"
    turned = sk.Solution(system, motion.q[-1]).rotation((0.5, 0.4))
    assert turned > 0.5, "nothing turned"


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_the_midpoint_rule_keeps_momenta_and_not_energy(theory):
    problem, mesh = BODIES["flat"]
    system = problem.on(mesh, theory)
    rules = sk.ImplicitMidpoint(), sk.GeneralizedAlpha()
    midpoint, alpha = (drifts(run(system, 0.6, 0.02, rule).ledger) for rule in rules)
    assert midpoint[0] > 1e-3 and max(midpoint[1:]) < KEPT  # measured 4e-3 and 7e-3
    assert alpha[0] > 1e-3 and alpha[2] > 1e-6  # moments of forces at another place than the middle


def test_energy_is_kept_where_the_midpoint_rule_blows_up():
    """The same run of a curved panel; the other rule is stopped where its energy has doubled."""
    problem, mesh = BODIES["curved"]
    system = problem.on(mesh, "kirchhoff")
    motion = run(system, 0.6, 0.02, sk.ImplicitMidpoint(), rtol=1e-9, balance=0.5)
    assert motion.status is Status.UNBALANCED and motion.ledger.energy[-1] > 2 * motion.ledger.energy[0]
    assert "gained" in motion.message and "EnergyMomentum" in motion.message
    assert max(drifts(run(system, 0.6, 0.02, sk.EnergyMomentum(1.0)).ledger)) < KEPT


def test_adaptive_steps_keep_them_too():
    problem, mesh = BODIES["laminate"]
    motion = sk.simulate(problem.on(mesh, "kirchhoff"), 0.5, rtol=2e-2, rule=sk.EnergyMomentum(1.0), newton_rtol=1e-11,
                         velocity=sk.RigidVelocity((0, 0, 0), (2.0, 6.0, 1.0)), progress=False)  # fmt: skip
    assert len({step.dt for step in motion.steps}) > 2 and max(drifts(motion.ledger)) < KEPT


# --- in a turned frame -----------------------------------------------------------------------------------------------


def rotation(spin):
    angle = np.linalg.norm(spin)
    x, y, z = np.asarray(spin) / angle
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(), sk.GeneralizedAlpha()], ids=lambda rule: type(rule).__name__)
@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
@pytest.mark.parametrize("body", ["curved", "hanging nodes"])
def test_a_turned_run_is_the_run_turned(body, theory, rule):
    """Place, velocity, loads and weight turned by 2 rad: positions after the run are turned, and strains the same."""
    problem, mesh = BODIES[body]
    Q = rotation(1.2 * np.array([1.0, -1.0, 0.8]))

    def loaded(R):
        loads = [sk.EdgeLoad("right", tuple(R @ (1.0, -2.0, 5.0)), history=sk.Ramp(0.1)), sk.FollowerPressure(8.0),
                 sk.Gravity(tuple(R @ (0, 0, -9.81)))]  # fmt: skip
        damping = sk.Damping(mass=0.3, stiffness=1e-3)
        return sk.Problem(problem.surface, problem.thickness, problem.material, [], loads, damping).on(mesh, theory)

    plain, turned = loaded(np.eye(3)), loaded(Q)
    v = tumbling(plain)

    def over(vectors, R):
        return (vectors.reshape(-1, 3) @ R.T).ravel()

    start = sk.Solution(turned, over(plain.undeformed, Q), over(v, Q), 0.0)
    one = run(plain, 0.2, 0.01, rule, rtol=1e-12, velocity=v)
    two = run(turned, 0.2, 0.01, rule, rtol=1e-12, velocity=None, start=start)
    # Newton's method ends at 1e-12 in the energy norm; its directions depend on the frame through loads that follow.
    moved = np.abs(one.q[-1] - plain.undeformed).max()
    assert moved > 0.3
    assert np.abs(two.q[-1] - over(one.q[-1], Q)).max() < 1e-9 * moved
    assert np.abs(two.v[-1] - over(one.v[-1], Q)).max() < 1e-8 * np.abs(one.v[-1]).max()
    assert np.allclose(one.ledger.strain, two.ledger.strain, rtol=0, atol=1e-9 * one.ledger.kinetic.max())
    assert np.abs(two.q[-1] - one.q[-1]).max() > 0.1
