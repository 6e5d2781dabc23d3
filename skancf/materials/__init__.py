"""Laws: strain to stress, as pure functions at a point; sections: the layers through the thickness; damping."""

import importlib
from typing import TYPE_CHECKING, Any

from skancf.materials.damping import Damping
from skancf.materials.field import SectionField, sections_of
from skancf.materials.isotropic import Isotropic
from skancf.materials.laminate import Laminate, Layer
from skancf.materials.law import Anisotropic, Law
from skancf.materials.made import section_of
from skancf.materials.orthotropic import Orthotropic
from skancf.materials.point_law import BeyondLaw, PointLaw, PointResponse
from skancf.materials.section import Section
from skancf.materials.zones import Zone

if TYPE_CHECKING:
    from skancf.materials.hyperelastic import Gent, Hyperelastic, MooneyRivlin, NeoHooke, Ogden, Yeoh

ALL = [Isotropic, Orthotropic, Anisotropic]

__all__ = [
    "ALL", "Anisotropic", "BeyondLaw", "Damping", "Gent", "Hyperelastic", "Isotropic", "Laminate", "Law", "Layer",
    "MooneyRivlin", "NeoHooke", "Ogden", "Orthotropic", "PointLaw", "PointResponse", "Section", "SectionField", "Yeoh",
    "Zone", "section_of", "sections_of",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Laws of rubber are loaded when they are first used: most runs have none, and they are compiled code."""
    if name in __all__:
        return getattr(importlib.import_module("skancf.materials.hyperelastic"), name)
    raise AttributeError(f"module 'skancf.materials' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
