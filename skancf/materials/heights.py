"""Heights in a section, as numbers or names."""

from skancf.errors import InputError, number
from skancf.materials.section import Section

Depth = float | str
DEPTHS = ("top", "middle", "bottom")
"""A height z (m), or ``"top"``, ``"middle"`` or ``"bottom"``."""


def depth_of(section: Section, z: Depth) -> float:
    """A height in a section (m), given as a number or a name; InputError outside of the faces."""
    if isinstance(z, str):
        bottom, top = section.z[[0, -1]].tolist()
        named = dict(zip(DEPTHS, (top, 0.5 * (bottom + top), bottom), strict=True))
        if z not in named:
            raise InputError(f"z = {z!r}: give a depth (m), or one of {', '.join(map(repr, named))}")
        return float(named[z])
    if number("z", z):
        section.layer_at(z)
    return float(z)
