r"""Points whose elements are not made smaller than the plate is thick.

A force F along the surface at a single point has stresses :math:`F / (2 \pi r t)` about it, and under a multiple of it such
that the strain there is of the order of one, elements of that size buckle by themselves. A linear buckling load would go to
zero with the element size; what acts on a body is spread over a size of the order of its thickness.
"""

from typing import NamedTuple

import numpy as np

from skancf.adaptive.singular import held_points
from skancf.materials import Section
from skancf.system.regularity import singularities
from skancf.system.system import System


class Blunt(NamedTuple):
    """Points in space (3, n), and the size (n,) of the smallest elements about each (m)."""

    points: np.ndarray
    sizes: np.ndarray

    def smallest(self, corners: np.ndarray) -> np.ndarray:
        """That of elements with such corners (3, 4, m), zero for those farther from each point than its size: (m,)."""
        out = np.zeros(corners.shape[-1])
        for point, size in zip(self.points.T, self.sizes, strict=True):
            near = np.linalg.norm(corners - point[:, None, None], axis=0).min(axis=0) < size
            out[near] = np.maximum(out[near], size)
        return out


NOWHERE = Blunt(np.empty((3, 0)), np.empty(0))


def blunt_points(system: System) -> Blunt:
    """Where loads, conditions and supports have forces at single points, with the thickness there."""
    said, geometry = singularities(system), system.geometry
    places = [each.alone for each in said if each.pushes("force")]
    places += [point[:, None] for _, point, rests, _ in held_points(geometry, said) if rests]
    if not places:
        return NOWHERE
    at, section = geometry.within(np.hstack(places)), system.assembly.section
    found = section if isinstance(section, Section) else section.at_places(at)
    return Blunt(np.asarray(geometry.surface.position(*at)), np.broadcast_to(found.thickness, at.shape[1]))
