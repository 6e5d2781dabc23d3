"""Pressures, moments, foundations and springs that vary from place to place, and moments at points."""

import math
from math import pi

import numpy as np
import pytest

import skancf as sk

A, B, T, E, NU = 1.2, 0.8, 0.01, 70e9, 0.3
D = E * T**3 / 12 / (1 - NU**2)
PLATE = sk.Rectangle(A, B)
MATERIAL = sk.Isotropic(E, NU, 2500.0)
HARD = sk.SimpleSupport("boundary", kind="hard")
SUMS = 1e-11
theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])


def on_plate(supports=(), loads=(), theory="kirchhoff", n=(6, 4), mesh=None, surface=PLATE):
    mesh = sk.meshes.uniform(surface, *n) if mesh is None else mesh
    return sk.Problem(surface, T, MATERIAL, list(supports), list(loads)).on(mesh, theory)


def wave(x, y):
    return np.sin(pi * x / A) * np.sin(pi * y / B)


def tree():
    return sk.meshes.quadtree(sk.meshes.uniform(PLATE, 3, 2), PLATE).refined([2, 5]).refined([3])


@pytest.mark.parametrize("load", [
    sk.SurfaceLoad(lambda x, y: (0.0, 0.0, -100.0 * math.sin(pi * x / A) * math.sin(pi * y / B))),
    sk.FollowerPressure(lambda x, y: -100.0 * wave(x, y)),
])  # fmt: skip
def test_navier(load):
    w = sk.solve_linear(on_plate([HARD], [load], n=(8, 8))).displacement((A / 2, B / 2))[2]
    # Error of cubics, h^4.
    assert w == pytest.approx(-100.0 / (D * pi**4 * (1 / A**2 + 1 / B**2) ** 2), rel=2e-4)


def test_foundation_that_varies():
    """w = wave of the load D (pi^2/A^2 + pi^2/B^2)^2 w + k(x, y) w."""
    bending = D * pi**4 * (1 / A**2 + 1 / B**2) ** 2

    def stiffness(x, y):
        return bending * (1 + 3 * x + y**2)

    load = sk.SurfaceLoad(lambda x, y: (0, 0, 1e-3 * (bending + stiffness(x, y)) * wave(x, y)))
    supports = [HARD, sk.Foundation(stiffness, direction=(0, 0, 1))]
    at = np.random.default_rng(1).uniform((0, 0), (A, B), size=(30, 2))
    errors = [
        np.abs(sk.solve_linear(on_plate(supports, [load], n=(n, n))).displacement(at)[:, 2] - 1e-3 * wave(*at.T)).max()
        for n in (4, 8)
    ]
    assert errors[1] < 1e-6 and errors[0] / errors[1] > 10


@theories
@pytest.mark.parametrize("mesh", [None, tree])
def test_the_moment_of_an_edge_is_the_integral(theory, mesh):
    load = sk.EdgeMoment("right", lambda x, y: (0.0, 3.0 * y**2, 0.0))
    system = on_plate([], [load], theory, mesh=mesh() if mesh else None)
    force = system.external_force(system.undeformed).reshape(-1, 4, 3)
    assert np.allclose(np.cross(system.geometry.undeformed, force).sum(axis=(0, 1)), [0, B**3, 0], atol=SUMS)


def test_an_edge_moment_that_varies():
    """w = sin(pi y / B) sinh of x between two simply supported edges: the Levy solution."""
    moment = 5.0
    load = sk.EdgeMoment("right", lambda x, y: (0.0, moment * math.sin(pi * y / B), 0.0))
    a, found = pi / B, sk.solve_linear(on_plate([HARD], [load], n=(16, 12)))
    # w = (P sinh a x + Q x cosh a x) sin a y, w = 0 and D w_xx = M at x = A, of magnitude M.
    P, Q = np.linalg.solve(
        [[np.sinh(a * A), A * np.cosh(a * A)],
         [a**2 * np.sinh(a * A), 2 * a * np.sinh(a * A) + a**2 * A * np.cosh(a * A)]], [0.0, moment / D])  # fmt: skip
    x = 0.75 * A
    expected = P * np.sinh(a * x) + Q * x * np.cosh(a * x)
    assert abs(found.displacement((x, B / 2))[2]) == pytest.approx(abs(expected), rel=1e-3)


@theories
def test_springs_along_an_edge_that_vary(theory):
    """A stiff strip on springs k = k0 y along its edge, lifted by them: the force of a unit motion is the integral."""
    supports = [sk.Spring("left", lambda x, y: (0.0, 0.0, 500.0 * y))]
    system = on_plate(supports, theory=theory)
    up = np.zeros_like(system.geometry.undeformed)
    up[:, 0, 2] = 1.0
    assert up.ravel() @ (system.foundation @ up.ravel()) == pytest.approx(500 * B**2 / 2, rel=1e-12)
    dashpots = on_plate([sk.Dashpot("left", lambda x, y: (0.0, 0.0, 500.0 * y))], theory=theory)
    assert up.ravel() @ (dashpots.viscous @ up.ravel()) == pytest.approx(500 * B**2 / 2, rel=1e-12)


def tangent_error(system, seed=0):
    rng = np.random.default_rng(seed)
    q, eps = system.undeformed + 0.05 * rng.normal(size=system.n_dofs), 1e-6
    columns = rng.integers(0, system.n_dofs, 40)

    def force(state):
        return system.external_force(state)

    numeric = np.zeros((system.n_dofs, 40))
    for k, column in enumerate(columns):
        e = np.zeros(system.n_dofs)
        e[column] = eps
        numeric[:, k] = -(force(q + e) - force(q - e)) / (2 * eps)
    blocks = system.blocks()
    for load in system.loads:
        load.add_tangent(q, None, sk.Case(), blocks)
    exact = blocks.matrix().to_scipy() + system.skew(q)
    exact = np.asarray(exact.todense())[:, columns]
    return np.abs(exact - numeric).max() / np.abs(exact).max()


@theories
@pytest.mark.parametrize("load", [
    sk.FollowerPressure(lambda x, y: 1 + x * y), sk.PointMoment((0.37, 0.21), (1.0, 2.0, 3.0)),
    sk.EdgeMoment("right", lambda x, y: (y, 1.0, x)),
])  # fmt: skip
def test_tangents_are_derivatives(theory, load):
    assert tangent_error(on_plate([], [load], theory, n=(2, 2))) < 1e-7


@theories
def test_a_function_that_is_constant_is_the_constant(theory):
    one, other = (on_plate([], [sk.FollowerPressure(p)], theory) for p in (3.0, lambda x, y: 3.0))
    q = one.undeformed + 0.01 * np.random.default_rng(0).normal(size=one.n_dofs)
    scale = np.abs(one.external_force(q)).max()
    assert np.abs(one.external_force(q) - other.external_force(q)).max() < 1e-13 * scale


@theories
def test_a_point_moment_is_the_moment_it_says(theory):
    system = on_plate([], [sk.PointMoment((0.37, 0.21), (3.0, -2.0, 0.0))], theory)
    force = system.external_force(system.undeformed).reshape(-1, 4, 3)
    assert np.allclose(force[:, 0].sum(axis=0), 0, atol=SUMS)
    assert np.allclose(np.cross(system.geometry.undeformed, force).sum(axis=(0, 1)), [3, -2, 0], atol=SUMS)


def test_a_point_moment_by_navier_and_as_the_limit_of_a_couple():
    at, seen, m = (0.4 * A, 0.5 * B), (0.7 * A, 0.4 * B), 2.0
    found = sk.solve_linear(on_plate([HARD], [sk.PointMoment(at, (0.0, m, 0.0))], n=(20, 12))).displacement(seen)[2]
    # The couple is -m times the derivative by x of unit forces along z.
    i, j = np.meshgrid(np.arange(1, 200), np.arange(1, 200), indexing="ij")
    a, b = i * pi / A, j * pi / B
    terms = a * np.cos(a * at[0]) * np.sin(b * at[1]) * np.sin(a * seen[0]) * np.sin(b * seen[1]) / (a**2 + b**2) ** 2
    assert found == pytest.approx(-m * 4 / (A * B * D) * terms.sum(), rel=2e-3)
    h = 1e-4
    couple = [sk.PointForce((at[0] + s * h, at[1]), (0, 0, -s * m / (2 * h))) for s in (1, -1)]
    assert sk.solve_linear(on_plate([HARD], couple, n=(20, 12))).displacement(seen)[2] == pytest.approx(found, rel=1e-4)


@theories
def test_loads_on_a_named_line_inside(theory):
    mesh = sk.meshes.uniform(PLATE, 6, 4)
    line = mesh.facets_satisfying(lambda x: np.abs(x[0] - A / 2) < 1e-9)
    mesh = mesh.with_boundaries({**mesh.boundaries, "rib": line})
    system = on_plate([], [sk.EdgeLoad("rib", lambda x, y: (0, 0, y))], theory, mesh=mesh)
    same = on_plate([], [sk.LineLoad((A / 2, 0.0), (A / 2, B), lambda x, y: (0, 0, y))], theory, mesh=mesh)
    q = system.undeformed
    assert np.allclose(system.external_force(q), same.external_force(q), atol=1e-14)
    turned = on_plate([], [sk.EdgeMoment("rib", (0.0, 1.0, 0.0))], theory, mesh=mesh)
    force = turned.external_force(q).reshape(-1, 4, 3)
    assert np.allclose(np.cross(turned.geometry.undeformed, force).sum(axis=(0, 1)), [0, B, 0], atol=SUMS)


@pytest.mark.parametrize("supports, loads, words", [
    ([], [sk.FollowerPressure(lambda x, y: (x, y))], "pressure of shape"),
    ([], [sk.EdgeMoment("left", lambda x, y: x)], "moment of shape.*three components"),
    ([], [sk.PointMoment((0.5, 0.5), (0, 0, 1.0))], "along the normal"),
    ([], [sk.PointMoment((5.0, 0.5), (0, 1.0, 0.0))], "outside the surface"),
    ([sk.Foundation(lambda x, y: x - 0.5)], [], "stiffness = -.*nowhere negative"),
    ([sk.Foundation(lambda x, y: 0 * x)], [], "stiffness is zero all over"),
    ([sk.Spring("left", lambda x, y: (0, 0, np.nan))], [], "stiffness.*not finite"),
    ([sk.Dashpot("left", lambda x, y: (0, 0, x))], [], "damping is zero all over"),
])  # fmt: skip
def test_mistakes(supports, loads, words):
    with pytest.raises(sk.InputError, match=words):
        on_plate(supports, loads)


def disk_at(surface, at, radius, mesh):
    system = on_plate([], [sk.DiskForce(at, radius, (0.0, 0.0, 1.0))], surface=surface, mesh=mesh)
    return system, system.external_force(system.undeformed).reshape(-1, 4, 3)


def test_a_disk_is_round_where_the_parameters_bend():
    """Near the middle of a disc in polar parameters: its second moments are those of a disc."""
    disc = sk.AnnulusSector(0.05, 1.0, 2 * pi, closed=True)
    mesh, radius = sk.meshes.uniform(disc, 8, 16), 0.2
    centre = disc.position(np.array([0.3]), np.array([0.0]))[:, 0]
    system, _ = disk_at(disc, (0.3, 0.0), radius, mesh)
    at = disc.position(*system.loads.places()) - centre[:, None]
    # Rings of equal area at their mean radius squared.
    assert np.allclose(at[:2] @ at[:2].T / at.shape[1], radius**2 / 4 * np.eye(2), atol=1e-9)


def test_a_disk_farther_around_than_the_surface_goes_is_refused():
    tube, cap = sk.CylinderSector(1.0, 4.0, 2 * pi, closed=True), sk.SphereSector(1.0, (0.0, 2.5), 2 * pi, closed=True)
    for surface, at, says in ((tube, (2.0, 0.0), "so far around it"), (cap, (0.2, 0.0), "reaches over the edge")):
        with pytest.raises(sk.InputError, match=f"disk at .*{says}"):
            disk_at(surface, at, 1.2, sk.meshes.uniform(surface, 4, 8))


SURFACES = {
    "flat": sk.Rectangle(1.0, 2.0), "cylinder": sk.CylinderSector(1.0, 2.0, 1.0), "annulus": sk.AnnulusSector(1.0, 2.0, 1.0),
    "saddle": sk.HyperbolicParaboloid(2.0, 1.0, 0.4), "sphere": sk.SphereSector(1.0, (0.5, 1.5), 1.0),
}  # fmt: skip


def with_line(mesh, at):
    return mesh.with_boundaries({"line": lambda x: np.abs(x[0] - at) < 1e-9}, boundaries_only=False)


def meshes_with_a_line(surface):
    """Meshes with a named line across them, and where it is; nodes hang on it in the last two."""
    (low, high), across = surface.bounds
    x, y = (a + (b - a) * np.array(row) for (a, b), row in (((low, high), (0, 0.1, 0.4, 1)), (across, (0, 0.3, 0.35, 1))))
    yield "tensor", with_line(sk.meshes.tensor(surface, x, y), x[2]), x[2]
    spot = sk.meshes.Region([(a + b) / 2 for a, b in surface.bounds], (0.1, 0.1), ratio=9.0)
    graded = sk.meshes.graded(surface, [spot], shape=(5, 5))
    at = np.unique(graded.p[0])[3]
    yield "graded", with_line(graded, at), at
    even = sk.meshes.quadtree(sk.meshes.uniform(surface, 2, 2), surface)
    middle = (low + high) / 2
    yield "refined", with_line(even, middle).refined([0]).refined([0, 4]), middle
    yield "named later", with_line(even.refined([0, 3]).refined([1]), middle), middle


@pytest.mark.parametrize("name", SURFACES)
def test_a_load_on_an_inner_edge_is_that_on_the_line(name):
    """By elements of one side, by halves of divided edges, or by what elements the line crosses: the same work."""
    surface = SURFACES[name]

    def force(x, y):
        return 1 + x * y, np.cos(x) + y, x**2 - 2

    hanging = 0
    for kind, mesh, at in meshes_with_a_line(surface):
        start, end = ((at, y) for y in surface.bounds[1])
        loads = [sk.EdgeLoad("line", force), sk.LineLoad(start, end, force)]
        for theory in ("full", "kirchhoff"):
            system = on_plate([], loads, theory, mesh=mesh, surface=surface)
            edge, line = (load.force(system.undeformed, None, sk.Case()) for load in system.loads)
            assert np.abs(edge - line).max() < 1e-11 * np.abs(line).max(), (kind, theory)
        hanging += len(getattr(mesh, "hanging", []))
    assert hanging > 4


@theories
def test_a_moment_on_an_inner_line_with_hanging_nodes(theory):
    """On a flat plate its moment is the integral, whichever side is finer."""
    for kind, mesh, at in meshes_with_a_line(PLATE):
        load = sk.EdgeMoment("line", lambda x, y: (x * y, 3.0 * y**2, 7.0))
        system = on_plate([], [load], theory, mesh=mesh)
        force = system.external_force(system.undeformed).reshape(-1, 4, 3)
        moment = np.cross(system.geometry.undeformed, force).sum(axis=(0, 1))
        assert np.allclose(moment, [at * B**2 / 2, B**3, 0], atol=SUMS), kind
        assert np.allclose(force[:, 0].sum(axis=0), 0, atol=SUMS)


@theories
@pytest.mark.parametrize("factor", [0.3, 1.0])
def test_prescribed_functions_turn_a_plate_by_load_factors(theory, factor):
    """Edges and an inner line with hanging nodes move as the function says, times the factor; a whole turn is rigid."""
    c, s = math.cos(0.7), math.sin(0.7)

    def turn(x, y):
        return (c - 1) * x + 0 * y, 0 * x, -s * x + 0 * y

    mesh = with_line(sk.meshes.quadtree(sk.meshes.uniform(PLATE, 2, 2), PLATE), A / 2).refined([0])
    assert (np.abs(mesh.p[0, mesh.hanging] - A / 2) < 1e-9).any()
    problem = sk.Problem(PLATE, T, MATERIAL, [sk.Prescribed(["boundary", "line"], turn)])
    solution = sk.solve(problem.on(mesh, theory), load_factor=factor).unwrap()
    rng = np.random.default_rng(2)
    line, edge = np.array([(A / 2, y) for y in rng.uniform(0, B, 9)]), np.array([(x, 0.0) for x in rng.uniform(0, A, 9)])
    for at in (line, edge, *([rng.uniform((0, 0), (A, B), (20, 2))] if factor == 1.0 else [])):
        assert np.allclose(solution.displacement(at).T, factor * np.array(turn(*at.T)), atol=1e-10)
