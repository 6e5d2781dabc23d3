"""Moments of thin states, and of small changes about them."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from skancf.history import FULL, Case
from skancf.system.system import System
from skancf.system.unstressed import derivative
from skancf.theories.kirchhoff.point import DOUBLED, FIRST, SECOND, dot, dual, unit_normal
from skancf.theories.kirchhoff.theory import covariant_to_local

Moments = Callable[[np.ndarray, np.ndarray | None], np.ndarray]
"""Moments (m, 3, n) at local points (2, n) of elements (m,), None for all of them."""


def moments_of(system: System, q: np.ndarray, case: Case = FULL, small: bool = False) -> Moments:
    """Those of nodal coordinates q; ``small``: to first order about the undeformed ones."""
    assembly: Any = system.assembly

    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        heat = system.shell.temperature(points, case)
        if heat is not None and elements is not None:
            heat = heat[:, elements]
        return np.asarray(assembly.section_forces(system.shell.nodal(q), points, heat, elements, small)[:, 3:])

    return moments


def moments_of_small(system: System, change: np.ndarray, case: Case = FULL) -> Moments:
    """Those of a small-deflection answer that is a change from the undeformed coordinates."""
    rates, held = moment_rates(system, system.undeformed, change), moments_of(system, system.undeformed, case, small=True)
    cold = not system.shell.heats

    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        out = rates(points, elements)
        return out if cold else np.asarray(out + held(points, elements))

    return moments


def moment_rates(system: System, q: np.ndarray, change: np.ndarray) -> Moments:
    """Their derivative along a change of the nodal coordinates q."""
    assembly = cast(Any, system.assembly)
    if assembly.couples:  # with the assumed membrane strains that bending is coupled to
        return lambda points, elements: derivative(lambda v: moments_of(system, v)(points, elements), q, change)
    geometry, theory = system.geometry, system.geometry.theory

    def local(v: np.ndarray, elements: np.ndarray) -> np.ndarray:
        return geometry.local(system.shell.nodal(v), elements)

    def moments(points: np.ndarray, elements: np.ndarray | None) -> np.ndarray:
        pick = np.arange(geometry.n_elements) if elements is None else elements
        moved, before = theory.jets(local(change, pick), points), theory.jets(geometry.undeformed_local[pick], points)
        now = before if q is system.undeformed else theory.jets(local(q, pick), points)
        turn = covariant_to_local(before, geometry.tangents(points, pick), geometry.side[pick])[0][3:, 3:]
        D = assembly.section.at(points, elements).abd()[..., 3:, 3:]
        of_places = "ep" * (D.ndim > 2)
        changes = _curvature_rates(now, moved)
        return np.asarray(np.einsum(f"{of_places}ij,jkep,kep->eip", D, turn, changes, optimize=True))

    return moments


def _curvature_rates(jet: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Of the covariant curvature changes 11, 22, 12 (doubled), (3, m, n): see :mod:`skancf.theories.kirchhoff.point`."""
    n, duals = unit_normal(jet), dual(jet)
    tilts = [dot(n, moved[g]) for g in FIRST]
    return np.stack([
        -c * (dot(n, moved[ab]) - sum(dot(jet[ab], duals[g]) * tilts[g] for g in FIRST))
        for ab, c in zip(SECOND, DOUBLED, strict=True)
    ])  # fmt: skip
