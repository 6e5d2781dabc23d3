r"""Undeformed mid-surfaces :math:`\mathbf X(x, y)` over a parameter plane, one file for each.

A mesh lives in the parameter plane; a surface says where its points are in space.
"""

from skancf.surfaces.annulus import AnnulusSector
from skancf.surfaces.cone import Cone
from skancf.surfaces.cylinder import CylinderSector
from skancf.surfaces.hyperbolic_paraboloid import HyperbolicParaboloid
from skancf.surfaces.mapped import MappedSurface
from skancf.surfaces.parallelogram import Parallelogram
from skancf.surfaces.plane import Plane
from skancf.surfaces.protocol import BoundedSurface, Interval, Surface, closed_bounds, closed_directions
from skancf.surfaces.rectangle import Rectangle
from skancf.surfaces.regular import check_regular, normal
from skancf.surfaces.sphere import SphereSector

__all__ = [
    "AnnulusSector",
    "BoundedSurface",
    "Cone",
    "CylinderSector",
    "HyperbolicParaboloid",
    "Interval",
    "MappedSurface",
    "Parallelogram",
    "Plane",
    "Rectangle",
    "SphereSector",
    "Surface",
    "check_regular",
    "closed_bounds",
    "closed_directions",
    "normal",
]
