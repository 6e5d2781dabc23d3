"""The pages keep their word: the tutorials run and print what they show."""

import ast
import importlib.util
import logging
import re
import shutil
from pathlib import Path
from types import ModuleType

import pytest

import skancf
from skancf import SkancfError, output
from skancf.output.rendering import check_rendering

DOCS = Path(__file__).resolve().parent.parent / "docs"


def load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


tutorial = load(DOCS / "measure" / "tutorial.py")


@pytest.fixture(autouse=True)
def log_as_before():
    """A page may set up logging, and what it sets up ends with it."""
    root, newton = logging.getLogger(), logging.getLogger("skancf.statics.newton")
    handlers, levels = list(root.handlers), (root.level, newton.level)
    yield
    root.handlers[:] = handlers
    root.setLevel(levels[0])
    newton.setLevel(levels[1])
    newton.propagate = True


def check_page(page: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Its code prints what it shows and makes its pictures; how many outputs it has."""
    monkeypatch.chdir(folder)
    if "deck.run(" in page.read_text(encoding="utf-8") and shutil.which("ccx") is None:
        pytest.skip("CalculiX (ccx) is not installed: apt install calculix-ccx")
    tutorial.lay_out(page, folder)
    pictures = tutorial.pictures(page)
    try:
        check_rendering()
    except SkancfError:
        for name in ("picture", "animation"):
            monkeypatch.setattr(output, name, lambda *_, **__: None)
        pictures = []
        if "pyvista.Plotter" in page.read_text(encoding="utf-8"):
            pytest.skip("needs a machine that can draw")
    examples = tutorial.examples(page)
    printed = tutorial.run(examples)
    for example, given in zip(examples, printed, strict=True):
        assert tutorial.same(example.shown, given), f"line {example.line}: shown\n{example.shown}printed\n{given}"
    for made in [*pictures, *tutorial.live(page)]:
        assert (folder / Path(made).name).stat().st_size > 0
    return sum(bool(example.shown) for example in examples)


@pytest.mark.parametrize("name", tutorial.PAGES)
def test_a_tutorial_prints_what_it_shows(name, tmp_path, monkeypatch):
    assert check_page(tutorial.PAGES[name], tmp_path, monkeypatch) >= 4, "outputs have not been found on the page"


def test_the_first_page_runs_in_ten_lines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    try:
        check_rendering()
    except SkancfError:
        monkeypatch.setattr(output, "picture", lambda *_, **__: None)
    (example,) = tutorial.examples(tutorial.FRONT)
    (given,) = tutorial.run([example])
    assert example.shown and tutorial.same(example.shown, given), given
    statements = ast.parse(example.code).body
    assert len(statements) <= 10


def test_every_tutorial_is_found_and_shows_a_picture():
    pages = {
        "getting_started",
        "thin_plates",
        "shells",
        "paths",
        "laminates",
        "adaptive",
        "dynamics",
        "speed",
        "own_energy",
        "links_and_hinges",
        "rubber",
        "results",
        "rubber_shells",
        "tapers_and_zones",
        "looking",
        "saving",
        "exchange",
        "command_line",
        "progress",
    }
    assert pages <= set(tutorial.PAGES)
    assert all(tutorial.pictures(page) for page in tutorial.PAGES.values())


@pytest.mark.parametrize(
    ("shown", "printed", "equal"),
    [
        ("-3.60 mm\n", "-3.61 mm\n", True),
        ("-3.60 mm\n", "-3.63 mm\n", False),
        ("169 nodes\n", "170 nodes\n", False),
        ("converged\n", "diverged\n", False),
        ("a 1.0\n", "a 1.0\nb\n", False),
    ],
)
def test_the_comparison_has_teeth(shown, printed, equal):
    assert tutorial.same(shown, printed) is equal


def test_every_public_name_is_on_the_page_of_public_names():
    page = (DOCS / "api" / "index.rst").read_text(encoding="utf-8")
    listed = set(re.findall(r"^   (\w+)$", page, re.MULTILINE))
    wanted = {name for name in skancf.__all__ if not isinstance(getattr(skancf, name), ModuleType)} - {"__version__"}
    assert not wanted - listed
    assert len(wanted) > 50
