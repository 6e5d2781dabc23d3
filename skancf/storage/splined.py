"""Functions kept as tables of their values."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import InputError, finite, number, warn
from skancf.functions import values_at
from skancf.history import Table
from skancf.supports import DrivenClamp
from skancf.surfaces import MappedSurface
from skancf.tolerances import SAMPLED, SAMPLED_AT_MOST, SAMPLED_EXACTLY, TINY

ORDER = 5
"""Of the splines between the samples."""
SAMPLES, MOMENTS = (65, 129, 257), 2001
"""In each direction of the parameter plane, as few of these as will do; over time."""


@by_value
@dataclass(frozen=True)
class Splined:
    """A function of the parameters (x, y), by splines through its values on a grid.

    Parameters
    ----------
    x, y : (n,) and (m,) sequences of float
        The lines of the grid, ascending, at least six each.
    values : (n, m) or (k, n, m) sequence of float
        Numbers, or vectors of k components.
    error : float
        Largest difference from the function of which these are the values, half-way between the lines, relative to its
        largest value.

    Raises
    ------
    InputError
        For lines that do not ascend, and values that do not fit them.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 9)
    >>> thickness = sk.storage.Splined(x, x, 0.01 * (1 + np.outer(x, x**2)))
    >>> round(float(thickness(0.5, 0.5)), 9)
    0.01125
    """

    x: Any
    y: Any
    values: Any
    error: float = 0.0

    def __post_init__(self) -> None:
        plain(self)
        x, y, values = (finite(name, getattr(self, name)) for name in ("x", "y", "values"))
        for name, line in (("x", x), ("y", y)):
            if line.ndim != 1 or line.size <= ORDER or not (np.diff(line) > 0).all():
                raise InputError(f"{name} of shape {line.shape}: give at least {ORDER + 1} ascending numbers in a row")
        if values.ndim not in (2, 3) or values.shape[-2:] != (x.size, y.size):
            raise InputError(f"values of shape {values.shape}: give ({x.size}, {y.size}), or components of that first")
        number("error", self.error)
        for name, array in (("x", x), ("y", y), ("values", values)):
            object.__setattr__(self, name, array)

    @cached_property
    def _splines(self) -> list[Any]:
        from scipy.interpolate import RectBivariateSpline  # not at the top: few runs need it, and it is slow to load

        parts = self.values if self.values.ndim == 3 else [self.values]
        return [RectBivariateSpline(self.x, self.y, part, kx=ORDER, ky=ORDER) for part in parts]

    def __call__(self, x: Any, y: Any) -> Any:
        found = [spline.ev(x, y) for spline in self._splines]
        return np.stack(found) if self.values.ndim == 3 else found[0]


TIMED = ("history", "angle")
"""Fields that are functions of time with one value."""
PLACED = ("thickness", "offset", "force", "pressure", "change", "gradient", "stiffness", "displacement", "rotation",
          "moment", "impulse", "function")  # fmt: skip
"""Fields that may be functions of the parameters (x, y)."""
APART = {DrivenClamp: ("displacement",)}
"""Fields of these names that are something else."""


class Sampler:
    """Says what is kept instead of functions: tables of them, over the bounds of a surface and a span of time.

    ``refuse`` is asked where there is none. What has been sampled is in ``said``, in words.
    """

    def __init__(self, surface: Any, span: tuple[float, float] | None, refuse: Any) -> None:
        self.surface, self.span, self.refuse = surface, span, refuse
        self.said: list[str] = []

    def __call__(self, owner: Any, name: str, value: Any) -> Any:
        """The table that is kept; InputError where there is none that is close."""
        made: Table | Splined | None = None
        if callable(value) and not isinstance(value, type) and name not in APART.get(type(owner), ()):
            if name in TIMED and self.span is not None and not hasattr(value, "at_rest"):
                made = self._over_time(owner, name, value, *self.span)
            elif name in PLACED:
                surface = owner if isinstance(owner, MappedSurface) else self.surface
                made = self._over_place(owner, name, value, getattr(surface, "bounds", None))
        return self.refuse(owner, name, value) if made is None else made

    def warn(self) -> None:
        """What was sampled, and how close it is."""
        if self.said:
            warn("kept as tables of values, not as functions: " + "; ".join(self.said))

    def _over_time(self, owner: Any, name: str, function: Any, begin: float, end: float) -> Table | None:
        times = np.linspace(begin, end, MOMENTS)
        between = 0.5 * (times[1:] + times[:-1])
        exact, values = (np.array([function(float(t)) for t in part], dtype=float) for part in (between, times))
        table = Table(times.tolist(), values.tolist(), kind="smooth")
        error = _error(np.array([table(t) for t in between]), exact)
        return table if self._close(owner, name, error) else None

    def _over_place(self, owner: Any, name: str, function: Any, bounds: Any) -> Splined | None:
        if bounds is None:
            return None
        wanted, allowed = (SAMPLED_EXACTLY,) * 2 if isinstance(owner, MappedSurface) else (SAMPLED, SAMPLED_AT_MOST)
        table = None
        for n in SAMPLES:
            x, y = (np.linspace(low, high, n) for low, high in bounds)
            values = _on_grid(function, x, y)
            if values is None:
                return None
            halves = [0.5 * (line[1:] + line[:-1]) for line in (x, y)]
            error = _error(_on_grid(Splined(x, y, values), *halves), _on_grid(function, *halves))
            table = Splined(x, y, values, error)
            if error <= wanted:
                break
        return table if table and self._close(owner, name, table.error, allowed) else None

    def _close(self, owner: Any, name: str, error: float, allowed: float = SAMPLED_AT_MOST) -> bool:
        if error <= allowed:
            self.said.append(f"{type(owner).__name__}.{name}, with an error of {error:.1e} of its largest value")
        return error <= allowed


def _error(near: Any, exact: Any) -> float:
    """Largest difference, relative to the largest value."""
    return float(np.abs(near - exact).max() / max(np.abs(exact).max(), TINY))


def _on_grid(function: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray | None:
    """Values (n, m) or (3, n, m); None of what gives neither."""
    at = np.stack(np.meshgrid(x, y, indexing="ij"))
    try:
        return values_at("values", function, at)
    except InputError:  # no number for each point: three, or nothing of the kind
        with suppress(InputError):
            return values_at("values", function, at, 3)
    return None
