"""Errors of this library. Each message names the value, the rule and the way out."""

from collections.abc import Sequence
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


class SingularMatrix(SkancfError):
    """A matrix that has no factors."""


class NotEnoughMemory(SkancfError, MemoryError):
    """A run that would not fit into memory, found before the memory was asked for."""


def finite(name: str, value: Any) -> np.ndarray:
    """``value`` as a float array; :class:`InputError` where it is not finite."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as wrong:
        raise InputError(f"{name} = {value!r}: not a number; give finite numbers") from wrong
    if not np.isfinite(array).all():
        first = np.argwhere(~np.isfinite(array))[0]
        where = f"[{', '.join(map(str, first))}] of shape {array.shape}" if array.ndim else ""
        raise InputError(f"{name}{where} = {array[tuple(first)]}: not finite; every entry must be a finite number")
    return array


def number(name: str, value: Any) -> float:
    """``value`` as one finite float."""
    array = finite(name, value)
    if array.ndim:
        raise InputError(f"{name} = {value}: give one number, not {array.size}")
    return float(array)


def positive(name: str, value: Any, unit: str = "") -> float:
    """``value`` as one finite float greater than zero."""
    checked = number(name, value)
    if not checked > 0:
        raise InputError(f"{name} = {value}{' ' + unit if unit else ''}: give a number greater than zero")
    return checked


def vector(name: str, value: Any, size: int) -> np.ndarray:
    """``value`` as a finite vector of ``size`` entries."""
    array = finite(name, value)
    if array.shape != (size,):
        raise InputError(f"{name} = {value}: give {size} numbers, not an array of shape {array.shape}")
    return array


NO_DIRECTION = "this is no direction; give three components, not all zero"


def unit_vector(name: str, value: Any, need: str = NO_DIRECTION) -> np.ndarray:
    """``value`` as a direction of space, of length one; ``need`` says why zero is none."""
    direction = vector(name, value, 3)
    length = float(np.linalg.norm(direction))
    if not length:
        raise InputError(f"{name} = (0, 0, 0): {need}")
    return np.asarray(direction / length)
