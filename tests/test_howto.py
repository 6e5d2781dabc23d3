"""How-to pages keep their word: they print what they show, and are found by the words that people type."""

import re
import shutil

import pytest
from test_docs import check_page, tutorial

WORDS = {
    "plate_with_hole": ["hole", "opening", "cut-out", "stress concentration"],
    "many_thicknesses": ["many thicknesses", "thickness", "parameter study", "sweep"],
    "symmetric_half": ["symmetry", "symmetric half", "quarter model", "mirror"],
    "pressure": ["pressure", "follower load", "inflation"],
    "prestress": ["prestress", "pre-tension", "pretension"],
    "buckling": ["buckling", "critical load", "imperfection", "stability"],
    "modes": ["modes", "eigenfrequency", "natural frequency", "vibration", "modal analysis"],
    "restart": ["restart", "resume", "checkpoint"],
    "own_energy": ["own energy", "custom energy", "elastic foundation"],
    "laminate": ["laminate", "composite", "layup", "sandwich", "ply"],
    "thermal": ["thermal", "temperature", "thermal stress"],
    "zones": ["zones", "variable thickness", "taper", "several materials"],
    "rubber": ["rubber", "hyperelastic", "neo-Hooke", "large strain"],
    "own_surface": ["own surface", "parametric surface", "MappedSurface", "imperfection"],
    "compare_meshes": ["compare meshes", "mesh convergence", "convergence study"],
    "error_bar": ["error bar", "accuracy", "error estimate", "adaptive mesh refinement"],
    "own_load": ["own load", "custom load", "load history", "varying load"],
    "damping": ["damping", "Rayleigh damping", "damping ratio", "dashpot"],
    "moving_load": ["moving load", "moving force", "wheel", "bridge"],
    "csv_and_pandas": ["CSV", "pandas", "DataFrame", "Excel", "CSV and pandas"],
    "animation": ["animation", "mp4", "gif", "video", "movie"],
    "check_with_calculix": ["CalculiX", "check with CalculiX", "Abaqus", "verification"],
    "gmsh": ["gmsh", "meshio", "mesh file", "import mesh"],
    "stress_along_a_line": ["stress along a line", "von Mises", "principal stress", "stress at a point"],
    "notebook": ["notebook", "Jupyter", "interactive viewer"],
    "logging_and_progress": ["logging", "progress bar", "progress", "verbose"],
}
INDEX = (tutorial.DOCS / "howto" / "index.rst").read_text(encoding="utf-8")
LARGEST = 80_000  # bytes of a picture


def entries(name: str) -> set[str]:
    """Main entries of the index that lead to a page: the search of the site puts whole ones first."""
    head = re.match(r"\.\. index:: (.+(?:\n   .+)*)\n\n", tutorial.HOWTO[name].read_text(encoding="utf-8"))
    assert head, "a page begins with the words that people type, as main entries of the index"
    words = re.split(r", |\n +", head[1])
    assert all(word.startswith("! ") for word in words)
    return {word[2:].lower() for word in words}


@pytest.mark.parametrize("name", tutorial.HOWTO)
def test_a_page_prints_what_it_shows(name, tmp_path, monkeypatch):
    if name == "check_with_calculix" and not shutil.which("ccx"):
        pytest.skip("CalculiX (ccx) is not installed: apt install calculix-ccx")
    if name == "gmsh":
        pytest.importorskip("gmsh", reason="gmsh or a library of it is not installed", exc_type=(ImportError, OSError))
    check_page(tutorial.HOWTO[name], tmp_path, monkeypatch)


@pytest.mark.parametrize("name", tutorial.HOWTO)
def test_a_page_has_its_parts(name):
    text = tutorial.HOWTO[name].read_text(encoding="utf-8")
    for part in ("\nPitfalls\n--------\n", "\nSee also\n--------\n"):
        assert part in text
    first = tutorial.examples(tutorial.HOWTO[name])[0]
    assert "import skancf as sk\n" in first.code, "the first script can be pasted"
    assert first.shown, "its output is on the page"
    assert max(len(line) for example in tutorial.examples(tutorial.HOWTO[name]) for line in example.code.splitlines()) <= 86
    for picture in tutorial.pictures(tutorial.HOWTO[name]):
        assert (tutorial.DOCS / "pictures" / picture).stat().st_size < LARGEST


def test_every_page_is_listed_twice_in_the_same_order():
    """In a group, with a sentence, and in the tree of contents."""
    listed = re.findall(r"^\* :doc:`(\w+)`: .+\.$", INDEX, re.MULTILINE)
    assert listed == re.findall(r"^   (\w+)$", INDEX, re.MULTILINE)
    assert sorted(listed) == sorted(tutorial.HOWTO) == sorted(WORDS)


@pytest.mark.parametrize(("name", "words"), WORDS.items())
def test_a_page_is_found_by_the_words_that_people_type(name, words):
    """By each of them, before all but two others: whole main entries count 100 in the search, whole titles 15, text 5."""
    for word in words:
        assert word.lower() in entries(name)
        assert sum(word.lower() in entries(other) for other in tutorial.HOWTO) <= 3
