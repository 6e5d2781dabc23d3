"""Temperature changes of laws at points: a free stretch inside the law, in both theories, at rest and in motion."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import fsolve

import skancf as sk
from skancf.materials import NeoHooke
from skancf.meshes import uniform

SHEAR, NU, ALPHA, T = 1e6, 0.4, 1e-3, 0.05
COMPRESSIBLE = NeoHooke(SHEAR, 1000.0, poisson=NU, expansion=ALPHA)
INCOMPRESSIBLE = NeoHooke(SHEAR, 1000.0, expansion=ALPHA)
PLATE = sk.Rectangle(1.0, 0.6)
INSIDE = np.array([[0.3, 0.8], [0.2, 0.5]])
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def just_held(length=1.0):
    return [sk.Pin((0.0, 0.0)), sk.Prescribed((length, 0.0), (None, 0.0, 0.0)),
            sk.Prescribed((0.0, 0.6 * length), (None, None, 0.0))]  # fmt: skip


def system_on(theory, surface, supports, loads, mesh=(3, 2), law=COMPRESSIBLE, thickness=T, **options):
    return sk.Problem(surface, thickness, law, supports, loads, **options).on(uniform(surface, *mesh), theory)


@theories
@pytest.mark.parametrize("change", [0.1, 50.0, 500.0])
def test_a_free_plate_expands_without_stress(theory, change):
    """By 1 + alpha T, to half as much again."""
    system = system_on(theory, PLATE, just_held(), [sk.Temperature(change)])
    grown = ALPHA * change
    solution = sk.solve(system, rtol=1e-12).unwrap()
    assert np.allclose(solution.displacement((1.0, 0.6)), [grown, 0.6 * grown, 0.0], rtol=1e-12, atol=1e-13)
    for z in ("bottom", "top"):
        assert np.abs(solution.stresses(INSIDE, z)).max() < 1e-13 * SHEAR
        assert np.allclose(solution.strains(INSIDE, z)[..., :3], ((1 + grown) ** 2 - 1) / 2, rtol=1e-9)
    assert np.abs(solution.section_forces(INSIDE)).max() < 1e-13 * SHEAR * T
    assert 0 <= solution.strain_energy < 1e-20 * SHEAR
    small = sk.solve_linear(system)
    assert np.allclose(small.displacement((1.0, 0.6)), [grown, 0.6 * grown, 0.0], rtol=1e-9, atol=1e-12)
    assert np.abs(small.stresses(INSIDE, "top")).max() < 1e-9 * SHEAR * grown
    assert abs(small.strain_energy) < 1e-12 * small.system.shell.thermal_energy()


@theories
def test_a_free_ball_expands_without_stress(theory):
    """Normals grow with it. In theory full the interpolated strains of a sphere are those of its mesh."""
    ball = sk.SphereSector(1.0, (0.0, np.pi), 2 * np.pi, closed=True)
    held = [((0.0, 0.0), (0.0, 0.0, None)), ((np.pi, 0.0), (0.0, 0.0, None)), ((np.pi / 2, 0.0), (None, 0.0, 0.0))]
    system = system_on(theory, ball, [sk.Prescribed(at, u) for at, u in held], [sk.Temperature(200.0)], (6, 12))
    solution = sk.solve(system, rtol=1e-10).unwrap()
    positions = system.layout.positions
    error = np.abs(positions(solution.q) - 1.2 * positions(system.undeformed)).max()
    assert error < (1e-12 if theory == "kirchhoff" else 5e-4)


@theories
def test_a_heated_plate_is_a_larger_cold_one(theory):
    """Of the same law: bent by a force, it has the same shape as one that is made 1.2 times as large."""
    force, lengths, found = 400.0, (1.0, 1.2), []
    for length, heat in zip(lengths, ([sk.Temperature(200.0)], []), strict=True):
        surface = sk.Rectangle(length, 0.6 * length)
        loads = [sk.PointForce((0.5 * length, 0.3 * length), (0.0, 0.0, force)), *heat]
        system = system_on(theory, surface, just_held(length), loads, thickness=T * length)
        found.append(system.layout.positions(sk.solve(system, rtol=1e-11).unwrap().q))
    assert np.ptp(found[1][:, 2]) > 0.1
    # Newton's tolerance; in theory kirchhoff the rest of the assumed strains has the law of the undeformed mesh.
    assert np.abs(found[0] - found[1]).max() < (3e-4 if theory == "kirchhoff" else 1e-8)


@theories
def test_a_clamped_plate_is_pressed_as_by_the_inverse_stretch(theory):
    """Per undeformed length: N = t beta S_e(1 / beta^2), from beta^3 of the volume and beta^-2 of the strain."""
    system = system_on(theory, PLATE, [sk.Clamp("boundary")], [sk.Temperature(100.0)], thickness=0.5)
    grown = 1.1
    pressed = COMPRESSIBLE.plane_stress([[grown**-2.0], [grown**-2.0], [0.0]])
    stress = grown * pressed.stress[0, 0]
    if theory == "kirchhoff":  # in full the clamp holds the thickness at the edge, too
        solution = sk.Solution(system, system.undeformed)
        assert np.allclose(solution.stresses(INSIDE, 0.0)[..., :2], stress, rtol=1e-9)
        assert np.allclose(solution.section_forces(INSIDE)[:, :2], stress * 0.5, rtol=1e-9)
        assert np.isclose(solution.strain_energy, grown**3 * pressed.energy[0] * 0.6 * 0.5, rtol=1e-9)
        assert np.abs(system.constraints.free_part(system.internal_force(solution.q))).max() < 1e-9 * SHEAR
    small = -(2 * SHEAR * (1 + NU)) / (1 - NU) * 0.1
    held = [sk.Roller(["left", "right"], (1, 0, 0)), sk.Roller(["top", "bottom"], (0, 1, 0)), sk.Roller("boundary")]
    system = system_on(theory, PLATE, held, [sk.Temperature(100.0)], thickness=0.5)
    assert np.allclose(sk.solve_linear(system).stresses(INSIDE, 0.0)[..., :2], small, rtol=1e-9)
    assert abs(stress / small - 1) > 0.1
    for z in ("bottom", "top"):
        assert np.allclose(sk.solve(system).unwrap().stresses(INSIDE, z)[..., :2], stress, rtol=1e-6)


def bent(middle, gradient):
    """Stretch and turn per length of a strip in plane strain without force and moment, of incompressible rubber, from the
    energy alone: beta^3 mu / 2 (I1 - 3) with stretches (l + b z w) / beta and 1 / beta at 20 heights, b those of normals."""
    s, w = np.polynomial.legendre.leggauss(20)
    z, w = s * T / 2, w * T / 2
    free, normal = 1 + ALPHA * (middle + gradient * z), 1 + ALPHA * middle

    def forces(x):
        one = (x[0] + normal * z * x[1]) / free
        rate = SHEAR * (one - free**2 / one**3) * free**2 * w
        return [rate.sum(), (rate * normal * z).sum()]

    return fsolve(forces, [1.0, ALPHA * gradient], xtol=1e-13)


def strip(theory, law, middle, gradient, n=8):
    supports = [sk.Clamp("left"), sk.Symmetry(["top", "bottom"])]
    return system_on(theory, sk.Rectangle(1.0, 0.2), supports, [sk.Temperature(middle, gradient)], (n, 1), law)


def test_a_gradient_bends_a_strip():
    """To a part of a ring, and little more than the linear law says where it is small."""
    middle, gradient = 50.0, 2000.0  # free strains of 0.05 and, at the faces, 0.05
    stretch, turn = bent(middle, gradient)
    tip = stretch / turn * np.array([np.sin(turn), 1 - np.cos(turn)])
    errors = []
    for n in (4, 8):
        solution = sk.solve(strip("kirchhoff", INCOMPRESSIBLE, middle, gradient, n)).unwrap()
        x, _, z = solution.displacement((1.0, 0.1))
        errors.append(np.hypot(x + 1 - tip[0], z + tip[1]))
    assert turn > 2 and errors[1] < 1e-4 and errors[1] < errors[0] / 8, errors
    linear = sk.Isotropic(3 * SHEAR, 0.5 - 1e-12, 1000.0, expansion=ALPHA)
    apart = []
    for part in (0.4, 0.1):
        both = [sk.solve(strip("kirchhoff", law, 0.0, part * gradient)).unwrap() for law in (INCOMPRESSIBLE, linear)]
        one, two = (solution.displacement((1.0, 0.1))[2] for solution in both)
        apart.append(abs(one / two - 1))
    # Free strains of 0.02 and 0.005 at the faces, whose squares count, and 5e-6 of the mesh.
    assert apart[0] < 1e-4 and apart[1] < 1.2e-5, apart


def test_both_theories_bend_alike():
    tips = [sk.solve(strip(theory, COMPRESSIBLE, 0.0, 1000.0, 16)).unwrap().displacement((1.0, 0.1))[2]
            for theory in ("kirchhoff", "full")]  # fmt: skip
    assert abs(tips[0]) > 0.3 and np.isclose(*tips, rtol=1e-3), tips


@dataclass(frozen=True)
class AlongOne:
    """Rubber that expands along 1 alone."""

    law: NeoHooke = COMPRESSIBLE

    def __getattr__(self, name):
        return getattr(self.law, name)

    def thermal_strain(self):
        return ALPHA * np.array([1.0, 0, 0, 0, 0, 0])

    def plane_stress(self, C, guess=None):
        return self.law.respond(C, guess)


def test_a_law_that_expands_along_one_direction():
    """A strip bends to a part of a ring without stress; errors are those of its shape in cubic polynomials."""
    gradient, middle = 2000.0, 100.0
    turn, stretch, errors, energies = ALPHA * gradient, 1.1, [], []
    tip = stretch / turn * np.array([np.sin(turn), 1 - np.cos(turn)])
    for n in (4, 8):
        loads = [sk.Temperature(middle, gradient)]
        system = system_on("kirchhoff", sk.Rectangle(1.0, 0.2), [sk.Clamp("left")], loads, (n, 1), AlongOne())
        solution = sk.solve(system).unwrap()
        x, _, z = solution.displacement((1.0, 0.1))
        errors.append(np.hypot(x + 1 - tip[0], z + tip[1]))
        energies.append(solution.strain_energy)
    assert errors[1] < 1e-3 and errors[1] < errors[0] / 8, errors
    assert energies[1] < energies[0] / 10


@theories
@pytest.mark.parametrize("surface", [PLATE, sk.SphereSector(1.0, (0.6, 1.4), 0.9)], ids=["flat", "sphere"])
def test_energy_force_and_tangent_belong_together(surface, theory, rng):
    """And the derivative by the load factor."""
    load = sk.Temperature(lambda x, y: 100 * (1 + x), 500.0, history=lambda t: t)
    system = system_on(theory, surface, [], [load], (2, 1), thickness=0.1)
    q, step, case = (system.undeformed + 0.01 * rng.normal(size=system.n_dofs), 1e-6 * rng.normal(size=system.n_dofs),
                     sk.Case(0.7, 0.6))  # fmt: skip

    def residual(q, case=case):
        return system.internal_force(q, None, case) - system.external_force(q, case)

    difference = 0.5 * (system.strain_energy(q + step, case) - system.strain_energy(q - step, case))
    assert np.isclose(difference, residual(q) @ step, rtol=1e-7)
    numeric, tangent = 0.5 * (residual(q + step) - residual(q - step)), system.tangent(q, case).to_scipy() @ step
    assert np.abs(tangent - numeric).max() < 1e-8 * np.abs(tangent).max()
    cold = system.tangent(q, sk.Case(0.0)).to_scipy() @ step
    assert np.abs(cold - tangent).max() > 1e-3 * np.abs(tangent).max()
    rate, h = system.shell.load_rate(q, 0.7), 1e-5
    differences = [residual(q, sk.Case(0.7 + sign * h)) for sign in (-1, 1)]
    assert np.abs(rate - (differences[0] - differences[1]) / (2 * h)).max() < 1e-6 * np.abs(rate).max()


@theories
@pytest.mark.parametrize("history", [None, lambda t: 1 + np.sin(60 * t)], ids=["constant", "varying"])
def test_motion_in_the_heat_keeps_energy(theory, history):
    """What a temperature that varies puts in is booked as its work."""
    system = system_on(theory, PLATE, [], [sk.Temperature(100.0, 500.0, history=history)], (2, 1), thickness=0.1)

    def thrown(x, y):
        return np.stack([6 * (x - 0.5) + 0 * y, 3 * (y - 0.3) + 2 * (x - 0.5), 5 * (x - 0.5) ** 2 + 3 * x * y])

    motion = sk.simulate(system, 0.02, dt=1e-3, rule=sk.EnergyMomentum(rho_inf=1.0), velocity=thrown, progress=False,
                         newton_rtol=1e-12, balance=None).unwrap()  # fmt: skip
    ledger = motion.ledger
    assert np.abs(ledger.balance).max() < 1e-10 * ledger.turnover[-1]
    assert np.abs(ledger.momentum_balance).max() < 1e-9 * np.abs(ledger.angular).max()
    assert (np.abs(ledger.work).max() > 1e-3 * ledger.turnover[-1]) == (history is not None)


def test_a_heated_strip_buckles():
    """Between walls: at the heat that the linear law says, and with a small load, along a path."""

    def between(law, *loads):
        supports = [sk.SimpleSupport(["left", "right"]), sk.Roller(["left", "right"], (1, 0, 0)),
                    sk.Symmetry(["top", "bottom"])]  # fmt: skip
        return system_on("kirchhoff", sk.Rectangle(1.0, 0.2), supports, [sk.Temperature(1.0), *loads], (8, 1), law, 0.02)

    linear = sk.Isotropic(2 * SHEAR * (1 + NU), NU, 1000.0, expansion=ALPHA)
    rubber = between(COMPRESSIBLE)
    factor = sk.buckling(rubber, 1).load_factors[0]
    assert np.isclose(factor, sk.buckling(between(linear), 1).load_factors[0], rtol=1e-9)
    for part, sign in ((0.99, 1), (1.01, -1)):  # strains of 3e-4 apart
        state = sk.Solution(rubber, rubber.undeformed, load_factor=part * factor)
        assert np.sign(sk.modes(rubber, 1, state=state).eigenvalues[0]) == sign
    pushed = between(COMPRESSIBLE, sk.SurfaceLoad((0.0, 0.0, 0.5)))
    path = sk.trace(pushed, sk.ArcLength(first=0.1 * factor), until=2 * factor, steps=60).unwrap()
    w = [state.displacement((0.5, 0.1))[2] for state in path.solutions]
    assert w[-1] > 10 * np.interp(0.5 * factor, path.load_factors, w)
    again = sk.solve(pushed, load_factor=2 * factor, rtol=1e-10).unwrap().displacement((0.5, 0.1))[2]
    assert np.isclose(w[-1], again, rtol=1e-6)


def test_vibrations_of_a_hot_free_plate():
    """Six motions without stiffness; frequencies of the larger plate with the mass of the small one: over sqrt(1.2)."""
    hot = system_on("kirchhoff", PLATE, just_held(), [sk.Temperature(200.0)])
    at = sk.solve(hot, rtol=1e-12).unwrap()
    free = system_on("kirchhoff", PLATE, [], [sk.Temperature(200.0)])
    found = sk.modes(free, 8, state=sk.Solution(free, at.q))
    cold = sk.modes(system_on("kirchhoff", PLATE, [], []), 8)
    assert found.n_rigid == 6
    # omega^2 ~ E t^3 / (m L^2), t and L times 1.2 at the same mass m.
    assert np.allclose(found.frequencies[6:], np.sqrt(1.2) * cold.frequencies[6:], rtol=1e-6)


def test_what_leaves_no_length_is_refused():
    with pytest.raises(sk.InputError, match="free stretch"):
        sk.solve(system_on("kirchhoff", PLATE, just_held(), [sk.Temperature(-1100.0)]))


@theories
def test_a_hot_plate_has_its_gradients_and_estimates(theory):
    """Of a section force, and of a goal by the dual-weighted residual."""
    problem = sk.Problem(PLATE, T, COMPRESSIBLE, [sk.Clamp("left")],
                         [sk.Temperature(50.0, 500.0), sk.SurfaceLoad((0.0, 0.0, 20.0))])  # fmt: skip
    system = problem.on(sk.meshes.quadtree(uniform(PLATE, 3, 2)), theory)
    state = sk.solve(system, rtol=1e-11).unwrap()
    rng = np.random.default_rng(0)
    u, h = system.constraints.free_part(system.layout.scales.ravel() * rng.uniform(-1, 1, system.n_dofs)), 1e-6
    for quantity in (sk.SectionForce("M11", at=(0.4, 0.3)), sk.SectionForce("N11", within=((0.2, 0.8), (0.1, 0.5))),
                     sk.StrainEnergy()):  # fmt: skip
        ahead, behind = (quantity.value(sk.Solution(system, state.q + s * h * u)) for s in (1, -1))
        assert quantity.gradient(state) @ u == pytest.approx((ahead - behind) / (2 * h), rel=1e-6)
    goal = sk.goal_estimate(state, sk.Displacement((1.0, 0.3), (0.0, 0.0, 1.0)))
    finer = sk.solve(problem.on(uniform(PLATE, 12, 8), theory)).unwrap()
    true = finer.displacement((1.0, 0.3))[2] - state.displacement((1.0, 0.3))[2]
    assert 0.7 < goal.error / true < 1.5, (goal.error, true)
