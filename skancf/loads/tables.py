"""Loads from tables: forces at points, and fields of samples."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from skancf.arguments import text
from skancf.columns import columns
from skancf.equality import by_value
from skancf.errors import InputError, finite, shown
from skancf.history import History, check_history
from skancf.loads.moment import PointMoment
from skancf.loads.point import PointForce
from skancf.showing import short
from skancf.tolerances import NO_AREA, ONE_PLACE, SAME_VALUE

FORCES, MOMENTS = ("fx", "fy", "fz"), ("mx", "my", "mz")


def point_forces(table: Any, *, titles: Mapping[str, str] | None = None, history: History | None = None) -> list[Any]:
    r"""Forces and moments at points, one row each.

    Parameters
    ----------
    table
        A DataFrame, a mapping from names to columns, a structured array, or the path of a ``.csv`` file. Its columns are x
        and y (the point of the parameter plane), and of fx, fy, fz (N) and mx, my, mz (N m) those that are not zero; others
        are ignored. A title may have a unit, as in ``"fx (N)"``: those of a table must belong together.
    titles : mapping, optional
        From these names to titles in the table, as in ``{"fz": "Load Z"}``.
    history : callable, optional
        Factor of all as a function of time.

    Returns
    -------
    list of PointForce and PointMoment
        In the order of the rows; what is zero is left out.

    Raises
    ------
    InputError
        For a missing column, an entry that is no finite number (its column and row are named), and units that do not belong
        together.

    Examples
    --------
    >>> table = {"x (m)": [0.2, 0.8], "y (m)": [0.5, 0.5], "fz (N)": [-10.0, -20.0]}
    >>> sk.loads.point_forces(table)[1].force
    (0.0, 0.0, -20.0)
    """
    check_history(history)
    found = columns("table", table, ("x", "y"), (*FORCES, *MOMENTS), titles)
    if not any(name in found for name in (*FORCES, *MOMENTS)):
        raise InputError(f"table: has none of the columns {', '.join((*FORCES, *MOMENTS))}; name its own by titles=")
    at = np.column_stack([found["x"], found["y"]])
    out: list[Any] = []
    none = np.zeros(len(at))
    forces, moments = (np.column_stack([found.get(name, none) for name in names]) for names in (FORCES, MOMENTS))
    for point, force, moment in zip(at.tolist(), forces.tolist(), moments.tolist(), strict=True):
        if any(force):
            out.append(PointForce(tuple(point), tuple(force), history))
        if any(moment):
            out.append(PointMoment(tuple(point), tuple(moment), history))
    return out


def sampled(table: Any, values: str | Sequence[str], *, titles: Mapping[str, str] | None = None) -> "Sampled":
    r"""A function of place from samples: of a pressure, a force per area, a thickness or a temperature.

    Samples on the lines of a grid are interpolated bilinearly between them; others linearly on the triangles of Delaunay.

    Parameters
    ----------
    table
        As for :func:`point_forces`, with columns x and y and those of the values.
    values : str or sequence of str
        One column, for a number at each place, or three, for a vector.
    titles : mapping, optional
        From names to titles in the table.

    Returns
    -------
    Sampled
        For :class:`~skancf.FollowerPressure`, :class:`~skancf.SurfaceLoad` (three columns), thickness, temperature, and
        whatever else takes a function of (x, y).

    Raises
    ------
    InputError
        For a missing column, an entry that is no finite number, fewer than three samples or all on a line, and two that
        differ at one place. When called: for a point outside the samples, whose values are not known.

    Examples
    --------
    >>> table = {"x": [0.0, 1.0, 0.0, 1.0], "y": [0.0, 0.0, 1.0, 1.0], "p (Pa)": [0.0, 100.0, 0.0, 300.0]}
    >>> pressure = sk.loads.sampled(table, "p")
    >>> float(pressure(0.5, 1.0))
    150.0
    >>> load = sk.FollowerPressure(pressure)
    """
    names = (values,) if isinstance(values, str) else values
    if isinstance(names, Mapping) or not isinstance(names, Sequence) or len(names) not in (1, 3):
        raise InputError(
            f"values = {shown(values)}: give the name of one column, or a list of three, as in ('px', 'py', 'pz')"
        )
    names = tuple(text("values", name) for name in names)
    if len({"x", "y", *names}) < 2 + len(names):
        raise InputError(f"values = {shown(values)}: give other columns than x and y, each once")
    found = columns("table", table, ("x", "y", *names), titles=titles)
    return Sampled(found["x"], found["y"], np.stack([found[name] for name in names]), not isinstance(values, str))


@by_value
@dataclass(frozen=True, eq=False)
class Sampled:
    """A function of (x, y) from samples, see :func:`sampled`.

    Attributes
    ----------
    x, y : (n,) arrays
    values : (1, n) or (3, n) array
    vector : bool
        Whether it returns three components.

    Examples
    --------
    >>> heat = sk.loads.sampled({"x": [0.0, 1.0, 0.0], "y": [0.0, 0.0, 1.0], "T (K)": [0.0, 10.0, 30.0]}, "T")
    >>> heat(np.array([0.5, 0.0]), np.array([0.5, 0.5]))
    array([20., 15.])
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray = field(repr=False)
    vector: bool = False
    __repr__ = short

    def __post_init__(self) -> None:
        points = np.stack([self.x, self.y])
        if points.shape[1] < 3:
            raise InputError(f"table: {points.shape[1]} samples make no field; give at least three that are not on a line")
        size = np.ptp(points, axis=1)
        away = (points - points[:, :1]) / np.where(size > 0, size, 1.0)[:, None]
        if np.linalg.svd(away, compute_uv=False)[1] ** 2 <= NO_AREA * away.shape[1]:
            raise InputError("table: all samples are on one line; give some beside it")
        self._check_places(points)

    def _check_places(self, points: np.ndarray) -> None:
        """InputError for two samples at one place that differ."""
        _, first, number = np.unique(points, axis=1, return_index=True, return_inverse=True)
        other = first[number.ravel()]
        apart = np.abs(self.values - self.values[:, other]).max(axis=0) > SAME_VALUE * np.abs(self.values).max()
        if apart.any():
            row = int(np.argmax(apart))
            raise InputError(f"table: rows {other[row]} and {row} are both at ({self.x[row]:.6g}, {self.y[row]:.6g}) and "
                             "have different values; keep one of them")  # fmt: skip

    @cached_property
    def _function(self) -> Any:
        from scipy.interpolate import LinearNDInterpolator, RegularGridInterpolator  # slow to load, and seldom needed

        x, along_x = np.unique(self.x, return_inverse=True)
        y, along_y = np.unique(self.y, return_inverse=True)
        if len(x) * len(y) == len(np.unique(along_x.ravel() * len(y) + along_y.ravel())):
            grid = np.empty((len(x), len(y), len(self.values)))
            grid[along_x.ravel(), along_y.ravel()] = self.values.T
            return RegularGridInterpolator((x, y), grid, bounds_error=False)
        return LinearNDInterpolator(np.column_stack([self.x, self.y]), self.values.T, rescale=True)

    def __call__(self, x: Any, y: Any) -> np.ndarray:
        x, y = finite("x", x), finite("y", y)
        try:
            x, y = np.broadcast_arrays(x, y)
        except ValueError as wrong:
            raise InputError(f"x and y of shapes {x.shape} and {y.shape}: give as many of both") from wrong
        points = np.column_stack([x.ravel(), y.ravel()])
        found = self._function(points)
        lost = np.isnan(found).any(axis=1)
        if lost.any():
            # On the outline, up to rounding.
            middle = np.array([self.x.mean(), self.y.mean()])
            found[lost] = self._function(points[lost] + ONE_PLACE * (middle - points[lost]))
            lost = np.isnan(found).any(axis=1)
        if lost.any():
            at = points[np.argmax(lost)]
            raise InputError(f"samples: there are none around (x, y) = ({at[0]:.6g}, {at[1]:.6g}); they are from x = "
                             f"{self.x.min():.6g} to {self.x.max():.6g} and y = {self.y.min():.6g} to {self.y.max():.6g}; "
                             "give some as far as the edge of the surface")  # fmt: skip
        out = found.T.reshape(len(self.values), *x.shape)
        return np.asarray(out if self.vector else out[0])
