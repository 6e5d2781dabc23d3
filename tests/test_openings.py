"""Openings of a mesh: what is removed, what stays, and what the edges are called."""

import math

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.errors import InputError
from skancf.meshes import check_mesh, tensor, uniform

SQUARE = sk.Rectangle(1.0, 1.0)
L_SHAPE = sk.Rectangle(2.0, 2.0, origin=(-1.0, -1.0))


def edges(mesh, name):
    """Ends of the edges of a boundary, as a set of pairs of points."""
    return {frozenset(map(tuple, mesh.p[:, ends].T.tolist())) for ends in mesh.facets[:, mesh.boundaries[name]].T}


def middles(mesh, name):
    return mesh.p[:, mesh.facets[:, mesh.boundaries[name]]].mean(axis=1)


def is_whole_boundary(mesh):
    return sorted(np.concatenate(list(mesh.boundaries.values()))) == sorted(mesh.boundary_facets())


def test_a_hole_inside():
    whole, mesh = uniform(SQUARE, 4, 4), uniform(SQUARE, 4, 4, openings=[((0.25, 0.75), (0.5, 0.75))])
    check_mesh(mesh)
    assert (mesh.nelements, mesh.nvertices) == (14, 25)
    assert edges(mesh, "opening") == {
        frozenset(pair)
        for pair in [((0.25, 0.5), (0.5, 0.5)), ((0.5, 0.5), (0.75, 0.5)), ((0.25, 0.75), (0.5, 0.75)),
                     ((0.5, 0.75), (0.75, 0.75)), ((0.25, 0.5), (0.25, 0.75)), ((0.75, 0.5), (0.75, 0.75))]
    }  # fmt: skip
    for side in SQUARE.sides:
        assert edges(mesh, side) == edges(whole, side)
    assert is_whole_boundary(mesh)


def test_a_larger_hole_has_no_nodes_inside():
    mesh = uniform(SQUARE, 8, 8, openings=[((0.25, 0.75), (0.25, 0.75))])
    check_mesh(mesh)
    assert (mesh.nelements, mesh.nvertices) == (48, 81 - 9)
    assert mesh.boundaries["opening"].size == 16


def test_elements_keep_their_order_and_corners():
    rows = np.array([0, 0.1, 0.4, 0.7, 1.0]), np.array([0, 0.3, 0.5, 1.0])
    whole, mesh = tensor(SQUARE, *rows), tensor(SQUARE, *rows, openings=[((0.1, 0.7), (0.3, 0.5))])
    x, y = whole.p[:, whole.t].mean(axis=1)
    kept = ~((x > 0.1) & (x < 0.7) & (y > 0.3) & (y < 0.5))
    assert kept.sum() == 10
    assert np.array_equal(mesh.p[:, mesh.t], whole.p[:, whole.t[:, kept]])


def test_an_opening_at_a_corner_makes_an_l():
    mesh = uniform(L_SHAPE, 4, 4, openings=[((0.0, 1.0), (0.0, 1.0))])
    check_mesh(mesh)
    assert (mesh.nelements, mesh.nvertices) == (12, 21)
    x, y = middles(mesh, "right")
    assert (x == 1).all() and sorted(y) == [-0.75, -0.25]
    x, y = middles(mesh, "top")
    assert (y == 1).all() and sorted(x) == [-0.75, -0.25]
    assert sorted(map(tuple, middles(mesh, "opening").T)) == [(0.0, 0.25), (0.0, 0.75), (0.25, 0.0), (0.75, 0.0)]
    assert is_whole_boundary(mesh)


def test_a_side_of_which_nothing_is_left_has_no_name():
    mesh = uniform(SQUARE, 4, 4, openings=[((0.0, 0.25), (0.0, 1.0))])
    assert mesh.boundaries.keys() == {"right", "bottom", "top", "opening"}
    assert (middles(mesh, "opening")[0] == 0.25).all()
    assert is_whole_boundary(mesh)


def test_openings_may_overlap_and_touch_along_edges():
    cross = [((0.25, 0.75), (0.375, 0.625)), ((0.375, 0.625), (0.25, 0.75))]
    mesh = uniform(SQUARE, 8, 8, openings=cross)
    assert mesh.nelements == 64 - 12
    assert mesh.boundaries["opening"].size == 16
    halves = [((0.25, 0.5), (0.25, 0.75)), ((0.5, 0.75), (0.25, 0.75))]
    assert np.array_equal(uniform(SQUARE, 8, 8, halves).t, uniform(SQUARE, 8, 8, [((0.25, 0.75), (0.25, 0.75))]).t)


@pytest.mark.parametrize("seed", range(8))
def test_names_against_a_plain_search(seed):
    """Random holes: every boundary edge is named after the side it lies on, or else "opening"."""
    rng = np.random.default_rng(seed)
    rows = [np.sort(np.concatenate([[0, 1], rng.uniform(0.01, 0.99, 7)])) for _ in "xy"]
    i, j = rng.integers(0, 5, 2)
    opening = (tuple(rows[0][[i, i + 3]]), tuple(rows[1][[j, j + 2]]))
    mesh = tensor(SQUARE, *rows, openings=[opening])
    named = {int(f): name for name, facets in mesh.boundaries.items() for f in facets}
    count = np.bincount(np.concatenate(mesh.t2f))
    assert set(named) == set(np.flatnonzero(count == 1).tolist())
    for facet, name in named.items():
        x, y = mesh.p[:, mesh.facets[:, facet]]
        sides = {"left": (x == 0).all(), "right": (x == 1).all(), "bottom": (y == 0).all(), "top": (y == 1).all()}
        assert name == next((side for side, on in sides.items() if on), "opening")


def test_sides_to_rounding_are_on_mesh_lines():
    third = [((0.1 + 0.2, 0.6), (1 - 0.9, 0.9))]
    assert 0.1 + 0.2 != 0.3
    assert uniform(SQUARE, 10, 10, third).nelements == 100 - 24


def test_the_unit_of_length_does_not_matter():
    small = uniform(sk.Rectangle(1e-6, 1e-6), 4, 4, [((2.5e-7, 5e-7), (2.5e-7, 5e-7))])
    assert small.nelements == 15
    assert uniform(sk.Rectangle(1e6, 1e6), 4, 4, [((2.5e5, 5e5), (2.5e5, 5e5))]).nelements == 15


@pytest.mark.parametrize(
    "openings, message",
    [
        ([((0.25, 0.6), (0.25, 0.5))], r"openings\[0\]: its side x = 0.6 is on no mesh line, .* x = 0.5 and 0.75; move"),
        ([((0.25, 0.5), (0.3, 0.5))], r"openings\[0\]: its side y = 0.3 is on no mesh line, .* y = 0.25 and 0.5"),
        ([((0.0, 0.25), (0, 0.25)), ((0.5, 1.5), (0, 1))], r"openings\[1\]: its side x = 1.5 is outside the bounds"),
        ([((0.5, 0.25), (0, 1))], r"openings\[0\]: x from 0.5 to 0.25 covers no element"),
        ([((0.5, 0.5 + 1e-12), (0, 1))], r"covers no element"),
        ([((0, 1), (0, 1))], "nothing is left"),
        ([((0, 0.5), (0, 1)), ((0.5, 1), (0, 1))], "nothing is left"),
        (((0.25, 0.5), (0.25, 0.5)), r"openings of shape \(2, 2\): give a list of rectangles"),
        ([((0.25, np.nan), (0.25, 0.5))], "openings.*not finite"),
        ([0.5], r"openings of shape \(1,\)"),
        ([((0.25, 0.5), (0.25, 0.5)), ((0.5, 0.75), (0.5, 0.75))], r"at node 12, \(0.5, 0.5\), by that node only"),
        ([((0, 0.5), (0.5, 1)), ((0.5, 1), (0, 0.5))], r"\(0.5, 0.5\), by that node only, which is a hinge; join"),
    ],
)
def test_openings_that_cannot_be_cut(openings, message):
    with pytest.raises(InputError, match=message):
        uniform(SQUARE, 4, 4, openings)


def test_no_openings_are_the_whole_mesh():
    for none in ([], (), np.empty((0, 2, 2))):
        mesh = uniform(SQUARE, 3, 3, openings=none)
        assert mesh.nelements == 9 and "opening" not in mesh.boundaries


def tube():
    return sk.CylinderSector(1.0, 2.0, 2 * math.pi, closed=True)


def test_openings_of_a_tube():
    mesh = uniform(tube(), 4, 8, openings=[((0.5, 1.5), (math.pi / 2, math.pi))])
    assert mesh.boundaries.keys() == {"left", "right", "opening"}
    assert mesh.boundaries["opening"].size == 8
    ends = [((0.5, 1.5), (0.0, math.pi / 4)), ((0.5, 1.5), (7 * math.pi / 4, 2 * math.pi))]
    mesh = uniform(tube(), 4, 8, openings=ends)
    # Two elements each; the seam between them is no edge any more.
    assert mesh.boundaries["opening"].size == 8
    steel = sk.Isotropic(2e11, 0.3, 7800.0)
    geometry = sk.Problem(tube(), 0.01, steel).on(mesh, "kirchhoff").geometry
    assert set(geometry.facets_on("boundary")) == set(mesh.boundaries["left"]) | set(mesh.boundaries["right"])
    assert set(geometry.facets_on("openings")) == set(geometry.facets_on("opening 1")) == set(mesh.boundaries["opening"])
    with pytest.raises(InputError, match=r"at the seam y = 0.0, which is y = 6.28.* near x = 0.75; cut on both"):
        uniform(tube(), 4, 8, openings=ends[:1])


def test_a_side_called_opening_is_in_the_way():
    class Door(sk.Rectangle):
        sides = ("opening", "right", "bottom", "top")

    with pytest.raises(InputError, match="the surface has a side 'opening'"):
        uniform(Door(1.0, 1.0), 2, 2, openings=[((0.0, 0.5), (0.0, 0.5))])
    assert "opening" in uniform(Door(1.0, 1.0), 2, 2).boundaries


def test_a_plate_with_a_hole_is_softer_and_its_edge_can_be_clamped():
    steel = sk.Isotropic(2e11, 0.3, 7800.0)

    def middle_of_an_edge(openings, supports):
        plate = sk.Problem(SQUARE, 0.01, steel, supports, [sk.PointForce((0.5, 0.0), (0.0, 0.0, -10.0))])
        solution = sk.solve_linear(plate.on(uniform(SQUARE, 8, 8, openings), "kirchhoff"))
        return -float(solution.displacement((0.5, 0.0))[2])

    hole = [((0.25, 0.75), (0.25, 0.75))]
    sides = [sk.Clamp("left"), sk.Clamp("right")]
    whole, open_ = (middle_of_an_edge(openings, sides) for openings in ([], hole))
    held = middle_of_an_edge(hole, [*sides, sk.Clamp("opening")])
    assert held < 0.5 * whole < whole < 0.95 * open_


def test_the_boundary_is_the_outer_one():
    """Of a plate with two holes and a notch, which is no hole; on a quadtree too."""
    plate, steel = sk.Rectangle(1.2, 0.8), sk.Isotropic(2e11, 0.3, 7800.0)
    holes = [((0.2, 0.4), (0.2, 0.4)), ((0.7, 0.9), (0.4, 0.6)), ((1.1, 1.2), (0.3, 0.5))]
    mesh = uniform(plate, 12, 8, openings=holes)
    for tried in (mesh, sk.meshes.quadtree(mesh, plate).refined([13, 40])):
        geometry = sk.Problem(plate, 0.01, steel).on(tried, "kirchhoff").geometry

        def length(name, geometry=geometry):
            ends = geometry.mesh.p[:, geometry.mesh.facets[:, geometry.facets_on(name)]]
            return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0).sum()

        lengths = {"boundary": 4.2, "openings": 1.6, "opening 1": 0.8, "opening 2": 0.8}
        assert {name: length(name) for name in lengths} == pytest.approx(lengths)
        assert geometry.mesh.p[0, geometry.mesh.facets[:, geometry.facets_on("opening 1")]].max() == pytest.approx(0.4)
        assert {"openings", "opening 2"} <= set(geometry.names())
    with pytest.raises(InputError, match="no boundary 'opening 3'"):
        geometry.facets_on("opening 3")
    whole = sk.Problem(plate, 0.01, steel).on(uniform(plate, 2, 2), "kirchhoff").geometry
    with pytest.raises(InputError, match=r"'openings'.*has none"):
        whole.facets_on("openings")


def test_a_mesh_of_any_shape_has_an_outline():
    """Quads around a hole, in the plane, that the library did not make."""
    angles, radii = np.linspace(0, 2 * np.pi, 17)[:-1], [0.5, 1.0]
    p = np.concatenate([r * np.stack([np.cos(angles), np.sin(angles)]) for r in radii], axis=1)
    k = np.arange(16)
    mesh = skfem.MeshQuad(p, np.stack([k, k + 16, (k + 1) % 16 + 16, (k + 1) % 16]), sort_t=False)
    geometry = sk.Problem(sk.Plane(), 0.01, sk.Isotropic(2e11, 0.3, 7800.0)).on(mesh, "full").geometry
    assert np.allclose(np.linalg.norm(geometry.points[:, geometry.nodes_on("boundary")], axis=0), 1.0)
    assert np.allclose(np.linalg.norm(geometry.points[:, geometry.nodes_on("openings")], axis=0), 0.5)
