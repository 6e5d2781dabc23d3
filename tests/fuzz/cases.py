"""Strategies for whole cases."""

from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

import skancf as sk
from fuzz import bodies, conditions
from fuzz.bodies import among, decades
from fuzz.case import Case
from fuzz.shapes import extent
from fuzz.transforms import in_units, needs_axes


class Range(NamedTuple):
    """Decades of slenderness (length over thickness) and of the load in multiples of E h^4 / L^4."""

    slenderness: tuple[int, int]
    load: tuple[int, int]


EVERYTHING = Range((0, 6), (-10, 10))
NONLINEAR = EVERYTHING
"""What nonlinear statics is asked for: everything. Thin films, small loads and large ones end in balance, or say why not."""


def slender(decades_of: tuple[int, int]) -> st.SearchStrategy[float]:
    # A plate as thick as it is long is no plate; the first decade begins at five.
    return decades(*decades_of).map(lambda ratio: max(ratio, 5.0))


UNITS = among((1.0, 1.0), (1e3, 1.0), (1e3, 1e-3), (1.0, 1e-3))


@st.composite
def cases(
    draw: Any, within: Range = EVERYTHING, surfaces: tuple[str, ...] = bodies.ALL, kinds: tuple[str, ...] = conditions.EVERY,
    theories: st.SearchStrategy[Any] = conditions.THEORIES, plain: bool = False, moved: bool = True, springs: bool = True,
    most: int = 4, units: bool = True,
) -> Case:  # fmt: skip
    """A supported and loaded body."""
    surface = draw(st.one_of(*[bodies.SURFACES[name] for name in surfaces]))
    section = draw(bodies.sections(slender(within.slenderness)))
    mesh = draw(bodies.meshes(surface, plain, most))
    supports = draw(conditions.supports(surface, mesh, section, moved, springs))
    size = draw(decades(*within.load))
    found = draw(st.lists(conditions.loads(surface, section, size, kinds), min_size=1, max_size=3))
    problem = sk.Problem(surface, section.thickness, section.material, supports, found)
    case = Case(problem, mesh, draw(theories))
    return in_units(case, *draw(UNITS)) if units else case


@st.composite
def free_bodies(draw: Any) -> Case:
    """A body without supports and loads, from thick to thin."""
    case = draw(cases(Range((0, 4), (0, 1)), plain=False))
    return replace(case, problem=replace(case.problem, supports=[], loads=[]))


class Frame(NamedTuple):
    turn: Any
    shift: Any


@lru_cache
def _proper(seed: int) -> np.ndarray:
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


@st.composite
def framed(draw: Any, mirror: bool, **options: Any) -> tuple[Case, Frame]:
    """A case and a frame in which it can be stated."""
    case = draw(cases(**options))
    if needs_axes(case):
        order = draw(st.permutations(range(3)))
        turn = np.eye(3)[list(order)]
        turn[0] *= np.linalg.det(turn)
        turn[1:] *= draw(among(1, -1))
    else:
        turn = _proper(draw(st.integers(0, 20)))
    if mirror:
        turn = turn @ np.diag([1.0, 1.0, -1.0])
    return case, Frame(turn, extent(case.problem.surface) * np.array(draw(among((0.0, 0.0, 0.0), (1.0, -2.0, 0.5)))))


@st.composite
def parted(draw: Any, **options: Any) -> tuple[Case, Case]:
    """A half with a plane of symmetry, and the whole that it is half of."""
    section = draw(bodies.sections(slender(options["within"].slenderness), uniform=True))
    kind, a, b = draw(among("rectangle", "cylinder", "annulus", "sphere")), draw(bodies.SIDES), draw(bodies.ANGLES) / 2
    # The second parameter runs from the plane of symmetry, y = 0, on.
    make = {
        "rectangle": lambda low, high: sk.Rectangle(a, high - low, origin=(0.0, low)),
        "cylinder": lambda low, high: sk.CylinderSector(1.0, a, high - low, low),
        "annulus": lambda low, high: sk.AnnulusSector(0.5, 0.5 + a, high - low, low),
        "sphere": lambda low, high: sk.SphereSector(1.0, (0.4, 1.1), high - low, low),
    }[kind]  # fmt: skip
    half, whole = make(0.0, b), make(-b, b)
    mesh = draw(bodies.meshes(half, plain=True))
    y = np.array(mesh.y)
    both = replace(mesh, y=tuple(((1 + np.concatenate([-y[:0:-1], y])) / 2).tolist()))
    names = half.sides
    held = draw(among(sk.Clamp(names[0]), sk.SimpleSupport(names[0]), sk.SimpleSupport(names[0], "hard")))
    if isinstance(held, sk.SimpleSupport) and draw(st.booleans()):
        held = sk.Clamp([names[0], names[1]])
    size = draw(decades(*options["within"].load)) * section.young * section.total**4
    force = [size, -size, size]
    force[2 if kind == "cylinder" else 1] = 0.0  # the axis of space that is normal to the plane y = 0
    loads = [draw(among(sk.SurfaceLoad(tuple(force)), sk.EdgeLoad(names[1], tuple(force)), sk.FollowerPressure(size)))]
    outer = [sk.Pin(names[3])] if draw(st.booleans()) else []
    mirrored = [sk.Pin(names[2]), *outer] if outer else []
    theory = draw(among("kirchhoff", "full"))
    of = section.thickness, section.material
    return (
        Case(sk.Problem(half, *of, [held, sk.Symmetry(names[2]), *outer], loads), mesh, theory),
        Case(sk.Problem(whole, *of, [held, *mirrored], loads), both, theory),
    )
