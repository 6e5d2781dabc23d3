r"""Sections that vary over a surface: thickness, offset and material as functions of place, and zones.

Everything a section says (stiffness, mass, heights of the faces) is asked at places of the parameter plane, and is that of
the functions there: no polynomial stands between. Integration points ask once, when a system is made.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from skancf.errors import InputError, number, shown
from skancf.functions import ONE_POINT, Noted, is_function, values_at
from skancf.materials.made import section_of
from skancf.materials.point_law import PointLaw, is_point_law
from skancf.materials.section import Section
from skancf.materials.zone_laws import LawsOfZones, LinearAtPoints
from skancf.materials.zones import Zone
from skancf.showing import short


@dataclass(frozen=True)
class Given:
    """What the section of a part of the surface is made of: constants, and functions of the parameters (x, y).

    Parameters
    ----------
    name : str
        Of a zone; empty for the plate.
    material, thickness, offset
        As those of :class:`~skancf.Problem`.
    """

    name: str
    material: Any
    thickness: Any
    offset: Any
    law: PointLaw | None = field(default=None, init=False)
    """The material as a law at points; None of others."""

    def __post_init__(self) -> None:
        with self._noted():
            if not is_function(self.offset):
                number("offset", self.offset)
            if not is_function(self.material):
                any_will_do = is_function(self.thickness) and not brings_thickness(self.material)
                made = section_of(self.material, 1.0 if any_will_do else self.thickness)
                object.__setattr__(self, "law", made.points_law)

    @property
    def varies(self) -> bool:
        """Whether anything is a function."""
        return any(map(is_function, (self.material, self.thickness, self.offset)))

    def at(self, places: np.ndarray) -> "Layers":
        """Arrays of the sections at places (2, n) of the parameter plane.

        Raises
        ------
        InputError
            For a thickness that is not positive at some, and for values that are no numbers, laws or laminates.
        """
        with self._noted():
            kinds, which = self._materials(places)
            made = Layers(*(np.stack(each)[which] for each in zip(*kinds, strict=True)))
            heights = made.z
            if self.thickness is not None:
                heights = heights * self._thickness(places)[:, None]
            return made._replace(z=heights + _values("offset", self.offset, places)[:, None])

    def _thickness(self, places: np.ndarray) -> np.ndarray:
        thickness = _values("thickness", self.thickness, places)
        if (thickness <= 0).any():
            least = int(np.argmin(thickness))
            x, y = places[:, least]
            raise InputError(f"thickness = {thickness[least]:.6g} at (x, y) = ({x:.6g}, {y:.6g}): a plate is thicker "
                             "than zero everywhere; end the surface before, or give the function a least value")  # fmt: skip
        return thickness

    def _materials(self, places: np.ndarray) -> tuple[list["Layers"], np.ndarray]:
        """Layers of all the materials in a part, of the thickness 1 where it is a law, and which of them is at each place
        (n,)."""
        if not is_function(self.material):
            return [self._made(self.material if self.law is None else self.law)], np.zeros(places.shape[1], dtype=int)
        known: dict[Any, int] = {}
        materials: list[Any] = []
        found: list[Layers] = []
        which = np.empty(places.shape[1], dtype=int)
        for k, (x, y) in enumerate(places.T.tolist()):
            with _Said(after=_at(x, y), before="material: "), Noted("material"):
                material = self.material(x, y)
            which[k] = known.setdefault(_key(material), len(found))
            if which[k] == len(found):
                materials.append(material)  # so that no other one has its id
                with _Said(after=_at(x, y)):
                    if is_point_law(material):
                        raise InputError(f"material: {type(material).__name__} is a law at points; a function of place "
                                         "gives linear laws or laminates, take zones for laws at points")  # fmt: skip
                    found.append(self._made(material))
        return filled_up(found), which

    def _made(self, material: Any) -> "Layers":
        """Of a material, of the thickness 1 where it is a law."""
        if self.thickness is not None and brings_thickness(material):
            raise InputError(f"material = {shown(material)}: a laminate brings its own thickness, and the problem has one "
                             "too; leave it out, or let the function return laws")  # fmt: skip
        return Layers.of(section_of(material, None if self.thickness is None else 1.0))

    def _noted(self) -> Any:
        return _Said(before=f"zone {self.name!r}: " if self.name else "")


def sections_of(material: Any, thickness: Any, offset: Any = 0.0, zones: Sequence[Zone] = ()) -> "Section | SectionField":
    """The section of a plate that is everywhere the same, or the field of sections of one that is not."""
    if zones or any(map(is_function, (material, thickness, offset))):
        return SectionField(material, thickness, offset, zones)
    return section_of(material, thickness).about(-number("offset", offset))


class SectionField:
    """The sections of a plate that is not everywhere the same, by place of the parameter plane.

    Parameters
    ----------
    material, thickness, offset
        Of what is in no zone, as those of :class:`~skancf.Problem`, and of a zone that says nothing else. With zones that
        cover everything they may be missing.
    zones : sequence of Zone

    Raises
    ------
    InputError
        For what is missing, with the name of the zone.

    Examples
    --------
    >>> steel = sk.Isotropic(210e9, 0.3, 7850.0)
    >>> blade = sk.Problem(sk.Rectangle(1.0, 0.1), lambda x, y: 0.02 - 0.01 * x, steel)
    >>> places = np.array([[0.0, 0.5, 1.0], [0.05, 0.05, 0.05]])
    >>> print(blade.section.at(places, np.full(3, -1)).thickness)
    [0.02  0.015 0.01 ]
    """

    def __init__(self, material: Any, thickness: Any, offset: Any, zones: Sequence[Zone] = ()):
        self.zones = tuple(zones)
        made = [Given(*_of_zone(zone, material, thickness, offset)) for zone in zones]
        self.covers = material is not None and (thickness is not None or brings_thickness(material) or not zones)
        self.given = [*made, *([Given("", material, thickness, offset)] if self.covers or not zones else [])]
        self._laws = laws_of(self.given)

    @property
    def points_law(self) -> Any:
        """The law at points, or those of all zones; None where all are linear."""
        return self._law_at(np.arange(len(self.given)))

    def _law_at(self, zones: np.ndarray) -> Any:
        """The law at places in zones of these numbers."""
        laws = self._laws
        return laws[0] if len(set(map(id, laws))) == 1 else LawsOfZones(laws, zones.ravel()) if laws else None

    @property
    def varies(self) -> bool:
        """Whether anything is a function of place within a zone."""
        return any(part.varies for part in self.given)

    @property
    def varies_in_material(self) -> bool:
        """Whether the material is one within a zone."""
        return any(is_function(part.material) for part in self.given)

    def at(self, places: np.ndarray, zones: Any) -> Section:
        """Sections at places (2, ...) in zones of these numbers, which broadcast to (...); the rest has the last number."""
        zones, flat = np.broadcast_to(zones, places.shape[1:]).ravel(), places.reshape(2, -1)
        present = np.unique(zones)
        groups = [np.flatnonzero(zones == zone) for zone in present]
        found = filled_up([self.given[zone].at(flat[:, group]) for zone, group in zip(present, groups, strict=True)])
        arrays = found[0] if found else NOWHERE
        if len(found) > 1:
            order = np.argsort(np.concatenate(groups), kind="stable")
            arrays = Layers(*(np.concatenate(each)[order] for each in zip(*found, strict=True)))
        shaped = (each.reshape(*places.shape[1:], *each.shape[1:]) for each in arrays)
        z, stiffness, density, expansion, thinning = shaped
        return Section(z, stiffness, density, expansion, thinning, self._law_at(zones), places=places)


class Layers(NamedTuple):
    """Arrays of sections, as :class:`~skancf.materials.Section` has them, with axes of places before or without."""

    z: np.ndarray
    stiffness: np.ndarray
    density: np.ndarray
    expansion: np.ndarray
    thinning: np.ndarray

    def __repr__(self) -> str:
        return short(self)

    @classmethod
    def of(cls, section: Section) -> "Layers":
        return cls(*(getattr(section, name) for name in cls._fields))

    def with_layers(self, n: int) -> "Layers":
        """With a given number of layers, by layers of no thickness on top."""
        more = n - self.density.shape[-1]
        if not more:
            return self
        axes = (-1, -3, -1, -2, -2)
        last = [np.take(each, [-1] * more, axis) for each, axis in zip(self, axes, strict=True)]
        return Layers(*map(np.concatenate, zip(self, last, strict=True), axes))


NOWHERE = Layers(*(np.empty((0, *shape)) for shape in ((2,), (1, 6, 6), (1,), (1, 6), (1, 3))))
"""Sections at no places."""


def filled_up(sections: Sequence[Layers]) -> list[Layers]:
    """All with as many layers as that of the most."""
    most = max((one.density.shape[-1] for one in sections), default=1)
    return [one.with_layers(most) for one in sections]


def laws_of(parts: Sequence[Given]) -> tuple[PointLaw, ...]:
    """Laws at points of all parts, equal ones as one; linear ones are asked at points too. None where all are linear.

    Raises
    ------
    InputError
        For a laminate, and for a material that is a function of place, together with a law at points.
    """
    known: dict[Any, PointLaw] = {}
    first = next((part for part in parts if part.law is not None), None)
    if first is None:
        return ()
    for part in parts:
        if brings_thickness(part.material) or is_function(part.material):
            name = f"zone {part.name!r}" if part.name else "the rest of the plate"
            what = "a laminate" if brings_thickness(part.material) else "a material that is a function of place"
            raise InputError(f"material: {name} has {what}, and {type(first.material).__name__} is a law at points, next to "
                             "which each zone has one law; give it one that is linear or a law at points")  # fmt: skip
        known.setdefault(_key(part.material), part.law or LinearAtPoints(part.material))
    return tuple(known[_key(part.material)] for part in parts)


def brings_thickness(material: Any) -> bool:
    """Whether a material is a laminate."""
    return callable(getattr(material, "section", None)) and not isinstance(material, type)


def _of_zone(zone: Zone, material: Any, thickness: Any, offset: Any) -> tuple[Any, ...]:
    """What a zone is made of: what it says itself, and what the problem says of the rest."""
    material = material if zone.material is None else zone.material
    if zone.thickness is not None or brings_thickness(material):
        thickness = zone.thickness
    return zone.name, material, thickness, offset if zone.offset is None else zone.offset


def _values(name: str, given: Any, places: np.ndarray) -> np.ndarray:
    """A constant or a function at places (2, n), (n,); errors of a function name the place."""
    try:
        return values_at(name, given, places)
    except InputError as wrong:
        for x, y in places.T:
            _tell(name, given, x, y)
        raise wrong


def _tell(name: str, given: Any, x: float, y: float) -> None:
    """InputError with the place, if something is wrong there; no word of a function that takes arrays only."""
    try:
        with _Said(_at(x, y)):
            values_at(name, given, np.array([x, y]))
    except ONE_POINT as wrong:
        if isinstance(wrong, InputError):
            raise


def _at(x: float, y: float) -> str:
    return f"; at (x, y) = ({x:.6g}, {y:.6g})"


class _Said:
    """Errors within say something more, after or before their message."""

    def __init__(self, after: str = "", before: str = ""):
        self.after, self.before = after, before

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, wrong: BaseException | None, trace: Any) -> None:
        if type(wrong) is InputError and (self.after or self.before):
            raise InputError(f"{self.before}{wrong}{self.after}") from wrong


def _key(material: Any) -> Any:
    """What equal materials have in common."""
    try:
        hash(material)
    except TypeError:
        return id(material)
    return material
