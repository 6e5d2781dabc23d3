"""Running CalculiX on a deck, and reading what it answers."""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skancf.arguments import text, whole
from skancf.atomic import AnyPath, as_path
from skancf.errors import InputError, SkancfError, finite, positive
from skancf.export.bricks import Bricks
from skancf.showing import short
from skancf.states import solution_of
from skancf.tolerances import SEVEN_DIGITS


class Printed(NamedTuple):
    """Displacements that CalculiX prints.

    Attributes
    ----------
    time : float
        Of the increment; one at the end of a static step.
    nodes : (n,) int array
        Numbers of the nodes in the deck.
    displacements : (n, 3) array
        In m.

    Examples
    --------
    >>> table = sk.export.Printed(1.0, np.array([7]), np.array([[0.0, 0.0, -2.5e-3]]))
    >>> table.displacements[table.nodes == 7]
    array([[ 0.    ,  0.    , -0.0025]])
    """

    time: float
    nodes: np.ndarray
    displacements: np.ndarray


def read_calculix(path: AnyPath) -> Printed:
    r"""The last displacements in a ``.dat`` file of CalculiX, which ``*NODE PRINT`` with ``U`` writes.

    Raises
    ------
    InputError
        For a file that cannot be read or has no displacements.

    Examples
    --------
    >>> from pathlib import Path
    >>> text = " displacements (vx,vy,vz) for set NALL and time  0.1000000E+01\n\n  7  0.0  0.0  -2.5E-3\n"
    >>> _ = Path("job.dat").write_text(text)
    >>> sk.export.read_calculix("job.dat").displacements
    array([[ 0.    ,  0.    , -0.0025]])
    """
    file = as_path("path", path)
    try:
        lines = file.read_text(encoding="ascii", errors="replace").splitlines()
    except OSError as wrong:
        raise InputError(f"path = '{file}': cannot be read ({wrong.strerror})") from wrong
    heads = [k for k, line in enumerate(lines) if line.strip().startswith("displacements")]
    if not heads:
        raise InputError(f"path = '{file}': has no displacements; give the .dat file of a run with *NODE PRINT and U")
    begin = heads[-1]
    rows = []
    for line in lines[begin + 2 :]:
        words = line.split()
        if len(words) != 4 or not words[0].isdigit():
            break
        rows.append(words)
    try:
        table, time = np.array(rows, dtype=float).reshape(-1, 4), float(lines[begin].split()[-1])
    except ValueError as wrong:
        raise InputError(f"path = '{file}': its displacements are damaged ({wrong})") from wrong
    return Printed(time, table[:, 0].astype(int), table[:, 1:])


@dataclass(frozen=True, eq=False)
class CalculixDeck:
    """A deck that :func:`calculix` wrote.

    Attributes
    ----------
    path : Path
    bricks : Bricks
        Its nodes and elements.
    nonlinear : bool

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.02, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")], [sk.Gravity()])
    >>> deck = sk.export.calculix(plate.on(sk.meshes.uniform(plate.surface, 4, 4)), "plate.inp")
    >>> deck
    CalculixDeck('plate.inp', 16 bricks, 155 nodes)
    >>> deck.run().displacement((1.0, 0.5))    # doctest: +SKIP
    array([-2.1e-07, -1.0e-20, -1.2e-03])
    """

    path: Path
    bricks: Bricks
    nonlinear: bool

    def __repr__(self) -> str:
        return f"CalculixDeck('{self.path}', {self.n_elements} bricks, {self.n_nodes} nodes)"

    @property
    def n_nodes(self) -> int:
        return self.bricks.n_nodes

    @property
    def n_elements(self) -> int:
        return self.bricks.n_layers * self.bricks.system.geometry.n_elements

    def run(self, ccx: str = "ccx", *, threads: int = 1, timeout: float = 3600.0) -> "CalculixResult":
        """Run CalculiX in the folder of the deck, and read its answer.

        Parameters
        ----------
        ccx : str
            The program: a name on the path or a file.
        threads : int
        timeout : float
            Seconds after which it is stopped.

        Raises
        ------
        InputError
            Where there is no such program.
        SkancfError
            Where it fails, with what it says.
        """
        threads, timeout = whole("threads", threads), positive("timeout", timeout, "s")
        program = shutil.which(text("ccx", ccx))
        if program is None:
            raise InputError(f"ccx = {ccx!r}: there is no such program; install CalculiX (on Debian: apt install "
                             "calculix-ccx), or run the deck elsewhere and read its .dat file with result()")  # fmt: skip
        self.path.with_suffix(".dat").unlink(missing_ok=True)
        try:
            done = subprocess.run(
                [program, "-i", self.path.stem], cwd=self.path.parent, capture_output=True, text=True, check=False,
                timeout=timeout, env={**os.environ, "OMP_NUM_THREADS": str(threads)},
            )  # fmt: skip
        except subprocess.TimeoutExpired as wrong:
            raise SkancfError(f"CalculiX on '{self.path}': stopped after {timeout:g} s; give a longer timeout") from wrong
        except OSError as wrong:
            raise SkancfError(f"CalculiX on '{self.path}': '{program}' cannot be run ({wrong.strerror})") from wrong
        if done.returncode or "*ERROR" in done.stdout:
            said = " ".join(done.stdout.split("*ERROR")[-1].split())[-300:]
            raise SkancfError(f"CalculiX on '{self.path}' failed: {said or done.stderr[-300:]}")
        return self.result()

    def result(self, path: AnyPath | None = None) -> "CalculixResult":
        """The answer in a ``.dat`` file, by default that beside the deck.

        Raises
        ------
        InputError
            For a file that is not there, is of another deck, or ends before the whole load.
        """
        file = self.path.with_suffix(".dat") if path is None else as_path("path", path)
        printed = read_calculix(file)
        if not np.array_equal(printed.nodes, np.arange(1, self.n_nodes + 1)):
            raise InputError(f"path = '{file}': has displacements of {len(printed.nodes)} nodes, and this deck has "
                             f"{self.n_nodes}; give the file of this deck")  # fmt: skip
        if abs(printed.time - 1.0) > SEVEN_DIGITS:
            raise InputError(f"path = '{file}': ends at {printed.time:.4g} of the load; look into CalculiX's .sta file, and "
                             "give a smaller increment=")  # fmt: skip
        return CalculixResult(self, printed.displacements)


@dataclass(frozen=True, eq=False)
class CalculixResult:
    """What CalculiX found.

    Attributes
    ----------
    deck : CalculixDeck
    displacements : (n_nodes, 3) array
        Of the nodes of the bricks (m), in the order of the deck.

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.02, sk.Isotropic(70e9, 0.3, 2700.0), [sk.Clamp("left")], [sk.Gravity()])
    >>> deck = sk.export.calculix(plate.on(sk.meshes.uniform(plate.surface, 4, 4)), "plate.inp")
    >>> moved = np.zeros((deck.n_nodes, 3))
    >>> moved[:, 2] = deck.bricks.points[:, 0] ** 2
    >>> sk.export.CalculixResult(deck, moved).displacement((0.6, 0.5)).round(3)
    array([0.  , 0.  , 0.36])
    """

    deck: CalculixDeck
    displacements: np.ndarray
    __repr__ = short

    def displacement(self, at: Any) -> np.ndarray:
        """Of the reference surface at points of the parameter plane, (2,) or (n, 2): (3,) or (n, 3) (m).

        Raises
        ------
        InputError
            For a point outside the surface.
        """
        places = np.atleast_2d(finite("at", at))
        if places.ndim != 2 or places.shape[1] != 2:
            raise InputError(f"at of shape {np.shape(at)}: give a point (x, y) of the parameter plane, or several, (n, 2)")
        elements, local = self.deck.bricks.system.geometry.locate_all(places.T)
        out = self.deck.bricks.at_points(elements, local[:, :, None]) @ self._of_lines()
        return np.asarray(out[0] if np.ndim(at) == 1 else out)

    def difference(self, solution: Any) -> float:
        """The largest distance between the displacements of a solution and these, over the largest of these, at all corners
        and middles of sides of the elements of the deck.

        Raises
        ------
        InputError
            For what is no solution.
        """
        found = solution_of("solution", solution)
        own = self._of_lines()
        apart = found.displacement(self.deck.bricks.at.T) - own
        largest = np.linalg.norm(own, axis=1).max()
        return float(np.linalg.norm(apart, axis=1).max() / largest) if largest else 0.0

    def _of_lines(self) -> np.ndarray:
        """Of the reference surface at each line, (n_lines, 3)."""
        return np.asarray(self.deck.bricks.weights[0] @ self.displacements)
