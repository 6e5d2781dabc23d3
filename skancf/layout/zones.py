"""Zones on a mesh: which element is in which, and the sections at its points."""

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from skancf.elements.nodal import askew
from skancf.errors import InputError
from skancf.layout.geometry import Geometry
from skancf.layout.patches import edge_numbers
from skancf.layout.section_checks import JUMP, MIDDLES, check_sections
from skancf.materials import Section, SectionField
from skancf.materials.section import trace
from skancf.materials.zones import Zone, overlap
from skancf.tolerances import ONE_PLACE


class SectionsOnMesh:
    """A field of sections on a mesh, whose zones consist of whole elements.

    Attributes
    ----------
    zones : (n_elements,) int array
        Number of each element's zone; the rest of the plate has the last one.

    Raises
    ------
    InputError
        For a zone without an element, with a side that cuts elements, or that shares one with another; for a gap between
        zones that are to cover everything; and see :func:`~skancf.layout.section_checks.check_sections`.
    """

    def __init__(self, field: SectionField, geometry: Geometry):
        self.field, self.geometry = field, geometry
        self.zones = zones_of_elements(geometry, field)
        if field.varies:
            check_sections(field, geometry, self.zones)

    def at(self, points: np.ndarray, elements: np.ndarray | None = None) -> Section:
        """Sections at local points (2, n), or those of each element, (m, 2, n), of elements (m,) or of all: with axes
        (m, n)."""
        zones = self.zones if elements is None else self.zones[elements]
        return self.field.at(self.geometry.parameters(points, elements), zones[:, None])

    @property
    def points_law(self) -> Any:
        """As :attr:`skancf.materials.field.SectionField.points_law`."""
        return self.field.points_law

    def at_places(self, places: Any) -> Section:
        """Sections at places (2, n) of the parameter plane: with an axis (n,)."""
        places = np.asarray(places, dtype=float)
        return self.field.at(places, self.zones[self.geometry.locate_all(places)[0]])

    @cached_property
    def borders(self) -> np.ndarray:
        """Facets between zones, (n_facets,) bool: an edge that is divided on one side, and its parts."""
        low, high = self._at_facets(np.broadcast_to(self.zones[:, None], (len(self.zones), 4)))
        return np.asarray(low < high)

    @cached_property
    def beside_jumps(self) -> np.ndarray:
        """Elements with a side at which the membrane stiffness of the section jumps, or the height of what carries it,
        (n_elements,) bool."""
        section, jumps = self.at(MIDDLES), np.zeros(len(self.borders), dtype=bool)
        stiffness = trace(section.abd()[..., :3, :3])
        for values, size in ((stiffness, stiffness), (section.neutral, section.thickness)):
            low, high = self._at_facets(values)
            jumps |= high - low > JUMP * self._at_facets(size)[1]
        return np.asarray((self.borders & jumps)[self.geometry.mesh.t2f].any(axis=0))

    def _at_facets(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of values on the sides of elements (n_elements, 4) the smallest and the largest at each facet, (n_facets,), of a
        divided edge those at the whole and its parts."""
        mesh, numbers = self.geometry.mesh, edge_numbers(self.geometry)
        # Facets of two elements are by themselves, others may be parts of an edge, or at a seam.
        shared = np.bincount(mesh.t2f.ravel(), minlength=len(numbers)) > 1
        numbers = np.where(shared, numbers.max() + 1 + np.arange(len(numbers)), numbers)
        n = int(numbers.max()) + 1
        low, high = np.full(n, np.inf), np.full(n, -np.inf)
        np.minimum.at(low, numbers[mesh.t2f], values.T)
        np.maximum.at(high, numbers[mesh.t2f], values.T)
        return low[numbers], high[numbers]

    def samples(self) -> list[Section]:
        """Of each zone the section where it is thickest, and where it is farthest off the surface, each as that of a plate
        that is everywhere the same."""
        section, out = self.at(self.geometry.theory.quadrature[0]), []
        off = np.abs(section.neutral) / section.thickness
        for zone in np.unique(self.zones):
            here = self.zones == zone
            found = {int(np.argmax(np.where(here[:, None], size, -1.0))) for size in (section.thickness, off)}
            out += [section.one(np.unravel_index(place, off.shape)) for place in sorted(found)]
        return out

    def key(self, points: np.ndarray) -> np.ndarray:
        """What tells elements apart by their sections at local points, (n_elements, n), free of units."""
        if not self.field.varies:
            return self.zones[:, None].astype(float)
        section, n = self.at(points), len(self.zones)
        arrays = [section.z]
        if self.field.varies_in_material:
            arrays += [section.stiffness, section.density, section.expansion, section.thinning]
        sizes = [np.abs(each).max() or 1.0 for each in arrays]
        parts = [each.reshape(n, -1) / size for each, size in zip(arrays, sizes, strict=True)]
        return np.hstack([self.zones[:, None], *parts])


def section_on(geometry: Geometry, section: Section | SectionField) -> Section | SectionsOnMesh:
    """A section on a mesh: one that is everywhere the same is that on every mesh."""
    return SectionsOnMesh(section, geometry) if isinstance(section, SectionField) else section


def zones_of_elements(geometry: Geometry, field: SectionField) -> np.ndarray:
    """The number of each element's zone, (n_elements,), checked."""
    points = geometry.theory.quadrature[0]
    places = geometry.parameters(points)
    rest = len(field.zones)
    out = np.full(geometry.n_elements, rest)
    for number, zone in enumerate(field.zones):
        held = zone.holds(places, geometry.closed_bounds())
        _require_lines(geometry, zone, held)
        inside = held.all(axis=1)
        if not inside.any():
            raise InputError(f"zone {zone.name!r}: no element of the mesh is in it; its place is in the parameter plane, "
                             f"over {_bounds(geometry)}")  # fmt: skip
        if (twice := inside & (out < rest)).any():
            first = int(np.argmax(twice))
            raise overlap(field.zones[out[first]], zone, places[:, first].mean(axis=1))
        out[inside] = number
    if not field.covers and (open_ := np.flatnonzero(out == rest)).size:
        raise _gap(field.zones, places[:, open_].mean(axis=2))
    return out


def _require_lines(geometry: Geometry, zone: Zone, held: np.ndarray) -> None:
    """InputError where a zone, which holds some integration points (n_elements, n), cuts elements."""
    corners = geometry.mesh.p[:, geometry.mesh.t]
    low, high = corners.min(axis=1), corners.max(axis=1)
    cut = held.any(axis=1) & ~held.all(axis=1)
    for axis, side, crossed in _crossed(geometry, zone, low, high):
        wrong = np.flatnonzero(crossed & (cut | ~askew(geometry.mesh)))
        if wrong.size:
            name, element = "xy"[axis], int(wrong[0])
            raise InputError(f"zone {zone.name!r} ends at {name} = {side:.6g}, which is no line of the mesh: element "
                             f"{element} reaches from {name} = {low[axis, element]:.6g} to {high[axis, element]:.6g}; put "
                             "a line there, as sk.meshes.with_lines(surface, nx, ny, zones) does")  # fmt: skip
    if cut.any():
        element = int(np.argmax(cut))
        x, y = corners[:, :, element].mean(axis=1)
        raise InputError(f"zone {zone.name!r} ends inside element {element}, near (x, y) = ({x:.6g}, {y:.6g}): zones "
                         "consist of whole elements; give the mesh lines along its border, or another border")  # fmt: skip


def _crossed(geometry: Geometry, zone: Zone, low: np.ndarray, high: np.ndarray) -> Iterator[tuple[int, float, np.ndarray]]:
    """Direction and coordinate of each side of a zone, and the elements (n_elements,) that a line along it would cut, of
    those that the zone reaches into; they lie between ``low`` and ``high``, each (2, n_elements)."""
    slack = ONE_PLACE * np.ptp(geometry.mesh.p, axis=1)[:, None]
    for part in zone.parts(geometry.closed_bounds()):
        lower, upper = part.T[:, :, None]
        reached = ((low < upper - slack) & (high > lower + slack)).all(axis=0)
        for axis, sides in enumerate(part.tolist()):
            for side in sides:
                yield axis, side, reached & (low[axis] < side - slack[axis]) & (high[axis] > side + slack[axis])


def _gap(zones: tuple[Zone, ...], places: np.ndarray) -> InputError:
    """Places (2, n) in no zone; the zones that are nearest to the first are named."""
    place = places[:, 0]
    nearest = [repr(zone.name) for zone in sorted(zones, key=lambda zone: _distance(zone, place))[:2]]
    return InputError(f"zones: none holds (x, y) = ({place[0]:.6g}, {place[1]:.6g}), next to {' and '.join(nearest)}, and "
                      "the problem has no section of its own; close the gap, or give the problem a thickness and a material "
                      "for the rest")  # fmt: skip


def _distance(zone: Zone, place: np.ndarray) -> float:
    """Of a place (2,) from a rectangle; infinite where a function tells the zone."""
    sides = zone.rectangle
    return float("inf") if sides is None else float(np.linalg.norm(place - np.clip(place, sides[:, 0], sides[:, 1])))


def _bounds(geometry: Geometry) -> str:
    (x0, y0), (x1, y1) = geometry.mesh.p.min(axis=1), geometry.mesh.p.max(axis=1)
    return f"x from {x0:.6g} to {x1:.6g}, y from {y0:.6g} to {y1:.6g}"
