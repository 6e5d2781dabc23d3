"""Which shell term belongs to which theory."""

from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import section_on
from skancf.materials import Section, SectionField
from skancf.terms.protocols import Assembly
from skancf.terms.shells.full import FullAssembly
from skancf.terms.shells.full_points import FullPointAssembly
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.terms.shells.kirchhoff_points import ThinPointAssembly
from skancf.theories import Full, Kirchhoff

ASSEMBLIES: dict[tuple[type, bool], type] = {
    (Full, False): FullAssembly, (Full, True): FullPointAssembly,
    (Kirchhoff, False): ThinAssembly, (Kirchhoff, True): ThinPointAssembly,
}  # fmt: skip
"""By theory, and whether the section has a law at points."""


def assemble(geometry: Geometry, section: Section | SectionField) -> Assembly:
    """The assembly of the geometry's theory."""
    schedule = Schedule(geometry.nodes, geometry.mesh.p[:, geometry.mesh.t].mean(axis=1))
    place = section_on(geometry, section)
    made: Assembly = ASSEMBLIES[type(geometry.theory), section.points_law is not None](geometry, place, schedule)
    return made
