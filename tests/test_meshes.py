"""Uniform and graded meshes: exact counts, exact lengths, bounded ratios, named sides."""

from itertools import pairwise, product

import numpy as np
import pytest
import skfem

from skancf.errors import InputError
from skancf.meshes import Region, check_mesh, graded, progression, tensor, uniform
from skancf.meshes.placing import largest_ratio, place
from skancf.meshes.sizes import Sizes
from skancf.surfaces import AnnulusSector, Plane, Rectangle

SQUARE = Rectangle(1.0, 1.0)
PLATE = Rectangle(3.0, 2.0, origin=(-1.0, 5.0))
QUARTER = AnnulusSector(1.0, 2.0)
# The integral of 1/h is a sum over a thousand samples, each right to 1e-16, and its inverse is as good.
ROUNDING = 1e-12


def rows(mesh):
    """Distinct node coordinates in both directions."""
    return np.unique(mesh.p[0]), np.unique(mesh.p[1])


def symmetric(x):
    return np.abs(x + x[::-1] - x[0] - x[-1]).max() < ROUNDING


# --- progression -----------------------------------------------------------------------------------------------------

LENGTHS = [
    (l_0, l_n, length)
    for l_0, l_n, length in product([0.01, 0.1, 0.3, 1.0], [0.012, 0.1, 0.5, 1.0], [0.7, 2.0, 9.3])
    if length > l_0 + l_n
]


@pytest.mark.parametrize("l_0, l_n, length", LENGTHS)
def test_progression_adds_up_and_keeps_its_ends(l_0, l_n, length):
    l = progression(l_0, l_n, length)
    n = l.size - 1
    q = l[1:] / l[:-1]
    assert abs(l.sum() / length - 1) < 1e-12
    np.testing.assert_allclose(q, q[0], rtol=1e-12)
    if l_0 != l_n:
        assert l[0] == l_0
        # n is off by at most a half. Its price, over a wide scan: below 0.9/n growing, 2.3/n shrinking.
        assert abs(np.log(l[-1] / l_n)) <= (1.0 if l_n > l_0 else 2.5) / n or n == 1


def test_progression_of_whole_n_is_exact():
    wanted = 0.1 * 1.3 ** np.arange(7)
    # The formula is then its own inverse; conditioning of q costs some digits.
    np.testing.assert_allclose(progression(0.1, wanted[-1], wanted.sum()), wanted, rtol=1e-11)
    np.testing.assert_allclose(progression(wanted[-1], 0.1, wanted.sum()), wanted[::-1], rtol=1e-11)
    # Without the correction of q the lengths would not add up: the check above has teeth.
    l_0, l_n, length = 0.1, 0.5, 2.0
    q = (length - l_0) / (length - l_n)
    n = round(np.log(l_n / l_0) / np.log(q))
    assert abs((l_0 * q ** np.arange(n + 1)).sum() - length) > 1e-3


def test_equal_lengths_are_uniform():
    np.testing.assert_allclose(progression(0.1, 0.1, 1.04), np.full(10, 0.104), rtol=1e-15)
    np.testing.assert_allclose(progression(0.1, 0.1 * (1 + 1e-14), 1.0), np.full(10, 0.1), rtol=1e-12)


@pytest.mark.parametrize(
    "values, message",
    [
        ((0.0, 0.1, 1.0), "l_0 = 0.0: .* greater than zero"),
        ((0.1, -0.1, 1.0), "l_n = -0.1"),
        ((0.1, 0.1, np.nan), "length = nan"),
        ((0.5, 0.1, 0.4), "length = 0.4: .* from l_0 = 0.5 to l_n = 0.1 .* about 0.6; make the transition longer"),
        ((0.5, 0.5, 0.6), "length = 0.6"),
        ((0.1, 0.5, 0.505), "length = 0.505"),
    ],
)
def test_progression_names_what_cannot_fit(values, message):
    with pytest.raises(InputError, match=message):
        progression(*values)


# --- uniform, tensor, sides ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", [SQUARE, PLATE, QUARTER])
def test_uniform_counts_and_sides(surface):
    mesh = uniform(surface, 5, 3)
    check_mesh(mesh)
    assert (mesh.nelements, mesh.nvertices) == (15, 24)
    assert mesh.boundaries.keys() == set(surface.sides)
    ends = [(0, 0), (0, 1), (1, 0), (1, 1)]
    for name, (direction, end) in zip(surface.sides, ends, strict=True):
        facets = mesh.boundaries[name]
        nodes = mesh.facets[:, facets]
        assert facets.size == (3 if direction == 0 else 5)
        assert (mesh.p[direction, nodes] == surface.bounds[direction][end]).all()
    # Together they are the whole boundary, each facet once.
    assert sorted(np.concatenate(list(mesh.boundaries.values()))) == sorted(mesh.boundary_facets())


def test_sides_lie_in_space_where_their_names_say():
    mesh = graded(QUARTER, [Region((1.0, 0.5), (0.1, 0.1), 9.0)], nodes=400)
    space = QUARTER.position(*mesh.p)
    # sin and cos of the angle: a rounding or two.
    for name, value in [
        ("inner", np.hypot(*space[:2]) - 1),
        ("outer", np.hypot(*space[:2]) - 2),
        ("start", space[1]),
        ("end", space[0]),
    ]:
        assert np.abs(value[mesh.facets[:, mesh.boundaries[name]]]).max() < 1e-15


@pytest.mark.parametrize("nx, message", [(0, "nx = 0: .* at least 1"), (2.0, "nx = 2.0"), ("3", "nx = '3'")])
def test_uniform_names_wrong_counts(nx, message):
    with pytest.raises(InputError, match=message):
        uniform(SQUARE, nx, 2)


@pytest.mark.parametrize(
    "x, message",
    [
        ([0, 0.5, 0.5, 1], r"x\[1\] = 0.5, x\[2\] = 0.5: node positions must increase"),
        ([0, 0.5], r"x runs from 0.0 to 0.5: it must cover the bounds \(0.0, 1.0\)"),
        ([0], "x has shape"),
        ([0, np.nan, 1], r"x\[1\].*not finite"),
    ],
)
def test_tensor_names_wrong_rows(x, message):
    with pytest.raises(InputError, match=message):
        tensor(SQUARE, x, [0, 1])


def test_a_surface_without_bounds_is_named():
    with pytest.raises(InputError, match="it has no bounds to mesh"):
        uniform(Plane(), 2, 2)


# --- check_mesh ------------------------------------------------------------------------------------------------------

P = np.array([[0.0, 1, 1, 0], [0, 0, 1, 1]])


def quad(p, order=(0, 1, 2, 3)):
    return skfem.MeshQuad(np.array(p, float), np.array(order)[:, None])


def test_both_orientations_and_mixtures_are_legal():
    check_mesh(quad(P))
    check_mesh(quad(P, (0, 3, 2, 1)))
    check_mesh(quad(P * [[1], [1e-6]]))
    two = np.array([[0.0, 1, 1, 0, 2, 2], [0, 0, 1, 1, 0, 1]])
    check_mesh(skfem.MeshQuad(two, np.array([[0, 1, 2, 3], [1, 2, 5, 4]]).T))


@pytest.mark.parametrize(
    "mesh, message",
    [
        (quad(P, (0, 1, 3, 2)), r"element 0 with corners \(0, 0\), \(1, 0\), \(0, 1\), \(1, 1\)"),
        (quad([[0, 1, 0.2, 0], [0, 0, 0.2, 1]]), "not convex"),
        (quad([[0, 1, 0.5, 0], [0, 0, 0.5, 1]]), "not convex"),
        (quad([[0, 1, 1, 0], [0, 0, 0, 0]]), "not convex"),
        (quad([[0, 1, 1, np.inf], [0, 0, 1, 1]]), "node 3 lies at"),
        (quad(np.hstack([P, [[7.0], [7.0]]])), r"1 nodes belong to no element \(first: 4\)"),
        (skfem.MeshTri(), "mesh is a MeshTri1"),
        (skfem.MeshQuad2(), "mesh is a MeshQuad2"),
        (None, "mesh is a NoneType"),
    ],
)
def test_check_mesh_names_the_fault(mesh, message):
    with pytest.raises(InputError, match=message):
        check_mesh(mesh)


# --- one direction ---------------------------------------------------------------------------------------------------


def random_sizes(rng):
    m = rng.integers(1, 5)
    centres = np.where(rng.uniform(size=m) < 0.2, 0.0, rng.uniform(0, 1, m))
    growth, transition = rng.choice([1.2, 1.5, 2.0]), rng.choice([0.0, 0.1, 0.4])
    return Sizes(0.0, 1.0, centres, rng.uniform(0.005, 0.2, m), rng.uniform(0.1, 0.9, m), growth, transition)


def test_any_number_of_cells_fits_any_regions():
    rng = np.random.default_rng(5)
    served = wanted = 0
    for _ in range(300):
        sizes, cells = random_sizes(rng), int(rng.integers(1, 60))
        x = place(sizes, cells)
        assert x.size == cells + 1
        assert (x[0], x[-1]) == (0.0, 1.0)
        assert (np.diff(x) > 0).all()
        assert abs(np.diff(x).sum() - 1) < 1e-12
        assert largest_ratio(x) <= 2 * (1 + ROUNDING)
        served, wanted = served + np.isin(sizes.centres, x).sum(), wanted + sizes.centres.size
    # Up to four centres among as few as one cell: not all can be served, most must be (0.88 over 2000 draws).
    assert 0.8 < served / wanted < 1


def test_mirrored_regions_give_mirrored_nodes():
    rng = np.random.default_rng(6)
    for cells in range(2, 60):
        s = random_sizes(rng)
        both = [
            np.concatenate([a, b])
            for a, b in [(s.centres, 1 - s.centres), (s.half_sizes, s.half_sizes), (s.fractions, s.fractions)]
        ]
        assert symmetric(place(Sizes(0.0, 1.0, *both, s.growth, s.transition), cells))
        # The check has teeth: half of the regions are not symmetric.
        assert cells < 4 or not symmetric(place(s, cells))


def test_centres_halfway_between_nodes_keep_the_symmetry():
    # Wanted lengths are uniform, so the centres fall at 2.5 and 6.5 of 9 cells, up to rounding.
    everywhere = Sizes(0.0, 1.0, np.array([2.5, 6.5]) / 9, np.ones(2), np.full(2, 0.5), 1.5)
    x = place(everywhere, 9)
    assert symmetric(x)
    assert set(everywhere.centres) <= set(x)


def test_a_weak_centre_does_not_spoil_the_cells_of_a_strong_one():
    # Between the two there is room for 1.45 wanted cells; a single one would be 1.6 times as long as its neighbour.
    x = rows(graded(SQUARE, [Region((0.5, 0.5), (0.2, 0.2), 2.0), Region((0.55, 0.5), HALF, 9.0)], coarse=0.1))[0]
    at = int(np.flatnonzero(x == 0.55)[0])
    left, right = np.diff(x)[at - 1 : at + 1]
    assert max(left, right) / min(left, right) < 1.3


def test_a_ramp_is_the_geometric_progression():
    """Cells that lie on one ramp have the lengths of eq. (7) for their first, last and total length."""
    growth = 1.3
    x = place(Sizes(0.0, 1.0, np.array([0.0]), np.array([0.1]), np.array([0.1]), growth), 30)
    l = np.diff(x)
    ratios = l[1:] / l[:-1]
    # The integral's rounding, magnified by dividing the small lengths.
    on_ramp = np.flatnonzero(np.abs(ratios - growth) < 1e-9)
    assert on_ramp.size > 4
    ramp = l[on_ramp[0] : on_ramp[-1] + 2]
    np.testing.assert_allclose(progression(ramp[0], ramp[-1], ramp.sum()), ramp, rtol=1e-9)
    # Uniform before and after, one or two cells over each bend.
    np.testing.assert_allclose(l[:3], l[0], rtol=1e-9)
    np.testing.assert_allclose(l[-3:], l[-1], rtol=1e-9)
    assert on_ramp.size < 20


# --- graded ----------------------------------------------------------------------------------------------------------

HALF = (0.05, 0.05)
PAPER = [Region((x, y), HALF, 4.0) for x in (0.0, 1.0) for y in (0.0, 1.0)] + [Region((0.5, 0.5), HALF, 9.0)]


@pytest.mark.parametrize("nodes, shape", [(4, (1, 1)), (169, (12, 12)), (168, (11, 13)), (625, (24, 24))])
def test_the_papers_plate_has_exactly_these_nodes(nodes, shape):
    mesh = graded(SQUARE, PAPER, nodes=nodes)
    check_mesh(mesh)
    x, y = rows(mesh)
    assert mesh.nvertices == nodes
    assert (x.size - 1, y.size - 1) == shape
    assert symmetric(x) and symmetric(y)
    # Symmetry wins over a node in the middle of an odd number of cells.
    assert (0.5 in x) == (shape[0] % 2 == 0)


def test_finer_near_regions():
    for mesh in (graded(SQUARE, PAPER, shape=(24, 24)), graded(SQUARE, PAPER, coarse=0.06)):
        x, l = rows(mesh)[0], np.diff(rows(mesh)[0])
        assert l[np.argmin(np.abs(x - 0.5))] < 0.5 * l.max()
        assert l[0] < 0.7 * l.max()
        # A ratio of 9 asks for finer elements than one of 4.
        assert l[np.argmin(np.abs(x - 0.5))] < 0.9 * l[0]
    assert largest_ratio(rows(uniform(SQUARE, 24, 24))[0]) < 1 + 1e-12


def test_coarse_lengths_are_met():
    one = [Region((0.3, 0.62), (0.05, 0.05), 16.0)]
    x, y = rows(graded(SQUARE, one, coarse=(0.05, 0.1)))
    for row, coarse, centre in [(x, 0.05, 0.3), (y, 0.1, 0.62)]:
        l = np.diff(row)
        assert centre in row
        # A whole number of cells on either side of the centre stretches them: half a cell in ten.
        assert abs(l.max() / coarse - 1) < 0.1
        assert abs(l.min() / (coarse / 4) - 1) < 0.1


def test_transitions_that_meet_stay_below_the_coarse_length():
    near = [Region((0.45, 0.5), (0.02, 0.02), 100.0), Region((0.55, 0.5), (0.02, 0.02), 100.0)]
    x = rows(graded(SQUARE, near, shape=(40, 10)))[0]
    between = np.diff(x[(x >= 0.45) & (x <= 0.55)])
    assert np.diff(x).min() * 1.05 < between.max() < 0.6 * np.diff(x).max()
    assert {0.45, 0.55} <= set(x)
    assert largest_ratio(x) <= 2


def test_overlapping_regions_take_the_finer_length():
    wide, strong = Region((0.5, 0.5), (0.2, 0.2), 2.0), Region((0.55, 0.5), (0.05, 0.05), 9.0)
    coarse = 0.02
    alone, both = (rows(graded(SQUARE, r, coarse=coarse))[0] for r in ([strong], [wide, strong]))
    for where, wanted_alone, wanted_both in [(0.1, 1, 1), (0.35, 1, 2**-0.5), (0.55, 1 / 3, 1 / 3)]:
        for x, wanted in ((alone, wanted_alone), (both, wanted_both)):
            length = np.diff(x)[np.searchsorted(x, where)]
            # Whole counts between the centres move lengths by some percent.
            assert abs(length / (wanted * coarse) - 1) < 0.1


def test_a_longer_transition_is_gentler():
    corner = [Region((0.0, 0.0), (0.1, 0.1), 100.0)]
    steep, gentle = (rows(graded(SQUARE, corner, shape=(30, 30), transition=t))[0] for t in (0.0, 0.8))
    assert 1.3 < largest_ratio(steep) <= 1.5 + ROUNDING
    assert largest_ratio(gentle) < 1.2


def test_regions_at_the_same_place_to_rounding_share_a_node():
    pair = [Region((0.3, 0.2), (0.05, 0.05), 4.0), Region((1 - 0.7, 0.8), (0.05, 0.05), 4.0)]
    assert pair[0].centre[0] != pair[1].centre[0]
    x = rows(graded(SQUARE, pair, shape=(20, 20)))[0]
    assert np.abs(x - 0.3).min() < 1e-15


def test_quarter_annulus_refined_at_an_angle():
    angle = np.pi / 6
    mesh = graded(QUARTER, [Region((1.0, angle), (0.05, 0.05), 16.0)], nodes=400)
    check_mesh(mesh)
    radius, angles = rows(mesh)
    assert mesh.nvertices == 400
    assert angle in angles and angle in mesh.p[1, mesh.facets[:, mesh.boundaries["inner"]]]
    assert (angles[0], angles[-1]) == QUARTER.bounds[1]
    steps = np.diff(angles)
    assert np.abs(angles[np.argmin(steps)] - angle) < 0.1
    assert steps.min() < 0.4 * steps.max()
    assert (np.diff(np.diff(radius)) > -ROUNDING).all()
    # The arc in the middle is 1.5 pi/2 = 2.36 times as long as the radius: more cells along the angle.
    assert angles.size > radius.size


def test_natural_shape_follows_lengths_in_space():
    assert rows(graded(Rectangle(2.0, 1.0), [], nodes=21 * 11))[0].size == 21
    assert rows(graded(AnnulusSector(9.5, 10.5, angle=0.1), [], nodes=121))[0].size == 11


@pytest.mark.parametrize("options", [{"nodes": 169}, {"shape": (12, 12)}, {"coarse": 1 / 12}])
def test_no_regions_give_the_uniform_mesh(options):
    assert np.array_equal(graded(SQUARE, [], **options).p, uniform(SQUARE, 12, 12).p)


def test_the_unit_of_length_does_not_matter():
    unit = 1e-6
    small = graded(Rectangle(unit, unit), [Region((0.3 * unit, 0.0), (0.1 * unit, 0.1 * unit), 9.0)], nodes=169)
    large = graded(SQUARE, [Region((0.3, 0.0), (0.1, 0.1), 9.0)], nodes=169)
    np.testing.assert_allclose(small.p / unit, large.p, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "regions, options, message",
    [
        ([], {}, "0 of nodes, shape and coarse are given"),
        ([], {"nodes": 9, "coarse": 0.1}, "2 of nodes, shape and coarse are given"),
        (PAPER, {"nodes": 170}, r"nodes = 170: .* nx : ny near 1; .* 169 or 176"),
        ([], {"nodes": 3}, "nodes = 3: .* at least 4"),
        ([], {"nodes": 5}, "nodes = 5: .* 4 or 9"),
        ([], {"shape": (3, 0)}, "ny = 0"),
        ([], {"shape": 3}, "shape = 3: give the two numbers"),
        ([], {"coarse": 0.0}, "coarse = 0.0"),
        ([], {"coarse": (1, 2, 3)}, "coarse = .* one for each direction"),
        ([], {"nodes": 9, "finest": 1.0}, "finest = 1.0: .* between 0 and 1"),
        ([], {"nodes": 9, "growth": 3.0}, "growth = 3.0: .* at most 2"),
        ([], {"nodes": 9, "transition": -1.0}, "transition = -1.0"),
        ([Region((0.5, 1.5), (1, 1), 2.0)], {"nodes": 9}, r"region centre \(0.5, 1.5\): y = 1.5 lies outside"),
    ],
)
def test_graded_names_what_is_wrong(regions, options, message):
    with pytest.raises(InputError, match=message):
        graded(SQUARE, regions, **options)


@pytest.mark.parametrize(
    "values, message",
    [
        (((0, 0, 0), (1, 1), 2.0), "centre"),
        (((0, np.nan), (1, 1), 2.0), "centre"),
        (((0, 0), (1, 0), 2.0), "half_size = .*greater than zero"),
        (((0, 0), (1, 1), 1.0), "ratio = 1.0: .* leave the region out"),
        (((0, 0), (1, 1), 2.0, np.inf), "value"),
    ],
)
def test_region_names_what_is_wrong(values, message):
    with pytest.raises(InputError, match=message):
        Region(*values)


def test_lengths_fall_monotonically_to_a_corner():
    l = np.diff(rows(graded(SQUARE, [Region((1.0, 0.0), (0.05, 0.05), 50.0)], nodes=289))[0])
    assert all(b <= a * (1 + 1e-9) for a, b in pairwise(l))
    assert l[-1] < 0.3 * l[0]
