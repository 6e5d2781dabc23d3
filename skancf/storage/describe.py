"""Objects as tables of numbers and texts, as TOML and JSON have them, and back.

An object is a table with its class as ``type`` and its arguments by name; None is left out. No text is ever evaluated.
"""

import difflib
from collections.abc import Callable, Container, Mapping
from functools import partial
from inspect import Parameter, signature
from math import isfinite
from typing import Any

import numpy as np

from skancf.errors import InputError, shown
from skancf.storage.registry import DESCRIBED, KINDS, class_named, fields_of, kind_of

Keep = Callable[[Any, str, Any], Any]
"""What is kept instead of something that is no table: of the object that has it, the field's name, and its value."""

DEFAULT_TYPES = {"layers": "Layer", "zones": "Zone", "damping": "Damping"}
"""What a table is that says no ``type``, by the argument in which it stands."""
NAMED = {"material": "materials", "history": "histories"}
"""Arguments that may be the name of a table in one of the tables of this name."""
ROOMS = {"surface": "surfaces", "supports": "supports", "loads": "loads", "material": "materials", "history": "history",
         "conditions": "conditions", "theory": "theories"}  # fmt: skip
CHOICES = {name: DESCRIBED[room] for name, room in ROOMS.items()}
"""Classes that messages name for an argument."""
MOST_NAMES = 20
"""Of classes or arguments in a message."""
ARRAY, FLOAT = "array", "float"


def refuse(owner: Any, name: str, value: Any) -> Any:
    """InputError for what cannot be kept."""
    where = f"{type(owner).__name__}.{name}" if owner is not None else name
    what = "a function" if callable(value) else f"a {type(value).__name__} of your own"
    raise InputError(f"{where} = {shown(value)}: {what}, and only numbers and texts are kept in files; give numbers or an "
                     "object of this library, such as a Table for a function of time, or save the arrays of a result by "
                     "save(result, path, what='arrays')")  # fmt: skip


def describe(value: Any, keep: Keep = refuse, owner: Any = None, name: str = "value") -> Any:
    """A value as tables, lists, numbers and texts.

    Parameters
    ----------
    value
        Of a class of :data:`~skancf.storage.registry.DESCRIBED`, an array, a number, a text, or lists of these.
    keep : callable
        Asked for what takes the place of anything else.

    Raises
    ------
    InputError
        For a function, or an object of another class.
    """
    again = partial(describe, keep=keep)
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if isfinite(value) else {FLOAT: str(value)}
    if isinstance(value, np.generic):
        return again(value.item(), owner=owner, name=name)
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
        return {ARRAY: value.tolist(), "dtype": value.dtype.str.lstrip("<>|=")}
    if isinstance(value, list | tuple):
        return [again(item, owner=owner, name=name) for item in value]
    kind = kind_of(value, KINDS)
    if kind is None:
        return again(keep(owner, name, value), owner=owner, name=name)
    table = {field: again(getattr(value, field), owner=value, name=field) for field in fields_of(type(value))}
    return {"type": kind} | {field: part for field, part in table.items() if part is not None}


def build(table: Any, where: str, named: Mapping[str, Any] | None = None, name: str = "") -> Any:
    """The value of which :func:`describe` made a table, or that a user wrote as one.

    Parameters
    ----------
    table
        Tables as dicts, lists, numbers and texts.
    where : str
        As messages call its place.
    named : mapping, optional
        Tables ``materials`` and ``histories``, to which arguments may refer by name.
    name : str
        Of the argument.

    Raises
    ------
    InputError
        For unknown classes and arguments, with the nearest that there is, and what classes say of their arguments; the place
        is told.
    """
    named = named or {}
    if isinstance(table, str) and table in named.get(NAMED.get(name, ""), {}):
        return build(named[NAMED[name]][table], f"{NAMED[name]}.{table}", named, name)
    if isinstance(table, list | tuple):
        return tuple(build(item, f"{where}[{k}]", named, name) for k, item in enumerate(table))
    if not isinstance(table, Mapping):
        if table is None or isinstance(table, bool | int | float | str):
            return table
        raise InputError(f"{where} = {shown(table)}: give a number, a text, a list or a table")
    if table.keys() == {FLOAT}:
        return float(table[FLOAT])
    if table.keys() == {ARRAY, "dtype"}:
        return np.array(table[ARRAY], dtype=table["dtype"])
    kind = table.get("type", DEFAULT_TYPES.get(name))
    choices = CHOICES.get(name, KINDS)
    if kind is None:
        some = ", ".join(sorted(choices)[:MOST_NAMES])
        raise InputError(f"{where}: this table has no type; give its class, such as {some}")
    if kind not in KINDS:
        known("type", kind, choices, where)
    return made(class_named(kind), {key: item for key, item in table.items() if key != "type"}, f"{where} ({kind})", named)


def made(function: Callable[..., Any], table: Mapping[str, Any], where: str, named: Mapping[str, Any]) -> Any:
    """A class called with what stands in a table."""
    return told(where, function, arguments(function, table, where, named))


def arguments(
    function: Callable[..., Any], table: Mapping[str, Any], where: str, named: Mapping[str, Any],
    given: Container[str] = (), more: tuple[str, ...] = (),
) -> dict[str, Any]:  # fmt: skip
    """Arguments of a class or a function, as they stand in a table, but for those that are ``given`` otherwise; keys that
    are no arguments stand in ``more``."""
    wanted = {name: each for name, each in signature(function).parameters.items() if name not in given}
    for key in table:
        known("key", key, [*wanted, *more], where)
    missing = [name for name, each in wanted.items() if each.default is Parameter.empty and name not in table]
    if missing:
        raise InputError(f"{where}: {missing[0]} is missing; it takes {', '.join(wanted)}")
    return {key: build(item, f"{where}.{key}", named, key) for key, item in table.items()}


def told(where: str, function: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """What a call returns; what it says of its arguments, with the place where they stand."""
    try:
        return function(**values)
    except InputError as wrong:
        raise InputError(f"{where}: {wrong}") from wrong
    except (TypeError, ValueError, AttributeError, KeyError, IndexError) as wrong:
        raise InputError(f"{where}: these values do not fit together ({wrong})") from wrong


def known(what: str, key: Any, names: Any, where: str) -> str:
    """``key``, which must be among some names; else the nearest of them is told."""
    if isinstance(key, str) and key in names:
        return key
    near = difflib.get_close_matches(str(key), list(names), 1, 0.5) or [
        name for name in names if str(name).lower() == str(key).lower()
    ]
    hint = f"do you mean '{near[0]}'? " if near else ""
    every = sorted(map(str, names))
    there = f"There is {', '.join(every)}" if len(every) <= MOST_NAMES else "The page of public names has all"
    raise InputError(f"{where}: unknown {what} {shown(key)}; {hint}{there}")
