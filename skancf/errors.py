"""Errors of this library. Each message names the value, the rule and the way out."""

import logging
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from decimal import Decimal
from numbers import Real
from typing import Any

import numpy as np


class SkancfError(Exception):
    """Base class, so that a caller can catch this library and nothing else.

    Examples
    --------
    >>> try:
    ...     sk.Rectangle(-1.0, 1.0)
    ... except sk.SkancfError as reason:
    ...     print(type(reason).__name__)
    InputError
    """


class InputError(SkancfError, ValueError):
    """A value that cannot be used, found before any work was done.

    Examples
    --------
    >>> try:
    ...     sk.Rectangle(-1.0, 1.0)
    ... except sk.InputError as reason:
    ...     print(reason)
    length_x = -1.0: give a number greater than zero
    """


class NoLimit(InputError):
    """A number that has no limit as the mesh is refined; the message names the point, and a quantity that has one.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> nail = sk.PointForce((0.5, 0.5), (0.0, 0.0, -100.0))
    >>> plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel, supports=[sk.Clamp("boundary")], loads=[nail])
    >>> try:
    ...     sk.adapt(plate, sk.Displacement(at=(0.5, 0.5)), rtol=1e-2, theory="full", linear=True)
    ... except sk.NoLimit as reason:
    ...     print(str(reason).split(":")[0])
    Displacement(at=(0.5, 0.5)) has no limit as the mesh is refined
    """


class DidNotConverge(SkancfError):
    """A solve that stopped without an answer; carries the history of its residual.

    Examples
    --------
    >>> from dataclasses import replace
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> hard = replace(strip, loads=[sk.EdgeMoment("right", (0.0, -2e5, 0.0))])
    >>> step = sk.HalveAndGrow(smallest=0.9)
    >>> result = sk.solve(hard.on(system.mesh, "kirchhoff"), max_iterations=2, control=step, relax=False)
    >>> try:
    ...     solution = result.unwrap()
    ... except sk.DidNotConverge:
    ...     print(result.ok)
    False
    """

    def __init__(self, message: str, residual_norms: Sequence[float] = ()):
        self.residual_norms = tuple(residual_norms)
        super().__init__(message)


class OutOfDepth(UserWarning):
    """An answer that leaves out what may matter: shear of a thick plate, mass off its surface, loads that may flutter.

    Examples
    --------
    >>> import warnings
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> from dataclasses import replace
    >>> thick = replace(plate, thickness=0.1).on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     solution = sk.solve(thick).unwrap()
    >>> print([warning.category.__name__ for warning in told])
    ['OutOfDepth']
    """


_silent: ContextVar[bool] = ContextVar("_silent", default=False)


@contextmanager
def silenced() -> Iterator[None]:
    """No warnings by :func:`warn`, as of states on the way to an answer that will be judged itself."""
    before = _silent.set(True)
    try:
        yield
    finally:
        _silent.reset(before)


def is_silenced() -> bool:
    """Whether the code runs in :func:`silenced`."""
    return _silent.get()


def warn(message: str) -> None:
    """Warn of what is :class:`OutOfDepth`, at the line outside of this library that led to it, and log it."""
    if is_silenced():
        return
    frame, level = sys._getframe(1), 2
    logging.getLogger(frame.f_globals["__name__"]).warning("%s", message)
    while frame is not None and frame.f_globals.get("__name__", "").startswith("skancf."):
        frame, level = frame.f_back, level + 1  # type: ignore[assignment]
    warnings.warn(message, OutOfDepth, stacklevel=level)


class SingularMatrix(SkancfError):
    """A matrix that has no factors.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> free = sk.Problem(sk.Rectangle(1.0, 1.0), 0.01, steel)
    >>> system = free.on(sk.meshes.uniform(free.surface, 2, 2), "kirchhoff")
    >>> with sk.linear.DirectSolver(system.pattern, system.constraints) as solver:
    ...     try:
    ...         solver.factor(system.tangent(system.undeformed))
    ...     except sk.SingularMatrix:
    ...         print("moves freely")
    moves freely
    """


class NotEnoughMemory(SkancfError, MemoryError):
    """A run that would not fit into memory, found before the memory was asked for.

    Examples
    --------
    >>> try:
    ...     sk.meshes.uniform(sk.Rectangle(1.0, 1.0), 10**6, 10**6)
    ... except sk.NotEnoughMemory:
    ...     print("too large")
    too large
    """


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
