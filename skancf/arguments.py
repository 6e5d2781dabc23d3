"""Arguments of public functions, checked before any work: what they must be, what was given, and what to give instead."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import fields
from decimal import Decimal
from numbers import Integral, Real
from typing import Any, TypeVar

import numpy as np

from skancf.errors import InputError, finite, number, shown

T = TypeVar("T")

SYSTEM = "a system, as problem.on(mesh) makes it"
STATE = "a Solution, for example sk.solve(system).solution or motion.at(time)"
MESH = "a skfem.MeshQuad, as sk.meshes.uniform(surface, 8, 8) makes it"
PROBLEM = "a Problem, as in sk.Problem(surface, thickness, material, supports, loads)"
SURFACE = "a surface, for example sk.Rectangle(1.0, 1.0)"

PARTS = ("solution", "state", "system", "problem", "mesh", "surface")
"""Attributes in which a value of one kind may hold what was meant."""


def instance(name: str, value: Any, kind: type[T] | tuple[type[T], ...], example: str) -> T:
    """``value``, which must be of a kind; ``example`` says what to give."""
    if isinstance(value, kind):
        return value
    raise InputError(f"{name} = {shown(value)}: give {example}{_hint(value, kind)}")


def _hint(value: Any, kind: Any) -> str:
    """Where in a value of another kind the right one is."""
    if isinstance(value, type):
        return f"; this is the class {value.__name__}, not one of its objects"
    for part in PARTS if kind else ("system",):
        try:
            held = getattr(value, part, None)
        except Exception:
            continue  # such as a motion on several meshes, which has no one system
        if isinstance(held, kind) or (not kind and hasattr(held, "pattern")):
            return f"; this {type(value).__name__} has one as its .{part}"
    return f", not a {type(value).__name__}"


def having(name: str, value: Any, methods: Sequence[str], example: str) -> None:
    """InputError for a class, and for what has not these methods or attributes."""
    if isinstance(value, type) or not all(hasattr(value, method) for method in methods):
        raise InputError(f"{name} = {shown(value)}: give {example}")


MOST = 10**15
"""Largest whole number of anything."""


def whole(name: str, value: Any, least: int = 1, most: int | None = None, floats: bool = False) -> int:
    """``value`` as an integer from ``least`` on, up to ``most`` if there is such; with ``floats`` 6.0 is one, True never."""
    rule = f"give a whole number of at least {least}" + ("" if most is None else f" and at most {most}")
    refused: tuple[type, ...] = (bool, np.bool_) if floats else (bool, np.bool_, float, np.floating)
    if isinstance(value, refused):
        raise InputError(f"{name} = {shown(value)}: {rule}")
    if type(value) is not int:
        try:
            checked = number(name, value)
        except InputError as wrong:
            raise InputError(f"{name} = {shown(value)}: {rule}") from wrong
        if checked != int(checked):
            raise InputError(f"{name} = {value}: {rule}")
        value = int(value)
    if not least <= value <= (MOST if most is None else most):
        raise InputError(f"{name} = {shown(value)}: {rule}")
    return int(value)


def plain(made: Any) -> None:
    """Numbers in the fields of a dataclass as floats and integers of Python, which all else can compute with.

    Decimals and fractions are numbers, but numpy's functions take none, and its short kinds overflow. What is no number
    stays as it is, for the checks to name.
    """
    for part in (part for part in fields(made) if part.init):
        value = getattr(made, part.name)
        found = _plain(value)
        if found is not value:
            object.__setattr__(made, part.name, found)


DEEP = 2
"""Lists of lists in which numbers are looked for, as in bounds."""


def _plain(value: Any, depth: int = DEEP) -> Any:
    if type(value) in (int, float, bool) or isinstance(value, np.bool_):
        return value
    if isinstance(value, Real | Decimal):
        try:
            return int(value) if isinstance(value, Integral) else float(value)
        except (OverflowError, ValueError):
            return value
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.dtype != float and not np.ma.isMA(value):
        value = value.astype(float)
    if isinstance(value, np.ndarray) and value.dtype == float and not value.ndim and not np.ma.isMA(value):
        return float(value)
    if type(value) in (list, tuple) and depth:
        items = [_plain(item, depth - 1) for item in value]
        if any(one is not two for one, two in zip(items, value, strict=True)):
            return type(value)(items)
    return value


def function(name: str, value: Any, example: str) -> Callable[..., Any]:
    """``value``, which must be callable."""
    if not callable(value) or isinstance(value, type):
        raise InputError(f"{name} = {shown(value)}: give {example}")
    return value


def choice(name: str, value: Any, choices: Collection[Any]) -> None:
    """InputError for what is not one of some names."""
    if not (value is None or isinstance(value, str)) or value not in choices:
        *names, last = [repr(each) for each in choices]
        which = f"one of {', '.join(names)} or {last}" if names else last
        raise InputError(f"{name} = {shown(value)}: choose {which}")


def flag(name: str, value: Any) -> bool:
    """``value`` as True or False."""
    if not isinstance(value, bool | np.bool_) and not (isinstance(value, int) and value in (0, 1)):
        raise InputError(f"{name} = {shown(value)}: give True or False")
    return bool(value)


def text(name: str, value: Any) -> str:
    """``value``, which must be a string."""
    if not isinstance(value, str):
        raise InputError(f"{name} = {shown(value)}: give a text")
    try:
        value.encode()
    except UnicodeEncodeError as wrong:
        raise InputError(f"{name} = {shown(value)}: has characters that cannot be written ({wrong.reason}); leave them out"
                         ) from wrong  # fmt: skip
    return value


def texts(**values: Any) -> None:
    """InputError for what is no string; None will do."""
    for name, value in values.items():
        if value is not None:
            text(name, value)


def row(name: str, values: Any) -> np.ndarray:
    """``values`` as finite floats in one row, (n,)."""
    array = finite(name, values)
    if array.ndim != 1:
        raise InputError(f"{name} of shape {array.shape}: give a list of numbers")
    return array


def system_like(value: Any) -> None:
    """InputError for what solvers cannot take as a system."""
    if isinstance(value, type) or not all(hasattr(value, name) for name in ("undeformed", "constraints", "pattern")):
        instance("system", value, (), SYSTEM)


def sequence(name: str, value: Any, kind: Any, example: str) -> tuple[Any, ...]:
    """The items of ``value``, each of a kind; an array or generator will do."""
    if isinstance(value, str | bytes | Mapping | type):
        raise InputError(f"{name} = {shown(value)}: give a list of {example}")
    try:
        items = tuple(value)
    except TypeError as wrong:
        raise InputError(f"{name} = {shown(value)}: give a list of {example}") from wrong
    for k, item in enumerate(items):
        if not isinstance(item, kind):
            raise InputError(f"{name}[{k}] = {shown(item)}: is no {kind.__name__}; give {example}{_hint(item, kind)}")
    return items


def mapping(name: str, value: Any, example: str) -> Mapping[Any, Any]:
    """``value``, which must be a mapping."""
    if not isinstance(value, Mapping):
        raise InputError(f"{name} = {shown(value)}: give {example}")
    return value
