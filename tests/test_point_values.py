"""What a state says at places, along lines and through the thickness, against known answers."""

import numpy as np
import pytest

import skancf as sk
from skancf.layout.around import elements_around

E, H, L, B = 2e7, 0.02, 1.0, 0.25
STRIP = sk.Rectangle(L, B)
PLAIN = sk.Isotropic(E, 0.0, 1e3)
THEORIES = ["kirchhoff", "full"]


def meshes(kind):
    uniform = sk.meshes.uniform(STRIP, 8, 2)
    if kind == "quadtree":
        return sk.meshes.quadtree(uniform).refined([0, 5, 6])
    if kind == "graded":
        return sk.meshes.graded(STRIP, [sk.meshes.Region((0.0, 0.125), (0.2, 0.05))], nodes=120)
    return uniform


def solved(problem, mesh, theory="kirchhoff", linear=True):
    system = problem.on(mesh, theory)
    return sk.solve_linear(system) if linear else sk.solve(system).solution


def bent(moment, theory="kirchhoff", mesh=None, linear=True, material=PLAIN, thickness=H):
    load = sk.EdgeMoment("right", (0.0, -moment, 0.0))
    problem = sk.Problem(STRIP, thickness, material, [sk.Clamp("left")], [load])
    return solved(problem, meshes("uniform") if mesh is None else mesh, theory, linear)


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("kind", ["uniform", "quadtree", "graded"])
def test_faces_of_a_bent_strip_have_six_m_over_h_squared(theory, kind):
    state = bent(3.0, theory, meshes(kind))
    assert kind != "quadtree" or len(state.system.mesh.hanging)
    rng = np.random.default_rng(1)
    points = np.vstack([rng.uniform(0.02, 0.98, (20, 2)) * [L, B], [(0.5, 0.125), (0.25, 0.0), (1.0, 0.25), (0.0, 0.0625)]])
    values = state.at(points)
    size = 6 * 3.0 / H**2
    sign = np.sign(values.M[0, 0])
    assert np.abs(values.M[:, 0] - sign * 3.0).max() < 1e-6 * 3 and np.abs(values.N).max() < 1e-6
    for face, way in (("top", 1), ("bottom", -1), (H / 2, 1), ("middle", 0)):
        stress = values.stress(face)
        assert np.abs(stress.components[:, 0] - way * sign * size).max() < 1e-5 * size
        assert np.abs(stress.von_mises - abs(way) * size).max() < 1e-5 * size
        assert np.abs(stress.principal[:, 1]).max() < 1e-5 * size
    assert np.allclose(values.columns["mises_top"], size, rtol=1e-5)


@pytest.mark.parametrize("theory", THEORIES)
def test_stress_in_space_turns_with_the_body(theory):
    """A strip that a moment rolls by a right angle: at the tip the fibres run along the axis z of space."""
    moment = E * H**3 / 12 * (np.pi / 2) / L
    state = bent(moment, theory, sk.meshes.uniform(STRIP, 16, 1), linear=False)
    values = state.at([(L, B / 2), (L / 2, B / 2), (0.0, B / 2)])
    assert values.rotations == pytest.approx([np.pi / 2, np.pi / 4, 0.0], abs=6e-3)
    size = E * H / 2 * (np.pi / 2) / L
    local = values.stress("top").components
    assert np.abs(np.abs(local[:, 0]) - size).max() < 0.03 * size
    tip, middle, root = values.stress("top", frame="global").tensors
    s = local[0, 0]
    assert np.abs(tip - np.diag([0, 0, s])).max() < 0.02 * size
    up = np.sign(state.displacement((L, B / 2))[2])
    assert np.abs(middle - 0.5 * s * np.array([[1, 0, up], [0, 0, 0], [up, 0, 1]])).max() < 0.02 * size
    assert np.abs(root - np.diag([s, 0, 0])).max() < 0.03 * size
    undeformed = values.stress("top", frame="global", measure="second piola").tensors
    assert np.abs(undeformed - undeformed[0]).max() < 0.06 * size and abs(undeformed[0, 0, 0] - s) < 0.1 * size


@pytest.mark.parametrize("theory", THEORIES)
def test_a_pressure_vessel_has_its_hoop_stress_around_the_axis(theory):
    R, h, p = 1.0, 0.01, 10.0
    surface = sk.CylinderSector(R, 0.5, np.pi / 2, 0.0)
    supports = [sk.Symmetry(side) for side in ("left", "start", "end")]
    problem = sk.Problem(surface, h, PLAIN, supports, [sk.FollowerPressure(p)])
    state = solved(problem, sk.meshes.uniform(surface, 2, 8), theory)
    angles = np.array([0.0, 0.3, np.pi / 4, 1.2, np.pi / 2])
    values = state.at(np.stack([np.full(5, 0.3), angles], axis=1))
    stress = values.stress("middle", frame="global").tensors
    around = np.stack([0 * angles, np.sin(angles), np.cos(angles)], axis=1)
    hoop = p * R / h
    assert np.abs(stress - hoop * around[:, :, None] * around[:, None]).max() < 0.01 * hoop
    assert np.abs(values.stress("middle").max_principal - hoop).max() < 0.01 * hoop
    assert np.abs(values.N[:, 1] - p * R).max() < 0.01 * p * R
    normals = np.stack([0 * angles, -np.cos(angles), np.sin(angles)], axis=1)
    assert np.abs(values.frames[:, 2] - normals).max() < 1e-3 and np.abs(values.frames[:, 0] - [1, 0, 0]).max() < 1e-3


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("linear", [True, False])
def test_shear_force_of_a_clamped_strip(theory, linear):
    pressure = 1e-3
    problem = sk.Problem(STRIP, H, PLAIN, [sk.Clamp("left"), sk.Clamp("right")], [sk.SurfaceLoad((0, 0, pressure))])
    state = solved(problem, sk.meshes.uniform(STRIP, 16, 1), theory, linear)
    middles = (np.arange(16) + 0.5) / 16
    line = state.at(np.stack([middles, np.full(16, B / 2)], axis=1))
    known = pressure * (L / 2 - middles)
    assert np.abs(np.abs(line.Q[:, 0]) - np.abs(known)).max() < 0.01 * known[0]
    assert np.sign(line.Q[0, 0]) == -np.sign(line.Q[-1, 0])
    ends = state.at([(0.0, B / 2), (L / 2, B / 2)])
    assert np.abs(np.abs(ends.M[:, 0]) - pressure * L**2 / np.array([12, 24])).max() < 0.02 * pressure / 12


@pytest.mark.parametrize("theory", THEORIES)
def test_layers_of_a_laminate_have_their_own_stress(theory):
    """Stiff faces and a soft core under a moment: E_k z kappa in each layer."""
    soft = sk.Isotropic(E / 10, 0.0, 1e3)
    laminate = sk.Laminate([sk.Layer(PLAIN, 0.004), sk.Layer(soft, 0.012), sk.Layer(PLAIN, 0.004)])
    state = bent(2.0, theory, material=laminate, thickness=None)
    D = E * (0.02**3 - 0.012**3) / 12 + E / 10 * 0.012**3 / 12
    profile = state.through_thickness((0.4, 0.1), n=3)
    sign = np.sign(profile.stress[-1, 0])
    assert profile.layer.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert np.allclose(profile.z, [-0.01, -0.008, -0.006, -0.006, 0.0, 0.006, 0.006, 0.008, 0.01], atol=1e-12)
    young = np.where(profile.layer == 1, E / 10, E)
    known = sign * young * profile.z * 2.0 / D
    assert np.abs(profile.stress[:, 0] - known).max() < 1e-4 * np.abs(known).max()
    assert profile.columns["mises"][3] < 0.2 * profile.columns["mises"][2]


def test_at_a_border_of_zones_values_are_means_or_of_one_side():
    zone = sk.Zone("thick", ((0.5, 1.0), (0.0, B)), thickness=2 * H)
    problem = sk.Problem(STRIP, H, PLAIN, [sk.Clamp("left")], [sk.EdgeLoad("right", (10.0, 0, 0))], zones=[zone])
    state = solved(problem, sk.meshes.uniform(STRIP, 8, 2))
    point = (0.5, 0.1)
    thin, thick, mean = (state.at(point, side=side).stress("middle").components[0, 0] for side in ((-1, 0), (1, 0), None))
    assert (thin, thick, mean) == pytest.approx((10 / H, 5 / H, 7.5 / H), rel=0.05)
    assert mean == pytest.approx((thin + thick) / 2)
    with pytest.raises(sk.InputError, match=r"side = \(-1\.0, 0\.0\): there is no element on that side of \(0, 0\.1\)"):
        _ = state.at((0, 0.1), side=(-1, 0)).N
    line = state.along((0.5, 0.0), (0.5, B), n=5, side=(1, 0))
    assert np.allclose(line.stress("middle").max_principal, 5 / H, rtol=0.05)


def test_rubber_has_its_cauchy_stress_at_points():
    surface, rubber = sk.Rectangle(1.0, 1.0), sk.NeoHooke(shear=1e5, density=1e3)
    stretch = 1.6
    supports = [
        sk.Symmetry("left"), sk.Symmetry("bottom"), sk.Prescribed((0, 0), (None, None, 0)),
        sk.Prescribed("right", (stretch - 1, None, None)),
    ]  # fmt: skip
    state = solved(sk.Problem(surface, 0.01, rubber, supports), sk.meshes.uniform(surface, 2, 2), linear=False)
    stress = state.at([(0.3, 0.7), (0.5, 0.5)]).stress("middle")
    assert stress.components[:, 0] == pytest.approx(1e5 * (stretch**2 - 1 / stretch), rel=1e-6)
    assert np.allclose(stress.von_mises, stress.components[:, 0], rtol=1e-6)


def test_a_line_has_arc_length_corners_and_columns(tmp_path):
    state = bent(3.0)
    line = state.along((0, 0.1), (0.6, 0.1), (0.6, 0.25), n=26)
    assert line.s[-1] == pytest.approx(0.75) and np.all(np.diff(line.s) > 0) and len(line) == 26
    assert np.abs(line.points - [0.6, 0.1]).sum(axis=1).min() < 1e-12
    assert np.array_equal(line.columns["u3"], state.displacement(line.points)[:, 2])
    frame = line.to_dataframe()
    assert list(frame.columns[:3]) == ["s", "x", "y"] and frame.attrs["units"]["M11"] == "N"
    assert line.to_csv(tmp_path / "line.csv").read_text().startswith("s [m],x,y,X [m],")
    tube = sk.CylinderSector(2.0, 1.0, np.pi)
    problem = sk.Problem(tube, H, PLAIN, [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    around = solved(problem, sk.meshes.uniform(tube, 1, 6)).along((0.5, 0.0), (0.5, np.pi), n=7)
    assert around.s[-1] == pytest.approx(2 * np.pi)
    circle = state.along(sk.Arc((0.5, 0.125), 0.1), n=33)
    assert circle.s[-1] == pytest.approx(0.2 * np.pi, rel=1e-3) and circle.M[:, 0] == pytest.approx(circle.M[0, 0])


def test_places_outside_are_named():
    state = bent(3.0)
    with pytest.raises(
        sk.InputError, match=r"points: 2 of 3 lie outside the surface: \(1\.5, 0\.1\), \(2, 0\); .* from \(0, "
    ):
        state.at([(1.5, 0.1), (0.5, 0.1), (2.0, 0.0)])
    with pytest.raises(sk.InputError, match=r"points: 1 of 2 lie outside the surface: \(1\.2, 0\)"):
        state.along((0, 0), (1.2, 0))
    with pytest.raises(sk.InputError, match="this line has no length"):
        state.along((0, 0), (0, 0))
    with pytest.raises(sk.InputError, match="give two points"):
        state.along((0, 0))


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("kind", ["quadtree", "uniform"])
def test_some_elements_have_the_values_that_all_have(theory, kind):
    """In a state without any symmetry, so that each depends on its own neighbours."""
    system = sk.Problem(STRIP, H, PLAIN, [sk.Clamp("left")], []).on(meshes(kind), theory)
    rng = np.random.default_rng(5)
    state = sk.Solution(system, system.undeformed + 1e-4 * rng.normal(size=system.n_dofs))
    points, some = rng.uniform(0, 1, (2, 3)), np.array([7, 1, 4])
    for name in ("strains", "stresses", "recovered_strains", "recovered_stresses", "cauchy_stresses"):
        whole, part = getattr(state, name)(points, "top"), getattr(state, name)(points, "top", some)
        assert np.abs(part - whole[some]).max() < 1e-10 * np.abs(whole).max(), name
    for name in ("section_forces", "recovered_section_forces", "shear_forces"):
        whole, part = getattr(state, name)(points), getattr(state, name)(points, some)
        assert np.abs(part - whole[some]).max() < 1e-10 * np.abs(whole).max(), name
    at = system.geometry.parameters(points[:, :1])[:, some, 0].T
    assert (
        np.abs(state.at(at).M - state.recovered_section_forces(points[:, :1])[some, 3:, 0]).max()
        < 1e-7 * np.abs(whole).max()
    )
    with pytest.raises(sk.InputError, match=r"elements = \[99\]: give numbers of elements from 0 to"):
        state.strains(points, "top", [99])


def test_elements_that_meet_at_a_place():
    tube = sk.CylinderSector(1.0, 1.0, 2 * np.pi, closed=True)
    system = sk.Problem(tube, 0.01, PLAIN, [sk.Clamp("left")], []).on(sk.meshes.uniform(tube, 2, 8))
    places = np.array([[0.1, 0.1], [0.5, 0.1], [0.5, 0.0], [0.25, 2 * np.pi], [0.0, 0.0]]).T
    found = elements_around(system.geometry, places)
    assert np.bincount(found.places).tolist() == [1, 2, 4, 2, 2]
    at_seam = found.local[found.places == 3]
    assert sorted(at_seam.ravel().round(9).tolist()) == [0.0, 0.5, 0.5, 1.0]


def test_a_motion_at_a_time_and_a_mode_say_what_they_are():
    problem = sk.Problem(STRIP, H, PLAIN, [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    system = problem.on(sk.meshes.uniform(STRIP, 4, 1))
    motion = sk.simulate(system, 0.02, dt=0.01, progress=False)
    line = motion.at(0.015).along((0, 0.1), (1, 0.1), n=3)
    assert line.state.time == 0.015 and np.abs(line.displacements[-1, 2]) > 0
    mode = sk.modes(system, 1).shape(0)
    assert "size" in repr(mode.at((0.5, 0.1))) or mode.note in repr(mode.at((0.5, 0.1)))
    assert mode.note


def test_lines_are_drawn():
    from matplotlib.figure import Figure

    line = bent(3.0).along((0, 0.1), (1, 0.1), n=5)
    axes = line.plot("M11", "M22", axes=Figure().subplots())
    assert axes.get_ylabel() == "[N]" and len(axes.lines) == 2 and axes.get_legend()
    assert line.plot("u3", axes=Figure().subplots(), units=sk.Units(length="mm")).get_ylabel() == "u3 [mm]"
    assert np.array_equal(axes.lines[0].get_ydata(), line.M[:, 0])
    with pytest.raises(sk.InputError, match="they have different units, N, m"):
        line.plot("M11", "u3")
    with pytest.raises(sk.InputError, match="name = 'M13': is no column; there are s, x, y"):
        line.plot("M13")
