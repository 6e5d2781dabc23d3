"""Problems and results come back from HDF5 files as they were, and damaged files are refused."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import warnings
from dataclasses import replace

import h5py
import numpy as np
import pytest
from kept import EXAMPLES, FUNCTIONS, STEEL, every, example, problem, results, system
from test_equality import NAMES

import skancf as sk
from skancf.equality import same
from skancf.storage import hdf5, registry
from skancf.storage.describe import build, describe
from skancf.storage.files import VERSION
from skancf.surfaces import Surface

MIDDLE = np.array([[0.5, 0.2], [0.5, 0.1]])
INTERPOLATED = 1e-9
"""Of fields between samples of quintic splines on 129 lines: of the smooth functions here, measured 1e-11."""


@pytest.fixture(scope="module")
def found():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return results()


@pytest.fixture(scope="module")
def files(found, tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return {name: sk.save(thing, folder / f"{name}.h5") for name, thing in found.items()}


# --- descriptions ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", every())
def test_a_description_is_built_into_an_equal_object(name):
    one = example(name)
    table = json.loads(json.dumps(describe(one), allow_nan=False))
    assert build(table, name) == one and table["type"] == name
    wanted = [f.name for f in dataclasses.fields(one) if f.init and getattr(one, f.name) is not None]
    assert table.keys() == {"type", *wanted}


def test_every_public_dataclass_is_described():
    rooms = (
        sk.surfaces,
        sk.materials,
        sk.supports,
        sk.loads,
        sk.conditions,
        sk.theories,
        sk.dynamics,
        sk.adaptive,
        sk.statics,
    )
    public = {name for room in rooms for name in room.__all__ if dataclasses.is_dataclass(getattr(room, name))}
    others = {"Estimate", "PointResponse", "RemapChange", "Remapped", "Section", "Singularity", "Spectrum"}
    missing = public - registry.KINDS.keys() - registry.ANSWERS.keys() - set(registry.KEPT_OUT) - others
    assert not missing, "give them a line in skancf/storage/registry.py"
    assert set(EXAMPLES) | FUNCTIONS <= registry.KINDS.keys() and not EXAMPLES.keys() & FUNCTIONS


def test_a_problem_is_kept_whole(tmp_path):
    asked = problem()
    again = sk.load(sk.save(asked, tmp_path / "problem.h5"))
    assert again == asked and build(describe(asked), "problem") == asked
    assert isinstance(again.loads[0].history, sk.Table) and again.zones[0].thickness == 0.02


# --- results ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_results_come_back_equal(found, files, name):
    one, two = found[name], sk.load(files[name])
    assert two == one and type(two) is type(one)
    for word in ("status", "message", "checks", "note", "ok"):
        assert same(getattr(one, word, None), getattr(two, word, None))


def states(result):
    return {"Modes": lambda r: r.shape(1), "BucklingResult": lambda r: r.shape(0), "Motion": lambda r: r.at(0.011),
            "Solution": lambda r: r}.get(type(result).__name__, lambda r: r.solution)(result)  # fmt: skip


@pytest.mark.parametrize("name", [name for name in NAMES if name != "Motion with conditions"])
def test_loaded_states_answer_to_the_last_bit(found, files, name):
    one, two = states(found[name]), states(sk.load(files[name]))
    at = [(0.3, 0.2), (1.0, 0.5)]
    for ask in (
        lambda s: s.q, lambda s: s.displacement(at), lambda s: s.section_forces(), lambda s: s.stresses(MIDDLE, "top"),
        lambda s: s.nodal_section_forces(), lambda s: s.strain_energy, lambda s: s.kinetic_energy,
    ):  # fmt: skip
        assert np.array_equal(ask(one), ask(two))
    if one.velocity is None and name not in ("Modes", "BucklingResult"):
        assert np.array_equal(one.reactions(), two.reactions()) and np.abs(one.reactions()).max() > 0
    if one.multipliers is not None:
        assert one.conditions == two.conditions and one.conditions


def test_what_was_one_object_is_one_again(found, files):
    for result in (found["StaticResult"], sk.load(files["StaticResult"])):
        assert result.path[-1] is result.solution and result.path[0].system is result.solution.system


def test_a_loaded_motion_goes_on(found, files):
    one, two = (sk.simulate(motion.segments[-1].system, 0.01, start=motion.at(0.02), dt=2e-3, progress=False)
                for motion in (found["Motion"], sk.load(files["Motion"])))  # fmt: skip
    assert np.array_equal(one.q, two.q)
    assert np.array_equal(found["Motion"].records["u"][1], sk.load(files["Motion"]).records["u"][1])


@pytest.mark.parametrize("tree", [False, True])
def test_meshes(tmp_path, tree):
    mesh = system(tree=tree).mesh
    mesh = mesh.with_boundaries({"inside": lambda x: abs(x[0] - 0.5) < 1e-9}, boundaries_only=False) if not tree else mesh
    again = sk.load(sk.save(mesh, tmp_path / "mesh.h5"))
    assert same(mesh, again) and again.boundaries.keys() == mesh.boundaries.keys()
    assert tree or again.boundaries["inside"].size


def test_systems_of_both_theories(tmp_path):
    for theory in ("full", "kirchhoff"):
        one = system(theory, tree=True)
        two = sk.load(sk.save(one, tmp_path / "system.h5"))
        assert one == two and np.array_equal(one.stiffness().values, two.stiffness().values)


def test_the_choice_of_a_theory_is_kept(tmp_path):
    one = problem().on(system().mesh, "auto")
    two = sk.load(sk.save(one, tmp_path / "system.h5"))
    assert two.choice == one.choice and two.choice.reason


def test_others_read_the_arrays(found, files):
    with h5py.File(files["StaticResult"]) as file:
        content = file["content"]
        assert file.attrs["format"] == b"skancf" and file.attrs["version"] == VERSION
        assert content.attrs["type"] == b"StaticResult" and content.attrs["status"] == b"CONVERGED"
        assert np.array_equal(content["solution/q"], found["StaticResult"].solution.q)
        assert content["solution/system"] == content["path/0/system"], "one system, linked"
        assert np.array_equal(content["solution/system/mesh/nodes"], found["StaticResult"].solution.system.mesh.p)
        table = json.loads(content["solution/system/problem"][0])
        assert table["surface"] == {"type": "Rectangle", "length_x": 1.0, "length_y": 0.5, "origin": [0.0, 0.0]}
        assert content["solution/q"].fletcher32


def test_columns_of_several_lengths_and_long_texts(tmp_path, found):
    ragged = np.empty(2, dtype=object)
    ragged[:] = [np.zeros(2), np.ones(3)]
    times = np.array([0.0, 1.0])
    motion = replace(found["Motion"], records={"a/b": (times, ragged), "no": (times, times)}, message="long " * 1000)
    assert sk.load(sk.save(motion, tmp_path / "motion.h5")) == motion


# --- functions -------------------------------------------------------------------------------------------------------------


def curved(**more):
    def roof(x, y):
        return x, y, 0.1 * np.sin(4 * x) * (1 + y**2)

    surface = sk.MappedSurface(roof, ((0.0, 1.0), (0.0, 1.0)))
    asked = {"supports": [sk.Clamp("left")], "loads": [sk.SurfaceLoad((0.0, 0.0, -1e3))]} | more
    return sk.Problem(surface, lambda x, y: 0.01 * (1 + 0.2 * x * y), STEEL, **asked)


def test_functions_of_place_are_kept_as_tables(tmp_path):
    asked = curved(loads=[sk.SurfaceLoad(lambda x, y: (0 * x, 0 * x, -1e3 * np.cos(x)))])
    solution = sk.solve_linear(asked.on(sk.meshes.uniform(asked.surface, 4, 4), "kirchhoff"))
    with pytest.warns(sk.statics.OutOfDepth, match=r"MappedSurface\.function, with an error of .*e-"):
        file = sk.save(solution, tmp_path / "roof.h5")
    again = sk.load(file)
    assert np.abs(again.displacements - solution.displacements).max() == 0.0 and np.array_equal(
        again.change, solution.change
    )
    table = again.system.problem.thickness
    assert 0 <= table.error < INTERPOLATED and abs(table(0.3, 0.7) - 0.01 * (1 + 0.2 * 0.21)) < INTERPOLATED * 0.01
    assert np.abs(again.section_forces() - solution.section_forces()).max() < 1e-6 * np.abs(solution.section_forces()).max()
    assert again.system.problem.surface.function.error < 1e-11


def test_a_surface_that_no_table_has_to_rounding_is_refused(tmp_path):
    surface = sk.MappedSurface(lambda x, y: (x, y, 0.01 * np.sin(150 * x)), ((0.0, 1.0), (0.0, 1.0)), step=1 / 4096)
    with pytest.raises(sk.InputError, match=r"MappedSurface\.function = .*what='arrays'"):
        sk.save(surface, tmp_path / "x.h5")


def test_functions_of_time_are_kept_over_a_motion(tmp_path):
    asked = replace(problem(), loads=[sk.PointForce((1.0, 0.0), (0.0, 0.0, -1.0), history=lambda t: np.sin(200 * t))])
    motion = sk.simulate(asked.on(system().mesh, "kirchhoff"), 0.02, dt=2e-3, progress=False)
    with pytest.warns(sk.statics.OutOfDepth, match=r"PointForce\.history, with an error of"):
        file = sk.save(motion, tmp_path / "motion.h5")
    again = sk.load(file)
    assert np.array_equal(again.q, motion.q) and isinstance(again.system.problem.loads[0].history, sk.Table)
    assert abs(again.system.problem.loads[0].history(0.0123) - np.sin(200 * 0.0123)) < 1e-5
    with pytest.raises(sk.InputError, match=r"PointForce\.history = .*a Table for a function of time.*what='arrays'"):
        sk.save(asked, tmp_path / "problem.h5")


class OwnSurface(sk.Plane):
    """Not of this library."""


def jumps(x, y):
    return np.where(x > 0.5, 0.02, 0.01)


@pytest.mark.parametrize(
    ("asked", "name"),
    [
        (lambda: replace(problem(), material=lambda x, y: STEEL), "Problem.material"),
        (lambda: replace(problem(), surface=OwnSurface()), "Problem.surface"),
        (lambda: replace(problem(), supports=[sk.Clamp(lambda x, y: x < 1e-9)]), "Clamp.where"),
        (lambda: replace(problem(), zones=[sk.Zone("a", lambda x, y: x < 0.5, 0.02)]), "Zone.where"),
        (lambda: replace(problem(), zones=[], thickness=jumps), "Problem.thickness"),
        (lambda: replace(problem(), terms=[sk.FormTerm(lambda w: 0 * w.X[0])]), "FormTerm.energy"),
        (lambda: replace(problem(), loads=[sk.MovingForce(lambda t: (t, 0.0), (0, 0, 1.0))]), "MovingForce.path"),
    ],
)  # fmt: skip
def test_other_functions_are_refused_by_name(tmp_path, asked, name):
    with pytest.raises(sk.InputError, match=rf"{name} = .*what='arrays'"):
        sk.save(asked(), tmp_path / "x.h5")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", NAMES)
def test_arrays_need_no_problem(found, tmp_path, name):
    one = found[name]
    two = sk.load(sk.save(one, tmp_path / "x.h5", what="arrays"))
    assert isinstance(two, sk.storage.StoredFields) and two.kind == type(one).__name__ and two.ok == getattr(one, "ok", True)
    state = list(one.states)[-1] if "Motion" in name else states(one) if name not in ("Modes",) else one.shape(1)
    corners = np.array([[0.0, 1, 1, 0], [0, 0, 1, 1]])
    assert np.array_equal(two.state.displacements, state.displacements) or name == "BucklingResult"
    assert two.state.stresses_top.shape == state.stresses(corners, "top").shape
    if name in ("Solution", "StaticResult", "PathResult"):
        assert np.array_equal(two.state.section_forces, state.section_forces())
        assert np.array_equal(two.state.stresses_top, state.stresses(corners, "top"))
        assert two.state.strain_energy == state.strain_energy
        assert np.array_equal(two.state.positions, state.position(state.system.mesh.p.T).T)
    with pytest.raises(sk.InputError, match="shear_share: this result was kept as arrays"):
        _ = two.state.shear_share


def test_arrays_of_a_problem_of_functions(tmp_path):
    asked = curved(supports=[sk.Clamp(lambda x, y: x < 1e-9)])
    solution = sk.solve_linear(asked.on(sk.meshes.uniform(asked.surface, 2, 2), "kirchhoff"))
    again = sk.load(sk.save(solution, tmp_path / "x.h5", what="arrays"))
    assert np.array_equal(again.state.q, solution.q) and not hasattr(again, "system")


# --- damage ----------------------------------------------------------------------------------------------------------------


def read(data, file):
    """What damaged bytes give: the error, or what they hold."""
    file.write_bytes(data)
    try:
        return sk.load(file)
    except sk.InputError as refused:
        assert str(file) in str(refused)
        return None


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A file with a solution, and what it holds."""
    solution = sk.solve_linear(system())
    file = sk.save(solution, tmp_path_factory.mktemp("small") / "x.h5")
    return solution, file.read_bytes()


def test_a_file_that_was_cut_off_is_refused(small, tmp_path):
    _, data = small
    ends = np.linspace(0, len(data) - 1, 60).astype(int)
    assert all(read(data[:end], tmp_path / "x.h5") is None for end in ends)


def test_a_file_with_another_byte_is_refused_or_the_same(small, tmp_path, rng):
    solution, data = small
    refused = 0
    for place, change in zip(rng.integers(len(data), size=120), rng.integers(1, 256, size=120), strict=True):
        damaged = bytearray(data)
        damaged[place] ^= int(change)
        again = read(bytes(damaged), tmp_path / "x.h5")
        refused += again is None
        assert again is None or again == solution, f"byte {place} was changed by {change}"
    assert refused > 40, "bytes that matter were changed"


def test_each_byte_of_the_coordinates_is_checked(small, tmp_path):
    solution, data = small
    start = data.index(solution.q[:64].tobytes())
    for place in range(start, start + solution.q.nbytes, 97):
        damaged = bytearray(data)
        damaged[place] ^= 1
        assert read(bytes(damaged), tmp_path / "x.h5") is None


def changed(small, tmp_path, change):
    file = tmp_path / "x.h5"
    file.write_bytes(small[1])
    with h5py.File(file, "r+") as root:
        change(root)
    return file


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda root: root.attrs.__setitem__("version", VERSION + 1), f"version {VERSION + 1} .*update"),
        (lambda root: root.attrs.__setitem__("format", np.bytes_(b"other")), "not one of sk.save"),
        (lambda root: root.__delitem__("content/system/mesh"), "does not fit"),
        (lambda root: root["content"].attrs.__setitem__("type", np.bytes_(b"os.system")), "damaged"),
        (lambda root: hdf5.put_array(root["content"], "velocity", np.zeros(3)), "give 180 numbers"),
        (lambda root: root["content"].attrs.__setitem__("load_factor", np.bytes_(b"1")), "load_factor"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(small, tmp_path, change, says):
    with pytest.raises(sk.InputError, match=says):
        sk.load(changed(small, tmp_path, change))


@pytest.mark.parametrize("data", [b"", b"text", b"\x89HDF\r\n\x1a\n" + bytes(100)])
def test_other_files_are_refused(tmp_path, data):
    assert read(data, tmp_path / "x.h5") is None
    with pytest.raises(sk.InputError, match="no such file"):
        sk.load(tmp_path / "y.h5")


def test_an_hdf5_file_of_others(tmp_path):
    with h5py.File(tmp_path / "x.h5", "w") as root:
        root["a"] = 1
    with pytest.raises(sk.InputError, match=r"not one of sk\.save"):
        sk.load(tmp_path / "x.h5")


def test_nothing_is_run_that_a_file_names(small, tmp_path):
    """A type is looked up in a list, and nowhere else."""
    for name in ("subprocess.run", "System.__init__", "__import__", "InputError"):

        def change(root, name=name):
            del root["content/system/problem"]
            hdf5.put_text(root["content/system"], "problem", json.dumps({"type": name, "args": "x"}), "Problem")

        with pytest.raises(sk.InputError, match="unknown type"):
            sk.load(changed(small, tmp_path, change))


# --- writing ---------------------------------------------------------------------------------------------------------------


def test_an_older_file_stays_until_the_new_one_is_whole(tmp_path, monkeypatch, small):
    file = sk.save(small[0], tmp_path / "x.h5")
    before = file.read_bytes()
    monkeypatch.setattr(hdf5, "put_array", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sk.save(small[0], file)
    assert file.read_bytes() == before and list(tmp_path.iterdir()) == [file]


KILLED = """
import sys, time, numpy as np, skancf as sk
from skancf.storage import hdf5
sys.path.insert(0, {tests!r})
from kept import system
slow = hdf5.put_array
def put_array(*arguments):
    print("writing", flush=True)
    time.sleep(0.3)
    return slow(*arguments)
hdf5.put_array = put_array
sk.save(sk.solve_linear(system("full")), {file!r})
"""


def test_a_process_that_is_killed_leaves_the_older_file(tmp_path, small):
    file = sk.save(small[0], tmp_path / "x.h5")
    code = KILLED.format(tests=os.path.dirname(__file__), file=str(file))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline() == b"writing\n"
    process.send_signal(signal.SIGKILL)
    process.wait(timeout=30)
    process.stdout.close()
    assert sk.load(file) == small[0] and len(list(tmp_path.iterdir())) == 2, "it was in the middle"


@pytest.mark.parametrize(
    ("thing", "path", "what", "says"),
    [
        (3.0, "x.h5", "all", "give a Problem"), (STEEL, "x.txt", "all", r"end it in \.h5 or \.hdf5"),
        (STEEL, "x.h5", "some", "choose one of 'all'"), (STEEL, "x.h5", "arrays", "has no fields"),
        (Surface, "x.h5", "all", "give a Problem"), (STEEL, "no\0", "all", "no path"),
    ],
)  # fmt: skip
def test_wrong_arguments(tmp_path, thing, path, what, says):
    with pytest.raises(sk.InputError, match=says):
        sk.save(thing, tmp_path / path, what=what)
