"""Is an adaptive answer within the depth of its theory?"""

import numpy as np

from skancf.adaptive.singular import strong_points, touching
from skancf.solution import Solution
from skancf.statics.depth import warn_if_loose, warn_if_thick

CENTRE = np.array([[0.5], [0.5]])
NEAR_SINGULAR = 3.0
"""Thicknesses around a strong point in which no thin theory is meant."""


def judge(state: Solution) -> None:
    """Warnings where single elements move in ways of their own, and where the thin theory is not enough, elements at
    re-entrant corners, point loads and point supports left out: the shear energy of theory `kirchhoff` has no limit there,
    which tells nothing of the rest."""
    system, near = state.system, strong_points(state.system)
    positions = system.geometry.surface.position(*system.geometry.parameters(CENTRE)[:, :, 0])
    reach = NEAR_SINGULAR * system.problem.section.thickness
    away = np.ones(system.mesh.nelements, dtype=bool)
    for point in np.asarray(system.geometry.surface.position(*near)).T:
        away &= np.linalg.norm(positions.T - point, axis=1) > reach
    away[touching(system.mesh.leaves, near)] = False
    areas = system.assembly.areas.sum(axis=1)
    warn_if_thick(state, away if areas[away].sum() > areas.sum() / 2 else None)
    warn_if_loose(state)
