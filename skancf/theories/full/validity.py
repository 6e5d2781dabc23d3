"""What sections theory `full` does not fit."""

import numpy as np

from skancf.errors import warn
from skancf.materials import Section

OFF = 0.25
"""Offset over thickness from which theory `full` needs more elements: a strip of 16 bends 1 % less at an offset of one
thickness, 12 % less at five."""


def warn_if_off(section: Section) -> None:
    r"""A warning where the stiffness of layers is so far off the surface that theory `full` locks on coarse meshes: by
    :math:`B_{ii} / A_{ii}`, which is the offset of layers of one material, over the thickness that bends."""
    abd, thickness = section.abd(), section.bending_thickness
    ratios = abd[:3, 3:].diagonal()[:2] / abd[:3, :3].diagonal()[:2]
    off = float(ratios[np.argmax(np.abs(ratios))])
    if abs(off) > OFF * thickness:
        warn(
            f"theory 'full' with the stiffness of its layers {off:.3g} m off the reference surface, and a thickness of "
            f"{thickness:.3g} m as far as bending goes, is too stiff on coarse meshes: refine until the answer stays, take "
            "the surface through their neutral surface (offset of a laminate), or theory 'kirchhoff', which is not, where "
            "the plate is thin"
        )
