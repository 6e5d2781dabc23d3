"""The search for regions of stress concentration, on fields with known peaks."""

import numpy as np
import pytest

from skancf.adaptive.regions import find_regions
from skancf.errors import InputError
from skancf.meshes import graded, uniform
from skancf.surfaces import AnnulusSector, Rectangle

N = 20
SPACING = 1 / N
NODES = uniform(Rectangle(1.0, 1.0), N, N).p


def bump(x, y, height, width=0.04):
    return height * np.exp(-((NODES[0] - x) ** 2 + (NODES[1] - y) ** 2) / width**2)


def spikes(*nodes_and_values):
    """1 everywhere, other values at single nodes given by coordinates."""
    sigma = np.ones(NODES.shape[1])
    for x, y, value in nodes_and_values:
        sigma[np.argmin(np.hypot(NODES[0] - x, NODES[1] - y))] = value
    return sigma


def centres(sigma, **options):
    return [tuple(np.round(r.centre, 12)) for r in find_regions(NODES, sigma, spacing=SPACING, **options)]


def test_one_peak():
    sigma = 1 + bump(0.3, 0.65, 9.0)
    (region,) = find_regions(NODES, sigma, spacing=SPACING)
    # The centre is a node, copied, not computed.
    np.testing.assert_allclose(region.centre, (0.3, 0.65), rtol=0, atol=1e-15)
    assert region.value == sigma.max()
    assert region.ratio == sigma.max() / sigma.mean()


def test_sizes_grow_with_concentration_up_to_the_cap():
    sigma = spikes((0.2, 0.2, 2.0), (0.8, 0.2, 3.5), (0.2, 0.8, 40.0), (0.8, 0.8, 90.0))
    regions = sorted(find_regions(NODES, sigma, spacing=SPACING, cap=3.0, cell=(0.1, 0.2)), key=lambda r: r.ratio)
    half_x = np.array([r.half_size[0] for r in regions])
    # One factor times one product: a few roundings.
    np.testing.assert_allclose(half_x, 0.1 * np.minimum(np.sqrt([r.ratio for r in regions]), 3), rtol=1e-14)
    assert half_x[0] < half_x[1] < half_x[2] == half_x[3] == 0.1 * 3.0
    np.testing.assert_allclose([r.half_size[1] for r in regions], 2 * half_x, rtol=1e-14)


@pytest.mark.parametrize("steps, kept", [(2, 1), (3, 1), (5, 2), (8, 2)])
def test_a_lower_peak_counts_only_outside_the_spheres(steps, kept):
    # The lower peak's ratio is about 2.9, so its sphere has 2 sqrt(2.9) = 3.4 spacings; the higher one's 2 cap = 4.
    sigma = spikes((0.3, 0.5, 6.0), (0.3 + steps * SPACING, 0.5, 3.0))
    assert 3.3 < 2 * np.sqrt(3.0 / sigma.mean()) < 3.5
    found = centres(sigma)
    assert len(found) == kept
    assert (0.3, 0.5) in found


def test_between_the_two_spheres_both_stand():
    # As the method says, a node looks at its own sphere: 4 steps are inside the wide one and outside the narrow one,
    # whichever of the two nodes comes first.
    for side in (-1, 1):
        assert len(centres(spikes((0.5, 0.5, 6.0), (0.5 + side * 4 * SPACING, 0.5, 3.0)))) == 2


def test_the_sphere_grows_with_its_radius():
    sigma = spikes((0.3, 0.5, 6.0), (0.55, 0.5, 3.0))
    assert len(centres(sigma)) == 2
    assert len(centres(sigma, radius=4.0)) == 1


def test_peaks_below_the_mean_are_none():
    sigma = 10 * np.ones(NODES.shape[1])
    sigma[NODES[0] < 0.4] = 1.0
    sigma[np.argmin(np.hypot(NODES[0] - 0.1, NODES[1] - 0.5))] = 2.0
    assert sigma.mean() > 2.0
    assert (0.1, 0.5) not in centres(sigma)


def test_equal_values_within_one_sphere_are_one_region():
    equal_to_rounding = 5.0 * (1 + 4e-16)
    sigma = spikes((0.5, 0.5, 5.0), (0.55, 0.5, equal_to_rounding), (0.5, 0.55, 5.0), (0.55, 0.55, 5.0))
    assert centres(sigma) == [(0.5, 0.5)]
    # The check has teeth: far apart, the same values are regions of their own.
    assert len(centres(spikes((0.2, 0.5, 5.0), (0.8, 0.5, equal_to_rounding)))) == 2


def test_a_ridge_is_covered_all_along():
    found = centres(spikes(*((0.5, y, 5.0) for y in np.linspace(0, 1, N + 1))))
    gaps = np.diff([0.0, *(y for _, y in found), 1.0])
    assert {x for x, _ in found} == {0.5}
    # No node of the ridge is further from a region than the sphere, at most 4 spacings (cap 2).
    assert len(found) > 3
    assert gaps.max() <= (4 + 1) * SPACING + 1e-12


def test_four_corners_and_the_centre():
    """The paper's plate: supports at the corners, a load in the middle."""
    sigma = 0.5 + sum(bump(x, y, 3.0) for x in (0, 1) for y in (0, 1)) + bump(0.5, 0.5, 5.0)
    found = find_regions(NODES, sigma, spacing=SPACING)
    assert [r.centre for r in found] == [(0, 0), (0, 1), (0.5, 0.5), (1, 0), (1, 1)]
    mesh = graded(Rectangle(1.0, 1.0), found, nodes=169)
    x = np.unique(mesh.p[0])
    assert mesh.nvertices == 169
    # Symmetry to the rounding of the integral of 1/h over a thousand samples.
    np.testing.assert_allclose(x, 1 - x[::-1], rtol=0, atol=1e-12)
    assert 0.5 in x


def test_the_sphere_lies_in_space():
    """On an annulus of radius 10 to 10.1, angles that differ by little are far apart."""
    surface = AnnulusSector(10.0, 10.1)
    p = uniform(surface, 1, 40).p
    sigma = np.ones(p.shape[1])
    at = [np.argmin(np.hypot(p[0] - 10, p[1] - k * np.pi / 80)) for k in (10, 14)]
    sigma[at] = 5.0, 4.0
    arc = 10 * np.pi / 80
    assert len(find_regions(p, sigma, spacing=arc, positions=surface.position(*p), radius=1.0)) == 2
    assert len(find_regions(p, sigma, spacing=arc, radius=1.0)) == 1


@pytest.mark.parametrize("level", [0.0, 0.1, 3.7e8])
def test_constant_sigma_has_no_regions(level):
    assert find_regions(NODES, np.full(NODES.shape[1], level), spacing=SPACING) == ()


ONES = np.ones(NODES.shape[1])


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"sigma": ONES * np.nan}, "(?s)sigma.*not finite"),
        ({"sigma": -ONES}, "sigma.0. = -1.0: .* must not be negative"),
        ({"sigma": ONES[:-1]}, "sigma has shape .* one value for each of the 441 nodes"),
        ({"points": NODES[:1]}, r"points has shape \(1, 441\)"),
        ({"points": NODES + np.inf}, "(?s)points.*not finite"),
        ({"positions": NODES[:, :5]}, "positions has shape"),
        ({"spacing": 0.0}, "spacing = 0.0: .* greater than zero"),
        ({"radius": -1.0}, "radius = -1.0"),
        ({"size": 0.0}, "size = 0.0"),
        ({"cap": 0.5}, "cap = 0.5: give a factor of at least 1"),
        ({"cell": (0.1, 0.0)}, "cell = .*greater than zero"),
        ({"cell": (0.1, 0.1, 0.1)}, "cell = .* one for each direction"),
    ],
)
def test_wrong_input_is_named(changes, message):
    options = {"points": NODES, "sigma": ONES, "spacing": SPACING} | changes
    with pytest.raises(InputError, match=message):
        find_regions(options.pop("points"), options.pop("sigma"), **options)
