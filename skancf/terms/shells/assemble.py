"""Which shell term belongs to which theory."""

from skancf.kernels.schedule import Schedule
from skancf.layout.geometry import Geometry
from skancf.layout.zones import section_on
from skancf.materials import Section, SectionField
from skancf.terms.protocols import Assembly
from skancf.terms.shells.full import FullAssembly
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.theories import Full, Kirchhoff

ASSEMBLIES: dict[type, type] = {Full: FullAssembly, Kirchhoff: ThinAssembly}


def assemble(geometry: Geometry, section: Section | SectionField) -> Assembly:
    """The assembly of the geometry's theory."""
    schedule = Schedule(geometry.nodes, geometry.mesh.p[:, geometry.mesh.t].mean(axis=1))
    made: Assembly = ASSEMBLIES[type(geometry.theory)](geometry, section_on(geometry, section), schedule)
    return made
