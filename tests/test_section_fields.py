"""Thickness, offset and material as functions of place: series, beams, and what a constant function must be."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad

import skancf as sk
from skancf.adaptive import recovery_indicator

L, B, H, E, RHO = 1.0, 0.1, 0.02, 2e11, 7800.0
STRIP = sk.Rectangle(L, B)
NO_POISSON = sk.Isotropic(E, 0.0, RHO)
INSIDE = np.array([[0.1, 0.5, 0.9], [0.2, 0.6, 1.0]])
SAME = 1e-14
theories = pytest.mark.parametrize("theory", ["full", "kirchhoff"])
PLY = sk.Orthotropic((1.4e11, 1e10, 1e10), (0.3, 0.3, 0.4), (5e9, 5e9, 3.5e9), 1600.0, expansion=(-3e-7, 2.8e-5, 3e-5))


def same(one, two, tolerance=SAME):
    one, two = np.asarray(one), np.asarray(two)
    return one.shape == two.shape and np.abs(one - two).max() <= tolerance * np.abs(two).max()


# --- a constant function is a constant -------------------------------------------------------------------------------


def plies(offset=0.0):
    return sk.Laminate([sk.Layer(PLY, 0.006, angle) for angle in (0.0, 1.5, 0.4)], offset=offset)


SHAPES = {"flat": sk.Rectangle(1.0, 0.8), "curved": sk.SphereSector(1.0, (0.6, 1.4), 0.9)}
GIVEN = {
    "thickness": ({"thickness": H, "material": sk.Isotropic(E, 0.3, RHO, expansion=1e-5)},
                  {"thickness": lambda x, y: H, "material": sk.Isotropic(E, 0.3, RHO, expansion=1e-5)}),
    "offset": ({"material": plies(0.02)}, {"material": plies(), "offset": lambda x, y: 0.02 + 0 * x}),
    "material": ({"material": plies(0.01)}, {"material": lambda x, y: plies(0.01)}),
    "zone": ({"thickness": H, "material": NO_POISSON, "offset": 0.01},
             {"zones": [sk.Zone("all", lambda x, y: True, thickness=H, material=NO_POISSON, offset=0.01)]}),
}  # fmt: skip


@theories
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("given", GIVEN)
def test_a_constant_function_is_the_constant(given, shape, theory):
    """In all that a system and its answers say; weight with an offset, heat, and pictures among it."""
    surface, said = SHAPES[shape], []
    height = sk.Problem(surface, **GIVEN[given][0]).section.z[[0, -1]] @ [0.3, 0.7]
    for keywords in GIVEN[given]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", sk.OutOfDepth)
            problem = sk.Problem(
                surface, supports=[sk.Clamp(surface.sides[0])],
                loads=[sk.Gravity((1.0, 2.0, -9.0)), sk.Temperature(10.0, 100.0)], **keywords,
            )  # fmt: skip
            system = problem.on(sk.meshes.uniform(surface, 3, 2), theory)
        move = 1e-3 * np.random.default_rng(1).normal(size=system.n_dofs)
        state = sk.Solution(system, system.undeformed + move)
        sections = system.assembly.sections
        values = {
            "law": sections.law, "moments": sections.moments, "force": system.internal_force(state.q),
            "external": system.external_force(state.q), "energy": state.strain_energy,
            "tangent": system.tangent(state.q).values, "section forces": state.section_forces(INSIDE),
            "recovered": state.recovered_section_forces(INSIDE), "indicator": recovery_indicator(state),
            "nodal stress": state.nodal_stresses("bottom"), "stress": state.recovered_stresses(INSIDE, height),
            "place": state.position([(0.7, 0.3)], "top"), "mises": sk.output.fields.values(state, "mises", 2, None),
            "sample": sk.output.sample(state, 2, "middle").points,
        }  # fmt: skip
        if theory == "kirchhoff":
            values |= {"share": state.shear_share, "shear": state.shear_forces(INSIDE)}
        said.append(values)
    uniform, field = said
    # Sums of products in another order, of stresses that nearly cancel: sharper for what enters a system.
    for name, value in uniform.items():
        assert same(field[name], value, SAME if name in ("law", "moments") else 1e-11), name
    assert isinstance(system.assembly.section.at(INSIDE).thickness, np.ndarray)


def test_equal_elements_share_their_class():
    """A taper along x has as many classes as columns; a uniform section has one, and no field at all."""
    def of(thickness):
        system = sk.Problem(STRIP, thickness, NO_POISSON).on(sk.meshes.uniform(STRIP, 8, 4), "kirchhoff")
        return len(system.assembly.sections.law)

    assert of(H) == 1 and of(lambda x, y: H) == 1 and of(lambda x, y: H * (1 + x)) == 8
    assert of(lambda x, y: H * (1 + x) * (1 + y)) == 32
    assert isinstance(sk.Problem(STRIP, H, NO_POISSON).section, sk.materials.Section)


# --- tapers ----------------------------------------------------------------------------------------------------------

TAPERS = {0.25: (0.41165264, 2 / 3), 0.5: (0.54517744, 1.0), 0.75: (0.84158663, 2.0)}
"""w E I0 / (P L^3) of strips h0 (1 - a x / L) under an end force, and w E I0 / (M L^2) under an end moment."""


def taper(share):
    return lambda x, y: H * (1 - share * x / L)


def deflection(n, share, load, theory="kirchhoff", thickness=None):
    problem = sk.Problem(STRIP, thickness or taper(share), NO_POISSON, [sk.Clamp("left")], [load])
    w = sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, n, 1), theory)).displacement((L, B / 2))[2]
    return w * E * H**3 / 12


@pytest.mark.parametrize("share", TAPERS)
def test_tapered_strips(share):
    force, moment = sk.EdgeLoad("right", (0, 0, 1.0)), sk.EdgeMoment("right", (0, -1.0, 0))
    for load, expected in zip((force, moment), TAPERS[share], strict=True):
        errors = [abs(deflection(n, share, load) / expected - 1) for n in (8, 16)]
        # Order 4, less where the thin end is as thin as a quarter.
        assert errors[1] < 6e-5 and np.log2(errors[0] / errors[1]) > 3.6
        assert abs(deflection(16, share, load, thickness=H) / expected - 1) > 0.1


def test_a_tapered_strip_of_theory_full_has_its_shear_too():
    share, G = 0.5, E / 2
    shear = quad(lambda s: 1 / (5 / 6 * G * H * (1 - share * s)), 0, 1)[0] * L
    expected = TAPERS[share][0] + shear * E * H**3 / 12
    errors = [deflection(n, share, sk.EdgeLoad("right", (0, 0, 1.0)), "full") / expected - 1 for n in (8, 32)]
    # A uniform strip of this theory is 1.5e-4 softer than a beam with shear too, by its free edges.
    assert abs(errors[1]) < 8e-4 and errors[0] < -1e-3


@pytest.mark.parametrize(("growth", "expected"), [(0.5, 0.00209968), (1.0, 0.00123662)])
def test_a_square_plate_that_grows_thicker(growth, expected):
    """Simply supported, uniform load, h0 (1 + l x / a), nu = 0.3: w D0 / (q a^4) of a sine Ritz series in the centre."""
    plate, law = sk.Rectangle(1.0, 1.0), sk.Isotropic(E, 0.3, RHO)
    D = E * H**3 / 12 / (1 - 0.3**2)
    problem = sk.Problem(plate, lambda x, y: H * (1 + growth * x), law, [sk.SimpleSupport("boundary", kind="hard")],
                         [sk.SurfaceLoad((0, 0, 1.0))])  # fmt: skip
    found = [sk.solve_linear(problem.on(sk.meshes.uniform(plate, n, n), "kirchhoff")).displacement((0.5, 0.5))[2] * D
             for n in (4, 8)]  # fmt: skip
    errors = np.abs(np.array(found) / expected - 1)
    # Order 4, less on the coarse mesh; the series has six digits.
    assert errors[1] < 5e-5 and errors[0] / errors[1] > 10
