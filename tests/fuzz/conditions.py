"""Strategies for supports and loads, and for theories."""

from typing import Any

from hypothesis import strategies as st

import skancf as sk
from fuzz.bodies import FRACTIONS, Section, among
from fuzz.case import Mesh, place
from fuzz.shapes import open_sides

DIRECTIONS = among((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (1.0, -2.0, 0.5))
KINDS, ROLLS = among("soft", "hard"), among("soft", "soft", "hard")
"""Kinds of simple supports and of rollers, of which hard ones in the surface are refused."""
THEORIES = among("kirchhoff", "full", "kirchhoff", "full", sk.Kirchhoff(assumed=False), sk.Full(assumed=False))


@st.composite
def nodes(draw: Any, surface: Any, mesh: Mesh) -> tuple[float, float]:
    """A node of the mesh before it is refined."""
    x, y = draw(st.integers(0, len(mesh.x) - 1)), draw(st.integers(0, len(mesh.y) - 1))
    return place(surface, (mesh.x[x], mesh.y[y]))


@st.composite
def supports(draw: Any, surface: Any, mesh: Mesh, section: Section, moved: bool = True, springs: bool = True) -> list[Any]:
    """One that mostly holds the body alone, and up to two more; some displacement is prescribed if ``moved``."""
    sides = open_sides(surface)
    out = draw(_holding(sides, surface, mesh, section, springs))
    for _ in range(draw(st.integers(0, 2))):
        out += draw(_more(sides, surface, mesh, section, springs))
    if moved and len(sides) > 1 and draw(st.integers(0, 3)) == 0:
        h = section.total
        u = draw(among((0.0, 0.0, h), (None, None, -h), (0.1 * h, None, 0.0), (-1e-3 * h, 1e-3 * h, 0.3 * h)))
        held = draw(among(*sides))
        out = [s for s in out if not (isinstance(s, sk.Pin | sk.Clamp | sk.SimpleSupport | sk.Symmetry))]
        out += [sk.Clamp(next(side for side in sides if side != held)), sk.Prescribed(held, u)]
    return out


def _holding(sides: list[str], surface: Any, mesh: Mesh, section: Section, springs: bool) -> st.SearchStrategy[list[Any]]:
    stiffness = section.young * section.total**3
    around = st.builds(sk.Spring, st.just(sides[0] if sides else (0.0, 0.0)), st.just((stiffness, 2 * stiffness, stiffness)))
    point = nodes(surface, mesh).map(lambda at: [sk.Clamp(at)])
    if not sides:
        return point
    side = among(*sides)
    found = [
        side.map(lambda s: [sk.Clamp(s)]),
        st.builds(lambda kind: [sk.SimpleSupport("boundary", kind)], KINDS),
        st.just([sk.Clamp("boundary")]),
        st.builds(lambda a, b: [sk.Pin(a), sk.SimpleSupport(b)], side, side),
        st.builds(lambda s, d, k: [sk.Clamp(s), sk.Roller("boundary", d, k)], side, DIRECTIONS, ROLLS),
        st.builds(lambda s, d, e: [sk.Roller("boundary", d), sk.Roller(s, e)], side, DIRECTIONS, DIRECTIONS),
        st.just([sk.Pin("corners")]) if len(sides) == 4 else point,
        point,
    ]
    return st.one_of(*found, around.map(lambda spring: [spring])) if springs else st.one_of(*found)


def _more(sides: list[str], surface: Any, mesh: Mesh, section: Section, springs: bool) -> st.SearchStrategy[list[Any]]:
    stiffness = section.young * section.total**3
    at, factor = nodes(surface, mesh), among(1e-3, 1.0, 1e3).map(lambda f: f * stiffness)
    found: list[st.SearchStrategy[Any]] = [st.builds(sk.Pin, at), st.builds(sk.Roller, at, DIRECTIONS)]
    if springs:
        found += [
            st.builds(sk.Foundation, factor, st.none() | DIRECTIONS),
            st.builds(lambda at, k: sk.Spring(at, (k, 0.0, 2 * k)), at, factor),
        ]
    if sides:
        side = among(*sides)
        found += [
            st.builds(sk.Roller, side, DIRECTIONS, ROLLS), st.builds(sk.Symmetry, side), st.builds(sk.NoRotation, side),
            st.builds(sk.SimpleSupport, side, KINDS),
        ]  # fmt: skip
    return st.one_of(*found).map(lambda support: [support])


DEAD = ("point", "disk", "line", "surface", "edge", "gravity", "moment")
EVERY = (*DEAD, "pressure", "temperature")


@st.composite
def loads(draw: Any, surface: Any, section: Section, size: float, kinds: tuple[str, ...] = EVERY) -> Any:
    """A load of so many times the pressure E h^4 / L^4 that bends a plate of one metre by about its thickness."""
    h, young = section.total, section.young
    pressure, sides = size * young * h**4, open_sides(surface)
    kind, direction = draw(among(*kinds)), draw(DIRECTIONS)
    force = tuple(pressure * d for d in direction)
    at = place(surface, draw(st.tuples(FRACTIONS, FRACTIONS)))
    if kind in ("edge", "moment") and not sides:
        kind = "surface"
    if kind == "point":
        return sk.PointForce(at, force)
    if kind == "disk":
        return sk.DiskForce(place(surface, draw(among((0.5, 0.5), (0.3, 0.6)))), 0.05, force)
    if kind == "line":
        return sk.LineLoad(at, place(surface, draw(among((0.4, 0.6), (0.95, 0.05)))), force)
    if kind == "edge":
        return sk.EdgeLoad(draw(among(*sides)), force)
    if kind == "moment":
        return sk.EdgeMoment(draw(among(*sides)), force)
    if kind == "gravity":
        material = section.material
        density = (material.layers[0].material if isinstance(material, sk.Laminate) else material).density
        return sk.Gravity(tuple(f / (density * h) for f in force))
    if kind == "pressure":
        return sk.FollowerPressure(draw(among(1, -1)) * pressure)
    if kind == "temperature":
        # Strains above a tenth are no material's.
        change = min(size * h**2, 0.1) / 1e-5
        return draw(among(sk.Temperature(change), sk.Temperature(gradient=change / h), sk.Temperature(-change, change / h)))
    return sk.SurfaceLoad(force)
