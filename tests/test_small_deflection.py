"""Small deflections against series and Ritz values; where the plain element fails, and by how much."""

import warnings
from functools import cache

import numpy as np
import pytest
from reference import navier, ritz

import skancf as sk
from skancf.statics.validity import warn_if_loads_move

MESHES = (8, 16, 32)


@cache
def deflection(edges: str, slenderness: float, n: int, poisson=0.3, assumed=True, kind="plane_stress") -> float:
    """w_c D / (q a^4) of a square plate under uniform load on n x n elements."""
    h = 1 / slenderness
    material = sk.Isotropic(1.0, poisson, 1.0, kind=kind)
    support = sk.Clamp("boundary") if edges == "clamped" else sk.SimpleSupport("boundary", kind=edges)
    plate = sk.Problem(sk.Rectangle(1, 1), h, material, [support], [sk.SurfaceLoad((0, 0, 1.0))])
    system = plate.on(sk.meshes.uniform(plate.surface, n, n), sk.Full(assumed=assumed))
    rigidity = h**3 / 12 / (1 - poisson**2)
    return sk.solve_linear(system).displacement((0.5, 0.5))[2] * rigidity


@cache
def exact(edges: str, slenderness: float, poisson: float) -> float:
    if edges == "hard":
        return navier.mindlin_uniform(slenderness, poisson)
    return ritz.centre_deflection(edges, slenderness, poisson)


def observed_rates(errors):
    return np.log2(np.array(errors[:-1]) / errors[1:])


# --- the references among themselves ---------------------------------------------------------------------------------


def test_series_agree_with_the_literature_and_each_other():
    # Timoshenko and Woinowsky-Krieger (1959), tables 8, 23, 35: three digits.
    assert np.isclose(navier.kirchhoff_uniform(), 0.00406, atol=5e-6)
    assert np.isclose(navier.kirchhoff_uniform(b=2.0), 0.01013, atol=5e-6)
    assert np.isclose(navier.kirchhoff_point(), 0.01160, atol=5e-6)
    assert np.isclose(ritz.centre_deflection("clamped", 1000, 0.3), 0.00126, atol=6e-6)
    # Shear adds (h/a)^2 times a constant: from thick to thin.
    assert np.isclose(navier.mindlin_uniform(1e4, 0.3), navier.kirchhoff_uniform(), rtol=1e-6)
    # Two methods for one plate; the Ritz values have converged to this.
    for slenderness, poisson in ((10, 0.3), (100, 0.0)):
        by_ritz = ritz.centre_deflection("hard", slenderness, poisson)
        assert np.isclose(navier.mindlin_uniform(slenderness, poisson), by_ritz, rtol=1e-7)
    thin, rigid = np.array([[4.0, 0.5, 0], [0.5, 1.0, 0], [0, 0, 0.6]]), (1e6, 1e6)
    assert np.isclose(navier.shear_deformable(thin, rigid), navier.thin_orthotropic(thin), rtol=1e-4)


# --- the element -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("poisson", [0.0, 0.3])
@pytest.mark.parametrize("slenderness", [10, 100, 1000])
@pytest.mark.parametrize("edges", ["hard", "clamped"])
def test_order_two_whatever_the_thickness(edges, slenderness, poisson):
    ratios = np.array([deflection(edges, slenderness, n, poisson) for n in MESHES]) / exact(edges, slenderness, poisson)
    errors = np.abs(ratios - 1)
    # The curvature is that of a bilinear director: order 2 in the displacement, measured 1.97 to 2.2.
    assert (observed_rates(errors) > 1.9).all()
    # Measured 0.0012 (hard) and 0.0007 (clamped) of the deflection on 32 x 32, the same for all thicknesses.
    assert errors[-1] < 0.0013


def test_thin_limit_under_a_centre_force():
    """Kirchhoff's 0.0116008 P a^2 / D; the shear deflection under the force has no limit but scales with (h/a)^2."""
    h, errors = 1e-3, []
    for n in MESHES:
        plate = sk.Problem(
            sk.Rectangle(1, 1), h, sk.Isotropic(1.0, 0.3, 1.0), [sk.SimpleSupport("boundary", kind="hard")],
            [sk.PointForce((0.5, 0.5), (0, 0, 1.0))],
        )  # fmt: skip
        solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n)))
        errors.append(abs(solution.displacement((0.5, 0.5))[2] * h**3 / 12 / 0.91 / navier.kirchhoff_point() - 1))
    # A force leaves w ~ r^2 log r: order 2 up to a logarithm, measured 1.50 and 1.68, error 0.0006.
    rates = observed_rates(errors)
    assert (rates > 1.4).all() and rates[-1] > rates[0]
    assert errors[-1] < 0.001


def test_soft_supports_converge_through_their_edge_layer():
    """Deflections of this element at a/h = 10, computed independently beforehand, and the Ritz limit 0.0046169."""
    found = [deflection("soft", 10, n) for n in MESHES]
    assert np.allclose(found, [0.004577, 0.004588, 0.004607], rtol=0, atol=6e-7)  # printed to six decimals
    limit = exact("soft", 10, 0.3)
    assert np.isclose(limit, 0.00461691, atol=2e-8)
    errors = limit - np.array(found)
    assert (np.diff(errors) < 0).all() and errors[-1] < 0.0025 * limit
    assert abs(found[-1] / exact("hard", 10, 0.3) - 1) > 0.05, "hard and soft differ by 8 % in a thick plate"


def test_plate_on_four_corners():
    """a/h = 100, computed independently beforehand; Kirchhoff's value, by Ritz, is 0.02551."""
    for n, expected in ((8, 0.02484), (16, 0.02537)):
        plate = sk.Problem(
            sk.Rectangle(1, 1), 0.01, sk.Isotropic(1.0, 0.3, 1.0), [sk.Pin("corners")], [sk.SurfaceLoad((0, 0, 1.0))]
        )
        solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n)))
        assert np.isclose(solution.displacement((0.5, 0.5))[2] * 1e-6 / 12 / 0.91, expected, atol=6e-6)


# --- where methods fail ----------------------------------------------------------------------------------------------

# Deflection over the exact one with the plain element, a/h = 1000, n = 8, 16, 32 (computed independently beforehand).
SHEAR_LOCKING = {"hard": (0.133, 0.728, 0.977), "clamped": (0.037, 0.469, 0.940)}


@pytest.mark.parametrize("edges", SHEAR_LOCKING)
def test_plain_element_locks_in_shear(edges):
    for n, expected in zip(MESHES, SHEAR_LOCKING[edges], strict=True):
        ratio = deflection(edges, 1000, n, assumed=False) / exact(edges, 1000, 0.3)
        assert abs(ratio - expected) < 0.001, "three decimals were printed"


def test_plain_element_converges_in_thick_plates():
    errors = [1 - deflection("hard", 10, n, assumed=False) / exact("hard", 10, 0.3) for n in MESHES]
    assert (observed_rates(errors) > 1.9).all() and errors[-1] < 0.001


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_3d_law_converges_to_a_wrong_answer(poisson):
    """Poisson thickness locking: too stiff by (1 - nu)^2 / (1 - 2 nu), whatever the mesh; 0.816 for nu = 0.3."""
    factor = (1 - 2 * poisson) / (1 - poisson) ** 2
    for assumed in (True, False):
        ratio = deflection("hard", 100, 32, poisson, assumed, "3d") / exact("hard", 100, poisson)
        # What the mesh itself leaves is below 0.2 %; shear does not lock and is a tenth of a percent here.
        assert np.isclose(ratio, factor, rtol=0.0025)
    if poisson:
        assert factor < 0.82 and abs(ratio - 1) > 0.15


def thick_plate_under(load, n):
    plate = sk.Problem(
        sk.Rectangle(1, 1), 0.2, sk.Isotropic(1.0, 0.3, 1.0), [sk.SimpleSupport("boundary", kind="hard")], [load]
    )
    return sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n))).displacement((0.5, 0.5))[2]


def test_point_force_has_no_limit_and_disk_force_has():
    point = np.diff([thick_plate_under(sk.PointForce((0.5, 0.5), (0, 0, 1.0)), n) for n in MESHES])
    disk = np.diff([thick_plate_under(sk.DiskForce((0.5, 0.5), 0.15, (0, 0, 1.0)), n) for n in MESHES])
    # Shear flow P / (2 pi r) on the stiffness k G h: each halving of the element adds ln 2 of P / (2 pi k G h).
    each = np.log(2) / (2 * np.pi * 5 / 6 / 2.6 * 0.2)
    assert np.allclose(point, each, rtol=0.02)  # measured 1.01 and 1.006
    assert abs(disk[1]) < 0.5 * abs(disk[0]) and abs(disk[1]) < 0.1 * each


# --- orthotropic plates ----------------------------------------------------------------------------------------------

FIBRES = {"young": (1.4e11, 1.0e10, 1.0e10), "poisson": (0.3, 0.3, 0.4), "shear": (5e9, 5e9, 3.5e9), "density": 1600.0}


def orthotropic_deflection(h, n, angle=0.0, b=1.0, kind="hard"):
    plate = sk.Problem(
        sk.Rectangle(1, b), h, sk.Orthotropic(**FIBRES, angle=angle), [sk.SimpleSupport("boundary", kind=kind)],
        [sk.SurfaceLoad((0, 0, 1.0))],
    )  # fmt: skip
    return sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n))).displacement((0.5, b / 2))[2]


def orthotropic_series(h, b=1.0):
    C = sk.Orthotropic(**FIBRES).stiffness()
    bending = h**3 / 12 * C[np.ix_([0, 1, 5], [0, 1, 5])]
    return navier.shear_deformable(bending, (h * C[4, 4], h * C[3, 3]), b), navier.thin_orthotropic(bending, b)


@pytest.mark.parametrize("b", [1.0, 1.5])
@pytest.mark.parametrize("h", [0.1, 0.001])
def test_orthotropic_plate(h, b):
    expected, thin = orthotropic_series(h, b)
    errors = [abs(orthotropic_deflection(h, n, b=b) / expected - 1) for n in MESHES]
    assert (observed_rates(errors) > 1.9).all() and errors[-1] < 0.002
    assert (abs(thin / expected - 1) < 1e-3) == (h < 0.01), "shear matters in the thick one"


def test_material_angle():
    h = 0.02
    straight, along_y = orthotropic_deflection(h, 16), orthotropic_deflection(h, 16, angle=np.pi / 2)
    # A square plate turned by a quarter is the same plate; one turned by 45 degrees either way is its mirror image.
    assert np.isclose(straight, along_y, rtol=1e-9)
    plus, minus = (orthotropic_deflection(h, 16, angle=a * np.pi / 4) for a in (1, -1))
    assert np.isclose(plus, minus, rtol=1e-9)
    assert abs(plus / straight - 1) > 0.05
    oblong = orthotropic_deflection(h, 16, b=1.5), orthotropic_deflection(h, 16, angle=np.pi / 2, b=1.5)
    assert oblong[1] > 1.5 * oblong[0], "in an oblong plate the direction of the fibres counts"


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e3, 1e9])
def test_answers_do_not_depend_on_the_unit_of_length(unit):
    """Elements are sorted into classes of equal shape; a graded mesh in any unit has the same classes and answer."""

    def answer(a):
        region = sk.meshes.Region((0.5 * a, 0.25 * a), (0.1 * a, 0.1 * a), 4.0)
        surface = sk.Rectangle(a, a)
        plate = sk.Problem(surface, 0.01 * a, sk.Isotropic(1.0, 0.3, 1.0), [sk.Clamp("boundary")],
                           [sk.SurfaceLoad((0, 0, 1e-8))])  # fmt: skip
        system = plate.on(sk.meshes.graded(surface, [region], shape=(8, 8)))
        return sk.solve_linear(system).displacement((0.5 * a, 0.5 * a))[2] / a, system.assembly.sections.shape

    (w, classes), (w_unit, classes_unit) = answer(1.0), answer(unit)
    # Rounding, amplified by the condition of a plate of a / h = 100.
    assert w_unit == pytest.approx(w, rel=1e-7)
    assert classes.max() > 5 and classes_unit.max() == classes.max()


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_clamped_plate_under_a_centre_force(nu):
    """w = 0.0056120 P a^2 / D in the thin limit, whatever nu is (Timoshenko and Woinowsky-Krieger, table 37: 0.00560)."""
    h = 1e-3
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), h, sk.Isotropic(1.0, nu, 1.0), [sk.Clamp("boundary")],
                       [sk.PointForce((0.5, 0.5), (0, 0, 1e-12))])  # fmt: skip
    errors = []
    for n in (8, 16, 32):
        w = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n))).displacement((0.5, 0.5))[2]
        errors.append(abs(w * h**3 / (12 * (1 - nu**2)) / (1e-12 * 0.0056120) - 1))
    # The load is not smooth, so the order is less than two; the last error is a few parts in a thousand.
    assert errors[0] > errors[1] > errors[2] and errors[2] < 5e-3


def ponding(k: float) -> sk.Solution:
    """A strip on two supports under 100 Pa and water that collects in its dent, k (N/m3) times its depth."""
    water = sk.FormTerm(energy=lambda w: -0.5 * k * w.u[2] ** 2 + 100.0 * w.u[2], load=True)
    steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    supports = [sk.SimpleSupport("left"), sk.SimpleSupport("right")]
    strip = sk.Problem(sk.Rectangle(1.0, 0.2), 0.003, steel, supports, terms=[water])
    return sk.solve_linear(strip.on(sk.meshes.uniform(strip.surface, 8, 1), "kirchhoff"))


def test_loads_that_follow_the_dent_are_left_out_with_a_word():
    """By Rayleigh's quotient of the first sine they have the part k L^4 / (pi^4 D) of the stiffness."""
    D = 210e9 * 0.003**3 / 12
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        few, many = ponding(0.04 * np.pi**4 * D), ponding(0.22 * np.pi**4 * D)
    assert np.array_equal(few.q, many.q)
    assert [("22 %" in str(warning.message), warning.category) for warning in told] == [(True, sk.OutOfDepth)]


def test_a_rigid_motion_meets_no_resistance_that_loads_could_have_a_share_of():
    steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, loads=[sk.FollowerPressure(1e3)])
    system = plate.on(sk.meshes.uniform(plate.surface, 2, 2), "kirchhoff")
    moved = system.undeformed.reshape(-1, 4, 3).copy()
    moved[:, 0] += 0.1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_if_loads_move(sk.Solution(system, moved.ravel(), linear=True))
