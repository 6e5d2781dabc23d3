"""Layers off the surface of a curved shell, and of unlike stiffness, against elasticity: Lame's tubes and spheres, rings."""

import warnings

import numpy as np
import pytest
from reference import layered_tube

import skancf as sk
from skancf.materials.curved import CurvedSection
from skancf.materials.law import turned
from skancf.materials.parallel import curvature_at, strains_at

STIFF, SOFT = (sk.Isotropic(E, 0.3, 1.0, expansion=1.0) for E in (1.0, 0.2))
PLY = sk.Orthotropic((25, 1, 1), (0.25, 0.25, 0.25), (0.5, 0.5, 0.2), 1.0, expansion=(0.0, 1.0, 1.0))
# Of a wall of thickness 1: material, thickness, angle.
WALLS = {
    "one": [(STIFF, 1.0, 0)],
    "stiff inside": [(STIFF, 0.5, 0), (SOFT, 0.5, 0)],
    "stiff outside": [(SOFT, 0.3, 0), (STIFF, 0.7, 0)],
    "cross-ply": [(PLY, 0.5, 0), (PLY, 0.5, 90)],
    "sandwich": [(STIFF, 0.1, 0), (SOFT, 0.8, 0), (STIFF, 0.1, 0)],
}
walls = pytest.mark.parametrize("wall", WALLS)
offsets = pytest.mark.parametrize("offset", [0.0, 0.5, -0.5, 2.0])
QUARTER = np.pi / 2
ORDER = 0.5
"""Largest part of (h/R)^2 that is left, as found; 0.36 of it in the bending of a cross-ply."""
CRUSHED = {"one": 0.2, "stiff inside": 1.5, "stiff outside": 1.1, "cross-ply": 8.0, "sandwich": 0.3}
"""The same of pressure, whose radial stress crushes layers, and soft ones most; as found."""


def laminate(wall, offset=0.0):
    return sk.Laminate([sk.Layer(law, t, np.radians(angle)) for law, t, angle in WALLS[wall]], offset)


def laws(wall):
    """In three dimensions, in the frame of a tube: axis, hoop, radius."""
    solid = [type(law)(**{**vars(law), "kind": "3d", "shear_correction": 1.0}) for law, _, _ in WALLS[wall]]
    return [turned(law.stiffness(), np.radians(angle)) for law, (_, _, angle) in zip(solid, WALLS[wall], strict=True)]


# --- the law at a point ----------------------------------------------------------------------------------------------


def ring(section, R, law=None, ez=0.0, turn=0.0, pressed=0.0):
    """Movement w of the reference surface of a tube, moment that bends it, and axial force, each per length.

    With a pressure on the reference surface, an axial strain and a part of the angle by which it is bent.
    """
    law = CurvedSection(section).law(np.array([0.0, -1 / R, 0.0])) if law is None else law
    by_w, by_ez, by_turn = np.zeros((3, 6))
    by_w[[1, 4]], by_ez[0], by_turn[[1, 4]] = (1 / R, 1 / R**2), 1.0, (1.0, 2 / R)
    given = ez * by_ez + turn * by_turn
    w = (pressed - by_w @ law @ given) / (by_w @ law @ by_w)
    stress = law @ (w * by_w + given)
    return w, stress @ by_turn * R, stress @ by_ez * R


def errors(wall, offset, ratio, flat=False):
    """Of the movement under pressure, of the stiffness in bending, and of the force of an axial strain, relative."""
    section, R = laminate(wall, offset).section(), 1 / ratio
    radii, own = R + section.z, section.abd() if flat else None
    pressed = layered_tube.pressed(radii, laws(wall), R).at_surface(R)
    bent = layered_tube.tube(radii, laws(wall), turn=1.0).integral(1, 1)
    pulled = layered_tube.tube(radii, laws(wall), ez=1.0).integral(2, 1)
    found = ring(section, R, own, pressed=1.0)[0], ring(section, R, own, turn=1.0)[1], ring(section, R, own, ez=1.0)[2]
    return np.array(found) / [pressed, bent, pulled] - 1


@walls
@offsets
def test_tubes_to_second_order(wall, offset):
    """Under pressure, bent and pulled; the law of a plate is wrong in first order where layers are off the surface."""
    most = np.array([CRUSHED[wall], ORDER, ORDER])
    for ratio in (0.01, 0.02, 0.05, 0.1):
        assert (np.abs(errors(wall, offset, ratio)) < most * ratio**2 + 1e-7).all()
    if offset:
        assert np.abs(errors(wall, offset, 0.02, flat=True)).max() > 0.01
        # At a face: three times h / 2R of the stiffness of one layer against pressure, and nu h / R.
        assert wall != "one" or offset != 0.5 or abs(errors(wall, offset, 0.05, flat=True)[0] + 0.09) < 0.005
    elif wall in ("one", "sandwich"):
        assert np.allclose(errors(wall, 0.0, 0.05), errors(wall, 0.0, 0.05, flat=True), rtol=0, atol=1e-13)


@pytest.mark.parametrize("wall", ["one", "stiff inside", "stiff outside", "sandwich"])
def test_rate(wall):
    """The exponent between thickness over radius 0.1 and 0.0125, in bending. (A cross-ply keeps 0.0024 h/R, because Love's
    mixed terms are left out, which are not zero where its axial strain is held.)"""
    ratios = np.array([0.1, 0.05, 0.025, 0.0125])
    found = [abs(errors(wall, 0.5, ratio)[1]) for ratio in ratios]
    assert np.polyfit(np.log(ratios), np.log(found), 1)[0] == pytest.approx(2, abs=0.15)
    plain = [abs(errors(wall, 0.5, ratio, flat=True)[0]) for ratio in ratios]
    assert np.polyfit(np.log(ratios), np.log(plain), 1)[0] == pytest.approx(1, abs=0.15)


def test_parallel_surfaces_are_a_group(rng):
    b = 0.3 * rng.normal(size=(5, 3))
    there = strains_at(b, 0.4)
    on = curvature_at(b, 0.4)
    assert np.allclose(strains_at(on, -0.4) @ there, np.eye(6), atol=1e-13)
    assert np.allclose(strains_at(on, 0.25) @ there, strains_at(b, 0.65), atol=1e-13)


def test_strain_at_a_height_is_that_of_the_metric(rng):
    """Of a surface z = x . A x / 2 + ..., moved: half the difference of the metrics of r + z n, by differences."""
    second, step, z = rng.normal(size=(3, 3)), 1e-5, 0.2  # r_xx, r_yy, r_xy at the origin
    second[:, :2] *= 0.1

    def metric(first, second):
        def position(x, y):
            r = first[0] * x + first[1] * y + (second[0] * x * x + second[1] * y * y) / 2 + second[2] * x * y
            r_x, r_y = first[0] + second[0] * x + second[2] * y, first[1] + second[1] * y + second[2] * x
            n = np.cross(r_x, r_y)
            return r + z * n / np.linalg.norm(n)

        slopes = [(position(*(step * d)) - position(*(-step * d))) / (2 * step) for d in np.eye(2)]
        return np.array([[a @ b for b in slopes] for a in slopes])

    def forms(first, second):
        n = np.cross(*first) / np.linalg.norm(np.cross(*first))
        normal = [v @ n for v in second]
        return np.array([[a @ b for b in first] for a in first]), np.array([[normal[0], normal[2]], [normal[2], normal[1]]])

    def voigt(E):
        return np.array([E[0, 0], E[1, 1], 2 * E[0, 1]])

    flat, small = np.eye(3)[:2], 1e-4
    moved, bent = flat + small * rng.normal(size=(2, 3)), second + small * rng.normal(size=(3, 3))
    (a0, b0), (a1, b1) = forms(flat, second), forms(moved, bent)
    own = np.concatenate([voigt(a1 - a0) / 2, voigt(b0 - b1)])
    mu = np.eye(2) - z * b0
    lengths = np.linalg.inv(mu)
    expected = voigt(lengths @ (metric(moved, bent) - metric(flat, second)) @ lengths / 2)
    found = strains_at(np.array([b0[0, 0], b0[1, 1], b0[0, 1]]), z)[:3] @ own
    # What is quadratic in the strain, and differences.
    assert np.allclose(found, expected, atol=3e-3 * np.abs(expected).max())
    assert not np.allclose(own[:3] + z * own[3:], expected, atol=3e-2 * np.abs(expected).max())


@pytest.mark.parametrize("wall", ["one", "cross-ply"])
def test_the_frame_does_not_matter(wall, rng):
    angle, b = 0.7, np.array([0.05, -0.02, 0.03])
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])
    B = turn @ np.array([[b[0], b[2]], [b[2], b[1]]]) @ turn.T
    seen = np.array([B[0, 0], B[1, 1], B[0, 1]])
    layers = laminate(wall, 0.4).layers
    other = sk.Laminate([sk.Layer(layer.material, layer.thickness, layer.angle - angle) for layer in layers], 0.4)
    T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    both = np.kron(np.eye(2), T)
    one, two = (CurvedSection(m.section()).law(k) for m, k in ((laminate(wall, 0.4), b), (other, seen)))
    assert np.allclose(one, both.T @ two @ both, rtol=1e-10, atol=1e-10 * np.abs(one).max())


def test_equal_layers_are_one_layer_at_every_height(rng):
    b = 0.05 * rng.normal(size=(7, 3))
    one = CurvedSection(laminate("one", 0.7).section())
    many = CurvedSection(sk.Laminate([sk.Layer(STIFF, t) for t in (0.2, 0.5, 0.3)], 0.7).section())
    assert np.allclose(many.law(b), one.law(b), rtol=1e-12, atol=1e-12)
    flat = np.zeros((3, 3))
    for wall in WALLS:
        section = laminate(wall, 0.7).section()
        assert np.array_equal(CurvedSection(section).law(flat), np.broadcast_to(section.abd(), (3, 6, 6)))
        nearly = CurvedSection(section).law(flat + 1e-12)
        assert np.allclose(nearly, section.abd(), rtol=1e-10, atol=1e-10 * section.abd().max())
    assert CurvedSection(laminate("sandwich").section()).centred and not one.centred


# --- shells ----------------------------------------------------------------------------------------------------------


def tube(material, R, supports, loads, n=12, theory="kirchhoff", length=None):
    surface = sk.CylinderSector(R, R / 4 if length is None else length, QUARTER)
    problem = sk.Problem(surface, material=material, supports=[sk.Symmetry("start"), *supports], loads=loads)
    return problem.on(sk.meshes.uniform(surface, 2, n), theory)


def outwards(solution, x, angle=QUARTER / 2):
    return solution.displacement((x, angle)) @ [0.0, -np.cos(angle), np.sin(angle)]


PLANE = [sk.Symmetry("left"), sk.Symmetry("right")]


@pytest.mark.parametrize("wall, offset", [("one", 0.5), ("one", -0.5), ("stiff inside", 0.0), ("cross-ply", 0.5)])
def test_a_pressed_tube(wall, offset):
    """From the face on which the pressure acts too, by Poisson's ratio and all."""
    R, p = 50.0, 1e-9
    section = laminate(wall, offset).section()
    system = tube(laminate(wall, offset), R, [sk.Symmetry("end"), *PLANE], [sk.FollowerPressure(p)])
    exact = layered_tube.pressed(R + section.z, laws(wall), R)
    solution = sk.solve_linear(system)
    assert outwards(solution, R / 8) / p == pytest.approx(exact.at_surface(R), rel=CRUSHED[wall] / R**2)
    # What holds the pressure is p R per length of the reference surface, wherever the wall is.
    points = np.array([[0.5], [0.5]])
    assert np.allclose(solution.section_forces(points)[:, 1], p * R, rtol=1e-3)
    height = section.z[-1] - 0.1
    hoop = exact.stress(len(WALLS[wall]) - 1, R + height)[1]
    assert np.allclose(solution.stresses(points, height)[..., 1], p * hoop, rtol=0.03)


def test_a_pressed_tube_in_full():
    """Integrated through the thickness, it is right with its wall at a face, as far as the mesh is fine."""
    law = sk.Isotropic(1.0, 0.0, 1.0)
    wall = sk.Laminate([sk.Layer(law, 1.0)], 0.5)
    with pytest.warns(sk.OutOfDepth, match="too stiff on coarse meshes"):
        system = tube(wall, 50.0, [sk.Symmetry("end"), *PLANE], [sk.FollowerPressure(1e-9)], 24, "full")
    exact = layered_tube.pressed(50 + wall.section().z, [law.stiffness()], 50.0)
    assert outwards(sk.solve_linear(system), 6.0) / 1e-9 == pytest.approx(exact.at_surface(50.0), rel=2e-3)


@pytest.mark.parametrize("wall, offset", [("one", 0.5), ("stiff inside", 0.0), ("cross-ply", 0.5)])
def test_a_bent_tube(wall, offset):
    """The energy of pure bending."""
    R, moment = 20.0, 1e-6
    section = laminate(wall, offset).section()
    held = [*PLANE, sk.Prescribed((0.0, 0.0), (None, 0.0, None))]
    system = tube(laminate(wall, offset), R, held, [sk.EdgeMoment("end", (moment, 0, 0))])
    exact = layered_tube.tube(R + section.z, laws(wall), turn=1.0)
    stiffness = exact.integral(1, 1)
    solution, energy = sk.solve_linear(system), moment**2 / stiffness * QUARTER * R / 8
    assert solution.strain_energy == pytest.approx(energy, rel=ORDER / R**2)
    # At the faces no straight line: h / 3R more inside and less outside, of one layer.
    found = [abs(solution.stresses(np.array([[0.5], [0.5]]), face)[0, 0, 1]) for face in section.z[[0, -1]]]
    right = [abs(exact.stress(k, R + face)[1]) for k, face in ((0, section.z[0]), (len(exact.laws) - 1, section.z[-1]))]
    right = np.array(right) * moment / stiffness
    assert np.allclose(found, right, atol=8e-3 * right.max())
    assert wall != "one" or right[0] / right[1] - 1 > 0.03


@pytest.mark.parametrize("offset", [0.0, 0.5, -0.5])
def test_a_pressed_sphere(offset):
    """Lame's, an eighth of it, to what the mesh at the pole leaves."""
    R, p, nu = 20.0, 1e-9, 0.3
    ball = sk.SphereSector(R, (0.0, QUARTER), QUARTER)
    planes = [sk.Symmetry(side) for side in ("bottom", "start", "end")]
    problem = sk.Problem(ball, material=laminate("one", offset), supports=planes, loads=[sk.FollowerPressure(p)])
    solution = sk.solve_linear(problem.on(sk.meshes.uniform(ball, 8, 8), "kirchhoff"))
    found = np.linalg.norm(solution.displacement((QUARTER / 2, QUARTER / 2))) / p
    a, b = R + offset - 0.5, R + offset + 0.5
    inside, outside = R**2 / a**2 * (b - R), -(R**2) / b**2 * (R - a)  # so that thinning does the work it does at R
    exact = (1 - 2 * nu) * (inside * a**3 - outside * b**3) * R + (1 + nu) / 2 * (inside - outside) * (a * b) ** 3 / R**2
    assert found == pytest.approx(exact / (b**3 - a**3), rel=4e-4 + 2 * ORDER / R**2 * abs(offset))


@pytest.mark.parametrize("offset", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_a_ring_expands_freely(offset, theory):
    """Its size and its curvature change together, without stress and energy."""
    R, change, points = 20.0, 1e-6, np.array([[0.5, 0.1], [0.5, 0.8]])
    supports = [sk.Symmetry("end"), sk.Symmetry("left")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)  # full off its surface
        system = tube(laminate("one", offset), R, supports, [sk.Temperature(change)], 8, theory)
    solution = sk.solve_linear(system)
    # The thin theory's normals keep their length between a surface and layers that are somewhere else.
    grown = R + (max(offset - 0.5, 0.0) if theory == "kirchhoff" else 0.0)
    assert outwards(solution, R / 8) == pytest.approx(change * grown, rel=3e-5 if theory == "kirchhoff" else 1e-3)
    for z in (offset - 0.5, offset, offset + 0.5):
        # Of E alpha T; what is left is of second order in the height over the radius.
        assert np.abs(solution.stresses(points, z)[..., [0, 1, 5]]).max() < 1e-3 * change
    assert np.abs(solution.section_forces(points)).max() < 1e-3 * change
    assert abs(solution.strain_energy) < 1e-5 * system.shell.thermal_energy()


@pytest.mark.parametrize("offset, tolerance", [(0.0, 0.005), (0.5, 0.05)])
def test_hoop_force_of_a_pinched_ring_is_that_of_statics(offset, tolerance):
    """-P cos(angle) from the side to the load; bending alone would leave M / R."""
    R, force = 20.0, 1e-6
    supports = [*PLANE, sk.NoRotation("end"), sk.Roller("end", (0, 1, 0))]
    solution = sk.solve_linear(tube(laminate("one", offset), R, supports, [sk.EdgeLoad("end", (0, 0, -force))], 24))
    points = np.array([[0.5], [0.5]])
    angle = solution.system.geometry.parameters(points)[1, :, 0]
    forces = solution.section_forces(points)[..., 0] / force
    assert np.abs(forces[:, 1] + np.cos(angle)).max() < tolerance
    assert np.abs(forces[:, 4] / R).max() > 0.3


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_gradient_of_the_section_forces_on_a_curved_surface(theory, rng):
    surface = sk.SphereSector(1.0, (0.6, 1.4), 0.9)
    layers = [sk.Layer(sk.Isotropic(1e6, 0.3, 1.0), 0.05), sk.Layer(sk.Isotropic(2e5, 0.3, 1.0), 0.05)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sk.OutOfDepth)
        system = sk.Problem(surface, material=sk.Laminate(layers, 0.03)).on(sk.meshes.uniform(surface, 2, 1), theory)
    points, elements = np.array([[0.3, 0.8], [0.6, 0.2]]), np.arange(2)
    weights = rng.normal(size=(2, 6, 2))
    q, eps = system.undeformed + 0.02 * rng.normal(size=system.n_dofs), 1e-6
    step = eps * rng.normal(size=system.n_dofs)
    ahead, behind = (np.vdot(weights, system.shell.section_forces(q + sign * step, points)) for sign in (1, -1))
    gradient = system.assembly.section_force_gradient(q.reshape(-1, 4, 3), elements, points, weights)
    assert (ahead - behind) / 2 == pytest.approx(gradient.ravel() @ step, rel=1e-6)


@pytest.mark.parametrize("offset", [0.0, 0.005, -0.1, 0.2])
def test_frequency_of_a_ring_off_its_surface(offset):
    """cos 2 angle without stretch of the wall, whose mass is taken to be in the reference surface, as the warning says."""
    R, h, n = 1.0, 0.01, 2
    law = sk.Laminate([sk.Layer(sk.Isotropic(1.0, 0.0, 1.0), h)], offset)
    system = tube(law, R, [sk.Symmetry("end"), *PLANE], [], length=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if offset else "error", sk.OutOfDepth)
        found = 2 * np.pi * sk.modes(system, 1).frequencies[0]
    wall = R + offset
    along = (1 - offset / wall) / n + n * offset / wall  # movement along the reference surface
    mass = h * wall * (1 + along**2)
    assert found == pytest.approx(np.sqrt(h**3 / 12 * (n * n - 1) ** 2 / wall**3 / mass), rel=3e-3)


def test_where_it_does_not_hold():
    surface, half = sk.CylinderSector(1.0, 0.5, QUARTER), sk.Layer(STIFF, 0.15)
    mesh = sk.meshes.uniform(surface, 1, 2)

    def on(*args, theory="kirchhoff"):
        return sk.Problem(surface, material=sk.Laminate(*args)).on(mesh, theory)

    for theory in ("kirchhoff", "full", "auto"):
        with (pytest.raises(sk.InputError, match=r"height -1\.2 m are past a centre.*radii go down to (0\.9|1\.03)"),
              warnings.catch_warnings()):  # fmt: skip
            warnings.simplefilter("ignore", sk.OutOfDepth)
            on([half], -1.125, theory=theory)
    with pytest.warns(sk.OutOfDepth, match=r"thickness over radius, which is 0\.3.*half of its square, 5"):
        on([half, sk.Layer(SOFT, 0.15)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        on([half], 1.0)
        on([half, half])
        on([sk.Layer(STIFF, 0.04), sk.Layer(SOFT, 0.04)])


def test_an_open_shell_that_is_warm_keeps_its_shape():
    """Uniform heat makes a similar body, whatever the surface that its layers are told from."""
    surface, law = sk.CylinderSector(1.0, 1.0, 1.1), sk.Isotropic(1e9, 0.3, 1.0, expansion=1e-5)
    section = sk.Laminate([sk.Layer(law, 0.05)], offset=0.02)
    held = [sk.Clamp((0.0, 0.0))]
    problem = sk.Problem(surface, None, section, held, [sk.Temperature(10.0)])
    found = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 4, 6), "kirchhoff"))
    far = np.array([1.0, 1.1])
    grown = 1e-4 * (found.system.geometry.surface.position(*far[:, None]) - surface.position(*np.zeros((2, 1))))[:, 0]
    assert np.allclose(found.displacement(tuple(far)), grown, atol=2e-3 * np.linalg.norm(grown))
