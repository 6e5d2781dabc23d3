"""Problems from TOML files: read, refused where they are wrong, and run."""

import csv
from pathlib import Path

import numpy as np
import pytest
from kept import problem

import skancf as sk
from skancf.output.rendering import check_rendering
from skancf.storage import FileRun
from skancf.storage.describe import describe

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

EXAMPLE = Path(__file__).resolve().parent.parent / "demos" / "problem.toml"
PLATE = """
thickness = 0.01
surface = {type = "Rectangle", length_x = 1.0, length_y = 0.5}
material = {type = "Isotropic", young = 2.1e11, poisson = 0.3, density = 7850}
"""
HELD = (
    PLATE
    + """
supports = [{type = "Clamp", where = "left"}]
theory = "kirchhoff"
"""
)
LOADED = (
    HELD
    + """
loads = [{type = "EdgeLoad", where = "right", force = [0, 0, -100]}]
mesh = {type = "uniform", nx = 4, ny = 2}
"""
)
PUSHED = LOADED.replace("[0, 0, -100]", "[-100, 0, 0]")


def written(folder, text):
    file = folder / "problem.toml"
    file.write_text(text)
    return file


def test_the_example_is_the_problem_in_python(tmp_path):
    steel = sk.Isotropic(210e9, 0.3, 7850.0)
    surface = sk.Rectangle(1.0, 0.5)
    asked = sk.Problem(
        surface, 0.004, steel, [sk.Clamp("left")],
        [sk.Gravity(), sk.SurfaceLoad((0.0, 0.0, -400.0), history=sk.Pulse(0.05))],
        zones=[sk.Zone("doubler", ((0.0, 0.25), (0.0, 0.5)), 0.008)],
    )  # fmt: skip
    task = sk.read_problem(EXAMPLE)
    assert task.problem == asked and task.analysis == "solve" and task.title.startswith("A clamped steel plate")
    assert task.system == asked.on(sk.meshes.uniform(surface, 16, 8), "kirchhoff")
    assert task == sk.read_problem(str(EXAMPLE))


def test_the_example_runs(tmp_path):
    text = EXAMPLE.read_text().replace("nx = 16", "nx = 4").replace("ny = 8", "ny = 2")
    run = sk.run_file(written(tmp_path, text))
    assert isinstance(run, FileRun) and run.ok and run.folder == tmp_path / "problem_results" and run.message == ""
    expected = sk.solve(run.task.system)
    assert np.array_equal(run.result.solution.q, expected.solution.q)
    assert sk.load(run.folder / "result.h5") == run.result
    with (run.folder / "table.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert float(rows[-1]["u3 at (1, 0.5)"]) == expected.solution.displacement((1.0, 0.5))[2] < 0
    assert float(rows[-1]["strain energy"]) == expected.solution.strain_energy
    names = {file.name for file in run.files}
    try:
        check_rendering()
    except sk.SkancfError:
        assert any("no pictures" in note for note in run.notes)
        names |= {"picture.png"}
    assert names == {"result.h5", "table.csv", "picture.png", "state.vtu"}
    assert sk.output.read(run.folder / "state.vtu").points.shape[1] == 3


ANALYSES = {
    "solve": ("load_factor = 0.5\ncontrol = {type = 'HalveAndGrow', first = 0.5}", LOADED, "load factor"),
    "solve_linear": ("", LOADED, "load factor"),
    "trace": ("until = 1.0\ncontrol = {type = 'ArcLength'}", LOADED, "negative pivots"),
    "modes": ("n = 3", LOADED, "frequency"),
    "buckling": ("n = 1", PUSHED, "load factor"),
    "simulate": (
        "t_end = 0.004\ndt = 1e-3\noutputs = 3\nrule = {type = 'GeneralizedAlpha', rho_inf = 0.5}\nbalance = 'auto'\n"
        "velocity = {type = 'RigidVelocity', velocity = [0, 0, 0]}",
        LOADED, "kinetic energy",
    ),
    "adapt": ("rtol = 0.1\nquantity = {type = 'StrainEnergy'}\nmarking = {type = 'Doerfler', share = 0.6}",
              LOADED.replace("mesh =", "#"), "n_elements"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("analysis", ANALYSES)
def test_every_analysis(tmp_path, monkeypatch, analysis):
    options, text, column = ANALYSES[analysis]
    monkeypatch.setattr(sk.output, "picture", lambda state, path, **options: path)
    run = sk.run_file(written(tmp_path, f"{text}\n[analysis]\ntype = '{analysis}'\n{options}"), tmp_path / "there")
    assert run.result == sk.load(run.folder / "result.h5") and run.ok
    table = (run.folder / "table.csv").read_text().splitlines()
    assert column in table[0] and len(table) > 1
    assert (run.folder / "states.pvd").exists() == (analysis not in ("solve", "solve_linear", "adapt"))


@pytest.mark.parametrize(
    ("mesh", "elements"),
    [
        ("{type = 'uniform', nx = 4, ny = 2, quadtree = true, refined = 1}", 32),
        ("{type = 'tensor', x = [0, 0.3, 1], y = [0, 0.5]}", 2),
        ("{type = 'uniform', nx = 4, ny = 4, openings = [[[0.25, 0.5], [0.125, 0.25]]]}", 15),
        ("{type = 'with_lines', nx = 2, ny = 2, x = [0.3]}", None),
        ("{type = 'graded', nodes = 100, regions = [{type = 'Region', centre = [1, 0.25], half_size = "
         "[0.1, 0.1]}]}", None),
    ],
)  # fmt: skip
def test_meshes(tmp_path, mesh, elements):
    text = HELD + f"mesh = {mesh}\nanalysis = {{type = 'solve'}}"
    found = sk.read_problem(written(tmp_path, text)).system.mesh
    assert elements is None or found.nelements == elements
    assert 0.3 in found.p[0] or "0.3" not in mesh


def test_a_mesh_in_a_file_next_to_it(tmp_path):
    mesh = sk.meshes.quadtree(sk.meshes.uniform(sk.Rectangle(1.0, 0.5), 2, 1)).refined([0])
    sk.save(mesh, tmp_path / "mesh.h5")
    text = HELD + "mesh = {type = 'file', path = 'mesh.h5'}\nanalysis = {type = 'solve'}"
    assert sk.read_problem(written(tmp_path, text)).system.mesh == mesh


def as_toml(table):
    """A description in TOML."""
    if isinstance(table, dict):
        return "{" + ", ".join(f"{key} = {as_toml(item)}" for key, item in table.items()) + "}"
    if isinstance(table, list):
        return "[" + ", ".join(map(as_toml, table)) + "]"
    return str(table).lower() if isinstance(table, bool) else repr(table)


def test_a_description_is_a_file(tmp_path):
    asked = problem()
    lines = [f"{key} = {as_toml(item)}" for key, item in describe(asked).items() if key != "type"]
    text = "\n".join([*lines, "mesh = {type = 'uniform', nx = 4, ny = 2}", "analysis = {type = 'modes'}"])
    assert sk.read_problem(written(tmp_path, text)).problem == asked and tomllib.loads(text)


WRONG = {
    "thicknes = 0.01": r"the file: unknown table or key 'thicknes'; do you mean 'thickness'\?",
    "loads = [{type = 'PointForc', at = [1, 0], force = [0, 0, 1]}]": r"loads\[0\].*do you mean 'PointForce'",
    "loads = [{type = 'Gravity'}, {type = 'PointForce', att = [1, 0], force = [0, 0, 1]}]":
        r"loads\[1\] \(PointForce\): unknown key 'att'; do you mean 'at'\? There is at, force, history",
    "loads = [{type = 'PointForce', at = [1, 0]}]": r"loads\[0\] \(PointForce\): force is missing",
    "loads = [{type = 'PointForce', at = [1, 0], force = 'up'}]": r"loads\[0\] \(PointForce\): force = 'up'",
    "loads = [{at = [1, 0]}]": r"loads\[0\]: this table has no type; give its class, such as DiskForce",
    "loads = {type = 'Gravity'}": "loads: give a list",
    "loads = [{type = 'Gravity', history = 'gust'}]": "history",
    "loads = [3]": "loads: 3 is not a load",
    "offset = 2024-01-01": "offset.*give a number, a text, a list or a table",
    "offset = 'lambda x, y: 0'": "offset",
    "zones = [{type = 'Isotropic', young = 1, poisson = 0, density = 1}]": r"zones\[0\].*(is no Zone|is not a Zone|Zone)",
    "mesh = {nx = 4, ny = 2}": r"\[mesh\]: type is missing; choose one of file, graded, tensor, uniform, with_lines",
    "mesh = {type = 'uniforn', nx = 4, ny = 2}": "do you mean 'uniform'",
    "mesh = {type = 'uniform', nx = 4}": r"\[mesh\] \(uniform\): ny is missing; it takes nx, ny, openings",
    "mesh = {type = 'uniform', nx = 4, ny = 2.5}": r"\[mesh\] \(uniform\): ny = 2.5",
    "mesh = {type = 'uniform', nx = 4, ny = 2, refined = [9]}": r"\[mesh\] \(uniform\): refined = \(9,\)",
    "mesh = {type = 'file', path = 'no.h5'}": "no such file",
    "mesh = {type = 'file', pat = 'no.h5'}": "do you mean 'path'",
    "mesh = 'uniform'": r"give a table \[mesh\]",
    "analysis = {type = 'solv'}": r"\[analysis\]: unknown type 'solv'; do you mean 'solve'",
    "analysis = {type = 'solve', load_facto = 2}": r"\[analysis\] \(solve\).*do you mean 'load_factor'",
    "analysis = {type = 'solve', start = 2}": "start is a function, a state or a folder, given in Python only",
    "analysis = {type = 'adapt'}": r"\[analysis\] \(adapt\): quantity is missing",
    "output = {point = [[0, 0]]}": r"\[output\]: unknown key 'point'; do you mean 'points'",
    "title = 3": "title = 3: give a text",
    "theory = 'fool'": "unknown",
    "theory = {type = 'Full', n_thicknes = 2}": "do you mean 'n_thickness'",
    "materials = 3": r"give a table \[materials\]",
    "analysis = ": "is not TOML",
}  # fmt: skip


@pytest.mark.parametrize("line", WRONG)
def test_what_is_wrong_is_told_with_its_place(tmp_path, line):
    key = line.split(" ")[0]
    lines = [row for row in (LOADED + "analysis = {type = 'solve'}").splitlines() if row.split(" ")[0] != key]
    file = written(tmp_path, "\n".join([*lines, line]))
    with pytest.raises(sk.InputError, match=WRONG[line]) as told:
        _ = sk.read_problem(file).system
    assert str(file) in str(told.value) or key == "theory"
    assert "\n" not in str(told.value) and len(str(told.value)) < 600


def test_missing_tables_and_files(tmp_path):
    for left_out in ("surface", "mesh", "analysis"):
        lines = [row for row in (LOADED + "analysis = {type = 'solve'}").splitlines() if not row.startswith(left_out)]
        with pytest.raises(sk.InputError, match=rf"{left_out}\]? is missing"):
            sk.read_problem(written(tmp_path, "\n".join(lines)))
    with pytest.raises(sk.InputError, match="cannot be read"):
        sk.read_problem(tmp_path / "no.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(sk.InputError, match="is not TOML"):
        sk.run_file(tmp_path / "bytes.toml")
    with pytest.raises(sk.InputError, match=r"add a table \[mesh\]"):
        text = LOADED.replace("mesh =", "#") + "analysis = {type = 'adapt', quantity = {type = 'StrainEnergy'}}"
        _ = sk.read_problem(written(tmp_path, text)).system


def test_an_analysis_that_fails_is_written_too(tmp_path, monkeypatch):
    monkeypatch.setattr(sk.output, "picture", lambda state, path, **options: path)
    text = LOADED.replace("-100]", "-1e5]") + "analysis = {type = 'trace', until = 1.0, steps = 1}"
    run = sk.run_file(written(tmp_path, text))
    assert not run.ok and run.message and not sk.load(run.folder / "result.h5").ok


def test_what_cannot_be_drawn_is_noted(tmp_path):
    run = sk.run_file(written(tmp_path, LOADED + "analysis = {type = 'solve'}\noutput = {field = 'S99'}"))
    assert run.ok and len(run.files) == 3 and any("S99" in note for note in run.notes)
