"""Displacements and rotations as functions of place: fields that the elements contain come out exactly."""

import math

import numpy as np
import pytest

import skancf as sk

EXACT = 1e-10
MATERIAL = sk.Isotropic(3e6, 0.3, 1000.0)
PLATE = sk.Rectangle(1.3, 0.9)


def quadtree():
    """With hanging nodes; the small elements are at the boundary."""
    mesh = sk.meshes.quadtree(sk.meshes.uniform(PLATE, 3, 2), PLATE)
    return mesh.refined([0, 5]).refined([2])


MESHES = {
    "uniform": lambda: sk.meshes.uniform(PLATE, 3, 2),
    "tensor": lambda: sk.meshes.tensor(PLATE, [0.0, 0.2, 0.9, 1.3], [0.0, 0.5, 0.6, 0.9]),
    "quadtree": quadtree,
}
on_all = pytest.mark.parametrize("mesh", MESHES)
theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])


def solved(mesh, theory, supports, solve=sk.solve_linear, thickness=0.05, surface=PLATE):
    mesh = MESHES[mesh]() if isinstance(mesh, str) else mesh
    return solve(sk.Problem(surface, thickness, MATERIAL, supports).on(mesh, theory))


def error(solution, function):
    at = np.random.default_rng(0).uniform((0, 0), (1.3, 0.9), size=(40, 2))
    exact = np.stack([np.broadcast_to(u, 40) for u in function(*at.T)], axis=1)
    return np.abs(solution.displacement(at) - exact).max() / np.abs(exact).max()


@on_all
@theories
@pytest.mark.parametrize("g", [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0.3, -0.2, 0.5, 0.1)])
def test_membrane_patch(mesh, theory, g):
    def field(x, y):
        return 1e-3 * (g[0] * x + g[1] * y), 1e-3 * (g[2] * x + g[3] * y), 0.0 * x

    assert error(solved(mesh, theory, [sk.Prescribed("boundary", field)]), field) < EXACT


@on_all
@theories
@pytest.mark.parametrize("c", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, -0.8, 0.3)])
def test_bending_patch(mesh, theory, c):
    def field(x, y):
        return 0 * x, 0 * x, 1e-3 * (c[0] * x * x + c[1] * y * y + c[2] * x * y + 0.2 * x)

    def rotation(x, y):
        return 1e-3 * (2 * c[1] * y + c[2] * x), -1e-3 * (2 * c[0] * x + c[2] * y + 0.2), 0 * x

    assert error(solved(mesh, theory, [sk.Prescribed("boundary", field, rotation=rotation)]), field) < EXACT


@theories
def test_a_free_rotation_is_not_prescribed(theory):
    """Without rotations the plate bent by its edges to w = x^2 is another one: its edges turn."""

    def field(x, y):
        return 0 * x, 0 * x, 1e-3 * x * x

    assert error(solved("uniform", theory, [sk.Prescribed("boundary", field)]), field) > 1e-2


@theories
def test_statics_with_a_large_stretch(theory):
    def field(x, y):
        return 0.2 * x - 0.1 * y, 0.1 * x + 0.05 * y, 0 * x

    solution = solved("tensor", theory, [sk.Prescribed("boundary", field)], lambda s: sk.solve(s, rtol=1e-12).unwrap())
    assert error(solution, field) < EXACT


def test_functions_of_numbers_entries_of_their_own_and_numbers():
    fields = [lambda x, y: (None, 0.0, math.sin(x) * y), (None, 0.0, lambda x, y: np.sin(x) * y)]
    one, two = (solved("uniform", "kirchhoff", [sk.Prescribed("boundary", field), sk.Pin((0, 0))]) for field in fields)
    assert np.abs(one.q - two.q).max() < 1e-15
    constant = [solved("uniform", "full", [sk.Prescribed("boundary", u)]) for u in ((1, 2, 3), lambda x, y: (1, 2, 3))]
    assert np.abs(constant[0].q - constant[1].q).max() < 1e-12


@pytest.mark.parametrize("kind", ["left", "function"])
def test_slopes_along_the_edge_follow(kind):
    where = "left" if kind == "left" else lambda x, y: x < 1e-9
    support = sk.Prescribed(where, (None, None, lambda x, y: np.exp(y)))
    system = sk.Problem(PLATE, 0.1, MATERIAL, [support]).on(MESHES["tensor"]())
    nodal, edge = system.prescribed().reshape(-1, 4, 3), system.geometry.nodes_on("left")
    y = system.geometry.points[1, edge]
    # Chebyshev interpolation of degree eight over half a unit.
    assert np.allclose(nodal[edge, 0, 2], np.exp(y), rtol=1e-13) and np.allclose(nodal[edge, 2, 2], np.exp(y), rtol=1e-9)
    assert not nodal[edge, 1].any()


def on_boundary(x, y):
    return (abs(x) < 1e-9) | (abs(x - 1.3) < 1e-9) | (abs(y) < 1e-9) | (abs(y - 0.9) < 1e-9)


def fields(k):
    """Displacements u = grad(f) of a harmonic f, which need no force in the plane, and a deflection f, which needs none."""

    def f(x, y):
        return 1e-4 * np.exp(k * x) * np.cos(k * y)

    def f_y(x, y):
        return -1e-4 * np.exp(k * x) * np.sin(k * y)

    return {
        "in the plane": (lambda x, y: (k * f(x, y), k * f_y(x, y), 0 * x), None),
        "bent": (lambda x, y: (0 * x, 0 * x, f(x, y)), lambda x, y: (k * f_y(x, y), -k * f(x, y), 0 * x)),
    }, lambda x, y: k * k * np.array([f(x, y), -f(x, y), f_y(x, y)])  # f_xx, f_yy, f_xy


@pytest.mark.parametrize("where", ["boundary", on_boundary], ids=["by name", "by a function"])
@pytest.mark.parametrize("kind, theory", [("in the plane", "full"), ("in the plane", "kirchhoff"), ("bent", "kirchhoff")])
def test_stresses_converge_up_to_an_edge_that_a_function_moves(where, kind, theory):
    k, t = 2.3, 0.05
    given, second = fields(k)
    displacement, rotation = given[kind]
    support = sk.Prescribed(where, displacement, rotation=rotation)
    stiff = MATERIAL.young * t / (1 + MATERIAL.poisson)  # of tr(strain) = 0, over t^2 / 12 for curvatures
    errors = []
    for n in (4, 8, 16):
        solution = solved(sk.meshes.uniform(PLATE, n, n), theory, [support], thickness=t)
        exact = stiff * second(*solution.system.mesh.p).T * (1.0 if kind == "in the plane" else -t * t / 12)
        found = solution.nodal_section_forces()[:, :3] if kind == "in the plane" else solution.nodal_section_forces()[:, 3:]
        errors.append(np.abs(found - exact).max() / np.abs(exact).max())
    # Largest errors at nodes, those of the edges among them: strains of cubics are of order three, the assumed ones two.
    assert errors[-1] < 0.02 and errors[0] / errors[1] > 3 and errors[1] / errors[2] > 3, errors


@theories
def test_they_do_not_where_points_of_the_edge_are_moved(theory):
    displacement, _ = fields(2.3)[0]["in the plane"]
    largest = []
    for n in (4, 8, 16):
        mesh = sk.meshes.uniform(PLATE, n, n)
        row = mesh.p[:, mesh.boundary_nodes()].T.tolist()
        with pytest.warns(sk.OutOfDepth, match="stresses grow without limit"):
            solution = solved(mesh, theory, [sk.Prescribed(row, displacement)])
        nodes = mesh.boundary_nodes()
        edge, exact = solution.nodal_section_forces()[nodes], fields(2.3)[1](*mesh.p[:, nodes])
        largest.append(np.abs(edge[:, :3].T - MATERIAL.young * 0.05 / 1.3 * exact).max())
    # By a function the same errors fall to a ninth and less.
    assert min(largest) > 0.7 * max(largest), largest


@theories
def test_a_tube_twisted_by_its_ends_turns(theory):
    """A rigid turn about its axis, of a closed curved surface."""
    tube = sk.CylinderSector(0.5, 1.0, 2 * np.pi, closed=True)
    mesh = sk.meshes.uniform(tube, 3, 8)

    def field(x, y):
        return 1e-4 * np.cross([0.3, 0.2, 1.0], tube.position(x, y), axisb=0, axisc=0)

    solution = solved(mesh, theory, [sk.Prescribed("boundary", field, rotation=(3e-5, 2e-5, 1e-4))], surface=tube)
    turned = solution.displacement(mesh.p.T)
    # The edge between nodes is a cubic, the turn of the undeformed one is not: to the error of the geometry.
    assert np.abs(turned - field(*mesh.p).T).max() < 1e-8
    assert np.abs(turned).max() > 1e-5


@pytest.mark.parametrize("u", [lambda x, y: np.sin(y) ** 2, lambda x, y: 1 - np.cos(y), lambda x, y: np.exp(np.sin(y))])
def test_a_seam_is_no_contradiction_and_a_jump_there_is(u):
    tube = sk.CylinderSector(0.5, 1.0, 2 * np.pi, closed=True)
    mesh = sk.meshes.uniform(tube, 2, 6)
    assert sk.Problem(tube, 0.05, MATERIAL, [sk.Prescribed("left", (u, u, None))]).on(mesh, "kirchhoff").prescribed().any()
    jump = [sk.Prescribed("left", (lambda x, y: y, None, None))]
    with pytest.raises(sk.InputError, match="prescribe different values"):
        sk.Problem(tube, 0.05, MATERIAL, jump).on(mesh, "kirchhoff")


@pytest.mark.parametrize("build, words", [
    (lambda: sk.Prescribed("left"), "nothing is prescribed"),
    (lambda: sk.Prescribed("left", lambda x, y: x), "must return three components"),
    (lambda: sk.Prescribed("left", lambda x, y: (None, None, None)), "nothing is prescribed"),
    (lambda: sk.Prescribed("left", (0, 0, lambda x, y: float("nan"))), "displacement.*not finite"),
    (lambda: sk.Prescribed("left", rotation=(1, 2)), "rotation = "),
    (lambda: sk.Prescribed("left", rotation=lambda x, y: (x, y)), "rotation .*three components"),
    (lambda: sk.Prescribed("left", (0, "a", 0)), "displacement"),
])  # fmt: skip
def test_mistakes(build, words):
    with pytest.raises(sk.InputError, match=words):
        sk.Problem(PLATE, 0.1, MATERIAL, [build()]).on(MESHES["uniform"]())
