"""Any smooth function as a surface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, positive, shown
from skancf.functions import called, is_function
from skancf.showing import short
from skancf.surfaces.differences import POINTS, difference
from skancf.surfaces.kinks import check_kinks
from skancf.surfaces.protocol import TAKEN, Interval, parameters
from skancf.tolerances import ONE_PLACE

# Of steps over the range of a parameter; of shorter ones the differences are rounding.
SMALLEST_STEP = 1e-7
# What tells a wrong function (a seam that gapes or kinks, derivatives of something else) from inexact differences,
# relative to the largest value.
MISTAKE = 1e-4


@by_value
@dataclass(frozen=True)
class MappedSurface:
    r"""A surface by any smooth function :math:`\mathbf X(x, y)` over a rectangle of the parameter plane.

    The normal points along :math:`\mathbf X_{,x} \times \mathbf X_{,y}`.

    Parameters
    ----------
    function : callable
        From arrays x and y of one shape to the three components of X (m), each of that shape or a number. It is never
        called outside the bounds. Second derivatives must be continuous.
    bounds : ((2,), (2,)) tuple
        Smallest and largest x, smallest and largest y.
    sides : (4,) tuple of str
        Names of x = min, x = max, y = min and y = max.
    closed : (2,) tuple of bool
        Whether x (y) comes back, smoothly, to where it began.
    exact_derivatives : callable, optional
        From x and y to the pair X_x, X_y; without it they are differences of nine values.
    step : float
        Distance of these values over the range of x (y), at most 1/9. On functions that are a full wave over the range
        the default has errors of 2e-13 in first and 1e-10 in second derivatives, relative to the largest; on four
        waves 1e-9 and 5e-8, at the edges. Smaller steps suit shorter waves.

    Raises
    ------
    InputError
        For bounds that do not increase, a function whose values are no three finite components (the point is named) or that
        has a kink, a closed direction that does not close or has a kink there, exact derivatives that are those of another
        function, and parameters outside the bounds.

    Examples
    --------
    >>> wave = sk.MappedSurface(lambda x, y: (x, y, 0.05 * np.sin(np.pi * x)), bounds=((0.0, 2.0), (0.0, 1.0)))
    >>> print(wave.position(0.5, 0.0).round(3))
    [0.5  0.   0.05]
    """

    function: Callable[[np.ndarray, np.ndarray], Any]
    bounds: tuple[Interval, Interval]
    sides: tuple[str, str, str, str] = ("left", "right", "bottom", "top")
    closed: tuple[bool, bool] = (False, False)
    exact_derivatives: Callable[[np.ndarray, np.ndarray], Any] | None = None
    step: float = 1 / 256

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not is_function(self.function):
            raise InputError(f"function = {shown(self.function)}: give a function of x and y that returns three components")
        _check_bounds(self.bounds)
        _check_names(self.sides)
        if not _is_pair(self.closed):
            raise InputError(f"closed = {shown(self.closed)}: give two of True or False, for x and for y")
        if not SMALLEST_STEP <= positive("step", self.step) <= 1 / POINTS:
            raise InputError(f"step = {self.step}: {POINTS} different values must fit into the range; give at least "
                             f"{SMALLEST_STEP:g} and at most 1/{POINTS}")  # fmt: skip
        self._check_function()

    def position(self, x: Any, y: Any) -> np.ndarray:
        x, y = self._inside(x, y)
        return self._value(x, y)

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        x, y = self._inside(x, y)
        if self.exact_derivatives is None:
            return self._along_x(self._value, x, y), self._along_y(self._value, x, y)
        pair = self._called("exact_derivatives", self.exact_derivatives, x, y)
        if len(pair) != 2:
            raise InputError(f"exact_derivatives: {len(pair)} values; give the pair X_x, X_y")
        x_slope, y_slope = (_components(f"exact_derivatives[{i}]", each, x, y) for i, each in enumerate(pair))
        return x_slope, y_slope

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y = self._inside(x, y)
        if self.exact_derivatives is not None:
            x_slope, y_slope = (lambda x, y, i=i: self.derivatives(x, y)[i] for i in (0, 1))
            return self._along_x(x_slope, x, y), self._along_y(x_slope, x, y), self._along_y(y_slope, x, y)
        mixed = self._along_y(lambda x, y: self._along_x(self._value, x, y), x, y)
        return self._along_x(self._value, x, y, order=2), mixed, self._along_y(self._value, x, y, order=2)

    def _value(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return _components("function", self._called("function", self.function, x, y), x, y)

    def _called(self, name: str, function: Callable[[np.ndarray, np.ndarray], Any], x: np.ndarray, y: np.ndarray) -> Any:
        try:
            return tuple(called(name, function, x, y))
        except (TypeError, ValueError) as wrong:
            raise InputError(
                f"{name}: {wrong}, on arrays of shape {x.shape}; it must take arrays x and y and return its "
                "components, so use the functions of numpy and not of math"
            ) from wrong

    def _along_x(self, function: Any, x: np.ndarray, y: np.ndarray, order: int = 1) -> np.ndarray:
        return difference(lambda t: function(t, y), x, self.bounds[0], self.step, order)

    def _along_y(self, function: Any, x: np.ndarray, y: np.ndarray, order: int = 1) -> np.ndarray:
        return difference(lambda t: function(x, t), y, self.bounds[1], self.step, order)

    def _inside(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        x, y = parameters(x, y)
        for name, values, (low, high) in zip("xy", (x, y), self.bounds, strict=True):
            over = np.maximum(low - values, values - high)
            if not (over <= ONE_PLACE * (high - low)).all():
                worst = values.flat[int(np.argmax(over))]
                raise InputError(f"{name} = {worst}: outside the bounds ({low}, {high}) of the surface; widen them")
        return np.clip(x, *self.bounds[0]), np.clip(y, *self.bounds[1])

    def _check_function(self) -> None:
        (x_low, x_high), (y_low, y_high) = self.bounds
        x, y = np.meshgrid(np.linspace(x_low, x_high, 5), np.linspace(y_low, y_high, 6), indexing="ij")
        jet = [self.position(x, y), *self.derivatives(x, y)]
        for axis, closed in enumerate(self.closed):
            if closed:
                check_seam(axis, jet)
        check_kinks(self._value, self.bounds)
        if self.exact_derivatives is not None:
            differences = [self._along_x(self._value, x, y), self._along_y(self._value, x, y)]
            for name, exact, near in zip(("X_x", "X_y"), jet[1:], differences, strict=True):
                _check_exact(name, exact, near, x, y)


def check_seam(axis: int, jet: list[np.ndarray]) -> None:
    """X, X_x and X_y on a grid are the same at both ends of the axis."""
    for name, values in zip(("X", "X_x", "X_y"), jet, strict=True):
        # The origin of space does not matter to the size of a surface.
        size = np.abs(values - (values.mean(axis=(1, 2), keepdims=True) if name == "X" else 0)).max()
        gap = np.abs(values.take(0, axis + 1) - values.take(-1, axis + 1)).max()
        if gap > MISTAKE * size:
            raise InputError(
                f"closed in {'xy'[axis]}, but {name} differs by {gap:.3g} between the two ends; the surface "
                "must come back smoothly, or leave closed out"
            )


def _check_exact(name: str, exact: np.ndarray, near: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
    """Given derivatives are near to differences of the function."""
    wrong = np.abs(exact - near).max(axis=0) > MISTAKE * np.abs(near).max()
    if wrong.any():
        raise InputError(
            f"exact_derivatives: {name} = {exact[:, wrong][:, 0]} at (x, y) = ({x[wrong][0]:.6g}, "
            f"{y[wrong][0]:.6g}), but differences of the function give {near[:, wrong][:, 0]}; correct it, or "
            "leave it out"
        )


def _components(name: str, given: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Three components as one finite array (3, ...)."""
    if not hasattr(given, "__iter__") or (isinstance(given, np.ndarray) and given.ndim == 0):
        raise InputError(f"{name} returned {shown(given)}; give the three components of space")
    given = tuple(given)
    if len(given) != 3:
        raise InputError(f"{name} returned {len(given)} components; give the three of space")
    shapes = [np.shape(component) for component in given]
    if any(shape not in ((), x.shape) for shape in shapes):
        raise InputError(
            f"{name} returned components of shapes {shapes} at x and y of shape {x.shape}; each needs that "
            "shape, or is a number"
        )
    kinds = {np.asarray(component).dtype.kind for component in given}
    if not kinds <= set("biuf"):
        raise InputError(f"{name} returned {shown(given)}; give the three components of space as numbers")
    values = np.stack([np.broadcast_to(np.asarray(component, float), x.shape) for component in given])
    wrong = ~np.isfinite(values).all(axis=0)
    if wrong.any():
        raise InputError(
            f"{name} is {values[:, wrong][:, 0]} at (x, y) = ({x[wrong][0]:.6g}, {y[wrong][0]:.6g}): every "
            "component must be a finite number within the bounds"
        )
    return values


def _is_pair(closed: Any) -> bool:
    """Whether it says of two directions if they are closed."""
    truths = isinstance(closed, tuple) and all(isinstance(c, bool | np.bool_ | int) and c in (0, 1) for c in closed)
    return truths and len(closed) == 2


def _check_bounds(bounds: Any) -> None:
    checked = finite("bounds", bounds)
    if checked.shape != (2, 2) or not (checked[:, 0] < checked[:, 1]).all():
        raise InputError(f"bounds = {bounds}: give ((x min, x max), (y min, y max)) with min < max")


def _check_names(sides: Any) -> None:
    strings = isinstance(sides, tuple) and all(isinstance(name, str) and name for name in sides)
    if not strings or len(sides) != 4 or len(set(sides)) != 4:
        raise InputError(f"sides = {shown(sides)}: give four different names, for x = min, x = max, y = min and y = max")
    if set(sides) & set(TAKEN):
        raise InputError(f"sides = {sides}: {' and '.join(TAKEN[:2])} mean all sides and all corners, "
                         f"{TAKEN[2]} the edges of openings; choose other names")  # fmt: skip
