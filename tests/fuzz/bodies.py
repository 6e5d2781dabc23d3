"""Strategies for surfaces, sections and meshes, about one metre large."""

from itertools import combinations
from math import pi
from typing import Any, NamedTuple

from hypothesis import strategies as st

import skancf as sk
from fuzz.case import Mesh
from fuzz.shapes import barrel, torus


def among(*values: Any) -> st.SearchStrategy[Any]:
    return st.sampled_from(values)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers over decades, with one digit: they are read by people once they are found."""
    return st.builds(lambda n, m: float(f"{m}e{n}"), st.integers(int(low), int(high) - 1), among(1, 2, 5, 1.7, 3.3, 8.9))


SIDES = among(1.0, 0.7, 1.3, 2.0)
ANGLES = among(0.8, 0.3, 1.2, 1.9)
STARTS = among(0.0, 0.9, -0.4, pi / 2)
ROUND = st.fixed_dictionaries({"angle": st.just(2 * pi), "start": among(0.0, 0.7), "closed": st.just(True)})
SECTOR = st.fixed_dictionaries({"angle": ANGLES, "start": STARTS})


def _with(make: Any, rest: st.SearchStrategy[dict[str, Any]], *sizes: Any) -> st.SearchStrategy[Any]:
    return st.builds(lambda kw, *given: make(*given, **kw), rest, *sizes)


SURFACES: dict[str, st.SearchStrategy[Any]] = {
    "rectangle": st.builds(sk.Rectangle, SIDES, SIDES, among((0.0, 0.0), (-0.5, 0.2))),
    "parallelogram": st.builds(sk.Parallelogram, SIDES, SIDES, among(pi / 2, 1.0, 0.6, 2.2)),
    "cylinder": _with(sk.CylinderSector, SECTOR, among(1.0, 0.5, 5.0), SIDES),
    "tube": _with(sk.CylinderSector, ROUND, among(0.4, 1.0), SIDES),
    "slit tube": st.builds(sk.CylinderSector, among(0.4), SIDES, st.just(2 * pi)),
    "cone": _with(sk.Cone, st.one_of(SECTOR, ROUND), among(0.6, 0.4), among(1.0, 0.7), SIDES),
    "sphere": _with(sk.SphereSector, SECTOR, among(1.0, 2.0), among((0.4, 1.2), (1.0, 2.0))),
    "zone": _with(sk.SphereSector, ROUND, among(1.0, 2.0), among((0.4, 1.2), (1.0, 2.0))),
    "cap": _with(sk.SphereSector, ROUND, among(1.0, 2.0), among((0.0, 0.8), (0.0, 1.5))),
    "hemisphere's quarter": st.builds(sk.SphereSector, among(1.0), among((0.0, pi / 2)), st.just(pi / 2)),
    "annulus": _with(sk.AnnulusSector, SECTOR, among(0.5, 0.2), among(1.0, 1.5)),
    "ring": _with(sk.AnnulusSector, ROUND, among(0.5, 0.2), among(1.0, 1.5)),
    "disc": _with(sk.AnnulusSector, ROUND, st.just(0.0), among(1.0, 1.5)),
    "saddle": st.builds(sk.HyperbolicParaboloid, SIDES, SIDES, among(0.1, 0.4, -0.2)),
    "barrel": st.builds(barrel, SIDES, SIDES, among(0.2, 0.05, -0.3)),
    "torus": st.builds(torus, among(1.0), among(0.3, 0.5)),
}  # fmt: skip
ALL = tuple(SURFACES)
AFFINE = ("rectangle", "parallelogram")


class Section(NamedTuple):
    """A material, or a laminate, with its thickness and a size of its moduli."""

    material: Any
    thickness: float | None
    total: float
    young: float


POISSON = among(0.3, 0.0, 0.45, -0.2)


@st.composite
def laws(draw: Any, young: float, kind: str | None = None) -> Any:
    """A law whose moduli are about ``young``."""
    kind = kind or draw(among("isotropic", "isotropic", "orthotropic", "anisotropic"))
    density, expansion, law = draw(among(1000.0, 7800.0)), 1e-5, draw(among("plane_stress", "plane_stress", "3d"))
    angle = draw(among(0.0, 0.4, -1.1))
    if kind == "isotropic":
        return sk.Isotropic(young, draw(POISSON), density, law, expansion=expansion)
    if kind == "orthotropic":
        weak = draw(among(0.5, 0.1, 1.0))
        return sk.Orthotropic(
            (young, weak * young, weak * young), (0.25, 0.2, 0.3), (0.3 * young, 0.3 * young, 0.2 * young), density, angle,
            law, expansion=(expansion, 2 * expansion, 0.0),
        )  # fmt: skip
    entries = draw(st.lists(st.integers(-3, 3), min_size=15, max_size=15))
    rows = [[0.0] * 6 for _ in range(6)]
    for k, (i, j) in enumerate(combinations(range(6), 2)):
        # Dominant diagonals keep the law definite; those of shear are about a third.
        rows[i][j] = rows[j][i] = 0.02 * young * entries[k]
    for i in range(6):
        rows[i][i] = young * (1.0 if i < 3 else 0.4)
    return sk.Anisotropic(tuple(map(tuple, rows)), density, angle, law, expansion=(expansion,) * 3 + (0.0,) * 3)


@st.composite
def sections(draw: Any, slenderness: st.SearchStrategy[float], uniform: bool = False) -> Section:
    """One law, or a laminate of two or three layers on or off the reference surface, so many times thinner than a metre."""
    young, total = draw(among(1e7, 2e11)), 1.0 / draw(slenderness)
    if uniform or draw(st.integers(0, 3)):
        return Section(draw(laws(young, "isotropic" if uniform else None)), total, total, young)
    parts = draw(among((0.5, 0.5), (0.25, 0.5, 0.25), (0.6, 0.3, 0.1)))
    layers = [sk.Layer(draw(laws(young)), part * total, draw(among(0.0, pi / 2, 0.5))) for part in parts]
    return Section(sk.Laminate(layers, draw(among(0.0, 0.0, 0.5, -0.3)) * total), None, total, young)


LINES = {
    "uniform": lambda n: tuple(k / n for k in range(n + 1)),
    "graded": lambda n: tuple((k / n) ** 1.6 for k in range(n + 1)),
    "uneven": lambda n: (*(k / n for k in range(n)), 1.0 - 0.2 / n, 1.0) if n > 1 else (0.0, 0.7, 1.0),
}
FRACTIONS = among(0.5, 0.25, 0.1, 0.87, 1 / 3, 0.0, 1.0)


@st.composite
def meshes(draw: Any, surface: Any, plain: bool = False, most: int = 4) -> Mesh:
    """Two to ``most`` elements along a side, more around a closed one; hanging nodes or an opening unless ``plain``."""
    rows = []
    for closed, (low, high) in zip(surface.closed, surface.bounds, strict=True):
        turn = closed or (high - low > 3 and not hasattr(surface, "length_x"))
        rows.append(LINES[draw(among(*LINES))](draw(st.integers(6 if turn else 2, 6 if turn else most))))
    x, y = rows
    kind = "plain" if plain else draw(among("plain", "plain", "quadtree", "quadtree", "opening"))
    if kind == "quadtree":
        points = draw(st.lists(st.tuples(FRACTIONS, FRACTIONS), min_size=1, max_size=2))
        return Mesh(x, y, tuple(points))
    if kind == "opening" and len(x) > 3 and len(y) > 3:
        return Mesh(x, y, opening=(1, len(x) - 2, 1, len(y) - 2))
    return Mesh(x, y)
