"""Free bodies that spin: their relative equilibria stay, and a spin given to the undeformed body makes it oscillate."""

import numpy as np
import pytest
from spins import centre, spinning

import skancf as sk

THICKNESS, YOUNG, DENSITY = 0.05, 1e6, 1000.0
PLATE = sk.Rectangle(1.0, 0.8)
PANEL = sk.CylinderSector(1.0, 1.0, 1.2)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def free(surface, theory, n):
    problem = sk.Problem(surface, THICKNESS, sk.Isotropic(YOUNG, 0.3, DENSITY))
    return problem.on(sk.meshes.uniform(surface, n, n), theory)


def turns(system, spin, number, steps, rule, **options):
    t_end = number * 2 * np.pi / np.linalg.norm(spin)
    return sk.simulate(system, t_end, dt=t_end / (number * steps), rule=rule, outputs=2, newton_rtol=1e-11, progress=False,
                       balance=None, **options)  # fmt: skip


@theories
@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 1, 0), (1, 0, 0)], ids="zyx")
def test_a_spinning_plate_stays_in_its_equilibrium(axis, theory):
    """Three turns of 20 steps each: the rule keeps relative equilibria, whatever its steps."""
    system, spin = free(PLATE, theory, 3), 4.0 * np.array(axis)
    start = spinning(system, spin)
    assert start.strain_energy > 1e-3
    motion = turns(system, spin, 3, 20, sk.EnergyMomentum(), start=start)
    strain = motion.ledger.strain
    # Newton's rest times the condition of the thin membrane: the energy is a 300th part of the kinetic one.
    assert motion.ok and np.abs(strain / strain[0] - 1).max() < 1e-7
    # Turned by 20 steps of 2 atan(omega dt / 2), a little less than a turn each.
    dt = motion.steps[0].dt
    angle = len(motion.steps) * 2 * np.arctan(np.linalg.norm(spin) * dt / 2)
    c, r = centre(system), start.position((1.0, 0.8))
    r, e = r - c, np.array(axis, float)
    turned = r * np.cos(angle) + np.cross(e, r) * np.sin(angle) + e * (e @ r) * (1 - np.cos(angle))
    assert np.allclose(motion.at(motion.times[-1]).position((1.0, 0.8)), c + turned, rtol=0, atol=1e-6)


@theories
def test_so_does_a_curved_panel_that_bends(theory):
    system, spin = free(PANEL, theory, 2), np.array([2.0, 0.0, 0.0])
    start = spinning(system, spin)
    moved = np.linalg.norm((start.q - system.undeformed).reshape(-1, 4, 3)[:, 0], axis=1)
    assert moved.max() > 0.2 * THICKNESS, "nothing bent"
    strain = turns(system, spin, 3, 20, sk.EnergyMomentum(), start=start).ledger.strain
    assert np.abs(strain / strain[0] - 1).max() < 1e-7


def test_generalised_alpha_leaves_it():
    """Forces of the ends of the step do not belong to what lies between them: at 18 degrees per step strain energy grows."""
    system, spin = free(PLATE, "full", 2), np.array([0.0, 0.0, 4.0])
    motion = turns(system, spin, 1, 20, sk.GeneralizedAlpha(), start=spinning(system, spin))
    assert np.abs(motion.ledger.strain / motion.ledger.strain[0] - 1).max() > 0.1


@theories
def test_a_spin_of_the_undeformed_plate(theory):
    """No strain at first, then an oscillation about the equilibrium, of which 1.5 times the energy is the mean."""
    system, spin = free(PLATE, theory, 3), np.array([0.0, 0.0, 4.0])
    equilibrium = spinning(system, spin).strain_energy
    velocity = sk.RigidVelocity(spin=tuple(spin), about=tuple(centre(system)))
    motion = turns(system, spin, 1, 200, sk.EnergyMomentum(1.0), velocity=velocity)
    strain = motion.ledger.strain
    assert strain[0] < 1e-20 and strain[1] < 0.2 * equilibrium
    assert strain.max() > 2 * equilibrium
    # A single mode would give (1 - cos)^2 and 1.5; the plate stretches in several.
    assert np.mean(strain) == pytest.approx(1.5 * equilibrium, rel=0.15)
    assert np.ptp(motion.ledger.energy) < 1e-10 * motion.ledger.energy[0]
