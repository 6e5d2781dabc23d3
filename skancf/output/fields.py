"""Scalar fields by name, with their units."""

import numpy as np

from skancf.errors import InputError, number, shown
from skancf.materials import Section, SectionField
from skancf.materials.heights import ABOVE, DEPTHS, Depth, Interface, depth_of
from skancf.output.sampling import grid, sample_strain, sample_surface
from skancf.solution import STRESSES, Solution
from skancf.tensors import von_mises
from skancf.units import Units

STRAINS = tuple(name.replace("S", "E") for name in STRESSES)
VECTORS = {"displacement": ("u", "m"), "velocity": ("v", "m/s")}
FORCES = ("N11", "N22", "N12", "M11", "M22", "M12")
SHEAR = ("Q1", "Q2")
NAMES = (*STRESSES, "mises", *STRAINS, *FORCES, *SHEAR, *VECTORS, "u1", "u2", "u3", "v1", "v2", "v3", "thickness")


def check_name(name: str) -> str:
    if not isinstance(name, str) or name not in NAMES:
        raise InputError(f"field = {shown(name)}: no such field; there are {', '.join(NAMES)}")
    return name


def unit(name: str) -> str:
    """The unit of a field; empty for strains."""
    if name in STRAINS:
        return ""
    if name == "thickness":
        return "m"
    if name in FORCES + SHEAR:
        return "N" if name[0] == "M" else "N/m"
    return next((unit for vector, (short, unit) in VECTORS.items() if name == vector or name[0] == short), "Pa")


def words(name: str) -> str:
    """A field's name as a title has it."""
    named = {"N": "membrane force", "M": "moment", "Q": "shear force"}
    if name in FORCES + SHEAR:
        return f"{named[name[0]]} {name}"
    return {"mises": "von Mises stress", "displacement": "displacement", "velocity": "velocity"}.get(
        name, f"{'stress' if unit(name) == 'Pa' else 'strain'} {name}" if name[0] in "SE" else name
    )


def readable_unit(name: str, largest: float, units: Units | None = None) -> tuple[float, str]:
    """Factor and unit that show values up to ``largest``; stresses have a prefix for few digits where none was chosen."""
    return (units or Units()).with_stress(largest).of(unit(name))


def through(name: str) -> bool:
    """Does a field change through the thickness: stress, strain and von Mises' stress?"""
    return name == "mises" or name in STRESSES + STRAINS


def place(name: str, section: Section | SectionField, z: Depth | None) -> tuple[Depth, str]:
    """The depth that is meant by z, a number (m), or a name where each place has its own, and in words; without one the top
    face of stresses and strains, all depths for von Mises' stress, and the reference surface of what does not change through
    the thickness."""
    if z is None and not through(name):
        return 0.0, ""
    if z is None and name == "mises":
        return 0.0, "largest through the thickness"
    z = "top" if z is None else z
    if not isinstance(section, Section):
        said = z if z == "middle" else f"{z} face" if z in DEPTHS else f"z = {number('z', z):.4g} m"
        return z, said if through(name) or z else ""
    depth = depth_of(section, z)
    faces = {float(section.z[0]): "bottom face, ", float(section.z[-1]): "top face, "}
    shown = through(name) or depth
    return depth, f"{faces.get(depth, '')}z = {depth:.4g} m" if shown else ""


def largest_mises(solution: Solution, subdivisions: int) -> np.ndarray:
    """The largest von Mises stress through the thickness, (n,): stress is linear in each layer, and largest at its faces."""
    n = solution.system.assembly.section.at(grid(subdivisions).points).z.shape[-1]
    # At an interface the law is that of the layer below; a little higher it is the other one.
    depths = [*map(Interface, range(n)), *(Interface(k, ABOVE) for k in range(1, n - 1))]
    return np.max([von_mises(sample_strain(solution, subdivisions, z)[1]) for z in depths], axis=0)


def values(solution: Solution, name: str, subdivisions: int, z: Depth | None) -> np.ndarray:
    """A scalar field (n,) at the points of :func:`~skancf.output.sample`; of a vector its length; where z is None see
    :func:`place`."""
    check_name(name)
    if name == "mises" and z is None:
        return largest_mises(solution, subdivisions)
    z = place(name, solution.system.problem.section, z)[0]
    if through(name):
        strain, stress = sample_strain(solution, subdivisions, z)
        if name == "mises":
            return von_mises(stress)
        return stress[:, STRESSES.index(name)] if name in STRESSES else strain[:, STRAINS.index(name)]
    points = grid(subdivisions).points
    if name in FORCES:
        return solution.recovered_section_forces(points)[:, FORCES.index(name)].ravel()
    if name in SHEAR:
        return solution.shear_forces(points)[:, SHEAR.index(name)].ravel()
    if name == "thickness":
        here = solution.system.assembly.section.at(solution.system.geometry.inside(points)).thickness
        return np.broadcast_to(here, (solution.system.geometry.n_elements, points.shape[1])).ravel()
    surface = sample_surface(solution, subdivisions, z)
    vector = surface.displacement if name[0] in "du" else surface.velocity
    if vector is None:
        raise InputError(f"field = {name!r}: this state has no velocities; states of a motion have")
    return np.linalg.norm(vector, axis=1) if name in VECTORS else vector[:, int(name[1]) - 1]
