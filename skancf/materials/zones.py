"""Zones: parts of the parameter plane with sections of their own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from skancf.arguments import plain, sequence, text
from skancf.equality import by_value
from skancf.errors import InputError, finite, shown
from skancf.functions import is_function, true_at
from skancf.showing import short
from skancf.surfaces import Interval
from skancf.tolerances import ONE_PLACE

RECTANGLE = "a rectangle ((x0, x1), (y0, y1)) of the parameter plane, or a function of (x, y) that is true in the zone"
NONE_CLOSED: Mapping[int, Interval] = {}
ZONES = "zones, as in [Zone('doubler', ((0.2, 0.4), (0.1, 0.3)), thickness=0.02)]"


@by_value
@dataclass(frozen=True)
class Zone:
    """A part of the parameter plane where the section is another one.

    Parameters
    ----------
    name : str
        As messages and pictures say it.
    where : ((x0, x1), (y0, y1)) or callable
        A rectangle of the parameter plane, which may reach over the bounds of the surface, and over the end of a closed
        parameter goes on at its beginning; or a function of the parameters (x, y) that is true inside. Either way it
        consists of whole elements: its sides are lines of the mesh (:func:`skancf.meshes.with_lines` puts them there).
    thickness : float or callable, optional
        In the zone, as that of the problem (m). Default: that of the problem.
    material : Law, Laminate or callable, optional
        Default: that of the problem. A laminate brings its thickness. A law at points, such as rubber, may stand next to
        other laws, linear ones too, and not next to laminates.
    offset : float or callable, optional
        Height of the mid-plane above the reference surface (m). Default: that of the problem.

    Raises
    ------
    InputError
        For an invalid rectangle, and for a zone that changes nothing.

    Examples
    --------
    >>> sheet, steel = sk.Rectangle(1.0, 0.2), sk.Isotropic(210e9, 0.3, 7850.0)
    >>> doubler = sk.Zone("doubler", ((0.4, 0.6), (0.0, 0.2)), thickness=4e-3)
    >>> plate = sk.Problem(sheet, 2e-3, steel, [sk.Clamp("left")], zones=[doubler])
    >>> system = plate.on(sk.meshes.with_lines(sheet, 5, 1, plate.zones), "kirchhoff")
    >>> print(np.unique(system.mesh.p[0]))
    [0.  0.2 0.4 0.6 0.8 1. ]
    """

    name: str
    where: Any
    thickness: Any = None
    material: Any = None
    offset: Any = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        if not text("name of a zone", self.name):
            raise InputError("name of a zone: it is empty; give one, as messages and pictures say it")
        if not is_function(self.where):
            self._check_rectangle()
        if self.thickness is None and self.material is None and self.offset is None:
            raise InputError(f"zone {self.name!r}: its section is that of the problem; give it a thickness, a material or "
                             "an offset of its own, or leave it out")  # fmt: skip

    def _check_rectangle(self) -> None:
        sides = finite(f"where of zone {self.name!r}", self.where)
        if sides.shape != (2, 2):
            raise InputError(f"where of zone {self.name!r} = {shown(self.where)}: give {RECTANGLE}")
        for axis, (low, high) in zip("xy", sides.tolist(), strict=True):
            if not low < high:
                raise InputError(f"where of zone {self.name!r}: {axis} from {low} to {high} is empty; give the lower side "
                                 "first, then the upper")  # fmt: skip

    @property
    def rectangle(self) -> np.ndarray | None:
        """Its sides (2, 2), lower and upper of x and of y; None of a zone that a function tells."""
        return None if is_function(self.where) else np.array(self.where, dtype=float)

    def parts(self, closed: Mapping[int, Interval] = NONE_CLOSED) -> list[np.ndarray]:
        """Rectangles (2, 2) of which it consists within the bounds of closed parameters, which are by their number: more
        than one where it goes over a seam. None of a zone that a function tells."""
        sides = self.rectangle
        if sides is None:
            return []
        rows = [_between(low, high, closed.get(axis)) for axis, (low, high) in enumerate(sides.tolist())]
        return [np.array(part) for part in product(*rows)]

    def holds(self, places: np.ndarray, closed: Mapping[int, Interval] = NONE_CLOSED) -> np.ndarray:
        """Which places (2, ...) of the parameter plane are in it, bool (...)."""
        if self.rectangle is None:
            at = places.reshape(2, -1)
            return true_at(f"where of zone {self.name!r}", self.where, at).reshape(places.shape[1:])
        out = np.zeros(places.shape[1:], dtype=bool)
        for part in self.parts(closed):
            low, high = (side.reshape(2, *[1] * (places.ndim - 1)) for side in part.T)
            out |= ((places > low) & (places < high)).all(axis=0)
        return out


def _between(low: float, high: float, bounds: Interval | None) -> list[Interval]:
    """An interval, and one of a closed parameter within its bounds."""
    if bounds is None:
        return [(low, high)]
    start, end = bounds
    turn, slack = end - start, ONE_PLACE * (end - start)
    if high - low > turn - slack:
        return [(start, end)]
    turns = turn * np.floor((low - start + slack) / turn)
    low, high = float(low - turns), float(high - turns)
    return [(low, high)] if high < end + slack else [(low, end), (start, high - turn)]


def check_zones(zones: Any) -> tuple[Zone, ...]:
    """Zones of a problem.

    Raises
    ------
    InputError
        For what is no zone, two zones of one name, and rectangles that overlap.
    """
    found: tuple[Zone, ...] = sequence("zones", zones, Zone, ZONES)
    for one, two in combinations(found, 2):
        if one.name == two.name:
            raise InputError(f"zones: two have the name {one.name!r}; give each its own")
        sides, others = one.rectangle, two.rectangle
        if sides is not None and others is not None and (both := _common(sides, others)) is not None:
            raise overlap(one, two, both.mean(axis=1))
    return found


def overlap(one: Zone, two: Zone, place: np.ndarray) -> InputError:
    """Two zones that both hold a place (2,)."""
    return InputError(f"zones {one.name!r} and {two.name!r} overlap, near (x, y) = ({place[0]:.6g}, {place[1]:.6g}), where "
                      "the section would be two; end one where the other begins")  # fmt: skip


def _common(one: np.ndarray, two: np.ndarray) -> np.ndarray | None:
    """The rectangle that two rectangles share, (2, 2); None where they only touch."""
    low, high = np.maximum(one[:, 0], two[:, 0]), np.minimum(one[:, 1], two[:, 1])
    slack = ONE_PLACE * np.maximum(one[:, 1] - one[:, 0], two[:, 1] - two[:, 0])
    return np.stack([low, high], axis=1) if (high - low > slack).all() else None


def lines_of(zones: Sequence[Zone], axis: int, closed: Mapping[int, Interval] = NONE_CLOSED) -> list[float]:
    """Coordinates along x (0) or y (1) at which zones end; parameters are closed between bounds, by their number."""
    return [float(side) for zone in zones for part in zone.parts(closed) for side in part[axis]]
