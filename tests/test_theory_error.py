"""What leaving shear out changes: against Ritz's method with shear, Saint-Venant's torsion, and what must be zero."""

import warnings
from math import pi

import numpy as np
import pytest
import skfem
from reference import coupled_ritz, thick_ritz

import skancf as sk
from skancf import InputError
from skancf.thinness import rim_of

NU = 0.25
EDGES = ["hard", "soft", "clamped", "two free"]


def quarter(edges, h, n, loads=((0, 0, 1.0),), theory="kirchhoff"):
    """A quarter of a square plate of side 1 with D = 1 and mass 1 per area."""
    surface, outer = sk.Rectangle(0.5, 0.5), ["left", "bottom"]
    supports = {"hard": sk.SimpleSupport(outer, kind="hard"), "soft": sk.SimpleSupport(outer), "clamped": sk.Clamp(outer),
                "two free": sk.SimpleSupport("left", kind="hard")}  # fmt: skip
    law = sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1 / h)
    problem = sk.Problem(surface, h, law, [supports[edges], sk.Symmetry("right"), sk.Symmetry("top")],
                         [sk.SurfaceLoad(load) for load in loads])  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, n), theory)


def quiet(function, *arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        return function(*arguments, **options)


def pair(edges, h):
    return (thick_ritz.uniform(edges, t, 12 if t else 8, NU) for t in (h, 0.0))


@pytest.mark.parametrize("h", [1 / 12, 1 / 30])
@pytest.mark.parametrize("edges", EDGES)
def test_deflections_and_energies(edges, h):
    """Estimate over true change from 0.9 to 1.15: of first order, on 5 x 5 elements a quarter."""
    solution = quiet(sk.solve_linear, quarter(edges, h, 5))
    thick, thin = pair(edges, h)
    at = (0.5, 0.0) if edges == "two free" else (0.5, 0.5)
    change = sk.theory_error(solution, sk.Displacement(at=at))
    true = thick.deflection(*at) - thin.deflection(*at)
    assert 0.9 < change.value / true < 1.15 and change.share == pytest.approx(change.value / thin.deflection(*at), rel=0.01)
    energy = sk.theory_error(solution)
    assert 0.9 < energy.value / ((thick.energy - thin.energy) / 4) < 1.15
    # The energy of a small-deflection answer needs no solve, and as a quantity it is the same.
    assert energy.share == pytest.approx(solution.shear_share, rel=1e-9)
    assert sk.theory_error(solution, sk.StrainEnergy()) == energy


def test_without_the_edge_layer_a_soft_support_is_missed():
    """So the test above can fail: what was inside was a ninth of the whole."""
    solution = quiet(sk.solve_linear, quarter("soft", 1 / 30, 5))
    form, fields = solution.shear_fields()
    inside = form.product(fields, type(fields)(fields.Q, 0 * fields.twisting, 0 * fields.sliding))
    thick, thin = pair("soft", 1 / 30)
    assert inside / (2 * solution.strain_energy) < 0.3 * (thick.energy / thin.energy - 1)


@pytest.mark.parametrize("edges", ["clamped", "soft"])
def test_mean_moments(edges):
    """Over 2 x 2 elements of a half: the true change is a few thousandths, the estimate at most 1.6 times that."""
    h, quantity = 1 / 16, sk.SectionForce("M11", within=((0.25, 0.5), (0.25, 0.5)))
    change = sk.theory_error(quiet(sk.solve_linear, quarter(edges, h, 8)), quantity)
    thick, thin = (plate.mean_moment(0.25, 0.75) for plate in pair(edges, h))
    assert 0.9 < change.value / (thick - thin) < 1.6 and change.sound


@pytest.mark.parametrize("h", [1 / 8, 1 / 25])
@pytest.mark.parametrize("edges", EDGES)
def test_frequencies(edges, h):
    found = quiet(sk.modes, quarter(edges, h, 6, ()), 2)
    thick, thin = (thick_ritz.lowest(edges, t, n=8, poisson=NU) for t in (h, 0.0))
    assert found.omega[0] == pytest.approx(thin, rel=1e-3)
    assert 0.9 < found.theory_errors[0] / (thick / thin - 1) < 1.15


@pytest.mark.parametrize("edges", ["hard", "soft"])
def test_buckling_loads(edges):
    h, outer, z = 1 / 8, ["left", "bottom"], (0.0, 0.0, 1.0)
    surface, law = sk.Rectangle(0.5, 0.5), sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1.0)
    supports = [sk.Roller(outer, z, kind=edges), sk.Symmetry("right"), sk.Symmetry("top")]
    problem = sk.Problem(surface, h, law, supports, [sk.EdgeLoad("left", (1.0, 0, 0))])
    with pytest.warns(sk.OutOfDepth, match="buckling load number 0 by about"):
        found = sk.buckling(problem.on(sk.meshes.uniform(surface, 6, 6), "kirchhoff"), 1)
    thick, thin = (thick_ritz.lowest(edges, t, "buckling", 8, NU) for t in (h, 0.0))
    assert found.load_factors[0] == pytest.approx(thin, rel=1e-3)
    assert found.theory_errors[0] == pytest.approx(thick / thin - 1, rel=0.05)


class Twist:
    """Turn per length of a strip between two cross-sections."""

    unit = "rad/m"

    def __init__(self, begin, end, width):
        self.parts = [(sk.Displacement(at=(x, y)), sx * sy / width / (end - begin))
                      for x, sx in ((begin, -1), (end, 1)) for y, sy in ((0.0, -1), (width, 1))]  # fmt: skip

    def value(self, state):
        return sum(factor * part.value(state) for part, factor in self.parts)

    def gradient(self, state):
        return sum(factor * part.gradient(state) for part, factor in self.parts)


@pytest.mark.parametrize(("width", "least"), [(12.0, 0.9), (8.0, 0.9), (4.0, 0.75)])
def test_torsion_of_a_strip(width, least):
    """Of thickness 1: Saint-Venant's series for a rectangle. F is x where the truth is x / (1 - x)."""
    length = 3 * width
    surface, law = sk.Rectangle(length, width), sk.Isotropic(2.6, 0.3, 1.0)
    problem = sk.Problem(surface, 1.0, law, [sk.Clamp("left")], [sk.EdgeMoment("right", (1e-6, 0, 0))])
    solution = quiet(sk.solve_linear, problem.on(sk.meshes.uniform(surface, 18, 6), "kirchhoff"))
    change = sk.theory_error(solution, Twist(length / 3, 2 * length / 3, width))
    n = np.arange(1, 100, 2)
    left = 1 - 192 / pi**5 / width * (np.tanh(n * pi * width / 2) / n**5).sum()
    assert least < change.share / (1 / left - 1) < 1.15
    assert change.share == pytest.approx(1 - left, rel=0.02)


def test_moments_that_twist_an_edge_are_no_layer():
    """A plate of constant twist: with moments along its edges it has no layer, with forces at its corners c M^2 on all."""
    h, m, surface = 0.1, 1e-6, sk.Rectangle(1.0, 0.8)
    held = [sk.Pin([(0.0, 0.0)]), sk.Roller([(1.0, 0.0), (0.0, 0.8)]), sk.Roller([(1.0, 0.0)], (0.0, 1.0, 0.0))]
    moments = [sk.EdgeMoment(side, axis) for side, axis in
               (("right", (-m, 0, 0)), ("left", (m, 0, 0)), ("top", (0, m, 0)), ("bottom", (0, -m, 0)))]  # fmt: skip
    law, solutions = sk.Isotropic(1e6, 0.3, 1.0), []
    for loads in (moments, [sk.PointForce(at=(1.0, 0.8), force=(0, 0, -2 * m))]):
        problem = sk.Problem(surface, h, law, held, loads)
        solutions.append(quiet(sk.solve_linear, problem.on(sk.meshes.uniform(surface, 5, 4), "kirchhoff")))
    for solution in solutions:
        assert np.abs(solution.section_forces()[:, 5]) == pytest.approx(m, rel=1e-6)
    form, fields = solutions[1].shear_fields()
    G, k = 1e6 / 2.6, 5 / 6
    assert form.product(fields, fields) == pytest.approx(3.6 * m**2 * np.sqrt(12 / k) / (G * h**2), rel=0.08)
    assert solutions[0].shear_share < 1e-6 * solutions[1].shear_share


def test_prescribed_motions_are_relaxed_by_shear():
    """A cantilever moved at its tip: U = 3 E I d^2 / (2 L^3) / (1 + 3 E I / (k G A L^2)); nu = 0."""
    h, surface = 0.05, sk.Rectangle(1.0, 0.5)
    supports = [sk.Clamp("left"), sk.Prescribed("right", (None, None, 1e-4))]
    problem = sk.Problem(surface, h, sk.Isotropic(1e6, 0.0, 1.0), supports)
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 8, 2), "kirchhoff"))
    assert sk.theory_error(solution).share == pytest.approx(-(h**2) / 4 / (5 / 6 / 2), rel=0.01)
    # The force at the tip falls by as much.
    assert sk.theory_error(solution, sk.Reaction("right")).share == pytest.approx(-0.6 * h**2, rel=0.01)


def test_it_does_not_depend_on_the_frame_or_the_numbering():
    def turned(x, y):
        c, s = np.cos(0.7), np.sin(0.7)
        return np.array([c * y - s * x, s * y + c * x, 0 * x])  # x and y exchanged: the normal points down

    shares = []
    for surface in (sk.Rectangle(1.0, 0.6), sk.MappedSurface(turned, ((0.0, 0.6), (0.0, 1.0)))):
        law, load = sk.Orthotropic((3e6, 1e6, 1e6), (0.2, 0.2, 0.2), (4e5,) * 3, 1.0), [sk.SurfaceLoad((0, 0, 1e-3))]
        ends, n = ("left", "top"), (6, 4)
        if surface.bounds[0][1] == 0.6:
            ends, n = ("bottom", "right"), (4, 6)
            law = sk.Orthotropic((3e6, 1e6, 1e6), (0.2, 0.2, 0.2), (4e5,) * 3, 1.0, angle=pi / 2)
        problem = sk.Problem(surface, 0.03, law, [sk.SimpleSupport(end) for end in ends], load)
        shares.append(quiet(sk.solve_linear, problem.on(sk.meshes.uniform(surface, *n), "kirchhoff")).shear_share)
    assert shares[0] > 0.01 and shares[1] == pytest.approx(shares[0], rel=1e-4)


def test_curved_free_edges():
    """A sector with a clamped outer and a free inner edge, under cos 2 phi, against theory `full` on two meshes."""
    surface = sk.AnnulusSector(0.4, 1.0, pi / 2)
    load = sk.SurfaceLoad(lambda r, phi: (0.0, 0.0, 1e-3 * np.cos(2 * phi)))
    problem = sk.Problem(surface, 0.04, sk.Isotropic(1e6, 0.3, 1.0),
                         [sk.Clamp("outer"), sk.Symmetry("start"), sk.Symmetry("end")], [load])  # fmt: skip
    thin, coarse, fine = (sk.solve_linear(problem.on(sk.meshes.uniform(surface, n, n), theory))
                          for n, theory in ((8, "kirchhoff"), (16, "full"), (32, "full")))  # fmt: skip
    # Of order two; the layer of a third of the thickness is one element of the finer mesh.
    energy = fine.strain_energy + (fine.strain_energy - coarse.strain_energy) / 3
    assert thin.shear_share == pytest.approx(energy / thin.strain_energy - 1, rel=0.15)
    assert len(rim_of(thin.system).tilting) == 8


def tilting(surface, supports, n=(4, 4)):
    problem = sk.Problem(surface, 0.01, sk.Isotropic(1e6, 0.3, 1.0), supports)
    return len(rim_of(problem.on(sk.meshes.uniform(surface, *n), "kirchhoff")).tilting)


def test_which_edges_let_directors_tilt():
    square, tube = sk.Rectangle(1.0, 1.0), sk.CylinderSector(1.0, 2.0, 2 * pi, closed=True)
    assert tilting(square, [sk.Clamp("left")]) == 12
    assert tilting(square, [sk.SimpleSupport("boundary")]) == 16
    assert tilting(square, [sk.SimpleSupport(["left", "right"], kind="hard"), sk.Pin("top")]) == 8
    assert tilting(square, [sk.Symmetry("left"), sk.Roller("right", kind="hard"), sk.Spring("top", (0, 0, 1.0))]) == 8
    assert tilting(square, [sk.Roller("left"), sk.NoRotation("left"), sk.Pin("corners")]) == 12
    half = lambda x, y: (abs(x) < 1e-9) & (y < 0.51)  # noqa: E731
    assert tilting(square, [sk.SimpleSupport(half, kind="hard"), sk.Clamp("right")]) == 10
    assert tilting(tube, [sk.Clamp("left")], (2, 6)) == 6  # a seam is no edge


def test_hanging_nodes_and_an_opening():
    """The same plate with a hole, on a mesh and on one with elements of half the size at the hole."""
    surface = sk.Rectangle(1.0, 1.0)
    mesh = sk.meshes.uniform(surface, 8, 8)
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.flatnonzero((np.abs(x - 0.5) < 0.12) & (np.abs(y - 0.5) < 0.12)))
    tree = sk.meshes.quadtree(mesh, surface)
    near = np.flatnonzero(np.hypot(*(tree.p[:, tree.t].mean(axis=1) - 0.5)) < 0.3)
    problem = sk.Problem(surface, 0.05, sk.Isotropic(1e6, 0.3, 1.0), [sk.SimpleSupport("boundary")],
                         [sk.SurfaceLoad((0, 0, 1e-3))])  # fmt: skip
    one, two = (quiet(sk.solve_linear, problem.on(m, "kirchhoff")) for m in (tree, tree.refined(near)))
    assert len(two.system.mesh.hanging) and len(rim_of(one.system).tilting) == 32 + 8
    # Elements of 2.5 thicknesses at the corners of the opening are coarse for what grows there.
    assert two.shear_share == pytest.approx(one.shear_share, rel=0.12)


def l_plate(h, edges=sk.Clamp):
    line = np.linspace(-1, 1, 5)
    mesh = skfem.MeshQuad.init_tensor(line, line)
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.flatnonzero((x > 0) & (y < 0)))
    law = sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1.0)
    return sk.Problem(sk.Plane(), h, law, [edges("boundary")], [sk.SurfaceLoad((0, 0, 1.0))]), mesh


def test_no_false_alarm_at_a_corner_and_none_missed():
    """The share has a limit as the elements at a re-entrant corner get smaller, where that of all fields runs away."""
    problem, mesh = l_plate(0.05)
    tree, found = sk.meshes.quadtree(mesh), []
    for _ in range(5):
        solution = quiet(sk.solve_linear, problem.on(tree, "kirchhoff"))
        form, _ = solution.shear_fields()
        found.append(solution.shear_share)
        tree = tree.refined(np.flatnonzero(np.hypot(*tree.p[:, tree.t].mean(axis=1)) < 0.36 * 0.6 ** len(found) + 0.02))
    assert form._strong.shape[1] == 1
    assert found[-1] == pytest.approx(found[-2], rel=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        thin = sk.adapt(*l_plate(0.01)[:1], sk.StrainEnergy(), 1e-3, mesh=mesh, linear=True)
    assert 0 < thin.theory_error.share < 0.01
    with pytest.warns(sk.OutOfDepth, match="transverse shear"):
        sk.adapt(l_plate(0.2)[0], sk.StrainEnergy(), 1e-2, mesh=mesh, linear=True)


def test_adaptive_answers_have_a_second_figure():
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.04, sk.Isotropic(1e6, 0.3, 1e3), [sk.SimpleSupport("boundary")],
                         [sk.SurfaceLoad((0, 0, 1e-3))])  # fmt: skip
    mesh = sk.meshes.uniform(surface, 4, 4)
    result = sk.adapt(problem, sk.Displacement(at=(0.5, 0.5)), 1e-2, mesh=mesh, linear=True)
    assert f"(mesh), and the theory leaves out about {result.theory_error.value:+.2g} m" in str(result)
    assert 0.03 < result.theory_error.share < 0.05 and result.theory_error.sound
    frequency = quiet(sk.adapt, problem, sk.Eigenfrequency(), 1e-2, mesh=mesh)
    assert -0.05 < frequency.theory_error.share < -0.015 and "leaves out about -" in str(frequency)
    moment = sk.adapt(problem, sk.SectionForce("M11", at=(0.5, 0.5)), 1e-1, mesh=mesh, linear=True)
    assert np.isnan(moment.theory_error.value) and "within=" in moment.theory_error.note and "cannot be told" in str(moment)
    full = sk.adapt(problem, sk.Displacement(at=(0.5, 0.5)), 1e-1, mesh=mesh, linear=True, theory="full")
    assert full.theory_error.value == 0 and "theory" not in str(full)


def test_frequencies_of_thick_plates_come_with_a_warning():
    with pytest.warns(sk.OutOfDepth, match="frequency number 1 by about"):
        found = sk.modes(quarter("clamped", 0.1, 4, ()), 2)
    assert (found.theory_errors < -0.05).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert (sk.modes(quarter("clamped", 0.1, 2, (), "full"), 2).theory_errors == 0).all()
        assert (np.abs(sk.modes(quarter("hard", 0.01, 4, ()), 2).theory_errors) < 0.01).all()


def test_prestress_takes_no_part_in_shear():
    """A strip stretched so much that the stress is most of its stiffness: shear changes the rest only."""
    h, surface = 0.05, sk.Rectangle(1.0, 0.2)
    supports = [sk.SimpleSupport("left", kind="hard"), sk.Prescribed("right", (0.02, 0.0, 0.0))]
    problem = sk.Problem(surface, h, sk.Isotropic(1e6, 0.0, 1.0), supports)
    system = problem.on(sk.meshes.uniform(surface, 10, 2), "kirchhoff")
    free, tight = (quiet(sk.modes, system, 1, state=state) for state in (None, sk.solve_linear(system)))
    # Bending alone: omega^2 = D k^4 / rho h; tension N = E h e adds N k^2 / rho h, with k = pi.
    added = 0.02 * 12 / (h * pi) ** 2
    assert tight.eigenvalues[0] / free.eigenvalues[0] == pytest.approx(1 + added, rel=0.01)
    rotary = (h * pi) ** 2 / 12
    product = rotary / (5 / 6 / 2)
    expected = np.sqrt((1 - product / (1 + product) / (1 + added)) / (1 + rotary)) - 1
    assert tight.theory_errors[0] == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(("edges", "h", "theory"), [("clamped", 0.1, "full"), ("clamped", 0.01, "kirchhoff"),
                                                    ("soft", 0.02, "full"), ("hard", 0.02, "kirchhoff")])  # fmt: skip
def test_auto_judges_a_problem_without_loads_by_its_first_frequency(edges, h, theory):
    system = quarter(edges, h, 4, (), "auto")
    assert system.choice.theory == system.geometry.theory.name == theory and "first frequency" in system.choice.reason
    thick, thin = (thick_ritz.lowest(edges, t, n=8, poisson=NU) for t in (h, 0.0))
    assert system.choice.share == pytest.approx((thin / thick) ** 2 - 1, rel=0.15)


def test_auto_judges_a_free_plate():
    surface = sk.Rectangle(1.0, 0.7)
    mesh, law = sk.meshes.uniform(surface, 6, 4), sk.Isotropic(1e6, 0.3, 1.0)
    plates = [sk.Problem(surface, h, law) for h in (0.005, 0.1)]
    choices = [plate.on(mesh, "auto").choice for plate in plates]
    assert [choice.theory for choice in choices] == ["kirchhoff", "full"]
    found = quiet(sk.modes, plates[1].on(mesh, "kirchhoff"), 7)
    assert choices[1].share == pytest.approx((1 + found.theory_errors[6]) ** -2 - 1, rel=0.02)
    assert np.isnan(found.theory_errors[:6]).all()


def test_large_deflections_use_the_tangent_of_the_state():
    """Clamped, q a^4 / E h^4 = 25, against theory `full` on two meshes: the linear weight would say twice as much."""
    h, E = 1 / 16, 1.0
    surface, outer = sk.Rectangle(0.5, 0.5), ["left", "bottom"]
    problem = sk.Problem(surface, h, sk.Isotropic(E, 0.3, 1.0), [sk.Clamp(outer), sk.Symmetry("right"), sk.Symmetry("top")],
                         [sk.SurfaceLoad((0, 0, 25 * E * h**4))])  # fmt: skip
    quantity = sk.Displacement(at=(0.5, 0.5))
    thin, coarse, fine = (quiet(sk.solve, problem.on(sk.meshes.uniform(surface, n, n), theory)).solution
                          for n, theory in ((5, "kirchhoff"), (6, "full"), (12, "full")))  # fmt: skip
    values = [quantity.value(state) for state in (coarse, fine)]
    true = values[1] + (values[1] - values[0]) / 3 - quantity.value(thin)
    assert 0.9 < sk.theory_error(thin, quantity).value / true < 1.15


def test_what_has_no_answer_is_refused_and_what_is_large_says_so():
    solution = quiet(sk.solve_linear, quarter("clamped", 0.2, 4))
    with pytest.raises(InputError, match=r"within=\(\(x0, x1\)"):
        sk.theory_error(solution, sk.SectionForce("M11", at=(0.5, 0.5)))
    with pytest.raises(InputError, match="unit, value and gradient"):
        sk.theory_error(solution, sk.Eigenfrequency())
    moving = sk.Solution(solution.system, solution.q, velocity=0 * solution.q, time=0.0)
    with pytest.raises(InputError, match="state of a motion"):
        sk.theory_error(moving)
    large = sk.theory_error(solution)
    assert not large.sound and "order of magnitude" in large.note and large.share > 0.2
    small = sk.theory_error(quiet(sk.solve_linear, quarter("hard", 0.02, 4)))
    assert small.sound and not small.note
    one = sk.theory_error(solution, sk.SectionForce("M11", within=((0.375, 0.5), (0.375, 0.5))))
    assert "one element across" in one.note
    none = sk.theory_error(sk.solve_linear(quarter("clamped", 0.2, 2, theory="full")), sk.Displacement(at=(0.5, 0.5)))
    assert none.value == none.share == 0 and none.sound


@pytest.mark.parametrize("edges", ["soft", "clamped", "one clamped"])
def test_bending_that_twists(edges):
    """A layer at an angle: in an edge layer less than D66 resists, and right-angled corners are singular."""
    law = sk.Orthotropic((25e6, 1e6, 1e6), (0.25, 0.25, 0.25), (0.5e6, 0.5e6, 0.2e6), 1.0, angle=0.15)
    support = {"soft": sk.SimpleSupport("boundary"), "clamped": sk.Clamp("boundary"), "one clamped": sk.Clamp("left")}[edges]
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.03, law, [support], [sk.SurfaceLoad((0, 0, 1.0))])
    solution = quiet(sk.solve_linear, problem.on(sk.meshes.uniform(surface, 12, 12), "kirchhoff"))
    D, S = (tuple(map(tuple, m)) for m in (problem.section.abd()[3:, 3:], problem.section.shear_stiffness()))
    true = coupled_ritz.energy(edges, D, S) / coupled_ritz.energy(edges, D, None, 10) - 1
    assert solution.shear_share == pytest.approx(true, rel=0.1)
    assert D[2][2] - D[0][2] ** 2 / D[0][0] < 0.6 * D[2][2]


def test_the_energy_of_edge_moments_has_its_own_weight():
    """The dual weight of the energy is the answer itself: moments that twist an edge count in both."""
    surface = sk.Rectangle(1.0, 0.7)
    law = sk.Isotropic(70e9, 0.3, 2700.0)
    problem = sk.Problem(surface, 0.05, law, [sk.Clamp("left")], [sk.EdgeMoment("right", (2e3, 0.0, 0.0))])
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 8, 6), "kirchhoff"))
    assert solution.shear_share > 0.02
    assert sk.theory_error(solution).share == pytest.approx(solution.shear_share, rel=1e-9)
