"""Results at places, along lines and through the thickness: what a :class:`~skancf.Solution` is asked for."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.arguments import instance, plain, whole
from skancf.elements.quad_ancf import gauss
from skancf.errors import InputError, finite, number, positive, shown, vector
from skancf.functions import called
from skancf.layout.around import require_inside
from skancf.materials.heights import ABOVE, Interface
from skancf.optional import needed
from skancf.point_values import COMPONENTS, PointValues
from skancf.showing import short
from skancf.tabular import Column, Tabular
from skancf.tensors import principal_stresses, von_mises
from skancf.units import Units

PIECES = 8
"""Of a curve between two points, to find its length."""


@dataclass(frozen=True)
class Arc:
    r"""A circular arc in the parameter plane, for :meth:`Solution.along <skancf.Solution.along>`.

    .. math:: (x, y) = c + r (\cos \varphi, \sin \varphi), \qquad \varphi = \varphi_0 + t (\varphi_1 - \varphi_0)

    Parameters
    ----------
    centre : (2,) numbers
    radius : float
    start, end : float
        Angles from the x axis (rad). Default: the whole circle.

    Raises
    ------
    InputError
        For a radius that is not positive, and equal angles.

    Examples
    --------
    >>> quarter = sk.Arc((0.5, 0.5), 0.2, 0.0, np.pi / 2)
    >>> [round(float(v), 9) for v in quarter(0.0)], [round(float(v), 9) for v in quarter(1.0)]
    ([0.7, 0.5], [0.5, 0.7])
    """

    centre: tuple[float, float]
    radius: float
    start: float = 0.0
    end: float = 2 * np.pi

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        vector("centre", self.centre, 2)
        positive("radius", self.radius)
        if number("start", self.start) == number("end", self.end):
            raise InputError(f"start = end = {self.start}: this arc has no length; give two angles (rad)")

    def __call__(self, t: float) -> tuple[float, float]:
        """The point at t, from 0 to 1."""
        angle = self.start + t * (self.end - self.start)
        return self.centre[0] + self.radius * np.cos(angle), self.centre[1] + self.radius * np.sin(angle)


@dataclass(frozen=True, eq=False, repr=False)
class Line(PointValues):
    """A state along a line of the parameter plane, as :meth:`~skancf.Solution.along` gives it.

    A table as :class:`PointValues`, whose first column is the arc length s on the undeformed surface.

    Attributes
    ----------
    s : (n,) array
        Arc length from the first point, on the undeformed reference surface (m).
    """

    s: np.ndarray = None  # type: ignore[assignment]

    def _makers(self) -> dict[str, tuple[Callable[[], np.ndarray], str]]:
        return {"s": (lambda: self.s, "m"), **super()._makers()}

    def plot(self, *names: str, axes: Any = None, units: Units | None = None) -> Any:
        """Draw columns of the table over the arc length.

        Parameters
        ----------
        *names : str
            Columns of one unit, such as ``"M11", "M22"``. Default: von Mises' stress at both faces.
        axes : matplotlib axes, optional
            Where to draw. Default: new ones.
        units : Units, optional
            To show. Default: m, N and Pa.

        Returns
        -------
        matplotlib axes

        Raises
        ------
        InputError
            For a name that is no column, and columns of different units.

        Examples
        --------
        >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.3, 7800), [sk.Clamp("left")],
        ...                    [sk.EdgeLoad("right", (0, 0, 10.0))])
        >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
        >>> import matplotlib
        >>> from matplotlib.figure import Figure
        >>> axes = solution.along((0, 0.1), (1, 0.1), n=5).plot("M11", "M22", axes=Figure().subplots())
        >>> axes.get_xlabel()
        's [m]'
        """
        units = instance(
            "units", Units() if units is None else units, Units, "names of units, as in sk.Units(length='mm', stress='MPa')"
        )
        chosen = names or ("mises_top", "mises_bottom")
        for name in chosen:
            self._known(name)
        drawn = {self.unit(name) for name in chosen}
        if len(drawn) > 1:
            raise InputError(f"names = {chosen}: they have different units, {', '.join(sorted(drawn))}; draw each in "
                             "axes of its own")  # fmt: skip
        if axes is None:
            axes = needed("matplotlib.pyplot", "plot", "view").subplots(layout="constrained")[1]
        elif isinstance(axes, type) or not hasattr(axes, "get_xlabel"):
            raise InputError(f"axes = {shown(axes)}: give axes of matplotlib, as plt.subplots() makes them")
        (along, length), (factor, unit) = units.of("m"), units.of(drawn.pop())
        for name in chosen:
            axes.plot(along * self.s, factor * self[name], label=name)
        # The legend names several curves.
        named = (*chosen, f"[{unit}]" if unit else "") if len(chosen) == 1 else (f"[{unit}]" if unit else "",)
        axes.set(xlabel=f"s [{length}]", ylabel=" ".join(named).strip())
        if len(chosen) > 1:
            axes.legend()
        if self.state.note:
            axes.set_title(self.state.note)
        return axes


@dataclass(frozen=True, eq=False)
class Profile(Tabular):
    """Stresses through the thickness at a place, as :meth:`~skancf.Solution.through_thickness` gives them; a table.

    Attributes
    ----------
    z : (n,) array
        Undeformed heights above the reference surface (m): each interface twice, in the lower layer and in the upper one.
    layer : (n,) int array
        Number of the layer, from the bottom on.
    stress : (n, 6) array
        Cauchy stress in the local frame, order 11, 22, 33, 23, 13, 12 (Pa).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> profile = sk.solve_linear(system).through_thickness((0.5, 0.5))
    >>> print(profile.columns["z"])
    [-0.005  0.005]
    """

    z: np.ndarray
    layer: np.ndarray
    stress: np.ndarray

    __repr__ = short

    def _table(self) -> dict[str, Column]:
        table: dict[str, Column] = {"z": (self.z, "m"), "layer": (self.layer, "")}
        table |= {f"S{k}": (part, "Pa") for k, part in zip(COMPONENTS, self.stress.T, strict=True)}
        principal = principal_stresses(self.stress)
        return table | {
            "max_principal": (principal[:, 0], "Pa"), "min_principal": (principal[:, 2], "Pa"),
            "mises": (von_mises(self.stress), "Pa"),
        }  # fmt: skip


class AtPlaces:
    """What a state is asked for at places of the parameter plane; a base of :class:`~skancf.Solution`."""

    system: Any

    def at(self, points: Any, *, side: Any = None) -> PointValues:
        """Displacements, rotations, section forces and stresses at points of the parameter plane.

        Parameters
        ----------
        points : (2,) or (n, 2) numbers
            Parameters (x, y) of the surface, of a flat rectangle its coordinates (m).
        side : (2,) numbers, optional
            Fields other than the displacement may jump on edges of the mesh, as stresses do at borders of zones: there
            values are means over the elements that meet at the point, or, with a direction of the parameter plane, those of
            the elements on that side.

        Returns
        -------
        PointValues
            A table: its properties and ``to_dataframe()``, ``to_csv(path)`` have the values.

        Raises
        ------
        InputError
            For points outside the surface, which it names.

        Examples
        --------
        >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
        ...                    [sk.EdgeLoad("right", (0, 0, 10.0))])
        >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
        >>> values = solution.at([(0.0, 0.1), (0.5, 0.1)])
        >>> np.round(values.M[:, 0], 3) + 0.0
        array([-10.,  -5.])
        >>> np.round(values.stress("bottom").max_principal / 1e3, 1)
        array([600., 300.])
        """
        return PointValues(self, *_checked(self.system, points, side))

    def along(self, *points: Any, n: int = 101, side: Any = None) -> Line:
        """The same along a line of the parameter plane, from point to point in straight pieces, or along a curve.

        Parameters
        ----------
        *points : (2,) numbers, or one function
            Two points (x, y) or more; or a curve: a function of t, from 0 to 1, that gives (x, y), such as
            :class:`~skancf.Arc`.
        n : int
            Number of points, ends and corners included.
        side : (2,) numbers, optional
            As in :meth:`at`: for example ``(1, 0)`` takes the values just right of an edge that the line runs along.

        Returns
        -------
        Line
            A table with the arc length s.

        Raises
        ------
        InputError
            For points outside the surface, which it names, and lines without a length.

        Examples
        --------
        >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
        ...                    [sk.EdgeLoad("right", (0, 0, 10.0))])
        >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
        >>> line = solution.along((0, 0.1), (1, 0.1), n=5)
        >>> np.round(line.M[:, 0], 3) + 0.0
        array([-10. ,  -7.5,  -5. ,  -2.5,   0. ])
        """
        surface = self.system.geometry.surface
        count = whole("n", n, 2, MOST_POINTS)
        if len(points) == 1 and callable(points[0]):
            fine = _of_curve(points[0], count)
            places = fine[::PIECES]
            steps = _lengths(surface, fine).reshape(-1, PIECES).sum(axis=1)
        else:
            if len(points) < 2:
                raise InputError(f"points = {shown(points)}: give two points (x, y) or more, or a function of t from 0 to 1")
            corners = np.array([vector(f"points[{k}]", point, 2) for k, point in enumerate(points)])
            require_inside(self.system.geometry, corners.T)
            places = _between(corners, _lengths(surface, corners), count)
            steps = _lengths(surface, places)
        s = np.concatenate([[0.0], np.cumsum(steps)])
        return Line(self, *_checked(self.system, places, side), s=s)

    def through_thickness(self, at: Any, *, n: int = 2, side: Any = None) -> Profile:
        """Cauchy stresses in the local frame through the thickness at a point of the parameter plane, layer by layer.

        Parameters
        ----------
        at : (2,) numbers
        n : int
            Heights in each layer, at least 2, its faces included.
        side : (2,) numbers, optional
            As in :meth:`at`.

        Returns
        -------
        Profile

        Raises
        ------
        InputError
            For a point outside the surface.

        Examples
        --------
        >>> plate = sk.Problem(sk.Rectangle(1.0, 0.2), 0.01, sk.Isotropic(2e11, 0.0, 7800), [sk.Clamp("left")],
        ...                    [sk.EdgeLoad("right", (0, 0, 10.0))])
        >>> solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 1)))
        >>> profile = solution.through_thickness((0.5, 0.1))
        >>> np.round(profile.columns["S11"] / 1e3, 3)
        array([ 300., -300.])
        """
        values = self.at(vector("at", at, 2), side=side)
        per_layer, z = whole("n", n, 2, MOST_POINTS), values.heights[:, 0]
        layers = range(len(z) - 1)
        shares = np.linspace(0.0, 1.0, per_layer)
        heights: list[tuple[int, Any, float]] = []
        for k in layers:
            inner = [float(z[k] + share * (z[k + 1] - z[k])) for share in shares[1:-1]]
            heights.append((k, Interface(k, ABOVE if k else 0.0), float(z[k])))
            heights += [(k, height, height) for height in inner]
            heights.append((k, Interface(k + 1), float(z[k + 1])))
        stress = np.concatenate([values.stress(depth).components for _, depth, _ in heights])
        return Profile(np.array([h[2] for h in heights]), np.array([h[0] for h in heights]), stress)


MOST_POINTS = 1_000_000


def checked_points(system: Any, points: Any, name: str = "points") -> np.ndarray:
    """Points (n, 2) that the surface holds."""
    array = finite(name, points)
    if array.ndim not in (1, 2) or array.shape[-1] != 2 or not array.size:
        raise InputError(f"{name} of shape {array.shape}: give a point (x, y) of the parameter plane, or a list of them")
    array = array.reshape(-1, 2)
    require_inside(system.geometry, array.T, name)
    return array


def _checked(system: Any, points: Any, side: Any) -> tuple[np.ndarray, np.ndarray | None]:
    """Points (n, 2) that the surface holds, and a direction."""
    array = checked_points(system, points)
    if side is None:
        return array, None
    way = vector("side", side, 2)
    if not way.any():
        raise InputError("side = (0, 0): this is no direction; give one of the parameter plane, as in (1, 0)")
    return array, way


def _of_curve(curve: Callable[[float], Any], n: int) -> np.ndarray:
    """Points ((n - 1) PIECES + 1, 2) of a curve."""
    t = np.linspace(0.0, 1.0, (n - 1) * PIECES + 1)
    return np.array([vector("points", called("points", curve, float(each)), 2) for each in t])


def _lengths(surface: Any, points: np.ndarray) -> np.ndarray:
    """Lengths on the surface of the straight pieces between points (n, 2) of the parameter plane, (n - 1,)."""
    at, weights = gauss(4)
    ways = np.diff(points, axis=0)
    x, y = (points[:-1, None] + at[:, None] * ways[:, None]).transpose(2, 0, 1)
    along = np.einsum("aips,pa->ips", np.stack(surface.derivatives(x, y)), ways)
    return np.asarray(np.linalg.norm(along, axis=0) @ weights)


def _between(corners: np.ndarray, lengths: np.ndarray, n: int) -> np.ndarray:
    """About n points (m, 2) on straight pieces between corners, evenly by their lengths; corners are among them."""
    if not lengths.sum() > 0:
        raise InputError(f"points = {corners.tolist()}: this line has no length; give two different points")
    share = np.round(np.cumsum(lengths) / lengths.sum() * (n - 1)).astype(int)
    counts = np.where(lengths > 0, np.maximum(np.diff(share, prepend=0), 1), 0)
    parts = [corners[:1]]
    for start, end, count in zip(corners[:-1], corners[1:], counts, strict=True):
        parts.append(start + np.linspace(0.0, 1.0, count + 1)[1:, None] * (end - start))
    return np.concatenate(parts)
