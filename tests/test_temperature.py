"""Temperature changes against closed formulas, in both theories."""

import numpy as np
import pytest

import skancf as sk

E, NU, ALPHA, T = 1e6, 0.3, 1e-5, 0.01
MATERIAL = sk.Isotropic(E, NU, 2000.0, expansion=ALPHA)
PLATE = sk.Rectangle(1.0, 0.6)
JUST_HELD = [sk.Pin((0.0, 0.0)), sk.Prescribed((1.0, 0.0), (None, 0.0, 0.0)),
             sk.Prescribed((0.0, 0.6), (None, None, 0.0))]  # fmt: skip
INSIDE = np.array([[0.3, 0.8], [0.2, 0.5]])
IN_PLANE = [0, 1, 5]
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def system_on(theory, surface, supports, load, mesh=(3, 2), material=MATERIAL, thickness=T):
    problem = sk.Problem(surface, thickness, material, supports, [load])
    return problem.on(sk.meshes.uniform(surface, *mesh), theory)


@theories
def test_a_free_plate_expands_without_stress(theory):
    change = 50.0
    solution = sk.solve(system_on(theory, PLATE, JUST_HELD, sk.Temperature(change)), rtol=1e-12).unwrap()
    # The free Green-Lagrange strain is alpha T, so lengths grow by sqrt(1 + 2 alpha T).
    stretch = np.sqrt(1 + 2 * ALPHA * change) - 1
    assert np.allclose(solution.displacement((1.0, 0.6)), [stretch, 0.6 * stretch, 0], rtol=0, atol=1e-12)
    for z in (-T / 2, 0.0, T / 3):
        assert np.abs(solution.stresses(INSIDE, z)).max() < 1e-10 * E * ALPHA * change
        assert np.allclose(solution.strains(INSIDE, z)[..., [0, 1]], ALPHA * change, rtol=1e-9)
    assert np.abs(solution.section_forces(INSIDE)).max() < 1e-10 * E * T * ALPHA * change


@theories
def test_a_free_plate_expands_without_stress_in_the_small_deflection_answer(theory):
    """Strain alpha T in all three directions, once."""
    change = 50.0
    solution = sk.solve_linear(system_on(theory, PLATE, JUST_HELD, sk.Temperature(change)))
    assert np.allclose(solution.displacement((1.0, 0.6)), [ALPHA * change, 0.6 * ALPHA * change, 0], rtol=1e-9, atol=1e-12)
    for z in (-T / 2, 0.0, T / 3):
        # The linear part is a difference over a part of the change, 1e-16 / 1e-5 of the slopes beside the strain 5e-4.
        assert np.allclose(solution.strains(INSIDE, z)[..., :3], ALPHA * change, rtol=1e-6)
        assert np.abs(solution.stresses(INSIDE, z)).max() < 1e-6 * E * ALPHA * change


@theories
def test_a_free_ball_expands(theory):
    """All of it, without stress but for bending by the change of its radius, (t / R)^2 / 12 of the expansion."""
    ball = sk.SphereSector(1.0, (0.0, np.pi), 2 * np.pi, closed=True)
    held = [((0.0, 0.0), (0.0, 0.0, None)), ((np.pi, 0.0), (0.0, 0.0, None)), ((np.pi / 2, 0.0), (None, 0.0, 0.0))]
    system = system_on(theory, ball, [sk.Prescribed(at, u) for at, u in held], sk.Temperature(100.0), (6, 12),
                       thickness=0.05)  # fmt: skip
    at = np.stack(np.meshgrid([0.0, 0.5, 1.0, 3.0], [0.0, 1.0, 4.0]), axis=-1).reshape(-1, 2)
    before, after = (np.linalg.norm(state.position(at), axis=1)
                     for state in (sk.Solution(system, system.undeformed), sk.solve(system).unwrap()))  # fmt: skip
    assert np.abs(after / before - np.sqrt(1 + 2 * ALPHA * 100)).max() < 5e-4 * ALPHA * 100


@theories
def test_a_free_plate_expands_by_another_law_in_each_direction(theory):
    """The frame of an orthotropic law turned by a right angle."""
    wood = sk.Orthotropic(young=(1e6, 5e5, 5e5), poisson=(0.2, 0.1, 0.3), shear=(2e5, 2e5, 2e5), density=500.0,
                          angle=np.pi / 2, expansion=(1e-5, 4e-5, 4e-5))  # fmt: skip
    solution = sk.solve(system_on(theory, PLATE, JUST_HELD, sk.Temperature(1.0), material=wood), rtol=1e-12).unwrap()
    assert np.allclose(solution.displacement((1.0, 0.6)), [4e-5, 0.6e-5, 0], rtol=1e-4, atol=1e-12)


@theories
def test_a_bar_between_walls(theory):
    """-E alpha T along it, none across; half of it at half the load, and with a history at that time."""
    bar, change = sk.Rectangle(1.0, 0.1), 50.0
    supports = [sk.Roller(["left", "right"], (1, 0, 0)), sk.Prescribed((0.0, 0.0), (None, 0.0, None)),
                sk.Roller("boundary")]  # fmt: skip
    system = system_on(theory, bar, supports, sk.Temperature(change, history=lambda t: t), (4, 1))
    for factor in (1.0, 0.5):
        solution = sk.solve(system, rtol=1e-12, load_factor=factor).unwrap()
        expected = -factor * E * ALPHA * change
        stress = solution.stresses(INSIDE)
        assert np.allclose(stress[..., 0], expected, rtol=1e-9)
        assert np.abs(stress[..., 1:]).max() < 1e-9 * abs(expected)
        assert np.allclose(solution.reactions("right"), [expected * 0.1 * T, 0, 0], rtol=1e-9, atol=1e-9)
        assert np.allclose(solution.section_forces(INSIDE)[:, 0], expected * T, rtol=1e-9)
    q = system.undeformed
    assert np.allclose(system.external_force(q, sk.Case(time=0.25)), 0.25 * system.external_force(q), rtol=1e-14)


@theories
def test_a_gradient_bends_a_free_plate_to_a_sphere(theory):
    """Curvature alpha T1 in all directions (Timoshenko and Woinowsky-Krieger 1959, article 14), warm side outside."""
    gradient = 2.0
    system = system_on(theory, PLATE, JUST_HELD, sk.Temperature(0.0, gradient), (6, 4))
    x, y = system.mesh.p
    solution = sk.solve(system, rtol=1e-12).unwrap()
    # With the three held corners: w = kappa / 2 (x (1 - x) + y (0.6 - y)).
    expected = ALPHA * gradient / 2 * (x * (1 - x) + y * (0.6 - y))
    # The sphere's membrane strains are (w / t)^2 = 1e-5 of the bending.
    assert np.abs(solution.displacements[2] - expected).max() < 1e-5 * expected.max()
    free = E * ALPHA * gradient * T / 2
    assert np.abs(solution.stresses(INSIDE, T / 2)[..., IN_PLANE]).max() < 1e-3 * free
    assert np.abs(solution.section_forces(INSIDE)[:, 3:]).max() < 1e-3 * free * T**2 / 6


@theories
def test_a_clamped_plate_with_a_gradient_stays_flat(theory):
    """Moments of -E t^3 / 12 (1 - nu) alpha T1 everywhere."""
    gradient = 2.0
    system = system_on(theory, PLATE, [sk.Clamp("boundary")], sk.Temperature(0.0, gradient))
    solution = sk.solve(system, rtol=1e-12).unwrap()
    moment = -E * T**3 / 12 / (1 - NU) * ALPHA * gradient
    assert np.allclose(solution.section_forces(INSIDE)[:, [3, 4]], moment, rtol=1e-6)
    assert np.abs(solution.displacements[2]).max() < 1e-10


def bimetal_curvature(change, young, expansion, thickness):
    """Timoshenko 1925, Journal of the Optical Society of America 11, 233-255, eq. 4."""
    m, n, h = thickness[0] / thickness[1], young[0] / young[1], sum(thickness)
    return 6 * (expansion[1] - expansion[0]) * change * (1 + m) ** 2 / (
        h * (3 * (1 + m) ** 2 + (1 + m * n) * (m * m + 1 / (m * n))))  # fmt: skip


@theories
def test_a_bimetal_plate(theory):
    """Free, it bends to a sphere; Timoshenko's strip with the same Poisson's ratio in both layers has the same curvature."""
    young, expansion, thickness, change = (2e6, 1e6), (1e-5, 3e-5), (0.006, 0.004), 1.0
    layers = [sk.Layer(sk.Isotropic(e, NU, 1.0, expansion=a), t)
              for e, a, t in zip(young, expansion, thickness, strict=True)]  # fmt: skip
    system = system_on(theory, PLATE, JUST_HELD, sk.Temperature(change), (6, 4), sk.Laminate(layers), None)
    solution = sk.solve(system, rtol=1e-12).unwrap()
    kappa = bimetal_curvature(change, young, expansion, thickness)
    # The sphere's membrane strains take (w / t)^2 / 20 = 1e-4 of it, as found; convex on top, which expands more.
    close = 2e-4
    for along, length in (([(0, 0.3), (0.5, 0.3), (1, 0.3)], 0.5), ([(0.5, 0), (0.5, 0.3), (0.5, 0.6)], 0.3)):
        w = solution.displacement(along)[:, 2]
        assert np.isclose((2 * w[1] - w[0] - w[2]) / length**2, kappa, rtol=close)
    as_one = bimetal_curvature(change, (1e6, 1e6), expansion, thickness)
    assert abs(as_one / kappa - 1) > 10 * close, "layers of equal stiffness bend otherwise"


@theories
def test_it_varies_over_the_surface(theory):
    """A temperature linear in x strains freely without stress: the plate turns into a part of a ring."""
    slope = 1.0
    load = sk.Temperature(lambda x, y: slope * (y - 0.3))
    solution = sk.solve(system_on(theory, PLATE, JUST_HELD, load, (6, 4)), rtol=1e-12).unwrap()
    free = E * ALPHA * 0.3 * slope
    # Quadratic strains. Across, the thickness that theory full gives to the warm side costs shear.
    assert np.abs(solution.stresses(INSIDE, 0.0)[..., IN_PLANE]).max() < 1e-5 * free
    sag = solution.displacement([(0.0, 0.3), (0.5, 0.3), (1.0, 0.3)])[:, 1]
    assert np.isclose(sag[1] - (sag[0] + sag[2]) / 2, ALPHA * slope / 8, rtol=1e-3)


@theories
@pytest.mark.parametrize("surface", [PLATE, sk.SphereSector(1.0, (0.6, 1.4), 0.9)], ids=["flat", "sphere"])
def test_tangent_is_the_derivative_of_the_residual(surface, theory, rng):
    load = sk.Temperature(lambda x, y: 1e4 * (1 + x), 5e4)
    system = system_on(theory, surface, [], load, (2, 1), thickness=0.1)
    q, eps = system.undeformed + 0.02 * rng.normal(size=system.n_dofs), 1e-6

    def residual(q, factor):
        return system.internal_force(q) - factor * system.external_force(q)

    unit = eps * np.eye(system.n_dofs)
    for factor in (1.0, 0.5):
        numeric = np.array([residual(q + e, factor) - residual(q - e, factor) for e in unit]).T / (2 * eps)
        tangent = system.tangent(q, sk.Case(factor)).to_scipy().toarray()
        # Rounding over the step, and eps^2.
        assert np.abs(tangent - numeric).max() < 1e-7 * np.abs(tangent).max()
    cold = system.tangent(q, sk.Case(0.0)).to_scipy().toarray()
    assert np.abs(cold - tangent).max() > 1e-3 * np.abs(tangent).max()


@theories
def test_energy_is_that_of_the_stress(theory):
    """None in a plate that expands freely, E alpha^2 T^2 V / 2 in a bar between walls; a quarter at half the load."""
    change = 50.0
    load = sk.Temperature(change)
    prevented = E * ALPHA**2 * change**2 / (1 - NU) * 0.6 * T  # of the plate
    for solve in (sk.solve_linear, lambda system: sk.solve(system, rtol=1e-12).unwrap()):
        free = solve(system_on(theory, PLATE, JUST_HELD, load))
        # The rounding of its parts, each as large as what is held back.
        assert abs(free.strain_energy) < 1e-12 * prevented
        assert free.work == 0 and free.shear_share == 0
    supports = [sk.Roller(["left", "right"], (1, 0, 0)), sk.Prescribed((0.0, 0.0), (None, 0.0, None)),
                sk.Roller("boundary")]  # fmt: skip
    system = system_on(theory, sk.Rectangle(1.0, 0.1), supports, sk.Temperature(change, history=lambda t: t), (4, 1))
    expected = E * ALPHA**2 * change**2 / 2 * 0.1 * T
    assert np.isclose(sk.solve_linear(system).strain_energy, expected, rtol=1e-9)
    for factor in (1.0, 0.5):
        solution = sk.solve(system, rtol=1e-12, load_factor=factor).unwrap()
        assert np.isclose(solution.strain_energy, factor**2 * expected, rtol=1e-9)
    # Undeformed, expansion across is held back too, and in theory full that of the thickness.
    rows = slice(0, 3 if theory == "full" else 2)
    held = MATERIAL.stiffness()[rows, rows].sum() * ALPHA**2 * (0.5 * change) ** 2 / 2 * 0.1 * T
    undeformed = sk.Solution(system, system.undeformed, time=0.5)
    assert np.isclose(undeformed.strain_energy, held, rtol=1e-9)


@theories
def test_energy_is_that_of_the_residual(theory, rng):
    """Its derivative is the internal force without that of the temperature, in a laminate on a curved surface."""
    layers = [sk.Layer(sk.Isotropic(1e6, NU, 1.0, expansion=a), 0.05) for a in (1e-5, 3e-5)]
    load = sk.Temperature(lambda x, y: 1e4 * (1 + x), 5e4, history=lambda t: t)
    system = system_on(theory, sk.SphereSector(1.0, (0.6, 1.4), 0.9), [], load, (2, 1), sk.Laminate(layers), None)
    q, eps = system.undeformed + 0.02 * rng.normal(size=system.n_dofs), 1e-6
    step = eps * rng.normal(size=system.n_dofs)
    difference = system.strain_energy(q + step, sk.Case(0.7, 0.6)) - system.strain_energy(q - step, sk.Case(0.7, 0.6))
    residual = system.internal_force(q) - system.external_force(q, sk.Case(0.7, 0.6))
    # Rounding over the step.
    assert np.isclose(difference / 2, residual @ step, rtol=1e-5)


def test_energy_of_a_free_bimetal_is_that_of_its_own_stress():
    """Layers of equal law that differ in expansion by d: half of it held, less the curvature 3 d / (2 t) they take.

    With s = +-d T / 2 in the halves, the strain left is s - kappa z, and int (s - kappa z)^2 dz = (d T)^2 t / 16.
    """
    material = [sk.Orthotropic((E, E, E), (0, 0, 0), (E / 2, E / 2, E / 2), 1.0, expansion=(a, 0, 0)) for a in (1e-5, 3e-5)]
    layers = [sk.Layer(law, T / 2) for law in material]
    system = system_on("kirchhoff", PLATE, JUST_HELD, sk.Temperature(2.0), (4, 2), sk.Laminate(layers), None)
    expected = E / 2 * (2e-5 * 2.0) ** 2 * T / 16 * 0.6
    assert np.isclose(sk.solve_linear(system).strain_energy, expected, rtol=1e-8)


def test_free_bending_has_no_shear_force():
    """A gradient that grows along a strip bends it to w = -alpha g x^3 / 6 without moments, so without shear forces."""
    law = sk.Orthotropic(young=(E, E, E), poisson=(0, 0, 0), shear=(E / 2, E / 2, E / 2), density=1.0,
                         expansion=(ALPHA, 0, 0))  # fmt: skip
    strip, load = sk.Rectangle(1.0, 0.2), sk.Temperature(gradient=lambda x, y: 1e2 * x)
    solution = sk.solve_linear(system_on("kirchhoff", strip, [sk.Clamp("left")], load, (8, 2), law))
    held = E * T**3 / 12 * ALPHA * 1e2  # moment at the end, and its slope
    assert np.isclose(solution.displacement((1.0, 0.1))[2], -ALPHA * 1e2 / 6, rtol=1e-9)
    # The linear part is a difference: rounding over a step of 1e-5.
    assert np.abs(solution.section_forces(INSIDE)[:, 3:]).max() < 1e-8 * held
    assert np.abs(solution.shear_forces(INSIDE)).max() < 1e-6 * held
    assert solution.shear_share == 0
    whole = system_on("auto", strip, [sk.Clamp("left")], load, (8, 2), law)
    assert whole.choice.theory == "kirchhoff" and whole.choice.share == 0


def test_shear_force_of_a_held_gradient():
    """Both ends of a strip clamped, g = g1 x: M = D (kappa - alpha g) is linear in x by equilibrium, and the ends neither
    turn nor move where kappa and x kappa have no mean; so M = -D alpha g1 x, and Q = -D alpha g1."""
    law = sk.Isotropic(E, 0.0, 1.0, expansion=ALPHA)
    strip, load = sk.Rectangle(1.0, 0.2), sk.Temperature(gradient=lambda x, y: 1e2 * x)
    supports = [sk.Clamp(["left", "right"]), sk.Symmetry("top"), sk.Symmetry("bottom")]
    solution = sk.solve_linear(system_on("kirchhoff", strip, supports, load, (8, 2), law))
    assert np.allclose(solution.shear_forces()[:, 0], -E * T**3 / 12 * ALPHA * 1e2, rtol=1e-6)


def test_section_forces_of_the_three_dimensional_law():
    """A free plate has none, with the thickness strain that the law couples to those in the plane."""
    law = sk.Isotropic(E, NU, 2000.0, kind="3d", expansion=ALPHA)
    solution = sk.solve(system_on("full", PLATE, JUST_HELD, sk.Temperature(50.0), material=law), rtol=1e-12).unwrap()
    assert np.abs(solution.section_forces(INSIDE)).max() < 1e-9 * E * T * ALPHA * 50.0


def test_a_free_plate_with_a_gradient_has_no_stress_across():
    """Strain 33 of theory `full` is one through the thickness: if laws do not couple it, the mean of the free one."""
    load = sk.Temperature(0.0, 5000.0)
    solution = sk.solve_linear(system_on("full", PLATE, JUST_HELD, load))
    held = solution.system.shell.thermal_energy()
    assert abs(solution.strain_energy) < 1e-9 * held
    for z in ("top", "bottom"):
        assert np.abs(solution.stresses(INSIDE, z)).max() < 1e-9 * E * ALPHA * 5000.0 * T


def test_bimetals_have_one_energy_in_both_theories():
    """Free to bend and to expand; that of lamination theory, to rounding."""
    layers = [sk.Layer(sk.Isotropic(E, 0.25, 1.0, expansion=ALPHA), 0.004),
              sk.Layer(sk.Isotropic(0.3 * E, 0.35, 1.0, expansion=-ALPHA), 0.007)]  # fmt: skip
    thin, full = (
        sk.solve_linear(system_on(theory, PLATE, JUST_HELD, sk.Temperature(7.0, 300.0), material=sk.Laminate(layers),
                                  thickness=None)).strain_energy
        for theory in ("kirchhoff", "full")
    )  # fmt: skip
    assert thin > 0 and full == pytest.approx(thin, rel=1e-9)
