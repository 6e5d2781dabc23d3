"""Which numbers have no limit as the mesh is refined: rules on loads, supports and corners, without any solve."""

from typing import Any

import numpy as np

from skancf.adaptive.quantities import Displacement, Quantity, Rotation, SectionForce, StrainEnergy
from skancf.adaptive.singular import at_free_right_angle, has_part_along, held_points, holding, normal_at, same_point
from skancf.errors import finite, unit_vector
from skancf.layout.geometry import Geometry
from skancf.layout.singularities import Singularity
from skancf.recovered import reentrant_corners
from skancf.system.regularity import of_conditions, singularities, without_conditions
from skancf.system.system import System
from skancf.tolerances import ONE_DIRECTION


def no_limit(quantity: Quantity, system: System) -> str | None:
    """Why a quantity has no limit as the mesh is refined, and which one has; None where no rule says so.

    - A section force at a point where a point force or moment acts, at a support of a single point, and in a re-entrant
      corner. Not moments at a free right-angled corner in theory `kirchhoff`, where the twisting moment carries the force.
    - A displacement under a point force, along it, and the strain energy it makes, which grow with the logarithm of the
      element size: those across the surface in theory `full`, those along it in both theories. The rotation there has a
      limit.
    - The rotation under a point moment, and the strain energy it makes, in both theories. The displacement there has a
      limit.

    Loads and supports say what they do at points, those of a user's own too: see :class:`~skancf.loads.Singularity`. A load
    that moves counts where it stands in statics. Corners that are obtuse and supported, where moments of theory `kirchhoff`
    have no limit either, are not found.

    Parameters
    ----------
    quantity : Quantity
        Others than those of :mod:`skancf.adaptive.quantities` pass.
    system : System

    Raises
    ------
    InputError
        For a point outside the surface.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 4, 4), "full")
    >>> print(sk.adaptive.no_limit(sk.Displacement(at=(0.5, 0.5)), system))
    None
    """
    if isinstance(quantity, SectionForce):
        said = singularities(system)
        return None if quantity.at is None else _section_force(quantity, quantity.at, system.geometry, said)
    said = without_conditions(system)  # what gives way pulls less: see drift
    if isinstance(quantity, Displacement):
        return _displacement(quantity, system.geometry, said)
    if isinstance(quantity, Rotation):
        return _rotation(quantity, system.geometry, said)
    return _energy(system.geometry, said) if isinstance(quantity, StrainEnergy) else None


def drift(system: System) -> str | None:
    """A warning where supports or links at single points let every displacement drift with the element size; None without
    any.

    By its logarithm: the reaction of a support sinks into theory `full` as a point force does, by a part of the order of the
    thickness squared over the size squared; and a moment, of a support that holds the normal at a point, turns that point in
    both theories, by a part of the order of one. A link sinks as a support does, where it pulls along the surface in both
    theories.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(sk.adaptive.drift(system))
    None
    """
    shear, held = system.geometry.theory.shear, held_points(system.geometry, singularities(system))
    points = [point for _, point, rests, turned in held if turned or (rests and shear)]
    if not points:
        return _drift_of_conditions(system)
    places = _places(points)
    what, way_out = "theory 'full' is supported", "support an edge, or take theory 'kirchhoff'"
    if not shear:
        what, way_out = "the normal is held", "hold it along an edge"
    return (f"{what} at single points, {places}: with a reaction there every displacement drifts by the logarithm of the "
            f"element size, and has no limit as the mesh is refined; {way_out}")  # fmt: skip


def _drift_of_conditions(system: System) -> str | None:
    """The same of what conditions pull at."""
    geometry = system.geometry
    pulling = [(each, at) for each, at in _acting(of_conditions(system), "force")
               if geometry.theory.shear or has_part_along(geometry, each.vector, at)]  # fmt: skip
    if not pulling:
        return None
    thin_has_one = geometry.theory.shear and not any(has_part_along(geometry, each.vector, at) for each, at in pulling)
    way_out = "take theory 'kirchhoff'" if thin_has_one else "hold the mean of a region by a condition of your own"
    return (f"{pulling[0][0].words} pulls at single points, {_places([at for _, at in pulling])}, which sink into theory "
            f"{geometry.theory.name!r} there: every displacement drifts by the logarithm of the element size, and has no "
            f"limit as the mesh is refined; join edges by a Hinge, or {way_out}")  # fmt: skip


def _places(points: list[np.ndarray]) -> str:
    return ", ".join(_at(point) for point in points[:4]) + (", ..." if len(points) > 4 else "")


def _section_force(quantity: SectionForce, at: Any, geometry: Geometry, said: list[Singularity]) -> str | None:
    why = _why_singular(quantity, at, geometry, said)
    if why is None:
        return None
    return (f"SectionForce({quantity.component!r}, at={_at(at)}) has no limit as the mesh is refined: {why}. Its mean over "
            f"a region has one: SectionForce({quantity.component!r}, within={_region(geometry, at)})")  # fmt: skip


def _why_singular(quantity: SectionForce, at: Any, geometry: Geometry, said: list[Singularity]) -> str | None:
    geometry.locate(at)
    carried = quantity.component.startswith("M") and at_free_right_angle(geometry, said, at)
    for load, point in _acting(said, "force"):
        if same_point(geometry, point, at) and (not carried or has_part_along(geometry, load.vector, point)):
            return f"{load.words} acts there, {_at(load.vector)} N"
    for load, point in _acting(said, "moment"):
        if same_point(geometry, point, at):
            return f"{load.words} acts there, {_at(load.vector)} N m"
    for support, point, _, turned in held_points(geometry, said):
        if (turned or not carried) and same_point(geometry, point, at):
            return f"{support.words} holds this single point"
    for node, angle in reentrant_corners(geometry).items():
        if same_point(geometry, geometry.points[:, node], at):
            return f"the boundary has a re-entrant corner there, with {np.degrees(angle):.0f} degrees of material"
    return None


def _displacement(quantity: Displacement, geometry: Geometry, said: list[Singularity]) -> str | None:
    direction = unit_vector("direction", quantity.direction)
    geometry.locate(quantity.at)
    for load, point in _acting(said, "force"):
        if not same_point(geometry, point, quantity.at):
            continue
        n, force = normal_at(geometry, point), unit_vector("force", load.vector)
        along = (direction - (direction @ n) * n) @ (force - (force @ n) * n)
        across = (direction @ n) * (force @ n) if geometry.theory.shear else 0.0
        if max(abs(along), abs(across)) > ONE_DIRECTION:
            return (f"Displacement(at={_at(quantity.at)}) has no limit as the mesh is refined: {load.words} there sinks "
                    f"into theory {geometry.theory.name!r} with the logarithm of the element size; "
                    f"{_spread(geometry, [(load, point)])}")  # fmt: skip
    return None


def _rotation(quantity: Rotation, geometry: Geometry, said: list[Singularity]) -> str | None:
    towards = unit_vector("towards", quantity.towards)
    geometry.locate(quantity.at)
    for load, point in _acting(said, "moment"):
        if same_point(geometry, point, quantity.at):
            turned = np.cross(unit_vector("moment", load.vector), normal_at(geometry, point))
            if abs(turned @ towards) > ONE_DIRECTION:
                return f"Rotation(at={_at(quantity.at)}) has no limit as the mesh is refined: {_turns(load, 'there')}"
    return None


def _energy(geometry: Geometry, said: list[Singularity]) -> str | None:
    shear, none = geometry.theory.shear, "StrainEnergy() has no limit as the mesh is refined:"
    loads = [(load, at) for load, at in _acting(said, "force") if shear or has_part_along(geometry, load.vector, at)]
    for load, point in loads[:1]:
        return (f"{none} {load.words} at {_at(point)} sinks into theory {geometry.theory.name!r} with the logarithm of the "
                f"element size; {_spread(geometry, loads)}")  # fmt: skip
    for load, point in _acting(said, "moment"):
        return f"{none} {_turns(load, f'at {_at(point)}')}"
    return None


def _acting(said: list[Singularity], kind: str) -> list[tuple[Singularity, np.ndarray]]:
    """Forces or moments that act at single points, and those points."""
    return [(each, point) for each in said if each.pushes(kind) for point in each.alone.T]


def _turns(load: Singularity, where: str) -> str:
    return (f"{load.words} {where} turns its point with the logarithm of the element size, in every theory; take a couple "
            "of DiskForces, or an EdgeMoment")  # fmt: skip


def _spread(geometry: Geometry, loads: list[tuple[Singularity, np.ndarray]]) -> str:
    thin_has_one = geometry.theory.shear and not any(has_part_along(geometry, each.vector, at) for each, at in loads)
    return "take a DiskForce" + (", or theory 'kirchhoff'" if thin_has_one else "")


def _at(point: Any) -> str:
    return f"({', '.join(f'{v:.6g}' for v in point)})"


def _region(geometry: Geometry, at: Any) -> str:
    """The rectangle around the elements that meet at a point: means are over whole elements."""
    point, corners = geometry.within(finite("at", at)), geometry.mesh.p[:, geometry.mesh.t]
    low, high = corners.min(axis=1), corners.max(axis=1)
    around = holding(low, high, point, np.ptp(geometry.mesh.p, axis=1))
    start, end = low[:, around].min(axis=1), high[:, around].max(axis=1)
    return f"({', '.join(_at(pair) for pair in zip(start, end, strict=True))})"
