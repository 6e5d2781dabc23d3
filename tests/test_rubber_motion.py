"""Motion of thin shells with laws at points: energy and momenta that the rules keep, and what they take out."""

import numpy as np
import pytest

import skancf as sk
from skancf.materials import NeoHooke
from skancf.meshes import uniform

LAWS = {"incompressible": NeoHooke(4.225e5, 1000.0), "compressible": NeoHooke(4.225e5, 1000.0, poisson=0.4)}
laws = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def sheet(law, damping=None):
    problem = sk.Problem(sk.Rectangle(1.0, 0.6), 0.1, law, damping=damping)
    return problem.on(uniform(problem.surface, 3, 2), "kirchhoff")


def thrown(x, y):
    """Stretched, spun and bent at once; half of the energy becomes strain, of a fifth and more."""
    return np.stack([14 * (x - 0.5) + 0 * y, 3 * (y - 0.3) + 2 * (x - 0.5), 12 * (x - 0.5) ** 2 + 3 * x * y])


def run(system, rule, steps=100, **options):
    return sk.simulate(system, steps * 1e-3, dt=1e-3, rule=rule, velocity=thrown, progress=False, newton_rtol=1e-11,
                       **{"balance": None} | options).unwrap()  # fmt: skip


@laws
def test_a_sheet_of_rubber_keeps_energy_and_momenta(law):
    motion = run(sheet(law), sk.EnergyMomentum(rho_inf=1.0))
    ledger = motion.ledger
    assert ledger.strain.max() > 0.5 * ledger.kinetic.max()
    # 1e-12 as found, of Newton's tolerance over a hundred steps.
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1]
    left = np.abs(ledger.momentum_balance).max(axis=(0, 2))
    assert (left < 1e-10 * np.array([np.abs(ledger.linear).max(), np.abs(ledger.angular).max()])).all()


@laws
def test_the_mean_of_the_stresses_alone_does_other_work(law):
    """What the rule adds is what counts: without it the energy is off by what is of third order in a step."""
    system, rng = sheet(law), np.random.default_rng(0)
    q0, q1 = (system.undeformed + 0.1 * system.layout.scales.ravel() * rng.uniform(-1, 1, system.n_dofs) for _ in range(2))
    shell, gained = system.shell, system.strain_energy(q1) - system.strain_energy(q0)
    mean = 0.5 * (system.stresses(q0) + system.stresses(q1))
    exact = mean + shell.exact_work(q0, q1)
    work = [float(shell.force_between(q0, q1, stresses) @ (q1 - q0)) for stresses in (mean, exact)]
    assert abs(work[0] - gained) > 1e-3 * abs(gained)
    assert abs(work[1] - gained) < 1e-12 * system.strain_energy(q1)
    # Rounding takes no part where nothing moves.
    assert not shell.exact_work(q0, q0).any()


def test_the_dissipative_rule_takes_energy_out_in_every_step():
    rule = sk.EnergyMomentum(rho_inf=0.5)
    motion = run(sheet(LAWS["incompressible"]), rule, balance=None)
    ledger = motion.ledger
    assert ledger.numerical[-1] > 1e-3 * ledger.energy[0]
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1]
    assert ledger.energy.max() <= ledger.energy[0] * (1 + 1e-10)


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(rho_inf=1.0), sk.dynamics.ImplicitMidpoint(), sk.GeneralizedAlpha()])
def test_the_damping_of_the_material_is_booked(rule):
    """Viscous stress of the law at rest, C beta times the rate of the strain; what the balance leaves is the error of the
    rules in time."""
    motion = run(sheet(LAWS["compressible"], sk.Damping(stiffness=1e-3)), rule)
    ledger = motion.ledger
    lost = ledger.dissipation[-1]
    assert lost > 0.2 * ledger.energy[0]
    assert (np.diff(ledger.dissipation) >= 0).all()
    exact = isinstance(rule, sk.EnergyMomentum)
    assert np.abs(ledger.balance).max() < (1e-10 if exact else 2e-2) * ledger.turnover[-1]


OGDEN = sk.Ogden([(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)], 1000.0)


def blown_up(system, stretch):
    """In both directions, in the plane: its coordinates."""
    return stretch * system.undeformed


def test_damping_of_stretched_rubber_takes_energy_out():
    """By the stiffness of the stretched state it would put it in: shear of Ogden's law has a negative one there."""
    system = sheet(OGDEN, sk.Damping(stiffness=1e-3))
    q, rng, shell = blown_up(system, 1.6), np.random.default_rng(0), system.shell
    rates = [system.layout.scales.ravel() * rng.uniform(-1, 1, system.n_dofs) for _ in range(20)]
    powers = np.array([[shell.retarding_force(q, v) @ v, shell.force_of(q, shell.stresses(q, v) - shell.stresses(q)) @ v]
                       for v in rates]).T  # fmt: skip
    assert (powers[0] > 0).all() and powers[1].min() < -0.1 * np.abs(powers[1]).max()


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(rho_inf=1.0), sk.EnergyMomentum(), sk.GeneralizedAlpha()])
def test_a_stretched_sheet_comes_to_rest(rule):
    """Its edges held where it is 1.6 times as large; energies of vibrations in its plane that die."""
    edges = [sk.Prescribed("boundary", (lambda x, y: 0.6 * x, lambda x, y: 0.6 * y, 0.0))]
    problem = sk.Problem(sk.Rectangle(1.0, 0.6), 0.01, OGDEN, edges, damping=sk.Damping(stiffness=5e-3))
    system = problem.on(uniform(problem.surface, 3, 2), "kirchhoff")
    start = sk.solve(system, rtol=1e-10).unwrap()

    def pushed(x, y):
        return 3 * np.sin(np.pi * x) * np.sin(np.pi * y / 0.6) * np.stack([1 + 0 * x, -1 + 0 * x, 0 * x])

    motion = sk.simulate(system, 0.2, dt=2e-3, rule=rule, start=start, velocity=pushed, progress=False,
                         balance=None).unwrap()  # fmt: skip
    ledger = motion.ledger
    assert (np.diff(ledger.dissipation) >= 0).all() and ledger.dissipation[-1] > 0.5 * ledger.kinetic[0]
    assert ledger.kinetic[-1] < 0.2 * ledger.kinetic[0]
