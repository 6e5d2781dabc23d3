"""Laws at points: stresses and stiffnesses against published values, exact ones and differences."""

from dataclasses import replace

import numpy as np
import pytest

import skancf as sk
from skancf.materials import Gent, MooneyRivlin, NeoHooke, Ogden, Yeoh, section_of
from skancf.materials.point_law import PAIRS, PAIRS_3D, BeyondLaw

MU, RHO = 1.5e6, 1000.0
OGDEN = [(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)]
"""Of shear modulus 4.225e5 (Ogden 1972)."""


def scaled(mu):
    return [(m * mu / 4.225e5, alpha) for m, alpha in OGDEN]


def laws(mu=MU, **more):
    return {
        "NH": NeoHooke(mu, RHO, **more),
        "MR": MooneyRivlin(7 / 16 * mu, mu / 16, RHO, **more),
        "OG": Ogden(scaled(mu), RHO, **more),
        "Yeoh": Yeoh(mu / 2, -0.05 * mu, 0.01 * mu, RHO, **more),
        "Gent": Gent(mu, 30.0, RHO, **more),
    }


COMPRESSIBLE = {f"{name}, {nu}": law for nu in (0.0, 0.3, 0.45, 0.4999) for name, law in laws(poisson=nu).items()}
ALL = {**COMPRESSIBLE, **laws()}
every_law = pytest.mark.parametrize("law", ALL.values(), ids=ALL)


def uniaxial(law, stretch):
    """Stretches across, in the plane and out of it, and Cauchy's stress, under tension along 1: Newton's method on C22."""
    C22 = 1 / stretch
    for _ in range(50):
        found = law.plane_stress([[stretch**2], [C22], [0.0]])
        change = -2 * found.stress[1, 0] / found.stiffness[1, 0]
        C22 += change
        if abs(change) < 1e-15:
            break
    width, height = np.sqrt(C22), np.sqrt(found.stretch33[0])
    J = stretch * width * height
    return J, width, height, found.stress[0, 0] * stretch**2 / J


@pytest.mark.parametrize(
    ("name", "J", "width", "cauchy"),
    [
        ("NH", 1.105598565, 0.743504729, 4.374167e6),
        ("MR", 1.099905842, 0.741588107, 4.148532e6),
        ("OG", 1.088778638, 0.737827432, 3.704423e6),
    ],
)
def test_compressible_rubber_in_tension(name, J, width, cauchy):
    """Unit tests of G+Smo's hyperelastic materials: volume at the stretch 2, mu = 1.5 MPa, nu = 0.45, to its ten digits."""
    found = uniaxial(laws(poisson=0.45)[name], 2.0)
    assert found[0] == pytest.approx(J, abs=1e-9)
    assert found[1] == pytest.approx(width, abs=1e-9)
    assert found[2] == pytest.approx(found[1], rel=1e-12)  # isotropic: as thin as it is narrow
    assert found[3] == pytest.approx(cauchy, rel=2e-7)
    # Another ratio is another volume: the digits are those of the law.
    assert abs(uniaxial(laws(poisson=0.449)[name], 2.0)[0] - J) > 1e-3


def tension(name, stretch, mu=MU):
    """Exact Cauchy stress of an incompressible law in tension."""
    l, i1, i2 = stretch, stretch**2 + 2 / stretch - 3, 2 * stretch + stretch**-2 - 3
    w1, w2 = {
        "NH": (mu / 2, 0.0), "MR": (7 / 16 * mu, mu / 16), "Yeoh": (mu / 2 - 0.1 * mu * i1 + 0.03 * mu * i1**2, 0.0),
        "Gent": (mu / 2 / (1 - i1 / 30), 0.0), "OG": (0.0, i2 * 0),
    }[name]  # fmt: skip
    if name == "OG":
        return sum(m * (l**a - l ** (-a / 2)) for m, a in scaled(mu))
    return 2 * (l**2 - 1 / l) * (w1 + w2 / l)


@pytest.mark.parametrize("name", laws())
@pytest.mark.parametrize("stretch", [0.3, 0.9, 1.000001, 2.0, 4.0])
def test_incompressible_rubber_in_tension(name, stretch):
    J, width, height, cauchy = uniaxial(laws()[name], stretch)
    assert pytest.approx(1.0, abs=1e-14) == J
    assert width == pytest.approx(stretch**-0.5, rel=1e-13)
    assert height == pytest.approx(stretch**-0.5, rel=1e-13)
    assert cauchy == pytest.approx(tension(name, stretch), rel=1e-12, abs=1e-15 * MU)


def balloon(law, stretch, R=10.0, t=0.1):
    """Pressure in a thin sphere, p = 2 t S / (R lambda)."""
    found = law.plane_stress(np.array([stretch**2, stretch**2, 0 * stretch]))
    assert found.stress[0] == pytest.approx(found.stress[1], rel=1e-13)
    return 2 * t / R * found.stress[0] / stretch


@pytest.mark.parametrize(
    ("name", "largest", "at", "two", "three"),
    [
        ("NH", 5236.73, 1.38309, 4158.98, 2812.80),
        ("MR", 5945.96, 1.53519, 5718.61, 5625.61),
        ("OG", 5494.12, 1.37405, 4108.07, 2734.90),
    ],
)
def test_pressure_of_a_balloon(name, largest, at, two, three):
    """Closed form, Kiendl et al. (2015): p = 2 t / R sum mu_p (l^(a_p - 3) - l^(-2 a_p - 3))."""
    mu, law = 4.225e5, laws(4.225e5)[name]
    pairs = {"NH": [(mu, 2)], "MR": [(7 / 8 * mu, 2), (-mu / 8, -2)], "OG": OGDEN}[name]
    l = np.linspace(1.0, 4.0, 400)
    exact = 0.02 * sum(m * (l ** (a - 3) - l ** (-2 * a - 3)) for m, a in pairs)
    p = balloon(law, l)
    assert np.abs(p - exact).max() < 1e-12 * exact.max()
    assert np.allclose(balloon(law, np.array([2.0, 3.0])), [two, three], rtol=2e-6)  # printed with six digits
    near = at + np.linspace(-0.02, 0.02, 401)
    fit = np.polynomial.Polynomial.fit(near, balloon(law, near), 6)
    top = next(r.real for r in fit.deriv().roots() if abs(r - at) < 0.02)
    assert top == pytest.approx(at, abs=1e-5)
    assert fit(top) == pytest.approx(largest, abs=1e-2)


def square(six):
    D = np.empty((3, 3, six.shape[1]))
    for entry, (k, l) in zip(six, PAIRS, strict=True):
        D[k, l] = D[l, k] = entry
    return D


def states(law, rng, n=60):
    """C of random stretches and shears, equal stretches too."""
    F = np.eye(2)[:, :, None] + 0.35 * rng.uniform(-1, 1, (2, 2, n))
    F[:, :, 0], F[:, :, 1], F[:, :, 2] = np.eye(2), 1.7 * np.eye(2), np.diag([1.5, 1.5 + 1e-9])
    C = np.einsum("kin,kjn->ijn", F, F)
    return np.array([C[0, 0], C[1, 1], C[0, 1]])


@every_law
def test_stress_and_stiffness_are_derivatives(law):
    """Central differences with two steps, extrapolated: errors of the sixth power of what is left, and rounding over it."""
    C = states(law, np.random.default_rng(3))
    found = law.plane_stress(C)
    D = square(found.stiffness)
    scale = np.abs(D).max(axis=(0, 1))
    # Pressure is rounded by 1e-16 of the bulk modulus, which the step divides.
    bound = 1e-9 if law.rest_poisson < 0.49 or law.incompressible else 3e-8
    for j, factor in enumerate((2.0, 2.0, 1.0)):
        unit = np.zeros((3, 1))
        unit[j] = 1.0
        slopes = []
        for h in (2e-3, 1e-3, 5e-4):
            up, down = (law.plane_stress(C + sign * h * unit, found.stretch33) for sign in (1, -1))
            slopes.append(np.vstack([(up.energy - down.energy)[None], up.stress - down.stress]) * factor / (2 * h))
        first, second = (4 * slopes[1] - slopes[0]) / 3, (4 * slopes[2] - slopes[1]) / 3
        slope = (16 * second - first) / 15
        assert np.abs(slope[0] - found.stress[j]).max() < 1e-9 * scale.max()
        assert (np.abs(slope[1:] - D[:, j]).max(axis=0) / scale).max() < bound
    # Half the stiffness of a shear would be seen.
    assert np.abs(D[2, 2]).max() > 0.1 * scale.max()


@every_law
def test_small_strain_is_that_of_the_linear_law(law):
    found = law.plane_stress([[1.0], [1.0], [0.0]])
    assert found.energy[0] == 0 and not found.stress.any() and found.stretch33[0] == 1
    D = square(found.stiffness)[:, :, 0]
    assert np.abs(D - law.in_plane_stiffness()).max() < 1e-12 * D.max()
    nu = law.rest_poisson
    if nu < 0.5:
        linear = sk.Isotropic(2 * MU * (1 + nu), nu, RHO) if law.shear_modulus == MU else None
        assert linear is None or np.abs(law.stiffness() - linear.stiffness()).max() < 1e-13 * D.max()
    E = 1e-7 * np.array([1.0, -3.0, 2.0])
    small = law.plane_stress(np.array([[1 + 2 * E[0]], [1 + 2 * E[1]], [E[2]]]))
    assert small.stress[:, 0] == pytest.approx(D @ E, abs=3e-6 * D[0, 0] * E.max())  # and products of strains
    # C itself is rounded by 1e-16, strain by 1e-9 of itself: the energy, 1e-14 of the shear modulus, has these digits too.
    assert small.energy[0] == pytest.approx(E @ D @ E / 2, rel=5e-6)
    assert (small.stretch33[0] - 1) / 2 == pytest.approx(law.thinning() @ E, abs=3e-6 * E.max())


@every_law
def test_a_frame_turned_in_the_plane_changes_nothing(law):
    rng = np.random.default_rng(5)
    C = states(law, rng)
    cos, sin = np.cos(0.7), np.sin(0.7)
    turned = np.array([
        cos * cos * C[0] + sin * sin * C[1] + 2 * sin * cos * C[2],
        sin * sin * C[0] + cos * cos * C[1] - 2 * sin * cos * C[2],
        sin * cos * (C[1] - C[0]) + (cos * cos - sin * sin) * C[2],
    ])  # fmt: skip
    one, two = law.plane_stress(C), law.plane_stress(turned)
    assert two.energy == pytest.approx(one.energy, rel=1e-11, abs=1e-14 * MU)
    s = one.stress
    back = cos * cos * s[0] + sin * sin * s[1] + 2 * sin * cos * s[2]
    assert two.stress[0] == pytest.approx(back, rel=1e-10, abs=1e-12 * MU)


@pytest.mark.parametrize("law", COMPRESSIBLE.values(), ids=COMPRESSIBLE)
def test_the_thickness_is_found_from_afar(law):
    C = states(law, np.random.default_rng(11))
    C = np.hstack([C, [[9.0, 0.3, 25.0, 2.0], [4.0, 0.5, 0.1, 2.0], [0.5, 0.05, 0.1, 1.5]]])
    found = law.plane_stress(C)
    for guess in (1e-12, 1e-3, 1e3, 1e12):
        again = law.plane_stress(C, np.full(C.shape[1], guess))
        assert again.stretch33 == pytest.approx(found.stretch33, rel=1e-12)
    warm = law.plane_stress(C, found.stretch33)
    assert warm.stretch33 == pytest.approx(found.stretch33, rel=1e-14)


def test_nearly_incompressible_goes_to_incompressible():
    C = states(None, np.random.default_rng(2))
    for name, law in laws().items():
        exact = law.plane_stress(C).stress
        errors = [
            np.abs(laws(bulk=k * MU)[name].plane_stress(C).stress - exact).max() / np.abs(exact).max()
            for k in (1e3, 1e4, 1e5)
        ]
        assert errors[0] < 1e-2
        assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.05)
        assert errors[2] / errors[1] == pytest.approx(0.1, rel=0.05)


def test_ogden_has_neo_hooke_and_mooney_rivlin_in_it():
    C = states(None, np.random.default_rng(8))
    for more in ({}, {"poisson": 0.4}):
        pairs = {"NH": [(MU, 2.0)], "MR": [(7 / 8 * MU, 2.0), (-MU / 8, -2.0)]}
        for name, terms in pairs.items():
            one, two = laws(**more)[name].plane_stress(C), Ogden(terms, RHO, **more).plane_stress(C)
            assert np.abs(one.stress - two.stress).max() < 1e-13 * np.abs(one.stress).max()
            assert np.abs(one.stiffness - two.stiffness).max() < 1e-12 * np.abs(one.stiffness).max()
            assert np.abs(one.energy - two.energy).max() < 1e-13 * np.abs(one.energy).max()


def test_stretches_nearly_equal_make_no_noise():
    """The quotient of differences of equal stretches: stiffness to rounding, whatever their difference."""
    law = Ogden(scaled(MU), RHO)
    gaps = np.concatenate([[0.0], np.logspace(-17, -3, 15)])
    D = law.plane_stress(np.array([1.44 + gaps, np.full(16, 1.44), np.zeros(16)])).stiffness
    slope = (D[2, -1] - D[2, 0]) / gaps[-1]
    assert np.abs(D[2] - D[2, 0] - slope * gaps).max() < 2e-6 * D[2, 0]  # quadratic in the largest gap
    assert np.abs(D[2, :8] - D[2, 0]).max() < 1e-9 * D[2, 0]


@pytest.mark.parametrize("law", [*laws().values(), *laws(poisson=0.3).values()])
def test_what_has_no_area_is_refused_by_its_place(law):
    C = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.1, 0.0]])
    found = law.respond(C)
    assert list(found.code != 0) == [False, True, True] and found.first_failure == 1
    assert np.isnan(found.stress[:, 1:]).all() and np.isfinite(found.stress[:, 0]).all()
    with pytest.raises(BeyondLaw, match=r"at point 1 of 3, C = \(1, 1, 1\.1\).*no area left") as caught:
        law.plane_stress(C)
    assert caught.value.point == 1


@pytest.mark.parametrize("more", [{}, {"poisson": 0.3}])
def test_a_stretch_beyond_the_limit_of_gent(more):
    law = Gent(MU, 5.0, RHO, **more)
    fine = law.plane_stress([[6.0], [1.0], [0.0]])
    assert np.isfinite(fine.stress).all()
    if more:  # at the volume that it had, this is beyond the limit, and it thickens
        swollen = law.plane_stress([[30.0], [1.0], [0.0]])
        assert np.isfinite(swollen.stress).all() and swollen.stretch33[0] > 1 / 30
    with pytest.raises(BeyondLaw, match=r"beyond what the law allows.*must stay below most = 5"):
        law.plane_stress([[1.0, 1e3], [1.0, 1.0], [0.0, 0.0]])


def test_input_is_checked():
    with pytest.raises(sk.errors.InputError, match=r"give \(3, n\) numbers"):
        NeoHooke(1.0, 1.0).plane_stress([1.0, 1.0, 0.0])
    for build, text in (
        (lambda: NeoHooke(-1.0, 1.0), "shear = -1"),
        (lambda: NeoHooke(1.0, 0.0), "density = 0"),
        (lambda: NeoHooke(1.0, 1.0, poisson=0.51), "poisson = 0.51"),
        (lambda: NeoHooke(1.0, 1.0, poisson=0.4, bulk=2.0), "one follows from the other"),
        (lambda: MooneyRivlin(1.0, -2.0, 1.0), "shear modulus"),
        (lambda: Ogden([1.0, 2.0], 1.0), "give pairs"),
        (lambda: Ogden([(1.0, 0.0)], 1.0), "an exponent is zero"),
        (lambda: Ogden([(1.0, -2.0)], 1.0), "shear modulus"),
        (lambda: Gent(1.0, 0.0, 1.0), "most = 0"),
    ):
        with pytest.raises(sk.errors.InputError, match=text):
            build()


def test_bulk_modulus_and_ratio_say_the_same():
    by_ratio = NeoHooke(MU, RHO, poisson=0.45)
    by_bulk = replace(by_ratio, poisson=None, bulk=by_ratio.bulk_modulus)
    assert by_bulk.rest_poisson == pytest.approx(0.45, rel=1e-14)
    assert NeoHooke(MU, RHO, poisson=0.5).incompressible and NeoHooke(MU, RHO).incompressible


SOLID = {name: law for name, law in ALL.items() if not name.startswith("OG") and law.rest_poisson < 0.5}
ROWS, COLUMNS = [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]


@pytest.mark.parametrize("law", SOLID.values(), ids=SOLID)
def test_in_three_dimensions(law):
    """Derivatives by differences; where S33 is zero it is plane stress; at rest it is Hooke's law."""
    F = np.eye(3)[:, :, None] + 0.2 * np.random.default_rng(0).uniform(-1, 1, (3, 3, 20))
    F[:, :, 0] = np.eye(3)
    C = np.einsum("kin,kjn->ijn", F, F)[ROWS, COLUMNS]
    found = law.respond3d(C)
    D = np.empty((6, 6, 20))
    for entry, (k, l) in zip(found.stiffness, PAIRS_3D, strict=True):
        D[k, l] = D[l, k] = entry
    size = np.abs(D).max()
    for m in range(6):
        unit = 1e-5 * np.eye(6)[:, [m]]
        up, down = law.respond3d(C + unit), law.respond3d(C - unit)
        factor = (2 if m < 3 else 1) / 2e-5
        assert np.abs(factor * (up.energy - down.energy) - found.stress[m]).max() < 1e-9 * size
        assert np.abs(factor * (up.stress - down.stress) - D[:, m]).max() < 2e-9 * size  # third derivatives by 1e-10
    nu, mu = law.rest_poisson, law.shear_modulus
    lame = law.bulk_modulus - 2 / 3 * mu
    hooke = np.diag([2 * mu] * 3 + [mu] * 3)
    hooke[:3, :3] += lame
    assert np.abs(D[:, :, 0] - hooke).max() < 1e-12 * size and np.isfinite(nu)
    plane = law.plane_stress(C[[0, 1, 5]])
    zero = np.zeros(20)
    same = law.respond3d(np.array([C[0], C[1], plane.stretch33, zero, zero, C[5]]))
    assert np.abs(same.stress[[0, 1, 5]] - plane.stress).max() < 1e-12 * size and np.abs(same.stress[2]).max() < 1e-12 * size


def test_solids_need_a_compressible_law_of_invariants():
    C = np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    found = NeoHooke(MU, RHO, poisson=0.3).respond3d(C)
    assert list(found.code) == [0, 1] and np.isnan(found.stress[:, 1]).all()
    for law, text in (
        (NeoHooke(MU, RHO), "incompressible.*theory 'kirchhoff'"),
        (laws(poisson=0.3)["OG"], "three dimensions"),
    ):
        with pytest.raises(sk.errors.InputError, match=text):
            law.respond3d(C)


class Square:
    """St. Venant-Kirchhoff, written by a user: right, or with one mistake."""

    density = 1000.0

    def __init__(self, mistake=""):
        self.mistake = mistake

    def plane_stress(self, C, guess=None):
        E = np.array([(C[0] - 1) / 2, (C[1] - 1) / 2, C[2]])
        young, nu = 2e6, 0.3
        plane = young / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
        stress = plane @ E
        energy = 0.5 * (E * stress).sum(axis=0)
        entries = np.array([plane[k, l] for k, l in PAIRS])
        if self.mistake == "energy":
            energy = energy + 1e6 * E[0] ** 3
        elif self.mistake == "shear":
            stress = stress * [[1], [1], [2]]
        elif self.mistake == "stiffness":
            entries[3] *= 1.01
        elif self.mistake == "rest":
            stress = stress + 10.0
        elif self.mistake == "constant":
            energy = energy + 5.0
        elif self.mistake == "softer at rest":
            entries = 0.99 * entries
        elif self.mistake == "complex":
            stress = stress + 0j
        elif self.mistake == "text":
            energy = energy.astype(str)
        elif self.mistake == "list":
            return [energy, stress, entries, energy]
        elif self.mistake == "ends early":
            energy = np.where(E[0] > 0.005, np.nan, energy)
        elif self.mistake == "turned over":
            return energy, stress, np.repeat(entries[:, None], C.shape[1], axis=1), 1 - 60 * (E[0] + E[1])
        elif self.mistake == "shape":
            stress = stress[:2]
        elif self.mistake == "nan":
            stress = stress * np.nan
        c33 = 1 - nu / (1 - nu) * 2 * (E[0] + E[1])
        if self.mistake == "thickness":
            c33 = c33 + 1.0
        return energy, stress, np.repeat(entries[:, None], C.shape[1], axis=1), c33


def test_a_law_of_ones_own():
    law = Square()
    assert max(sk.testing.check_law(law).values()) < 1e-10
    section = sk.Problem(surface=sk.Rectangle(1.0, 1.0), thickness=0.1, material=law).section
    linear = section_of(sk.Isotropic(2e6, 0.3, 1000.0), 0.1)
    assert np.abs(section.abd() - linear.abd()).max() < 1e-9 * linear.abd().max()
    assert section.thinning[0] == pytest.approx(linear.thinning[0], abs=1e-9)
    assert np.allclose(section.shear_stiffness(), linear.shear_stiffness(), rtol=1e-9)
    assert section.mass == linear.mass
    E = np.array([0.2, -0.1, 0.05])
    found = section.points_law.respond((np.array([[1.0], [1.0], [0.0]]).T + E * [2, 2, 1]).T.copy())
    assert found.stress[:, 0] == pytest.approx(linear.in_plane()[0] @ E, rel=1e-12)


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("energy", "stress against energy: at C = .* S11 is .* and the difference of energy by the strain 11"),
        ("shear", "stress against energy: .* S12 is .* factors of two of the shear"),
        ("stiffness", r"stiffness against stress: .* D2211 is .*|stiffness against stress: .* D1122"),
        ("rest", "has the stress S11 = 10"),
        ("constant", "has the energy 5 J/m3"),
        ("shape", r"give a PointResponse, or energy \(n,\)"),
        ("nan", "it has no stress or no stiffness"),
        ("thickness", "C33 of the undeformed state is 2"),
        ("softer at rest", "stiffness against stress: at C = .* D1111 is .* and the difference of S11"),
        ("complex", "its stress is .* give real numbers"),
        ("text", "its energy is .* give real numbers"),
        ("list", r"returned \[.* \(a list\); give a PointResponse"),
        ("ends early", r"at C = \(1.02, 0.98, 0.02\) it has no finite energy"),
        ("turned over", r"at C = \(1.05, 1, 0.01\) C33 is -"),
    ],
)
def test_a_law_that_contradicts_itself_is_refused_before_any_work(mistake, message):
    with pytest.raises(sk.errors.InputError, match=message):
        sk.Problem(surface=sk.Rectangle(1.0, 1.0), thickness=0.1, material=Square(mistake))


def test_what_remembers_and_what_has_no_density_is_refused():
    law = Square()
    law.n_history = 4
    with pytest.raises(sk.errors.InputError, match="laws with memory cannot be solved yet"):
        section_of(law, 0.1)
    law = Square()
    law.density = None
    with pytest.raises(sk.errors.InputError, match="density"):
        section_of(law, 0.1)


def test_a_law_without_a_guess_and_one_of_another_small_strain():
    class Plain(Square):
        def plane_stress(self, C):
            return Square.plane_stress(self, C)

    assert section_of(Plain(), 0.1).abd() == pytest.approx(section_of(Square(), 0.1).abd(), rel=1e-12)

    class Told(Square):
        def stiffness(self):
            return self.matrix

    told = Told()
    told.matrix = section_of(Square(), 0.1).stiffness[0]
    assert section_of(told, 0.1).abd() == pytest.approx(section_of(Square(), 0.1).abd(), rel=1e-12)
    told.matrix = 1.01 * told.matrix
    with pytest.raises(sk.InputError, match=r"its entry 11, 11 is .* and that of plane_stress at the undeformed state"):
        section_of(told, 0.1)
    told.matrix = np.eye(3)
    with pytest.raises(sk.InputError, match=r"stiffness\(\) of shape \(3, 3\): a law is a 6 x 6 matrix"):
        section_of(told, 0.1)


def test_laminates_of_rubber_are_refused():
    with pytest.raises(sk.errors.InputError, match=r"layers of NeoHooke.*one layer"):
        sk.Layer(NeoHooke(MU, RHO), 0.01)
    with pytest.raises(sk.errors.InputError, match="needs a thickness"):
        section_of(NeoHooke(MU, RHO), None)


@pytest.mark.parametrize("law", [*laws().values(), *laws(poisson=0.4).values()])
def test_check_law_passes_those_of_the_library(law):
    assert max(sk.testing.check_law(law).values()) < 1e-9
    assert max(sk.testing.check_law(law, states(law, np.random.default_rng(1))).values()) < 1e-6
