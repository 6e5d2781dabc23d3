"""Sections made of materials."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skancf.errors import InputError, positive
from skancf.materials.law import require_law, stiffness_of, thinning_of
from skancf.materials.own_point_law import point_law_of
from skancf.materials.point_law import is_point_law
from skancf.materials.section import Section


def section_of(material: Any, thickness: float | None) -> Section:
    """The section of a plate: one layer about its mid-surface, or the layers that the material brings.

    Parameters
    ----------
    material : Law or Laminate
    thickness : float or None
        Of the plate, for a law (m); None for a laminate.

    Raises
    ------
    InputError
        For a law without a thickness, a laminate with one, and a material that is neither.
    """
    if callable(getattr(material, "section", None)) and not isinstance(material, type):
        if thickness is not None:
            raise InputError(f"thickness = {thickness}: a laminate brings its own, the sum of its layers'; leave it out")
        return material.section()
    if not is_point_law(material):
        require_law(material)
    if thickness is None:
        raise InputError(f"thickness: missing; a plate of one material ({type(material).__name__}) needs a thickness")
    half = positive("thickness", thickness, "m") / 2
    if is_point_law(material):
        law = point_law_of(material)
        one = stack([-half, half], [law.stiffness()], [law.density], [law.thermal_strain()], [law.thinning()])
        return replace(one, points_law=law)
    return stack([-half, half], [stiffness_of(material)], [material.density], [material.thermal_strain()],
                 [thinning_of(material)])  # fmt: skip


def stack(
    z: Any, stiffness: Sequence[Any], density: Sequence[float], expansion: Sequence[Any], thinning: Sequence[Any]
) -> Section:
    """A section from lists."""
    return Section(np.array(z), np.array(stiffness), np.array(density), np.array(expansion), np.array(thinning))
