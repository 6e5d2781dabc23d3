"""Laws: definite, turned rightly, condensed rightly, and checked on the way in."""

import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.materials import ALL

# Products and one inverse of 6 x 6 matrices whose condition is below 100.
ROUNDING = 1e-13
KINDS = ("plane_stress", "3d")
IN_PLANE, TRANSVERSE = [0, 1, 5], [3, 4]


def a_matrix():
    root = np.random.default_rng(4).normal(size=(6, 6))
    return 1e9 * (root @ root.T + 2 * np.eye(6))


def isotropic(**options):
    return sk.Isotropic(2e11, 0.3, 7800.0, **options)


def orthotropic(**options):
    """Carbon fibre and resin, roughly."""
    return sk.Orthotropic((1.77e11, 1.08e10, 1.2e10), (0.27, 0.25, 0.4), (7.6e9, 7.0e9, 8.5e9), 1600.0, **options)


def anisotropic(**options):
    return sk.Anisotropic(a_matrix(), 1000.0, **options)


MAKERS = [isotropic, orthotropic, anisotropic]
makers = pytest.mark.parametrize("make", MAKERS)
kinds = pytest.mark.parametrize("kind", KINDS)


def close(a, b, rtol=ROUNDING):
    return np.abs(a - b).max() <= rtol * np.abs(b).max()


def rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])


VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def turned_by_tensor(C, angle):
    """The plain twin: rotate the fourth-order tensor index by index."""
    full = np.zeros((3, 3, 3, 3))
    for a, (i, j) in enumerate(VOIGT):
        for b, (k, l) in enumerate(VOIGT):
            for x, y in ((i, j), (j, i)):
                for z, w in ((k, l), (l, k)):
                    full[x, y, z, w] = C[a, b]
    Q = rotation(angle).T  # material axes as columns, in the frame of the surface
    full = np.einsum("ia,jb,kc,ld,abcd->ijkl", Q, Q, Q, Q, full)
    return np.array([[full[i, j, k, l] for k, l in VOIGT] for i, j in VOIGT])


def test_every_law_is_tested():
    assert {type(make()) for make in MAKERS} == set(ALL)


@makers
@kinds
def test_symmetric_positive_definite(make, kind):
    C = make(kind=kind, **({} if make is isotropic else {"angle": 0.7})).stiffness()
    assert C.shape == (6, 6) and close(C, C.T)
    assert np.linalg.eigvalsh(C)[0] > 0


@makers
@kinds
def test_stress_is_the_derivative_of_the_energy(make, kind, rng):
    """Of the whole library: the law is a matrix, the energy is that of a homogeneous plate."""
    C, strain, eps = make(kind=kind).stiffness(), rng.normal(size=6), 1e-4
    unit = eps * np.eye(6)
    difference = [((strain + e) @ C @ (strain + e) - (strain - e) @ C @ (strain - e)) / (4 * eps) for e in unit]
    # Quadratic, so that only rounding over the step is left: 1e-16 / 1e-4.
    assert close(C @ strain, np.array(difference), 1e-10)
    assert not close(C.T @ strain + 1e-3 * np.abs(C).max(), np.array(difference), 1e-10)


@pytest.mark.parametrize("make", [orthotropic, anisotropic])
@kinds
def test_turn_by_a_quarter_a_whole_and_any_angle(make, kind):
    C = make(kind=kind).stiffness()
    quarter = make(kind=kind, angle=np.pi / 2).stiffness()
    # 1 -> 2 and 2 -> -1: normal components change places, 23 and 13 too, with signs for odd powers of direction 1.
    swap, sign = [1, 0, 2, 4, 3, 5], np.array([1, 1, 1, -1, 1, -1])
    assert close(quarter, (C * np.outer(sign, sign))[np.ix_(swap, swap)])
    assert close(make(kind=kind, angle=2 * np.pi).stiffness(), C)
    assert close(make(kind=kind, angle=0.6).stiffness(), turned_by_tensor(C, 0.6))
    assert not close(make(kind=kind, angle=-0.6).stiffness(), turned_by_tensor(C, 0.6), 1e-3), "the sign counts"


def test_isotropic_laws_have_no_direction():
    for kind in KINDS:
        C = isotropic(kind=kind, shear_correction=1.0).stiffness()
        assert close(turned_by_tensor(C, 0.6), C)


def test_isotropic_numbers():
    E, nu = 2e11, 0.3
    plane = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    C = isotropic().stiffness()
    assert close(C[np.ix_(IN_PLANE, IN_PLANE)], plane)
    assert np.abs(C[2, [0, 1, 3, 4, 5]]).max() == 0, "the thickness strain is uncoupled"
    three = isotropic(kind="3d", shear_correction=1.0).stiffness()
    compliance = np.diag([1 / E] * 3 + [2 * (1 + nu) / E] * 3)
    compliance[:3, :3] -= nu / E * (1 - np.eye(3))
    assert close(three, np.linalg.inv(compliance))
    assert np.isclose(C[2, 2], three[2, 2], rtol=ROUNDING)
    # What a plate with the 3D law loses in bending: (1 - nu)^2 / (1 - 2 nu) times too stiff.
    assert np.isclose(three[0, 0] / C[0, 0], (1 - nu) ** 2 / (1 - 2 * nu), rtol=ROUNDING)


def test_three_laws_say_the_same_of_an_isotropic_material():
    E, nu = 2e11, 0.3
    G = E / 2 / (1 + nu)
    by_constants = sk.Orthotropic((E, E, E), (nu, nu, nu), (G, G, G), 7800.0, angle=0.3)
    by_matrix = sk.Anisotropic(isotropic(kind="3d", shear_correction=1.0).stiffness(), 7800.0)
    for law in (by_constants, by_matrix):
        assert close(law.stiffness(), isotropic().stiffness())


def test_orthotropic_numbers():
    """The plane block is the inverse of the in-plane compliance, whatever the thickness direction does."""
    law = orthotropic()
    (e1, e2, _), (nu12, _, _), (g12, g13, g23) = law.young, law.poisson, law.shear
    compliance = np.array([[1 / e1, -nu12 / e1, 0], [-nu12 / e1, 1 / e2, 0], [0, 0, 1 / g12]])
    C = law.stiffness()
    assert close(C[np.ix_(IN_PLANE, IN_PLANE)], np.linalg.inv(compliance))
    assert close(C[TRANSVERSE, TRANSVERSE], 5 / 6 * np.array([g23, g13]))


@makers
@kinds
def test_shear_correction_scales_transverse_shear_only(make, kind):
    one, half = (make(kind=kind, shear_correction=k).stiffness() for k in (1.0, 0.5))
    block = np.ix_(TRANSVERSE, TRANSVERSE)
    rest = np.ix_([0, 1, 2, 5], [0, 1, 2, 5])
    assert close(half[block], 0.5 * one[block]) and np.array_equal(half[rest], one[rest])
    assert np.isclose(make(kind=kind).stiffness()[3, 3], 5 / 6 * one[3, 3], rtol=ROUNDING), "5/6 by default"


def test_plane_stress_block_has_no_normal_stress(rng):
    """Condensed: the strain that makes S33 = 0 in the 3D law gives the same in-plane stress."""
    three = anisotropic(kind="3d", shear_correction=1.0).stiffness()
    plane = anisotropic(kind="plane_stress", shear_correction=1.0).stiffness()
    strain = rng.normal(size=6)
    strain[2] = 0
    with_thinning = strain.copy()
    with_thinning[2] = -three[2] @ strain / three[2, 2]
    rest = [0, 1, 3, 4, 5]
    assert close((plane @ strain)[rest], (three @ with_thinning)[rest])
    assert not close((three @ strain)[rest], (three @ with_thinning)[rest], 1e-3)


def test_stiffness_cannot_be_changed_from_outside():
    for make in MAKERS:
        law = make()
        law.stiffness()[:] = 0
        assert law.stiffness()[0, 0] > 0


ORTHO = {"young": (3.0, 2.0, 1.0), "poisson": (0.2, 0.2, 0.2), "shear": (1.0, 1.0, 1.0), "density": 1.0}
NOT_SYMMETRIC = np.eye(6) + np.eye(6, k=1)
BAD = [
    (lambda: sk.Isotropic(1.0, 0.5, 1.0), "poisson = 0.5"),
    (lambda: sk.Isotropic(1.0, -1.0, 1.0), "-1 < poisson < 0.5"),
    (lambda: sk.Isotropic(1.0, float("nan"), 1.0), "poisson = nan.*finite"),
    (lambda: sk.Isotropic(0.0, 0.3, 1.0), "young = 0.0 Pa.*greater than zero"),
    (lambda: sk.Isotropic(-1.0, 0.3, 1.0), "young = -1.0"),
    (lambda: sk.Isotropic(float("inf"), 0.3, 1.0), "young = inf"),
    (lambda: sk.Isotropic("steel", 0.3, 1.0), "young = 'steel': not a number"),
    (lambda: sk.Isotropic(1.0, 0.3, 0.0), "density = 0.0 kg/m3"),
    (lambda: sk.Isotropic(1.0, 0.3, 1.0, kind="2d"), "kind = '2d'.*plane_stress.*3d"),
    (lambda: sk.Isotropic(1.0, 0.3, 1.0, shear_correction=0.0), "shear_correction = 0.0"),
    (lambda: sk.Orthotropic(**{**ORTHO, "young": (1.0, -2.0, 1.0)}), "young = -2.0"),
    (lambda: sk.Orthotropic(**{**ORTHO, "shear": (1.0, 0.0, 1.0)}), "shear = 0.0"),
    (lambda: sk.Orthotropic(**{**ORTHO, "poisson": (0.2, float("nan"), 0.2)}), "poisson.*finite"),
    (lambda: sk.Orthotropic(**{**ORTHO, "poisson": (2.0, 0.2, 0.2)}), "Orthotropic.*not positive definite"),
    (lambda: sk.Orthotropic(**ORTHO, angle=float("inf")), "angle = inf"),
    (lambda: sk.Anisotropic(NOT_SYMMETRIC, 1.0), "Anisotropic.*not symmetric"),
    (lambda: sk.Anisotropic(np.diag([1.0, 1, 1, 1, 1, -1]), 1.0), "not positive definite"),
    (lambda: sk.Anisotropic(np.diag([1.0, 1, 1, 1, 1, 0]), 1.0), "not positive definite"),
    (lambda: sk.Anisotropic(np.diag([1.0, 1, np.nan, 1, 1, 1]), 1.0), "(?s)matrix.*finite"),
    (lambda: sk.Anisotropic(np.eye(3), 1.0), "6 x 6"),
    (lambda: sk.Anisotropic(np.eye(6), -1.0), "density = -1.0"),
]


@pytest.mark.parametrize("make,message", BAD, ids=[m for _, m in BAD])
def test_bad_values_are_named(make, message):
    with pytest.raises(InputError, match=message):
        make()
