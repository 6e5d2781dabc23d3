"""Quadtree meshes: balance, hanging nodes, facets and names after any change, against searches by geometry; and files."""

import io
import os
import pickle
import zipfile
from itertools import product
from math import pi

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.errors import InputError
from skancf.meshes import check_mesh, load, quadtree, save, tensor, uniform
from skancf.meshes.forest import DEEPEST

SQUARE = sk.Rectangle(1.0, 1.0)
TUBE = sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True)
RING = sk.AnnulusSector(0.5, 1.0, 2 * pi, closed=True)
TORUS = sk.MappedSurface(
    lambda x, y: ((1 + 0.4 * np.cos(x)) * np.cos(y), (1 + 0.4 * np.cos(x)) * np.sin(y), 0.4 * np.sin(x)),
    ((0.0, 2 * pi), (0.0, 2 * pi)), closed=(True, True),
)  # fmt: skip
# Coordinates are sums of two products: a few units in the last place.
ROUNDING = 1e-14


def make(name):
    """A coarse mesh as a tree, and the periods of its parameters, 0 for none."""
    if name == "rectangle":
        return quadtree(uniform(SQUARE, 2, 3)), (0.0, 0.0)
    if name == "L-shape":
        return quadtree(uniform(SQUARE, 4, 4, openings=[((0.5, 1.0), (0.5, 1.0))])), (0.0, 0.0)
    if name == "hole":
        return quadtree(uniform(SQUARE, 3, 3, openings=[((1 / 3, 2 / 3), (1 / 3, 2 / 3))])), (0.0, 0.0)
    if name == "tensor":
        return quadtree(tensor(SQUARE, [0, 0.1, 0.37, 1], [0, 0.7, 0.8, 1])), (0.0, 0.0)
    if name == "torus":
        return quadtree(uniform(TORUS, 2, 3), TORUS), (2 * pi, 2 * pi)
    surface = {"tube": TUBE, "ring": RING}[name]
    return quadtree(uniform(surface, 2, 3), surface), (0.0, 2 * pi)


KINDS = ["rectangle", "L-shape", "hole", "tensor", "tube", "ring", "torus"]
kinds = pytest.mark.parametrize("kind", KINDS)


def boxes(mesh):
    corner = mesh.p[:, mesh.t]
    return corner.min(axis=1), corner.max(axis=1)


def shifts(periods):
    return np.array(list(product(*[(0.0,) if not period else (-period, 0.0, period) for period in periods])))


def check_balance(mesh, periods):
    """No two elements that touch, at a corner or across a seam, differ by more than one level."""
    low, high = boxes(mesh)
    slack = ROUNDING * np.ptp(mesh.p)
    for shift in shifts(periods):
        moved = [bound + shift[:, None] for bound in (low, high)]
        touch = (low[:, :, None] <= moved[1][:, None] + slack) & (high[:, :, None] >= moved[0][:, None] - slack)
        touch = touch.all(axis=0)
        assert (np.abs(mesh.levels[:, None] - mesh.levels)[touch] <= 1).all()


def check_tiling(mesh, coarse):
    """Each element is its part of one coarse element, and together they have the area."""
    low, high = boxes(mesh)
    corner = coarse.p[:, coarse.t]
    middle, (below, above) = (low + high) / 2, (corner.min(axis=1), corner.max(axis=1))
    inside = ((middle[:, :, None] > below[:, None]) & (middle[:, :, None] < above[:, None])).all(axis=0)
    assert (inside.sum(axis=1) == 1).all()
    root = inside.argmax(axis=1)
    size = np.ptp(mesh.p)
    assert np.abs((high - low) - (above - below)[:, root] / 2.0**mesh.levels).max() < ROUNDING * size
    whole = np.bincount(root, 0.25**mesh.levels)
    assert (whole == 1).all()
    # Disjoint: no middle is in another one.
    in_other = ((middle[:, :, None] > low[:, None]) & (middle[:, :, None] < high[:, None])).all(axis=0)
    assert (in_other.sum(axis=1) == 1).all()


def check_nodes(mesh, periods):
    """Nodes are unique, hanging are those strictly inside an element's edge, in the middle of their ends."""
    check_mesh(mesh)
    size, p = np.ptp(mesh.p), mesh.p
    apart = np.abs(p[:, :, None] - p[:, None]).max(axis=0) + np.eye(p.shape[1]) * size
    assert apart.min() > 1e-6 * size
    low, high = boxes(mesh)
    slack, found = 1e-9 * size, np.zeros(p.shape[1], dtype=bool)
    for shift in shifts(periods):
        a, b = low + shift[:, None], high + shift[:, None]
        at, within = np.abs(p[:, :, None] - a[:, None]) < slack, (p[:, :, None] > a[:, None] + slack)
        at |= np.abs(p[:, :, None] - b[:, None]) < slack
        within &= p[:, :, None] < b[:, None] - slack
        found |= ((at[0] & within[1]) | (at[1] & within[0])).any(axis=1)
    assert np.array_equal(mesh.hanging, np.flatnonzero(found))
    ends = mesh.p[:, mesh.hanging_ends]
    assert np.abs(ends.mean(axis=1) - p[:, mesh.hanging]).max(initial=0.0) < ROUNDING * size
    assert not np.isin(mesh.hanging_ends, mesh.hanging).any()
    # Two elements have each of them as a corner, and the sides along the edge reach from end to end.
    assert (np.bincount(mesh.t.ravel(), minlength=p.shape[1])[mesh.hanging] == 2).all()


def facet_table(mesh):
    """For each facet the elements on whose border it lies as a whole, and whether it is divided: by geometry."""
    low, high = boxes(mesh)
    ends, slack = mesh.p[:, mesh.facets], 1e-9 * np.ptp(mesh.p)
    middle = ends.mean(axis=1)[:, :, None]
    a, b = low[:, None], high[:, None]
    at = (np.abs(middle - a) < slack) | (np.abs(middle - b) < slack)
    within = (middle > a + slack) & (middle < b - slack)
    lengths = np.abs(ends[:, 1] - ends[:, 0])
    vertical = lengths[0] < lengths[1]
    side = np.where(vertical[:, None], high[1] - low[1], high[0] - low[0])
    beside = np.where(vertical[:, None], at[0] & within[1], at[1] & within[0])
    fits = lengths.max(axis=0)[:, None] <= side + slack
    # The middle of a divided edge is a node, so that its small neighbours are found by a point a quarter along.
    quarter = (0.75 * ends[:, 0] + 0.25 * ends[:, 1])[:, :, None]
    inside = (quarter > a + slack) & (quarter < b - slack)
    smaller = np.where(vertical[:, None], at[0] & inside[1], at[1] & inside[0]) & ~fits
    return beside & fits, smaller.any(axis=1)


def check_facets(mesh):
    """f2t, boundary, interior: halves of divided edges have two elements, the whole has one and is no boundary."""
    beside, divided = facet_table(mesh)
    n = beside.sum(axis=1)
    assert ((n == 1) | (n == 2)).all() and (n[divided] == 1).all()
    assert mesh.f2t.shape[1] == (~divided).sum() and divided[mesh.f2t.shape[1] :].all()
    for facet, (one, two) in enumerate(mesh.f2t.T):
        assert {one, two} - {-1} == set(np.flatnonzero(beside[facet]))
    boundary = (n == 1) & ~divided
    assert np.array_equal(mesh.boundary_facets(), np.flatnonzero(boundary))
    assert np.array_equal(skfem.InteriorFacetBasis(mesh, skfem.ElementQuad1()).find, np.flatnonzero(n == 2))
    nodes = np.unique(mesh.facets[:, boundary])
    assert np.array_equal(mesh.boundary_nodes(), nodes)
    assert np.array_equal(mesh.interior_nodes(), np.setdiff1d(np.arange(mesh.p.shape[1]), nodes))
    # Each element has each of its sides once.
    assert np.array_equal(np.sort(mesh.facets[:, mesh.t2f], axis=0), np.sort(
        np.stack([mesh.t, np.roll(mesh.t, -1, axis=0)]), axis=0))  # fmt: skip


def check(mesh, coarse, periods):
    check_balance(mesh, periods)
    check_tiling(mesh, coarse)
    check_nodes(mesh, periods)
    check_facets(mesh)
    n = coarse.p.shape[1]
    assert np.array_equal(mesh.p[:, :n], coarse.p), "coarse nodes keep their number"


def walk(mesh, rng, steps=6, most=120):
    """Meshes of a random sequence of changes."""
    for k in range(steps):
        some = rng.permutation(mesh.nelements)
        few, many = some[: rng.integers(1, 4)], some[: (3 * len(some)) // 4]
        change = ("refined", "refined", "coarsened", "adapted")[k % 4 if k < 2 else rng.integers(4)]
        if change == "refined" and mesh.nelements < most:
            mesh = mesh.refined(few)
        elif change == "adapted":
            mesh = mesh.adapted(few, many)
        else:
            mesh = mesh.coarsened(many)
        yield mesh


def length(mesh, facets):
    return np.linalg.norm(np.diff(mesh.p[:, mesh.facets[:, facets]], axis=1)[:, 0], axis=0).sum()


@kinds
@pytest.mark.parametrize("seed", range(3))
def test_random_changes(kind, seed):
    coarse, periods = make(kind)
    rng, most = np.random.default_rng(seed), 0
    perimeter = length(coarse, coarse.boundary_facets())
    lengths = {name: length(coarse, facets) for name, facets in (coarse.boundaries or {}).items()}
    for mesh in walk(coarse, rng):
        check(mesh, coarse, periods)
        most = max(most, len(mesh.hanging))
        assert np.isclose(length(mesh, mesh.boundary_facets()), perimeter, rtol=ROUNDING)
        found = mesh.boundaries or {}
        assert found.keys() == lengths.keys()
        for name, facets in found.items():
            assert np.isclose(length(mesh, facets), lengths[name], rtol=ROUNDING) and np.isin(
                facets, mesh.boundary_facets()).all()  # fmt: skip
    assert most > 3, "no hanging nodes came up"


@pytest.mark.parametrize("kind", ["tube", "torus"])
def test_balance_needs_the_seam(kind):
    """Without the surface the tree knows of no seam, and a corner at it is refined alone."""
    coarse, periods = make(kind)
    alone, tied = quadtree(coarse.plain()), coarse
    for _ in range(3):
        alone, tied = (m.refined(m.element_finder()(np.array([1e-9]), np.array([1e-9]))) for m in (alone, tied))
    check(tied, coarse, periods)
    check(alone, coarse, (0.0, 0.0))
    with pytest.raises(AssertionError):
        check_balance(alone, periods)


def test_balance_around_an_inner_corner():
    coarse, periods = make("L-shape")
    mesh = coarse
    for _ in range(4):
        mesh = mesh.refined(mesh.element_finder()(np.array([0.5 - 1e-6]), np.array([0.5 - 1e-6])))
    check(mesh, coarse, periods)
    # Those across the corner follow with one level less, to an eighth of their edges.
    assert len(mesh.boundaries["opening"]) == 2 * (1 + 4)


@kinds
def test_scikit_fem_sees_each_interior_edge_once(kind):
    coarse, _ = make(kind)
    *_, mesh = walk(coarse, np.random.default_rng(1))
    mesh = mesh.refined([0])
    assert len(mesh.hanging)
    linear = skfem.Basis(mesh, skfem.ElementQuad1())
    beside, divided = facet_table(mesh)
    inner = length(mesh, np.flatnonzero(beside.sum(axis=1) == 2))
    x = 2.0 + 3 * mesh.p[0] - 5 * mesh.p[1]
    sides = [skfem.InteriorFacetBasis(mesh, skfem.ElementQuad1(), side=side) for side in (0, 1)]
    for basis in sides:
        assert np.isclose(basis.dx.sum(), inner, rtol=1e-12)
    one, two = (basis.interpolate(x) for basis in sides)
    scale = np.abs(x).max()
    assert np.abs(one - two).max() < 1e-12 * scale and np.abs(one.grad - two.grad).max() < 1e-11 * scale
    assert np.abs(sides[0].global_coordinates() - sides[1].global_coordinates()).max() < 1e-12 * np.ptp(mesh.p)
    outer = skfem.FacetBasis(mesh, skfem.ElementQuad1())
    assert np.isclose(outer.dx.sum(), length(coarse, coarse.boundary_facets()), rtol=1e-12)
    assert np.isclose(linear.dx.sum(), np.prod(np.subtract(*boxes(coarse)), axis=0).sum(), rtol=1e-12)
    wanted = np.unique(mesh.facets[:, (beside.sum(axis=1) == 1) & ~divided])
    if wanted.size:
        assert np.array_equal(np.sort(linear.get_dofs().all()), wanted)
    # The broken jump of a field that is not continuous there shows: the plain mesh takes divided edges for a boundary.
    plain = mesh.plain()
    assert length(plain, plain.boundary_facets()) > length(mesh, mesh.boundary_facets()) + 1e-3


def test_a_torn_mesh_is_refused():
    tree = quadtree(uniform(sk.Rectangle(1.0, 1.0), 4, 4)).refined([0, 5])
    with pytest.raises(InputError, match=r"node \d+ at .* would be torn there"):
        sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, sk.Isotropic(1.0, 0.3, 1.0)).on(tree.plain(), "kirchhoff")


def test_a_tree_fits_its_surface():
    tube = sk.CylinderSector(1.0, 1.0, 2 * np.pi, closed=True)
    bare = quadtree(uniform(tube, 2, 4))
    with pytest.raises(InputError, match=r"quadtree\(coarse mesh, surface\)"):
        quadtree(bare, tube)
    assert quadtree(bare) is bare


def test_jumps_of_a_field_with_a_free_hanging_node_show():
    mesh = make("rectangle")[0].refined([0])
    u = np.zeros(mesh.p.shape[1])
    u[mesh.hanging[0]] = 1.0
    one, two = (skfem.InteriorFacetBasis(mesh, skfem.ElementQuad1(), side=side).interpolate(u) for side in (0, 1))
    assert np.abs(one - two).max() > 0.5


def test_elements_are_found():
    coarse, _ = make("L-shape")
    *_, mesh = walk(coarse, np.random.default_rng(3))
    low, high = boxes(mesh)
    s = np.random.default_rng(0).uniform(size=low.shape)
    x, y = low + s * (high - low)
    assert np.array_equal(mesh.element_finder()(x, y), np.arange(mesh.nelements))
    for node in mesh.p.T:
        element = int(mesh.element_finder()(*node[:, None])[0])
        assert (low[:, element] <= node + 1e-15).all() and (high[:, element] >= node - 1e-15).all()
    with pytest.raises(ValueError, match="outside"):
        mesh.element_finder()(np.array([0.75]), np.array([0.75]))


# --- names -----------------------------------------------------------------------------------------------------------


def on_segment(mesh, start, end):
    """Facets, but no whole divided edges, that lie on a segment along x or y."""
    ends, slack = mesh.p[:, mesh.facets], 1e-9
    low, high = np.minimum(start, end)[:, None, None], np.maximum(start, end)[:, None, None]
    within = ((ends >= low - slack) & (ends <= high + slack)).all(axis=(0, 1))
    return np.setdiff1d(np.flatnonzero(within), mesh.divided[1])


SEGMENTS = {
    "left": ((0.0, 0.0), (0.0, 1.0)),
    "some of left": ((0.0, 0.0), (0.0, 0.5)),
    "a quarter of the bottom": ((0.5, 0.0), (0.75, 0.0)),
    "line": ((0.5, 0.0), (0.5, 1.0)),
    "short line": ((0.0, 0.5), (0.25, 0.5)),
}
PARTS = {"patch": ((0.0, 0.0), (0.25, 0.5)), "half": ((0.5, 0.0), (1.0, 1.0))}


def in_part(mesh, low, high):
    middle = mesh.p[:, mesh.t].mean(axis=1)
    return np.flatnonzero(((middle > np.array(low)[:, None]) & (middle < np.array(high)[:, None])).all(axis=0))


def named():
    """Names that end inside coarse edges and elements, given on a refined tree."""
    mesh = quadtree(uniform(SQUARE, 2, 2)).refined(1)
    names = {name: on_segment(mesh, *segment) for name, segment in SEGMENTS.items()}
    return mesh.with_boundaries(names).with_subdomains({name: in_part(mesh, *part) for name, part in PARTS.items()})


def check_names(mesh):
    for name, segment in SEGMENTS.items():
        assert np.array_equal(np.sort(mesh.boundaries[name]), on_segment(mesh, *segment)), name
        assert np.isclose(length(mesh, mesh.boundaries[name]), np.abs(np.subtract(*segment)).sum(), rtol=1e-13), name
    low, high = boxes(mesh)
    areas = np.prod(high - low, axis=0)
    for name, part in PARTS.items():
        assert np.array_equal(np.sort(mesh.subdomains[name]), in_part(mesh, *part)), name
        assert np.isclose(areas[mesh.subdomains[name]].sum(), np.prod(np.subtract(*part)), rtol=1e-13), name


@pytest.mark.parametrize("seed", range(6))
def test_names_stay_exact(seed):
    check_names(named())
    levels = set()
    for mesh in walk(named(), np.random.default_rng(seed), 8):
        check_names(mesh)
        levels |= set(mesh.levels)
    assert max(levels) > 2


def test_coarsening_does_not_merge_across_names():
    """Roots whose halves have different names stay split; the others come back."""
    mesh = named().refined([0, 5, 9])
    for _ in range(4):
        mesh = mesh.coarsened(np.arange(mesh.nelements))
        check_names(mesh)
    # "patch" and "a quarter of the bottom" need the two lower roots, "short line" is a side of the upper left one's.
    middles = mesh.p[:, mesh.t].mean(axis=1)
    assert mesh.nelements == 13 and ((middles[1] > 0.5) & (middles[0] > 0.5)).sum() == 1


def test_a_name_of_either_kind_keeps_a_family():
    mesh = quadtree(uniform(SQUARE, 1, 1)).refined(1)
    everything = np.arange(4)
    assert mesh.coarsened(everything).nelements == 1
    for one in (mesh.with_subdomains({"one": np.array([2])}), mesh.with_boundaries({"half": mesh.boundaries["left"][:1]}),
                mesh.with_boundaries({"inside": on_segment(mesh, (0.5, 0.0), (0.5, 0.5))})):  # fmt: skip
        assert one.coarsened(everything) is one
    whole = mesh.with_subdomains({"all": everything}).coarsened(everything)
    assert whole.nelements == 1 and np.array_equal(whole.subdomains["all"], [0])


def test_a_named_line_between_elements_does_not_keep_them_small():
    """Both sides of a line are coarsened together, also where one is smaller."""
    mesh = quadtree(uniform(SQUARE, 2, 1)).refined(1)
    mesh = mesh.with_boundaries({"line": on_segment(mesh, (0.5, 0.0), (0.5, 1.0))})
    at_line = mesh.element_finder()(np.array([0.49]), np.array([0.1]))
    fine = mesh.refined(at_line)
    assert len(fine.boundaries["line"]) == 3
    back = fine.coarsened(np.arange(fine.nelements))
    plain = quadtree(uniform(SQUARE, 2, 1)).refined(1).refined(at_line)
    assert np.array_equal(back.p, plain.coarsened(np.arange(plain.nelements)).p)
    assert np.isclose(length(back, back.boundaries["line"]), 1.0)


def test_with_boundaries_by_function_takes_no_divided_edge():
    mesh = quadtree(uniform(SQUARE, 2, 2)).refined([0])
    line = mesh.with_boundaries({"line": lambda x: x[0] == 0.5}, boundaries_only=False)
    assert np.isclose(length(line, line.boundaries["line"]), 1.0) and len(line.boundaries["line"]) == 3
    mesh = mesh.with_boundaries({"all": lambda x: x[0] < 2})
    assert np.array_equal(np.sort(mesh.boundaries["all"]), mesh.boundary_facets())
    finer = mesh.refined([3, 4])
    assert np.array_equal(np.sort(finer.boundaries["all"]), finer.boundary_facets())
    assert finer.boundaries.keys() == {"left", "right", "bottom", "top", "all"}


# --- back and forth ----------------------------------------------------------------------------------------------------


@kinds
def test_refine_then_coarsen_is_the_same_mesh(kind):
    coarse, _ = make(kind)
    *_, mesh = walk(coarse, np.random.default_rng(5), 4)
    fine = mesh.refined(1)
    back = fine.coarsened(np.arange(fine.nelements))
    assert fine.nelements == 4 * mesh.nelements
    assert np.array_equal(back.p, mesh.p) and np.array_equal(back.t, mesh.t)
    for name, facets in (mesh.boundaries or {}).items():
        assert np.array_equal(back.boundaries[name], facets)
    while len(back.leaves) > coarse.nelements:
        smaller = back.coarsened(np.arange(back.nelements))
        assert smaller.nelements < back.nelements
        back = smaller
    assert np.array_equal(back.p, coarse.p) and np.array_equal(back.t, coarse.t)


def test_nothing_to_do_is_the_mesh_itself():
    mesh = make("rectangle")[0].refined([1])
    assert mesh.refined([]) is mesh and mesh.coarsened([]) is mesh and mesh.adapted([], []) is mesh
    assert mesh.coarsened([0]) is mesh, "one sister alone"
    assert mesh.refined(np.zeros(mesh.nelements, dtype=bool)) is mesh


def test_a_mask_is_as_good_as_numbers():
    mesh = make("rectangle")[0]
    mask = np.arange(mesh.nelements) == 4
    assert np.array_equal(mesh.refined(mask).p, mesh.refined([4]).p)


def test_a_smaller_neighbour_blocks_coarsening():
    mesh = quadtree(uniform(SQUARE, 2, 1)).refined(1)
    middles = mesh.p[:, mesh.t].mean(axis=1)
    at_middle = np.flatnonzero(np.isclose(middles[0], 0.375) & np.isclose(middles[1], 0.25))
    mesh = mesh.refined(at_middle)
    right = np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) > 0.5)
    assert len(right) == 4 and mesh.coarsened(right) is mesh
    # With the small ones merged too, there is room: twice, since the larger ones wait for them.
    once = mesh.coarsened(np.arange(mesh.nelements))
    assert once.nelements == 5 and sorted(once.levels) == [0, 1, 1, 1, 1]


def test_adapted_refines_and_coarsens():
    mesh = quadtree(uniform(SQUARE, 4, 1)).refined([0, 3])
    middles = mesh.p[:, mesh.t].mean(axis=1)
    first, last = np.flatnonzero(middles[0] < 0.25), np.flatnonzero(middles[0] > 0.75)
    changed = mesh.adapted(first[:1], last)
    assert changed.nelements == 3 + 4 + 3 and changed.levels.max() == 2
    assert np.array_equal(mesh.adapted(first[:1], np.concatenate([first, last])).p, changed.p), "refinement comes first"
    assert np.array_equal(mesh.adapted([], last).p, mesh.coarsened(last).p)


# --- what is refused -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("numbers", [[6], [-1], [0.5], [0, 100], [True, False], np.array([[7]])])
@pytest.mark.parametrize("method", ["refined", "coarsened", "adapted"])
def test_bad_element_numbers(numbers, method):
    mesh = make("rectangle")[0]
    with pytest.raises(InputError, match="give element numbers from 0 to 5"):
        getattr(mesh, method)(numbers)
    with pytest.raises(InputError, match="coarsened: give element numbers"):
        mesh.adapted([], numbers)


def test_the_deepest_level():
    mesh = make("rectangle")[0]
    for _ in range(DEEPEST):
        mesh = mesh.refined([mesh.levels.argmax()])
    deep = mesh.levels.argmax()
    assert mesh.levels[deep] == DEEPEST and np.ptp(mesh.p[0, mesh.t[:, deep]]) == 0.5 ** (DEEPEST + 1)
    assert np.unique(mesh.p, axis=1).shape == mesh.p.shape
    with pytest.raises(InputError, match=rf"element {deep} at \(.*\) has level 20, the deepest; begin with a finer"):
        mesh.refined([deep])


def test_elements_that_are_no_aligned_rectangles():
    for moved, theirs in ((4, "4 of 4 elements.*first: element 0"), (8, "1 of 4 elements.*first: element 3")):
        mesh = uniform(SQUARE, 2, 2)
        p = mesh.p.copy()
        p[0, moved] += 0.05
        with pytest.raises(InputError, match=theirs):
            quadtree(skfem.MeshQuad(p, mesh.t))
    with pytest.raises(InputError, match=r"give a skfem\.MeshQuad"):
        quadtree(skfem.MeshTri())


@pytest.mark.parametrize("move", [
    lambda m: m.translated((1.0, 0.0)), lambda m: m.scaled(2.0), lambda m: m.restrict([0, 1]), lambda m: m.smoothed(),
    lambda m: m.remove_elements([0]), lambda m: m.mirrored((1.0, 0.0)),
    lambda m: m + m, lambda m: type(m)(), lambda m: type(m).init_tensor(np.array([0, 1.0]), np.array([0, 1.0])),
])  # fmt: skip
def test_what_leaves_the_tree_is_refused(move):
    with pytest.raises(InputError, match=r"grows from a coarse one by quadtree\(mesh\).*change the coarse mesh, or take"):
        move(make("rectangle")[0].refined([0]))


def test_the_plain_copy_can_be_moved():
    mesh = make("rectangle")[0].refined([0])
    moved = mesh.plain().translated((1.0, 0.0))
    assert type(moved) is skfem.MeshQuad and np.allclose(moved.p - mesh.p, [[1], [0]]) and np.array_equal(moved.t, mesh.t)


def test_any_corner_numbering():
    """Quarter turns and both senses of rotation; names stay with their edges."""
    right = uniform(SQUARE, 2, 2)
    ends = {name: {frozenset(f) for f in right.facets[:, facets].T.tolist()} for name, facets in right.boundaries.items()}
    rng = np.random.default_rng(0)
    turned = np.stack([np.roll(t[::step], k) for t, step, k in zip(
        right.t.T, rng.choice([-1, 1], 4), rng.integers(0, 4, 4), strict=True)], axis=1)  # fmt: skip
    mesh = skfem.MeshQuad(right.p, turned, sort_t=False).with_boundaries({
        name: lambda x, name=name: {"left": x[0] == 0, "right": x[0] == 1, "bottom": x[1] == 0, "top": x[1] == 1}[name]
        for name in ends})  # fmt: skip
    tree = quadtree(mesh)
    assert np.array_equal(tree.p, right.p)
    assert tree.boundaries.keys() == ends.keys()
    for name, facets in tree.boundaries.items():
        assert {frozenset(f) for f in tree.facets[:, facets].T.tolist()} == ends[name]
    x, y = tree.p[:, tree.t]
    assert (x[0] < x[1]).all() and (x[1] == x[2]).all() and (y[0] == y[1]).all() and (y[1] < y[2]).all()
    check(tree.refined([1]).refined([2]), tree, (0.0, 0.0))


def test_coordinates_that_differ_by_rounding_are_one_line():
    mesh = uniform(SQUARE, 3, 3)
    p = mesh.p * (1 + 1e-15 * np.random.default_rng(0).normal(size=mesh.p.shape))
    tree = quadtree(skfem.MeshQuad(p, mesh.t)).refined([4])
    assert len(np.unique(tree.p[0])) == 5
    check_nodes(tree, (0.0, 0.0))


def test_ends_of_a_seam_that_do_not_match():
    mesh = uniform(TUBE, 3, 4)
    with pytest.raises(InputError, match="closed in y, but the mesh has other edges at 0 than at"):
        quadtree(mesh.restrict(np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) + mesh.p[1, mesh.t].mean(axis=0) < 6)), TUBE)


def test_a_tree_of_a_tree_is_the_tree():
    mesh = make("rectangle")[0].refined([0])
    assert quadtree(mesh) is mesh


# --- files -----------------------------------------------------------------------------------------------------------


def same(one, two):
    assert np.array_equal(one.p, two.p) and np.array_equal(one.t, two.t)
    for names, others in ((one.boundaries, two.boundaries), (one.subdomains, two.subdomains)):
        assert (names or {}).keys() == (others or {}).keys()
        for name in names or {}:
            assert np.array_equal(np.sort(names[name]), np.sort(others[name]))
    assert np.array_equal(one.hanging, two.hanging) and np.array_equal(one.f2t, two.f2t)


@kinds
def test_a_file_gives_the_mesh_back(kind, tmp_path):
    coarse, _ = make(kind)
    *_, mesh = walk(coarse, np.random.default_rng(2))
    again = load(save(mesh, tmp_path / "mesh.npz"))
    same(again, mesh)
    # It goes on as the first one does, across seams too.
    same(again.refined([0]), mesh.refined([0]))
    same(again.coarsened(np.arange(mesh.nelements)), mesh.coarsened(np.arange(mesh.nelements)))


def test_names_are_in_the_file(tmp_path):
    mesh = named().refined([3])
    again = load(save(mesh, tmp_path / "mesh.npz"))
    same(again, mesh)
    check_names(again.refined([0, 7]))
    assert [f.name for f in tmp_path.iterdir()] == ["mesh.npz"]


def altered(path, out, **changes):
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files}
    for name, change in changes.items():
        arrays[name] = change(arrays[name])
    np.savez(out, **{name: array for name, array in arrays.items() if array is not None})
    return out


def file_of(mesh, tmp_path):
    return save(mesh, tmp_path / "mesh.npz")


@pytest.mark.parametrize("changes, message", [
    ({"format": lambda a: np.array("skancf quadtree 99")}, r"is skancf quadtree 99, this version reads 'skancf quadtree 1'"),
    ({"format": lambda a: None}, "is None, this version reads"),
    ({"cells": lambda a: a[:, 1:]}, "overlap or leave a gap"),
    ({"cells": lambda a: np.hstack([a, a[:, :1]])}, "overlap or leave a gap"),
    ({"cells": lambda a: np.hstack([a[:, 1:], a[:, 1:2]])}, "overlap or leave a gap"),
    ({"cells": lambda a: a[:, :0]}, "leave a gap"),
    ({"cells": lambda a: a + np.array([[99], [0], [0], [0]])}, "no root or a level out of range"),
    ({"cells": lambda a: a + np.array([[0], [40], [0], [0]])}, "no root or a level out of range"),
    ({"cells": lambda a: a + np.array([[0], [0], [9], [0]])}, "outside of its root"),
    ({"cells": lambda a: a.astype(float)}, "cells is missing or has another shape"),
    ({"cells": lambda a: None}, "cells is missing"),
    ({"points": lambda a: a * np.nan}, "every coordinate must be a finite number"),
    ({"points": lambda a: a[:, :3]}, "corners names what is not there"),
    ({"points": lambda a: a + np.arange(a.shape[1])}, "no aligned rectangles"),
    ({"points": lambda a: -a}, "no aligned rectangle with its lower left corner first"),
    ({"corners": lambda a: a + 50}, "corners names what is not there"),
    ({"corners": lambda a: a[[1, 2, 3, 0]]}, "no aligned rectangle with its lower left corner first"),
    ({"corners": lambda a: a[:, :0]}, "corners names what is not there"),
    ({"closed": lambda a: None}, "closed is missing"),
    ({"closed": lambda a: a[:1]}, "closed is missing or has another shape"),
    ({"side_masks": lambda a: a[:, :, 1:]}, "sides and side_masks do not fit"),
    ({"sides": lambda a: a[1:]}, "sides and side_masks do not fit"),
    ({"sides": lambda a: np.array(3)}, "sides and side_masks do not fit"),
    ({"sides": lambda a: np.arange(len(a))}, "sides and side_masks do not fit"),
    ({"part_masks": lambda a: None}, "parts and part_masks do not fit"),
])  # fmt: skip
def test_files_that_hold_no_mesh(changes, message, tmp_path):
    path = file_of(named().refined([0]), tmp_path)
    same(load(altered(path, tmp_path / "same.npz")), load(path))
    with pytest.raises(InputError, match=message) as caught:
        load(altered(path, tmp_path / "other.npz", **changes))
    assert "other.npz" in str(caught.value) and "write it again" in str(caught.value)


def test_a_file_whose_elements_are_not_balanced(tmp_path):
    from skancf.meshes.forest import Leaves
    from skancf.meshes.quadtree import grown

    coarse = quadtree(uniform(SQUARE, 2, 1))
    once = coarse.leaves.split(np.array([0]))
    twice = Leaves(coarse.leaves.forest, once.cells).split(np.array([1]))
    path = save(grown(twice), tmp_path / "mesh.npz")
    with pytest.raises(InputError, match="differ by more than one level"):
        load(path)


def test_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        load(tmp_path / "mesh.npz")
    with pytest.raises(InputError, match="there is no such file"):
        load(tmp_path)
    array = io.BytesIO()
    np.save(array, np.arange(3))
    zipped = io.BytesIO()
    with zipfile.ZipFile(zipped, "w") as archive:
        archive.writestr("readme.txt", "no arrays")
    for content in (b"", b"hello", array.getvalue(), zipped.getvalue(), pickle.dumps({"format": 1})):
        (tmp_path / "mesh.npz").write_bytes(content)
        with pytest.raises(InputError, match=r"mesh.npz'.*write it again"):
            load(tmp_path / "mesh.npz")


def test_damaged_files_are_refused_or_whole(tmp_path):
    """Cut anywhere, or with any byte changed: InputError, or the mesh itself where the byte does not matter."""
    mesh = make("tube")[0].refined([0])
    path = file_of(mesh, tmp_path)
    whole, rng, refused = path.read_bytes(), np.random.default_rng(0), 0
    cuts = [whole[:n] for n in np.linspace(0, len(whole) - 1, 25).astype(int)]
    changed = []
    for place in rng.integers(0, len(whole), 300):
        content = bytearray(whole)
        content[place] ^= 1 << int(rng.integers(8))
        changed.append(bytes(content))
    for content in cuts + changed:
        path.write_bytes(content)
        try:
            same(load(path), mesh)
        except InputError:
            refused += 1
    assert refused > 200


class Trap:
    def __reduce__(self):
        return os.mkdir, (Trap.folder,)


@pytest.mark.parametrize("name", ["format", "cells", "sides"])
def test_code_in_a_file_is_not_run(name, tmp_path):
    Trap.folder = str(tmp_path / "ran")
    path = file_of(make("rectangle")[0], tmp_path)
    bad = altered(path, tmp_path / "bad.npz", **{name: lambda a: np.array([Trap()], dtype=object)})
    with pytest.raises(InputError, match="damaged"):
        load(bad)
    assert not os.path.exists(Trap.folder)
    with np.load(bad, allow_pickle=True) as data:
        data[name]
    assert os.path.exists(Trap.folder), "the trap works"


def test_an_older_file_survives_a_failed_write(tmp_path, monkeypatch):
    mesh = make("rectangle")[0]
    path = file_of(mesh, tmp_path)

    def fail(stream, **arrays):
        stream.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(OSError, match="disk full"):
        save(mesh.refined([0]), path)
    same(load(path), mesh)
    assert [f.name for f in tmp_path.iterdir()] == ["mesh.npz"]
    with pytest.raises(InputError, match=r"ends in '.txt'"):
        save(mesh, tmp_path / "mesh.txt")
