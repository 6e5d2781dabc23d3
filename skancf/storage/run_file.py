"""A problem file run, and its results in a folder."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skancf.adaptive import AdaptiveResult
from skancf.atomic import AnyPath, as_path, check_folder
from skancf.dynamics import Motion
from skancf.errors import SkancfError, finite
from skancf.solution import Solution
from skancf.statics import BucklingResult, Modes, PathResult, StaticResult
from skancf.storage.files import save
from skancf.storage.problem_file import ProblemFile, read_problem

RESULT, TABLE, PICTURE, STATE, STATES = "result.h5", "table.csv", "picture.png", "state.vtu", "states.pvd"
Columns = dict[str, Any]


@dataclass(frozen=True)
class FileRun:
    """What :func:`run_file` has computed and written.

    Attributes
    ----------
    task : ProblemFile
        What the file asked for.
    result
        That of the analysis: a StaticResult, Solution, PathResult, Modes, BucklingResult, Motion or AdaptiveResult.
    folder : Path
    files : tuple of Path
        In the folder: ``result.h5``, which :func:`~skancf.load` reads, ``table.csv``, ``picture.png``, and ``state.vtu`` or
        ``states.pvd`` for ParaView.
    notes : tuple of str
        What could not be written, and why.

    Examples
    --------
    See :func:`run_file`, which makes one.

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
    >>> run = sk.run_file("plate.toml", "there")
    >>> run.ok, (run.folder / "table.csv").exists()
    (True, True)
    """

    task: ProblemFile
    result: Any
    folder: Path
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the analysis reached what was asked for."""
        return bool(getattr(self.result, "ok", True))

    @property
    def message(self) -> str:
        """What the result says, in words; empty where there is nothing to say."""
        return str(getattr(self.result, "message", "") or getattr(self.result, "note", ""))


def run_file(path: AnyPath, folder: AnyPath | None = None, *, progress: bool = False) -> FileRun:
    """Solve the problem in a TOML file, and write the results to a folder.

    Parameters
    ----------
    path : str or Path
        See :func:`read_problem`.
    folder : str or Path, optional
        Default: next to the file, with its name and ``_results``. Files of an earlier run in it are replaced.
    progress : bool
        Show progress bars.

    Returns
    -------
    FileRun
        The result and the files; also of an analysis that did not reach its end, with ``ok`` false.

    Raises
    ------
    InputError
        For what is wrong in the file, and a folder that cannot be written, before anything is computed.

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
    >>> run = sk.run_file("plate.toml")
    >>> sk.load(run.folder / "result.h5") == run.result
    True
    """
    task, file = read_problem(path), as_path("file", path)
    place = check_folder(file.with_name(f"{file.stem}_results") if folder is None else folder)
    result = task.run(progress=progress)
    kept: list[Path] = []
    notes: list[str] = []
    for write in (_save, _table, _picture, _states):
        with _noting(notes):
            kept.append(write(task, result, place))
    return FileRun(task, result, place, tuple(kept), tuple(notes))


@contextmanager
def _noting(notes: list[str]) -> Iterator[None]:
    """What cannot be written stops nothing else."""
    try:
        yield
    except SkancfError as wrong:
        notes.append(str(wrong))


def _save(task: ProblemFile, result: Any, folder: Path) -> Path:
    return save(result, folder / RESULT)


def _table(task: ProblemFile, result: Any, folder: Path) -> Path:
    from skancf.output import save_table

    columns = next(make for kind, make in COLUMNS.items() if isinstance(result, kind))
    return save_table(folder / TABLE, columns(result, _points(task)))


def _picture(task: ProblemFile, result: Any, folder: Path) -> Path:
    from skancf.output import picture
    from skancf.output.rendering import check_rendering

    check_rendering()
    options = {name: value for name, value in task.output.items() if name != "points"}
    return picture(shown_state(result), folder / PICTURE, **options)


def _states(task: ProblemFile, result: Any, folder: Path) -> Path:
    from skancf.output import write

    if isinstance(result, Motion):
        return write(result.states, folder / STATES)
    if isinstance(result, PathResult):
        return write(result.solutions, folder / STATES)
    if isinstance(result, Modes | BucklingResult):
        return write((result.shape(k) for k in range(len(result.shapes))), folder / STATES)
    return write(shown_state(result), folder / STATE)


def shown_state(result: Any) -> Solution:
    """The state of a result that a picture shows: the last one, or the first shape."""
    if isinstance(result, Motion):
        return result.at(float(result.times[-1]))
    if isinstance(result, Modes | BucklingResult):
        return result.shape(0)
    return result if isinstance(result, Solution) else result.solution


def _points(task: ProblemFile) -> np.ndarray:
    return finite("[output] points", task.output.get("points", np.empty((0, 2)))).reshape(-1, 2)


def _of_states(first: Columns, states: Iterable[Solution], points: np.ndarray) -> Columns:
    """Columns with the largest displacement, the strain energy, and the displacements of points."""
    rows = []
    for state in states:
        largest = np.linalg.norm(state.displacements, axis=0).max()
        rows.append([largest, state.strain_energy, *(np.ravel(state.displacement(points)) if len(points) else ())])
    titles = ["largest displacement", "strain energy"]
    titles += [f"u{k} at ({x:g}, {y:g})" for x, y in points for k in (1, 2, 3)]
    return first | dict(zip(titles, np.array(rows).reshape(-1, len(titles)).T, strict=True))


def _of_static(result: StaticResult, points: np.ndarray) -> Columns:
    return _of_states({"load factor": [state.load_factor for state in result.path]}, result.path, points)


def _of_motion(result: Motion, points: np.ndarray) -> Columns:
    ledger = result.output_ledger()
    return _of_states({"time": result.times, "kinetic energy": ledger.kinetic}, result.states, points)


def _of_levels(result: AdaptiveResult, points: np.ndarray) -> Columns:
    names = ("n_elements", "n_dofs", "value", "error", "bar")
    return {name: [getattr(level, name) for level in result.levels] for name in names}


COLUMNS: dict[type, Callable[[Any, np.ndarray], Columns]] = {
    Solution: lambda state, points: _of_states({"load factor": [state.load_factor]}, [state], points),
    StaticResult: _of_static,
    PathResult: lambda path, points: _of_states(
        {"load factor": path.load_factors, "negative pivots": path.negative_pivots}, path.solutions, points
    ),
    Modes: lambda found, points: {"frequency": found.frequencies, "eigenvalue": found.eigenvalues},
    BucklingResult: lambda found, points: {"load factor": found.load_factors},
    Motion: _of_motion,
    AdaptiveResult: _of_levels,
}
"""What the table of a result has."""
