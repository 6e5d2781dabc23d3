"""Every surface keeps the contract: derivatives, shapes, normals, seams, areas; and names what is wrong."""

import re
from dataclasses import replace
from math import asinh, atan, cos, hypot, pi, radians, sin, sqrt

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.meshes import Region, check_mesh, graded, uniform
from skancf.surfaces import (
    AnnulusSector,
    Cone,
    CylinderSector,
    HyperbolicParaboloid,
    MappedSurface,
    Parallelogram,
    Plane,
    Rectangle,
    SphereSector,
    check_regular,
    closed_directions,
    normal,
)

FULL = 2 * pi
# A few operations on numbers of order one to ten.
ROUNDING = 1e-13
TORUS = (3.0, 1.0)


def torus(x, y):
    ring, tube = TORUS
    rho = ring + tube * np.cos(x)
    return rho * np.cos(y), -rho * np.sin(y), tube * np.sin(x)


def torus_derivatives(x, y):
    ring, tube = TORUS
    rho = ring + tube * np.cos(x)
    s, c, zero = -tube * np.sin(x), tube * np.cos(x), 0 * x
    return (s * np.cos(y), -s * np.sin(y), c), (-rho * np.sin(y), -rho * np.cos(y), zero)


def torus_second_derivatives(x, y):
    ring, tube = TORUS
    rho, s, c, zero = ring + tube * np.cos(x), -tube * np.sin(x), -tube * np.cos(x), 0 * x
    xx, xy = (c * np.cos(y), -c * np.sin(y), s), (-s * np.sin(y), -s * np.cos(y), zero)
    return np.array([xx, xy, (-rho * np.cos(y), rho * np.sin(y), zero)])


def saddle_area(length_x, length_y, rise):
    """Closed form of the integral of sqrt(1 + c^2 (x^2 + y^2)) over the rectangle."""
    c = 4 * rise / (length_x * length_y)
    a, b = c * length_x / 2, c * length_y / 2
    s = sqrt(1 + a * a + b * b)
    quarter = (a * b * s - atan(a * b / s)) / 3
    quarter += (a / 2 + a**3 / 6) * asinh(b / sqrt(1 + a * a)) + (b / 2 + b**3 / 6) * asinh(a / sqrt(1 + b * b))
    return 4 * quarter / c**2


BOTH = ((0.0, FULL), (0.0, FULL))
ROUND = ("inside", "outside", "from", "to")
# Each surface with its area: to add one, add a line.
SURFACES = [
    (Rectangle(3.0, 2.0, origin=(-1.0, 5.0)), 6.0),
    (Parallelogram(3.0, 2.0, radians(30)), 3.0),
    (Parallelogram(3.0, 2.0, radians(120)), 6 * sin(radians(120))),
    (AnnulusSector(1.0, 2.0), 3 * pi / 4),
    (AnnulusSector(0.0, 2.0, 1.0, start=0.5), 2.0),
    (AnnulusSector(1.0, 2.0, FULL, start=0.3), 3 * pi),
    (AnnulusSector(0.0, 2.0, FULL, start=-1.0, closed=True), 4 * pi),
    (CylinderSector(2.0, 5.0, 0.8, start=pi / 2 - 0.4), 8.0),
    (CylinderSector(2.0, 5.0, FULL, start=0.1, closed=True), 20 * pi),
    (Cone(2.0, 1.0, 3.0, 1.2, start=0.2), 1.2 * 1.5 * sqrt(10)),
    (Cone(1.0, 2.5, 3.0, FULL, closed=True), FULL * 1.75 * hypot(3.0, 1.5)),
    (SphereSector(3.0, (radians(18), pi / 2), pi / 2), 9 * pi / 2 * cos(radians(18))),
    (SphereSector(3.0, (0.0, pi), FULL, closed=True), 36 * pi),
    (HyperbolicParaboloid(3.0, 2.0, 0.7), saddle_area(3.0, 2.0, 0.7)),
    (HyperbolicParaboloid(3.0, 2.0, -0.7), saddle_area(3.0, 2.0, 0.7)),
    (MappedSurface(torus, BOTH, closed=(True, True)), 4 * pi**2 * 3),
    (MappedSurface(torus, BOTH, ROUND, (True, True), torus_derivatives), 4 * pi**2 * 3),
    (MappedSurface(lambda x, y: (x, y, 0.0), ((0.0, 2.0), (0.0, 1.5)), ("a", "b", "c", "d")), 3.0),
]


def spelled(value):
    """The same in every process: where a function lies in memory is left out."""
    return re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))


EACH = pytest.mark.parametrize("surface", [surface for surface, _ in SURFACES], ids=spelled)


def inner_points(surface, n=5):
    """A grid between the bounds, off the poles."""
    rows = [low + (high - low) * np.linspace(0.1, 0.9, n) for low, high in surface.bounds]
    return np.meshgrid(*rows, indexing="ij")


def fourth_order(f, t, step):
    """Central difference with an error of step^4."""
    return (8 * (f(t + step) - f(t - step)) - (f(t + 2 * step) - f(t - 2 * step))) / (12 * step)


# --- the contract ----------------------------------------------------------------------------------------------------


@EACH
def test_derivatives_are_those_of_the_position(surface):
    x, y = inner_points(surface)
    hx, hy = (1e-3 * (high - low) for low, high in surface.bounds)
    X_x, X_y = surface.derivatives(x, y)
    size = max(np.abs(X_x).max(), np.abs(X_y).max())
    # A full wave over the range: (2 pi 1e-3)^4 / 30 = 5e-11 of the derivative, per order.
    assert np.abs(X_x - fourth_order(lambda t: surface.position(t, y), x, hx)).max() < 1e-9 * size
    assert np.abs(X_y - fourth_order(lambda t: surface.position(x, t), y, hy)).max() < 1e-9 * size
    X_xx, X_xy, X_yy = surface.second_derivatives(x, y)
    along_x = fourth_order(lambda t: np.array(surface.derivatives(t, y)), x, hx)
    along_y = fourth_order(lambda t: np.array(surface.derivatives(x, t)), y, hy)
    size = max(size, np.abs([X_xx, X_xy, X_yy]).max())
    assert np.abs(along_x - [X_xx, X_xy]).max() < 1e-8 * size
    assert np.abs(along_y - [X_xy, X_yy]).max() < 1e-8 * size


def test_the_check_of_derivatives_can_fail():
    class Wrong(CylinderSector):
        def second_derivatives(self, x, y):
            xx, xy, yy = super().second_derivatives(x, y)
            return xx, xy + 1e-6, yy

    with pytest.raises(AssertionError):
        test_derivatives_are_those_of_the_position(Wrong(2.0, 5.0, 0.8))


@EACH
def test_numbers_and_arrays_of_any_shape(surface):
    (x, _), (y, _) = ((low + 0.3 * (high - low), high) for low, high in surface.bounds)

    def jet(x, y):
        return [surface.position(x, y), *surface.derivatives(x, y), *surface.second_derivatives(x, y), normal(surface, x, y)]

    whole = jet(np.full((2, 1, 4), x), np.full((2, 1, 4), y))
    for point, one, many in zip(jet(x, y), jet(np.full((2, 1, 1), x), np.full(4, y)), whole, strict=True):
        assert point.shape == (3,) and one.shape == (3, 2, 1, 4)
        assert np.array_equal(one, many)
        # numpy's sin of one number and of many may differ in the last place; second differences magnify it.
        np.testing.assert_allclose(one[:, 1, 0, 3], point, atol=1e-8 * np.abs(many).max())
    assert surface.position([x, x], y).shape == (3, 2)
    assert surface.derivatives(np.array([], float), y)[1].shape == (3, 0)


@EACH
def test_the_normal_is_a_unit_vector_across_both_tangents(surface):
    x, y = inner_points(surface)
    n = normal(surface, x, y)
    assert np.abs((n * n).sum(axis=0) - 1).max() < ROUNDING
    for slope in surface.derivatives(x, y):
        assert np.abs((n * slope).sum(axis=0)).max() < ROUNDING * np.abs(slope).max()


@EACH
def test_a_closed_direction_comes_back_and_an_open_one_does_not(surface):
    assert closed_directions(surface) == surface.closed
    x, y = inner_points(surface)
    for axis, ends in enumerate(surface.bounds):
        first, last = (
            [surface.position(*p), *surface.derivatives(*p), *surface.second_derivatives(*p)]
            for p in ((end, y[0]) if axis == 0 else (x[:, 0], end) for end in ends)
        )
        gap = [np.abs(a - b).max() for a, b in zip(first, last, strict=True)]
        if surface.closed[axis]:
            # Differences are one-sided at the ends: 1e-10 of second derivatives of order 4.
            assert gap[0] < ROUNDING and max(gap) < (1e-8 if isinstance(surface, MappedSurface) else ROUNDING)
        elif getattr(surface, "angle", 0) != FULL or axis == 0:
            assert max(gap) > 0.1


@pytest.mark.parametrize("surface, area", SURFACES, ids=spelled)
def test_area(surface, area):
    t, w = np.polynomial.legendre.leggauss(24)
    (x, wx), (y, wy) = (((a + b) / 2 + (b - a) / 2 * t, (b - a) / 2 * w) for a, b in surface.bounds)
    X_x, X_y = surface.derivatives(x[:, None], y)
    # 24 points integrate every one of these analytic functions to rounding; differences are right to 1e-12.
    assert abs(wx @ np.linalg.norm(np.cross(X_x, X_y, axis=0), axis=0) @ wy / area - 1) < 1e-11


@EACH
def test_bounds_and_sides(surface):
    assert all(low < high for low, high in surface.bounds)
    assert len(set(surface.sides)) == 4
    mesh = uniform(surface, 4, 3)
    check_mesh(mesh)
    check_regular(surface, *mesh.p[:, mesh.t].mean(axis=1))
    named = [name for i, name in enumerate(surface.sides) if not surface.closed[i // 2]]
    assert list(mesh.boundaries) == named
    for i, name in enumerate(surface.sides):
        if name in named:
            assert (mesh.p[i // 2, mesh.facets[:, mesh.boundaries[name]]] == surface.bounds[i // 2][i % 2]).all()


def test_the_plane_is_a_rectangle_without_bounds():
    plane, rectangle = Plane(), Rectangle(1.0, 1.0)
    x, y = np.array([0.0, 0.3]), 0.7
    assert np.array_equal(plane.position(x, y), rectangle.position(x, y))
    assert np.array_equal(plane.second_derivatives(x, y), np.zeros((3, 3, 2)))
    assert not hasattr(plane, "bounds") and plane.closed == (False, False)


def test_every_public_surface_is_in_the_registry():
    public = {each for each in vars(sk).values() if isinstance(each, type) and hasattr(each, "second_derivatives")}
    assert public == {type(surface) for surface, _ in SURFACES} | {Plane}


# --- where they lie --------------------------------------------------------------------------------------------------


def test_a_shallow_roof_has_its_crown_on_top():
    roof = CylinderSector(2.0, 5.0, 0.8, start=pi / 2 - 0.4)
    np.testing.assert_allclose(roof.position(1.0, pi / 2), [1, 0, 2], atol=ROUNDING)
    np.testing.assert_allclose(normal(roof, 1.0, pi / 2), [0, 0, 1], atol=ROUNDING)
    np.testing.assert_allclose(roof.position(0.0, roof.bounds[1][1]), [0, 2 * sin(0.4), 2 * cos(0.4)], atol=ROUNDING)


@pytest.mark.parametrize(
    "surface, across",
    [(CylinderSector(2.0, 5.0, FULL, closed=True), (0, 1, 1)), (SphereSector(2.0, (0.3, 3.0), FULL, 1.0, True), (1, 1, 1))],
)
def test_normals_point_outwards(surface, across):
    x, y = inner_points(surface)
    outwards = np.diag(across) @ surface.position(x, y).reshape(3, -1) / 2
    assert np.abs(normal(surface, x, y).reshape(3, -1) - outwards).max() < ROUNDING


def test_normals_of_a_cone_and_of_a_saddle():
    cone = Cone(2.0, 1.0, 3.0, pi)
    # It narrows by 1 over 3.
    np.testing.assert_allclose(normal(cone, 0.4, pi / 2), np.array([1, 0, 3]) / sqrt(10), atol=ROUNDING)
    np.testing.assert_allclose(cone.position([0, 3], pi / 2), [[0, 3], [0, 0], [2, 1]], atol=ROUNDING)
    saddle = HyperbolicParaboloid(3.0, 2.0, 0.7)
    np.testing.assert_allclose(saddle.position([1.5, -1.5], 1.0)[2], [0.7, -0.7], atol=ROUNDING)
    assert (normal(saddle, *inner_points(saddle))[2] > 0).all()


def disc(x, y):
    return y * np.cos(x), -y * np.sin(x), 0 * x


@pytest.mark.parametrize(
    "surface, at, expected",
    [
        (AnnulusSector(0.0, 2.0), (0.0, [0.1, 1.0]), [0, 0, 1]),
        (SphereSector(2.0, (0.0, 1.0), 1.0), (0.0, [0.1, 1.0]), [0, 0, 1]),
        (SphereSector(2.0, (1.0, pi), 1.0), (pi, [0.1, 1.0]), [0, 0, -1]),
        (MappedSurface(disc, ((0.0, 1.0), (0.0, 2.0))), ([0.1, 1.0], 0.0), [0, 0, 1]),
        (MappedSurface(lambda x, y: disc(x, y - 2), ((0.0, 1.0), (0.0, 2.0))), (0.5, 2.0), [0, 0, -1]),
    ],
    ids=spelled,
)
def test_at_a_pole_the_normal_is_its_limit(surface, at, expected):
    n = normal(surface, *at)
    # Of second differences on the mapped ones.
    assert np.abs(n.reshape(3, -1).T - expected).max() < 1e-8
    assert np.abs(normal(surface, *(np.array(v) * (1 - 1e-6) + 1e-7 for v in at)) - n).max() < 1e-5


# --- mapped surfaces -------------------------------------------------------------------------------------------------


def test_mapped_derivatives_reach_what_they_promise():
    """Over a full wave in each direction, up to the edges; measured 2e-13 and 7e-11 of the largest."""
    surface = MappedSurface(torus, BOTH, closed=(True, True))
    x, y = np.meshgrid(np.linspace(0, FULL, 41), np.linspace(0, FULL, 37))
    exact = np.array(torus_derivatives(x, y))
    first = np.abs(np.array(surface.derivatives(x, y)) - exact).max() / np.abs(exact).max()
    exact = torus_second_derivatives(x, y)
    second = np.abs(np.array(surface.second_derivatives(x, y)) - exact).max() / np.abs(exact).max()
    assert first < 1e-12 and second < 3e-10
    # Steps that are far too long show: the check has teeth.
    long = MappedSurface(torus, BOTH, closed=(True, True), step=1 / 30)
    assert np.abs(np.array(long.second_derivatives(x, y)) - exact).max() / np.abs(exact).max() > 1e-8


def test_mapped_derivatives_of_short_waves():
    k = 8 * pi
    surface = MappedSurface(lambda x, y: (x, y, np.sin(k * x)), ((0.0, 1.0), (0.0, 1.0)))
    x = np.linspace(0, 1, 101)
    # Measured 9e-10 and 5e-8 at the edges, where k h = 0.1 and the error is (k h)^8 / 9, then (k h)^7 / 2.
    assert np.abs(surface.derivatives(x, 0.5)[0][2] - k * np.cos(k * x)).max() < 2e-9 * k
    assert np.abs(surface.second_derivatives(x, 0.5)[0][2] + k * k * np.sin(k * x)).max() < 1e-7 * k * k


def test_exact_derivatives_make_second_ones_better():
    x, y = np.meshgrid(np.linspace(0, FULL, 41), np.linspace(0, FULL, 37))
    surface = MappedSurface(torus, BOTH, ROUND, (True, True), torus_derivatives)
    assert np.array_equal(surface.derivatives(x, y), torus_derivatives(x, y))
    exact = torus_second_derivatives(x, y)
    assert np.abs(np.array(surface.second_derivatives(x, y)) - exact).max() < 1e-11


def test_the_function_is_never_called_outside_the_bounds():
    bounds = ((0.1, 0.7), (-0.3, 1e-3))
    asked = []

    def half_sphere(x, y):
        asked.append([x.min() - 0.1, 0.7 - x.max(), y.min() + 0.3, 1e-3 - y.max()])
        return x, y, np.sqrt(1 - x * x - y * y)

    surface = MappedSurface(half_sphere, bounds)
    x, y = np.meshgrid(np.linspace(0.1, 0.7, 203), np.linspace(-0.3, 1e-3, 11))
    surface.derivatives(x, y), surface.second_derivatives(x, y)
    assert np.min(asked) >= 0 and len(asked) > 50
    assert surface.position(0.7 * (1 + 1e-15), 0.0)[0] == 0.7


@pytest.mark.parametrize("step", [1 / 9, 1 / 10, 1 / 17.3])
def test_the_longest_steps_fit_and_are_exact_on_polynomials(step):
    surface = MappedSurface(lambda x, y: (x, y, x**8 + x**3 * y**2), ((0.0, 1.0), (0.0, 1.0)), step=step)
    x, y = np.meshgrid(np.linspace(0, 1, 57), np.linspace(0, 1, 5))
    # Nine points are exact to degree eight: only rounding is left, times weights of some hundreds at h = 1/17.
    assert np.abs(surface.derivatives(x, y)[0][2] - 8 * x**7 - 3 * x**2 * y**2).max() < 1e-11
    xx, xy, _ = surface.second_derivatives(x, y)
    assert np.abs(xx[2] - 56 * x**6 - 6 * x * y**2).max() < 1e-10
    assert np.abs(xy[2] - 6 * x**2 * y).max() < 1e-10


# --- regularity ------------------------------------------------------------------------------------------------------

UNIT = ((0.0, 1.0), (0.0, 1.0))
GRID = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), indexing="ij")


@pytest.mark.parametrize(
    "function, message",
    [
        (lambda x, y: ((x - 0.5) ** 2, y, 0 * x), r"\(x, y\) = \(0.5, 0\), in space \(0, 0, 0\) \(5 such points\)"),
        (lambda x, y: (x + y, 2 * (x + y), 0 * x), r"\(x, y\) = \(0, 0\), in space \(0, 0, 0\) \(25 such points\)"),
        (lambda x, y: (x, np.sin(x), 0 * x), "25 such points"),
        (lambda x, y: (x, 1e-14 * y, 7.0), "25 such points"),
        (lambda x, y: (1.0, 2.0, 3.0), r"in space \(1, 2, 3\) \(25 such points\)"),
        (lambda x, y: (x * np.cos(y), x * np.sin(y), 0 * x), r"\(x, y\) = \(0, 0\), .* \(5 such points\)"),
    ],
)
def test_folds_and_surfaces_without_area_are_named(function, message):
    surface = MappedSurface(function, UNIT)
    with pytest.raises(InputError, match=message):
        check_regular(surface, *GRID)


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: (x, 1e-5 * y, 7.0),
        lambda x, y: (x + y, 1e-5 * x, 0 * x),
        lambda x, y: ((x + 1e-5) * np.cos(y), (x + 1e-5) * np.sin(y), 0 * x),
        lambda x, y: (1e-9 * x, 1e-9 * y, 0 * x),
    ],
)
def test_slender_skew_and_tiny_surfaces_pass(function):
    surface = MappedSurface(function, UNIT)
    check_regular(surface, *GRID)
    check_regular(surface, 0.0, 0.5)
    check_regular(surface, 0.5, [0.1, 0.2])
    check_regular(surface, [], [])


def test_a_normal_that_does_not_exist_is_named():
    with pytest.raises(InputError, match=r"no tangent plane at \(x, y\) = \(0.5, 0.2\)"):
        normal(MappedSurface(lambda x, y: ((x - 0.5) ** 2, y, 0 * x), UNIT), 0.5, 0.2)
    # Nor has a fold away from the middle, though one side of it has a limit.
    with pytest.raises(InputError, match=r"no tangent plane at \(x, y\) = \(0.3, 1\)"):
        normal(MappedSurface(lambda x, y: ((x - 0.3) ** 2, y, 0 * x), ((0.0, 1.0), (0.0, 2.0))), 0.3, [1.0, 1.2])

    class Line(Plane):
        def derivatives(self, x, y):
            return super().derivatives(x, y)[0], 0 * super().derivatives(x, y)[1]

    with pytest.raises(InputError, match="no tangent plane"):
        normal(Line(), [0.5, 1.0], 0.2)


# --- meshes ----------------------------------------------------------------------------------------------------------


def test_meshes_of_closed_surfaces_name_no_seam():
    tube = CylinderSector(1.0, 3.0, FULL, closed=True)
    mesh = graded(tube, [Region((1.0, 2.0), (0.1, 0.1), 9.0)], nodes=15 * 21)
    assert set(mesh.boundaries) == {"left", "right"}
    assert set(uniform(CylinderSector(1.0, 3.0, FULL), 3, 8).boundaries) == {"left", "right", "start", "end"}
    assert not uniform(MappedSurface(torus, BOTH, closed=(True, True)), 4, 4).boundaries
    bow = MappedSurface(torus, ((0.0, FULL), (0.0, 1.0)), closed=(True, False))
    assert set(uniform(bow, 4, 4).boundaries) == {"bottom", "top"}


def test_a_surface_that_does_not_say_is_open():
    class Strip:
        bounds, sides = ((0.0, 1.0), (0.0, 2.0)), ("a", "b", "c", "d")

    assert closed_directions(Strip()) == (False, False)
    assert set(uniform(Strip(), 1, 2).boundaries) == set("abcd")


# --- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Rectangle(0.0, 1.0), "length_x = 0.0"),
        (lambda: Rectangle(1.0, 1.0, origin=(0.0,)), "origin"),
        (lambda: Parallelogram(1.0, -1.0, 1.0), "length_y = -1.0"),
        (lambda: Parallelogram(1.0, 1.0, 0.0), "angle = 0.0"),
        (lambda: Parallelogram(1.0, 1.0, 60.0), "angle = 60.0: .* 0 < angle < pi, in radians"),
        (lambda: AnnulusSector(-1.0, 2.0), r"inner = -1.0: .* at least zero"),
        (lambda: AnnulusSector(0.0, 0.0), "outer = 0.0"),
        (lambda: AnnulusSector(2.0, 1.0), "inner = 2.0, outer = 1.0: the inner radius must be the smaller one"),
        (lambda: AnnulusSector(1.0, 2.0, 90.0), "angle = 90.0: .* 0 < angle <= 2 pi, in radians"),
        (lambda: AnnulusSector(1.0, 2.0, start=np.nan), "start = nan"),
        (lambda: AnnulusSector(1.0, 2.0, closed=True), r"closed = True with angle = 1.57.*: only a full turn"),
        (lambda: AnnulusSector(1.0, 2.0, FULL, closed="yes"), "closed = 'yes': give True"),
        (lambda: CylinderSector(-1.0, 1.0, 1.0), "radius = -1.0"),
        (lambda: CylinderSector(1.0, 0.0, 1.0), "length = 0.0"),
        (lambda: CylinderSector(1.0, 1.0, 7.0), "angle = 7.0"),
        (lambda: CylinderSector(1.0, 1.0, 6.28, closed=True), "closed = True with angle = 6.28"),
        (lambda: Cone(0.0, 1.0, 1.0, 1.0), "radius_low = 0: a cone has no tangent plane at its apex; cut it off"),
        (lambda: Cone(1.0, 0, 1.0, 1.0), "radius_high = 0: a cone has no tangent plane"),
        (lambda: Cone(1.0, -1.0, 1.0, 1.0), "radius_high = -1.0"),
        (lambda: Cone(1.0, 2.0, 0.0, 1.0), "height = 0.0"),
        (lambda: SphereSector(0.0, (0.0, 1.0), 1.0), "radius = 0.0"),
        (lambda: SphereSector(1.0, (1.0, 0.5), 1.0), r"polar = \(1.0, 0.5\): give polar angles 0 <= low < high <= pi"),
        (lambda: SphereSector(1.0, (18.0, 90.0), 1.0), "polar = .* in radians"),
        (lambda: SphereSector(1.0, (0.0, 1.0), 0.0), "angle = 0.0"),
        (lambda: HyperbolicParaboloid(0.0, 1.0, 1.0), "length_x = 0.0"),
        (lambda: HyperbolicParaboloid(1.0, 1.0, 0.0), "rise = 0: this is flat; use a Rectangle"),
    ],
)  # fmt: skip
def test_wrong_values_are_named(make, message):
    with pytest.raises(InputError, match=message):
        make()


def flat(x, y):
    return x, y, 0 * x


@pytest.mark.parametrize(
    "values, message",
    [
        ({"function": 3}, "function = 3"),
        ({"bounds": ((0, 1), (1, 1))}, r"bounds = .* with min < max"),
        ({"bounds": (0, 1)}, "bounds"),
        ({"sides": ("a", "b", "c")}, "sides = .* four different names"),
        ({"sides": ("a", "b", "c", "a")}, "sides = .* four different names"),
        ({"sides": ("a", "b", "c", "corners")}, "boundary and corners mean all sides"),
        ({"closed": True}, "closed = True: give two"),
        ({"step": 0.2}, "step = 0.2: .* at most 1/9"),
        ({"function": lambda x, y: (x, y)}, "function returned 2 components; give the three"),
        ({"function": lambda x, y: (x, y, np.zeros(3))}, r"\(5, 6\), \(3,\)\] at x and y of shape \(5, 6\)"),
        ({"function": lambda x, y: 1.0}, "function: 'float' object is not iterable"),
        ({"function": lambda x, y: (x, y, sin(x))}, r"on arrays of shape \(5, 6\); .* numpy and not of math"),
        ({"function": lambda x, y: (x, y, np.where(x > 0.9, np.nan, x))}, r"is \[ *1. +0. +nan\] at \(x, y\) = \(1, 0\)"),
        ({"closed": (True, False)}, "closed in x, but X differs by 1 between the two ends"),
        ({"function": lambda x, y: (np.sin(pi * x), y, x * x - x), "closed": (True, False)}, "x, but X_x differs by"),
        ({"exact_derivatives": lambda x, y: ((1.0, 0.0, 0.0),)}, "exact_derivatives: 1 values; give the pair"),
        ({"exact_derivatives": lambda x, y: ((1, 0), (0, 1, 0))}, r"exact_derivatives\[0\] returned 2 components"),
        ({"exact_derivatives": lambda x, y: ((1, 0, 0), (0, x, 0))}, r"X_y = \[0. 0. 0.\] at \(x, y\) = \(0, 0\), but"),
    ],
)  # fmt: skip
def test_wrong_mapped_surfaces_are_named(values, message):
    with pytest.raises(InputError, match=message):
        MappedSurface(**{"function": flat, "bounds": UNIT, **values})


@pytest.mark.parametrize(
    "function, message",
    [
        (lambda x, y: (x, y, abs(x - 0.4)), r"X_x jumps by 1\.\d* at x = 0\.40000\d?, a kink"),
        (lambda x, y: (x, y, abs(x - 0.5)), r"X_x jumps by 2 at x = 0\.5, a kink"),
        (lambda x, y: (x, y, np.interp(y, [0.0, 0.3, 1.0], [0.0, 0.1, 0.0])), r"X_y jumps by 0\.\d* at y = 0\.30000\d?, a"),
        (lambda x, y: (x, y, 0.1 * np.hypot(x - 0.5, y - 1 / 3)), r"X_x jumps by .* at x = 0\.\d*, a kink"),
        (lambda x, y: (x, y, 0.03 * abs(x - 0.4) + 0.1 * np.sin(6 * x)), r"X_x jumps by 0\.0\d* at x = 0\.4"),
    ],
)
def test_kinks_are_named(function, message):
    with pytest.raises(InputError, match=message):
        MappedSurface(function, UNIT)


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: (x, y, np.sqrt((x - 0.4) ** 2 + 1e-6)),  # rounded with a radius of a thousandth
        lambda x, y: (x, y, abs(x - 0.4) ** 3),
        lambda x, y: (x, y, np.sin(16 * pi * x) * np.cos(32 * pi * y)),
        lambda x, y: (x, y, np.sin(6 * x) + 1e-10 * np.sin(1e9 * x + 3e8 * y)),  # noise
        lambda x, y: tuple(np.asarray(v, np.float32) for v in (x, y, np.sin(6 * x))),
        lambda x, y: (1e6 + 1e-3 * x, y, np.sin(6 * x)),
    ],
    ids=["rounded", "cubic", "waves", "noise", "single precision", "far away"],
)
def test_what_is_no_kink_passes(function):
    MappedSurface(function, UNIT)


def test_parameters_outside_the_bounds_are_named():
    surface = MappedSurface(flat, UNIT)
    with pytest.raises(InputError, match=r"y = 1.1: outside the bounds \(0.0, 1.0\)"):
        surface.derivatives(0.5, [0.2, 1.1])
    with pytest.raises(InputError, match="x = nan: outside"):
        surface.position(np.nan, 0.5)


def test_sectors_are_values():
    ring = AnnulusSector(1.0, 2.0, FULL, closed=True)
    assert ring.closed == (False, True) and AnnulusSector(1.0, 2.0, FULL).closed == (False, False)
    assert replace(ring, outer=3.0) == AnnulusSector(1.0, 3.0, FULL, closed=True)
    assert ring != AnnulusSector(1.0, 2.0, FULL) and hash(ring) == hash(replace(ring))
    with pytest.raises(AttributeError):
        ring.outer = 3.0
