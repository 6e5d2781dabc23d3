"""Heights in a section, as numbers or names."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.errors import InputError, number
from skancf.materials.section import Section


@dataclass(frozen=True)
class Interface:
    """The height of an interface or face of a section, by its number from the bottom face, and a part of the thickness."""

    number: int
    above: float = 0.0


Depth = float | str | Interface
DEPTHS = ("top", "middle", "bottom")
"""A height z above the reference surface (m), or ``"top"``, ``"middle"`` or ``"bottom"``, of a field each place's own."""
ABOVE = 1e-9
"""Of the thickness: this far above an interface the law is that of the upper layer."""


def depth_of(section: Section, z: Depth) -> Any:
    """A height in a section (m), given as a number or a name; InputError outside of the faces.

    Of a section at many places a name means a height at each, a number the same height at all.
    """
    if isinstance(z, str):
        bottom, top = section.z[..., 0], section.z[..., -1]
        named = dict(zip(DEPTHS, (top, 0.5 * (bottom + top), bottom), strict=True))
        if z not in named:
            raise InputError(f"z = {z!r}: give a depth (m), or one of {', '.join(map(repr, named))}")
        height = np.asarray(named[z])
        return height if height.ndim else float(height)
    if isinstance(z, Interface):
        return np.minimum(section.z[..., z.number] + z.above * section.thickness, section.z[..., -1])
    if number("z", z):
        section.layer_at(z)
    return float(z)


def unlike_faces(section: Section) -> InputError:
    """Strain or law differ through the thickness, and no depth was given."""
    bottom, top = ("" if section.places is not None else f" ({z:.6g} m)" for z in section.z[[0, -1]])
    return InputError(f"z: stress and strain differ from face to face; say where, as in z='top'{top}, z='bottom'{bottom}, "
                      "z='middle' or a number between (m)")  # fmt: skip
