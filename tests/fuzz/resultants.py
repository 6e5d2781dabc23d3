"""Resultants of loads from what was asked, by quadrature of the surface itself."""

from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss

import skancf as sk
from fuzz.case import Case

NODES, WEIGHTS = leggauss(8)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2


def areas(surface: Any, mesh: Any) -> tuple[float, np.ndarray]:
    """Area and the integral of the normal over it, (3,)."""
    low, high = mesh.p[:, mesh.t].min(axis=1), mesh.p[:, mesh.t].max(axis=1)
    x = low[0][:, None] + (high - low)[0][:, None] * NODES
    y = low[1][:, None] + (high - low)[1][:, None] * NODES
    one, two = surface.derivatives(x[:, :, None], y[:, None, :])
    normals = np.cross(one, two, axis=0) * np.einsum("e,a,b->eab", np.prod(high - low, axis=0), WEIGHTS, WEIGHTS)
    return float(np.linalg.norm(normals, axis=0).sum()), normals.sum(axis=(1, 2, 3))


def length(surface: Any, start: np.ndarray, end: np.ndarray) -> float:
    """Length of a straight line of the parameter plane, in pieces."""
    pieces = np.linspace(0, 1, 17)
    s = (pieces[:-1, None] + NODES / 16).ravel()
    along = end - start
    at = start[:, None] + along[:, None] * s
    slopes = np.stack(surface.derivatives(*at))
    return float(np.linalg.norm(np.tensordot(along, slopes, 1), axis=0) @ np.tile(WEIGHTS / 16, 16))


def edge_length(surface: Any, mesh: Any, name: str) -> float:
    ends = mesh.p[:, mesh.facets[:, mesh.boundaries[name]]]
    return sum(length(surface, ends[:, 0, k], ends[:, 1, k]) for k in range(ends.shape[2]))


def density(section: Any) -> float:
    """Mass per area."""
    return float(section.density @ np.diff(section.z))


def resultant(case: Case, mesh: Any) -> tuple[np.ndarray, float]:
    """The sum of dead loads and of pressure on the undeformed surface (3,), and by how much the elements may miss it: they
    are of order four on curved surfaces, which on the coarsest meshes is a few per cent."""
    problem, surface = case.problem, case.problem.surface
    area, normal = areas(surface, mesh)
    total, curved, exact = np.zeros(3), 0.0, 0.0
    for load in problem.loads:
        match load:
            case sk.PointForce() | sk.DiskForce():
                part = np.array(load.force)
            case sk.SurfaceLoad():
                part = area * np.array(load.force)
                curved += float(np.linalg.norm(part))
            case sk.Gravity():
                part = area * density(problem.section) * np.array(load.acceleration)
                curved += float(np.linalg.norm(part))
            case sk.FollowerPressure():
                part = load.pressure * normal
                curved += abs(load.pressure) * area
            case sk.EdgeLoad():
                part = edge_length(surface, mesh, load.where) * np.array(load.force)
            case sk.LineLoad():
                part = length(surface, np.array(load.start), np.array(load.end)) * np.array(load.force)
            case _:
                part = np.zeros(3)
        total += part
        exact += float(np.linalg.norm(part))
    if type(surface) in (sk.Rectangle, sk.Parallelogram):
        return total, 1e-9 * exact
    # The elements integrate along a piece of a line at four Gauss points.
    return total, 1e-4 * exact + 0.2 * curved
