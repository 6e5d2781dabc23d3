"""What the rest of the library knows of a surface."""

from typing import Any, Protocol

import numpy as np

Interval = tuple[float, float]
TAKEN = ("boundary", "corners", "openings")
"""Names that every mesh gives to its outer boundary, its corners and its openings."""


class Surface(Protocol):
    r"""A mid-surface :math:`\mathbf X(x, y)`, in m, over a parameter plane.

    x and y are numbers or arrays that broadcast against each other. Second derivatives must be continuous.

    Examples
    --------
    >>> class Slope:
    ...     closed = (False, False)
    ...     def position(self, x, y):
    ...         return np.stack(np.broadcast_arrays(x, y, 0.1 * x))
    ...     def derivatives(self, x, y):
    ...         one, zero = np.ones(np.broadcast(x, y).shape), np.zeros(np.broadcast(x, y).shape)
    ...         return np.stack([one, zero, 0.1 * one]), np.stack([zero, one, zero])
    ...     def second_derivatives(self, x, y):
    ...         return (np.zeros((3, *np.broadcast(x, y).shape)),) * 3
    >>> print(sk.surfaces.normal(Slope(), 0.5, 0.5).round(3))
    [-0.1    0.     0.995]
    """

    def position(self, x: Any, y: Any) -> np.ndarray:
        """X(x, y), shape (3, ...)."""

    def derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        """X_x and X_y, each of shape (3, ...)."""

    def second_derivatives(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """X_xx, X_xy and X_yy, each of shape (3, ...)."""

    @property
    def closed(self) -> tuple[bool, bool]:
        """Does x (does y) come back to where it began, so that its smallest and largest value are one curve in space?

        The two sides are no boundary then. A side of zero length (the centre of a disc, the top of a sphere) is not
        meant by this.
        """


class BoundedSurface(Surface, Protocol):
    """A surface over a rectangle of the parameter plane.

    Examples
    --------
    >>> print(hasattr(sk.Rectangle(1.0, 1.0), "bounds"), hasattr(sk.Plane(), "bounds"))
    True False
    """

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        """Smallest and largest x, smallest and largest y."""

    @property
    def sides(self) -> tuple[str, str, str, str]:
        """Names of x = min, x = max, y = min, y = max; in a closed direction they name no boundary of a mesh."""


def closed_directions(surface: Surface) -> tuple[bool, bool]:
    """``surface.closed``; a surface that does not say is open in both directions.

    Examples
    --------
    >>> sk.surfaces.closed_directions(sk.CylinderSector(0.5, 1.0, 2 * np.pi, closed=True))
    (False, True)
    """
    x, y = getattr(surface, "closed", (False, False))
    return bool(x), bool(y)


def closed_bounds(surface: Surface) -> dict[int, Interval]:
    """Bounds of the parameters that are closed, by their number."""
    closed = closed_directions(surface)
    return {axis: surface.bounds[axis] for axis in (0, 1) if closed[axis]}  # type: ignore[attr-defined]


def parameters(x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """x and y as float arrays of one shape."""
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    return x, y
