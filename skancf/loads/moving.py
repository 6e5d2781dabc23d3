"""Forces that move over the surface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, shown, vector
from skancf.functions import called, is_function
from skancf.history import Case, History, check_history
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity
from skancf.loads.acting import Acting, Spread, check_distributed
from skancf.loads.edge import along_line, on_line
from skancf.showing import short
from skancf.terms.protocols import Assembly

Place = Callable[[float], Any]
"""A point (x, y) of the parameter plane as a function of time."""
Found = tuple[np.ndarray, Spread]
"""Parameters (2, n) where a load acts, and its forces."""


@by_value
@dataclass(frozen=True)
class MovingForce:
    """A dead force (N) at a point that moves over the surface: a wheel, a drop that runs down.

    Its place is prescribed and its mass none. Where the path is outside the surface there is no force: it comes on and goes
    off at the edge. In statics it stands where it is at t = 0.

    Parameters
    ----------
    path : callable
        A function of time (s) that returns the point (x, y) of the parameter plane, for example a :class:`Path`. Closed
        parameters may run on beyond their bounds, round and round.
    force : (3,)
    history : callable, optional
        Factor as a function of time.

    Raises
    ------
    InputError
        For a path that is no function or a force that is not three numbers; when it acts, for a point that is not two finite
        numbers.

    Notes
    -----
    In theory `kirchhoff` the nodal forces and their rates are continuous in time where the point crosses from one element to
    the next; in theory `full` the forces are.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> wheel = sk.MovingForce(sk.Path((0.0, 0.1), [(0.0, 0.05), (1.0, 0.05)]), (0.0, 0.0, -10.0))
    >>> bridge = sk.Problem(sk.Rectangle(1.0, 0.1), 0.005, steel, [sk.Pin("left"), sk.Pin("right")], [wheel])
    >>> system = bridge.on(sk.meshes.uniform(bridge.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.1, rtol=0.05, progress=False)
    >>> print(motion.status.value)
    finished
    """

    path: Place
    force: tuple[float, float, float]
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_history(self.history)
        vector("force", self.force, 3)
        if not is_function(self.path):
            raise InputError(f"path = {shown(self.path)}: give a function of time that returns (x, y), for example a Path; "
                             "a force that stands still is a PointForce")  # fmt: skip

    def on(self, assembly: Assembly) -> "Moving":
        geometry, force = assembly.geometry, np.asarray(self.force, float)

        def find(time: float) -> Found:
            at = geometry.within(_point("path", self.path, time)[:, None])
            inside, elements, local = geometry.locate_inside(at)
            forces = np.zeros((len(elements), 2, 3, 1))
            forces[:, 0, :, 0] = force
            return at[:, inside], Spread(elements, local[:, :, None], forces)

        def singular(time: float) -> list[Singularity]:
            return [Singularity("force", find(time)[0], "a MovingForce", force, moves=True)]

        return Moving(geometry, find, singular, self.history, [self.path])


@by_value
@dataclass(frozen=True)
class MovingLine:
    """A dead force per undeformed length (N/m) along a straight line of the parameter plane, whose ends move.

    As :class:`LineLoad` at each time, and as :class:`MovingForce` where it leaves the surface: its part inside acts. In
    statics it stands where it is at t = 0.

    Parameters
    ----------
    start, end : callable or (2,)
        Functions of time (s) that return points (x, y) of the parameter plane, for example a :class:`Path`; an end that
        stands still is a point.
    force : (3,) or callable
        Constant, or a function of the parameters (x, y) that returns (3, ...).
    history : callable, optional
        Factor as a function of time.

    Raises
    ------
    InputError
        For ends that are neither functions nor points, and what :class:`LineLoad` refuses.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> start, end = (sk.Path((0.0, 0.1), [(0.0, y), (1.0, y)]) for y in (0.0, 0.1))
    >>> axle = sk.MovingLine(start, end, (0.0, 0.0, -100.0))
    >>> bridge = sk.Problem(sk.Rectangle(1.0, 0.1), 0.005, steel, [sk.Pin("left"), sk.Pin("right")], [axle])
    """

    start: Any
    end: Any
    force: Any
    history: History | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        check_distributed(self.force, self.history)
        for name in ("start", "end"):
            place = getattr(self, name)
            if not is_function(place):
                vector(f"{name}, neither a function of time nor a point:", place, 2)

    def on(self, assembly: Assembly) -> "Moving":
        geometry = assembly.geometry

        def ends(time: float) -> tuple[np.ndarray, np.ndarray]:
            return _point("start", self.start, time), _point("end", self.end, time)

        def find(time: float) -> Found:
            at, spread = on_line(geometry, *ends(time), self.force, leave=True)
            return at.reshape(2, -1), spread

        def singular(time: float) -> list[Singularity]:
            return [along_line(geometry, *ends(time), "a MovingLine", moves=True)]

        return Moving(geometry, find, singular, self.history, [self.start, self.end])


def _point(name: str, place: Any, time: float) -> np.ndarray:
    return vector(f"{name} at t = {time}", called(name, place, time) if is_function(place) else place, 2)


class Moving(Acting):
    """A load whose forces are found anew at each time; those of the last one are kept, for the iterations of a step."""

    def __init__(
        self, geometry: Geometry, find: Callable[[float], Found], singular: Callable[[float], list[Singularity]],
        history: History | None, paths: list[Any],
    ):  # fmt: skip
        self.geometry, self.find, self.singular, self.history, self.paths = geometry, find, singular, history, paths
        self._last: tuple[Case, np.ndarray] | None = None

    def histories(self) -> list[Any]:
        return [self.history, *self.paths]

    def force(self, q: np.ndarray, case: Case) -> np.ndarray:
        if self._last is None or self._last[0] != case:
            _, spread = self.find(case.time or 0.0)
            nodal = spread.nodal(self.geometry) if len(spread.elements) else np.zeros_like(self.geometry.undeformed)
            nodal *= case.amplitude(self.history)
            nodal.flags.writeable = False  # it is given away more than once
            self._last = case, nodal
        return self._last[1]

    def singularities(self, case: Case) -> list[Singularity]:
        return self.singular(case.time or 0.0)

    def places(self, case: Case) -> np.ndarray:
        return self.find(case.time or 0.0)[0]
