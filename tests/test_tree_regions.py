"""Quadtree meshes made fine in regions: lengths by the rule of graded meshes, and nothing else."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.meshes import Region, Regions, graded, quadtree, refined_in, uniform
from skancf.surfaces import CylinderSector, Rectangle

SQUARE = Rectangle(1.0, 1.0)
# Coordinates are sums of halved lengths.
ROUNDING = 1e-12


def lengths(mesh):
    return np.ptp(mesh.p[:, mesh.t], axis=1)


def within(mesh, region):
    """Elements whose inside meets that of a region, by corners."""
    low, high = mesh.p[:, mesh.t].min(axis=1), mesh.p[:, mesh.t].max(axis=1)
    centre, half = np.array([region.centre, region.half_size])[:, :, None]
    return ((high > centre - half + ROUNDING) & (low < centre + half - ROUNDING)).all(axis=0)


def cells(mesh, turn=lambda x, y: (x, y)):
    """Middles and lengths of all elements, sorted, after a map of the plane."""
    corners = np.array(turn(*mesh.p))[:, mesh.t]
    rows = np.concatenate([corners.mean(axis=1), np.ptp(corners, axis=1)]).T.round(9) + 0.0
    return rows[np.lexsort(rows.T)]


def symmetric(mesh, turn):
    """Equal to its image to 2e-9, the rounding of the sorted rows."""
    before, after = cells(mesh), cells(mesh, turn)
    return before.shape == after.shape and np.abs(before - after).max() < 2e-9


# Lengths


@pytest.mark.parametrize("ratio, share", [(1.2, 1.2**-0.5), (4.0, 0.5), (9.0, 1 / 3), (1e4, 0.25)])
def test_lengths_in_a_region_follow_the_rule(ratio, share):
    region = Region((0.31, 0.62), (0.11, 0.07), ratio)
    mesh = refined_in(uniform(SQUARE, 10, 10), [region])
    largest = lengths(mesh)[:, within(mesh, region)].max(axis=1)
    assert (largest <= 0.1 * share * (1 + 1e-9)).all()
    assert (largest > 0.1 * share / 2).all(), "no finer than asked for"
    assert mesh.hanging.size > 0


def test_lengths_are_those_of_graded_meshes():
    region = Region((0.5, 0.5), (0.2, 0.2), 5.0)
    rows = np.unique(graded(SQUARE, [region], coarse=0.1, growth=1.5).p[0])
    fine = np.diff(rows)[(rows[:-1] > 0.3) & (rows[1:] < 0.7)]
    quartered = lengths(refined_in(uniform(SQUARE, 5, 5), [region], coarse=0.1)).min()
    # A row of cells is stretched until it fits.
    assert fine.max() == pytest.approx(0.1 * 5**-0.5, rel=0.1)
    assert fine.max() / 2 < quartered <= fine.max() * 1.1


def test_the_length_elsewhere_is_that_of_the_regions_own_mesh_or_this_one():
    region = Region((0.5, 0.5), (0.1, 0.1), 4.0)
    mesh = uniform(SQUARE, 4, 4)

    def smallest(regions, **options):
        return lengths(refined_in(mesh, regions, **options)).min(axis=1).tolist()

    assert smallest([region]) == [0.125, 0.125], "half of this mesh's 1/4"
    assert smallest(Regions([region], cell=(0.1, 0.1))) == [1 / 32, 1 / 32], "at most 0.05"
    assert smallest(Regions([region], cell=(0.1, 0.1)), coarse=0.25) == [0.125, 0.125]
    assert smallest([region], coarse=(0.25, 0.125)) == [1 / 16, 1 / 16], "y asks for 1/16, and elements are quartered"
    assert smallest([region], finest=0.9) == [0.125, 0.125]
    assert smallest([Region((0.5, 0.5), (0.1, 0.1), 1e4)], finest=0.1) == [1 / 64, 1 / 64]


def test_slender_elements_are_quartered_until_both_lengths_fit():
    region = Region((0.5, 0.5), (0.1, 0.1), 4.0)
    mesh = refined_in(uniform(SQUARE, 8, 2), [region], coarse=0.125)
    assert lengths(mesh)[:, within(mesh, region)].max(axis=1).tolist() == [1 / 64, 1 / 16]


def test_the_finer_of_two_regions_wins():
    both = [Region((0.5, 0.5), (0.3, 0.3), 2.0), Region((0.5, 0.5), (0.05, 0.05), 16.0)]
    mesh = refined_in(uniform(SQUARE, 8, 8), both)
    for region, length in zip(both, (1 / 16, 1 / 32), strict=True):
        assert lengths(mesh)[:, within(mesh, region)].max() == length
    assert set(cells(mesh)[:, 2]) == {1 / 8, 1 / 16, 1 / 32}
    assert np.array_equal(cells(mesh), cells(refined_in(uniform(SQUARE, 8, 8), both[::-1])))


def test_refining_again_changes_nothing():
    region = Region((0.3, 0.4), (0.1, 0.2), 7.0)
    once = refined_in(uniform(SQUARE, 6, 6), [region], coarse=1 / 6)
    assert refined_in(once, [region], coarse=1 / 6) is once


@pytest.mark.parametrize("levels", [0, 1, 3])
def test_levels_count_from_the_mesh_that_is_given(levels):
    region = Region((0.5, 0.5), (0.1, 0.1), 1.01)
    coarse = quadtree(uniform(SQUARE, 4, 4)).refined(np.array([5]))
    mesh = refined_in(coarse, [region], levels=levels)
    before, after = coarse.levels[within(coarse, region)], mesh.levels[within(mesh, region)]
    # Of the parts of a quartered element some touch the region.
    assert {before.min() + levels, before.max() + levels} == set(after)


# Elsewhere


def test_far_from_the_regions_nothing_changes():
    region = Region((0.5, 0.5), (0.05, 0.05), 1e3)
    mesh = refined_in(uniform(SQUARE, 16, 16), [region])
    outside = np.abs(mesh.p[:, mesh.t].mean(axis=1) - 0.5).max(axis=0) > 0.05 + 2 / 16
    assert (mesh.levels[outside] == 0).all() and mesh.levels.max() == 2
    strips = graded(SQUARE, [region], coarse=1 / 16, growth=2.0)
    assert mesh.t.shape[1] < strips.t.shape[1], "no strips to the rim"


def test_without_regions_nothing_changes():
    mesh = refined_in(uniform(SQUARE, 3, 2), [])
    assert np.array_equal(cells(mesh), cells(uniform(SQUARE, 3, 2)))
    assert refined_in(mesh, [], levels=2) is mesh


def test_an_element_that_a_region_only_touches_stays():
    """The region's sides lie on coarse lines, one of which is not exact in binary numbers."""
    region = Region((0.45, 0.5), (0.15, 0.1), 3.9)
    mesh = refined_in(uniform(SQUARE, 10, 10), [region])
    x, y = mesh.p[:, mesh.t].mean(axis=1)[:, mesh.levels > 0]
    assert len(x) == 4 * 6 and x.min() > 0.3 and x.max() < 0.6 and y.min() > 0.4 and y.max() < 0.6


def test_a_region_across_a_coarse_line_refines_both_sides():
    region = Region((0.5, 0.25), (0.01, 0.01), 4.0)
    mesh = refined_in(uniform(SQUARE, 2, 2), [region])
    x, y = mesh.p[:, mesh.t].mean(axis=1)[:, mesh.levels > 0]
    assert set(x) == {0.125, 0.375, 0.625, 0.875} and set(y) == {0.125, 0.375}
    assert refined_in(mesh, [region], coarse=0.25).levels.max() == 2


def test_symmetric_regions_give_symmetric_meshes():
    places = [(0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
    mesh = refined_in(uniform(SQUARE, 7, 7), [Region(at, (0.13, 0.13), 6.0) for at in places])
    for turn in (lambda x, y: (1 - x, y), lambda x, y: (x, 1 - y), lambda x, y: (y, x)):
        assert symmetric(mesh, turn)
    assert not symmetric(refined_in(mesh, [Region((0.2, 0.7), (0.1, 0.1), 50.0)]), lambda x, y: (y, x))


def test_names_of_sides_are_kept():
    mesh = refined_in(uniform(SQUARE, 4, 4), [Region((0.0, 0.5), (0.1, 0.1), 16.0)])
    assert (mesh.p[0, mesh.facets[:, mesh.boundaries["left"]]] == 0.0).all()
    assert mesh.boundaries["left"].size > mesh.boundaries["right"].size == 4


# Closed surfaces


def test_a_region_ends_at_the_seam_but_balance_does_not():
    tube = CylinderSector(1.0, 2.0, angle=2 * np.pi, closed=True)
    mesh, turn = quadtree(uniform(tube, 4, 8), tube), 2 * np.pi
    half, length = (0.1, 0.4 * turn / 8), (0.5, turn / 8)
    low, high = Region((1.0, 0.0), half, 1e3), Region((1.0, turn), half, 1e3)

    def finest_at_ends(mesh):
        y = mesh.p[1, mesh.t].mean(axis=0)
        return mesh.levels[y < length[1]].max(), mesh.levels[y > turn - length[1]].max()

    fine = refined_in(mesh, [low], coarse=length)
    assert finest_at_ends(fine) == (2, 1)
    assert finest_at_ends(refined_in(mesh, [low, high], coarse=length)) == (2, 2)
    assert symmetric(refined_in(mesh, [low, high], coarse=length), lambda x, y: (x, turn - y))
    assert finest_at_ends(refined_in(uniform(tube, 4, 8), [low])) == (2, 0), "no seam without the surface"


# Errors


@pytest.mark.parametrize("regions, options, message", [
    ([Region((1.2, 0.5), (0.1, 0.1), 2.0)], {}, "outside the mesh"),
    ([Region((0.3, 0.3), (0.1, 0.1), 2.0)], {"levels": 1}, "outside the mesh"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"finest": 1.0}, "finest = 1.0.*between 0 and 1"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"finest": 0.0}, "finest"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"coarse": 1.5}, "does not fit into the side L = 1.0"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"coarse": -0.1}, "coarse.*greater than zero"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"coarse": (1, 2, 3)}, "one for each direction"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"levels": 1.5}, "levels = 1.5.*whole number"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"levels": -1}, "levels = -1"),
    ([Region((0.7, 0.5), (0.1, 0.1), 2.0)], {"levels": 1, "coarse": 0.1}, "not both"),
    ([((0.7, 0.5), (0.1, 0.1), 2.0)], {}, "no Region"),
    ([((0.7, 0.5), (0.1, 0.1), 2.0)], {"levels": 1}, "no Region"),
])  # fmt: skip
def test_wrong_input_is_named(regions, options, message):
    mesh = uniform(SQUARE, 4, 4, openings=[((0.25, 0.5), (0.25, 0.5))])
    with pytest.raises(InputError, match=message):
        refined_in(mesh, regions, **options)


# The paper's plate


def test_the_papers_plate_is_refined_under_the_force():
    plate = sk.Problem(
        surface=SQUARE, thickness=0.05,
        material=sk.Isotropic(young=0.2e6, poisson=0.0, density=2000.0, kind="3d", shear_correction=1.0),
        supports=[sk.Pin("corners")], loads=[sk.PointForce(at=(0.5, 0.5), force=(0.0, 0.0, -20.0))],
    )  # fmt: skip
    mesh = uniform(SQUARE, 12, 12)
    state = sk.solve(plate.on(mesh, "full")).unwrap()
    regions = sk.stress_regions(state)
    fine = refined_in(mesh, regions)
    middle = max(regions, key=lambda region: region.ratio if region.centre == (0.5, 0.5) else 0.0)
    assert middle.centre == (0.5, 0.5)
    wanted = max(0.25, middle.ratio**-0.5) / 12
    inside = within(fine, middle)
    assert wanted / 2 < lengths(fine)[:, inside].max() <= wanted * (1 + 1e-9)
    assert fine.levels[inside].min() > fine.levels.min() == 0
    assert fine.hanging.size > 0
    for turn in (lambda x, y: (1 - x, y), lambda x, y: (y, x)):
        assert symmetric(fine, turn)
    again = sk.solve(plate.on(fine, "full")).unwrap()
    # The larger space gives way more, by a few per cent only.
    old, new = (result.displacement((0.5, 0.5))[2] for result in (state, again))
    assert 1 < new / old < 1.1
