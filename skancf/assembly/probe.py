"""Values at points of the parameter plane, as weights of nodal vectors."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.assembly.system import System
from skancf.errors import InputError, finite


def places_of(at: Any) -> np.ndarray:
    """Points of the parameter plane (n, 2), of one (2,) or a list of them."""
    places = finite("at", at)
    if places.ndim not in (1, 2) or places.shape[-1] != 2:
        raise InputError(f"at of shape {places.shape}: give a point (x, y) of the parameter plane, or a list of them")
    return places.reshape(-1, 2)


def probe(system: System, at: Any) -> sp.csr_matrix:
    """Weights (n, 4 n_nodes) that make mid-surface values at points of the parameter plane, (2,) or (n, 2), of nodal
    vectors."""
    geometry = system.geometry
    elements, local = geometry.locate_all(places_of(at).T)
    table = geometry.theory.position_table(local.T)[0]
    point, row, column, value = geometry.local_entries(elements)
    shape = (len(elements), 4 * geometry.n_nodes)
    return sp.csr_matrix((value * table[row, point], (point, column)), shape=shape)
