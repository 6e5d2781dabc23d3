"""Scalar fields by name, with their units."""

import numpy as np

from skancf.errors import InputError, shown
from skancf.output.sampling import grid, sample_strain, sample_surface
from skancf.solution import STRESSES, Solution

STRAINS = tuple(name.replace("S", "E") for name in STRESSES)
VECTORS = {"displacement": ("u", "m"), "velocity": ("v", "m/s")}
FORCES = ("N11", "N22", "N12", "M11", "M22", "M12")
SHEAR = ("Q1", "Q2")
NAMES = (*STRESSES, "mises", *STRAINS, *FORCES, *SHEAR, *VECTORS, "u1", "u2", "u3", "v1", "v2", "v3")


def von_mises(stress: np.ndarray) -> np.ndarray:
    r"""Von Mises' equivalent of stresses in the order 11, 22, 33, 23, 13, 12: (..., 6) to (...), same unit.

    .. math:: \sigma_v^2 = \tfrac12 [(S_{11} - S_{22})^2 + (S_{22} - S_{33})^2 + (S_{33} - S_{11})^2]
                           + 3 (S_{23}^2 + S_{13}^2 + S_{12}^2)

    Of the second Piola-Kirchhoff stress it is the usual one where strains are small, however large rotations are.
    """
    s11, s22, s33, s23, s13, s12 = np.moveaxis(stress, -1, 0)
    return np.sqrt(0.5 * ((s11 - s22) ** 2 + (s22 - s33) ** 2 + (s33 - s11) ** 2) + 3 * (s23**2 + s13**2 + s12**2))


def check_name(name: str) -> str:
    if not isinstance(name, str) or name not in NAMES:
        raise InputError(f"field = {shown(name)}: no such field; there are {', '.join(NAMES)}")
    return name


def unit(name: str) -> str:
    """The unit of a field; empty for strains."""
    if name in STRAINS:
        return ""
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


def readable_unit(name: str, largest: float) -> tuple[float, str]:
    """Factor and unit, with a prefix for stresses, that show values up to ``largest`` in few digits."""
    if unit(name) != "Pa":
        return 1.0, unit(name)
    power = next((power for power in (9, 6, 3) if largest >= 10.0**power), 0)
    return 10.0**-power, {9: "GPa", 6: "MPa", 3: "kPa", 0: "Pa"}[power]


def values(solution: Solution, name: str, subdivisions: int, z: float) -> np.ndarray:
    """A scalar field (n,) at the points of :func:`~skancf.output.sample`; of a vector its length."""
    check_name(name)
    if name == "mises" or name in STRESSES + STRAINS:
        strain, stress = sample_strain(solution, subdivisions, z)
        if name == "mises":
            return von_mises(stress)
        return stress[:, STRESSES.index(name)] if name in STRESSES else strain[:, STRAINS.index(name)]
    points = grid(subdivisions).points
    if name in FORCES:
        return solution.section_forces(points)[:, FORCES.index(name)].ravel()
    if name in SHEAR:
        return solution.shear_forces(points)[:, SHEAR.index(name)].ravel()
    surface = sample_surface(solution, subdivisions, z)
    vector = surface.displacement if name[0] in "du" else surface.velocity
    if vector is None:
        raise InputError(f"field = {name!r}: this state has no velocities; states of a motion have")
    return np.linalg.norm(vector, axis=1) if name in VECTORS else vector[:, int(name[1]) - 1]
