"""The command: what it prints and writes, its exit codes, and that errors are one message."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import skancf as sk
from skancf import SkancfError, output
from skancf.about import MISSING, Info, installed
from skancf.cli import demos, main
from skancf.output.rendering import check_rendering

PLATE = """
thickness = 0.01
surface = {type = "Rectangle", length_x = 1.0, length_y = 0.5}
material = {type = "Isotropic", young = 210e9, poisson = 0.3, density = 7850.0}
supports = [{type = "Clamp", where = "left"}]
loads = [{type = "EdgeLoad", where = "right", force = [0.0, 0.0, -40.0]}]
mesh = {type = "uniform", nx = 4, ny = 2}
theory = "kirchhoff"
analysis = {type = "solve"}
"""


@pytest.fixture(scope="module")
def draws():
    try:
        check_rendering()
    except SkancfError:
        return False
    return True


@pytest.fixture(autouse=True)
def no_screen(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.fixture(scope="module")
def state():
    plate = sk.Problem(sk.Rectangle(1.0, 0.5), 0.01, sk.Isotropic(210e9, 0.3, 7850.0), [sk.Clamp("left")],
                       [sk.EdgeLoad("right", (0.0, 0.0, -40.0))])  # fmt: skip
    return sk.solve(plate.on(sk.meshes.uniform(plate.surface, 4, 2), "kirchhoff"))


def run(*words, **options):
    return subprocess.run([sys.executable, "-m", "skancf", *words], capture_output=True, text=True, timeout=120, **options)


def test_the_module_is_the_command(tmp_path):
    done = run("solve", str(tmp_path / "none.toml"))
    assert done.returncode == 2 and done.stdout == "" and "Traceback" not in done.stderr
    assert done.stderr.startswith("skancf: file '") and "cannot be read" in done.stderr and done.stderr.count("\n") == 1


def test_the_package_declares_the_command():
    project = (Path(__file__).parent.parent / "pyproject.toml").read_text()
    assert '[project.scripts]\nskancf = "skancf.cli:main"' in project


@pytest.mark.parametrize("name", ["info", "demo", "solve", "view", "compile"])
def test_every_command_has_help_with_an_example(name, capsys):
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    shown = capsys.readouterr().out
    assert ended.value.code == 0 and f"example:\n  skancf {name}" in shown


@pytest.mark.parametrize("words", [[], ["dance"], ["solve"], ["demo", "--nothing"]])
def test_wrong_words_are_refused_with_the_usage(words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2 and "usage: skancf" in capsys.readouterr().err


def test_info_tells_versions_solvers_and_pictures(capsys):
    assert main(["info"]) == 0
    shown = capsys.readouterr().out
    for word in (
        sk.__version__,
        sys.executable,
        np.__version__,
        "linear solver",
        "superlu",
        "threads",
        "kernels",
        "rendering",
    ):
        assert word in shown
    assert shown == f"{sk.info()}\n"
    assert isinstance(sk.info(), Info) and repr(sk.info()) == str(sk.info())


def test_info_names_what_is_missing(monkeypatch):
    assert installed("no-such-package") == MISSING
    monkeypatch.setattr("skancf.about.installed", lambda package: MISSING)
    assert sk.info().parts["Optional packages"]["pandas"] == (
        "not installed (tables as DataFrames: pip install 'skancf[tables]')"
    )


def test_info_counts_kernels_that_are_kept(tmp_path, state):
    code = "import skancf as sk; print(sk.info().parts['Calculation']['kernels'])"
    fresh = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120,
                           env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)})  # fmt: skip
    assert fresh.stdout.startswith("0 of ") and str(tmp_path) in fresh.stdout and "skancf compile" in fresh.stdout
    here = sk.info().parts["Calculation"]["kernels"]
    assert int(here.split()[0]) > 3


@pytest.mark.parametrize("name", demos.DEMOS)
def test_an_example_agrees_with_what_is_published(name):
    found = demos.DEMOS[name].run()
    for k in range(found.titles.index("published"), len(found.titles), 2):
        assert np.allclose(found.rows[:, k - 1], found.rows[:, k], rtol=0.02), found.rows
    assert np.allclose(found.rows[0, -2], found.rows[0, -1], rtol=0.011)


def test_demo_prints_its_table_and_writes_its_files(tmp_path, capsys, draws):
    assert main(["demo", "roof", "--out", str(tmp_path / "roof")]) == 0
    shown = capsys.readouterr().out
    assert "limit load (N)" in shown and "2226.3" in shown and "Sze" in shown
    assert (tmp_path / "roof" / "roof.pvd").is_file()
    assert (tmp_path / "roof" / "roof.png").is_file() is draws


def test_demos_are_listed_and_others_are_named(capsys):
    assert main(["demo", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(demos.DEMOS)
    assert main(["demo", "waltz"]) == 2
    assert capsys.readouterr().err == "skancf: demo = 'waltz': choose one of 'hemisphere' or 'roof'\n"


def test_solve_writes_its_results_and_view_shows_them(tmp_path, capsys, draws):
    file, folder = tmp_path / "plate.toml", tmp_path / "plate_results"
    file.write_text(PLATE)
    assert main(["solve", str(file), "-v"]) == 0
    shown = capsys.readouterr()
    assert "converged" in shown.out and f"-> {folder}/result.h5" in shown.out
    assert "INFO skancf.statics.cascade: converged" in shown.err
    assert main(["view", str(folder / "result.h5"), "--out", str(tmp_path / "page.html"), "--field", "mises"]) == 0
    assert "<html" in (tmp_path / "page.html").read_text()[:300]
    if draws:
        assert main(["view", str(folder / "result.h5")]) == 0
        assert (folder / "result_view.png").is_file() and "no screen" in capsys.readouterr().out


def test_an_analysis_that_does_not_arrive_has_another_code(tmp_path, capsys):
    file = tmp_path / "plate.toml"
    file.write_text(PLATE.replace('{type = "solve"}', '{type = "trace", until = 1e4, steps = 1}'))
    assert main(["solve", str(file)]) == 1
    assert "these were all the steps" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", [".vtu", ".pvd"])
def test_view_draws_files_for_paraview(state, tmp_path, draws, suffix, capsys):
    if not draws:
        return
    file, picture = tmp_path / f"state{suffix}", tmp_path / "seen.png"
    output.write(state.solution if suffix == ".vtu" else state.path, file, progress=False)
    assert main(["view", str(file), "--out", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert main(["view", str(file), "--field", "beauty", "--out", str(picture)]) == 2
    assert "field = 'beauty': choose one of 'displacement'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "says"), [("none.vtu", "there is no such file"), ("notes.txt", "give one of .h5, .vtu or .pvd")]
)
def test_view_names_files_that_cannot_be_shown(tmp_path, capsys, name, says):
    (tmp_path / "notes.txt").write_text("nothing")
    assert main(["view", str(tmp_path / name)]) == 2
    assert says in capsys.readouterr().err


def test_an_interruption_is_no_traceback(monkeypatch, capsys):
    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr("skancf.about.info", interrupted)
    assert main(["info"]) == 130
    assert capsys.readouterr().err == "skancf: interrupted\n"


def test_a_warning_is_a_line(monkeypatch, capsys):
    monkeypatch.setattr("skancf.about.info", lambda: warnings.warn("thick", sk.OutOfDepth, stacklevel=1))
    main(["info"])
    assert capsys.readouterr().err == "skancf: warning: thick\n"


def test_compile_runs_what_needs_the_kernels(monkeypatch, capsys, caplog):
    from skancf.cli import compiles
    from skancf.compiling import announce

    listener = announce()
    ran = []

    def run(name, found):
        ran.append(name)
        listener.total += found

    monkeypatch.setattr(compiles, "RUNS", {"one": lambda: run("one", 2), "two": lambda: run("two", 1)})
    assert main(["compile"]) == 0
    shown = capsys.readouterr().out
    assert ran == ["one", "two"] and shown.startswith("3 kernels compiled in ") and "kept in /" in shown
    monkeypatch.setattr(compiles, "RUNS", {"theory kirchhoff": compiles.RUNS["one"]} | {"two": lambda: None})
    monkeypatch.setitem(compiles.RUNS, "theory kirchhoff", lambda: compiles._plain("kirchhoff"))
    main(["compile"])
    # Compiled by it or before it, all that the theory and the solvers need is on disk.
    from skancf import about

    kept = {f.py_func.__module__ for f in about._functions() if about._is_kept(about._cache_of(f))}
    assert {"skancf.theories.kirchhoff.tangent_kernel", "skancf.loads.pressure_kernel", "skancf.linear.kernels"} <= kept


def test_compile_knows_every_rubber():
    from skancf.cli import compiles

    laws = {path.stem for path in (Path(sk.__file__).parent / "materials" / "hyperelastic").glob("*.py")}
    named = {"neo_hooke": "NeoHooke", "mooney_rivlin": "MooneyRivlin", "yeoh": "Yeoh", "gent": "Gent", "ogden": "Ogden"}
    assert set(named) <= laws and set(named.values()) == set(compiles.RUBBERS)
