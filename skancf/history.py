"""Functions of time that multiply loads and prescribed displacements, and paths of loads that move."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, pi, sin
from types import NoneType
from typing import Any

import numpy as np

from skancf.arguments import choice, function, plain, text
from skancf.columns import columns
from skancf.equality import by_value
from skancf.errors import InputError, finite, number, positive, shown
from skancf.functions import called
from skancf.showing import short
from skancf.tolerances import ONE_TIME

History = Callable[[float], float]


def check_history(history: object) -> None:
    """InputError for a history that cannot be called."""
    if history is not None:
        function("history", history, "a function of time, as in history=lambda t: min(1.0, t / 0.1)")


def amplitude(history: History | None, time: float | None) -> float:
    """The factor at a time; without a history it is one, and without a time its attribute ``at_rest`` or one.

    Raises
    ------
    InputError
        Where the function is not finite.
    """
    if history is None or time is None:
        return float(getattr(history, "at_rest", 1.0))
    value = called("history", history, time)
    if isinstance(value, float) and isfinite(value):
        return float(value)
    try:
        return number("history", value)
    except InputError as wrong:
        raise InputError(f"history at t = {time} is {shown(value)}; a function of time must give one finite number over the "
                         "whole run") from wrong  # fmt: skip


def check_covers(histories: Iterable[Any], begin: float, end: float) -> None:
    """InputError where a function of time is a table that does not cover the times of a run (s)."""
    for history in histories:
        check_cover(history, begin, end)


def knots_of(histories: Iterable[Any]) -> list[float]:
    """Times, ascending, at which functions of time begin, end or bend, by their attribute ``knots`` (s)."""
    return sorted({float(t) for history in histories for t in getattr(history, "knots", ())})


@dataclass(frozen=True)
class Case:
    """When, and under how much of the loads, a system is asked.

    Attributes
    ----------
    factor : float
        Of all loads and prescribed motions.
    time : float or None
        In seconds. Statics has none: there every history counts with its full amplitude.

    Examples
    --------
    >>> sk.Case(0.5), sk.Case(time=0.1)
    (Case(factor=0.5, time=None), Case(factor=1.0, time=0.1))
    """

    factor: float = 1.0
    time: float | None = None

    def __post_init__(self) -> None:
        # Solvers make one for each evaluation, of numbers of their own.
        plain = type(self.factor) is float and type(self.time) in (float, NoneType)
        if plain and isfinite(self.factor + (self.time or 0.0)):
            return
        object.__setattr__(self, "factor", number("factor", self.factor))
        if self.time is not None:
            object.__setattr__(self, "time", number("time", self.time))

    def amplitude(self, history: History | None) -> float:
        """What a load with this history is multiplied by: its value at the time, see :func:`amplitude`, and the factor."""
        return self.factor * amplitude(history, self.time)


FULL = Case()
"""Statics under the whole load."""


def no_case(value: Any) -> InputError:
    """What is to be said of a value that stands where a case belongs."""
    factor = value if isinstance(value, int | float) else 0.5
    return InputError(f"case = {shown(value)}: give a Case, as in sk.Case({factor}), which has a load factor and a time")


def _moment(time: Any) -> float:
    """A time, checked; of a solver's own times it costs one call."""
    return time if type(time) is float and isfinite(time) else number("time", time)


def check_cover(history: Any, begin: float, end: float) -> None:
    """InputError where a function of time that has a range, its attribute ``span``, does not cover a run.

    Parameters
    ----------
    history
        Any; a function without ``span = (first, last)`` covers all times.
    begin, end : float
        Of the run (s).

    Examples
    --------
    >>> sk.history.check_cover(sk.Table((0.0, 1.0), (0.0, 1.0)), 0.0, 0.5)
    >>> try:
    ...     sk.history.check_cover(sk.Table((0.0, 1.0), (0.0, 1.0)), 0.0, 2.0)
    ... except sk.InputError as reason:
    ...     print(str(reason)[:60])
    Table from t = 0 to 1 s does not cover the run from t = 0 to
    """
    span = getattr(history, "span", None)
    if span is None:
        return
    first, last = span
    slack = ONE_TIME * (last - first)
    if begin < first - slack or end > last + slack:
        name = getattr(history, "name", type(history).__name__)
        raise InputError(f"{name} from t = {first:.6g} to {last:.6g} s does not cover the run from t = "
                         f"{begin:.6g} to {end:.6g} s; give it values over the whole run, or shorten the run")  # fmt: skip


DENSE = 200
"""Times of a table beyond which a run need not stop at each of them."""


class Tabulated:
    """What tables of time have in common; ``times`` is one of their fields."""

    times: Sequence[float]

    def _set_times(self) -> int:
        """Checks the times and makes a tuple of them; their number."""
        times = finite("times", self.times)
        if times.ndim != 1 or times.size < 2:
            raise InputError(f"times of shape {times.shape}: a table needs two times or more, in one row")
        wrong = np.flatnonzero(np.diff(times) <= 0)
        if wrong.size:
            k = int(wrong[0])
            raise InputError(f"times[{k}] = {times[k]}, times[{k + 1}] = {times[k + 1]}: times must ascend; for a jump "
                             "leave a short time between its two values")  # fmt: skip
        object.__setattr__(self, "times", tuple(times.tolist()))
        return int(times.size)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time (s)."""
        return self.times[0], self.times[-1]

    @property
    def knots(self) -> tuple[float, ...]:
        """Times at which a step ends (s): its own, unless it is as dense as a measurement."""
        return tuple(self.times) if len(self.times) <= DENSE else ()

    @cached_property
    def _times(self) -> np.ndarray:
        return np.array(self.times)

    def _inside(self, time: float) -> float:
        time, (first, last) = time if type(time) is float else number("time", time), self.span
        slack = ONE_TIME * (last - first)
        if not first - slack <= time <= last + slack:
            raise InputError(f"{type(self).__name__} at t = {time} s: its values are from t = {first} to {last} s; give it "
                             "values over the whole run")  # fmt: skip
        return float(min(max(time, first), last))


@by_value
@dataclass(frozen=True)
class Table(Tabulated):
    """A function of time given by values, for example measured ones.

    Parameters
    ----------
    times : sequence of float
        Ascending (s), at least two.
    values : sequence of float
        One for each time.
    kind : {"linear", "smooth"}
        Between the times: straight lines, or cubics with a continuous first derivative that overshoot nowhere (Fritsch and
        Butland 1984, SIAM Journal on Scientific and Statistical Computing 5, 300-304).

    Raises
    ------
    InputError
        For times that do not ascend, fewer than two, values that are not finite or not as many, and an unknown kind; when
        called, for a time outside the range.

    Examples
    --------
    >>> measured = sk.Table(times=(0.0, 0.1, 0.3), values=(0.0, 1.0, 0.5))
    >>> measured(0.2)
    0.75
    """

    times: Sequence[float]
    values: Sequence[float]
    kind: str = "linear"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        n, values = self._set_times(), finite("values", self.values)
        if values.shape != (n,):
            raise InputError(f"values of shape {values.shape}: give {n} numbers, one for each time")
        choice("kind", self.kind, ("linear", "smooth"))
        object.__setattr__(self, "values", tuple(values.tolist()))

    @classmethod
    def of(
        cls, table: Any, time: str = "time", value: str = "factor", kind: str = "linear"
    ) -> "Table":  # fmt: skip
        """The function of time in two columns of a table, or in a Series over its index.

        Parameters
        ----------
        table
            A DataFrame, a Series of pandas, a mapping from names to columns, a structured array, or the path of a ``.csv``
            file. Titles may have a unit, as in ``"time (s)"``.
        time, value : str
            Names of the two columns.
        kind : {"linear", "smooth"}

        Raises
        ------
        InputError
            For a missing column, an entry that is no finite number (its column and row are named), and for values that make
            no :class:`Table`.

        Examples
        --------
        >>> sk.Table.of({"time (s)": [0.0, 1.0, 2.0], "factor": [0.0, 1.0, 0.5]})(1.5)
        0.75
        """
        time, value = text("time", time), text("value", value)
        if hasattr(table, "index") and hasattr(table, "to_frame"):
            table = {time: np.asarray(table.index), value: np.asarray(table)}
        found = columns("table", table, (time, value))
        return cls(found[time].tolist(), found[value].tolist(), kind)

    @cached_property
    def _function(self) -> Callable[[float], Any]:
        values = np.array(self.values)
        if self.kind == "smooth":
            from scipy.interpolate import PchipInterpolator  # not at the top: few runs need it, and it is slow to load

            return PchipInterpolator(self._times, values)
        return lambda time: np.interp(time, self._times, values)

    def __call__(self, time: float) -> float:
        return float(self._function(self._inside(time)))


@by_value
@dataclass(frozen=True)
class Path(Tabulated):
    """A way in the parameter plane, straight from point to point; a load that moves follows it.

    Parameters
    ----------
    times : sequence of float
        Ascending (s), at least two.
    points : sequence of (x, y)
        Where it is at these times. It may begin and end outside the surface.

    Raises
    ------
    InputError
        For times that do not ascend, fewer than two, points that are not finite or not as many; when called, for a time
        outside the range.

    Examples
    --------
    >>> lane = sk.Path(times=(0.0, 2.0), points=[(0.0, 0.5), (10.0, 0.5)])
    >>> print(lane(1.0))
    [5.  0.5]
    """

    times: Sequence[float]
    points: Sequence[tuple[float, float]]

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        n, points = self._set_times(), finite("points", self.points)
        if points.shape != (n, 2):
            raise InputError(f"points of shape {points.shape}: give {n} points (x, y), one for each time")
        object.__setattr__(self, "points", tuple((x, y) for x, y in points.tolist()))

    @cached_property
    def _points(self) -> np.ndarray:
        return np.array(self.points).T

    def __call__(self, time: float) -> np.ndarray:
        inside = self._inside(time)
        return np.array([np.interp(inside, self._times, values) for values in self._points])


class Lasting:
    """What functions have in common that begin at a time and last; ``duration`` and ``start`` are among their fields."""

    duration: float
    start: float

    def __post_init__(self) -> None:
        plain(self)
        positive("duration", self.duration, "s")
        number("start", self.start)

    @property
    def knots(self) -> tuple[float, float]:
        """Times at which a step ends (s)."""
        return self.start, self.start + self.duration


@by_value
@dataclass(frozen=True)
class Ramp(Lasting):
    r"""Zero before ``start``, one after ``start + duration``, a straight line between: :math:`(t - t_0) / T`.

    Parameters
    ----------
    duration : float
        T (s).
    start : float
        :math:`t_0` (s).

    Raises
    ------
    InputError
        For a duration that is not positive, or a start that is not finite.

    Examples
    --------
    >>> ramp = sk.Ramp(duration=0.2, start=0.1)
    >>> ramp(0.1), ramp(0.2), ramp(1.0)
    (0.0, 0.5, 1.0)
    """

    duration: float
    start: float = 0.0

    __repr__ = short

    def __call__(self, time: float) -> float:
        return min(max((_moment(time) - self.start) / self.duration, 0.0), 1.0)


PULSES: dict[str, Callable[[float], float]] = {
    "sine": lambda s: sin(pi * s),
    "triangle": lambda s: 1.0 - abs(2 * s - 1.0),
    "rectangle": lambda s: 1.0,
}
"""Shapes over 0 < s < 1."""


@by_value
@dataclass(frozen=True)
class Pulse(Lasting):
    r"""A pulse of height one between ``start`` and ``start + duration``, zero elsewhere.

    With :math:`s = (t - t_0) / T` between 0 and 1 it is :math:`\sin \pi s`, :math:`1 - |2 s - 1|`, or one; its integral over
    time is :math:`2 T / \pi`, :math:`T / 2`, or T.

    Parameters
    ----------
    duration : float
        T (s).
    start : float
        :math:`t_0` (s).
    shape : {"sine", "triangle", "rectangle"}
        The rectangle jumps; it is one at ``start`` and zero at the end.

    Raises
    ------
    InputError
        For a duration that is not positive, a start that is not finite, and an unknown shape.

    Examples
    --------
    >>> tap = sk.Pulse(duration=0.01)
    >>> print(tap(0.005), tap(0.02))
    1.0 0.0
    """

    duration: float
    start: float = 0.0
    shape: str = "sine"

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        super().__post_init__()
        choice("shape", self.shape, PULSES)

    def __call__(self, time: float) -> float:
        s = (_moment(time) - self.start) / self.duration
        return PULSES[self.shape](s) if 0.0 <= s < 1.0 else 0.0
