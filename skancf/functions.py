"""What a user's own functions of place and time return, checked."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from skancf.errors import InputError, SkancfError, finite, shown

ONE_POINT = (TypeError, ValueError)
"""What functions of numbers, such as ``math.sin`` or ``1.0 if x > 0 else 0.0``, raise when they are given arrays."""

WORDS = {2: "two", 3: "three"}


def is_function(value: Any) -> bool:
    """Whether a value is to be called; a class does not count as a function of the user."""
    return callable(value) and not isinstance(value, type)


def is_ours(value: Any) -> bool:
    """Whether a value is of a class of this library, which checked itself when it was made."""
    return type(value).__module__.split(".")[0] == __package__


class Noted:
    """What a user's function raises within passes through, with a note that names the argument.

    Errors of this library name what is wrong themselves, and those in ``but`` pass as they are. StopIteration becomes a
    RuntimeError: it would end a generator around the call without a word.
    """

    def __init__(self, name: str, but: tuple[type[Exception], ...] = ()):
        self.name, self.but = name, but

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, wrong: BaseException | None, trace: Any) -> None:
        if not isinstance(wrong, Exception) or isinstance(wrong, (SkancfError, *self.but)):
            return
        note = f"raised by the function given as {self.name}"
        if isinstance(wrong, StopIteration):
            stopped = RuntimeError(f"StopIteration({wrong.value!r})")
            _add_note(stopped, note)
            raise stopped from wrong
        _add_note(wrong, note)


def _add_note(error: BaseException, note: str) -> None:
    """What ``error.add_note`` does, which Python 3.10 has not: there the note is kept, and its tracebacks do not show it."""
    error.__notes__ = [*getattr(error, "__notes__", ()), note]


def called(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """What a user's function returns; what it raises passes through with a note that names the argument.

    Arrays are given as copies, so that a function that changes them in place changes nothing else.
    """
    with Noted(name):
        return function(*_own(arguments))


def measured(name: str, function: Callable[..., Any], state: Any) -> Any:
    """What a user's function finds in a state: numbers, in an array of any shape.

    Raises
    ------
    InputError
        For anything else, such as None of a function that forgets to return. What the function itself raises passes through
        with a note.
    """
    value = called(name, function, state)
    try:
        kind = np.asarray(value).dtype.kind
    except Exception:
        kind = "O"  # ragged
    if kind not in "biufc":
        raise InputError(f"{name}: the function returned {shown(value)}; it must return a number, or an array of numbers")
    return value


def _own(arguments: Iterable[Any]) -> list[Any]:
    return [each.copy() if isinstance(each, np.ndarray) else each for each in arguments]


def true_at(name: str, function: Callable[..., Any], at: np.ndarray) -> np.ndarray:
    """Where a user's function of place is true, of points (2, n): (n,) bool.

    Truth values will do, and whole numbers; a function that cannot take arrays is called point by point.

    Raises
    ------
    InputError
        For other values, and another number of them. What the function itself raises passes through with a note.
    """
    try:
        with Noted(name, but=ONE_POINT):
            found = function(*_own(at))
    except ONE_POINT as wrong:
        found = [_at_one(name, function, point, wrong) for point in at.T.tolist()]
    try:
        array = np.asarray(found)
    except ValueError:
        array = np.array(None)  # ragged
    whole = array.dtype.kind in "biu" or (array.dtype.kind == "f" and bool(np.isin(array, (0.0, 1.0)).all()))
    if not whole or array.shape not in ((), at.shape[1:]):
        raise InputError(f"{name}: the function of (x, y) returned {shown(found)}; it must return True or False for each "
                         f"point, here {at.shape[1:]}, as in lambda x, y: abs(x) < 1e-9")  # fmt: skip
    return np.broadcast_to(array.astype(bool), at.shape[1:])


def values_at(name: str, given: Any, at: np.ndarray, components: int | None = None) -> np.ndarray:
    """A constant or a user's function of place at points.

    A function that cannot take arrays is called point by point. Of the components that it returns, some may be constants.

    Parameters
    ----------
    name : str
        The argument, as messages call it.
    given : callable, number or (components,)
        A function of the coordinates, or a constant.
    at : (n_coordinates, ...) array
    components : int, optional
        Of a vector; without it the values are numbers.

    Returns
    -------
    (components, ...) or (...) array
        As many values as there are points.

    Raises
    ------
    InputError
        For values that are not finite numbers, or of a shape that is not that of the points. What the function itself raises
        passes through with a note that names the argument.
    """
    points = at.shape[1:]
    if not is_function(given):
        return _spread(name, given, points, components)
    try:
        with Noted(name, but=ONE_POINT):
            found = given(*_own(at))
    except ONE_POINT as wrong:
        return _point_by_point(name, given, at, components, wrong)
    return _spread(name, found, points, components)


def _point_by_point(
    name: str, function: Callable[..., Any], at: np.ndarray, components: int | None, first: Exception
) -> np.ndarray:
    found = [_at_one(name, function, point, first) for point in at.reshape(len(at), -1).T.tolist()]
    size = () if components is None else (components,)
    values = [_spread(name, value, (), components) for value in found]
    return np.array(values).reshape(-1, *size).T.reshape(*size, *at.shape[1:])


def _at_one(name: str, function: Callable[..., Any], point: Sequence[float], first: Exception) -> Any:
    """The function called with numbers; if it fails again, the first exception tells why."""
    try:
        with Noted(name):
            return function(*point)
    except Exception as wrong:
        raise wrong from first


def _spread(name: str, value: Any, points: tuple[int, ...], components: int | None) -> np.ndarray:
    if components is None:
        return _filled(name, value, points, points, None)
    if isinstance(value, Sequence) and not isinstance(value, str | bytes | bytearray) and len(value) == components:
        return np.stack([_filled(name, part, points, points, components) for part in value])
    array, wanted = _numbers(name, value), (components, *points)
    if array.shape == (components,):
        array = array.reshape(components, *[1] * len(points))
    elif array.shape[:1] != (components,) or array.ndim != len(wanted):
        raise _wrong_shape(name, array.shape, points, components)
    return _filled(name, array, wanted, points, components)


def _filled(name: str, value: Any, shape: tuple[int, ...], points: tuple[int, ...], components: int | None) -> np.ndarray:
    array = _numbers(name, value)
    try:
        return np.broadcast_to(array, shape)
    except ValueError as wrong:
        raise _wrong_shape(name, array.shape, points, components) from wrong


def _wrong_shape(name: str, shape: tuple[int, ...], points: tuple[int, ...], components: int | None) -> InputError:
    if components is None:
        wanted = f"{points}, one for each point" if points else "one for one point"
        return InputError(f"{name} of shape {shape}: give one number; a function of (x, y) must return {wanted}")
    number = WORDS.get(components, str(components))
    return InputError(f"{name} of shape {shape}: give {number} numbers; a function of (x, y) must return {number} "
                      f"components first, {(components, *points)}")  # fmt: skip


def _numbers(name: str, value: Any) -> np.ndarray:
    """Finite numbers; strings, which numpy would read, complex numbers and None are refused."""
    try:
        kind = np.asarray(value).dtype.kind
    except ValueError:
        kind = "f"  # ragged: finite() names it
    if kind not in "biufO" or value is None:
        shown = f"= {value!r}" if np.ndim(value) == 0 else f"has entries such as {np.ravel(value)[0]!r}"
        raise InputError(f"{name} {shown}: not a number; give finite numbers, or a function of (x, y) that returns them")
    return finite(name, value)
