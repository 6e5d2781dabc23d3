"""Flat rectangles."""

from dataclasses import dataclass

from skancf.arguments import plain
from skancf.equality import by_value
from skancf.errors import positive, vector
from skancf.showing import short
from skancf.surfaces.plane import Plane
from skancf.surfaces.protocol import Interval


@by_value
@dataclass(frozen=True)
class Rectangle(Plane):
    """A flat rectangle ``length_x`` by ``length_y`` in the plane z = 0, its lower left corner at ``origin``.

    Its sides are ``"left"``, ``"right"``, ``"bottom"`` and ``"top"``. Its normal is +z.

    Raises
    ------
    InputError
        For a length that is not positive.

    Examples
    --------
    >>> sheet = sk.Rectangle(1.2, 0.8, origin=(-0.6, -0.4))
    >>> sheet.bounds
    ((-0.6, 0.6), (-0.4, 0.4))
    """

    length_x: float
    length_y: float
    origin: tuple[float, float] = (0.0, 0.0)

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        positive("length_x", self.length_x)
        positive("length_y", self.length_y)
        vector("origin", self.origin, 2)

    @property
    def bounds(self) -> tuple[Interval, Interval]:
        x, y = self.origin
        return (x, x + self.length_x), (y, y + self.length_y)

    @property
    def sides(self) -> tuple[str, str, str, str]:
        return "left", "right", "bottom", "top"
