"""Terms from forms: against the library's own loads and theories, known integrals, series and differences."""

from math import pi

import numpy as np
import pytest
import skfem
from problems import SURFACES
from skfem.helpers import ddot, dot, grad
from test_hanging import tree
from test_thin_kernel import mixed

import skancf as sk
from skancf.elements.quad_ancf import square_quadrature
from skancf.errors import InputError
from skancf.layout.geometry import Geometry
from skancf.system.build import assemble
from skancf.terms.forms import points
from skancf.terms.shell import Shell
from skancf.testing import check_term

# Sums of some hundred products; relative to the largest entry. Tangents of an energy alone are differences.
SUMS, DIFFERENCES = 1e-11, 1e-7
MATERIAL = sk.Isotropic(1e6, 0.3, 2000.0)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])


def problem(surface, terms=(), supports=(), loads=(), thickness=0.05):
    return sk.Problem(surface, thickness, MATERIAL, supports=list(supports), loads=list(loads), terms=list(terms))


def on_mesh(name, terms=(), theory="kirchhoff", **given):
    """A tree with hanging nodes; closed ones have seams and poles."""
    return problem(SURFACES[name][0], terms, **given).on(tree(name), theory)


def disturbed(system, rng, amount=0.03):
    return system.undeformed + amount * rng.normal(size=system.n_dofs)


def close(found, expected, tolerance):
    return np.abs(found - expected).max() < tolerance * np.abs(expected).max()


def own(system):
    """Energy, force, tangent and skew part of the last of the structure's terms."""
    (term,) = system.others
    empty = problem(system.geometry.surface).on(system.mesh, system.geometry.theory)

    def at(q):
        tangent = system.tangent(q).to_scipy() - empty.tangent(q).to_scipy()
        return term.energy(q, sk.Case()), term.force(q, None, sk.Case()), tangent.toarray(), system.skew(q)

    return at


FOUNDATION = {
    "kirchhoff": sk.FormTerm(energy=lambda w: 0.5 * 300.0 * dot(w.u, w.N) ** 2),
    "full": sk.FormTerm(energy=lambda w: 0.5 * 300.0 * dot(w.u, w.D) ** 2 / dot(w.D, w.D)),
}


# --- against the library's own ---------------------------------------------------------------------------------------


@theories
@pytest.mark.parametrize("name", ["flat", "tube", "disc"])
def test_a_foundation_is_that_of_the_library(name, theory, rng):
    mine = on_mesh(name, [FOUNDATION[theory]], theory)
    theirs = on_mesh(name, theory=theory, supports=[sk.Foundation(300.0)])
    q = disturbed(mine, rng)
    energy, force, tangent, _ = own(mine)(q)
    # On curved surfaces theory `full` has the area of the volume there, per height, and not that of the surface.
    exact = theory == "kirchhoff" or name != "tube"
    assert np.isclose(energy, 0.5 * force @ (q - mine.undeformed), rtol=SUMS)
    change = q - mine.undeformed
    assert close(force, theirs.foundation @ change, SUMS if exact else 1e-2)
    assert close(tangent, theirs.foundation.to_scipy().toarray(), DIFFERENCES if exact else 1e-2)


@theories
@pytest.mark.parametrize("name", ["flat", "tube"])
def test_a_pressure_is_that_of_the_library(name, theory, rng):
    """Its skew part too, of free edges: an open tube, and a plate."""
    residual = skfem.LinearForm(lambda v, w: -5.0 * dot(v, w.n) * w.J)
    form = sk.FormTerm(residual=residual, load=True, history=lambda t: 2.0 * t, points=5)
    mine = on_mesh(name, [form], theory)
    theirs = on_mesh(name, theory=theory, loads=[sk.FollowerPressure(5.0, history=lambda t: 2.0 * t)])
    q, case = disturbed(mine, rng), sk.Case(0.7, 0.4)
    assert close(mine.external_force(q, case), theirs.external_force(q, case), SUMS)
    assert close(mine.tangent(q, case).to_scipy().toarray(), theirs.tangent(q, case).to_scipy().toarray(), SUMS)
    assert close(mine.skew(q, case).toarray(), theirs.skew(q, case).toarray(), SUMS)
    assert close(2 * mine.external_force(q, sk.Case(0.7, 0.2)), mine.external_force(q, case), SUMS), "linear in time"


@theories
def test_an_edge_load_is_that_of_the_library(theory, rng):
    form = sk.FormTerm(residual=lambda v, w: -(3.0 * v[0] - 2.0 * v[2]), load=True, where=["right", "top"])
    mine = on_mesh("flat", [form], theory)
    theirs = on_mesh("flat", theory=theory, loads=[sk.EdgeLoad(["right", "top"], (3.0, 0.0, -2.0))])
    q = disturbed(mine, rng)
    assert close(mine.external_force(q), theirs.external_force(q), SUMS)


STIFFNESS = 1e6 * 0.05 / (1 - 0.09)


def koiter(w):
    """Energy of an isotropic surface in any parameters, from metric and curvature."""
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(w.A, (0, 1), (-2, -1))), (-2, -1), (0, 1))

    def quadratic(e):
        mixed_parts = np.einsum("ab...,bc...->ac...", inverse, e)
        trace, square = np.einsum("aa...->...", mixed_parts), np.einsum("ab...,ba...->...", mixed_parts, mixed_parts)
        return STIFFNESS / 2 * (0.3 * trace**2 + 0.7 * square)

    return quadratic((w.a - w.A) / 2) + 0.05**2 / 12 * quadratic(w.B - w.b)


def test_the_thin_theory_is_an_energy_of_metric_and_curvature(rng):
    """On a ring, whose parameters are polar coordinates."""
    surface = sk.AnnulusSector(0.5, 1.0, 1.2)
    mesh = mixed(sk.meshes.uniform(surface, 2, 2))
    system = problem(surface).on(mesh, sk.Kirchhoff(assumed=False))
    term = sk.FormTerm(energy=koiter).on(system.shell, system.layout)
    q, case = disturbed(system, rng, 0.01), sk.Case()
    assert np.isclose(term.energy(q, case), system.strain_energy(q), rtol=SUMS)
    assert close(term.force(q, None, case), system.internal_force(q), 1e-9)
    blocks = system.blocks()
    term.add_tangent(q, None, case, blocks)
    assert close(blocks.matrix().to_scipy().toarray(), system.tangent(q).to_scipy().toarray(), DIFFERENCES)
    assert not np.isclose(term.energy(q, case), 1.001 * system.strain_energy(q), rtol=1e-4)


# --- energy, residual and tangent are one ----------------------------------------------------------------------------


def tension(w):
    return 2.0 * w.J + 30.0 * w.u[2] ** 4


@skfem.LinearForm
def tension_residual(v, w):
    """With a dual basis of r_x, r_y: the change of area is the divergence of the variation."""
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(w.a, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    dual = np.einsum("ab...,ib...->ia...", inverse, grad(w.r))
    return 2.0 * w.J * ddot(dual, grad(v)) + 120.0 * w.u[2] ** 3 * v[2]


@theories
@pytest.mark.parametrize("name", ["flat", "disc"])
def test_residuals_and_tangents_are_made_of_energies(name, theory, rng):
    terms = {"energy": sk.FormTerm(energy=skfem.Functional(tension)), "residual": sk.FormTerm(residual=tension_residual)}
    found = {}
    for kind, term in terms.items():
        system = on_mesh(name, [term], theory)
        found[kind] = own(system)(disturbed(system, np.random.default_rng(1), 0.01))
    (_, force, tangent, none), (energy, other_force, other_tangent, _) = found["energy"], found["residual"]
    assert energy is None and none is None
    assert close(force, other_force, 1e-10) and close(tangent, other_tangent, DIFFERENCES)


@theories
def test_a_tangent_is_taken_as_it_is_given(theory, rng):
    residual = skfem.LinearForm(lambda v, w: 7.0 * w.u[0] * v[2])
    tangent = skfem.BilinearForm(lambda u, v, w: 7.0 * u[0] * v[2])
    found = []
    for form in (sk.FormTerm(residual=residual), sk.FormTerm(residual=residual, tangent=tangent)):
        system = on_mesh("flat", [form], theory)
        found.append(own(system)(disturbed(system, np.random.default_rng(1))))
    assert close(found[0][2], found[1][2], SUMS) and close(found[0][3].toarray(), found[1][3].toarray(), SUMS)
    assert np.abs(found[0][2] - found[0][2].T).max() < 1e-12, "the other part is kept apart"
    assert abs(found[0][3] + found[0][3].T).max() < 1e-15


EVERYTHING = {
    "kirchhoff": lambda w: np.tanh(w.H) + w.K + w.r_x[0] * w.r_yy[2] + dot(w.n, w.N) + ddot(w.b, w.B) + w.x[0] * w.J,
    "full": lambda w: dot(w.d, w.d) ** 2 + dot(w.d_x, w.n) + dot(w.D, w.d) * w.r_y[1] + w.x[1] * ddot(w.a, w.A) + w.da,
}


@theories
@pytest.mark.parametrize("name", ["flat", "ring", "cap"])
def test_every_field_is_differentiated_exactly(name, theory):
    check_term(sk.FormTerm(energy=EVERYTHING[theory]), on_mesh(name, theory=theory))


@theories
def test_every_field_of_an_edge_is_differentiated_exactly(theory):
    surface = sk.AnnulusSector(0.5, 1.0, 1.2)
    for where in ("inner", "start"):
        form = sk.FormTerm(energy=lambda w: w.stretch**2 + w.s[0] * w.nu[1] + dot(w.u, w.n), where=where)
        check_term(form, problem(surface), theory=theory)


@theories
def test_drag_is_damping(theory, rng):
    """Piston theory: pressure against the velocity and the slope along a stream; its damping and skew tangent."""
    piston = sk.FormTerm(residual=lambda v, w: 3.0 * (dot(w.v, w.n) - 40.0 * w.n[0]) * dot(w.n, v) * w.J, load=True)
    report = check_term(piston, problem(sk.Rectangle(1.0, 1.0)), theory=theory)
    assert "damping against force" in report.errors
    drag = sk.FormTerm(residual=lambda v, w: 5.0 * dot(w.v, v))
    system = on_mesh("tube", [drag], theory)
    velocity, blocks = rng.normal(size=system.n_dofs), system.blocks()
    force = system.others[0].force(system.undeformed, velocity, sk.Case())
    system.others[0].add_damping(system.undeformed, velocity, sk.Case(), blocks)
    assert close(blocks.matrix() @ velocity, force, SUMS)
    assert not system.others[0].force(system.undeformed, None, sk.Case()).any()


def test_what_does_not_depend_on_the_state_has_no_tangent():
    surface = sk.Rectangle(1.0, 1.0)
    for form in (sk.FormTerm(residual=lambda v, w: 2.0 * v[2], load=True), sk.FormTerm(energy=lambda w: 1.0)):
        check_term(form, problem(surface))


def test_variations_have_directors_and_second_derivatives():
    thick = sk.FormTerm(residual=lambda v, w: dot(w.d, v.d) + w.u[0] * v.d.grad[2, 1])
    thin = sk.FormTerm(residual=lambda v, w: (w.r.hess * v.hess).sum(axis=(0, 1, 2)))
    check_term(thick, problem(sk.Rectangle(1.0, 1.0)), theory="full")
    check_term(thin, problem(sk.Rectangle(1.0, 1.0)), theory="kirchhoff")


@theories
def test_many_calls_are_one(theory, rng, monkeypatch):
    system = on_mesh("disc", [sk.FormTerm(energy=tension)], theory)
    q = disturbed(system, rng, 0.01)
    expected = own(system)(q)
    monkeypatch.setattr(points, "AT_ONCE", 50)
    again = on_mesh("disc", [sk.FormTerm(energy=tension)], theory)
    assert len(again.others[0].chunks) > 3 == len(system.others[0].chunks) + 2
    found = own(again)(q)
    assert np.isclose(found[0], expected[0], rtol=SUMS)
    assert close(found[1], expected[1], SUMS) and close(found[2], expected[2], SUMS)


# --- known integrals -------------------------------------------------------------------------------------------------


def energy_of(form, system, q=None):
    return form.on(system.shell, system.layout).energy(system.undeformed if q is None else q, sk.Case())


@theories
def test_areas_and_lengths(theory):
    surface = sk.Rectangle(2.0, 0.5)
    system = problem(surface).on(sk.meshes.uniform(surface, 4, 3), theory)
    stretched = system.undeformed * np.tile([1.5, 1.2, 1.0], system.n_dofs // 3)
    area, one = sk.FormTerm(energy=lambda w: w.J), sk.FormTerm(energy=lambda w: 1.0 + 0.0 * w.J)
    assert np.isclose(energy_of(area, system, stretched), 1.5 * 1.2, rtol=SUMS)
    assert np.isclose(energy_of(one, system, stretched), 1.0, rtol=SUMS)
    length = sk.FormTerm(energy=lambda w: w.stretch, where=["top", "left"])
    assert np.isclose(energy_of(length, system, stretched), 1.5 * 2.0 + 1.2 * 0.5, rtol=SUMS)
    half = sk.FormTerm(energy=lambda w: w.J, where=lambda x, y: x < 1.0)
    assert np.isclose(energy_of(half, system), 0.5, rtol=SUMS)


SIDES = {"left": (0, 0.0), "right": (0, 2.0), "top": (1, 0.5)}


def test_elements_with_points_of_their_own_are_integrated_with_them():
    """Half of one element, as an outline that cuts it would leave."""
    surface = sk.Rectangle(1.0, 1.0)
    mesh, (gauss, weights) = sk.meshes.uniform(surface, 2, 2), square_quadrature(4)
    geometry = Geometry(mesh, surface, sk.Kirchhoff(), {1: (gauss * [[0.5], [1.0]], 0.5 * weights)})
    system = problem(surface).on(mesh, "kirchhoff")
    shell = Shell(assemble(geometry, system.problem.section), system.layout)
    x = system.mesh.p[0, system.mesh.t[:, 1]]
    for where, area in ((None, 0.875), (lambda x, y: x < 0.5, 0.375 if x.max() <= 0.5 else 0.5)):
        term = sk.FormTerm(energy=lambda w: w.J, where=where).on(shell, system.layout)
        assert np.isclose(term.energy(system.undeformed, sk.Case()), area, rtol=SUMS)
    check_term(sk.FormTerm(energy=tension).on(shell, system.layout), system)


@pytest.mark.parametrize("clockwise", [False, True])
def test_conormals_point_outwards_and_edges_have_the_surface_on_their_left(clockwise):
    surface = sk.Rectangle(2.0, 0.5)
    mesh = sk.meshes.uniform(surface, 2, 2)
    if clockwise:
        mesh = mixed(mesh).with_boundaries({name: (lambda x, i=i, at=at: x[i] == at) for name, (i, at) in SIDES.items()})
    system = problem(surface).on(mesh, "full")
    for name, out, along in (("left", (-1, 0), (0, -1)), ("right", (1, 0), (0, 1)), ("top", (0, 1), (-1, 0))):
        length = {"left": 0.5, "right": 0.5, "top": 2.0}[name]
        for field, way in (("nu", out), ("s", along)):
            for i in (0, 1):
                form = sk.FormTerm(energy=lambda w, field=field, i=i: w[field][i], where=name)
                assert np.isclose(energy_of(form, system), length * way[i], atol=1e-13)


def test_bending_energy_of_a_sphere_is_eight_pi():
    """Canham's energy of any sphere, H = 1 / R, and Gauss and Bonnet's of any closed one."""
    for radius in (1.0, 3.0):
        surface = sk.SphereSector(radius, (0.0, pi), 2 * pi, closed=True)
        system = problem(surface).on(sk.meshes.uniform(surface, 12, 16), "kirchhoff")
        bending = sk.FormTerm(energy=lambda w: 0.5 * (2 * w.H) ** 2 * w.J)
        gauss = sk.FormTerm(energy=lambda w: w.K * w.J)
        # Bicubic elements of 15 degrees have the curvature to some thousandths, squared: 1e-3 at most.
        assert np.isclose(energy_of(bending, system), 8 * pi, rtol=1e-3)
        assert np.isclose(energy_of(gauss, system), 4 * pi, rtol=1e-3)


# --- solvers ---------------------------------------------------------------------------------------------------------


def winkler(k, load, D, side, terms=80):
    """Navier's series of the middle of a hinged square plate on a foundation."""
    m, n = np.meshgrid(np.arange(1, terms, 2), np.arange(1, terms, 2))
    w = 16 * load / (pi**2 * m * n) / (D * pi**4 / side**4 * (m**2 + n**2) ** 2 + k)
    return float((w * np.sin(m * pi / 2) * np.sin(n * pi / 2)).sum())


def test_a_plate_on_a_foundation_sinks_by_its_series():
    k, load, surface = 4e3, -1e-3, sk.Rectangle(1.0, 1.0)
    D = 1e6 * 0.02**3 / 12 / (1 - 0.09)
    system = problem(
        surface, [sk.FormTerm(energy=lambda w: 0.5 * k * w.u[2] ** 2)], [sk.SimpleSupport("boundary", kind="hard")],
        [sk.SurfaceLoad((0.0, 0.0, load))], 0.02,
    ).on(sk.meshes.uniform(surface, 8, 8), "kirchhoff")  # fmt: skip
    found = sk.solve(system).unwrap().displacement((0.5, 0.5))[2]
    small = sk.solve_linear(system).displacement((0.5, 0.5))[2]
    expected = winkler(k, load, D, 1.0)
    assert np.isclose(found, expected, rtol=1e-3) and np.isclose(small, expected, rtol=1e-3)
    assert abs(winkler(0.0, load, D, 1.0) / expected) > 2, "the foundation carries most of it"


def test_a_force_of_the_undeformed_state_moves_it_in_small_deflections_too():
    surface, mesh = sk.Rectangle(1.0, 1.0), sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 3, 3)
    pulled = problem(surface, [sk.FormTerm(energy=lambda w: 1e-6 * w.u[2] + 3.0)], [sk.Clamp("left")]).on(mesh, "kirchhoff")
    loaded = problem(surface, [], [sk.Clamp("left")], [sk.SurfaceLoad((0, 0, -1e-6))]).on(mesh, "kirchhoff")
    found, expected = (sk.solve_linear(system) for system in (pulled, loaded))
    assert close(found.change, expected.change, 1e-9)
    # The plate's own energy, less twice as much of the pull.
    assert np.isclose(found.strain_energy, 3.0 - expected.strain_energy, rtol=1e-12)
    assert np.isclose(pulled.strain_energy(found.q), found.strain_energy, rtol=1e-12)


def test_newton_turns_back_from_where_an_energy_ends():
    """A barrier of a logarithm: a step through the wall is no number, and a shorter one follows."""
    surface, k, deep = sk.Rectangle(1.0, 1.0), 1e-2, 0.02
    wall = sk.FormTerm(energy=lambda w: -k * np.log(1 + w.u[2] / deep))
    loads, mesh = [sk.SurfaceLoad((0.0, 0.0, -20.0))], sk.meshes.uniform(surface, 3, 3)
    systems = [problem(surface, terms, [sk.Clamp("left")], loads, 0.02).on(mesh, "kirchhoff") for terms in ([wall], [])]
    stopped, free = (sk.solve(system).unwrap().displacement((1.0, 1.0))[2] for system in systems)
    assert -deep < stopped < -0.8 * deep and free < -10 * deep


@theories
def test_the_books_of_a_motion_balance(theory):
    """A plate thrown at a stiffening foundation, with a load of the user's own that has no potential."""
    surface = sk.Rectangle(1.0, 0.5)
    ground = sk.FormTerm(energy=lambda w: 2e4 * w.u[2] ** 4)
    wind = sk.FormTerm(residual=lambda v, w: -90.0 * w.J * dot(w.n, v), load=True, history=sk.Ramp(0.1))
    tide = sk.FormTerm(energy=lambda w: 300.0 * w.u[2] ** 2 + w.u[0] ** 4, load=True)
    drag = sk.FormTerm(residual=lambda v, w: 10.0 * dot(w.v, v))
    system = problem(surface, [ground, wind, tide, drag]).on(sk.meshes.uniform(surface, 2, 1), theory)
    thrown = sk.RigidVelocity((0.0, 0.0, 3.0))
    motion = sk.simulate(system, 0.1, dt=0.005, rule=sk.EnergyMomentum(), velocity=thrown, newton_rtol=1e-11, outputs=2,
                         balance=None, progress=False)  # fmt: skip
    ledger = motion.ledger
    assert np.ptp(ledger.strain) > 0.2 * ledger.turnover[-1] and np.ptp(ledger.work) > 0.02 * ledger.turnover[-1]
    # Newton's method ends at 1e-11.
    assert np.abs(ledger.balance).max() < 1e-8 * ledger.turnover[-1]


@theories
def test_a_tangent_that_is_not_symmetric_counts_whole_in_small_deflections(theory):
    """A pressure along the slope in a stream: as the large deflections of a small load, and eigenvalues warn."""
    surface = sk.Rectangle(1.0, 0.5)
    mesh, load = sk.meshes.uniform(surface, 3, 2), [sk.SurfaceLoad((0.0, 0.0, -1e-4))]
    stream = sk.FormTerm(residual=lambda v, w: 8.0 * w.r_x[2] * v[2])
    found = []
    for terms in ([stream], [sk.FormTerm(residual=lambda v, w: 0.0 * v[2])]):
        system = problem(surface, terms, [sk.Clamp("left")], load).on(mesh, theory)
        small, large = sk.solve_linear(system), sk.solve(system, rtol=1e-10).unwrap()
        assert close(small.change, large.change, 1e-5)
        assert np.allclose(small.reactions(), large.reactions(), rtol=1e-5, atol=1e-12)
        found.append(small.displacement((1.0, 0.5))[2])
    assert abs(found[0] / found[1] - 1) > 0.05, "the stream counts"
    streaming = problem(surface, [stream], [sk.Clamp("left")], load)
    with pytest.warns(sk.OutOfDepth, match="terms of one's own, have no potential"):
        sk.modes(streaming.on(mesh, theory), 1)
    small, large = (sk.adapt(streaming, sk.Displacement((1.0, 0.5), (0, 0, 1)), rtol=1e-2, linear=linear, mesh=mesh,
                             theory=theory, max_dofs=3000) for linear in (True, False))  # fmt: skip
    assert np.isclose(small.value, large.value, rtol=1e-4) and np.isclose(small.error_bar, large.error_bar, rtol=1e-2)


@pytest.mark.parametrize("rule", [sk.EnergyMomentum(rho_inf=1.0), sk.GeneralizedAlpha(1.0)])
def test_what_time_does_to_an_energy_is_work(rule):
    """A foundation that hardens while a plate swings on it; a residual alone, of which all is work, moves it alike."""
    surface = sk.Rectangle(1.0, 0.5)

    def hard(w):
        return 2e3 * (1 + 100 * w.time)

    forms = {"energy": lambda w: 0.5 * hard(w) * w.u[2] ** 2}, {"residual": lambda v, w: hard(w) * w.u[2] * v[2]}
    ends = []
    for form in forms:
        system = problem(surface, [sk.FormTerm(**form)]).on(sk.meshes.uniform(surface, 1, 1), "kirchhoff")
        motion = sk.simulate(system, 0.05, dt=0.001, rule=rule, velocity=sk.RigidVelocity((0.0, 0.0, 1.0)), outputs=2,
                             balance=None, progress=False)  # fmt: skip
        ledger = motion.ledger
        assert system.others[0].timed == ("energy" in form)
        assert np.abs(ledger.work).max() > 0.05 * ledger.kinetic[0], "time does work"
        # Means of ends and middles of steps of a thirtieth of a period.
        assert np.abs(ledger.balance).max() < 5e-3 * ledger.turnover[-1]
        ends.append(motion.q[-1])
    assert close(*ends, 1e-3)


# --- what is refused -------------------------------------------------------------------------------------------------

WRONG = {
    "none of energy": ({}, "none of energy, residual and tangent: give an energy"),
    "no form": ({"energy": 3.0}, r"energy = 3.0: give a function of \(w\), or a skfem.Functional"),
    "wrong kind": ({"energy": skfem.LinearForm(lambda v, w: v[0])}, "energy is a skfem.LinearForm: give a skfem.Functional"),
    "arguments": ({"residual": lambda w: w.J}, r"it is called as residual\(v, w\)"),
    "tangent alone": ({"tangent": lambda u, v, w: u[0] * v[0]}, "a tangent alone"),
    "no residual": ({"energy": lambda w: w.J, "tangent": lambda u, v, w: u[0] * v[0]}, "a tangent and no residual"),
    "history": ({"energy": lambda w: w.J, "history": lambda t: t}, "only loads have one"),
    "points": ({"energy": lambda w: w.J, "points": 0}, "points = 0"),
    "load": ({"energy": lambda w: w.J, "load": "yes"}, "load = 'yes'"),
}
ON_MESH = {
    "unknown name": ({"energy": lambda w: w.foo}, r"w.foo: there is no such field; w has A, B, H, J, K"),
    "parameter": ({"energy": lambda w: w.y}, r"the parameters are x, y = w.x"),
    "edge": ({"energy": lambda w: w.stretch}, "edges have it: give where"),
    "director": ({"energy": lambda w: w.d[0]}, "theory 'full' has a director"),
    "shape": ({"energy": lambda w: w.u}, r"an array of shape \(3, 4, 16\); it must return one number for each"),
    "nothing": ({"energy": lambda w: None}, "returned None"),
    "another mesh": ({"energy": lambda w: np.ones((9, 16)) * w.J}, "fields of another basis or mesh do not fit"),
    "not finite": ({"energy": lambda w: 1 / w.u[2]}, r"the form is inf at \(.*\) .* not finite at 64 points of 64"),
    "complex": ({"energy": lambda w: 1j * w.J}, "complex numbers for real fields"),
    "abs": ({"energy": lambda w: np.abs(w.u[2]) ** 2}, "by complex steps, and its derivative by one is"),
    "norm": ({"energy": lambda w: np.linalg.norm(w.r_x, axis=0)}, "by complex steps"),
    "conj": ({"energy": lambda w: (w.u * np.conj(w.u)).sum(axis=0).real}, "by complex steps"),
    "no complex numbers": ({"energy": lambda w: np.floor(w.u[2])}, "takes no complex numbers"),
    "abs of residual": ({"residual": lambda v, w: np.abs(w.u[2]) * v[2]}, "residual: derivatives are taken by complex"),
    "moving energy": ({"energy": lambda w: w.v[2]}, "it reads the velocity w.v"),
    "not linear": ({"residual": lambda v, w: v[2] ** 2}, "not linear in v"),
    "without v": ({"residual": lambda v, w: w.u[2]}, "not linear in v"),
    "swapped": ({"residual": lambda w, v: w.u[2] * v[2]}, "u: a vector field has grad.*those of w, the last argument"),
    "truth": ({"energy": lambda w: w.u[2] < 0}, r"an array of shape \(4, 16\); it must return one number for each"),
    "time": ({"energy": lambda w: w.J, "where": "lid"}, "no boundary 'lid'"),
    "nowhere": ({"energy": lambda w: w.J, "where": lambda x, y: x > 5}, "true at no integration point"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_term(name):
    given, message = WRONG[name]
    with pytest.raises(InputError, match=message):
        sk.FormTerm(**given)


@pytest.mark.parametrize("name", ON_MESH)
def test_what_is_none_on_a_mesh(name):
    given, message = ON_MESH[name]
    surface = sk.Rectangle(1.0, 1.0)
    with pytest.raises(InputError, match=message):
        problem(surface, [sk.FormTerm(**given)]).on(sk.meshes.uniform(surface, 2, 2), "kirchhoff")


def test_what_only_the_thin_theory_has():
    surface = sk.Rectangle(1.0, 1.0)
    for name in ("H", "b", "r_xx", "X_xy", "B"):
        with pytest.raises(InputError, match=rf"w.{name}: there is no such field \(curvature needs theory 'kirchhoff'"):
            problem(surface, [sk.FormTerm(energy=lambda w, name=name: w[name])]).on(sk.meshes.uniform(surface, 2, 2), "full")


def test_time_begins_where_statics_is():
    surface = sk.Rectangle(1.0, 1.0)
    system = problem(surface, [sk.FormTerm(energy=lambda w: w.time * w.J)]).on(sk.meshes.uniform(surface, 2, 2), "full")
    assert system.others[0].energy(system.undeformed, sk.Case(time=3.0)) == pytest.approx(3.0)
    assert not system.others[0].force(system.undeformed, None, sk.Case()).any()


def test_exact_derivatives_need_no_complex_numbers():
    """With residual and tangent given, forms may be what they like."""
    surface = sk.Rectangle(1.0, 1.0)
    spring = sk.FormTerm(
        energy=lambda w: np.abs(w.u[2]) ** 3,
        residual=lambda v, w: 3 * np.abs(w.u[2]) * w.u[2] * v[2],
        tangent=lambda u, v, w: 6 * np.abs(w.u[2]) * u[2] * v[2],
    )
    report = check_term(spring, problem(surface), theory="kirchhoff")
    assert max(report.errors.values()) < 1e-6
