"""The adaptive loop: rates, mechanisms, budgets, numbers without a limit, indicators, and the surfaces it works on."""

import re
from functools import cache
from math import pi

import numpy as np
import pytest
import skfem
from problems import PULLED, hemisphere
from reference import navier

import skancf as sk
from skancf.adaptive import no_limit
from skancf.adaptive.analysis import StaticAnalysis
from skancf.adaptive.singular import touching
from skancf.adaptive.start import starting_mesh
from skancf.errors import InputError
from skancf.meshes import quadtree
from skancf.solving import Status

NU, THICKNESS = 0.3, 0.01
MATERIAL = sk.Isotropic(12 * (1 - NU**2) / THICKNESS**3, NU, 1.0)
"""With D = 1."""
SQUARE = sk.Rectangle(1.0, 1.0)
L_SHAPE = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))
L_MESH = sk.meshes.uniform(L_SHAPE, 4, 4, openings=[((0.0, 1.0), (-1.0, 0.0))])
CENTRE = (0.5, 0.5)
CENTRAL = sk.Displacement(CENTRE)
UNIFORM, FORCE = sk.SurfaceLoad((0, 0, 1.0)), sk.PointForce(CENTRE, (0, 0, 1.0))
SIMPLE, CLAMPED, PINS = sk.SimpleSupport("boundary"), sk.Clamp("boundary"), sk.Pin("corners")
L_PLATE = sk.Problem(L_SHAPE, THICKNESS, MATERIAL, [CLAMPED], [UNIFORM])
L_ENERGY = 0.0017892850
"""Of runs with elements down to 2^-18 of the extent: see test_estimates."""
EVERYWHERE = {"marking": sk.AllElements(), "coarsening": sk.Never()}
FORCES = {"simple": (SIMPLE, 0.0116008405), "clamped": (CLAMPED, 0.0056120), "corners": (PINS, 0.03914185)}
"""Deflections under the force: Navier's series, and Ritz's method extrapolated in its degree, to 1e-7."""


def square(support, load) -> sk.Problem:
    return sk.Problem(SQUARE, THICKNESS, MATERIAL, [support], [load])


def on_l(quantity=sk.StrainEnergy(), rtol=1e-4, **more):  # noqa: B008
    return sk.adapt(L_PLATE, quantity, rtol, mesh=L_MESH, linear=True, **more)


l_run = cache(on_l)


@cache
def force_run(name: str) -> sk.AdaptiveResult:
    return sk.adapt(square(FORCES[name][0], FORCE), CENTRAL, 1e-5 if name != "clamped" else 4e-5, linear=True)


@cache
def hemisphere_run() -> sk.AdaptiveResult:
    return sk.adapt(hemisphere(force=200.0), sk.Displacement(PULLED, (1, 0, 0)), 1e-3)


def power(levels, errors) -> float:
    """Of the number of coordinates by which errors fall, from the first mesh to the last."""
    n = np.array([level.n_dofs for level in levels], dtype=float)
    return float(np.polyfit(np.log(n), np.log(errors), 1)[0])


def errors_of(result, reference) -> np.ndarray:
    return np.abs(reference - np.array([level.value for level in result.levels]))


class Hidden:
    """A quantity that no rule knows."""

    def __init__(self, quantity):
        self.quantity, self.unit = quantity, quantity.unit

    def value(self, state):
        return self.quantity.value(state)

    def gradient(self, state):
        return self.quantity.gradient(state)


# --- rates ---------------------------------------------------------------------------------------------------------------


def test_rates_at_a_reentrant_corner():
    """w ~ r^1.5445: h^0.5445 = N^-0.27 on uniform meshes, in the energy norm; N^-1 of bicubic elements on adaptive ones."""
    adaptive, even = l_run(), on_l(max_levels=4, **EVERYWHERE)
    rates = [power(r.levels, np.sqrt(errors_of(r, L_ENERGY))) for r in (adaptive, even)]
    assert rates[0] < -0.9
    assert -0.40 < rates[1] < -0.25, "with a first step that is steeper"
    last = np.diff(np.log(errors_of(even, L_ENERGY)[-2:]))[0] / 2 / np.diff(np.log([v.n_dofs for v in even.levels[-2:]]))[0]
    assert last == pytest.approx(-0.27, abs=0.03)
    assert adaptive.ok and abs(adaptive.value - L_ENERGY) < 1e-4 * L_ENERGY


@pytest.mark.parametrize(("at", "reference"), [((-0.5, 0.5), 0.0031291), ((-0.5, -0.5), 0.0019219)])
def test_deflections_of_the_l_shape(at, reference):
    """Graded uniform meshes with Richardson's extrapolation, five digits, a part of 2e-5; the bar has a tenth of slack."""
    result = l_run(sk.Displacement(at))
    assert result.ok and abs(result.value - reference) < 1.3e-4 * reference


@pytest.mark.parametrize("name", FORCES)
def test_rates_under_a_force(name):
    """w ~ r^2 log r: N^-1 on uniform meshes, for a deflection N^-2 where the mesh adapts."""
    result, (support, reference) = force_run(name), FORCES[name]
    even = sk.adapt(square(support, FORCE), CENTRAL, 1e-9, linear=True, max_levels=4, **EVERYWHERE)
    rates = [power(r.levels, errors_of(r, reference)) for r in (result, even)]
    assert rates[0] < -1.7 and -1.15 < rates[1] < -0.9
    assert result.ok and abs(result.value - reference) < 1.1 * result.error_bar + 1e-7


# --- what took part ------------------------------------------------------------------------------------------------------


def test_nodes_hang():
    assert all(level.n_hanging > 0 for level in l_run().levels[1:])
    assert len(l_run().solution.system.mesh.hanging) == l_run().levels[-1].n_hanging


def test_elements_that_do_not_matter_are_merged():
    """A corner of the plate is three levels finer than the rest at first; the force is in the centre."""
    mesh = quadtree(sk.meshes.uniform(SQUARE, 4, 4)).refined([0])
    for level in (1, 2):
        mesh = mesh.refined(np.flatnonzero(mesh.levels == level))
    result = sk.adapt(square(SIMPLE, FORCE), CENTRAL, 1e-4, linear=True, mesh=mesh)
    first, second, last = result.levels[0], result.levels[1], result.levels[-1]
    corner = np.array([[0.06], [0.06]])
    assert second.coarsened > 10 and second.n_elements < first.n_elements
    assert last.mesh.levels[touching(last.mesh.leaves, corner)].max() < 3
    kept = sk.adapt(square(SIMPLE, FORCE), CENTRAL, 1e-4, linear=True, mesh=mesh, coarsening=sk.Never())
    assert not any(level.coarsened for level in kept.levels) and kept.levels[-1].n_elements > last.n_elements
    for run in (result, kept):
        assert run.ok and abs(run.value - FORCES["simple"][1]) < 1.1e-4 * run.value


def test_a_mesh_on_which_merging_made_it_worse_is_taken_back():
    """All elements that are not refined are merged where they can be, again and again; once it did harm, never again."""
    mesh = quadtree(sk.meshes.uniform(SQUARE, 2, 2)).refined(2)
    result = sk.adapt(square(SIMPLE, FORCE), CENTRAL, 1e-4, linear=True, mesh=mesh, marking=sk.Maximum(1.0),
                      coarsening=sk.AllElements())  # fmt: skip
    rejected = [k for k, level in enumerate(result.levels) if level.rejected]
    assert len(rejected) == 1
    k = rejected[0]
    before, bad, after = result.levels[k - 1 : k + 2]
    assert bad.coarsened and abs(bad.error) > abs(before.error) > abs(after.error)
    assert not any(level.coarsened for level in result.levels[k + 1 :])
    assert (after.mesh.leaves.find(before.mesh.leaves.cells.parents) < 0).all(), "the next mesh refines the one before"
    assert result.ok and not result.levels[-1].rejected and "rejected" in result.table()
    assert abs(result.value - FORCES["simple"][1]) < 1.1e-4 * result.value


def test_states_go_from_mesh_to_mesh():
    """With it a mesh takes half of Newton's steps; where these fail from there, it is relaxed from there."""
    result = hemisphere_run()
    assert not any(level.restarted for level in result.levels)
    problem, level = hemisphere(force=200.0), result.levels[-1]
    statics = StaticAnalysis(sk.Displacement(PULLED, (1, 0, 0)), rtol=1e-5)
    from_nothing = statics.solve(problem.on(level.mesh, "kirchhoff"), None)
    assert level.iterations < 0.6 * from_nothing.iterations
    assert from_nothing.value == pytest.approx(level.value, rel=1e-6)


def test_where_a_state_leads_nowhere_the_load_is_applied_anew(monkeypatch):
    """A transferred state that is no use: its load factor is known, its place is not."""
    from dataclasses import replace

    from skancf.adaptive import analysis

    problem, statics = hemisphere(force=200.0), StaticAnalysis(sk.Displacement(PULLED, (1, 0, 0)), rtol=1e-5)
    system = problem.on(quadtree(sk.meshes.uniform(problem.surface, 4, 4)), "kirchhoff")
    once = statics.solve(system, None)
    lost = replace(once.state, q=np.full_like(once.state.q, 1e200))
    monkeypatch.setattr(analysis, "transfer", lambda *_: lost)
    again = statics.solve(system, once.state)
    assert again.restarted and again.value == pytest.approx(once.value, rel=1e-9)


def interrupted_in(number: int, monkeypatch):
    solve, calls = StaticAnalysis.solve, []

    def solve_until(self, *arguments):
        calls.append(1)
        if len(calls) == number:
            raise KeyboardInterrupt
        return solve(self, *arguments)

    monkeypatch.setattr(StaticAnalysis, "solve", solve_until)
    return on_l()


def test_an_interrupt_leaves_the_last_finished_mesh(monkeypatch):
    result = interrupted_in(3, monkeypatch)
    assert result.status is Status.INTERRUPTED and not result.ok and "keyboard" in result.message
    assert len(result.levels) == 2 and result.value == result.levels[1].value == l_run().levels[1].value


def test_an_interrupt_on_the_first_mesh_goes_on(monkeypatch):
    with pytest.raises(KeyboardInterrupt):
        interrupted_in(1, monkeypatch)


def test_two_runs_are_the_same():
    """The same meshes; numbers to the order in which threads of a solver add up, some 1e-14 of the value."""
    one, two = on_l(rtol=3e-3), on_l(rtol=3e-3)
    for a, b in zip(one.levels, two.levels, strict=True):
        assert np.array_equal(a.mesh.leaves.keys, b.mesh.leaves.keys)
        assert max(abs(a.value - b.value), abs(a.error - b.error)) < 1e-12 * a.value


# --- budgets and errors --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("budget", "levels", "words"), [
    ({"max_dofs": 2500}, 3, r"max_dofs = 2500: the next mesh has \d+ nodal coordinates"),
    ({"max_levels": 2}, 2, "max_levels = 2 meshes are spent"),
    ({"max_seconds": 1e-6}, 1, "max_seconds = 1e-06: .* s are spent, and the next mesh would take some"),
])  # fmt: skip
def test_budgets(budget, levels, words):
    """The best answer with an honest bar, and why it ends."""
    result = on_l(rtol=1e-6, **budget)
    assert result.status is Status.BUDGET and not result.ok and len(result.levels) == levels
    assert abs(L_ENERGY - result.value) < 1.1 * result.error_bar
    assert result.levels[-1].n_dofs <= budget.get("max_dofs", np.inf)
    assert re.match(words, result.message)
    assert result.status.value in str(result)


def test_seconds_are_foreseen(monkeypatch):
    """By a clock on which every look takes a second: no mesh is begun that would end later than allowed."""
    ticks = iter(range(10**6))
    monkeypatch.setattr("skancf.adaptive.loop.time.perf_counter", lambda: float(next(ticks)))
    result = on_l(rtol=1e-8, max_seconds=40.0)
    assert result.status is Status.BUDGET and len(result.levels) > 1 and next(ticks) < 40


def test_a_budget_that_is_too_small_for_the_first_mesh():
    with pytest.raises(InputError, match="max_dofs = 100: the first mesh of 12 elements already has 252"):
        on_l(max_dofs=100)


def skewed():
    mesh = sk.meshes.uniform(SQUARE, 2, 2)
    points = mesh.p.copy()
    points[:, np.argmin(np.linalg.norm(points - 0.5, axis=0))] += 0.03
    return {"mesh": skfem.MeshQuad(points, mesh.t)}


@pytest.mark.parametrize(("quantity", "more", "words"), [
    (CENTRAL, {"rtol": 0.0}, "rtol = 0"),
    (CENTRAL, {"rtol": -1e-3}, "rtol = -0.001"),
    (CENTRAL, {"rtol": float("nan")}, "rtol"),
    (CENTRAL, {"atol": -1.0}, "atol = -1"),
    (CENTRAL, {"indicator": "zz"}, "indicator = 'zz': choose one of"),
    (CENTRAL, {"indicator": lambda state: np.ones(3)}, "3 numbers for 16 elements"),
    (CENTRAL, {"indicator": lambda state: -np.ones(16)}, r"indicators\[0\] = -1"),
    (CENTRAL, {"max_levels": 0}, "max_levels = 0"),
    (CENTRAL, {"max_seconds": -1.0}, "max_seconds = -1"),
    (CENTRAL, skewed(), "4 of 4 elements are no aligned rectangles .first: element 0"),
    (sk.Displacement((1.5, 0.5)), {}, r"\(1.5, 0.5\) lies outside"),
    (sk.SectionForce("M11", at=(0.5, -0.1)), {}, "lies outside"),
    (sk.Reaction("lleft"), {}, "no boundary 'lleft' on this mesh; it has"),
    ("w", {}, "quantity = 'w'"),
])  # fmt: skip
def test_wrong_input(quantity, more, words):
    with pytest.raises(InputError, match=words):
        sk.adapt(square(CLAMPED, UNIFORM), quantity, **{"rtol": 1e-3, "linear": True, **more})


def test_an_absolute_accuracy_is_enough():
    result = sk.adapt(square(CLAMPED, UNIFORM), CENTRAL, 0.0, atol=1e-6, linear=True)
    assert result.ok and result.error_bar <= 1e-6


def test_nothing_marked_is_said():
    result = on_l(indicator=lambda state: np.zeros(state.system.mesh.nelements))
    assert result.status is Status.UNMARKED and "no element is marked" in result.message and len(result.levels) == 1


def test_rounding_ends_it():
    """Small elements in the centre make rounding of coordinates large in the moment there: 1e-4 at 2^-19 of the plate."""
    mesh = quadtree(sk.meshes.uniform(SQUARE, 8, 8))
    for _ in range(16):
        mesh = mesh.refined(touching(mesh.leaves, np.array([[0.5], [0.5]])))
    moment = sk.SectionForce("M11", at=CENTRE)
    result = sk.adapt(square(SIMPLE, UNIFORM), moment, 1e-9, linear=True, mesh=mesh, coarsening=sk.Never())
    assert result.status is Status.ROUNDING and "rounding" in result.message and len(result.levels) < 4
    assert abs(result.value - 0.0478864) < result.error_bar < 1e-3 * result.value


def test_the_smallest_elements_end_it():
    """What is left of the error is theirs, and other elements need no refinement."""
    mesh = quadtree(L_MESH)
    for _ in range(15):
        mesh = mesh.refined(touching(mesh.leaves, np.zeros((2, 1))))
    result = sk.adapt(L_PLATE, Hidden(sk.SectionForce("M11", at=(0.0, 0.0))), 1e-3, linear=True, mesh=mesh)
    assert result.status is Status.ROUNDING and "as small as rounding lets them be" in result.message
    assert len(result.levels) == 1


# --- numbers without a limit ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("problem", "quantity", "more", "words"), [
    (square(SIMPLE, FORCE), sk.SectionForce("M11", at=CENTRE), {},
     r"\(0.5, 0.5\).*within=\(\(0.25, 0.75\), \(0.25, 0.75\)\)"),
    (L_PLATE, sk.SectionForce("M22", at=(0.0, 0.0)), {"mesh": L_MESH}, r"re-entrant corner.*SectionForce\('M22', within="),
    (square(SIMPLE, FORCE), CENTRAL, {"theory": "full"},
     r"Displacement\(at=\(0.5, 0.5\)\).*DiskForce, or theory 'kirchhoff'"),
])  # fmt: skip
def test_no_limit_by_rule(problem, quantity, more, words):
    with pytest.raises(sk.NoLimit, match=words):
        sk.adapt(problem, quantity, 1e-3, linear=True, **more)


@pytest.mark.parametrize(("problem", "at", "more"), [
    (square(SIMPLE, FORCE), CENTRE, {}), (L_PLATE, (0.0, 0.0), {"mesh": L_MESH}),
])  # fmt: skip
def test_no_limit_by_what_refinement_does(problem, at, more):
    result = sk.adapt(problem, Hidden(sk.SectionForce("M11", at=at)), 1e-3, linear=True, **more)
    assert result.status is Status.NO_LIMIT and f"({at[0]:g}, {at[1]:g})" in result.message
    assert "within" in result.message and len(result.levels) < 8


def test_no_false_alarm():
    """Corner and force have errors that fall slowly at first; hidden from the rules too."""
    for result in (l_run(), force_run("clamped"), hemisphere_run()):
        assert result.ok
    assert on_l(Hidden(sk.Displacement((-0.5, -0.5))), 1e-3).ok


def test_an_error_that_is_all_at_a_corner_is_no_alarm_while_it_falls():
    """By a half with each halving of the elements there, when only these are refined."""
    mesh = sk.meshes.uniform(L_SHAPE, 12, 12, openings=[((0.0, 1.0), (-1.0, 0.0))])
    result = sk.adapt(L_PLATE, sk.StrainEnergy(), 1e-5, linear=True, mesh=mesh, max_levels=5, marking=sk.Maximum(0.9))
    for level in result.levels[1:]:
        corner = touching(level.mesh.leaves, np.zeros((2, 1)))
        assert level.indicators[corner].sum() > 0.5 * level.indicators.sum() and level.mesh.levels[corner].max() > 0
    assert result.status is Status.BUDGET


# --- indicators ----------------------------------------------------------------------------------------------------------


def by_recovery(state):
    return sk.recovery_indicator(state)


@pytest.mark.parametrize("indicator", ["goal", "residual", "recovery", "stress", by_recovery])
def test_every_indicator_leads_to_a_percent(indicator):
    result = l_run(rtol=1e-2, indicator=indicator)
    assert result.ok and abs(result.value - L_ENERGY) < 1e-2 * L_ENERGY
    # Uniform meshes need 192 elements for 1.5 %, and 768 for 0.7 %.
    assert result.levels[-1].n_elements < 500
    depth = result.levels[-1].mesh.levels
    corner = touching(result.levels[-1].mesh.leaves, np.zeros((2, 1)))
    assert depth[corner].max() == depth.max()
    if indicator is by_recovery:
        assert result.value == l_run(rtol=1e-2, indicator="recovery").value


# --- surfaces and first meshes -------------------------------------------------------------------------------------------

TUBE = sk.CylinderSector(1.0, 2.0, 2 * pi, closed=True)


@cache
def pinched(angle: float) -> sk.AdaptiveResult:
    """A tube under pressure, its ends clamped, pushed inwards in the middle."""
    at = (1.0, angle)
    inwards = -TUBE.position(*np.reshape(at, (2, 1)))[:, 0] * [0, 1, 1]
    ends = sk.Clamp(lambda x, y: np.minimum(x, 2.0 - x) < 1e-9)
    problem = sk.Problem(TUBE, 0.02, sk.Isotropic(1e6, 0.3, 1.0), [ends],
                         [sk.FollowerPressure(10.0), sk.PointForce(at, tuple(inwards))])  # fmt: skip
    return sk.adapt(problem, sk.Displacement(at, tuple(inwards)), 2e-3)


def test_a_force_on_the_seam_is_like_one_elsewhere():
    """With elements as small on both sides of it, and the same answer to the accuracy of both."""
    seam, other = pinched(0.0), pinched(pi / 2)
    assert seam.ok and other.ok
    assert abs(seam.value - other.value) < seam.error_bar + other.error_bar
    mesh = seam.solution.system.mesh
    assert len(mesh.hanging) > 10
    sides = [mesh.levels[touching(mesh.leaves, np.array([[1.0], [y]]))] for y in (0.0, 2 * pi)]
    assert sorted(sides[0]) == sorted(sides[1]) and len(sides[0]) == 2
    assert sides[0].max() == mesh.levels.max()


def test_a_cap_with_a_pole():
    """Pressure on a clamped spherical cap; the value against a run of a tenth of the tolerance."""
    cap = sk.SphereSector(1.0, (0.0, 0.8), 2 * pi, closed=True)
    problem = sk.Problem(cap, 0.02, sk.Isotropic(1e6, 0.3, 1.0), [sk.Clamp(lambda x, y: np.abs(x - 0.8) < 1e-9)],
                         [sk.FollowerPressure(-10.0)])  # fmt: skip
    result, finer = (sk.adapt(problem, sk.Displacement((0.0, 0.0)), rtol) for rtol in (1e-2, 1e-3))
    assert result.ok and finer.ok
    assert abs(result.value - finer.value) < result.error_bar + finer.error_bar


def test_a_force_across_a_pole_has_no_part_along():
    """The normal there is the limit of those around it, and a deflection along it has a limit."""
    cap = sk.SphereSector(1.0, (0.0, 0.8), 2 * pi, closed=True)
    for force, why in (((0, 0, -1.0), None), ((1e-2, 0, -1.0), "sinks")):
        problem = sk.Problem(cap, 0.02, MATERIAL, [], [sk.PointForce((0.0, 0.0), force)])
        found = no_limit(sk.Displacement((0.0, 0.0), force), problem.on(quadtree(starting_mesh(problem), cap), "kirchhoff"))
        assert (found is None) if why is None else why in found


def test_buckling_under_a_load_that_supports_take():
    pushed = square(SIMPLE, sk.EdgeLoad("left", (1.0, 0, 0)))
    with pytest.raises(InputError, match="the supports take the whole load"):
        sk.adapt(pushed, sk.BucklingLoad(), 1e-3)


def test_the_first_mesh_has_nodes_where_something_holds_or_acts():
    surface, pins, at = sk.Rectangle(2.0, 1.0), [(0.3, 0.2), (1.7, 0.2), (1.0, 0.9)], (0.77, 0.41)
    material = sk.Isotropic(1e6, 0.3, 1.0)
    problem = sk.Problem(surface, 0.02, material, [sk.Pin(pins)], [UNIFORM, sk.PointForce(at, (0, 0, 1.0))])
    mesh = starting_mesh(problem)
    for point in (*pins, at):
        assert np.abs(mesh.p - np.reshape(point, (2, 1))).sum(axis=0).min() < 1e-12
    assert mesh.nelements < 80
    result, finer = (sk.adapt(problem, sk.Displacement((1.0, 0.5)), rtol, linear=True) for rtol in (1e-3, 1e-4))
    assert result.ok and finer.ok and abs(result.value - finer.value) < result.error_bar + finer.error_bar


# --- what users do ---------------------------------------------------------------------------------------------------


def hard_plate(thickness=0.01):
    return sk.Problem(
        sk.Rectangle(1.0, 1.0), thickness, sk.Isotropic(7e10, 0.3, 2700.0), [sk.SimpleSupport("boundary", "hard")],
        [sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    )  # fmt: skip


def test_a_small_deflection_follows_the_load_factor():
    once, thrice = (
        sk.adapt(hard_plate(), sk.Displacement((0.5, 0.5)), 1e-3, linear=True, load_factor=f) for f in (1.0, 3.0)
    )
    assert thrice.value == pytest.approx(3 * once.value, rel=1e-12)
    assert thrice.error_bar == pytest.approx(3 * once.error_bar, rel=1e-6)
    energies = [sk.adapt(hard_plate(), sk.StrainEnergy(), 1e-3, linear=True, load_factor=f).value for f in (1.0, 3.0)]
    assert energies[1] == pytest.approx(9 * energies[0], rel=1e-12)
    assert thrice.solution.work == pytest.approx(energies[1], rel=1e-3)  # both of the tolerance 1e-3
    load = thrice.solution.reactions()[2]
    assert load == pytest.approx(3000.0, rel=1e-9)


def test_bars_of_moments_hold_against_the_series(rng):
    """At places of no node: 12 of them, at each of which the asked accuracy holds and most bars hold the truth."""
    plate, within = hard_plate(), 0
    stiffness = 7e10 * 0.01**3 / (12 * (1 - 0.3**2))
    for x, y in rng.uniform(0.1, 0.9, (12, 2)):
        found = sk.adapt(plate, sk.SectionForce("M11", at=(x, y)), 1e-2, linear=True)
        m, n = navier.orders(301)
        w = 16 * -1000.0 / (np.pi**6 * stiffness * m * n * (m**2 + n**2) ** 2)
        curvature = -(np.pi**2) * w * (m**2 + 0.3 * n**2) * np.sin(m * np.pi * x) * np.sin(n * np.pi * y)
        truth = -stiffness * curvature.sum()
        assert found.ok
        assert abs(found.value - truth) < 1.5 * 1e-2 * abs(truth), (x, y)
        within += abs(found.value - truth) <= 1.1 * found.error_bar
    assert within >= 9


@pytest.mark.parametrize("thickness", [0.1, 0.2, 0.3])
def test_thick_plates_are_told(thickness):
    clamped = sk.Problem(
        sk.Rectangle(1.0, 1.0), thickness, sk.Isotropic(7e10, 0.3, 2700.0), [sk.Clamp("boundary")],
        [sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    )  # fmt: skip
    with pytest.warns(sk.OutOfDepth, match="transverse shear"):
        sk.adapt(clamped, sk.Displacement((0.5, 0.5)), 1e-2, linear=True)


def test_a_corner_alone_makes_no_plate_thick(recwarn):
    on_l(sk.Displacement((-0.5, 0.5)), 1e-2)
    assert not [w for w in recwarn if issubclass(w.category, sk.OutOfDepth)]


def test_a_state_in_motion_has_no_such_error():
    plate = hard_plate()
    system = plate.on(quadtree(sk.meshes.uniform(plate.surface, 2, 2)), "kirchhoff")
    moving = sk.Solution(system, system.undeformed, velocity=np.zeros(system.n_dofs), time=0.1)
    for judged in (lambda: sk.goal_estimate(moving, sk.StrainEnergy()), lambda: sk.residual_indicator(moving)):
        with pytest.raises(InputError, match="state of a motion"):
            judged()
    bare = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 2, 2), "kirchhoff"))
    with pytest.raises(InputError, match="quadtree"):
        sk.goal_estimate(bare, sk.StrainEnergy())


def test_loads_that_are_close_make_no_slivers():
    loads = [sk.PointForce((0.5, 0.5), (0.0, 0.0, -1.0)), sk.PointForce((0.5002, 0.5), (0.0, 0.0, -1.0))]
    plate = sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(7e10, 0.3, 2700.0), [sk.SimpleSupport("boundary", "hard")], loads
    )
    found = sk.adapt(plate, sk.Displacement((0.25, 0.5)), 1e-3, linear=True)
    assert found.ok
    sides = np.ptp(found.levels[0].mesh.p[:, found.levels[0].mesh.t], axis=1)
    assert sides.max() < 4 * sides.min()


def test_a_number_that_is_zero_is_told_apart():
    """By the sizes of what cancels in it; of a number of which nothing is known but its value, by an absolute accuracy."""
    found = sk.adapt(hard_plate(), sk.SectionForce("M12"), 1e-3, linear=True)
    assert found.ok and found.is_zero and "zero" in found.message
    unknown = Hidden(sk.SectionForce("M12"))
    found = sk.adapt(hard_plate(), unknown, 1e-3, linear=True, max_levels=2)
    assert not found.ok and "atol" in found.message
    assert sk.adapt(hard_plate(), unknown, 1e-3, atol=1e-6, linear=True).ok


class Broken:
    """A quantity that fails, or is no number, from the third mesh on."""

    unit = "m"

    def __init__(self, what):
        self.what, self.inner, self.meshes = what, sk.Displacement((0.5, 0.5)), set()

    def value(self, state):
        self.meshes.add(state.system.mesh.nelements)
        if len(self.meshes) > 4:  # two for each mesh, one of them refined
            if self.what == "raise":
                raise RuntimeError("no more")
            return float("nan")
        return self.inner.value(state)

    def gradient(self, state):
        return self.inner.gradient(state)


@pytest.mark.parametrize("what", ["raise", "nan"])
def test_what_was_computed_is_kept_when_a_quantity_fails(what):
    found = sk.adapt(hard_plate(), Broken(what), 1e-9, linear=True)
    assert found.status is Status.FAILED
    assert len(found.levels) == 2 and np.isfinite([found.value, found.error_bar]).all()
    assert ("no more" if what == "raise" else "finite") in found.message


@pytest.mark.parametrize(
    ("given", "match"),
    [({"problem": None}, "give a Problem"), ({"marking": 0.5}, "marking = 0.5: give a policy"),
     ({"indicator": ["goal"]}, "indicator"), ({"coarsening": sk.Never}, "coarsening")],
)  # fmt: skip
def test_what_is_no_problem_or_policy_is_refused(given, match):
    with pytest.raises(InputError, match=match):
        sk.adapt(**{"problem": hard_plate(), "quantity": CENTRAL, **given})


def test_means_are_over_the_same_rectangle_on_all_meshes(recwarn):
    mean = sk.SectionForce("M11", within=((0.3, 0.77), (0.1, 0.6)))
    found = sk.adapt(hard_plate(), mean, 1e-3, linear=True)
    assert found.ok and not [w for w in recwarn if "line" in str(w.message)]
    first = found.levels[0].mesh
    for axis, sides in enumerate(mean.within):
        assert np.isin(sides, first.p[axis]).all()
    with pytest.warns(sk.OutOfDepth, match=r"x = 0.3 lies between the mesh lines 0.25 and 0.5"):
        sk.adapt(hard_plate(), mean, 1e-1, linear=True, mesh=sk.meshes.uniform(SQUARE, 4, 4))
