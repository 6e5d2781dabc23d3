"""The largest and smallest values over the states of a path or a motion, and when they occur."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError, shown
from skancf.functions import measured
from skancf.lines import checked_points
from skancf.point_values import PointValues
from skancf.showing import short
from skancf.solution import Solution
from skancf.tabular import Column, Tabular

STATES = "a path, a motion, or states in a list"


@dataclass(frozen=True, eq=False)
class Envelope(Tabular):
    """Outcome of :func:`envelope`; a table, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    lowest, highest : (n,) or (n, ...) arrays
        Over all states.
    lowest_at, highest_at : arrays of the same shape
        The time, or in statics the load factor, of the first state in which they occur.
    lowest_state, highest_state : int arrays of the same shape
        Numbers of those states, from 0 on.
    unit : str
    points : (n, 2) array or None
        Places of the parameter plane.
    n_states : int

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> found = sk.envelope(sk.solve(system), "M11", at=[(0.5, 0.5), (0.0, 0.5)])
    >>> print(found.governing["place"])
    (0.0, 0.5)
    """

    lowest: np.ndarray
    highest: np.ndarray
    lowest_at: np.ndarray
    highest_at: np.ndarray
    lowest_state: np.ndarray
    highest_state: np.ndarray
    over: str
    unit: str = ""
    points: np.ndarray | None = None
    n_states: int = 0

    __repr__ = short

    @property
    def largest(self) -> np.ndarray:
        """The largest size at each place, signs left out."""
        return np.asarray(np.maximum(np.abs(self.lowest), np.abs(self.highest)))

    @property
    def governing(self) -> dict[str, Any]:
        """The value of the largest size of all, the time or load factor and the number of its state, its index, and its
        place where there are places."""
        index = tuple(int(k) for k in np.unravel_index(int(np.nanargmax(self.largest)), self.largest.shape))
        high = abs(self.highest[index]) >= abs(self.lowest[index])
        value, at, state = (
            (self.highest, self.highest_at, self.highest_state) if high else (self.lowest, self.lowest_at, self.lowest_state)
        )
        out: dict[str, Any] = {
            "value": float(value[index]), self.over: float(at[index]), "state": int(state[index]), "index": index,
        }  # fmt: skip
        return out if self.points is None else out | {"place": tuple(self.points[index[0]].tolist())}

    def _table(self) -> dict[str, Column]:
        n = self.lowest.size
        table: dict[str, Column] = {"index": (np.arange(n), "")}
        if self.points is not None and self.lowest.ndim == 1:
            table = {"x": (self.points[:, 0], ""), "y": (self.points[:, 1], "")}
        when = "s" if self.over == "time" else ""
        return table | {
            "lowest": (self.lowest.ravel(), self.unit), f"lowest_{self.over}": (self.lowest_at.ravel(), when),
            "highest": (self.highest.ravel(), self.unit), f"highest_{self.over}": (self.highest_at.ravel(), when),
        }  # fmt: skip


def states_in(states: Any) -> Iterator[Solution]:
    """The states of a path, a motion, a static result or a list, one after the other.

    Raises
    ------
    InputError
        For what has none.
    """
    inner = next((getattr(states, name) for name in ("states", "solutions", "path") if hasattr(states, name)), states)
    if isinstance(inner, Solution):
        inner = (inner,)
    if isinstance(inner, str | bytes | np.ndarray | type) or not isinstance(inner, Iterable):
        raise InputError(f"states = {shown(states)}: give {STATES}")
    for k, state in enumerate(inner):
        if not isinstance(state, Solution):
            raise InputError(f"states[{k}] = {shown(state)}: is no Solution; give {STATES}")
        yield state


def envelope(states: Any, quantity: str | Callable[[Solution], Any], *, at: Any = None) -> Envelope:
    """The largest and the smallest value of a quantity over states, and when each occurs.

    States are taken one after the other: of a long motion no more than one is kept.

    Parameters
    ----------
    states : PathResult, StaticResult, Motion or iterable of Solution
    quantity : str or function of a Solution
        A column of :meth:`~skancf.Solution.at`, such as ``"mises_top"``, ``"M11"``, ``"u3"``; or a function that gives a
        number or an array, of one shape in all states.
    at : (2,) or (n, 2) numbers, optional
        Points of the parameter plane for a column. Default: the nodes of the mesh.

    Returns
    -------
    Envelope

    Raises
    ------
    InputError
        For no states at all, an unknown column, and values of another shape, as on meshes that change: then give ``at``.

    Examples
    --------
    >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.3, 7800), [sk.Clamp("left")],
    ...                    [sk.EdgeLoad("right", (0, 0, 100.0))])
    >>> result = sk.solve(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
    >>> found = sk.envelope(result, "M11", at=[(0.0, 0.1), (0.5, 0.1)])
    >>> found.governing["place"], found.governing["load_factor"]
    ((0.0, 0.1), 1.0)
    """
    if not (isinstance(quantity, str) or (callable(quantity) and not isinstance(quantity, type))):
        raise InputError(
            f"quantity = {shown(quantity)}: give the name of a column, such as 'M11', or a function of a Solution"
        )
    if at is not None and not isinstance(quantity, str):
        raise InputError("at: places are for columns, and this quantity is a function of a Solution; let it take its own")
    kept: _Extremes | None = None
    points, unit = None, ""
    for state in states_in(states):
        if isinstance(quantity, str):
            places = state.system.mesh.p.T if at is None else checked_points(state.system, at, "at")
            values = PointValues(state, places)
            found, unit = values[values._known(quantity, "quantity")], values.unit(quantity)
            points = places if points is None else points
        else:
            found = np.asarray(measured("quantity", quantity, state), dtype=float)
        kept = kept or _Extremes(found.shape, "load_factor" if state.time is None else "time")
        kept.take(found, state.load_factor if state.time is None else state.time)
    if kept is None:
        raise InputError("states: there are none; give " + STATES)
    (low, high), (low_at, high_at), (first, second) = kept.values, kept.when, kept.state
    return Envelope(low, high, low_at, high_at, first, second, kept.over, unit, points, kept.n)


class _Extremes:
    """The lowest and highest values so far."""

    def __init__(self, shape: tuple[int, ...], over: str) -> None:
        self.over, self.n = over, 0
        self.values = [np.full(shape, np.nan), np.full(shape, np.nan)]
        self.when = [np.full(shape, np.nan), np.full(shape, np.nan)]
        self.state = [np.full(shape, -1), np.full(shape, -1)]

    def take(self, found: np.ndarray, when: float) -> None:
        if found.shape != self.values[0].shape:
            raise InputError(
                f"quantity: states have values of shape {self.values[0].shape} and {found.shape}, as on "
                "meshes that differ; give places, at=[(x, y), ...], or a function whose values have one shape"
            )
        for k, sign in enumerate((-1.0, 1.0)):
            better = (sign * found > sign * self.values[k]) | (np.isnan(self.values[k]) & ~np.isnan(found))
            for kept, new in ((self.values, found), (self.when, when), (self.state, self.n)):
                kept[k] = np.where(better, new, kept[k])
        self.n += 1
