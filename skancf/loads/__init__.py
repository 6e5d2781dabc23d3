"""Loads: forces, moments, pressure and temperature, each with an optional function of time; impulses.

Statics takes every load as it is given times the load factor, which is what full amplitude means: ``history``, whatever its
largest or last value is, counts in dynamics only, which multiplies the load by ``history(t)``.
"""

from skancf.layout.singularities import Singularity
from skancf.loads.acting import Load
from skancf.loads.edge import EdgeLoad, LineLoad
from skancf.loads.impulse import EdgeImpulse, Impulse
from skancf.loads.moment import EdgeMoment, PointMoment
from skancf.loads.moving import MovingForce, MovingLine
from skancf.loads.point import DiskForce, PointForce
from skancf.loads.pressure import FollowerPressure
from skancf.loads.surface import Gravity, SurfaceLoad
from skancf.loads.tables import Sampled, point_forces, sampled
from skancf.loads.temperature import Temperature

ALL = [
    DiskForce, EdgeImpulse, EdgeLoad, EdgeMoment, FollowerPressure, Gravity, Impulse, LineLoad, MovingForce, MovingLine,
    PointForce, PointMoment, SurfaceLoad, Temperature,
]  # fmt: skip

__all__ = [
    "ALL", "DiskForce", "EdgeImpulse", "EdgeLoad", "EdgeMoment", "FollowerPressure", "Gravity", "Impulse", "LineLoad",
    "Load", "MovingForce", "MovingLine", "PointForce", "PointMoment", "Sampled", "Singularity", "SurfaceLoad",
    "Temperature", "point_forces", "sampled",
]  # fmt: skip
