"""Values at points of the parameter plane: positions as weights of nodal vectors, and normals."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.errors import InputError, finite
from skancf.layout.around import at_pairs
from skancf.system.system import System


def places_of(at: Any) -> np.ndarray:
    """Points of the parameter plane (n, 2), of one (2,) or a list of them."""
    places = finite("at", at)
    if places.ndim not in (1, 2) or places.shape[-1] != 2:
        raise InputError(f"at of shape {places.shape}: give a point (x, y) of the parameter plane, or a list of them")
    return places.reshape(-1, 2)


def probe(system: System, at: Any) -> sp.csr_matrix:
    """Weights (n, 4 n_blocks) that make mid-surface values at points of the parameter plane, (2,) or (n, 2), of nodal
    vectors."""
    return system.shell.position_rows(*system.geometry.locate_all(places_of(at).T))


def normals(system: System, at: Any, q: np.ndarray) -> np.ndarray:
    """Directors or unit normals (n, 3) at points of the parameter plane, (2,) or (n, 2)."""
    return _at_places(system, at, system.geometry.theory.normals, q)


def normal_rates(system: System, at: Any, q: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Their rates (n, 3) for rates of the nodal coordinates q."""
    return _at_places(system, at, system.geometry.theory.normal_rates, q, rates)


def _at_places(system: System, at: Any, field: Callable[..., np.ndarray], *vectors: np.ndarray) -> np.ndarray:
    geometry, nodal = system.geometry, [system.shell.nodal(v) for v in vectors]

    def value(points: np.ndarray, some: np.ndarray) -> np.ndarray:
        local = [geometry.local(each, some) for each in nodal]
        return np.asarray(field(*local, geometry.inside(points), geometry.side[some]).swapaxes(1, 2))

    elements, local = geometry.locate_all(places_of(at).T)
    return at_pairs(elements, local, value)
