"""Errors of this library. Each message names the value, the rule and the way out."""

import sys
import warnings
from collections.abc import Sequence
from decimal import Decimal
from numbers import Real
from typing import Any

import numpy as np


class SkancfError(Exception):
    """Base class, so that a caller can catch this library and nothing else."""


class InputError(SkancfError, ValueError):
    """A value that cannot be used, found before any work was done."""


class NoLimit(InputError):
    """A number that has no limit as the mesh is refined; the message names the point, and a quantity that has one."""


class DidNotConverge(SkancfError):
    """A solve that stopped without an answer; carries the history of its residual."""

    def __init__(self, message: str, residual_norms: Sequence[float] = ()):
        self.residual_norms = tuple(residual_norms)
        super().__init__(message)


class OutOfDepth(UserWarning):
    """An answer that leaves out what may matter: shear of a thick plate, mass off its surface, loads that may flutter."""


def warn(message: str) -> None:
    """Warn of what is :class:`OutOfDepth`, at the line outside of this library that led to it."""
    frame, level = sys._getframe(1), 2
    while frame is not None and frame.f_globals.get("__name__", "").startswith("skancf."):
        frame, level = frame.f_back, level + 1  # type: ignore[assignment]
    warnings.warn(message, OutOfDepth, stacklevel=level)


class SingularMatrix(SkancfError):
    """A matrix that has no factors."""


class NotEnoughMemory(SkancfError, MemoryError):
    """A run that would not fit into memory, found before the memory was asked for."""


LARGEST, SMALLEST = 1e100, 1e-100
"""Sizes of numbers that can be computed with: the cubes of larger and smaller ones are no numbers, or zero."""


def shown(value: Any) -> str:
    """A value as a message has it, in one line."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of the user's own class
        text = f"a {type(value).__name__}"
    return text if len(text) <= 100 else f"{text[:70]}... (a {type(value).__name__})"


def finite(name: str, value: Any) -> np.ndarray:
    """``value`` as a float array; :class:`InputError` where it is no number, not finite, or beyond :data:`LARGEST`.

    Text, truth values, complex numbers and masked entries are refused.
    """
    array = _as_floats(name, value)
    wrong = ~(np.abs(array) <= LARGEST)
    if wrong.any():
        first = tuple(np.argwhere(wrong)[0])
        where = f"[{', '.join(map(str, first))}] of shape {array.shape}" if array.ndim else ""
        rule = (
            f"too large, its cube is no floating-point number; give numbers up to {LARGEST:g}, in other units if need be"
            if np.isfinite(array[first]) else "not finite; every entry must be a finite number"
        )  # fmt: skip
        raise InputError(f"{name}{where} = {array[first]}: {rule}")
    return array


def _as_floats(name: str, value: Any) -> np.ndarray:
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O" and all(isinstance(v, Real | Decimal) and not _is_truth(v) for v in array.ravel()):
            array = array.astype(float)
    except OverflowError as wrong:
        raise InputError(f"{name} = {shown(value)}: too large; give numbers up to {LARGEST:g}") from wrong
    except Exception as wrong:
        raise InputError(f"{name} = {shown(value)}: not a number; give finite numbers ({wrong})") from wrong
    mixed = isinstance(value, list | tuple) and any(_is_truth(part) for part in value)
    if array.dtype.kind not in "iuf" or mixed or isinstance(value, bytearray):
        kind = "b" if mixed else array.dtype.kind
        what = {"b": ", but a truth value", "c": ", but complex", "U": ", but text", "S": ", but bytes"}
        raise InputError(f"{name} = {shown(value)}: not a number{what.get(kind, '')}; give finite numbers")
    if np.any(getattr(value, "mask", False)):
        raise InputError(f"{name} = {shown(value)}: has masked entries; give finite numbers, as in values.filled(0.0)")
    return array.astype(float, copy=False)


def _is_truth(value: Any) -> bool:
    return isinstance(value, bool | np.bool_)


def number(name: str, value: Any) -> float:
    """``value`` as one finite float."""
    array = finite(name, value)
    if array.ndim:
        raise InputError(f"{name} = {shown(value)}: give one number, not {array.size}")
    return float(array)


def positive(name: str, value: Any, unit: str = "") -> float:
    """``value`` as one finite float greater than zero, and not below :data:`SMALLEST`."""
    checked = number(name, value)
    if not checked > 0:
        raise InputError(f"{name} = {value}{' ' + unit if unit else ''}: give a number greater than zero")
    if checked < SMALLEST:
        raise InputError(f"{name} = {value}{' ' + unit if unit else ''}: too small, its cube is zero in floating-point "
                         f"numbers; give {SMALLEST:g} or more, in other units if need be")  # fmt: skip
    return checked


def vector(name: str, value: Any, size: int) -> np.ndarray:
    """``value`` as a finite vector of ``size`` entries."""
    array = finite(name, value)
    if array.shape != (size,):
        raise InputError(f"{name} = {shown(value)}: give {size} numbers, not an array of shape {array.shape}")
    return array


NO_DIRECTION = "this is no direction; give three components, not all zero"


def unit_vector(name: str, value: Any, need: str = NO_DIRECTION) -> np.ndarray:
    """``value`` as a direction of space, of length one; ``need`` says why it may not be zero."""
    direction = vector(name, value, 3)
    length = float(np.linalg.norm(direction))
    if not length:
        raise InputError(f"{name} = (0, 0, 0): {need}")
    return np.asarray(direction / length)
