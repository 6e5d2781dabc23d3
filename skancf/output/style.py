"""How pictures look."""

from dataclasses import dataclass

import numpy as np

from skancf.arguments import choice, flag, instance, texts, whole
from skancf.errors import InputError, number, vector
from skancf.materials.heights import DEPTHS, Depth
from skancf.output.fields import check_name, words
from skancf.output.sampling import grid
from skancf.showing import short
from skancf.solution import Solution
from skancf.units import Units

MOST_PIXELS = 16_384
"""In one direction; graphics drivers draw no larger pictures."""


@dataclass(frozen=True)
class Style:
    """How pictures look.

    Parameters
    ----------
    field : str
        ``"displacement"`` and ``"velocity"`` (lengths of the vectors), ``"u1"`` to ``"u3"``, ``"v1"`` to ``"v3"``,
        stresses ``"S11"``, ``"S22"``, ``"S33"``, ``"S23"``, ``"S13"``, ``"S12"`` in the local frame, ``"mises"``,
        strains ``"E11"``, ... in the same order, section forces ``"N11"``, ``"N22"``, ``"N12"``, ``"M11"``, ``"M22"``,
        ``"M12"``, ``"Q1"``, ``"Q2"``, and ``"thickness"``.
    z : float or {"top", "middle", "bottom"}, optional
        Depth of the surface that is drawn and of its field (m). Default: stresses and strains are those of the top face,
        and von Mises' stress is the largest through the thickness, drawn on the reference surface as all other fields. The
        title and the colour bar say which.
    scale : float
        Factor of the displacements that are drawn.
    limits : (2,) tuple, optional
        Smallest and largest value of the colours. Default: those of the field, made symmetric about zero where it has
        both signs.
    view : (3,) tuple
        Direction from the plate to the eye.
    show_mesh, show_undeformed : bool
        Draw the edges of elements, as the curves they are; draw the undeformed ones too, in grey.
    title : str, optional
        Default: field, depth, and time or load factor; that an answer is one of small deflections, or a mode, which has no
        size of its own. ``""``: none.
    subdivisions : int, optional
        Cells along an element's edge. Default: by the number of elements.
    size : (2,) tuple of int
        Pixels.
    units : Units, optional
        Of the colour bar. Default: those of SI, stresses with a prefix.

    Examples
    --------
    >>> sk.output.Style(field="S11", z="top", scale=10.0).field
    'S11'
    """

    field: str = "displacement"
    z: Depth | None = None
    scale: float = 1.0
    limits: tuple[float, float] | None = None
    view: tuple[float, float, float] = (-0.55, -1.0, 0.62)
    show_mesh: bool = True
    show_undeformed: bool = True
    title: str | None = None
    subdivisions: int | None = None
    size: tuple[int, int] = (1400, 1000)
    units: Units | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        check_name(self.field)
        if isinstance(self.z, str):
            choice("z", self.z, DEPTHS)
        elif self.z is not None:
            number("z", self.z)
        number("scale", self.scale)
        if not np.any(vector("view", self.view, 3)):
            raise InputError(f"view = {self.view}: give a direction, such as (0, 0, 1) to look from above")
        if self.limits is not None and not np.diff(vector("limits", self.limits, 2))[0] > 0:
            raise InputError(f"limits = {self.limits}: give the smaller value first")
        if self.subdivisions is not None:
            grid(self.subdivisions)
        for name in ("show_mesh", "show_undeformed"):
            flag(name, getattr(self, name))
        texts(title=self.title)
        if self.units is not None:
            instance("units", self.units, Units, "names of units, as in sk.Units(length='mm', stress='MPa')")
        for pixels in vector("size", self.size, 2):
            whole("size", pixels, most=MOST_PIXELS, floats=True)


def title_of(solution: Solution, style: Style, where: str) -> str:
    parts = [f"{words(style.field)}, {where}" if where else words(style.field)]
    if solution.note:
        parts.append(solution.note)
    if solution.linear:
        parts.append("small deflections")
    if solution.time is not None:
        parts.append(f"t = {solution.time:.4g} s")
    elif solution.load_factor != 1 and not (solution.note and solution.load_factor == 0):
        parts.append(f"load factor {solution.load_factor:.4g}")
    if style.scale != 1:
        parts.append(f"displacements x {style.scale:.4g}")
    return ", ".join(parts)
