"""Files, pictures and charts of states."""

import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from PIL import Image

import skancf as sk
from skancf import atomic, output
from skancf.errors import InputError, SkancfError
from skancf.output.fields import place, readable_unit, unit, values
from skancf.output.files import FILE_ORDER
from skancf.output.frames import sight
from skancf.output.plane import subdivided
from skancf.output.rendering import check_rendering
from skancf.output.sampling import grid
from skancf.output.style import Style, title_of
from skancf.tensors import von_mises

THICKNESS = 0.1


def system(nx=3, ny=2, surface=None):
    plate = sk.Problem(surface or sk.Rectangle(3.0, 2.0), THICKNESS, sk.Isotropic(1.2e6, 0.3, 1.0), [sk.Clamp("left")])
    return plate.on(sk.meshes.uniform(plate.surface, nx, ny))


@pytest.fixture(scope="module")
def rested():
    return system()


def moved(of, *, rotation=None, by=(0.0, 0.0, 0.0), **state):
    """A rigid motion of a system: slopes and directors only turn."""
    nodal = of.undeformed.reshape(-1, 4, 3) @ (np.eye(3) if rotation is None else rotation).T
    nodal[:, 0] += by
    return sk.Solution(of, nodal.ravel(), **state)


def bent(of, seed=1, size=1e-2, **state):
    """A state with every strain and stress different from zero."""
    rng = np.random.default_rng(seed)
    velocity = rng.normal(size=of.undeformed.shape)
    return sk.Solution(of, of.undeformed + size * rng.normal(size=of.undeformed.shape), velocity, **state)


def about_y(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def left_over(folder):
    return [file.name for file in Path(folder).rglob("*") if "part" in file.name or "probe" in file.name]


# Sampling


def test_grid_is_the_square_cut_evenly():
    cut = grid(3)
    x, y = cut.points[:, cut.cells]
    area = 0.5 * sum(x[:, i] * y[:, (i + 1) % 4] - x[:, (i + 1) % 4] * y[:, i] for i in range(4))
    # Positive: counter-clockwise.
    np.testing.assert_allclose(area, 1 / 9, rtol=1e-14)
    steps = np.linalg.norm(np.diff(cut.points[:, cut.rim], axis=1), axis=0)
    np.testing.assert_allclose(steps, np.full(12, 1 / 3), rtol=1e-14)
    assert cut.rim[0] == cut.rim[-1]


@pytest.mark.parametrize("subdivisions", [0, -1, 2.0, "4", True])
def test_subdivisions_are_a_whole_number(rested, subdivisions):
    with pytest.raises(InputError, match=r"subdivisions = .* whole number of at least 1"):
        output.sample(moved(rested), subdivisions)


@pytest.mark.parametrize("z", [0.0, -THICKNESS / 2])
def test_samples_are_the_solution_at_the_same_points(rested, z):
    state = bent(rested)
    samples = output.sample(state, 2, z)
    local, geometry = grid(2).points, rested.geometry
    at = geometry.parameters(local).reshape(2, -1).T
    # Points on element edges belong to several elements; positions agree there.
    np.testing.assert_allclose(samples.points, state.position(at, z), rtol=0, atol=1e-12)
    np.testing.assert_allclose(samples.displacement, state.displacement(at, z), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(samples.stress, state.recovered_stresses(local, z).reshape(-1, 6))
    np.testing.assert_array_equal(samples.strain, state.recovered_strains(local, z).reshape(-1, 6))
    assert samples.cells.shape == (rested.geometry.n_elements * 4, 4)


def test_velocity_is_the_rate_of_position(rested):
    state, dt = bent(rested), 1e-3
    later = sk.Solution(rested, state.q + dt * state.velocity)
    rate = (output.sample(later, 3, 0.02).points - output.sample(state, 3, 0.02).points) / dt
    # Positions are linear in q; what is left is rounding over dt.
    np.testing.assert_allclose(output.sample(state, 3, 0.02).velocity, rate, rtol=0, atol=1e-11)


def test_a_rigid_motion_lands_where_it_should(rested):
    turn, by, z = about_y(0.7), np.array([1.0, -2.0, 0.5]), 0.03
    samples = output.sample(moved(rested, rotation=turn, by=by), 3, z)
    before = output.sample(moved(rested), 3, z).points
    np.testing.assert_allclose(before[:, 2], z, rtol=0, atol=1e-14)
    np.testing.assert_allclose(samples.points, before @ turn.T + by, rtol=0, atol=1e-13)
    assert np.abs(samples.strain).max() < 1e-13


def test_mises_of_known_stresses():
    # Uniaxial s, pure shear t and hydrostatic pressure: s, sqrt(3) t, 0.
    stress = np.array([[3.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0], [5.0, 5, 5, 0, 0, 0]])
    np.testing.assert_allclose(von_mises(stress), [3.0, 2 * np.sqrt(3), 0.0], rtol=1e-15)


def test_fields_have_units_and_values(rested):
    state = bent(rested)
    samples = output.sample(state, 2, 0.01)
    assert [unit(name) for name in ("S11", "mises", "E12", "u1", "v2", "displacement", "velocity")] == [
        "Pa", "Pa", "", "m", "m/s", "m", "m/s"]  # fmt: skip
    np.testing.assert_array_equal(values(state, "S13", 2, 0.01), samples.stress[:, 4])
    np.testing.assert_array_equal(values(state, "E12", 2, 0.01), samples.strain[:, 5])
    np.testing.assert_array_equal(values(state, "v2", 2, 0.01), samples.velocity[:, 1])
    np.testing.assert_array_equal(values(state, "displacement", 2, 0.01), np.linalg.norm(samples.displacement, axis=1))
    assert readable_unit("S11", 2.5e6) == (1e-6, "MPa")
    assert readable_unit("displacement", 2.5e6) == (1.0, "m")
    with pytest.raises(InputError, match=r"velocity.*no velocities"):
        values(moved(rested), "velocity", 2, 0.0)


@pytest.fixture(scope="module")
def cantilever():
    """Bent by a moment: S11 = 6 M / t^2 at the faces, as wide as the plate stays flat across (nu = 0)."""
    problem = sk.Problem(sk.Rectangle(1.0, 0.5), 0.02, sk.Isotropic(2e9, 0.0, 1.0), [sk.Clamp("left")],
                         [sk.EdgeMoment("right", (0, -200.0, 0))])  # fmt: skip
    return sk.solve_linear(problem.on(sk.meshes.uniform(problem.surface, 3, 2), "kirchhoff"))


FACE = 6 * 200.0 / 0.02**2


def test_bent_plates_have_no_stress_without_a_depth(cantilever):
    inside = np.full((2, 1), 0.5)
    for ask in (cantilever.nodal_stresses, lambda: cantilever.stresses(inside), lambda: cantilever.strains(inside)):
        with pytest.raises(InputError, match=r"z: .* z='top' \(0\.01 m\), z='bottom' \(-0\.01 m\)"):
            ask()
    top, middle, bottom = (cantilever.nodal_stresses(z)[:, 0] for z in ("top", "middle", "bottom"))
    np.testing.assert_allclose(np.abs(top), FACE, rtol=1e-6)
    np.testing.assert_allclose(bottom, -top, rtol=1e-6)
    assert np.abs(middle).max() < 1e-6 * FACE
    np.testing.assert_array_equal(top, cantilever.nodal_stresses(0.01)[:, 0])
    with pytest.raises(InputError, match="z = 'face': give a depth"):
        cantilever.nodal_stresses("face")


def test_a_laminate_in_tension_has_no_stress_without_a_depth():
    layers = [sk.Layer(sk.Isotropic(young, 0.3, 1.0), 0.01) for young in (1e9, 2e9, 1e9)]
    problem = sk.Problem(sk.Rectangle(1.0, 1.0), None, sk.Laminate(layers))
    of = problem.on(sk.meshes.uniform(problem.surface, 2, 2), "kirchhoff")
    q = of.undeformed.reshape(-1, 4, 3).copy()
    q[:, :2, 0] *= 1.001
    state = sk.Solution(of, q.ravel())
    with pytest.raises(InputError, match="z='middle'"):
        state.nodal_stresses()
    # The inner layer is twice as stiff: largest there, above its lower interface, where no face shows it.
    assert values(state, "mises", 1, None) == pytest.approx(2 * values(state, "mises", 1, "top"), rel=1e-6)
    assert values(state, "mises", 1, None) == pytest.approx(values(state, "mises", 1, 0.0), rel=1e-6)


def test_fields_without_a_depth_say_which_they_are(cantilever):
    section = cantilever.system.problem.section
    np.testing.assert_allclose(values(cantilever, "mises", 2, None), FACE, rtol=1e-6)
    np.testing.assert_array_equal(values(cantilever, "S11", 2, None), values(cantilever, "S11", 2, 0.01))
    expected = {
        ("mises", None): "largest through the thickness",
        ("mises", "bottom"): "bottom face, z = -0.01 m",
        ("S11", None): "top face, z = 0.01 m",
        ("E12", 0.0): "z = 0 m",
        ("u3", None): "",
        ("M11", None): "",
    }
    assert {key: place(key[0], section, key[1])[1] for key in expected} == expected


# Files


def test_a_state_comes_back_as_it_was(rested, tmp_path):
    state = bent(rested, time=0.5)
    path = output.write(state, tmp_path / "state.vtu", subdivisions=3)
    mesh, samples = output.read(path), output.sample(state, 3)
    np.testing.assert_array_equal(mesh.points, samples.points)
    np.testing.assert_array_equal(mesh.cells_dict["quad"], samples.cells)
    np.testing.assert_array_equal(mesh.cell_data["element"][0], samples.elements)
    np.testing.assert_array_equal(mesh.point_data["displacement"], samples.displacement)
    np.testing.assert_array_equal(mesh.point_data["velocity"], samples.velocity)
    for name, z in {"mid": 0.0, "top": THICKNESS / 2, "bottom": -THICKNESS / 2}.items():
        there = output.sample(state, 3, z)
        np.testing.assert_array_equal(mesh.point_data[f"stress_{name}"], there.stress[:, FILE_ORDER])
        np.testing.assert_array_equal(mesh.point_data[f"strain_{name}"], there.strain[:, FILE_ORDER])
        np.testing.assert_array_equal(mesh.point_data[f"mises_{name}"], von_mises(there.stress))
    assert left_over(tmp_path) == []


def test_vtk_reads_the_same(rested, tmp_path):
    import pyvista

    state = bent(rested)
    mesh = pyvista.read(output.write(state, tmp_path / "state.vtu", depths={"there": 0.02}))
    samples = output.sample(state)
    np.testing.assert_array_equal(mesh.points, samples.points)
    assert set(mesh.celltypes) == {pyvista.CellType.QUAD}
    names = {"displacement", "velocity", "stress_there", "strain_there", "mises_there", "membrane_force", "moment"}
    assert set(mesh.point_data) == names
    forces = state.recovered_section_forces(sk.output.sampling.grid(4).points).swapaxes(1, 2).reshape(-1, 6)
    np.testing.assert_array_equal(mesh.point_data["moment"], forces[:, 3:])
    # VTK calls the fourth component of six XY.
    shear = output.sample(state, z=0.02).stress[:, sk.solution.STRESSES.index("S12")]
    np.testing.assert_array_equal(mesh.point_data["stress_there"][:, 3], shear)


def test_a_collection_is_played_by_paraview(rested, tmp_path):
    import pyvista

    times = [0.0, 0.1, 1 / 3]
    states = (moved(rested, by=(0, 0, t), time=t) for t in times)
    path = output.write(states, tmp_path / "deep" / "run.pvd", subdivisions=1)
    reader = pyvista.PVDReader(path)
    assert list(reader.time_values) == times
    reader.set_active_time_value(times[2])
    # VTK reads points as they were written, in double precision.
    np.testing.assert_allclose(reader.read()[0].points[:, 2], times[2], rtol=0, atol=1e-15)
    listed = output.read(path)
    assert [time for time, _ in listed] == times
    np.testing.assert_allclose(output.read(listed[1][1]).points[:, 2], times[1], rtol=0, atol=1e-15)
    assert left_over(tmp_path) == []


@pytest.mark.parametrize("factors, expected", [([0.25, 1.0], [0.25, 1.0]), ([1.0, 0.5], [0.0, 1.0])])
def test_statics_counts_in_load_factors_if_they_grow(rested, tmp_path, factors, expected):
    path = output.write([moved(rested, load_factor=f) for f in factors], tmp_path / "path.pvd", depths={})
    assert [time for time, _ in output.read(path)] == expected


def test_a_shorter_run_leaves_no_frames_of_a_longer_one(rested, tmp_path):
    for n in (4, 2):
        output.write([moved(rested, time=float(t)) for t in range(n)], tmp_path / "run.pvd", depths={}, subdivisions=1)
        (tmp_path / "run" / "notes.txt").write_text("mine")
    assert sorted(file.name for file in (tmp_path / "run").iterdir()) == ["notes.txt", "run_00000.vtu", "run_00001.vtu"]
    assert len(output.read(tmp_path / "run.pvd")) == 2


def contents(folder):
    return {file: file.read_bytes() for file in Path(folder).rglob("*") if file.is_file()}


def test_failure_in_the_middle_leaves_the_old_files(rested, tmp_path, monkeypatch):
    state = moved(rested, time=0.0)
    output.write(state, tmp_path / "state.vtu")
    output.write([state, moved(rested, time=1.0)], tmp_path / "run.pvd", depths={})
    before = contents(tmp_path)

    def half_written(path, *_, **__):
        Path(path).write_bytes(b"<VTKFile")
        raise OSError(28, "No space left on device")

    def broken():
        yield moved(rested, by=(1, 0, 0), time=0.0)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        output.write(broken(), tmp_path / "run.pvd", depths={})
    assert contents(tmp_path) == before
    monkeypatch.setattr(meshio.vtu, "write", half_written)
    for states, name in [(state, "state.vtu"), ([state], "run.pvd")]:
        with pytest.raises(OSError, match="No space"):
            output.write(states, tmp_path / name)
        assert contents(tmp_path) == before
    assert left_over(tmp_path) == []


def test_a_finished_file_is_readable_by_the_same_people_as_any(tmp_path):
    (tmp_path / "usual").write_text("")
    path = output.save_table(tmp_path / "table.csv", {"a": [1]})
    assert path.stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_wrong_states_are_refused(rested, tmp_path):
    at = [moved(rested, time=t) for t in (0.0, 0.0)]
    for states, message in [
        (at, "state 1: time 0.0 s follows 0.0 s"),
        ([], "the sequence is empty|there is nothing to write"),
        (3, "give a Solution or a sequence"),
        ([1], "state 0: give Solutions, not int"),
    ]:
        with pytest.raises(InputError, match=message):
            output.write(states, tmp_path / "run.pvd", depths={})
    with pytest.raises(InputError, match=r"'\.vtk'; end it in \.vtu"):
        output.write(at[0], tmp_path / "state.vtk")
    with pytest.raises(InputError, match="outside the plate"):
        output.write(at[0], tmp_path / "state.vtu", depths={"far": 1.0})
    assert not (tmp_path / "state.vtu").exists() and not (tmp_path / "run.pvd").exists()
    assert left_over(tmp_path) == []


def test_a_folder_that_cannot_be_is_found_before_any_work(tmp_path):
    (tmp_path / "taken").write_text("a file")

    def never():
        raise AssertionError("work was done")
        yield

    for folder in ("taken", "taken/deeper"):
        with pytest.raises(InputError, match=f"folder '.*{folder}': cannot be written .*; choose another folder"):
            output.check_folder(tmp_path / folder)
        with pytest.raises(InputError, match="cannot be written"):
            output.write(never(), tmp_path / folder / "run.pvd")
    # The folder of the frames has the name of the collection.
    with pytest.raises(InputError, match="taken': cannot be written"):
        output.write(never(), tmp_path / "taken.pvd")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match="folder of that name"):
        output.save_table(tmp_path / "folder.csv", {"a": [1]})


def test_a_folder_without_the_right_to_write_is_refused(tmp_path, monkeypatch):
    # As root every folder can be written; this is what the others see.
    def refuse(self, data):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "write_bytes", refuse)
    with pytest.raises(InputError, match=r"Permission denied.*right to write"):
        output.check_folder(tmp_path)


def test_check_folder_makes_it_and_leaves_nothing(tmp_path):
    folder = output.check_folder(tmp_path / "a" / "b")
    assert folder.is_dir() and not list(folder.iterdir())


def listing(entry):
    return f"<VTKFile type='Collection'><Collection><DataSet {entry}/></Collection></VTKFile>"


def test_what_is_no_such_file_is_refused(rested, tmp_path):
    whole = output.write(moved(rested), tmp_path / "whole.vtu").read_bytes()
    spoilt = {
        "cut.vtu": whole[: len(whole) // 2],
        "empty.vtu": b"",
        "text.vtu": b"hello",
        "zeros.vtu": whole[: len(whole) // 2] + b"0" * 40 + whole[len(whole) // 2 + 40 :],
        "other.vtu": b"<VTKFile type='PolyData'/>",
        "text.pvd": b"hello",
        "other.pvd": b"<VTKFile type='UnstructuredGrid'/>",
        "times.pvd": listing("timestep='x' file='whole.vtu'").encode(),
        "lacks.pvd": listing("timestep='0'").encode(),
    }
    for name, content in spoilt.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=f"{name}': is no .* or is damaged .*write it again"):
            output.read(tmp_path / name)


def test_missing_files_are_named(tmp_path):
    (tmp_path / "a.pvd").write_text(listing("timestep='0' file='gone.vtu'"))
    (tmp_path / "a.txt").write_text("")
    with pytest.raises(InputError, match=r"lists '.*gone.vtu', which is not there"):
        output.read(tmp_path / "a.pvd")
    with pytest.raises(InputError, match="no such file"):
        output.read(tmp_path / "b.vtu")
    with pytest.raises(InputError, match=r"only .vtu and .pvd"):
        output.read(tmp_path / "a.txt")


def test_tables_hold_every_digit(tmp_path):
    time, u = np.linspace(0, 1, 7), np.random.default_rng(0).normal(size=7) * 1e-9
    path = output.save_table(tmp_path / "history.csv", {"time (s)": time, "u3, tip (m)": u})
    assert path.read_text().splitlines()[0] == 'time (s),"u3, tip (m)"'
    np.testing.assert_array_equal(np.loadtxt(path, delimiter=",", skiprows=1), np.column_stack([time, u]))
    with pytest.raises(InputError, match=r"columns have shapes .*same length"):
        output.save_table(path, {"a": [1, 2], "b": [1]})
    with pytest.raises(InputError, match="columns have shapes"):
        output.save_table(path, {})


def test_atomic_replacement_keeps_the_old(tmp_path):
    file = tmp_path / "a.txt"
    file.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic.replacing(file) as part:
        part.write_text("new")
        raise ZeroDivisionError
    assert file.read_text() == "old" and left_over(tmp_path) == []


# Pictures


def pixels(path):
    return np.asarray(Image.open(path).convert("RGB")).astype(float)


def plate_columns(image):
    """Left and right column of coloured pixels, between the axes triad and the colour bar."""
    part = image[100:800, 200:1150]
    coloured = np.flatnonzero((np.ptp(part, axis=2) > 60).any(axis=0))
    return 200 + coloured[0], 200 + coloured[-1]


def test_a_picture_shows_the_field_where_it_is(rested, tmp_path):
    # Turned about the edge x = 0: the displacement grows from left to right.
    state = moved(rested, rotation=about_y(-0.4))
    path = output.picture(state, tmp_path / "turned.png", view=(0.0, -1.0, 0.5), show_mesh=False)
    image = pixels(path)
    assert image.shape == (1000, 1400, 3) and image.std() > 10
    assert (image[0, 0] == 255).all()
    left, right = plate_columns(image)
    colours = []
    for column in (left + 20, right - 20):
        line = image[100:800, column]
        colours.append(line[np.ptp(line, axis=1) > 60].mean(axis=0))
    # From blue to yellow.
    assert colours[0][2] > 1.3 * colours[0][1] > 1.3 * colours[0][0]
    assert colours[1][1] > 2 * colours[1][2]
    assert left_over(tmp_path) == []


def test_titles_say_at_which_depth_and_of_what_kind_a_state_is():
    surface = sk.Rectangle(2.0, 1.0)
    law, load = sk.Isotropic(2e9, 0.2, 1e3), sk.EdgeLoad("right", (-1.0, 0.0, 0.1))
    plate = sk.Problem(surface, 0.02, law, [sk.Clamp("left")], [load])
    system = plate.on(sk.meshes.uniform(surface, 4, 2), "kirchhoff")

    def title(state, **options):
        style = Style(**options)
        return title_of(state, style, place(style.field, plate.section, style.z)[1])

    small, large = sk.solve_linear(system), sk.solve(system).unwrap()
    assert title(small) == "displacement, small deflections"
    assert title(small, field="S11") == "stress S11, top face, z = 0.01 m, small deflections"
    assert title(large, field="S12", z=0.0) == "stress S12, z = 0 m"
    assert title(large, field="mises", scale=3) == "von Mises stress, largest through the thickness, displacements x 3"
    for shape in (sk.modes(system, 1).shape(0), sk.buckling(system, 1).shape(0)):
        assert title(shape, field="S11", z="bottom") == "stress S11, bottom face, z = -0.01 m, mode of arbitrary size"
    pressed = sk.solve(system, load_factor=0.5).unwrap()
    mode = sk.modes(system, 1, state=pressed).shape(0)
    assert title(mode) == "displacement, mode of arbitrary size, load factor 0.5"
    assert not pressed.note and not large.note


def test_samples_take_depths_by_name():
    surface = sk.Rectangle(1.0, 1.0)
    plate = sk.Problem(surface, 0.1, sk.Isotropic(1e6, 0.3, 1.0), [sk.Clamp("left")], [sk.SurfaceLoad((0, 0, 1.0))])
    bent = sk.solve_linear(plate.on(sk.meshes.uniform(surface, 2, 2)))
    assert np.array_equal(output.sample(bent, 2, "top").stress, output.sample(bent, 2, 0.05).stress)
    assert np.array_equal(output.sample(bent, 2, "bottom").points, output.sample(bent, 2, -0.05).points)
    with pytest.raises(sk.InputError, match="z = 'face'"):
        output.sample(bent, 2, "face")


def test_edges_and_undeformed_outline_are_drawn(rested, tmp_path):
    state = moved(rested, by=(0, 0, 1.0))
    choices = {"full": {}, "no mesh": {"show_mesh": False}, "no outline": {"show_undeformed": False}}
    images = {
        name: pixels(output.picture(state, tmp_path / "a.png", title="", view=(0, -0.01, 1), **options))
        for name, options in choices.items()
    }
    inside = (slice(300, 700), slice(300, 900))
    # Two lines across the middle of the plate, and one along it that may be blended with what is beside it.
    dark = {name: (image[inside].max(axis=2) < 90).sum() for name, image in images.items()}
    assert dark["no mesh"] == 0 and dark["full"] > 2 * 400
    grey = {name: (np.abs(image - 154).max(axis=2) < 30).sum() for name, image in images.items()}
    assert grey["full"] > grey["no outline"]


def test_a_film_moves(rested, tmp_path):
    states = [moved(rested, rotation=about_y(a), time=a) for a in (0.0, -0.3, -0.6)]
    told = []
    path = output.animation(iter(states), tmp_path / "film.gif", size=(350, 250), progress=told.append)
    assert [(event.done, event.total) for event in told] == [(1, 3), (2, 3), (3, 3)]
    film = Image.open(path)
    assert film.n_frames == 3 and film.size == (350, 250)
    frames = []
    for k in range(3):
        film.seek(k)
        frames.append(np.asarray(film.convert("RGB")).astype(float))
    assert np.abs(frames[0] - frames[2]).max() > 100
    with pytest.raises(InputError, match="the sequence is empty"):
        output.animation([], tmp_path / "none.gif")


def test_a_view_from_above_has_y_upright():
    right, up, back = sight((0.0, 0.0, 2.0))
    assert np.allclose([right, up, back], np.eye(3))
    right, up, back = sight((0.0, -1.0, 0.0))
    assert np.allclose([right, up, back], [[1, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.mark.parametrize(
    "options, message",
    [
        ({"field": "S31"}, "field = 'S31': no such field; there are S11"),
        ({"view": (0, 0, 0)}, "view = .* from above"),
        ({"limits": (1.0, 0.0)}, "limits = .*smaller value first"),
        ({"z": 1.0, "field": "S11"}, "outside the plate"),
        ({"subdivisions": 0}, "subdivisions = 0"),
        ({"scale": np.nan}, "scale = nan"),
    ],
)
def test_pictures_that_cannot_be_are_refused(rested, tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        output.picture(moved(rested), tmp_path / "a.png", **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="the choice of a window by environment is VTK's on Linux")
def test_a_machine_without_opengl_gets_a_message(monkeypatch, rested, tmp_path):
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkXOpenGLRenderWindow")
    monkeypatch.setenv("DISPLAY", ":98")
    check_rendering.cache_clear()
    with pytest.raises(SkancfError, match=r"no pictures on this machine: .*apt-get install"):
        output.picture(moved(rested), tmp_path / "a.png")
    check_rendering.cache_clear()
    assert not list(tmp_path.iterdir())


# Charts


def test_charts_are_drawn(tmp_path):
    surface = sk.AnnulusSector(1.0, 2.0)
    mesh = sk.meshes.uniform(surface, 4, 6)
    region = sk.meshes.Region((1.0, 0.4), (0.2, 0.3), 2.5)
    t = np.linspace(0, 1, 30)
    curves = {"ours": np.sin(9 * t), "reference": (t[::3], np.sin(9 * t[::3]))}
    made = [
        output.mesh_chart(mesh, tmp_path / "mesh.png", surface, [region], {"A": (2.0, 0.0)}),
        output.mesh_chart(mesh, tmp_path / "parameters.svg"),
        output.field_chart(mesh, np.sin(3 * mesh.p[1]), tmp_path / "field.png", "u3 (m)", surface=surface),
        output.field_chart(mesh, np.full(mesh.nvertices, 1e5), tmp_path / "constant.png", "S11 (Pa)"),
        output.histories_chart(t, curves, tmp_path / "one.png", ylabel="u3 (m)"),
        output.histories_chart(t, {f"point {p}": curves for p in "ABCDE"}, tmp_path / "five.pdf", ylabel="u3 (m)"),
        output.convergence(
            {"uniform": (10 ** (1 + t), 10 ** (-2 * t)), "exact": ([10.0], [0.0])},
            tmp_path / "rates.png",
            slopes=(-1, -2),
        ),
    ]
    for path in made:
        assert path.stat().st_size > 2000
        if path.suffix == ".png":
            assert pixels(path).std() > 5
    assert left_over(tmp_path) == []


def test_cells_in_a_panel_are_shaded_by_how_they_face_the_light(rested):
    from matplotlib.figure import Figure

    axes = Figure().add_subplot(projection="3d")
    flat = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
    upright = flat[:, :, [2, 0, 1]]
    for cell, shade in ((flat, 1.0), (upright, 0.65)):
        drawn = output.draw_cells(axes, cell, np.ones((1, 4)), light=(0, 0, 2))
        np.testing.assert_allclose(drawn.get_facecolor(), [[shade] * 3 + [1.0]], rtol=1e-12)
    samples = output.sample(bent(rested), 2)
    assert output.draw_cells(axes, samples.points[samples.cells], np.ones((len(samples.cells), 3))) in axes.collections
    with pytest.raises(InputError, match="a colour for each"):
        output.draw_cells(axes, flat, np.ones((2, 3)))


def test_a_refined_field_is_bilinear():
    surface = sk.AnnulusSector(1.0, 2.0)
    mesh = sk.meshes.uniform(surface, 3, 2)
    x, y = mesh.p
    triangles, fine = subdivided(mesh, 1 + 2 * x - 3 * y + x * y, None)
    # Nodes and values keep the same order through the refinements.
    np.testing.assert_allclose(fine, 1 + 2 * triangles.x - 3 * triangles.y + triangles.x * triangles.y, atol=1e-13)
    on_surface, _ = subdivided(mesh, x, surface)
    np.testing.assert_allclose(np.hypot(on_surface.x, on_surface.y), triangles.x, atol=1e-14)


def test_charts_refuse_what_they_cannot_draw(tmp_path):
    mesh, path, t = sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 2, 2), tmp_path / "a.png", np.arange(3.0)
    calls = {
        "values have shape .*one for each of the 9 nodes": lambda: output.field_chart(mesh, t, path, "u"),
        "values.*not finite": lambda: output.field_chart(mesh, np.full(9, np.nan), path, "u"),
        "limits = .*smaller": lambda: output.field_chart(mesh, np.ones(9), path, "u", limits=(1, 0)),
        "'a': values of shape": lambda: output.histories_chart(t, {"a": [1, 2]}, path, ylabel="u"),
        "the sequence is empty": lambda: output.histories_chart(t, {}, path, ylabel="u"),
        "not both": lambda: output.histories_chart(t, {"a": t, "b": {"c": t}}, path, ylabel="u"),
        "no positive values": lambda: output.convergence({"a": (t, 0 * t)}, path),
        "end it in .png or .pdf or .svg": lambda: output.mesh_chart(mesh, tmp_path / "a.jpg"),
    }
    for message, call in calls.items():
        with pytest.raises(InputError, match=f"(?s){message}"):
            call()
    assert not list(tmp_path.iterdir())


# Weight


def test_viewers_are_imported_where_they_are_used():
    heavy = {"pyvista", "vtkmodules", "matplotlib", "meshio", "PIL"}
    code = f"import sys, skancf.output; print({heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_all_that_is_exported_is_there():
    assert {"write", "read", "picture", "sample", "check_folder", "save_table"} <= set(output.__all__)
    assert all(hasattr(output, name) for name in output.__all__)
