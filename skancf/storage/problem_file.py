"""Problems written as TOML: tables and numbers, of which nothing is evaluated."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from inspect import signature
from pathlib import Path
from typing import Any

import skfem

from skancf import meshes
from skancf.adaptive import adapt
from skancf.arguments import flag, whole
from skancf.atomic import AnyPath, as_path, reason
from skancf.dynamics import simulate
from skancf.equality import by_value
from skancf.errors import InputError, shown
from skancf.meshes.forest import DEEPEST
from skancf.problem import Problem
from skancf.statics import buckling, modes, solve, solve_linear, trace
from skancf.storage.describe import arguments, build, known, made, told
from skancf.storage.files import load
from skancf.system.system import System

ANALYSES: dict[str, Callable[..., Any]] = {
    "adapt": adapt, "buckling": buckling, "modes": modes, "simulate": simulate, "solve": solve,
    "solve_linear": solve_linear, "trace": trace,
}  # fmt: skip
MESHES: dict[str, Callable[..., Any]] = {
    "graded": meshes.graded, "tensor": meshes.tensor, "uniform": meshes.uniform, "with_lines": meshes.with_lines,
}  # fmt: skip
GIVEN = frozenset({"surface", "zones", "system", "problem", "mesh", "theory", "progress"})
"""Arguments that other tables give, or whoever runs a file."""
FUNCTIONS = frozenset({"start", "state", "record", "indicator", "checkpoint", "resume", "follow"})
"""Arguments that no table can give."""
TABLES = ("title", "theory", "mesh", "analysis", "output", "materials", "histories")
"""What a file has beside the arguments of a Problem."""
OUTPUT = ("points", "field", "scale", "z")


@by_value
@dataclass(frozen=True)
class ProblemFile:
    """What a problem file asks for.

    Attributes
    ----------
    problem : Problem
    mesh : skfem.MeshQuad or None
        None where the analysis is ``adapt`` and makes its own.
    theory : str or Theory
    analysis : str
        The function that is asked for, one of ``"solve"``, ``"solve_linear"``, ``"trace"``, ``"modes"``, ``"buckling"``,
        ``"simulate"`` and ``"adapt"``.
    options : dict
        Its other arguments.
    output : dict
        What :func:`run_file` shows: ``points`` of the parameter plane, and ``field``, ``z`` and ``scale`` of the picture.
    title : str

    Examples
    --------
    >>> text = '''
    ... thickness = 0.01
    ... surface = {type = "Rectangle", length_x = 1.0, length_y = 0.5}
    ... material = {type = "Isotropic", young = 210e9, poisson = 0.3, density = 7850.0}
    ... supports = [{type = "Clamp", where = "left"}]
    ... mesh = {type = "uniform", nx = 4, ny = 2}
    ... analysis = {type = "modes", n = 2}
    ... '''
    >>> import pathlib
    >>> _ = pathlib.Path("plate.toml").write_text(text)
    >>> task = sk.read_problem("plate.toml")
    >>> task.analysis, task.options, task.system.n_dofs
    ('modes', {'n': 2}, 180)
    """

    problem: Problem
    mesh: skfem.MeshQuad | None
    theory: Any
    analysis: str
    options: dict[str, Any] = field(default_factory=dict)
    output: dict[str, Any] = field(default_factory=dict)
    title: str = ""

    @cached_property
    def system(self) -> System:
        """The problem on its mesh; InputError where the file has none."""
        if self.mesh is None:
            raise InputError("system: the file has no mesh, as the analysis 'adapt' makes its own; add a table [mesh]")
        return self.problem.on(self.mesh, self.theory)

    def run(self, *, progress: bool = False) -> Any:
        """The result of the analysis.

        Raises
        ------
        InputError
            As the function of the analysis.
        """
        function = ANALYSES[self.analysis]
        options = dict(self.options)
        if "progress" in signature(function).parameters:
            options["progress"] = progress
        if function is adapt:
            options |= {"problem": self.problem, "mesh": self.mesh, "theory": self.theory}
        else:
            options["system"] = self.system
        return function(**options)


def read_problem(path: AnyPath) -> ProblemFile:
    """Read a problem, its mesh, its theory and the analysis that is asked for from a TOML file.

    The arguments of :class:`~skancf.Problem` are the tables and keys of the file. An object is a table with its class as
    ``type`` and its arguments by name. No text is evaluated. The page "The problem file" describes all tables.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    ProblemFile

    Raises
    ------
    InputError
        For a file that is not there or is not TOML (the line is named), for unknown tables, classes and arguments, with the
        nearest known ones, and for values that the classes refuse; the message names the table and the key.

    Examples
    --------
    >>> text = '''
    ... thickness = 0.01
    ... surface = {type = "Rectangle", length_x = 1.0, length_y = 0.5}
    ... material = {type = "Isotropic", young = 210e9, poisson = 0.3, density = 7850.0}
    ... supports = [{type = "Clamp", where = "left"}]
    ... loads = [{type = "Gravity"}]
    ... mesh = {type = "uniform", nx = 4, ny = 2}
    ... analysis = {type = "solve"}
    ... '''
    >>> import pathlib
    >>> _ = pathlib.Path("plate.toml").write_text(text)
    >>> sk.read_problem("plate.toml").run().status.value
    'converged'
    """
    file = as_path("file", path)
    tables = _tables(file)
    try:
        return _task(tables, file.parent)
    except InputError as wrong:
        raise InputError(f"file '{file}': {wrong}") from wrong


def _tables(file: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(file.read_bytes().decode())
    except OSError as wrong:
        raise InputError(f"file '{file}': cannot be read ({reason(wrong)})") from wrong
    except ValueError as wrong:  # of TOML, and of bytes that are no text
        raise InputError(f"file '{file}': is not TOML ({wrong})") from wrong


def _task(tables: Mapping[str, Any], folder: Path) -> ProblemFile:
    own = {key: item for key, item in tables.items() if key not in TABLES}
    named = {key: _table(key, tables) for key in ("materials", "histories")}
    for key in own:
        known("table or key", key, (*PROBLEM, *TABLES), "the file")
    problem = made(Problem, own, "the problem", named)
    analysis, options = _typed("analysis", _table("analysis", tables, needed=True), ANALYSES)
    for key in options.keys() & FUNCTIONS:
        raise InputError(f"[analysis]: {key} is a function, a state or a folder, given in Python only; leave it out")
    task = arguments(ANALYSES[analysis], options, f"[analysis] ({analysis})", named, GIVEN | FUNCTIONS)
    mesh = _mesh(_table("mesh", tables, needed=analysis != "adapt"), problem, folder)
    output = _table("output", tables)
    for key in output:
        known("key", key, OUTPUT, "[output]")
    theory = build(tables.get("theory", "kirchhoff" if analysis == "adapt" else "full"), "theory", named, "theory")
    title = tables.get("title", "")
    if not isinstance(title, str):
        raise InputError(f"title = {shown(title)}: give a text")
    return ProblemFile(problem, mesh, theory, analysis, task, dict(output), title)


PROBLEM = tuple(signature(Problem).parameters)


def _table(name: str, tables: Mapping[str, Any], needed: bool = False) -> Mapping[str, Any]:
    if name not in tables and needed:
        raise InputError(f"the table [{name}] is missing; add it")
    table = tables.get(name, {})
    if not isinstance(table, Mapping):
        raise InputError(f"{name} = {shown(table)}: give a table [{name}]")
    return table


def _typed(name: str, table: Mapping[str, Any], choices: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    if "type" not in table:
        raise InputError(f"[{name}]: type is missing; choose one of {', '.join(sorted(choices))}")
    kind = known("type", table["type"], choices, f"[{name}]")
    return kind, {key: item for key, item in table.items() if key != "type"}


def _mesh(table: Mapping[str, Any], problem: Problem, folder: Path) -> skfem.MeshQuad | None:
    if not table:
        return None
    kind, options = _typed("mesh", table, {**MESHES, "file": None})
    where = f"[mesh] ({kind})"
    if kind == "file":
        return _mesh_in_file(options, folder, where)
    function = MESHES[kind]
    given = arguments(function, options, where, {}, GIVEN, ("quadtree", "refined"))
    is_tree = told(where, flag, {"name": "quadtree", "value": given.pop("quadtree", False)})
    times = told(where, whole, {"name": "refined", "value": given.pop("refined", 0), "least": 0, "most": DEEPEST})
    given |= {"zones": problem.zones} if "zones" in signature(function).parameters else {}
    mesh = told(where, function, {"surface": problem.surface, **given})
    if is_tree:
        mesh = told(where, meshes.quadtree, {"mesh": mesh, "surface": problem.surface})
    return told(where, mesh.refined, {"times_or_ix": times}) if times else mesh


def _mesh_in_file(options: Mapping[str, Any], folder: Path, where: str) -> skfem.MeshQuad:
    for key in options:
        known("key", key, ("path",), where)
    if not isinstance(options.get("path"), str):
        raise InputError(f"{where}: path is missing; give that of a mesh that sk.save has written")
    mesh = load(folder / options["path"])
    if not isinstance(mesh, skfem.MeshQuad):
        raise InputError(f"{where}: path = '{options['path']}' holds a {type(mesh).__name__}; give the file of a mesh")
    return mesh
