"""The same problem stated otherwise: in other units, in another frame, mirrored."""

from dataclasses import replace
from typing import Any

import numpy as np

import skancf as sk
from fuzz.case import Case
from fuzz.shapes import Moved

ON_PARAMETERS = {
    sk.Rectangle: (1, 1), sk.Parallelogram: (1, 1), sk.HyperbolicParaboloid: (1, 1), sk.CylinderSector: (1, 0),
    sk.Cone: (1, 0), sk.AnnulusSector: (1, 0), sk.SphereSector: (0, 0), sk.MappedSurface: (0, 0),
}  # fmt: skip
"""Which parameters of a surface are lengths."""
LENGTHS = ("length_x", "length_y", "radius", "length", "radius_low", "radius_high", "height", "inner", "outer", "rise")


def in_units(case: Case, length: float, force: float) -> Case:
    """Each number of the problem times what its unit has become; the unit of time stays."""
    problem = case.problem
    stretch = tuple(length if is_length else 1.0 for is_length in ON_PARAMETERS[type(problem.surface)])
    return replace(case, problem=replace(
        problem, surface=_surface(problem.surface, length), material=_material(problem.material, length, force),
        thickness=None if problem.thickness is None else problem.thickness * length,
        supports=[_support(s, stretch, length, force) for s in problem.supports],
        loads=[_load(load, stretch, length, force) for load in problem.loads],
    ))  # fmt: skip


def _surface(surface: Any, s: float) -> Any:
    if isinstance(surface, sk.MappedSurface):
        return replace(surface, function=surface.function.scaled(s))
    changed = {name: s * getattr(surface, name) for name in LENGTHS if hasattr(surface, name)}
    if isinstance(surface, sk.Rectangle):
        changed["origin"] = times(surface.origin, s)
    return replace(surface, **changed)


def _material(material: Any, s: float, f: float) -> Any:
    if isinstance(material, sk.Laminate):
        layers = [
            replace(layer, material=_material(layer.material, s, f), thickness=s * layer.thickness)
            for layer in material.layers
        ]
        return sk.Laminate(layers, s * material.offset)
    pressure, density = f / s**2, material.density * f / s**4
    if isinstance(material, sk.Anisotropic):
        return replace(material, matrix=tuple(times(row, pressure) for row in material.matrix), density=density)
    if isinstance(material, sk.Orthotropic):
        young, shear = times(material.young, pressure), times(material.shear, pressure)
        return replace(material, young=young, shear=shear, density=density)
    return replace(material, young=material.young * pressure, density=density)


def times(values: Any, factors: Any) -> tuple[float, ...]:
    return tuple((np.asarray(values, float) * factors).tolist())


def _support(support: Any, stretch: tuple[float, float], s: float, f: float) -> Any:
    where = getattr(support, "where", None)
    at_points = not isinstance(where, str) or where == "corners"
    if where is not None and not isinstance(where, str):
        support = replace(support, where=times(where, stretch))
    if isinstance(support, sk.Prescribed):
        return replace(support, displacement=tuple(None if u is None else u * s for u in support.displacement))
    if isinstance(support, sk.Spring):
        return replace(support, stiffness=times(support.stiffness, f / s if at_points else f / s**2))
    if isinstance(support, sk.Foundation):
        return replace(support, stiffness=support.stiffness * f / s**3)
    return support


def _load(load: Any, stretch: tuple[float, float], s: float, f: float) -> Any:
    places = {n: times(getattr(load, n), stretch) for n in ("at", "start", "end") if hasattr(load, n)}
    load = replace(load, **places)
    match load:
        case sk.PointForce():
            return replace(load, force=times(load.force, f))
        case sk.DiskForce():
            return replace(load, force=times(load.force, f), radius=s * load.radius)
        case sk.LineLoad() | sk.EdgeLoad():
            return replace(load, force=times(load.force, f / s))
        case sk.SurfaceLoad():
            return replace(load, force=times(load.force, f / s**2))
        case sk.EdgeMoment():
            return replace(load, moment=times(load.moment, f))
        case sk.Gravity():
            return replace(load, acceleration=times(load.acceleration, s))
        case sk.FollowerPressure():
            return replace(load, pressure=load.pressure * f / s**2)
        case sk.Temperature():
            return replace(load, gradient=load.gradient / s)
    raise TypeError(f"{load}: give it its units here")


def in_frame(case: Case, turn: np.ndarray, shift: np.ndarray) -> Case:
    r"""The body turned, or mirrored where det Q = -1, and shifted.

    A mirror turns the normal over, :math:`n' = -Q n`, while both tangents follow: so heights z, the shear strains 23 and
    13, and what acts along the normal change sign, and moments, which are axial vectors, are det(Q) Q m.
    """
    problem, over = case.problem, float(np.sign(np.linalg.det(turn)))
    return replace(case, problem=replace(
        problem, surface=Moved(problem.surface, tuple(map(tuple, turn.tolist())), tuple(shift.tolist())),
        material=problem.material if over > 0 else _mirrored(problem.material),
        supports=[_turned_support(support, turn) for support in problem.supports],
        loads=[_turned_load(load, turn, over) for load in problem.loads],
    ))  # fmt: skip


def _mirrored(material: Any) -> Any:
    if isinstance(material, sk.Laminate):
        layers = [replace(layer, material=_mirrored(layer.material)) for layer in material.layers[::-1]]
        return sk.Laminate(layers, -material.offset)
    if isinstance(material, sk.Anisotropic):
        sign = np.array([1, 1, 1, -1, -1, 1.0])
        return replace(material, matrix=tuple(map(tuple, (np.array(material.matrix) * np.outer(sign, sign)).tolist())))
    return material


def turned(vector: Any, turn: np.ndarray) -> tuple[float, ...]:
    return tuple((turn @ np.asarray(vector, float)).tolist())


def along_axes(vector: Any, turn: np.ndarray) -> tuple[Any, ...]:
    """Entries that may be None, in a frame whose axes are the old ones in another order and direction."""
    order, sign = np.abs(turn).argmax(axis=1), turn.sum(axis=1)
    return tuple(None if vector[k] is None else float(s * vector[k]) for k, s in zip(order, sign, strict=True))


def _turned_support(support: Any, turn: np.ndarray) -> Any:
    if getattr(support, "direction", None) is not None:
        return replace(support, direction=turned(support.direction, turn))
    if isinstance(support, sk.Prescribed):
        return replace(support, displacement=along_axes(support.displacement, turn))
    if isinstance(support, sk.Spring):
        return replace(support, stiffness=tuple(abs(k) for k in along_axes(support.stiffness, turn)))
    return support


def _turned_load(load: Any, turn: np.ndarray, over: float) -> Any:
    match load:
        case sk.EdgeMoment():
            return replace(load, moment=turned(over * np.array(load.moment), turn))
        case sk.Gravity():
            return replace(load, acceleration=turned(load.acceleration, turn))
        case sk.FollowerPressure():
            return replace(load, pressure=over * load.pressure)
        case sk.Temperature():
            return replace(load, gradient=over * load.gradient)
    return replace(load, force=turned(load.force, turn))


def needs_axes(case: Case) -> bool:
    """Is something stated along the axes of space, so that the frame must follow them?"""
    return any(isinstance(support, sk.Prescribed | sk.Spring) for support in case.problem.supports)
