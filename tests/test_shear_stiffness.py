"""Transverse shear of laminates against elasticity: Pagano's cylindrical bending, and a sandwich plate."""

import warnings

import numpy as np
import pytest
from reference import cylindrical_bending, navier

import skancf as sk
from skancf.materials.section import SHEAR
from skancf.materials.shear import shear_stress_at, shear_stresses, warping_length

PLY = sk.Orthotropic((25e6, 1e6, 1e6), (0.25, 0.25, 0.25), (5e5, 5e5, 2e5), 1.0)
FOAM, METAL = sk.Isotropic(1e4, 0.3, 1.0), sk.Isotropic(1e6, 0.3, 1.0)
CROSS = [(PLY, 1 / 3, 0), (PLY, 1 / 3, 90), (PLY, 1 / 3, 0)]
SANDWICH = [(METAL, 0.1, 0), (FOAM, 0.8, 0), (METAL, 0.1, 0)]


def changed(law, **options):
    return type(law)(**{**{k: v for k, v in vars(law).items() if k[0] != "_"}, **options})


def laminate(layers, offset=0.0, **options):
    made = [sk.Layer(changed(law, **options), t, np.radians(angle)) for law, t, angle in layers]
    return sk.Laminate(made, offset)


def by_theory(layers, a):
    """Deflection of cylindrical bending by bending and by shear."""
    section, p = laminate(layers).section(), np.pi / a
    bending = 1 / np.linalg.inv(section.abd()[np.ix_([0, 3], [0, 3])])[1, 1]
    return 1 / (bending * p**4), 1 / (section.shear_stiffness()[0, 0] * p**2)


def exact(layers, a):
    laws = [layer.stiffness() for layer in laminate(layers, kind="3d", shear_correction=1.0).layers]
    return cylindrical_bending.deflection(laws, [t for _, t, _ in layers], a)


def test_the_reference_has_the_published_values():
    """Pagano 1969: 100 E_T h^3 w / (q a^4)."""
    for a, value in ((4.0, 2.887), (10.0, 0.932)):
        assert np.isclose(100 * 1e6 * exact(CROSS, a)[0] / a**4, value, atol=5e-4)


@pytest.mark.parametrize("layers, error", [
    (CROSS, 1.36), ([(METAL, 1.0, 0)], 0.32), ([(PLY, 0.5, 0), (PLY, 0.5, 90)], 0.6), (SANDWICH, 0.42),
], ids=["cross-ply", "one layer", "lopsided", "sandwich"])  # fmt: skip
def test_cylindrical_bending(layers, error):
    """What is left at a / h = 10 and 50 is of higher order in h / a, given in per cent of the deflection at 10."""
    (bending, by_shear), right = by_theory(layers, 10.0), exact(layers, 10.0)[0]
    assert 100 * ((bending + by_shear) / right - 1) == pytest.approx(error, abs=0.02)
    assert bending / right - 1 < -7 * error / 100, "shear counts"
    slender = by_theory(layers, 50.0)
    assert abs(sum(slender) / exact(layers, 50.0)[0] - 1) < 3e-4


@pytest.mark.parametrize("layers", [CROSS, [(PLY, 0.5, 0), (PLY, 0.5, 90)], SANDWICH], ids=["cross", "lopsided", "sandwich"])
def test_shear_stress_is_that_of_elasticity(layers):
    n = 64
    stress = shear_stresses(laminate(layers).section(), (np.arange(n) + 0.5) / n)[..., 0, 0]
    _, right = exact(layers, 100.0)
    assert np.abs(stress - right).max() < 2e-3 * np.abs(right).max()


@pytest.mark.parametrize("law", [METAL, PLY], ids=["isotropic", "orthotropic"])
@pytest.mark.parametrize("k", [5 / 6, 1.0, 0.4])
def test_a_factor_of_ones_own_keeps_its_meaning(law, k):
    """Equal layers are one layer, with k G t; in a laminate it scales the modulus by k / (5/6)."""
    one = sk.Problem(sk.Rectangle(1, 1), 0.3, changed(law, shear_correction=k)).section.shear_stiffness()
    equal = laminate([(law, 0.1, 0), (law, 0.05, 180), (law, 0.15, 0)], shear_correction=k).section()
    assert np.allclose(equal.shear_stiffness(), one, rtol=1e-12, atol=1e-9 * one.max())
    assert np.allclose(np.diag(one), k * 0.3 * changed(law, kind="3d", shear_correction=1).stiffness()[[4, 3], [4, 3]])
    scaled, default = (laminate(CROSS, shear_correction=factor).section().shear_stiffness() for factor in (k, 5 / 6))
    assert np.allclose(scaled, default * k / (5 / 6), rtol=1e-12)


def test_frame_and_reference_surface_do_not_matter(rng):
    layers = [(PLY, 0.2, 10), (PLY, 0.3, 55), (METAL, 0.1, 0), (PLY, 0.2, -70)]
    plain = laminate(layers).section()
    for offset in (0.4, -30.0):
        assert np.allclose(laminate(layers, offset).section().shear_stiffness(), plain.shear_stiffness(), rtol=1e-9)
    by_quarter = laminate([(law, t, angle + 90) for law, t, angle in layers]).section().shear_stiffness()
    K = plain.shear_stiffness()
    assert abs(K[0, 1]) > 1e-2 * K[0, 0], "13 and 23 are coupled"
    assert np.allclose(by_quarter, [[K[1, 1], -K[0, 1]], [-K[0, 1], K[0, 0]]], rtol=1e-9)
    # What the layers hold in the plane is left as it was, and they stay definite.
    raw = np.array([layer.stiffness() for layer in laminate(layers).layers])
    assert np.allclose(plain.stiffness[:, [0, 1, 5]][:, :, [0, 1, 5]], raw[:, [0, 1, 5]][:, :, [0, 1, 5]], rtol=0, atol=0)
    assert np.linalg.eigvalsh(plain.stiffness).min() > 0
    assert not np.allclose(plain.stiffness[:, SHEAR][:, :, SHEAR], raw[:, SHEAR][:, :, SHEAR], rtol=1e-2)


def nafems_plate(theory, n):
    """A quarter of NAFEMS R0031/3: a sandwich of 10 by 10 in under 100 psi, hard simply supported."""
    face = sk.Orthotropic((10e6, 4e6, 4e6), (0.3, 0.3, 0.3), (1.875e6,) * 3, 1.0)
    core = sk.Orthotropic((10.0, 10.0, 10.0), (0, 0, 0), (10.0, 3e4, 1.2e4), 1.0)
    quarter = sk.Rectangle(5.0, 5.0)
    held = [sk.Symmetry("left"), sk.Symmetry("bottom"), sk.SimpleSupport(["right", "top"], kind="hard")]
    sandwich = sk.Laminate([sk.Layer(face, 0.028), sk.Layer(core, 0.75), sk.Layer(face, 0.028)])
    problem = sk.Problem(quarter, material=sandwich, supports=held, loads=[sk.SurfaceLoad((0, 0, -100.0))])
    return sk.solve_linear(problem.on(sk.meshes.uniform(quarter, n, n), theory))


def test_nafems_sandwich():
    """NAFEMS R0031/3: -0.123 in; S11 34 449 psi in the middle of the face, S22 13 350 to 13 930."""
    solution = nafems_plate("full", 12)
    w = solution.displacement((0, 0))[2]
    section = solution.system.problem.section
    series = navier.shear_deformable(section.abd()[3:, 3:] / 100, tuple(np.diag(section.shear_stiffness())))
    # Of a strip of length 1: q a^4 / D and q a^2 / K with a = 10 and q = 100.
    assert w == pytest.approx(-1e4 * series, rel=3e-3) and w == pytest.approx(-0.123, rel=1e-2)
    middle = np.argmin(np.abs(solution.system.mesh.p).sum(axis=0))
    s11, s22 = solution.nodal_stresses(-0.389)[middle, :2]
    assert s11 == pytest.approx(34449, rel=1e-2) and 13350 < s22 < 13930
    with pytest.warns(sk.OutOfDepth, match="transverse shear"):
        thin = nafems_plate("kirchhoff", 4)
    assert thin.displacement((0, 0))[2] / w == pytest.approx(0.64, abs=0.01)


def test_shear_stresses_of_all_layers_are_the_shear_force():
    """A strip of a sandwich with a force at its end: S13 sums to it in theory full, and the shear adds P L / K."""
    strip, t, force = sk.Rectangle(1.0, 0.1), (0.01, 0.08, 0.01), 1e-3
    layers = [(changed(METAL, poisson=0.0), t[0], 0), (changed(FOAM, poisson=0.0), t[1], 0),
              (changed(METAL, poisson=0.0), t[2], 0)]  # fmt: skip
    problem = sk.Problem(strip, material=laminate(layers), supports=[sk.Clamp("left")],
                         loads=[sk.EdgeLoad("right", (0.0, 0.0, force))])  # fmt: skip
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(strip, 20, 2), "full"))
    section = problem.section
    at = solution.system.geometry.locate((0.525, 0.025))[0]
    stress = [solution.stresses(np.array([[0.5], [0.5]]), z)[at, 0, 4] for z in (-0.045, 0.0, 0.045)]
    assert np.dot(stress, t) == pytest.approx(force, rel=1e-3)
    expected = force * (1 / (3 * section.abd()[3, 3]) + 1 / section.shear_stiffness()[0, 0])
    assert solution.displacement((1.0, 0.05))[2] == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize("ratio, a, error", [(1e2, 4.0, 0.0337), (1e3, 4.0, 0.296), (1e4, 10.0, 0.459), (1e4, 4.0, 2.93)])
def test_layers_that_bend_one_by_one(ratio, a, error):
    """Faces on a core that is too soft for one normal: by how much the theory is off, against elasticity, and said."""
    core = sk.Isotropic(1e6 / ratio, 0.3, 1.0)
    layers = [(METAL, 0.1, 0), (core, 0.8, 0), (METAL, 0.1, 0)]
    off = sum(by_theory(layers, a)) / exact(layers, a)[0] - 1
    assert off == pytest.approx(error, rel=0.01)
    for offset in (0.0, 3.0):
        length = warping_length(laminate(layers, offset).section())
        assert (np.pi * length / a) ** 2 == pytest.approx(error, rel=0.15)
    strip = sk.Rectangle(a, a / 8)
    problem, mesh = sk.Problem(strip, material=laminate(layers)), sk.meshes.uniform(strip, 2, 1)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        problem.on(mesh, "full")
        problem.on(mesh, "kirchhoff")
    assert ["bend one by one" in str(w.message) for w in said] == [True] * (error > 0.05)


def test_nafems_strip():
    """R0031/1: a strip of seven plies on two supports 30 mm apart, 10 N/mm in the middle: 683.9 MPa in the lower face,
    -1.06 mm, and an interlaminar shear stress of 4.1 MPa between the first two plies."""
    ply = sk.Orthotropic((100e3, 5e3, 5e3), (0.4, 0.3, 0.3), (3e3, 3e3, 2e3), 1.0)
    layers = [(ply, 0.4 if k == 3 else 0.1, 90 * (k % 2)) for k in range(7)]
    half = sk.Rectangle(15.0, 1.0)
    held = [sk.Symmetry("left"), sk.Roller("right"), sk.Roller((0.0, 0.0), (0, 1, 0))]
    problem = sk.Problem(half, material=laminate(layers), supports=held, loads=[sk.EdgeLoad("left", (0, 0, -5.0))])
    thin = sk.solve_linear(problem.on(sk.meshes.uniform(half, 12, 2), "kirchhoff"))
    element = thin.system.geometry.locate((7.4, 0.4))[0]
    section, shear = problem.section, thin.shear_forces()[element, :, 0]
    interlaminar = shear_stress_at(section, section.z[1]) @ shear
    assert abs(interlaminar[0]) == pytest.approx(4.1, abs=0.05)
    assert np.allclose(shear_stress_at(section, section.z[0]), 0, atol=1e-12)
    assert np.abs(shear_stress_at(section, section.z[-1])).max() < 1e-12
    full = sk.solve_linear(problem.on(sk.meshes.uniform(half, 30, 2), "full"))
    assert full.displacement((0.0, 0.5))[2] == pytest.approx(-1.06, rel=1e-2)
    corner = np.argmin(np.abs(full.system.mesh.p - [[0.0], [0.5]]).sum(axis=0))
    assert full.nodal_stresses("bottom")[corner, 0] == pytest.approx(683.9, rel=2e-2)
