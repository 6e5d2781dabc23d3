"""Which numbers have no limit as the mesh is refined: rules on loads, supports and corners, without any solve."""

from typing import Any

import numpy as np

from skancf.adaptive.quantities import Displacement, Quantity, SectionForce, StrainEnergy
from skancf.adaptive.singular import (
    at_free_right_angle,
    has_part_along,
    holding,
    normal_at,
    point_forces,
    point_supports,
    reentrant_corners,
    same_point,
)
from skancf.errors import finite, unit_vector
from skancf.layout.geometry import Geometry
from skancf.loads import PointForce
from skancf.supports import Clamp, NoRotation
from skancf.system.system import System

ALONG_TOO = 1e-6
"""Product of the parts of two unit vectors that counts."""


def no_limit(quantity: Quantity, system: System) -> str | None:
    """Why a quantity has no limit as the mesh is refined, and which one has; None where no rule says so.

    - A section force at a point where a point force acts, at a support of a single point, and in a re-entrant corner. Not
      moments at a free right-angled corner in theory `kirchhoff`, where the twisting moment carries the force.
    - A displacement under a point force, along it, and the strain energy it makes, which grow with the logarithm of the
      element size: those across the surface in theory `full`, those along it in both theories. The rotation there has a
      limit.

    Corners that are obtuse and supported, where moments of theory `kirchhoff` have no limit either, are not found.

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
    >>> sk.adaptive.no_limit(sk.Displacement(at=(0.5, 0.5)), system)
    """
    if isinstance(quantity, SectionForce):
        return None if quantity.at is None else _section_force(quantity, quantity.at, system)
    if isinstance(quantity, Displacement):
        return _displacement(quantity, system)
    return _energy(system) if isinstance(quantity, StrainEnergy) else None


def drift(system: System) -> str | None:
    """A warning where supports at single points let every displacement drift with the element size; None without any.

    By its logarithm: the reaction of a support sinks into theory `full` as a point force does, by a part of the order of the
    thickness squared over the size squared; and a moment, of a support that holds the normal at a point, turns that point in
    both theories, by a part of the order of one.
    """
    thin = system.geometry.theory.twist
    nodes = [node for support, node in point_supports(system) if not thin or isinstance(support, Clamp | NoRotation)]
    if not nodes:
        return None
    places = ", ".join(_at(system.mesh.p[:, node]) for node in nodes[:4]) + (", ..." if len(nodes) > 4 else "")
    what, way_out = "theory 'full' is supported", "support an edge, or take theory 'kirchhoff'"
    if thin:
        what, way_out = "the normal is held", "hold it along an edge"
    return (f"{what} at single points, {places}: with a reaction there every displacement drifts by the logarithm of the "
            f"element size, and has no limit as the mesh is refined; {way_out}")  # fmt: skip


def _section_force(quantity: SectionForce, at: Any, system: System) -> str | None:
    why = _why_singular(quantity, at, system)
    if why is None:
        return None
    return (f"SectionForce({quantity.component!r}, at={_at(at)}) has no limit as the mesh is refined: {why}. Its mean over "
            f"a region has one: SectionForce({quantity.component!r}, within={_region(system.geometry, at)})")  # fmt: skip


def _why_singular(quantity: SectionForce, at: Any, system: System) -> str | None:
    geometry = system.geometry
    geometry.locate(at)
    carried = quantity.component.startswith("M") and at_free_right_angle(system, at)
    for load in point_forces(system):
        if same_point(geometry, load.at, at) and (not carried or has_part_along(geometry, load)):
            return f"a PointForce acts there, {_at(load.force)} N"
    for support, node in point_supports(system):
        turning = isinstance(support, Clamp | NoRotation)
        if (turning or not carried) and same_point(geometry, geometry.mesh.p[:, node], at):
            return f"a {type(support).__name__} holds this single point"
    for node, angle in reentrant_corners(geometry).items():
        if same_point(geometry, geometry.points[:, node], at):
            return f"the boundary has a re-entrant corner there, with {np.degrees(angle):.0f} degrees of material"
    return None


def _displacement(quantity: Displacement, system: System) -> str | None:
    geometry, direction = system.geometry, unit_vector("direction", quantity.direction)
    geometry.locate(quantity.at)
    for load in point_forces(system):
        if not same_point(geometry, load.at, quantity.at):
            continue
        n, force = normal_at(geometry, load.at), unit_vector("force", load.force)
        along = (direction - (direction @ n) * n) @ (force - (force @ n) * n)
        across = 0.0 if geometry.theory.twist else (direction @ n) * (force @ n)
        if max(abs(along), abs(across)) > ALONG_TOO:
            return (f"Displacement(at={_at(quantity.at)}) has no limit as the mesh is refined: the PointForce there sinks "
                    f"into theory {geometry.theory.name!r} with the logarithm of the element size; "
                    f"{_spread(system, [load])}")  # fmt: skip
    return None


def _energy(system: System) -> str | None:
    thin = system.geometry.theory.twist
    loads = [load for load in point_forces(system) if not thin or has_part_along(system.geometry, load)]
    if not loads:
        return None
    return (f"StrainEnergy() has no limit as the mesh is refined: the PointForce at {_at(loads[0].at)} sinks into theory "
            f"{system.geometry.theory.name!r} with the logarithm of the element size; {_spread(system, loads)}")  # fmt: skip


def _spread(system: System, loads: list[PointForce]) -> str:
    thin_has_one = not system.geometry.theory.twist and not any(has_part_along(system.geometry, load) for load in loads)
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
