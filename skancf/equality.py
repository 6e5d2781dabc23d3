"""Equality by value: of objects whose fields may be arrays, functions or further objects."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any, TypeVar

import numpy as np
import skfem

T = TypeVar("T")


def by_value(cls: type[T]) -> type[T]:
    """A dataclass whose objects are equal where all their fields are, arrays included, and which can be pickled after use.

    What an object has computed and kept (its cached properties) takes no part in either: it is computed again.

    Examples
    --------
    >>> sk.Gravity(np.array([0.0, 0.0, -9.81])) == sk.Gravity((0.0, 0.0, -9.81))
    True
    """

    names = [part.name for part in fields(cls)]  # type: ignore[arg-type]

    def equal(self: Any, other: object) -> Any:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return all(same(getattr(self, name), getattr(other, name)) for name in names)

    def number(self: Any) -> int:
        return hash((type(self), *(_hashed(getattr(self, name)) for name in names)))

    def state(self: Any) -> dict[str, Any]:
        return {name: getattr(self, name) for name in names}

    methods: dict[str, Callable[..., Any]] = {"__eq__": equal, "__hash__": number, "__getstate__": state}
    for name, method in methods.items():
        method.__name__, method.__qualname__ = name, f"{cls.__qualname__}.{name}"
        setattr(cls, name, method)
    return cls


def same(one: Any, two: Any) -> bool:
    """Whether two values describe the same: arrays and lists by their entries, numbers that are none like one another."""
    if one is two:
        return True
    if isinstance(one, skfem.Mesh) and isinstance(two, skfem.Mesh):
        return same_mesh(one, two)
    if _is_array(one) or _is_array(two):
        return _same_entries(one, two)
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(same(one[key], two[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(two, list | tuple):
        return len(one) == len(two) and all(same(a, b) for a, b in zip(one, two, strict=True))
    if isinstance(one, partial) and isinstance(two, partial):
        return same((one.func, one.args, one.keywords), (two.func, two.args, two.keywords))
    if isinstance(one, float) and isinstance(two, float):
        return one == two or (one != one and two != two)
    try:
        return bool(one == two)
    except Exception:  # of a class of the user's own, whose objects cannot be compared
        return False


def same_mesh(one: skfem.Mesh, two: skfem.Mesh) -> bool:
    """Whether two meshes have the same points, elements and names, and the same tree."""
    cells = [getattr(getattr(mesh, "leaves", None), "cells", None) for mesh in (one, two)]
    return (
        type(one) is type(two)
        and np.array_equal(one.p, two.p) and np.array_equal(one.t, two.t)
        and same(one.boundaries or {}, two.boundaries or {}) and same(one.subdomains or {}, two.subdomains or {})
        and same(*cells)
    )  # fmt: skip


def _is_array(value: Any) -> bool:
    return isinstance(value, np.ndarray) or (hasattr(value, "__array__") and hasattr(value, "dtype"))


def _same_entries(one: Any, two: Any) -> bool:
    if any(value is None or isinstance(value, str) or callable(value) for value in (one, two)):
        return False
    try:
        first, second = np.asarray(one), np.asarray(two)
    except ValueError:  # ragged
        return False
    if first.shape != second.shape or not same(getattr(one, "ori", None), getattr(two, "ori", None)):
        return False
    if first.dtype.hasobject or second.dtype.hasobject:
        return all(same(a, b) for a, b in zip(first.ravel(), second.ravel(), strict=True))
    numbers = first.dtype.kind in "fc" and second.dtype.kind in "fc"
    return bool(np.array_equal(first, second, equal_nan=numbers))


def _hashed(value: Any) -> int:
    """Equal for equal values."""
    if isinstance(value, np.ndarray | list | tuple):
        items = value.tolist() if isinstance(value, np.ndarray) else value
        return hash(tuple(map(_hashed, items))) if isinstance(items, list | tuple) else hash(items)
    try:
        return hash(value)
    except TypeError:
        return hash(type(value).__name__)
