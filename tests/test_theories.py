"""What only a theory knows stands in its folder: nobody else asks which theory it is."""

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import skancf as sk
from skancf import theories
from skancf.theories import left_per_halving, theory_named
from skancf.theories.theory import Theory

PACKAGE = Path(sk.__file__).parent
OWN = ("theories", "terms/shells")
"""The theories, and what binds them to meshes."""
FILES = [path for path in sorted(PACKAGE.rglob("*.py")) if not path.relative_to(PACKAGE).as_posix().startswith(OWN)]
NAMES = set(theories.ALL)
CLASSES = {kind.__name__ for kind in theories.ALL.values()} | {"FullAssembly", "ThinAssembly"}
TESTED = {ast.If: "test", ast.IfExp: "test", ast.While: "test", ast.Subscript: "slice", ast.Match: "subject"}
"""Parts of code that rule what happens."""


def named(node: ast.AST) -> str:
    """The last name of a variable or attribute."""
    return getattr(node, "attr", getattr(node, "id", ""))


def asks_class(node: ast.Call) -> bool:
    if named(node.func) in ("isinstance", "issubclass", "cast"):
        return any(named(part) in CLASSES for part in ast.walk(node))
    return named(node.func) == "type" and any(named(argument).endswith("theory") for argument in node.args)


def has_name_of_theory(node: ast.AST) -> bool:
    parts = (part for part in ast.walk(node) if isinstance(part, ast.Attribute))
    return any(part.attr == "name" and named(part.value).endswith("theory") for part in parts)


def questions(source: str) -> Iterator[str]:
    """Lines of code that ask which theory it is."""
    lines = source.splitlines()
    for node in ast.walk(ast.parse(source)):
        asks = isinstance(node, ast.Attribute) and node.attr == "twist"
        asks |= isinstance(node, ast.Call) and asks_class(node)
        asks |= type(node) in TESTED and has_name_of_theory(getattr(node, TESTED.get(type(node), ""), node))
        if isinstance(node, ast.Compare):
            literals = (part.value for part in [node.left, *node.comparators] if isinstance(part, ast.Constant))
            asks |= has_name_of_theory(node) or any(value in NAMES for value in literals)
        if asks:
            yield lines[node.lineno - 1].strip()


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_nobody_else_asks_which_theory_it_is(path):
    assert list(questions(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("source", [
    "if geometry.theory.twist:\n    pass", "rows = [] if theory.name == 'full' else [1]",
    "x = LEFT[system.geometry.theory.name]",
    "thin = system.geometry.theory.twist", "isinstance(system.assembly, FullAssembly)", "cast(Kirchhoff, geometry.theory)",
    "old.theory.name != new.theory.name", "type(geometry.theory) is Thing", "chosen = choice.theory == 'kirchhoff'",
    "isinstance(theory, theories.Full)",
])  # fmt: skip
def test_the_search_finds_questions(source):
    assert set(questions(source)) == {source.splitlines()[0]}


@pytest.mark.parametrize("source", [
    "say(f'theory {geometry.theory.name!r} has none')", "if geometry.theory.directors:\n    pass",
    "problem.on(mesh, 'full')",
    "if system.name == 'plate':\n    pass", "left = left_per_halving(geometry.theory)",
])  # fmt: skip
def test_the_search_lets_other_things_pass(source):
    assert list(questions(source)) == []


def members() -> set[str]:
    return {name for name in vars(Theory) if not name.startswith("_")}


@pytest.mark.parametrize("name", theories.ALL)
def test_a_theory_has_what_the_protocol_says_and_nothing_of_it_is_unused(name):
    theory = theory_named(name)
    assert [member for member in members() if not hasattr(theory, member)] == []
    others = "\n".join(path.read_text(encoding="utf-8") for path in [*FILES, *(PACKAGE / "terms" / "shells").glob("*.py")])
    assert [member for member in members() if f".{member}" not in others] == []
    assert theory.rows.size == 4 * len(theory.nodal_vectors) and np.unique(theory.rows).size == 16
    assert left_per_halving(theory) == (1 / 2) ** theory.order


@pytest.mark.parametrize("name", theories.ALL)
def test_hanging_weights_are_those_of_the_local_functions(name):
    """In the middle of an edge of one element: what its local functions say of what lies on the edge."""
    theory = theory_named(name)
    table = theory.nodal_table(np.array([[0.5], [0.0]]))[:, :, 0]
    ends = theory.hanging_weights(np.ones(1), np.ones(1, dtype=bool))[:, 0]
    expected = np.stack([table[:, theory.rows[corner]] for corner in (0, 1)])
    along = [k for k, vector in enumerate(theory.nodal_vectors) if vector in ("r", "r_x", "r_z") or theory.continuity]
    assert np.abs(ends - expected)[:, along].max() < 1e-15
    assert np.abs(1.01 * ends - expected)[:, along].max() > 1e-3
