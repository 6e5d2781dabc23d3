"""Thickness, offset and material as functions of place: series, beams, and what a constant function must be."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eigh

import skancf as sk
from skancf.adaptive import recovery_indicator
from skancf.errors import InputError

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


def blade(share, n=16):
    """Frequencies of a tapered cantilever, omega L^2 sqrt(rho A0 / E I0), by Ritz's method with polynomials, which are exact
    to rounding."""
    x, w = np.polynomial.legendre.leggauss(60)
    x, w, h = (x + 1) / 2, w / 2, 1 - share * (x + 1) / 2
    shapes = [np.polynomial.Legendre.basis(k, [0, 1]) * np.polynomial.Polynomial([0, 0, 1]).convert(
        domain=[0, 1], kind=np.polynomial.Legendre) for k in range(n)]  # fmt: skip
    values, bent = (np.stack([f(x) for f in each]) for each in (shapes, [f.deriv(2) for f in shapes]))
    return np.sqrt(eigh(bent * w * h**3 @ bent.T, values * w * h @ values.T, eigvals_only=True))


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_modes_of_a_tapered_blade(share):
    """Of those that bend it about its weak axis; a wedge has 5.315, and one that is nearly sharp comes close."""
    expected = blade(share)[:3]
    assert abs(blade(0.0)[0] - 3.51601527) < 1e-8 and abs(blade(0.999)[0] - 5.315) < 0.02
    free = sk.Problem(STRIP, lambda x, y: H * (1 - share * x / L), NO_POISSON, [sk.Clamp("left")])
    unit = L**2 * np.sqrt(RHO * H / (E * H**3 / 12))
    errors = []
    for n in (8, 16):
        system = free.on(sk.meshes.uniform(STRIP, n, 1), "kirchhoff")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", sk.OutOfDepth)  # of shear in torsion, which is not looked at
            found = 2 * np.pi * sk.modes(system, 8).frequencies * unit
        errors.append([np.abs(found / one - 1).min() for one in expected])
        assert system.inertia.total == pytest.approx(RHO * B * H * (1 - share / 2), rel=1e-13)
    # Order 4; of the third one at the thin end the largest.
    assert max(errors[1]) < 2e-4 and errors[1][0] < 2e-6 and errors[0][2] / errors[1][2] > 8


@theories
def test_weight_of_a_taper_with_a_flat_bottom(theory):
    """Weight acts at the centre of mass; the surface is the bottom, and the answer that of the plate about its mid-plane."""

    def thickness(x, y):
        return H * (1 - 0.5 * x / L)

    problem = sk.Problem(STRIP, thickness, NO_POISSON, [sk.Clamp("left")], [sk.Gravity((0.0, 0.0, -9.81))],
                         offset=lambda x, y: thickness(x, y) / 2)  # fmt: skip
    middle = sk.Problem(STRIP, thickness, NO_POISSON, [sk.Clamp("left")], [sk.Gravity((0.0, 0.0, -9.81))])
    mesh = sk.meshes.uniform(STRIP, 16, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        found, other = (sk.solve_linear(each.on(mesh, theory)) for each in (problem, middle))
    reaction = found.reactions()
    assert reaction[2] == pytest.approx(RHO * 9.81 * B * H * 0.75, rel=1e-10)
    # Small deflections of a thin wedge do not know where its reference is, but for the slope of the mid-plane squared.
    tolerance = 2e-3 if theory == "kirchhoff" else 0.1
    assert found.displacement((L, B / 2))[2] == pytest.approx(other.displacement((L, B / 2))[2], rel=tolerance)
    assert found.position((0.5, B / 2), "bottom")[2] == pytest.approx(found.position((0.5, B / 2))[2], abs=1e-15)
    assert found.position((0.5, B / 2), "top")[2] - found.position((0.5, B / 2))[2] == pytest.approx(0.75 * H, rel=1e-6)


def test_stress_at_the_faces_of_each_place():
    end = sk.EdgeLoad("right", (0, 0, 1.0 / B))
    problem = sk.Problem(STRIP, taper(0.5), NO_POISSON, [sk.Clamp("left")], [end])
    state = sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, 32, 1), "kirchhoff"))
    x = state.system.geometry.parameters(INSIDE[:, 1:2])[0]
    height = H * (1 - 0.5 * x / L)
    expected = -6 * (L - x) / (B * height**2)
    inner = x < 0.9 * L  # at the tip it vanishes
    for z, factor in (("top", 1.0), ("bottom", -1.0), (0.004, 0.004 / (height / 2))):
        found = state.stresses(INSIDE[:, 1:2], z)[:, :, 0]
        assert np.allclose(found[inner], (factor * expected)[inner], rtol=2e-3), z
    with pytest.raises(InputError, match=r"z = 0.0075: outside .*at \(x, y\) = \(0.5"):
        state.stresses(INSIDE[:, 1:2], 0.0075)
    with pytest.raises(InputError, match="say where, as in z='top', z='bottom'"):
        state.stresses(INSIDE)


@theories
def test_heat_bends_a_taper_by_what_it_is_thick(theory):
    """A gradient T1 bends a free plate by alpha T1 in both directions, whatever its thickness is, and leaves no stress."""
    law = sk.Isotropic(E, 0.3, RHO, expansion=1e-5)
    free = [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Pin((0.0, 0.0))]
    problem = sk.Problem(STRIP, taper(0.5), law, free, [sk.Temperature(20.0, 10.0)])
    state = sk.solve_linear(problem.on(sk.meshes.uniform(STRIP, 8, 2), theory))
    assert np.allclose(state.displacement((L, 0.0)), [2e-4 * L, 0.0, 1e-4 * L**2 / 2 * -1.0], rtol=1e-6, atol=1e-12)
    # Of the stress that would hold it back.
    assert np.abs(state.stresses(INSIDE, "top")).max() < 1e-7 * E * 1e-4


def test_a_function_is_asked_on_each_mesh():
    """The refined mesh of an estimate sees the function, not what the elements of the coarse one had of it."""
    asked = []

    def thickness(x, y):
        asked.append(np.size(x))
        return H * (1 - 0.5 * x / L)

    problem = sk.Problem(STRIP, thickness, NO_POISSON, [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    tree = sk.meshes.quadtree(sk.meshes.uniform(STRIP, 4, 1), STRIP)
    state, quantity = sk.solve_linear(problem.on(tree, "kirchhoff")), sk.Displacement((L, B / 2), (0, 0, 1.0))
    before = max(asked)
    seen = sk.goal_estimate(state, quantity)
    exact = TAPERS[0.5][0] / (E * H**3 / 12)
    assert max(asked) >= 4 * before
    assert seen.error == pytest.approx(exact - seen.value, rel=0.1)


def test_fibres_that_turn():
    """A material as a function of place: a strip whose modulus grows along it, as its thickness would in bending."""
    grown = 0.5
    law = sk.Problem(STRIP, H, lambda x, y: sk.Isotropic(E * (1 - grown * x) ** 3, 0.0, RHO), [sk.Clamp("left")],
                     [sk.EdgeLoad("right", (0, 0, 1.0))])  # fmt: skip
    w = sk.solve_linear(law.on(sk.meshes.uniform(STRIP, 16, 1), "kirchhoff")).displacement((L, B / 2))[2]
    assert w * E * H**3 / 12 == pytest.approx(TAPERS[0.5][0], rel=1e-5)
    ply = sk.Orthotropic((4 * E, E, E), (0.0, 0.0, 0.0), (E / 2, E / 2, E / 2), RHO, angle=0.3)

    def turned(x, y):
        return sk.Orthotropic((4 * E, E, E), (0.0, 0.0, 0.0), (E / 2, E / 2, E / 2), RHO, angle=0.6 * x)

    section = sk.Problem(STRIP, H, turned).on(sk.meshes.uniform(STRIP, 2, 1)).assembly.section
    one = section.at_places(np.array([[0.5], [0.05]])).one(0)
    assert same(one.stiffness[0], ply.stiffness()) and one.thermal_resultants(1.0, 0.0).shape == (6,)
    with pytest.raises(InputError, match=r"another one at each place.*\.one\(0\)"):
        section.at(INSIDE).thermal_resultants(1.0, 0.0)


WRONG = {
    "not positive": (lambda x, y: H - 2 * H * x, r"thickness = -0.02 at \(x, y\) = \(1, 0"),
    "not finite": (lambda x, y: np.where(x > 0.5, np.nan, H), r"thickness = nan: not finite.*at \(x, y\) = \(0.6"),
    "nothing": (lambda x, y: None, "thickness = None: not a number"),
    "shape": (lambda x, y: np.ones((2, 2)), r"of shape \(2, 2\): give one number"),
    "one too many": (lambda x, y: np.ones(len(x) + 1), r"of shape \(41,\): .* must return \(40,\), one for each point"),
    "complex": (lambda x, y: H * (1 + 1e-3j * x), r"thickness = \(0.02\+0j\): not a number.*at \(x, y\) = \(0, 0\)"),
    "truth": (lambda x, y: x > 0.5, "a truth value"),
    "text": (lambda x, y: "thick", "'thick': not a number"),
    "zero at a node only": (lambda x, y: H * (L - x), r"thickness = 0 at \(x, y\) = \(1, 0"),
    "infinite at a node only": (lambda x, y: np.where(x > 0, H, np.inf), r"thickness = inf: .*at \(x, y\) = \(0, 0\)"),
    "too thick": (lambda x, y: 1e99 + x, "products of numbers beyond"),
}


@theories
@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_thickness_names_the_place(case, theory):
    thickness, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        sk.Problem(STRIP, thickness, NO_POISSON).on(sk.meshes.uniform(STRIP, 10, 1), theory)


def test_what_a_function_raises_comes_with_a_note():
    def broken(x, y):
        raise KeyError("table")

    for given in ({"thickness": broken, "material": NO_POISSON}, {"thickness": H, "material": broken},
                  {"thickness": H, "material": NO_POISSON, "offset": broken}):  # fmt: skip
        with pytest.raises(KeyError) as caught:
            sk.Problem(STRIP, **given).on(sk.meshes.uniform(STRIP, 2, 1))
        assert "raised by the function given as" in caught.value.__notes__[0]
    with pytest.raises(InputError, match="material = 3"):
        sk.Problem(STRIP, H, lambda x, y: 3).on(sk.meshes.uniform(STRIP, 2, 1))
    with pytest.raises(InputError, match="brings its own"):
        sk.Problem(STRIP, lambda x, y: H, plies())


WRONG_MATERIALS = {
    "number": lambda x, y: 3,
    "nothing": lambda x, y: None if x > 0.4 else NO_POISSON,
    "class": lambda x, y: sk.Isotropic,
    "list": lambda x, y: [NO_POISSON],
    "laminate beside laws": lambda x, y: plies() if x > 0.4 else NO_POISSON,
}


@pytest.mark.parametrize("case", WRONG_MATERIALS)
def test_a_function_that_returns_no_material_names_the_place(case):
    with pytest.raises(InputError, match=r"material = .*; at \(x, y\) = \(0(\.5)?, 0(\.1)?\)"):
        sk.Problem(STRIP, H, WRONG_MATERIALS[case]).on(sk.meshes.uniform(STRIP, 2, 1))


@pytest.mark.parametrize("offset", [lambda x, y: 1j * x, lambda x, y: np.full(np.shape(x), np.inf), lambda x, y: "top"])
def test_a_wrong_offset_names_the_place(offset):
    with pytest.raises(InputError, match=r"offset = .*not .*at \(x, y\) = \(0, 0\)"):
        sk.Problem(STRIP, H, NO_POISSON, offset=offset).on(sk.meshes.uniform(STRIP, 2, 1))


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


@pytest.mark.parametrize("zones", [[], [sk.Zone("tip", ((0.5, L), (0.0, B)), thickness=2 * H)]])
def test_a_law_that_a_material_function_cannot_make_is_told_with_its_place(zones):
    def softens(x, y):
        return sk.Orthotropic((E, E, E), (0.0, 0.0, 0.0), (E * (0.8 - x), E, E), RHO)

    mesh = sk.meshes.uniform(STRIP, 4, 1)
    with pytest.raises(InputError, match=r"material: shear.* at \(x, y\) = \((0\.[89]|1),? ?"):
        sk.Problem(STRIP, H, softens, [sk.Clamp("left")], zones=zones).on(mesh, "kirchhoff")
