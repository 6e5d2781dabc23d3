"""What a section does not allow, whatever the loads are."""

from skancf.errors import warn
from skancf.system.system import System


def warn_if_mass_is_off(system: System) -> None:
    """A warning where theory `kirchhoff` has mass in the reference surface that is more than a hundredth of the thickness
    off it."""
    if not hasattr(system, "geometry") or system.geometry.theory.directors:
        return
    for section in system.assembly.section.samples():
        off = section.first_moment / section.mass if section.mass else 0.0
        if abs(off) <= section.thickness / 100:
            continue
        warn(
            f"theory 'kirchhoff' has its mass in the reference surface, and the centre of mass is {off:.3g} m off, with a "
            f"thickness of {section.thickness:.3g} m: take the surface through it (offset of a laminate), or theory 'full' "
            "on a fine mesh"
        )
        return
