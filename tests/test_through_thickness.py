"""Sections of laws at points: Rivlin's flexure, exact states of shells, derivatives, and small strain."""

import numpy as np
import pytest

import skancf as sk
from skancf.materials import BeyondLaw, Isotropic, MooneyRivlin, NeoHooke, section_of
from skancf.materials.through_thickness import heated_through_thickness, heights, require_one_side, through_thickness

MU, RHO, H = 1.0, 1000.0, 0.1
RUBBER = NeoHooke(MU, RHO)
COMPRESSIBLE = NeoHooke(MU, RHO, poisson=0.4)


def column(*values):
    return np.array(values, dtype=float)[:, None]


ZERO = column(0.0, 0.0, 0.0)


def respond(law, eps, kappa, curvature=ZERO, points=3, **more):
    z, w = heights(section_of(law, H), points)
    return through_thickness(law, z, w, eps, kappa, curvature, **more)


def square(entries):
    full = np.empty((6, 6, entries.shape[1]))
    for entry, k, l in zip(entries, *np.triu_indices(6), strict=True):
        full[k, l] = full[l, k] = entry
    return full


def flexure(angle, points=3):
    """Moment of a plate in plane strain that turns by an angle per undeformed length without a force along it: mu H^2."""
    stretch = 1.0
    for _ in range(50):
        found = respond(RUBBER, column((stretch**2 - 1) / 2, 0, 0), column(stretch * angle, 0, 0), points=points)
        K = square(found.stiffness)[:, :, 0]
        change = -found.forces[0, 0] / (K[0, 0] * stretch + K[0, 3] * angle)
        stretch += change
        if abs(change) < 1e-15:
            break
    return found.forces[3, 0] * stretch / (MU * H**2)


@pytest.mark.parametrize(
    ("bend", "exact", "error"),
    [(0.02, 0.006666, 1e-5), (0.05, 0.016654, 2e-4), (0.1, 0.033234, 6e-4), (0.2, 0.065883, 2e-3)],
)
def test_flexure_of_rivlin(bend, exact, error):
    """Rivlin 1949, whose normals change their length: what that leaves is of the square of thickness over radius."""
    moment = flexure(bend / H)
    assert moment == pytest.approx(exact, rel=error + 5e-7 / exact)  # printed with six places
    if bend == 0.2:
        linear = bend / 3
        assert abs(linear / exact - 1) > 0.01  # so the law took part


def test_three_points_are_enough():
    """Against thirty, up to a radius of five thicknesses: an order below what normals of constant length leave."""
    for bend, error in ((0.1, 3e-6), (0.2, 4e-5), (0.4, 6e-4)):
        assert flexure(bend / H) == pytest.approx(flexure(bend / H, 30), rel=error)
    assert abs(flexure(0.2 / H, 2) / flexure(0.2 / H, 30) - 1) > 5e-3


def places(n=12):
    rng = np.random.default_rng(1)
    return 0.2 * rng.uniform(-1, 1, (3, n)), 2.0 * rng.uniform(-1, 1, (3, n)), 2.0 * rng.uniform(-1, 1, (3, n))


@pytest.mark.parametrize("law", [RUBBER, COMPRESSIBLE, MooneyRivlin(0.4, 0.1, RHO)], ids=["NH", "NH 0.4", "MR"])
def test_forces_and_stiffness_are_derivatives(law):
    """Differences of two steps, extrapolated: errors of the fourth power."""
    eps, kappa, curvature = places()
    found = respond(law, eps, kappa, curvature)
    full = square(found.stiffness)
    for m in range(6):
        size = H if m >= 3 else 1.0
        slopes = []
        for h in (2e-4, 1e-4):
            de, dk = np.zeros((2, 3, 1))
            (dk if m >= 3 else de)[m % 3] = h / size
            up, down = (respond(law, eps + s * de, kappa + s * dk, curvature) for s in (1, -1))
            slopes.append(np.vstack([(up.energy - down.energy)[None], up.forces - down.forces]) * size / (2 * h))
        slope = (4 * slopes[1] - slopes[0]) / 3
        assert np.abs(slope[0] - found.forces[m]).max() < 1e-9 * H * size
        assert np.abs((slope[1:] - full[:, m]).T / np.array([1, 1, 1, H, H, H])).max() < 3e-9 * H * size
    assert np.abs(full[:3, 3:]).max() > 0.1 * H**2  # curvature couples both, so all parts were seen


def test_the_undeformed_shell_is_at_rest():
    _, _, curvature = places()
    found = respond(COMPRESSIBLE, 0 * curvature, 0 * curvature, curvature)
    assert np.abs(found.forces).max() < 1e-15 and np.abs(found.energy).max() < 1e-30


def test_small_strain_of_a_flat_plate_is_lamination_theory():
    section = section_of(COMPRESSIBLE, H)
    found = square(respond(COMPRESSIBLE, ZERO, ZERO).stiffness)[:, :, 0]
    scale = np.repeat([1.0, H], 3)
    error = np.abs(found - section.abd()) / np.outer(scale, scale)
    assert error.max() < 1e-13
    linear = section_of(Isotropic(2 * MU * 1.4, 0.4, RHO), H)
    assert np.abs(section.abd() - linear.abd()).max() < 1e-15
    assert section.mass == linear.mass and section.neutral == 0 and linear.points_law is None


def test_a_sphere_that_grows_has_the_stress_of_each_layer():
    """R to r without change of the normals: C = ((r + z) / (R + z))^2 at each height, integrated with many points."""
    R, r = 1.0, 1.6
    eps = column((r * r / R**2 - 1) / 2, (r * r / R**2 - 1) / 2, 0)
    curvature = column(-1 / R, -1 / R, 0)  # bulged along the normal
    b = column(-r / R**2, -r / R**2, 0)  # r_,ab . n per undeformed length
    found = respond(RUBBER, eps, curvature - b, curvature, points=20)
    s, w = np.polynomial.legendre.leggauss(40)
    z = s * H / 2
    C = ((r + z) / (R + z)) ** 2
    energy = 0.5 * MU * (2 * C + C**-2 - 3) * (1 + z / R) ** 2 @ w * H / 2
    assert found.energy[0] == pytest.approx(energy, rel=1e-13)
    # The area of the mid-surface alone would be this far off, so the weights took part.
    assert abs((0.5 * MU * (2 * C + C**-2 - 3)) @ w * H / 2 / energy - 1) > 5e-4


def test_a_rolled_tube_has_no_stress_where_it_was_made():
    """Plane to a cylinder and back: bending of a curved section by minus its curvature is that of a flat strip."""
    R = 0.5
    curvature = column(1 / R, 0, 0)
    flat = respond(RUBBER, ZERO, curvature, curvature, points=12)  # b = 0 now
    s, w = np.polynomial.legendre.leggauss(40)
    z = s * H / 2
    C = (1 - z / R) ** -2.0
    energy = (0.5 * MU * (C + 1 + 1 / C - 3) * (1 - z / R)) @ w * H / 2
    assert flat.energy[0] == pytest.approx(energy, rel=1e-12)


HOT = NeoHooke(shear=1.5e6, density=1000.0, poisson=0.45, expansion=2e-4)


def heated(eps, kappa, curvature, middle, gradient=0.0):
    z, w = heights(section_of(HOT, H), 3)
    heat = np.array([middle]), np.array([gradient])
    return heated_through_thickness(HOT, z, w, eps, kappa, curvature, *heat)


def test_free_stretch_is_no_stress():
    """Heat: a stretch that nothing holds has no energy, and one that is held has that of its inverse, of a larger body."""
    grown = 1.02
    eps = column((grown**2 - 1) / 2, (grown**2 - 1) / 2, 0)
    moved = heated(eps, ZERO, ZERO, 100.0)
    assert np.abs(moved.forces).max() < 1e-9 and moved.stretch33[:, 0] == pytest.approx(np.full(3, grown**2), rel=1e-14)
    held = heated(ZERO, ZERO, ZERO, 100.0)
    pressed = HOT.plane_stress(column(grown**-2.0, grown**-2.0, 0))
    assert held.energy[0] == pytest.approx(grown**3 * H * pressed.energy[0], rel=1e-12)
    assert held.forces[0, 0] == pytest.approx(grown * H * pressed.stress[0, 0], rel=1e-13)
    full = square(held.stiffness)[:, :, 0]
    assert full[0, 0] == pytest.approx(H * pressed.stiffness[0, 0] / grown, rel=1e-13)


def test_a_shell_that_grows_in_the_heat_has_no_stress():
    """Of a sphere the curvature R_,ab . N grows by the stretch: (1 / R) (1.02 R / R) of the undeformed frame."""
    grown, b = 1.02, column(2.0, 2.0, 0)
    eps = column((grown**2 - 1) / 2, (grown**2 - 1) / 2, 0)
    assert np.abs(heated(eps, (1 - grown) * b, b, 100.0).forces).max() < 1e-9
    assert np.abs(heated(eps, ZERO, b, 100.0).forces).max() > 1.0


def test_a_gradient_bends_a_flat_plate_without_stress():
    """The stretch 1 + alpha (T0 + z T1) at each height, of normals that grow with T0."""
    middle, gradient = 100.0, 4000.0
    grown, slope = 1.02, 2e-4 * gradient
    eps = column((grown**2 - 1) / 2, (grown**2 - 1) / 2, 0)
    assert np.abs(heated(eps, column(slope, slope, 0), ZERO, middle, gradient).forces).max() < 1e-9


def test_the_first_place_that_fails_is_named():
    kappa = np.array([[0.0, 1.0, 25.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    eps = np.zeros((3, 3))
    eps[0] = [0.0, 0.0, -0.5]  # no length left in the middle of the third
    found = respond(RUBBER, eps, kappa, np.zeros((3, 3)))
    place, height, code = found.first_failure
    assert place == 2 and code == 1 and found.code[height, 2] == 1
    assert np.isnan(found.energy[2]) and np.isfinite(found.energy[:2]).all()
    assert respond(RUBBER, ZERO, ZERO).first_failure is None
    with pytest.raises(BeyondLaw):
        RUBBER.plane_stress(column(-1.0, 1.0, 0.0))


def test_a_centre_of_curvature_within_the_section_is_refused():
    z, _ = heights(section_of(RUBBER, H), 3)
    require_one_side(z, column(5.0, 5.0, 0.0))
    with pytest.raises(sk.errors.InputError, match="past a centre of curvature"):
        require_one_side(z, column(40.0, 0.0, 0.0))
