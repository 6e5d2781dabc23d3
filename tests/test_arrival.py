"""Statics arrives, on a stable state, and says what it met: films, snaps, struts, slack sheets, each as a user states it."""

from math import pi

import numpy as np
import pytest
from reference import von_karman
from scipy.optimize import brentq
from scipy.special import ellipk

import skancf as sk
from skancf.solving import Status
from skancf.system.dilation import pretension

THEORIES = ("kirchhoff", "full")
BALANCE = 1e-6
"""What a number that is called converged may be out of balance, of the loads: the promise of `solve`."""


def out_of_balance(system, solution):
    """Sum of loads and reactions over that of the magnitudes of nodal loads, by the solution's own reactions."""
    loads = solution.load_factor * system.external_force(solution.q).reshape(-1, 4, 3)[:, 0]
    return np.abs(loads.sum(axis=0) + solution.reactions()).max() / np.linalg.norm(loads, axis=1).sum()


# --- films ---------------------------------------------------------------------------------------------------------

FILM, FOIL, SHEET = (0.7, 0.4), 2e-4, sk.Isotropic(1.5e9, 0.38, 1300.0)


def film(Q, theory, load=lambda q: sk.SurfaceLoad((0.0, 0.0, q))):
    """Held all round, under Q = q b^4 / (E h^4)."""
    q = Q * SHEET.young * FOIL**4 / FILM[1] ** 4
    problem = sk.Problem(sk.Rectangle(*FILM), FOIL, SHEET, [sk.Pin("boundary")], [load(q)])
    return problem.on(sk.meshes.uniform(problem.surface, 6, 4), theory)


def middle(solution):
    return solution.displacement((FILM[0] / 2, FILM[1] / 2))[2]


@pytest.mark.parametrize("theory", THEORIES)
def test_films_over_six_decades_of_load_are_in_balance(theory):
    deflections = []
    for Q in (1e4, 1e6, 1e8, 1e10):
        system = film(Q, theory)
        result = sk.solve(system)
        assert result.status is Status.CONVERGED and result.negative_pivots == 0, result.message
        assert out_of_balance(system, result.solution) < BALANCE
        assert result.iterations <= 35
        deflections.append(middle(result.solution) / Q ** (1 / 3))
        loose, sharp = (middle(sk.solve(system, rtol=rtol).solution) for rtol in (1e-3, 1e-12))
        assert loose == pytest.approx(sharp, rel=1e-3)
    # A membrane: w grows with the cube root of the load, as long as slopes are small.
    assert deflections[1:] == pytest.approx(deflections[1] * np.ones(3), rel=0.02)


def test_a_film_agrees_with_von_karmans_plate_by_ritz():
    """Square, at Q = 1e6, where w / h = 29 and bending carries next to nothing; Ritz's polynomials are within 2e-4 there."""
    loads = tuple(10 ** np.linspace(1, 6, 21))
    reference = von_karman.centre("simple", loads, n=8)[-1]
    a, h, E = 1.0, 1e-4, 3e9
    problem = sk.Problem(sk.Rectangle(a, a), h, sk.Isotropic(E, 0.3, 1400.0), [sk.Pin("boundary")],
                         [sk.SurfaceLoad((0.0, 0.0, 1e6 * E * h**4 / a**4))])  # fmt: skip
    result = sk.solve(problem.on(sk.meshes.uniform(problem.surface, 16, 16), "kirchhoff"))
    assert result.unwrap().displacement((0.5, 0.5))[2] / h == pytest.approx(reference, rel=1e-3)


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_film_moves_with_the_pressure_that_follows_it(theory, sign):
    result = sk.solve(film(sign * 1e8, theory, sk.FollowerPressure))
    assert result.status is Status.CONVERGED and result.negative_pivots == 0
    assert sign * middle(result.solution) > 0.01


def test_the_old_scale_would_have_called_a_false_state_converged(monkeypatch):
    """The largest energy of a diverging iteration is no scale: with it alone the same film ends far from balance."""
    from skancf.statics import stopping

    monkeypatch.setattr(stopping.ConvergenceTest, "_scale", lambda self, q, load_factor: np.inf)
    monkeypatch.setattr(stopping.ConvergenceTest, "_is_small", lambda self, change, way: True)
    from skancf.linear import DirectSolver
    from skancf.statics import newton

    system = film(1e8, "kirchhoff")
    with DirectSolver(system.pattern, system.constraints) as solver:
        found = newton(system, system.undeformed, solver)
    assert found.ok and out_of_balance(system, sk.Solution(system, found.q)) > 1.0
    # And `solve` would not have believed it.
    monkeypatch.setattr("skancf.statics.cascade.FARTHEST", np.inf)
    result = sk.solve(system, relax=False)
    assert result.status is not Status.CONVERGED or out_of_balance(system, result.solution) < BALANCE


def test_a_path_of_a_film_is_in_balance_too():
    system = film(1e7, "kirchhoff")
    path = sk.trace(system, until=1.0).unwrap()
    assert path.checks and all(check.passed for check in path.checks)
    assert middle(path.solution) == pytest.approx(middle(sk.solve(system).solution), rel=1e-6)


def test_adapt_takes_a_film():
    Q = 1e8
    problem = film(Q, "kirchhoff").problem
    result = sk.adapt(problem, sk.Displacement(at=(0.35, 0.2), direction=(0, 0, 1)), rtol=1e-2)
    assert result.ok and all(check.passed for check in result.checks) and result.checks
    assert "relaxed" in result.message
    assert result.value == pytest.approx(middle(sk.solve(film(Q, "kirchhoff")).solution), rel=0.03)


# --- what rounding leaves open -------------------------------------------------------------------------------------


def test_loads_that_coordinates_cannot_hold_have_a_status_of_their_own():
    result = sk.solve(film(1e-9, "kirchhoff"))
    assert result.status is Status.ROUNDING and result.bound > 1e-2 and "rounding" in result.message
    with pytest.raises(sk.DidNotConverge, match="solve_linear"):
        result.unwrap()


def strip(thinness, theory="kirchhoff"):
    """A cantilever of unit length whose end force turns it by about a radian."""
    E, b = 210e9, 0.1
    force = 4 * E * thinness**3 / 12
    problem = sk.Problem(sk.Rectangle(1.0, b), thinness, sk.Isotropic(E, 0.0, 7800.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (0.0, 0.0, force))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 16, 1), theory)


@pytest.mark.parametrize("theory", THEORIES)
def test_a_very_thin_strip_is_converged_or_says_by_how_much_it_is_open(theory):
    reference = sk.solve(strip(1e-3, theory)).unwrap().displacement((1.0, 0.05))[2]
    for thinness in (1e-4, 1e-6):
        system = strip(thinness, theory)
        result = sk.solve(system)
        open_by = out_of_balance(system, result.solution)
        assert result.status is (Status.CONVERGED if open_by < BALANCE else Status.ROUNDING)
        assert open_by < max(result.bound, BALANCE)
        w = result.solution.displacement((1.0, 0.05))[2]
        assert w == pytest.approx(reference, rel=max(1e-3, result.bound))
    assert result.status is Status.ROUNDING, "the thinnest is limited by rounding, so that its status was tested"


# --- snaps ---------------------------------------------------------------------------------------------------------


def shallow_roof(fraction, n=8):
    """A quarter of a hinged cylindrical roof of other size than the published ones, under a force at the crown."""
    surface = sk.CylinderSector(radius=1.8, length=0.2, angle=0.13, start=pi / 2 - 0.13)
    problem = sk.Problem(
        surface, 0.01, sk.Isotropic(3e9, 0.3, 1200.0), [sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
        [sk.PointForce((0.2, pi / 2), (0.0, 0.0, -2000.0 * fraction))],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, n), "kirchhoff"), lambda s: -s.displacement((0.2, pi / 2))[2]


def shallow_cap(fraction, n=6):
    """A quarter of a spherical cap, pinned at its rim, under a pressure that keeps its direction."""
    surface = sk.SphereSector(2.0, (0.04, 0.16), pi / 2)
    problem = sk.Problem(
        surface, 0.015, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Pin("bottom"), sk.Symmetry("start"), sk.Symmetry("end")],
        [sk.SurfaceLoad((0.0, 0.0, -6e6 * fraction))],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, n), "kirchhoff"), lambda s: -s.displacement((0.04, pi / 4))[2]


def limit_load(make):
    """Load factor of the first limit point of a path."""
    found = sk.trace(make(1.0)[0], sk.ArcLength(first=0.1), steps=25)
    return next(event.load_factor for event in found.events if event.kind == "limit point")


@pytest.mark.parametrize("make", [shallow_roof, shallow_cap])
def test_below_the_limit_load_it_does_not_snap(make):
    """Relaxation from rest at the full load finds the same state as small load steps: it does not run past a near one."""
    from skancf.linear import DirectSolver
    from skancf.statics import newton
    from skancf.statics.relax import Relaxation

    limit = limit_load(make)
    for share in (0.5, 0.9, 0.98):
        system, deflection = make(share * limit)
        small = sk.solve(system, control=sk.HalveAndGrow(first=0.1, growth=1.0), relax=False).unwrap()
        with DirectSolver(system.pattern, system.constraints) as solver:
            relaxation = Relaxation(
                system, solver, 1.0, lambda q, factor, s=system, d=solver, **how: newton(s, q, d, load_factor=factor, **how)
            )
            found = relaxation.from_state(system.undeformed, system.undeformed)
        assert found is not None and found.ok and found.negative_pivots == 0
        assert deflection(sk.Solution(system, found.q)) == pytest.approx(deflection(small), rel=1e-6)
        assert deflection(sk.solve(system).unwrap()) == pytest.approx(deflection(small), rel=1e-6)


@pytest.mark.parametrize("make", [shallow_roof, shallow_cap])
def test_above_it_the_state_is_that_beyond_the_snap_and_the_message_says_so(make):
    limit = limit_load(make)
    system, deflection = make(1.05 * limit)
    result = sk.solve(system)
    assert result.status is Status.CONVERGED and result.negative_pivots == 0
    assert "snapped" in result.message and "relaxed" in result.message
    path = sk.solve(system, follow=True)
    assert path.status is Status.CONVERGED and "limit point at" in path.message, path.message
    assert deflection(result.solution) == pytest.approx(deflection(path.solution), rel=1e-5)
    before = sk.solve(make(0.95 * limit)[0])
    assert before.message == "" and deflection(result.solution) > 1.5 * deflection(before.solution)


# --- buckled states ------------------------------------------------------------------------------------------------

STRUT = (1.2, 0.08, 0.004)
EULER = pi**2 * 70e9 * STRUT[2] ** 3 / 12 / (4 * STRUT[0] ** 2)
"""Euler's load of the cantilever per width (N/m)."""


def strut(factor, theory):
    problem = sk.Problem(sk.Rectangle(*STRUT[:2]), STRUT[2], sk.Isotropic(70e9, 0.0, 2700.0), [sk.Clamp("left")],
                         [sk.EdgeLoad("right", (-factor * EULER, 0.0, 0.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 12 if theory == "kirchhoff" else 48, 1), theory)


def elastica_tip(factor):
    """Deflection of the end over the length: P / P_cr = (2 K(k) / pi)^2, w / L = 2 k / K(k)."""
    k = brentq(lambda k: (2 * ellipk(k**2) / pi) ** 2 - factor, 1e-6, 1 - 1e-12)
    return 2 * k / ellipk(k**2)


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("factor", [1.01, 1.02, 1.5, 4.0])
def test_a_strut_without_imperfection_buckles(theory, factor):
    result = sk.solve(strut(factor, theory))
    assert result.status is Status.CONVERGED and result.negative_pivots == 0 and "buckled" in result.message
    w = abs(result.solution.displacement((STRUT[0], STRUT[1] / 2))[2]) / STRUT[0]
    # At 1.02 of the load the deflection feels an error of the mesh's own Euler load 25 times.
    assert w == pytest.approx(elastica_tip(factor), rel=2e-2 if factor < 1.1 else 2e-3)
    straight = sk.solve(strut(factor, theory), relax=False)
    assert straight.negative_pivots > 0 and "not stable" in straight.message


def test_a_ring_under_pressure_buckles():
    """Beyond 3 E I / R^3 a ring has an oval shape; a quarter of it, with a plane of symmetry at each end."""
    R, h, E = 0.5, 0.005, 70e9
    surface = sk.CylinderSector(R, 0.05, pi / 2)

    def ring(factor):
        pressure = factor * 3 * E * h**3 / 12 / R**3
        problem = sk.Problem(
            surface, h, sk.Isotropic(E, 0.0, 2700.0), [sk.Symmetry("start"), sk.Symmetry("end"), sk.Symmetry("left")],
            [sk.FollowerPressure(-pressure)],
        )  # fmt: skip
        return sk.solve(problem.on(sk.meshes.uniform(surface, 1, 8), "kirchhoff"))

    round_still, oval = ring(0.97), ring(1.08)
    assert round_still.message == "" and oval.negative_pivots == 0 and "buckled" in oval.message
    ends = [np.linalg.norm(oval.solution.position((0.05, angle))[[1, 2]]) / R for angle in (0.0, pi / 2)]
    assert min(ends) < 0.9 < 1.05 < max(ends)


def test_nothing_downhill_is_said():
    """A strip rolled up by a moment about a fixed axis is not stable, and no stable state is found: it says so."""
    moment = 2 * pi * 1.2e6 * 0.1**3 / 12 / 12.0
    problem = sk.Problem(sk.Rectangle(12.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), [sk.Clamp("left")],
                         [sk.EdgeMoment("right", (0, -moment, 0))])  # fmt: skip
    result = sk.solve(problem.on(sk.meshes.uniform(problem.surface, 16, 1), "kirchhoff"))
    assert result.status is Status.CONVERGED and result.negative_pivots == 1 and "not stable" in result.message
    # A closed circle, to the 5e-4 of its length that 16 elements leave.
    assert np.linalg.norm(result.solution.position((12.0, 0.5)) - [0.0, 0.5, 0.0]) < 0.02


# --- slack ---------------------------------------------------------------------------------------------------------


def test_a_pillow_is_inflated():
    """A quarter of two slack sheets, 1 m by 0.6 m, joined along their edges: they wrinkle, and rise with the pressure."""
    surface, heights = sk.Rectangle(0.5, 0.3), []
    for pressure in (50.0, 500.0, 5000.0):
        problem = sk.Problem(
            surface, 5e-4, sk.Isotropic(6e8, 0.4, 1000.0),
            [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Roller(["right", "top"])], [sk.FollowerPressure(pressure)],
        )  # fmt: skip
        result = sk.solve(problem.on(sk.meshes.uniform(surface, 8, 6), "kirchhoff"))
        assert result.status is Status.CONVERGED and result.negative_pivots == 0, result.message
        heights.append(result.solution.displacement((0.0, 0.0))[2])
    assert heights == sorted(heights) and heights[0] > 0.05


# --- saddles: states that attract a flow in steps too long, and are not stable ----------------------------------------


def round_bag():
    """A quarter of two discs joined along their edge, under pressure: radial wrinkles all round."""
    surface = sk.AnnulusSector(0.0, 0.2, pi / 2)
    return surface, (6, 8), sk.Problem(
        surface, 1e-4, sk.Isotropic(1e9, 0.3, 1000.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Roller("outer")], [sk.FollowerPressure(3000.0)],
    )  # fmt: skip


def squeezed_annulus():
    """Clamped at its inner edge, under some fifty times the radial load at which it buckles."""
    surface, h, young = sk.AnnulusSector(0.3, 1.0, 2 * pi, closed=True), 0.01, 70e9
    load = -44 * young * h**3 / 12 / 0.91
    return surface, (3, 16), sk.Problem(
        surface, h, sk.Isotropic(young, 0.3, 2700.0), [sk.Clamp("inner")],
        [sk.EdgeLoad("outer", lambda r, angle: (load * np.cos(angle), load * np.sin(angle), 0 * r))],
    )  # fmt: skip


def collapsed_reed():
    """A strip that stands on its clamped foot under a thousand times the weight that it can bear (Greenhill 1881)."""
    surface, t, young, density = sk.Rectangle(0.1, 1.0), 1e-3, 3e9, 1200.0
    weight = 1e3 * 7.837 * young * t**2 / 12 / density
    return surface, (1, 16), sk.Problem(
        surface, t, sk.Isotropic(young, 0.0, density), [sk.Clamp("bottom")], [sk.Gravity((0.0, -weight, 0.0))]
    )  # fmt: skip


@pytest.mark.parametrize("make", [round_bag, squeezed_annulus, collapsed_reed])
def test_a_flow_does_not_end_in_a_saddle(make):
    surface, counts, problem = make()
    result = sk.solve(problem.on(sk.meshes.uniform(surface, *counts), "kirchhoff"))
    assert result.status is Status.CONVERGED and result.negative_pivots == 0, result.message
    assert "relaxed at the full load" in result.message


def test_a_step_that_goes_uphill_is_not_taken(monkeypatch):
    """Without that rule the same strip ends where it stands, with its message."""
    from skancf.statics.relax import Relaxation

    monkeypatch.setattr(Relaxation, "rise", lambda self, q, to: -1.0)
    surface, counts, problem = collapsed_reed()
    result = sk.solve(problem.on(sk.meshes.uniform(surface, *counts), "kirchhoff"))
    assert result.negative_pivots > 0 and "found no stable state" in result.message


def test_light_reeds_stand_and_heavier_ones_lean():
    """Greenhill's load of a strip under its own weight, 7.837 E I / L^3, from both sides."""
    surface, counts, problem = collapsed_reed()
    greenhill = problem.loads[0].acceleration[1] / 1e3
    heights = []
    for factor in (0.98, 1.02, 2.0):
        loads = [sk.Gravity((0.0, factor * greenhill, 0.0))]
        light = sk.Problem(surface, problem.thickness, problem.material, problem.supports, loads)
        result = sk.solve(light.on(sk.meshes.uniform(surface, *counts), "kirchhoff"))
        assert result.status is Status.CONVERGED and result.negative_pivots == 0
        assert ("buckled" in result.message) == (factor > 1)
        heights.append(result.solution.position((0.05, 1.0))[1])
    assert heights[0] == pytest.approx(1.0, abs=1e-3) and heights[2] < heights[1] < 0.95


# --- dents and twisted laminates -------------------------------------------------------------------------------------


def pinched_tube(n, theory):
    """An eighth of a tube with free ends, pinched in the middle until its walls are bent through."""
    surface = sk.CylinderSector(0.1, 0.12, pi / 2, start=pi / 2)
    problem = sk.Problem(
        surface, 1e-3, sk.Isotropic(3e9, 0.35, 1200.0),
        [sk.Symmetry("start"), sk.Symmetry("end"), sk.Symmetry("right")],
        [sk.PointForce((0.12, pi / 2), (0.0, 0.0, -40.0))],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(surface, n, n), theory), lambda s: -s.displacement((0.12, pi / 2))[2]


def cured_strip(n, theory):
    """An antisymmetric angle-ply strip that cooling twists, under a force at its end."""
    ply = sk.Orthotropic((140e9, 10e9, 10e9), (0.3, 0.3, 0.3), (5e9, 5e9, 3e9), 1600.0, expansion=(0.0, 3e-5, 3e-5))
    laminate = sk.Laminate([sk.Layer(ply, 2.5e-4, angle) for angle in (pi / 6, -pi / 6)])
    problem = sk.Problem(sk.Rectangle(0.4, 0.05), None, laminate, [sk.Clamp("left")],
                         [sk.Temperature(-120.0), sk.EdgeLoad("right", (0.0, 0.0, 4.0))])  # fmt: skip
    return problem.on(sk.meshes.uniform(problem.surface, 4 * n, n // 2), theory), lambda s: s.displacement((0.4, 0.05))[2]


@pytest.mark.parametrize("make", [pinched_tube, cured_strip])
@pytest.mark.parametrize("theory", THEORIES)
def test_tubes_and_laminates_arrive_on_every_mesh(make, theory):
    found = []
    for n in (4, 6, 8, 12):
        system, probe = make(n, theory)
        result = sk.solve(system)
        assert result.status is Status.CONVERGED and result.negative_pivots == 0, (n, result.message)
        found.append(probe(result.solution))
    assert found[-1] == pytest.approx(found[-2], rel=0.03 if theory == "kirchhoff" else 0.08), found


# --- what must not matter, and cost ----------------------------------------------------------------------------------


def test_units_density_and_frame_do_not_matter():
    """The same snap in metres and millimetres, a million times as heavy, and turned in space."""

    def roof(unit=1.0, density=1200.0, turned=False):
        force = np.array([0.0, 0.0, -900.0])
        half = 0.13
        surface = sk.CylinderSector(1.8 * unit, 0.2 * unit, half, start=pi / 2 - half)
        if turned:
            surface = sk.CylinderSector(1.8 * unit, 0.2 * unit, half, start=pi / 2 - half + 0.4)
            c, s = np.cos(0.4), np.sin(0.4)
            turn = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
            force = turn @ force
        problem = sk.Problem(
            surface, 0.01 * unit, sk.Isotropic(3e9 / unit**2, 0.3, density),
            [sk.Pin("start"), sk.Symmetry("end"), sk.Symmetry("right")],
            [sk.PointForce((0.2 * unit, pi / 2 + 0.4 * turned), force)],
        )  # fmt: skip
        result = sk.solve(problem.on(sk.meshes.uniform(surface, 6, 6), "kirchhoff"))
        u = result.solution.displacement((0.2 * unit, pi / 2 + 0.4 * turned)) / unit
        return result.iterations, np.linalg.norm(u), result

    count, size, result = roof()
    assert "snapped" in result.message, "nothing was relaxed, so this was not tested"
    for other in (roof(unit=1000.0), roof(density=1.2e9), roof(turned=True)):
        assert abs(other[0] - count) <= 2 and other[1] == pytest.approx(size, rel=1e-6)


def easy_problems():
    """Problems that Newton's method alone solves, with the iterations that it takes."""
    E = 70e9
    for Q, count in ((0.01, 3), (25.0, 6), (250.0, 8), (1e4, 12)):
        for theory in THEORIES:
            plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(E, 0.3, 2700.0), [sk.Clamp("boundary")],
                               [sk.SurfaceLoad((0, 0, Q * E * 0.01**4))])  # fmt: skip
            yield plate.on(sk.meshes.uniform(plate.surface, 8, 8), theory), count
    for force, count in ((1.0, 6), (4.0, 8)):
        for theory in THEORIES:
            bent = sk.Problem(sk.Rectangle(10.0, 1.0), 0.1, sk.Isotropic(1.2e6, 0.0, 1.0), [sk.Clamp("left")],
                              [sk.EdgeLoad("right", (0, 0, force))])  # fmt: skip
            yield bent.on(sk.meshes.uniform(bent.surface, 16, 1), theory), count


def test_easy_problems_cost_what_they_did():
    """At most one iteration more than Newton's method with its first stop rule, and no pretension is assembled."""
    for number, (system, count) in enumerate(easy_problems()):
        result = sk.solve(system)
        assert result.message == "" and len(result.attempts) == 1
        assert result.iterations <= count, (number, result.iterations, count)
        assert "pretension" not in vars(system)


@pytest.mark.parametrize("theory", THEORIES)
def test_the_pretension_is_a_dilation(theory):
    E, nu, h = 3e9, 0.35, 2e-3
    problem = sk.Problem(sk.Rectangle(2.0, 1.0), h, sk.Isotropic(E, nu, 1.0), [sk.Pin("boundary")])
    system = problem.on(sk.meshes.uniform(problem.surface, 4, 3), theory)
    x, y = system.geometry.surface.position(*system.mesh.p)[:2]
    shape = np.zeros((system.n_dofs // 12, 4, 3))
    # w = x y + x^2 in z, and its slopes: the integral of its squared gradient over 2 x 1 is known.
    shape[:, 0, 2], shape[:, 1, 2], shape[:, 2, 2] = x * y + x**2, y + 2 * x, x
    if theory == "kirchhoff":
        shape[:, 3, 2] = 1.0
    gradient = 2 / 3 + 4 + 4 * 8 / 3 + 8 / 3  # of (y + 2 x)^2 + x^2
    energy = shape.ravel() @ (pretension(system) @ shape.ravel())
    assert energy == pytest.approx(E * h / (1 - nu) * gradient, rel=1e-9)
    assert np.abs(pretension(system) @ np.tile([1.0, 2.0, 3.0] + [0.0] * 9, len(shape))).max() < 1e-6 * E * h


UNBALANCED = sk.Laminate([sk.Layer(sk.Orthotropic((30e9, 3e9, 3e9), (0.3, 0.3, 0.3), (1.5e9,) * 3, 1.0), 0.01, angle)
                          for angle in (0.2, pi / 2)])  # fmt: skip


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("material", [sk.Isotropic(1e9, 0.3, 1.0), UNBALANCED])
@pytest.mark.parametrize("surface", [sk.SphereSector(1.0, (0.3, 1.2), pi / 2), sk.Rectangle(1.0, 0.5)])
def test_the_pretension_is_positive(surface, material, theory):
    """Also of sections whose stretching bends them."""
    thickness = None if material is UNBALANCED else 0.02
    problem = sk.Problem(surface, thickness, material, [sk.Pin("boundary")])
    dense = pretension(problem.on(sk.meshes.uniform(surface, 3, 3), theory)).to_scipy().toarray()
    values = np.linalg.eigvalsh(dense)
    assert values.min() > -1e-9 * values.max() and (values > 1e-9 * values.max()).sum() > len(values) / 2


def test_a_relaxation_that_no_pull_can_hold_ends():
    """Failures without an iteration do not count against its budget, so the strength of the pull has a limit."""
    from skancf.linear import DirectSolver
    from skancf.statics.newton import NewtonResult
    from skancf.statics.relax import Relaxation

    system, _ = shallow_roof(0.3, n=2)
    pulls = []

    def fails(q, load_factor, **options):
        pulls.append(options["pull"].strength)
        return NewtonResult(q, Status.SINGULAR, ())

    with DirectSolver(system.pattern, system.constraints) as solver:
        assert Relaxation(system, solver, 1.0, fails).from_state(system.undeformed, system.undeformed) is None
    assert 3 < len(pulls) < 40 and max(pulls) < 1e5


def test_a_restart_far_from_equilibrium_does_not_say_that_it_snapped():
    system, deflection = shallow_roof(0.3)
    asked = sk.solve(system).unwrap()
    bent = sk.Solution(system, system.undeformed + 200 * asked.change)
    result = sk.solve(system, start=bent)
    assert result.status is Status.CONVERGED and result.negative_pivots == 0
    assert "the state it started from" in result.message and "snapped" not in result.message
    assert deflection(result.solution) == pytest.approx(deflection(asked), rel=1e-6)


@pytest.mark.parametrize("theory", THEORIES)
def test_a_heated_plate_that_is_held_all_round_buckles_and_has_no_path(theory):
    """Heat strains it and moves nothing before it buckles: at 5.3 pi^2 D / a^2 for a clamped square (Timoshenko)."""
    a, h, nu, expansion = 0.8, 2e-3, 0.3, 1.2e-5
    critical = 5.33 * pi**2 * h**2 / (12 * (1 + nu) * a**2 * expansion)
    material = sk.Isotropic(200e9, nu, 7800.0, expansion=expansion)
    for factor in (0.95, 1.2):
        problem = sk.Problem(sk.Rectangle(a, a), h, material, [sk.Clamp("boundary")], [sk.Temperature(factor * critical)])
        system = problem.on(sk.meshes.uniform(problem.surface, 8, 8), theory)
        result = sk.solve(system)
        assert result.status is Status.CONVERGED and result.negative_pivots == 0
        assert ("buckled" in result.message) == (factor > 1)
        path = sk.trace(system, until=1.0)
        assert path.status is Status.CONVERGED or "does not move it" in path.message
