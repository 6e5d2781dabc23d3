"""Layers through the thickness: lamination theory in closed form, heat, and plates made of laminates."""

import numpy as np
import pytest

import skancf as sk
from skancf import output
from skancf.errors import InputError
from skancf.materials import Section, section_of

# Products and inverses of small matrices whose condition is below a few hundred.
ROUNDING = 1e-12
VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
IN_PLANE = [0, 1, 5]

PLY = sk.Orthotropic(
    (1.4e11, 1.0e10, 1.0e10), (0.3, 0.3, 0.4), (5e9, 5e9, 3.5e9), 1600.0, expansion=(-3e-7, 2.8e-5, 3e-5)
)  # fmt: skip
T = 0.004  # m, of the laminates below


def any_law(**options):
    root = np.random.default_rng(8).normal(size=(6, 6))
    expansion = np.random.default_rng(9).uniform(-1e-5, 1e-5, 6)
    return sk.Anisotropic(1e9 * (root @ root.T + 2 * np.eye(6)), 1000.0, expansion=expansion, **options)


def laminate(*degrees, ply=PLY, offset=0.0):
    return sk.Laminate([sk.Layer(ply, T / len(degrees), np.radians(angle)) for angle in degrees], offset)


def blocks(section):
    abd = section.abd()
    return abd[:3, :3], abd[:3, 3:], abd[3:, 3:]


def close(a, b, scale=None, rtol=ROUNDING):
    return np.abs(a - b).max() <= rtol * (np.abs(b).max() if scale is None else scale)


def reduced():
    """Q11, Q22, Q12, Q66 of the ply from its engineering constants."""
    (e1, e2, _), nu12, g12 = PLY.young, PLY.poisson[0], PLY.shear[0]
    common = 1 - nu12**2 * e2 / e1
    return e1 / common, e2 / common, nu12 * e2 / common, g12


# --- lamination theory: Jones, Mechanics of Composite Materials (1999), section 4.4 ----------------------------------


def test_one_isotropic_layer():
    E, nu, h = 7e10, 0.3, 0.02
    A, B, D = blocks(section_of(sk.Isotropic(E, nu, 1.0), h))
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    assert close(A, E * h / (1 - nu**2) * plane)
    assert close(D, E * h**3 / 12 / (1 - nu**2) * plane)
    assert close(B, 0 * plane, E * h**2)


@pytest.mark.parametrize("law", [sk.Isotropic(7e10, 0.3, 1.0), PLY, any_law()], ids=["isotropic", "orthotropic", "any"])
def test_equal_layers_are_one_layer(law):
    one = section_of(law, T)
    stack = sk.Laminate([sk.Layer(law, t * T) for t in (0.1, 0.25, 0.05, 0.6)]).section()
    for a, b, unit in zip(blocks(stack), blocks(one), (1, T, T**2), strict=True):
        assert close(a, b, unit * np.abs(one.abd()).max())
    assert close(stack.shear_stiffness(), one.shear_stiffness()) and close(stack.mass, one.mass)
    thinner = sk.Laminate([sk.Layer(law, t * T) for t in (0.1, 0.25, 0.05, 0.599)]).section()
    assert not close(thinner.abd(), one.abd(), rtol=1e-4)


def test_cross_ply():
    (q11, q22, q12, q66), (A, B, D) = reduced(), blocks(laminate(0, 90).section())
    mean = np.array([[(q11 + q22) / 2, q12, 0], [q12, (q11 + q22) / 2, 0], [0, 0, q66]])
    assert close(A, mean * T) and close(D, mean * T**3 / 12)
    assert close(B, np.diag([q22 - q11, q11 - q22, 0]) * T**2 / 8)  # the stiff layer is below
    assert np.array_equal(np.sign(np.diag(blocks(laminate(90, 0).section())[1])), [1, -1, 0])


def test_antisymmetric_angle_ply():
    (q11, q22, q12, q66), (A, B, D) = reduced(), blocks(laminate(45, -45).section())
    b16 = -(q11 - q22) / 4 * T**2 / 4
    assert close(B, b16 * np.array([[0, 0, 1], [0, 0, 1], [1, 1, 0]]))
    turned = np.array([[(q11 + q22 + 2 * q12 + 4 * q66) / 4, (q11 + q22 + 2 * q12 - 4 * q66) / 4, 0]] * 2 + [[0, 0, 0]])
    turned[1, :2] = turned[0, 1::-1]
    turned[2, 2] = (q11 + q22 - 2 * q12) / 4
    assert close(A, turned * T) and close(D, turned * T**3 / 12)


def test_symmetric_laminate():
    (q11, q22, _, _), (A, B, D) = reduced(), blocks(laminate(0, 90, 90, 0).section())
    assert close(B, np.zeros((3, 3)), A.max() * T)
    assert close(D[0, 0], (7 * q11 + q22) / 8 * T**3 / 12)
    assert close(D[1, 1], (q11 + 7 * q22) / 8 * T**3 / 12)
    assert D[0, 2] == pytest.approx(0, abs=ROUNDING * D.max())


@pytest.mark.parametrize("offset", [T / 4, -T / 2, 3 * T])
def test_offset_is_the_parallel_axis(offset):
    A, B, D = blocks(laminate(0, 90, 45).section())
    a, b, d = blocks(laminate(0, 90, 45, offset=offset).section())
    assert close(a, A) and close(b, B + offset * A)
    assert close(d, D + 2 * offset * B + offset**2 * A)
    A, _, D = blocks(laminate(0, 90, 0).section())
    assert close(blocks(laminate(0, 90, 0, offset=offset).section())[1], offset * A)


# --- laws in a layer -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [sk.Isotropic(7e10, 0.3, 1.0), PLY, any_law(), any_law(angle=0.3)],
                         ids=["isotropic", "orthotropic", "any", "turned"])  # fmt: skip
@pytest.mark.parametrize("kind", ["plane_stress", "3d"])
def test_in_plane_stiffness_is_the_inverse_of_the_in_plane_compliance(law, kind):
    law = type(law)(**{**{k: v for k, v in vars(law).items() if k[0] != "_"}, "kind": kind})
    whole = type(law)(**{**{k: v for k, v in vars(law).items() if k[0] != "_"}, "kind": "3d"})
    expected = np.linalg.inv(np.linalg.inv(whole.stiffness())[np.ix_(IN_PLANE, IN_PLANE)])
    assert close(section_of(law, T).in_plane()[0], expected)
    assert not close(whole.stiffness()[np.ix_(IN_PLANE, IN_PLANE)], expected, rtol=1e-3)


def tensor(strain):
    out = np.empty((3, 3))
    for value, (i, j) in zip(strain, VOIGT, strict=True):
        out[i, j] = out[j, i] = value if i == j else value / 2
    return out


def strain_by_hand(strain, angle):
    """A strain known in axes turned by the angle, by rotating the tensor."""
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])  # columns: the turned axes
    E = axes @ tensor(strain) @ axes.T
    return np.array([E[i, j] * (1 if i == j else 2) for i, j in VOIGT])


@pytest.mark.parametrize("angle", [0.6, -1.1])
def test_layers_are_turned_as_by_hand(angle, rng):
    law, turned = any_law(), sk.Layer(any_law(), T, angle)
    strain = rng.normal(size=6)
    # The same strain, seen from both frames, has the same energy.
    seen = strain_by_hand(strain, -angle)
    assert close(strain @ turned.stiffness() @ strain, seen @ law.stiffness() @ seen)
    assert close(turned.thermal_strain(), strain_by_hand(law.thermal_strain(), angle))
    assert not close(turned.thermal_strain(), strain_by_hand(law.thermal_strain(), -angle), rtol=1e-2)


def test_the_angle_of_a_layer_adds_to_that_of_its_material():
    together, in_one = sk.Layer(any_law(angle=0.4), T, 0.5), any_law(angle=0.9)
    assert close(together.stiffness(), in_one.stiffness())
    assert close(together.thermal_strain(), in_one.thermal_strain())


def test_expansion_of_the_laws():
    assert np.array_equal(sk.Isotropic(1.0, 0.3, 1.0, expansion=2.0).thermal_strain(), [2, 2, 2, 0, 0, 0])
    assert np.array_equal(sk.Isotropic(1.0, 0.3, 1.0).thermal_strain(), np.zeros(6))
    a1, a2, a3 = PLY.expansion
    half = sk.Orthotropic(PLY.young, PLY.poisson, PLY.shear, 1.0, angle=np.pi / 4, expansion=PLY.expansion)
    mean = (a1 + a2) / 2
    assert close(half.thermal_strain(), np.array([mean, mean, a3, 0, 0, a1 - a2]))  # doubled shear


# --- depths ----------------------------------------------------------------------------------------------------------


def test_layer_at_a_depth():
    section = sk.Laminate([sk.Layer(PLY, 0.1), sk.Layer(PLY, 0.2), sk.Layer(PLY, 0.3)], offset=0.3).section()
    assert close(section.z, np.array([0, 0.1, 0.3, 0.6]))
    assert section.layer_at([0, 0.05, 0.1, 0.1 + 1e-9, 0.3, 0.6]).tolist() == [0, 0, 0, 1, 1, 2]
    assert section.layer_at(0.1 + 1e-16) == 0, "an interface up to rounding"
    for depth in (-1e-6, 0.7, float("nan")):
        with pytest.raises(InputError, match=r"(?s)z.*(outside the plate.*0\.6|finite)"):
            section.layer_at([0.1, depth])


def test_points_integrate_each_layer():
    section = sk.Laminate([sk.Layer(PLY, 0.1), sk.Layer(any_law(), 0.2)], offset=0.02).section()
    z, w, layer = section.points(2)
    assert layer.tolist() == [0, 0, 1, 1] and np.array_equal(section.layer_at(z), layer)
    for power in range(4):  # two Gauss points are exact to the third power
        for k in range(2):
            expected = (section.z[k + 1] ** (power + 1) - section.z[k] ** (power + 1)) / (power + 1)
            assert close((w * z**power)[layer == k].sum(), expected, rtol=1e-13)
    assert close(section.mass, 1600 * 0.1 + 1000 * 0.2) and close(section.thickness, 0.3)


def test_shear_stiffness():
    g13, g23 = PLY.shear[1:]
    assert close(laminate(0).section().shear_stiffness(), 5 / 6 * T * np.diag([g13, g23]))
    assert close(laminate(0, 0, 180).section().shear_stiffness(), 5 / 6 * T * np.diag([g13, g23]))


# --- heat ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["plane_stress", "3d"])
@pytest.mark.parametrize("offset", [0.0, 0.3 * T])
def test_a_homogeneous_free_plate_takes_its_thermal_strain(kind, offset):
    law = any_law(kind=kind, angle=0.7)
    section = sk.Laminate([sk.Layer(law, T / 3), sk.Layer(law, 2 * T / 3)], offset).section()
    scale = np.array([1, 1, 1, T, T, T])  # so that strains and curvatures compare
    free = np.linalg.solve(section.abd(), section.thermal_resultants(50.0, 2000.0)) * scale
    alpha = law.thermal_strain()[IN_PLANE]
    # Condition of the section: (offset / t)^2 on top of the law's.
    assert close(free, np.concatenate([50.0 * alpha, 2000.0 * T * alpha]), rtol=1e-10)


def test_thermal_resultants_are_the_integrals():
    section = laminate(0, 60, 90, offset=T / 3).section()
    z, w, layer = section.points(2)
    stress = np.einsum("pij,pj->pi", section.in_plane()[layer], section.thermal_strain(z, 30.0, 4000.0)[:, IN_PLANE])
    expected = np.concatenate([w @ stress, (w * z) @ stress])
    found = section.thermal_resultants(30.0, 4000.0)
    assert close(found[:3], expected[:3]) and close(found[3:], expected[3:])
    several = section.thermal_resultants(np.array([[30.0, 0.0]]), np.array([[4000.0, 0.0]]))
    assert several.shape == (6, 1, 2) and close(several[:, 0, 0], found) and not several[:, 0, 1].any()


@pytest.mark.parametrize("m", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("n", [0.2, 1.0, 2.0])
def test_bimetal_strip(m, n):
    """Timoshenko (1925), J. Opt. Soc. Am. 11, 233-255: m = t1 / t2, n = E1 / E2, layer 1 below."""
    h, change, a1, a2, E2 = 0.002, 80.0, 1.2e-5, 1.9e-5, 1.1e11
    layers = [sk.Layer(sk.Isotropic(n * E2, 0.0, 1.0, expansion=a1), h * m / (1 + m)),
              sk.Layer(sk.Isotropic(E2, 0.0, 1.0, expansion=a2), h / (1 + m))]  # fmt: skip
    section = sk.Laminate(layers).section()
    kappa = np.linalg.solve(section.abd(), section.thermal_resultants(change, 0.0))[3]
    expected = 6 * (a2 - a1) * change * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    assert close(kappa, expected)


# --- plates of laminates, theory full --------------------------------------------------------------------------------

SQUARE = sk.Rectangle(1.0, 1.0)


def plate(material, thickness=None, loads=(), n=2, supports=(), theory="full", surface=SQUARE):
    problem = sk.Problem(surface, thickness, material, supports, loads)
    return problem.on(sk.meshes.uniform(surface, n, n), theory)


@pytest.mark.parametrize("theory", [sk.Full(), sk.Full(assumed=False)], ids=["assumed", "plain"])
def test_equal_layers_make_the_homogeneous_plate(theory, rng):
    law, thicknesses, weight = any_law(), (0.02, 0.05, 0.03), [sk.Gravity((0.3, 0.0, -9.81))]
    one = plate(law, 0.1, weight, theory=theory)
    stack = plate(sk.Laminate([sk.Layer(law, t) for t in thicknesses]), None, weight, theory=theory)
    q = one.undeformed + 0.02 * rng.normal(size=one.n_dofs)
    for a, b in ((stack.internal_force(q), one.internal_force(q)), (stack.tangent(q).values, one.tangent(q).values),
                 (stack.mass.values, one.mass.values), (stack.external_force(q), one.external_force(q))):  # fmt: skip
        assert close(a, b)
    other = plate(sk.Laminate([sk.Layer(law, t, angle=0.01) for t in thicknesses]), None, theory=theory)
    assert not close(other.tangent(q).values, one.tangent(q).values, rtol=1e-4)


def heavy_below(offset=0.0):
    heavy, light = sk.Isotropic(1e6, 0.3, 5000.0), sk.Isotropic(2e6, 0.3, 1000.0)
    return sk.Laminate([sk.Layer(heavy, 0.02), sk.Layer(light, 0.08)], offset)


def test_mass_and_weight_of_unequal_layers():
    system = plate(heavy_below(), loads=[sk.Gravity((0.0, 0.0, -10.0))])
    z, rho = np.array([-0.05, -0.03, 0.05]), np.array([5000.0, 1000.0])
    m0, m1, m2 = (rho @ np.diff(z**k) / k for k in (1, 2, 3))
    weight = system.external_force(system.undeformed).reshape(-1, 4, 3).sum(axis=0)[:, 2]
    assert close(weight[0], -10 * m0) and close(weight[3], -10 * m1)
    # Turning about the line y = 0, z = 0 of the square: y^2 + z^2, and no product of y and z.
    omega = np.array([2.0, 0.0, 0.0])
    v = np.cross(omega, system.undeformed.reshape(-1, 4, 3)).ravel()
    assert close(v @ (system.mass @ v), 4 * (m0 / 3 + m2))
    # A shift along x while turning about y: the first moment counts.
    v = np.cross([0.0, 1.0, 0.0], system.undeformed.reshape(-1, 4, 3))
    v[:, 0, 0] += 3.0
    assert close(v.ravel() @ (system.mass @ v.ravel()), m2 + 6 * m1 + 9 * m0 + m0 / 3)


@pytest.mark.parametrize("n_thickness", [2, 3])
def test_stretch_and_bending_of_the_section(n_thickness):
    """Energy of small constant strain and curvature: that of A, B and D."""
    system = plate(laminate(0, 45, 90, offset=T / 5), theory=sk.Full(n_thickness=n_thickness), n=1)
    eps, kappa = 1e-7 * np.array([3.0, -1.0, 2.0]), 1e-4 * np.array([1.0, 2.0, -3.0])
    x, y = system.geometry.points
    (e, f, g), (k, l, m) = eps, kappa
    q = system.undeformed.reshape(-1, 4, 3).copy()
    q[:, 0, 0] += e * x + g * y / 2
    q[:, 0, 1] += g * x / 2 + f * y
    q[:, 0, 2] -= (k * x**2 + l * y**2 + m * x * y) / 2
    q[:, 1] += np.stack([e + 0 * x, g / 2 + 0 * x, -(k * x + m * y / 2)], axis=1)
    q[:, 2] += np.stack([g / 2 + 0 * x, f + 0 * x, -(l * y + m * x / 2)], axis=1)
    q[:, 3, 0] += k * x + m * y / 2
    q[:, 3, 1] += l * y + m * x / 2
    small = q.ravel() - system.undeformed
    energy = small @ (system.tangent(system.undeformed) @ small) / 2
    both = np.concatenate([eps, kappa])
    # Rounding of positions of 1 over strains of 1e-7.
    assert close(energy, both @ system.problem.section.abd() @ both / 2, rtol=1e-8)
    assert not close(energy, both @ laminate(0, 45, 90).section().abd() @ both / 2, rtol=1e-2)


def test_stress_jumps_with_the_layers():
    system = plate(heavy_below())
    q = (system.undeformed.reshape(-1, 4, 3) * [1.001, 1.0, 1.0]).ravel()
    solution, centre = sk.Solution(system, q), np.array([[0.5], [0.5]])
    strain = (1.001**2 - 1) / 2
    for z, young in ((-0.05, 1e6), (-0.03, 1e6), (-0.03 + 1e-9, 2e6), (0.0, 2e6), (0.05, 2e6)):
        assert close(solution.stresses(centre, z)[:, 0, 0], young * strain / 0.91, rtol=1e-10)  # rounding / strain
    with pytest.raises(InputError, match=r"z = 0\.06: outside the plate"):
        solution.stresses(centre, 0.06)


def test_a_laminate_off_its_reference_surface(tmp_path):
    """The reference surface keeps its positions though nothing is there; stress is only where the layers are."""
    solution = sk.Solution(*(lambda s: (s, s.undeformed))(plate(heavy_below(offset=0.2))))
    assert close(solution.position((0.5, 0.5)), np.array([0.5, 0.5, 0.0]))
    assert close(solution.position((0.5, 0.5), z=0.25), np.array([0.5, 0.5, 0.25]))
    with pytest.raises(InputError, match=r"z = 0\.0: outside the plate, whose faces are at z = 0\.15"):
        solution.nodal_stresses()
    data = output.read(output.write(solution, tmp_path / "off.vtu", subdivisions=1)).point_data
    assert {"stress_top", "stress_mid", "stress_bottom"} <= data.keys()


@pytest.mark.parametrize("degrees", [(0, 90), (90, 0)])
def test_coupled_strip_against_lamination_theory(degrees):
    r"""A slender cantilever [0/90]: :math:`D^* = D - B^2 / A` bends it, and bending moves its end along x.

    With no Poisson's ratio a strip is a beam: :math:`w = p L^3 / 3 D^* + p L / S`, :math:`u = B w' / A`.
    """
    ply = sk.Orthotropic(PLY.young, (0.0, 0.0, 0.0), PLY.shear, 1600.0)
    length, width, p = 0.4, 0.02, 1e-3
    problem = sk.Problem(sk.Rectangle(length, width), material=laminate(*degrees, ply=ply), supports=[sk.Clamp("left")],
                         loads=[sk.EdgeLoad("right", (0.0, 0.0, p))])  # fmt: skip
    meshes = [sk.meshes.uniform(problem.surface, n, 1) for n in (16, 32)]
    coarse, fine = (sk.solve_linear(problem.on(mesh)).displacement((length, width / 2)) for mesh in meshes)
    A, B, D = (block[0, 0] for block in blocks(problem.section))
    bending, shear = D - B**2 / A, problem.section.shear_stiffness()[0, 0]
    slope = p * length**2 / (2 * bending)
    expected = np.array([B / A * slope, p * length**3 / (3 * bending) + p * length / shear])
    # Curvature is constant in an element, which makes order 2: w is 0.5 / n^2 too small. What extrapolation leaves of
    # that was measured as 1e-5 of u and of w.
    assert close(fine[2], expected[1], rtol=6e-4)
    assert np.abs((4 * fine - coarse)[[0, 2]] / 3 / expected - 1).max() < 3e-5
    assert not close(fine[2], p * length**3 / (3 * D), rtol=0.3), "coupling counts"


ABAQUS = [("left", (0, 0, 0, 0), 40.3), ("bottom", (0, 0, 0, 0), 357.5), ("left", (0, 90, 90, 0), 45.6),
          ("bottom", (0, 90, 90, 0), 198.0)]  # fmt: skip


@pytest.mark.parametrize("held,degrees,expected", ABAQUS)
def test_square_laminate_under_its_own_weight(held, degrees, expected):
    """Liu, Tian and Hu (2011), Multibody Syst. Dyn. 26, 283-305: deflection (mm) of a corner, computed with Abaqus.

    500 mm x 500 mm, four layers of 0.25 mm, clamped along one edge. Data and values as in the unit test of Project
    Chrono's element 3423 (utest_FEA_ANCFShell_3423_Formulation.cpp), which accepts 5 %.
    """
    ply = sk.Orthotropic((177e9, 10.8e9, 10.8e9), (0.0, 0.0, 0.0), (7.6e9, 7.6e9, 8.504e9), 7800.0)
    layers = [sk.Layer(ply, 0.25e-3, np.radians(angle)) for angle in degrees]
    problem = sk.Problem(sk.Rectangle(0.5, 0.5), material=sk.Laminate(layers), supports=[sk.Clamp(held)],
                         loads=[sk.Gravity((0.0, 0.0, -9.81))])  # fmt: skip
    solution = sk.solve(problem.on(sk.meshes.uniform(problem.surface, 16, 16))).unwrap()
    # The last digit given is 0.1 % of 40.3, and the mesh leaves 0.1 %: found 40.23, 357.95, 45.53, 197.90.
    assert close(-1e3 * solution.displacement((0.5, 0.5))[2], expected, rtol=0.0025)


# --- mistakes --------------------------------------------------------------------------------------------------------

LAYER = sk.Layer(PLY, 0.1)


class HalfALaw:
    def stiffness(self):
        return np.eye(6)


MISTAKES = {
    "no layers": (lambda: sk.Laminate([]), r"layers = \[\]: give a list of layers"),
    "no list": (lambda: sk.Laminate(LAYER), "layers = .*give a list of layers"),
    "not a layer": (lambda: sk.Laminate([LAYER, PLY]), "layers: .*is not a layer; give Layer"),
    "negative thickness": (lambda: sk.Layer(PLY, -0.1), "thickness of a layer = -0.1 m: .*greater than zero"),
    "no thickness": (lambda: sk.Layer(PLY, None), "thickness of a layer"),
    "no material": (lambda: sk.Layer(None, 0.1), "material = None: give a law"),
    "a class": (lambda: sk.Layer(sk.Isotropic, 0.1), "material = .*give a law"),
    "angle": (lambda: sk.Layer(PLY, 0.1, float("nan")), "angle = nan: not finite"),
    "offset": (lambda: sk.Laminate([LAYER], float("inf")), "offset = inf: not finite"),
    "thickness of a laminate": (lambda: sk.Problem(SQUARE, 0.1, sk.Laminate([LAYER])), "thickness = 0.1: a laminate brings"),
    "thickness missing": (lambda: sk.Problem(SQUARE, material=PLY), r"thickness: missing.*\(Orthotropic\)"),
    "material missing": (lambda: sk.Problem(SQUARE, 0.1), "material = None: give a law"),
    "half a law": (lambda: sk.Problem(SQUARE, 0.1, HalfALaw()), "give a law.*this has no density and no thermal_strain"),
    "class of laminates": (lambda: sk.Problem(SQUARE, material=sk.Laminate), "material = .*give a law"),
    "laminate in a laminate": (lambda: sk.Layer(sk.Laminate([LAYER]), 0.1), "give a law.*this has no density"),
    "expansion": (lambda: sk.Isotropic(1.0, 0.3, 1.0, expansion=float("nan")), "expansion = nan"),
    "two expansions": (lambda: sk.Isotropic(1.0, 0.3, 1.0, expansion=(1.0, 2.0)), "expansion.*one number"),
    "one expansion": (lambda: sk.Orthotropic(PLY.young, PLY.poisson, PLY.shear, 1.0, expansion=1.0), "expansion.*3 numbers"),
    "three expansions": (lambda: sk.Anisotropic(np.eye(6), 1.0, expansion=(1.0,) * 3), "expansion.*6 numbers"),
    "heights": (lambda: Section([0.1, 0.0], [np.eye(6)], [1.0], [np.zeros(6)]), "z = .*increase"),
    "shapes": (lambda: Section([0.0, 0.1], [np.eye(6)], [1.0, 2.0], [np.zeros(6)]), r"density of shape \(2,\)"),
    "no section": (lambda: Section([0.0], [], [], []), "a section of n layers"),
    "temperature": (lambda: laminate(0).section().thermal_resultants(float("nan"), 0.0), "temperature_mid = nan"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_are_named(case):
    make, message = MISTAKES[case]
    with pytest.raises(InputError, match="(?s)" + message):
        make()


@pytest.mark.parametrize("offset", [0.0, 3 * T])
def test_bending_thickness(offset):
    """That of one layer is its own, off its surface too; of a sandwich that of its faces, sqrt(3) times their distance."""
    assert np.isclose(laminate(30, 30, offset=offset).section().bending_thickness, T, rtol=1e-9)
    face, core = sk.Isotropic(1e9, 0.3, 1.0), sk.Isotropic(1.0, 0.3, 1.0)
    layers = [sk.Layer(face, 1e-4), sk.Layer(core, 0.01), sk.Layer(face, 1e-4)]
    thickness = sk.Laminate(layers, offset).section().bending_thickness
    # A = 2 E t, D = E t d^2 / 2 + E t^3 / 6.
    assert np.isclose(thickness, np.sqrt(3 * 0.0101**2 + 1e-8), rtol=1e-6)


def test_the_rest_of_the_membrane_strains_counts_as_bending_does():
    """Between soft faces a stiff core is the thickness that bends."""
    face, core = sk.Isotropic(1.0, 0.3, 1.0), sk.Isotropic(1e9, 0.3, 1.0)
    material = sk.Laminate([sk.Layer(face, 0.05), sk.Layer(core, 0.01), sk.Layer(face, 0.05)])
    surface = sk.Rectangle(1.0, 1.0)
    system = sk.Problem(surface, material=material).on(sk.meshes.uniform(surface, 2, 2), "kirchhoff")
    rest = system.assembly.sections.rest
    # The core alone: 0.01 over flat elements of 0.5 x 0.5; the faces add their share of the stiffness, 1e-8 of it.
    assert np.allclose(rest, 0.02, rtol=1e-6)
