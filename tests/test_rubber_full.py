"""Theory `full` with laws at points through the thickness, compressible ones in three dimensions."""

import numpy as np
import pytest

import skancf as sk
from skancf.materials import NeoHooke
from skancf.meshes import uniform

SHEAR, POISSON, THICKNESS = 1.5e6, 0.45, 0.05
LAW = NeoHooke(SHEAR, 1000.0, poisson=POISSON)
YOUNG = 2 * SHEAR * (1 + POISSON)
LINEAR = sk.Isotropic(YOUNG, POISSON, 1000.0)
MIDDLE = np.array([[0.5], [0.5]])
SURFACES = {"flat": sk.Rectangle(1.0, 0.7), "cylinder": sk.CylinderSector(1.0, 1.0, 1.2)}


def near(found, expected, tolerance):
    assert np.abs(np.asarray(found) - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("assumed", [True, False], ids=["assumed", "plain"])
@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_force_tangent_and_work_are_those_of_the_energy(surface, assumed):
    system = sk.Problem(surface, THICKNESS, LAW).on(uniform(surface, 3, 2), sk.Full(assumed=assumed))
    rng, scales, h = np.random.default_rng(1), system.layout.scales.ravel(), 3e-6
    q = system.undeformed + 0.02 * scales * rng.uniform(-1, 1, system.n_dofs)
    u = 0.02 * scales * rng.uniform(-1, 1, system.n_dofs)
    ahead, behind = q + h * u, q - h * u
    near((system.strain_energy(ahead) - system.strain_energy(behind)) / (2 * h), system.internal_force(q) @ u, 1e-8)
    # What differences of this step leave: 1.0e-8 on the cylinder, of third derivatives.
    near(system.tangent(q) @ u, (system.internal_force(ahead) - system.internal_force(behind)) / (2 * h), 3e-8)
    end = q + 5 * u
    stresses = 0.5 * (system.stresses(q) + system.stresses(end)) + system.shell.exact_work(q, end)
    work = system.shell.force_between(q, end, stresses) @ (end - q)
    near(work, system.strain_energy(end) - system.strain_energy(q), 1e-11)


def test_a_strip_stretched_to_twice_its_length():
    """J, width and stress of J. Kiendl et al. (2015), as in theory `kirchhoff`; the stress across is found to be zero."""
    supports = [sk.Symmetry(["left", "bottom"]), sk.Roller("left"), sk.Prescribed("right", (2.0, None, None))]
    surface = sk.Rectangle(2.0, 1.0)
    solution = sk.solve(sk.Problem(surface, THICKNESS, LAW, supports).on(uniform(surface, 2, 2), "full")).unwrap()
    stretch = np.sqrt(1 + 2 * solution.strains(MIDDLE)[0, 0, :3])
    near(stretch[1:], [0.743504729, 0.743504729], 1e-8)
    near(stretch.prod(), 1.105598565, 1e-8)
    true = solution.cauchy_stresses(MIDDLE)[0, 0]
    near(true, [4.374167e6, 0, 0, 0, 0, 0], 1e-6)
    near(solution.reactions("right")[0], true[0] * stretch[1] * stretch[2] * THICKNESS, 1e-9)
    small = sk.solve_linear(solution.system)
    near(small.stresses(MIDDLE)[0, 0], [YOUNG, 0, 0, 0, 0, 0], 1e-9)
    near(small.section_forces(MIDDLE)[0, :, 0], [YOUNG * THICKNESS, 0, 0, 0, 0, 0], 1e-9)


def plate(law, theory, pressure):
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.02, law, [sk.SimpleSupport("boundary")], [sk.FollowerPressure(pressure)])
    return problem.on(uniform(surface, 6, 6), theory)


def test_bending_has_no_poisson_locking():
    """At rest it is the law of plane stress, to rounding; a law of three dimensions with one strain across is (1 - nu)^2 /
    (1 - 2 nu) = 3 times too stiff."""
    rubber, linear = plate(LAW, "full", 1.0), plate(LINEAR, "full", 1.0)
    near(sk.modes(rubber, 3).omega, sk.modes(linear, 3).omega, 1e-9)
    thick = plate(sk.Isotropic(YOUNG, POISSON, 1000.0, kind="3d"), "full", 1.0)
    assert sk.modes(thick, 1).omega[0] > 1.5 * sk.modes(rubber, 1).omega[0]


def test_a_plate_blown_up_in_both_theories():
    """To a seventh of its side, with strains of a tenth and more: the law takes part, and both theories agree."""
    middle = (0.5, 0.5)
    full, thin, linear = (
        sk.solve(plate(law, theory, 1e4)).unwrap() for law, theory in ((LAW, "full"), (LAW, "kirchhoff"), (LINEAR, "full"))
    )
    near(full.displacement(middle)[2], thin.displacement(middle)[2], 2e-3)
    assert full.displacement(middle)[2] > 1.04 * linear.displacement(middle)[2]
    near(full.thickness_stretch(MIDDLE, "middle"), thin.thickness_stretch(MIDDLE, "middle"), 1e-2)
    # In the corners of soft supports shear makes a difference.
    inside = np.abs(full.system.mesh.p[:, full.system.mesh.t].mean(axis=1) - 0.5).max(axis=0) < 0.3
    near(full.stresses(MIDDLE, "top")[inside, 0, 0], thin.stresses(MIDDLE, "top")[inside, 0, 0], 4e-2)


def test_motion_keeps_energy():
    problem = sk.Problem(sk.Rectangle(1.0, 0.6), 0.1, LAW)
    system = problem.on(uniform(problem.surface, 3, 2), "full")

    def thrown(x, y):
        return np.stack([14 * (x - 0.5) + 0 * y, 3 * (y - 0.3) + 2 * (x - 0.5), 12 * (x - 0.5) ** 2 + 3 * x * y])

    rule = sk.EnergyMomentum(rho_inf=1.0)
    motion = sk.simulate(system, 0.05, dt=1e-3, rule=rule, velocity=thrown, newton_rtol=1e-11, progress=False)
    ledger = motion.unwrap().ledger
    assert ledger.strain.max() > 0.3 * ledger.kinetic.max()
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1]
    assert np.abs(ledger.momentum_balance).max() < 1e-9 * np.abs(ledger.angular).max()


def test_what_it_cannot_do_is_refused():
    surface = sk.Rectangle(1.0, 1.0)
    with pytest.raises(sk.InputError, match="incompressible"):
        sk.Problem(surface, 0.02, NeoHooke(SHEAR, 1000.0)).on(uniform(surface, 1, 1), "full")


@pytest.mark.parametrize("heat", [[], [sk.Temperature(50.0, 500.0)]], ids=["cold", "hot"])
@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_section_forces_have_their_derivative(surface, heat):
    """Of weights times N and M, against differences."""
    law = NeoHooke(SHEAR, 1000.0, poisson=0.4, expansion=1e-3)
    system = sk.Problem(surface, THICKNESS, law, [], heat).on(uniform(surface, 3, 2), "full")
    rng, scales, h = np.random.default_rng(2), system.layout.scales.ravel(), 1e-5
    u = scales * rng.uniform(-1, 1, system.n_dofs)
    q = system.undeformed + 0.02 * scales * rng.uniform(-1, 1, system.n_dofs)
    points, elements = np.array([[0.2, 0.5], [0.3, 0.9]]), np.array([1, 4])
    weights, shell = rng.normal(size=(2, 6, 2)), system.shell

    def value(q):
        return np.vdot(weights, shell.section_forces(q, points)[elements])

    nodal = shell.nodal(q)
    rate = np.vdot(shell.at(sk.Case()).section_force_gradient(nodal, elements, points, weights), shell.nodal(u))
    assert rate == pytest.approx((value(q + h * u) - value(q - h * u)) / (2 * h), rel=1e-7)
