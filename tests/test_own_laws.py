"""Laws of the user's own: an energy, differentiated by complex steps; what cannot be differentiated is refused."""

import pickle
from functools import partial

import numba
import numpy as np
import pytest

import skancf as sk
from skancf.errors import InputError
from skancf.materials import Hyperelastic, MooneyRivlin, NeoHooke, Ogden

MU, RHO = 1.5e6, 1000.0
PAIRS = [(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)]


@numba.njit
def mooney(I1, I2, J, par):
    c10, c01, K = par
    return c10 * (J ** (-2 / 3) * I1 - 3) + c01 * (J ** (-4 / 3) * I2 - 3) + K / 4 * (J * J - 1 - 2 * np.log(J))


def mooney_of_components(a, b, c, d, par):
    I3 = (a * b - d * d) * c
    I1, I2 = a + b + c, a * b - d * d + c * (a + b)
    return par[0] * (I3 ** (-1 / 3) * I1 - 3) + par[1] * (I3 ** (-2 / 3) * I2 - 3) + par[2] / 4 * (I3 - 1 - np.log(I3))


def ogden_of_components(a, b, c, d, par):
    """Eigenvalues in the plane, with what keeps the root from zero where they are equal."""
    h, r = (a + b) / 2, np.sqrt(((a - b) / 2) ** 2 + d * d + 1e-20)
    I3, s = (a * b - d * d) * c, 0.0 * a
    for k in range(3):
        m, al = par[1 + 2 * k], par[2 + 2 * k]
        s = s + m / al * (I3 ** (-al / 6) * ((h + r) ** (al / 2) + (h - r) ** (al / 2) + c ** (al / 2)) - 3)
    return s + par[0] / 4 * (I3 - 1 - np.log(I3))


def states(n=40):
    F = np.eye(2)[:, :, None] + 0.3 * np.random.default_rng(4).uniform(-1, 1, (2, 2, n))
    C = np.einsum("kin,kjn->ijn", F, F)
    return np.array([C[0, 0], C[1, 1], C[0, 1]])


@pytest.mark.parametrize("energy", [mooney, mooney_of_components], ids=["invariants", "components"])
@pytest.mark.parametrize("incompressible", [False, True])
def test_an_energy_is_the_law_that_it_writes(energy, incompressible):
    """Steps of 1e-3 with errors of the fourth power, by components of 1e-5 with errors of its square: stiffness to 2e-10
    and 1e-9. Stress and energy to rounding."""
    known = MooneyRivlin(7 / 16 * MU, MU / 16, RHO, poisson=0.5 if incompressible else 0.45)
    bulk = 1.0 if incompressible else known.bulk_modulus
    law = Hyperelastic(energy, (known.c10, known.c01, bulk), RHO, incompressible=incompressible)
    C = states()
    found, exact = law.plane_stress(C), known.plane_stress(C)
    assert np.abs(found.stress - exact.stress).max() < 1e-12 * MU
    digits = 1e-9 if law.of_components else 2e-10
    assert np.abs(found.stiffness - exact.stiffness).max() < digits * np.abs(exact.stiffness).max()
    assert np.abs(found.energy - exact.energy).max() < 1e-13 * MU
    assert np.abs(found.stretch33 - exact.stretch33).max() < 1e-12
    assert np.abs(law.in_plane_stiffness() - known.in_plane_stiffness()).max() < 1e-9 * MU
    assert law.thinning() == pytest.approx(known.thinning(), abs=1e-10)
    plate, exact_plate = law.stiffness(), known.stiffness()
    assert np.delete(np.delete(plate, 2, 0), 2, 1) == pytest.approx(
        np.delete(np.delete(exact_plate, 2, 0), 2, 1), abs=1e-9 * MU
    )
    if not incompressible:  # across it is the modulus of the law itself
        assert plate[2, 2] == pytest.approx(known.bulk_modulus + 4 / 3 * MU, rel=1e-9)


def test_principal_stretches_of_ones_own():
    known = Ogden(PAIRS, RHO, poisson=0.45)
    law = Hyperelastic(ogden_of_components, known.parameters, RHO)
    C = states()
    found, exact = law.plane_stress(C), known.plane_stress(C)
    assert np.abs(found.stress - exact.stress).max() < 1e-10 * known.shear_modulus
    # Where both stretches are nearly equal, the root has no series in a step.
    apart = (C[0] - C[1]) ** 2 + 4 * C[2] ** 2 > 0.1
    assert apart.sum() > 15
    difference = np.abs(found.stiffness - exact.stiffness)[:, apart].max()
    assert difference < 1e-6 * np.abs(exact.stiffness).max()


def quadratic_fibre(a, b, c, d, par):
    """Neo-Hooke with fibres along an angle, which resist by their square strain."""
    mu, k, angle = par
    cos, sin = np.cos(angle), np.sin(angle)
    along = cos * cos * a + sin * sin * b + 2 * sin * cos * d
    return mu / 2 * (a + b + c - 3) + k / 8 * (along - 1) ** 2


def test_fibres_at_an_angle():
    """Stress of the fibres k/2 (C_ff - 1) f f on top of that of the rubber, exactly; stiffness k f f f f."""
    mu, k, angle = 1e5, 1e6, 0.4
    law = Hyperelastic(quadratic_fibre, (mu, k, angle), RHO, incompressible=True)
    C, f = states(), np.array([np.cos(angle), np.sin(angle)])
    ff = np.array([f[0] * f[0], f[1] * f[1], f[0] * f[1]])
    rubber, found = NeoHooke(mu, RHO).plane_stress(C), law.plane_stress(C)
    along = ff[0] * C[0] + ff[1] * C[1] + 2 * ff[2] * C[2]
    assert np.abs(found.stress - rubber.stress - np.outer(ff, k / 2 * (along - 1))).max() < 1e-11 * k
    more = np.array([ff[i] * ff[j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))])
    assert np.abs(found.stiffness - rubber.stiffness - k * more[:, None]).max() < 1e-8 * k
    assert law.in_plane_stiffness()[0, 2] == pytest.approx(k * more[4], rel=1e-8)
    section = sk.Problem(surface=sk.Rectangle(1.0, 1.0), thickness=0.01, material=law).section
    assert section.points_law is law and section.abd()[0, 2] == pytest.approx(0.01 * k * more[4], rel=1e-8)


TABLE = {"mu": 1.0}


def linear(I1, I2, J, par):
    return par[0] * (I1 - 3 - 2 * np.log(J))


class Energy:
    def __call__(self, I1, I2, J, par):
        return linear(I1, I2, J, par)


@pytest.mark.parametrize(
    ("energy", "message"),
    [
        (
            lambda I1, I2, J, par: par[0] * abs(I1 - 3) + (J - 1) ** 2,
            "derivative by I1 .* by a complex step and .* by a differ",
        ),
        (lambda I1, I2, J, par: I1.real - 3 - 2 * np.log(J), "derivative by I1"),
        (lambda I1, I2, J, par: max(I1, 3.0) - 3, "numba cannot compile it for complex numbers"),
        (lambda I1, I2, J, par: np.sqrt((I1 - 3) * (I1 - 3)) + (J - 1) ** 2, "not finite|by a complex step"),
        (lambda I1, I2, J, par: np.log(J - 1), "not finite at I1 = 3, I2 = 3, J = 1"),
        (lambda I1, I2, J, par: (I1 - 3) + (J - 1) ** 2, "undeformed state has stress, the derivative by C"),
        (lambda I1, I2, J, par: I1 - 2 * np.log(J), "it is 3 J/m3 in the undeformed state"),
        (lambda I1, I2, J, par: 2 * np.log(J) - (I1 - 3), "not stable"),
        (lambda I1, I2, J, par: 0.0 * I1, "its derivatives are zero"),
        (lambda I1, I2, J, par: par[7] * (I1 - 3), "asks for more than the 1 parameters"),
        (lambda I1, I2, J, par: "much", "it must return one number"),
        (lambda I1, I2: I1, "a function of 2 arguments"),
        (3.0, "give a function of"),
        (Energy(), "is a Energy; give a function"),
        (partial(mooney), "is a partial; give a function"),
        (lambda I1, I2, J, par: I1 * TABLE["mu"], "Untyped global name 'TABLE'"),
        (lambda I1, I2, J, par: linear(I1, I2, J, par), "Untyped global name 'linear'.*other functions that are compiled"),
        (lambda I1, I2, J, par: (I1 - 3) ** 2 + ((J - 1) ** 2) ** 2, "no stiffness, 0 Pa"),
        (lambda I1, I2, J, par: (par[0] * (I1 - 3 - 2 * np.log(J))).real, "by a complex step"),
        (lambda I1, I2, J, par: par[0] * (np.conj(I1) - 3 - 2 * np.log(J)), "by a complex step"),
        (lambda I1, I2, J, par: par[0] * (I1 - 3 - 2 * np.log(J)) + (J - 1) ** 4, r"such as x\*\*3 of what may be negative"),
        (lambda I1, I2, J, par: np.nan * (I1 - 3 - 2 * np.log(J)), "not finite"),
        (lambda I1, I2, J, par: np.array([I1]), "must return one number"),
        (lambda I1, I2, J, par: (I1, J), "must return one number"),
    ],
)
def test_what_is_no_energy_is_refused(energy, message):
    with pytest.raises(InputError, match=message):
        Hyperelastic(energy, (1.0,), RHO)


@pytest.mark.parametrize("parameters", ["mu", ("a",), ("1e6",), {"mu": 1.0}, None, (np.nan,), (1j,), [[1.0]]])
def test_parameters_that_are_no_row_of_numbers(parameters):
    with pytest.raises(InputError, match=r"parameters.* = |parameters of shape"):
        Hyperelastic(linear, parameters, RHO)


@pytest.mark.parametrize("mu, k", [(-1.0, 2.0), (1.0, -2.0)])
def test_negative_moduli(mu, k):
    with pytest.raises(InputError, match="some strain releases energy"):
        Hyperelastic(lambda I1, I2, J, par: par[0] * (J ** (-2 / 3) * I1 - 3) + par[1] * (J - 1) ** 2, (mu, k), RHO)


def test_an_array_from_around_an_energy_is_that_of_the_time_it_was_compiled():
    moduli = np.array([1.0, 2.0])

    def energy(I1, I2, J, par):
        return moduli[0] * (I1 - 3 - 2 * np.log(J)) + moduli[1] * np.log(J) ** 2

    law = Hyperelastic(energy, (0.0,), RHO)
    assert law.in_plane_stiffness()[2, 2] == pytest.approx(2.0, rel=1e-12)
    moduli[0] = 5.0
    assert law.in_plane_stiffness()[2, 2] == pytest.approx(2.0, rel=1e-12)
    with pytest.raises(InputError, match=r"compiled it is .* has changed since it was compiled; hand such"):
        Hyperelastic(energy, (0.0,), RHO)


def test_an_energy_that_ends_somewhere_names_the_point():
    law = Hyperelastic(lambda I1, I2, J, par: -par[0] * np.log(1 - (I1 - 3) / 2), (1.0,), RHO, True)
    with pytest.raises(InputError, match=r"at point 1 of 2.*beyond what the law allows"):
        law.plane_stress([[1.0, 9.0], [1.0, 1.0], [0.0, 0.0]])  # the complex logarithm of -2.56 is a finite number


def test_one_energy_is_compiled_once_and_can_be_pickled():
    one, two = (Hyperelastic(mooney, (MU, 0.1 * MU, k * MU), RHO) for k in (10, 20))
    assert one.compiled is two.compiled and one != two
    again = pickle.loads(pickle.dumps(one))
    assert np.array_equal(again.plane_stress(states()).stress, one.plane_stress(states()).stress)


def test_an_incompressible_energy_in_theory_full_is_told_what_it_lacks():
    law = Hyperelastic(lambda I1, I2, J, par: par[0] * (I1 - 3), (MU,), RHO, incompressible=True)
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.1, law, [sk.Clamp("left")])
    with pytest.raises(InputError, match=r"Hyperelastic: it is incompressible.* give energy a term of the volume J"):
        problem.on(sk.meshes.uniform(surface, 1, 1), "full")
