"""A surface of the user's own, checked before any work."""

from typing import Any

import numpy as np

from skancf.arguments import SURFACE, having
from skancf.errors import InputError, finite, shown
from skancf.functions import Noted, is_ours
from skancf.surfaces.protocol import TAKEN, Interval

METHODS = {"position": 1, "derivatives": 2, "second_derivatives": 3}
"""How many vectors of space each gives."""
NEEDED = ("position", "derivatives")
"""What every theory asks of a surface; `kirchhoff` asks for second derivatives as well."""
FEW = 6
PLACES = np.array([0.3, 0.6]), np.array([0.25, 0.5, 0.75])
"""Where, as parts of the bounds, a surface is asked for its vectors."""


def require_surface(surface: Any, needed: tuple[str, ...] = NEEDED) -> None:
    """InputError for what is no :class:`~skancf.surfaces.Surface`: the method or attribute is named, and what it gave.

    A surface with bounds is asked at a few points within them for all the vectors that it has; those that are ``needed`` it
    must have. What its own methods raise passes through with a note.
    """
    having("surface", surface, needed, SURFACE)
    for name in METHODS:
        if hasattr(surface, name) and not callable(getattr(surface, name)):
            raise InputError(f"surface.{name} = {shown(getattr(surface, name))}: give a method of x and y")
    if is_ours(surface):
        return
    with Noted("surface"):
        pair = getattr(surface, "closed", (False, False))
        if np.shape(pair) != (2,) or not all(isinstance(one, bool | np.bool_ | int) and one in (0, 1) for one in pair):
            raise InputError(f"surface.closed = {shown(pair)}: give two of True or False, for x and for y")
        if not hasattr(surface, "bounds"):
            return
        bounds = _bounds(surface)
        x, y = (low + (high - low) * at for (low, high), at in zip(bounds, PLACES, strict=True))
        _check_sides(getattr(surface, "sides", None), pair)
        _check_vectors(surface, *np.meshgrid(x, y, indexing="ij"))


def require_vectors(surface: Any, at: np.ndarray) -> None:
    """InputError for a surface of the user's own that gives no vectors at points (2, n), of which a few are tried."""
    if not is_ours(surface):
        with Noted("surface"):
            _check_vectors(surface, *at[:, :FEW])


def _bounds(surface: Any) -> tuple[Interval, Interval]:
    bounds = finite("surface.bounds", surface.bounds)
    if bounds.shape != (2, 2) or not (bounds[:, 0] < bounds[:, 1]).all():
        raise InputError(f"surface.bounds = {shown(surface.bounds)}: give ((x min, x max), (y min, y max)) with min < max")
    return (bounds[0, 0], bounds[0, 1]), (bounds[1, 0], bounds[1, 1])


def _check_sides(sides: Any, closed: Any) -> None:
    rule = f"give four different names, for x = min, x = max, y = min and y = max, and none of {', '.join(TAKEN)}"
    if not isinstance(sides, tuple | list) or len(sides) != 4 or not all(isinstance(name, str) and name for name in sides):
        raise InputError(f"surface.sides = {shown(sides)}: {rule}")
    named = [name for k, name in enumerate(sides) if not closed[k // 2]]
    if len(set(named)) != len(named) or set(named) & set(TAKEN):
        raise InputError(f"surface.sides = {shown(sides)}: {rule}")


def _check_vectors(surface: Any, x: np.ndarray, y: np.ndarray) -> None:
    for name, number in METHODS.items():
        method = getattr(surface, name, None)
        if not callable(method):
            continue
        found = method(x.copy(), y.copy())
        each = (found,) if number == 1 else found
        if not isinstance(each, tuple | list | np.ndarray) or len(each) != number:
            raise InputError(f"surface.{name} returned {shown(found)}; it must return {number} arrays (3, ...)")
        for k, vector in enumerate(each):
            values = finite(f"surface.{name}(x, y)" + f"[{k}]" * (number > 1), vector)
            if values.shape != (3, *x.shape):
                raise InputError(f"surface.{name} of shape {values.shape} for x and y of shape {x.shape}: it must return "
                                 f"three components of space first, {(3, *x.shape)}")  # fmt: skip
