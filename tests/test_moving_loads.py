"""Loads that move: where they act, what they do, how they leave, and the influence line."""

from math import pi

import numpy as np
import pytest

import skancf as sk
from skancf.adaptive.singular import singular_points
from skancf.errors import InputError
from skancf.history import check_covers
from skancf.linear import DirectSolver

theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])
UNIT = sk.Rectangle(1.0, 1.0)
MATERIAL = sk.Isotropic(1e6, 0.3, 1.0)
F = np.array([0.3, -0.2, 0.7])


def system_on(theory, *loads, surface=UNIT, supports=(), mesh=None, n=4, thickness=0.01):
    mesh = sk.meshes.uniform(surface, n, n) if mesh is None else mesh
    return sk.Problem(surface, thickness, MATERIAL, list(supports), list(loads)).on(mesh, theory)


def at_time(time):
    return sk.Case(time=time)


def resultant(system, time):
    """Force, and moment about the origin in the undeformed state."""
    f, q = system.external_force(system.undeformed, at_time(time)).reshape(-1, 4, 3), system.undeformed.reshape(-1, 4, 3)
    return f[:, 0].sum(axis=0), np.cross(q, f).sum(axis=(0, 1))


def diagonal(t):
    return (0.1 + t, 0.15 + 0.6 * t)


# --- a force ---------------------------------------------------------------------------------------------------------


@theories
def test_a_moving_force_is_a_point_force_where_it_is(theory):
    system = system_on(theory, sk.MovingForce(diagonal, tuple(F), history=lambda t: 1.0 + t))
    for t in (0.0, 0.15, 0.4, 0.77):
        there = system_on(theory, sk.PointForce(diagonal(t), tuple(F)))
        expected = (1 + t) * there.external_force(there.undeformed)
        assert np.allclose(system.external_force(system.undeformed, at_time(t)), expected, rtol=0, atol=1e-14)
        force, moment = resultant(system, t)
        assert np.allclose(force, (1 + t) * F, rtol=1e-12)
        assert np.allclose(moment, (1 + t) * np.cross([*diagonal(t), 0.0], F), rtol=1e-12)
        assert np.allclose(system.loads.places(at_time(t))[:, 0], diagonal(t))
    at_rest = system_on(theory, sk.PointForce(diagonal(0.0), tuple(F)))
    assert np.allclose(system.external_force(system.undeformed), at_rest.external_force(at_rest.undeformed), atol=1e-14)
    assert np.allclose(system.loads.places()[:, 0], diagonal(0.0))


@theories
def test_forces_are_continuous_where_it_crosses_edges(theory):
    """Through an edge, through a node, and along an edge; a force that went to the nearest node would jump."""
    paths = [lambda t: (t, 0.3), lambda t: (t, t), lambda t: (t, 0.5)]
    for path in paths:
        system = system_on(theory, sk.MovingForce(path, tuple(F)))
        for edge in (0.25, 0.5, 0.75):
            before, at, after = (system.external_force(system.undeformed, at_time(edge + d)) for d in (-1e-9, 0.0, 1e-9))
            assert np.abs(after - at).max() < 1e-7 and np.abs(before - at).max() < 1e-7
            if theory == "kirchhoff":  # so are their rates: the second difference is of the order of the step squared
                h = 1e-4
                left, right = (system.external_force(system.undeformed, at_time(edge + d)) for d in (-h, h))
                assert np.abs(right - 2 * at + left).max() < 200 * h**2 * np.abs(at).max()
                assert np.abs(right - left).max() > h


def test_on_hanging_nodes():
    mesh = sk.meshes.quadtree(sk.meshes.uniform(UNIT, 2, 2)).refined([0])
    for theory in ("kirchhoff", "full"):
        system = system_on(theory, sk.MovingForce(lambda t: (t, 0.3), tuple(F)), mesh=mesh)
        for t in (0.24, 0.25, 0.49, 0.5, 0.51):
            force, moment = resultant(system, t)
            assert np.allclose(force, F, rtol=1e-12) and np.allclose(moment, np.cross([t, 0.3, 0.0], F), rtol=1e-11)
        one, two = (system.external_force(system.undeformed, at_time(0.5 + d)) for d in (-1e-9, 1e-9))
        assert np.abs(one - two).max() < 1e-7


@theories
def test_it_comes_on_and_goes_off(theory):
    path = sk.Path([0.0, 3.0], [(-1.0, 0.5), (2.0, 0.5)])
    system = system_on(theory, sk.MovingForce(path, tuple(F)))
    for t, inside in ((0.5, False), (0.9999, False), (1.0, True), (1.5, True), (2.0, True), (2.0001, False), (3.0, False)):
        assert np.allclose(resultant(system, t)[0], F if inside else 0.0, rtol=1e-12, atol=1e-15)
        assert system.loads.places(at_time(t)).shape == (2, int(inside))
    with pytest.raises(InputError, match=r"Path at t = 3\.5 s"):
        system.external_force(system.undeformed, at_time(3.5))
    with pytest.raises(InputError, match="Path from t = 0 to 3 s does not cover the run"):
        check_covers(system.histories(), 0.0, 4.0)


@theories
def test_along_the_boundary_rounding_does_not_drop_it(theory):
    """Every place on the edges of a plate whose sides are no round numbers holds the force."""
    surface = sk.Rectangle(0.7, 0.3)
    sides = [lambda t: (0.7 * t, 0.1 + 0.1 + 0.1), lambda t: (0.7 * t, 0.0), lambda t: (0.1 * 7, 0.3 * t),
             lambda t: (0.0, 0.3 * t)]  # fmt: skip
    for side in sides:
        system = system_on(theory, sk.MovingForce(side, tuple(F)), surface=surface, n=7)
        for t in np.linspace(0, 1, 31):
            assert np.allclose(resultant(system, t)[0], F, rtol=1e-10)


def test_it_falls_through_an_opening():
    mesh = sk.meshes.uniform(UNIT, 5, 5, openings=[((0.4, 0.6), (0.4, 0.6))])
    system = system_on("full", sk.MovingForce(lambda t: (t, 0.5), tuple(F)), mesh=mesh)
    assert [bool(system.external_force(system.undeformed, at_time(t)).any()) for t in (0.2, 0.5, 0.9)] == [True, False, True]


@theories
def test_round_a_tube(theory):
    """A closed parameter runs on: the same place a turn later."""
    tube = sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True)
    system = system_on(theory, sk.MovingForce(lambda t: (0.4, t), tuple(F)), surface=tube, n=6)
    one, two = (system.external_force(system.undeformed, at_time(t)) for t in (1.0, 1.0 + 2 * pi))
    assert np.allclose(one, two, rtol=0, atol=1e-12) and one.any()


def test_the_last_time_is_kept():
    calls = []

    def path(t):
        calls.append(t)
        return diagonal(t)

    system = system_on("full", sk.MovingForce(path, tuple(F)))
    first = system.external_force(system.undeformed, at_time(0.2))
    again = system.external_force(system.undeformed, at_time(0.2))
    assert calls == [0.2] and np.array_equal(first, again)
    other = system.external_force(system.undeformed, at_time(0.3))
    assert calls == [0.2, 0.3] and not np.allclose(first, other)
    assert np.array_equal(system.external_force(system.undeformed, at_time(0.2)), first)


# --- a line ----------------------------------------------------------------------------------------------------------


@theories
def test_a_moving_line_is_a_line_load_where_it_is(theory):
    def start(t):
        return (0.1 + t, 0.05)

    system = system_on(theory, sk.MovingLine(start, (0.4, 0.9), tuple(F)))
    for t in (None, 0.0, 0.31, 0.8):
        there = system_on(theory, sk.LineLoad(start(t or 0.0), (0.4, 0.9), tuple(F)))
        expected = there.external_force(there.undeformed)
        assert np.allclose(system.external_force(system.undeformed, at_time(t)), expected, atol=1e-14)
        places = system.loads.places(at_time(t))
        way = np.subtract((0.4, 0.9), start(t or 0.0))
        off = np.cross(np.append(way, 0), np.c_[places.T - start(t or 0.0), np.zeros(places.shape[1])])[:, 2]
        assert places.shape[1] >= 4 and np.abs(off).max() < 1e-12


@theories
def test_the_part_of_a_line_inside_acts(theory):
    def low(t):
        return (t, -0.5)

    def high(t):
        return (t, 0.6)

    system = system_on(theory, sk.MovingLine(low, high, lambda x, y: np.stack([0 * x, 0 * x, y])))
    force, moment = resultant(system, 0.3)
    assert np.allclose(force, [0, 0, 0.6**2 / 2], rtol=0, atol=1e-14)
    assert np.allclose(moment, [0.6**3 / 3, -0.3 * 0.6**2 / 2, 0], rtol=0, atol=1e-14)
    assert not system.external_force(system.undeformed, at_time(1.2)).any()
    assert system.loads.places(at_time(1.2)).shape == (2, 0)
    point = system_on(theory, sk.MovingLine(low, low, tuple(F)))
    assert not point.external_force(point.undeformed, at_time(0.5)).any(), "a line without length"


@theories
def test_influence_line(theory):
    """w in the middle of a simply supported strip, P a (3 L^2 - 4 a^2) / 48 D for a force per width at a < L / 2."""
    strip, P = sk.Rectangle(1.0, 0.1), 1e-3
    supports = [sk.SimpleSupport(["left", "right"]), sk.Symmetry(["bottom", "top"])]
    ends = [sk.Path([0.0, 1.0], [(0.0, y), (1.0, y)]) for y in (0.0, 0.1)]
    line = sk.MovingLine(*ends, (0.0, 0.0, P))
    thickness, n = 0.001 if theory == "kirchhoff" else 0.01, 8 if theory == "kirchhoff" else 32
    mesh = sk.meshes.uniform(strip, n, 1)
    system = system_on(theory, line, surface=strip, supports=supports, mesh=mesh, thickness=thickness)
    D = 1e6 * thickness**3 / 12 / (1 - 0.3**2)
    times = np.array([0.0, 0.1, 0.2234, 0.375, 0.5, 0.6, 0.85])
    a = np.minimum(times, 1 - times)
    with DirectSolver(system.pattern, system.constraints) as solver:
        solver.factor(system.stiffness())
        found = []
        for t in times:
            u = solver.solve(system.external_force(system.undeformed, at_time(t)), refinements=2)
            found.append(sk.Solution(system, system.undeformed + u).displacement((0.5, 0.05))[2])
    exact = P * a * (3 - 4 * a**2) / (48 * D)
    # Exact at nodes on the thin element, up to rounding over (thickness / length)^2; full has shear and is of order two.
    assert np.allclose(found, exact, rtol=0, atol=(1e-6 if theory == "kirchhoff" else 5e-3) * exact.max())
    assert not np.allclose(found, P * a * (3 - 3 * a**2) / (48 * D), rtol=0, atol=5e-3 * exact.max())


# --- mistakes, and others' places ------------------------------------------------------------------------------------


def test_places_of_loads_that_stand():
    loads = [sk.PointForce((0.2, 0.3), (0, 0, 1.0)), sk.DiskForce((0.5, 0.5), 0.1, (0, 0, 1.0)), sk.SurfaceLoad((0, 0, 1.0)),
             sk.Gravity(), sk.FollowerPressure(1.0), sk.LineLoad((0.1, 0.9), (0.8, 0.9), (0, 0, 1.0))]  # fmt: skip
    places = system_on("full", *loads).loads.places(at_time(0.3))
    assert np.array_equal(places[:, 0], (0.2, 0.3))
    disk = np.linalg.norm(places[:, 1:769] - 0.5, axis=0)
    assert disk.max() < 0.1 and np.allclose(places[1, 769:], 0.9) and places.shape[1] > 769
    assert system_on("full").loads.places().shape == (2, 0)


def test_singular_points_of_loads_that_move_are_where_statics_has_them():
    bare = singular_points(system_on("full"))
    for load, at in [(sk.MovingLine(diagonal, (0.4, 0.9), F), [diagonal(0.0), (0.4, 0.9)]),
                     (sk.MovingForce(diagonal, tuple(F)), [diagonal(0.0)])]:  # fmt: skip
        found = singular_points(system_on("full", load))
        assert found.shape[1] == bare.shape[1] + len(at)
        assert all((np.abs(found.T - point).max(axis=1) < 1e-12).any() for point in at)


@pytest.mark.parametrize(("build", "words"), [
    (lambda: sk.MovingForce((0.5, 0.5), (0, 0, 1.0)), r"path = \(0.5, 0.5\): give a function of time"),
    (lambda: sk.MovingForce(diagonal, (0, 1.0)), "force = .*give 3 numbers"),
    (lambda: sk.MovingForce(diagonal, (0, 0, 1.0), history=1.0), "history = 1.0"),
    (lambda: sk.MovingLine("left", diagonal, (0, 0, 1.0)), "start, neither a function of time nor a point"),
    (lambda: sk.MovingLine(diagonal, (0, 0), (0, 1.0)), "force"),
    (lambda: resultant(system_on("full", sk.MovingForce(lambda t: (t, np.nan), (0, 0, 1.0))), 0.5),
     r"path at t = 0.5\[1\] .*not finite"),
    (lambda: resultant(system_on("full", sk.MovingForce(lambda t: t, (0, 0, 1.0))), 0.5),
     "path at t = 0.5 = 0.5: give 2 numbers"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(InputError, match=words):
        build()
