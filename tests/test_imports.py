"""Rooms of the library import in one direction, and the heavy ones are not loaded with the rest."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import skancf

PACKAGE = Path(skancf.__file__).parent
# A room imports from itself and from rooms before it.
ROOMS = [
    "version", "tolerances", "showing", "errors", "functions", "arguments", "equality", "rows", "memory", "checks", "atomic",
    "optional", "tabular", "units", "columns", "history", "progress", "compiling", "compiled", "threads", "vectors",
    "tensors", "elements", "surfaces", "linear", "kernels", "solving", "materials", "meshes", "theories", "layout", "terms",
    "conditions", "supports", "loads", "system", "thinness", "problem", "testing", "recovered", "true_stress",
    "local_fields", "point_values", "lines", "reactions", "solution", "states", "statics", "dynamics", "envelopes",
    "strength", "adaptive", "output", "export", "storage", "about", "cli", "__main__",
]  # fmt: skip
# The package's own __init__ names what users see; everything else is in a room.
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE or path.name != "__init__.py")


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(source: str) -> Iterator[str]:
    """Dotted names of this package that any import names, inside functions too."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "relative"
                continue
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        yield from (name.removeprefix("skancf.") for name in names if name.split(".")[0] == "skancf")


def loaded_by_name(source: str) -> Iterator[str]:
    """Names of this package's modules that are written as text, as for ``import_module``."""
    texts = (node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant))
    yield from (text.removeprefix("skancf.") for text in texts if isinstance(text, str) and DOTTED.fullmatch(text))


DOTTED = re.compile(r"skancf(\.[a-z]\w*)+")
WHEN_ASKED = {("showing", "output.notebook"), ("showing", "output.viewer")}
"""A room that every object shows itself by, and pictures of objects, which a notebook or the user asks for."""


def forbidden(room: str, source: str) -> list[str]:
    """Imports that do not point to this room or an earlier one."""
    allowed = ROOMS[: ROOMS.index(room) + 1]
    late = [name for name in loaded_by_name(source) if (room, name) not in WHEN_ASKED]
    return [name for name in [*imported(source), *late] if name.split(".")[0] not in allowed]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_go_one_way(path):
    assert room_of(path) in ROOMS, f"a new room: give it its place among {ROOMS}"
    assert forbidden(room_of(path), path.read_text()) == []


def test_the_check_can_fail():
    assert forbidden("statics", "from skancf.linear import DirectSolver") == []
    assert forbidden("linear", "def f():\n    from skancf.statics import solve") == ["statics.solve"]
    assert forbidden("meshes", "import skancf.theories.full") == ["theories.full"]
    assert forbidden("errors", "from skancf import Problem") == ["Problem"]
    assert forbidden("meshes", "from .. import errors") == ["relative"]
    assert forbidden("meshes", "import_module('skancf.output.notebook')") == ["output.notebook"]
    assert forbidden("showing", "import_module('skancf.output.notebook')") == []
    assert forbidden("meshes", "import numpy\nfrom skfem import MeshQuad") == []


def files_import_cycle(graph: dict[str, set[str]]) -> list[str]:
    """A cycle of files, or nothing."""
    done: set[str] = set()

    def visit(name: str, above: tuple[str, ...]) -> list[str]:
        if name in above:
            return [*above[above.index(name) :], name]
        if name in done:
            return []
        for other in sorted(graph.get(name, ())):
            if cycle := visit(other, (*above, name)):
                return cycle
        done.add(name)
        return []

    return next((cycle for name in sorted(graph) if (cycle := visit(name, ()))), [])


def test_files_of_a_room_have_no_cycle():
    dotted = [".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__") for path in FILES]
    modules = dict(zip(dotted, FILES, strict=True))
    graph = {}
    for name, path in modules.items():
        wanted = set()
        for full in imported(path.read_text()):
            parts = full.split(".")
            wanted |= {m for m in (".".join(parts[:k]) for k in range(1, len(parts) + 1)) if m in modules}
        # A file names its own package on the way to its neighbours.
        graph[name] = {m for m in wanted if m != name and not name.startswith(m + ".")}
    assert files_import_cycle(graph) == []
    assert files_import_cycle({"a": {"b"}, "b": {"c"}, "c": {"a"}}) == ["a", "b", "c", "a"]


def loaded_after(code: str) -> set[str]:
    """Modules of a fresh process that ran some code."""
    shown = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return set(shown.stdout.split())


def test_import_loads_nothing_heavy():
    loaded = loaded_after("import skancf")
    assert {"skancf", "skfem", "numba"} <= loaded
    heavy = {"pyvista", "vtk", "vtkmodules", "matplotlib", "meshio", "scipy.signal", "scipy.stats", "scipy.interpolate",
             "scipy.optimize", "scipy.spatial", "scipy.special", "scipy.ndimage", "skancf.output"}  # fmt: skip
    assert not loaded & heavy
    assert loaded_after("import skancf; skancf.output") & heavy == {"skancf.output"}


def test_output_is_a_name_of_the_package_before_it_is_loaded():
    shown = "import skancf as sk; assert 'output' in dir(sk); assert sk.output.sample; from skancf import *; output.sample"
    assert "skancf.output" in loaded_after(shown)
    with pytest.raises(AttributeError, match="no attribute 'outputs'"):
        _ = skancf.outputs


LINES, FUNCTION, SYSTEM = 400, 60, 200
"""Lines of a file, of a function without its docstring, and of the file that holds what solvers know."""
COMPILED = re.compile(r"^(kernels/|theories/.*kernel)")
"""Compiled code, which is unrolled by hand."""


def long_functions(source: str) -> list[str]:
    """Functions of more lines than allowed, docstrings not counted."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            first = node.body[0]
            docstring = ast.get_docstring(node) is not None
            lines = (node.end_lineno or 0) - node.lineno + 1
            lines -= (first.end_lineno or 0) - first.lineno + 1 if docstring else 0
            if lines > FUNCTION:
                found.append(f"{node.name}: {lines}")
    return found


def without_examples(source: str) -> int:
    """Lines of a file without the examples at the ends of docstrings, which are pages of the documentation."""
    examples = re.findall(r'^ *Examples\n *-{8}\n(?:(?! *""").*\n)*', source, re.MULTILINE)
    return len(source.splitlines()) - sum(len(each.splitlines()) for each in examples)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_files_and_functions_are_short(path):
    name, source = path.relative_to(PACKAGE).as_posix(), path.read_text()
    assert without_examples(source) <= (SYSTEM if name == "system/system.py" else LINES)
    if not COMPILED.match(name):
        assert long_functions(source) == []


def test_the_count_of_lines_can_fail():
    body = "\n".join(f"    x{k} = {k}" for k in range(FUNCTION))
    assert long_functions(f"def f():\n{body}") == [f"f: {FUNCTION + 1}"]
    assert long_functions(f'def f():\n    """{"doc" + chr(10) * 90}"""\n    return 1') == []
    shown = 'def f():\n    """Doc.\n\n    Examples\n    --------\n    >>> f()\n    1\n    """\n    return 1\n'
    assert without_examples(shown) == 5


@pytest.mark.parametrize("room", ["adaptive", "conditions", "dynamics", "export", "loads", "materials", "meshes", "output",
                                  "statics", "storage", "supports", "surfaces", "terms", "testing", "theories"])  # fmt: skip
def test_rooms_are_names_of_the_package(room):
    assert room in skancf.__all__ and room in dir(skancf)
    assert getattr(skancf, room).__name__ == f"skancf.{room}" and getattr(skancf, room).__doc__


def test_rooms_are_there_without_another_import():
    code = "import skancf as sk; sk.loads.Load, sk.supports.Pin, sk.adaptive.Marking, sk.dynamics.MeshEvent, sk.terms.Term"
    assert "skancf.testing" not in loaded_after(code)
    assert "skancf.testing" in loaded_after("import skancf as sk; sk.testing.check_term")
