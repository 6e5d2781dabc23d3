"""What rounding leaves of small elements, thin sections and small loads, and that it is said where it leaves nothing."""

import warnings

import numpy as np
import pytest

import skancf as sk
from skancf.linear import BlockMatrix
from skancf.meshes import tensor
from skancf.output.sampling import sample_surface
from skancf.system.unstressed import derivative

STEEL = sk.Isotropic(210e9, 0.3, 7850.0)


def deep(surface, times: int, at):
    """Quarters of the element that holds a point, again and again."""
    mesh = sk.meshes.quadtree(sk.meshes.uniform(surface, 3, 3), surface)
    for _ in range(times):
        inside = (mesh.p[:, mesh.t].min(axis=1) <= np.reshape(at, (2, 1))) & (
            mesh.p[:, mesh.t].max(axis=1) > np.reshape(at, (2, 1)))  # fmt: skip
        mesh = mesh.refined(np.flatnonzero(inside.all(axis=0)))
    return mesh


CONE = sk.Cone(0.6, 1.1, 0.9, 0.8)


@pytest.fixture(scope="module")
def two_meshes():
    """A sector of a cone, and the same with an element of 1e-5 of its size."""
    (x0, x1), (y0, y1) = CONE.bounds
    at = (0.37 * x0 + 0.63 * x1, 0.41 * y0 + 0.59 * y1)
    problem = sk.Problem(CONE, 0.01, STEEL, [sk.Clamp("left")], [sk.SurfaceLoad((0.0, 40.0, -100.0))])
    return [problem.on(deep(CONE, times, at), theory="kirchhoff") for times in (11, 16)]


def test_small_elements_change_no_frequency(two_meshes):
    """By the stiffness of the small elements a frequency would be wrong in the third digit: (L / h)^2 = 2e10 roundings."""
    coarse, fine = (sk.modes(system, 3) for system in two_meshes)
    assert np.allclose(fine.frequencies, coarse.frequencies, rtol=1e-7)  # what quarters of an element of 2^-13 more gain
    assert not [check for check in fine.checks if not check.passed]
    values = [two_meshes[1].stiffness().energy(v) * 2 for v in fine.shapes]
    assert np.allclose(values, fine.eigenvalues, rtol=1e-9)


def test_reactions_of_small_elements_balance_the_loads(two_meshes):
    answers = [sk.solve_linear(system) for system in two_meshes]
    areas = [system.assembly.areas.sum() for system in two_meshes]
    for answer, area in zip(answers, areas, strict=True):
        assert np.allclose(answer.reactions() / area, [0.0, -40.0, 100.0], atol=1e-9)
    coarse, fine = (answer.strain_energy for answer in answers)
    assert fine == pytest.approx(coarse, rel=1e-7)


def test_entries_do_not_have_the_digits_that_strains_have(two_meshes):
    """So that the test above has something to find: the same product of the entries is wrong."""
    system = two_meshes[1]
    exact, u = system.stiffness(), sk.solve_linear(system).change
    entries = BlockMatrix(exact.pattern, exact.values)
    work = float(u @ system.external_force(system.undeformed))
    wrong = [abs(2 * matrix.energy(u) / work - 1) for matrix in (exact, entries)]
    assert wrong[0] < 1e-12 and wrong[1] > 1e-9


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_energy_by_strains_is_that_of_the_entries(theory):
    """Where both have digits; springs count in both."""
    surface = sk.CylinderSector(1.2, 0.9, 0.7)
    problem = sk.Problem(surface, 0.05, STEEL, [sk.Clamp("left"), sk.Foundation(1e7)], [])
    system = problem.on(sk.meshes.uniform(surface, 3, 2), theory=theory)
    K, x = system.stiffness(), np.random.default_rng(3).standard_normal(system.n_dofs)
    plain = BlockMatrix(K.pattern, K.values)
    assert np.allclose(K @ x, plain @ x, atol=1e-12 * np.abs(plain @ x).max())
    assert K.energy(x) == pytest.approx(plain.energy(x), rel=1e-12)
    both = 2.0 * K + (-3.0) * system.mass
    assert np.allclose(both @ x, 2 * (plain @ x) - 3 * (system.mass @ x), atol=1e-12 * np.abs(plain @ x).max())
    assert both.energy(x) == pytest.approx(2 * plain.energy(x) - 3 * system.mass.energy(x), rel=1e-12)


@pytest.mark.parametrize("ratio", [2000, 30_000])
def test_rows_of_slivers(ratio):
    """A row of elements so many times as long as wide changes a plate by what a row more gains."""
    surface = sk.Rectangle(1.2, 0.8)
    supports = [sk.Clamp("bottom"), sk.SimpleSupport("top")]
    found = []
    for extra in ([], [0.3 + 0.2 / ratio]):
        mesh = tensor(surface, np.linspace(0, 1.2, 7), np.sort([*np.linspace(0, 0.8, 5), *extra]))
        system = sk.Problem(surface, 0.01, STEEL, supports, [sk.SurfaceLoad((0, 0, -500.0))]).on(mesh, theory="kirchhoff")
        with warnings.catch_warnings():
            warnings.simplefilter("error", sk.OutOfDepth)
            modes, answer = sk.modes(system, 3), sk.solve_linear(system)
        found.append([*modes.frequencies, *np.atleast_1d(answer.displacement((0.5, 0.5)))[2:], answer.reactions()[2]])
    assert np.allclose(found[1], found[0], rtol=1e-3)
    assert found[1][-1] == pytest.approx(500.0 * 0.96, rel=1e-10)


def test_a_plate_that_has_lost_its_digits_says_so():
    """A row of elements two million times as long as wide: the factors are rounding along its motions."""
    surface = sk.Rectangle(1.2, 0.8)
    mesh = tensor(surface, np.linspace(0, 1.2, 7), np.sort([*np.linspace(0, 0.8, 5), 0.2 + 1e-7]))
    problem = sk.Problem(surface, 0.01, STEEL, [sk.Clamp("boundary")], [sk.SurfaceLoad((0, 0, -500.0))])
    with pytest.warns(sk.OutOfDepth, match="lost digits|Check failed"):
        try:
            sk.modes(problem.on(mesh, theory="kirchhoff"), 2)
            sk.solve_linear(problem.on(mesh, theory="kirchhoff"))
        except (sk.SingularMatrix, sk.DidNotConverge) as said:
            warnings.warn(str(said), sk.OutOfDepth, stacklevel=1)


@pytest.mark.parametrize(("theory", "slenderness"), [("full", 3e-6), ("kirchhoff", 3e-8)])
def test_the_first_frequency_of_a_thin_strip(theory, slenderness):
    """Euler's beam; twelve elements of theory `full` are 0.2 % off at any thickness."""
    t, length, E, rho = 2.5 * slenderness, 2.5, 3e9, 1200.0
    surface = sk.Rectangle(length, 0.2)
    system = sk.Problem(surface, t, sk.Isotropic(E, 0.0, rho), [sk.Clamp("left")], []).on(
        sk.meshes.uniform(surface, 12, 1), theory=theory)  # fmt: skip
    exact = 1.8751040687**2 / (2 * np.pi) * np.sqrt(E * t**2 / 12 / rho) / length**2
    assert sk.modes(system, 1).frequencies[0] == pytest.approx(exact, rel=2e-3 if theory == "full" else 1e-6)


def curved_panel(load: float):
    surface = sk.CylinderSector(0.9, 1.4, 1.1)
    problem = sk.Problem(surface, 0.004, STEEL, [sk.Clamp("left"), sk.SimpleSupport("right")],
                         [sk.SurfaceLoad((0.0, 0.0, -load))])  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, 5, 5), theory="kirchhoff")


def test_answers_to_tiny_loads_are_those_to_loads():
    """Linear in the load to the last digits: with strains of 1e-16 no difference of positions has any."""
    tiny = 1e-11
    one, other = (sk.solve_linear(curved_panel(load)) for load in (700.0, 700.0 * tiny))
    at = (0.45, 0.8)
    for value in (
        lambda s: s.displacement(at), lambda s: s.displacement(at, z="top"), lambda s: s.rotation(at),
        lambda s: s.displacements, lambda s: sample_surface(s, 2, "top").displacement,
        lambda s: s.section_forces(), lambda s: s.nodal_stresses("bottom"), lambda s: s.reactions("left"),
        lambda s: sk.SectionForce("N22", at=at).value(s), lambda s: s.shear_forces(),
    ):  # fmt: skip
        expected = np.asarray(value(one))
        assert np.allclose(np.asarray(value(other)) / tiny, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    assert other.strain_energy / tiny**2 == pytest.approx(one.strain_energy, rel=1e-11)
    assert other.shear_share == pytest.approx(one.shear_share, rel=1e-9)
    assert other.rest_share == pytest.approx(one.rest_share, rel=1e-9)


def test_buckling_by_tiny_loads():
    factors = [sk.buckling(curved_panel(load), 2).load_factors * load for load in (1e4, 1e-5, 1e-20)]
    assert np.allclose(factors[1:], factors[0], rtol=1e-8)


def test_modes_about_a_linear_answer_on_small_elements():
    """A plate in tension, with an element of 2^-16 of its size: a membrane's frequencies and those of the plate together."""
    surface, N = sk.Rectangle(1.0, 1.0), 3e5
    supports = [sk.Prescribed("boundary", (None, None, 0.0)), sk.Roller("left", direction=(1, 0, 0)),
                sk.Roller("bottom", direction=(0, 1, 0))]  # fmt: skip
    loads = [sk.EdgeLoad("right", (N, 0, 0)), sk.EdgeLoad("top", (0, N, 0))]
    system = sk.Problem(surface, 0.004, STEEL, supports, loads).on(deep(surface, 14, (0.41, 0.61)), theory="kirchhoff")
    D, mass = 210e9 * 0.004**3 / 12 / 0.91, 7850 * 0.004
    exact = np.sqrt((D * (2 * np.pi**2) ** 2 + N * 2 * np.pi**2) / mass) / (2 * np.pi)
    found = sk.modes(system, 1, state=sk.solve_linear(system)).frequencies[0]
    assert found == pytest.approx(exact, rel=1e-4)


def test_a_mechanism_is_still_one():
    """Two strips that a hinge joins, held at one end: products by strains find no stiffness in it."""
    surface = sk.Rectangle(2.0, 0.3)
    problem = sk.Problem(surface, 0.01, STEEL, [sk.Pin((0.0, 0.0)), sk.Pin((0.0, 0.3))], [sk.SurfaceLoad((0, 0, -1.0))])
    system = problem.on(deep(surface, 10, (1.3, 0.1)), theory="kirchhoff")
    with pytest.raises((sk.SingularMatrix, sk.InputError)):
        sk.solve_linear(system)


def test_free_plates_with_small_elements_have_six_rigid_motions():
    surface = sk.Rectangle(1.0, 0.7)
    for theory in ("kirchhoff", "full"):
        system = sk.Problem(surface, 0.01, STEEL, [], []).on(deep(surface, 9, (0.4, 0.2)), theory=theory)
        found = sk.modes(system, 8)
        assert found.n_rigid == 6 and (found.eigenvalues[6:] > 1.0).all()


def test_complex_steps_are_derivatives():
    """Of a function whose derivative is known: the length of all nodal coordinates."""
    system = curved_panel(1.0)
    q, u = system.undeformed, np.random.default_rng(0).standard_normal(system.n_dofs)
    rate = derivative(lambda at: np.sqrt((at * at).sum()), q, 1e-30 * u)
    assert float(rate) == pytest.approx(1e-30 * float(q @ u) / np.sqrt(q @ q), rel=1e-13)
