"""The page for contributors has the rooms in their order, the citation the version, and make what it names."""

import ast
import re
from pathlib import Path

import pytest
from test_imports import PACKAGE, ROOMS

import skancf

ROOT = Path(__file__).resolve().parent.parent
pytestmark = pytest.mark.skipif(not (ROOT / "CONTRIBUTING.md").exists(), reason="tests away from their checkout")


def first_line(room: str) -> str:
    """Of a room's docstring, without the roles of reStructuredText."""
    file = PACKAGE / f"{room}.py"
    source = (file if file.exists() else PACKAGE / room / "__init__.py").read_text(encoding="utf-8")
    line = (ast.get_docstring(ast.parse(source)) or "The version of the package.").splitlines()[0]
    return re.sub(r":\w+:`~?(?:[\w.]*\.)?([^`]+)`", r"`\1`", line).replace("``", "`")


def test_the_map_has_all_rooms_in_their_order():
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- `(\w+)`: (.*)$", page, re.MULTILINE)
    assert listed == [(room, first_line(room)) for room in ROOMS]


def test_the_page_names_what_there_is():
    page, makefile = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"\bmake ([a-z]+)\b", page)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    for path in set(re.findall(r"`((?:skancf|tests|docs|demos)/[\w./]+)`", page)):
        assert (ROOT / path).exists(), path


def test_the_citation_has_the_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(rf"^version: {re.escape(skancf.__version__)}$", text, re.MULTILINE)
