"""Compiled maps between nodal coordinates and the local vectors of an element, the same for every theory."""

from typing import NamedTuple

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, CORNERS, FUNCTIONS, LOCAL, MATRIX, SECOND, THIRD
from skancf.kernels.panels import prefetch
from skancf.showing import short


class Maps(NamedTuple):
    """How elements see the nodal coordinates.

    ``nodes`` (n, 4); triples of element e are ``pointer[e]:pointer[e + 1]``: the local vector ``rows`` gets ``values``
    times the vector ``kinds`` of the corner ``corners``.
    """

    nodes: np.ndarray
    pointer: np.ndarray
    rows: np.ndarray
    corners: np.ndarray
    kinds: np.ndarray
    values: np.ndarray

    def __repr__(self) -> str:
        return short(self)


@compiled(**INNER)
def gather(e, q, maps, local):
    """Local vectors (16, 3) of element e from nodal coordinates (n_nodes, 4, 3)."""
    local[:] = 0.0
    for k in range(maps.pointer[e], maps.pointer[e + 1]):
        a, v = maps.rows[k], maps.values[k]
        n, kind = maps.nodes[e, maps.corners[k]], maps.kinds[k]
        for i in range(AXES):
            local[a, i] += v * q[n, kind, i]


@compiled(**INNER)
def scatter_force(e, force, maps, out):
    """Adds the forces on the local vectors (16, 3) to out (n_nodes, 4, 3)."""
    for k in range(maps.pointer[e], maps.pointer[e + 1]):
        a, v = maps.rows[k], maps.values[k]
        n, kind = maps.nodes[e, maps.corners[k]], maps.kinds[k]
        for i in range(AXES):
            out[n, kind, i] += v * force[a, i]


@compiled(**INNER)
def prefetch_blocks(e, slots, out):
    """Asks for the blocks of an element early, so that they come while its tangent is computed."""
    for a in range(CORNERS):
        for b in range(CORNERS):
            slot = slots[e, a, b]
            if slot >= 0:
                for line in range(0, MATRIX, 8):
                    prefetch(out, MATRIX * slot + line)


@compiled(**INNER)
def scatter_tangent(e, maps, slots, K, out):
    """Adds an element's tangent, K (48, 48) of which i <= j is used, to the upper blocks, out (n_blocks, 12, 12)."""
    for k in range(maps.pointer[e], maps.pointer[e + 1]):
        a, v, row = maps.rows[k], maps.values[k], 3 * maps.kinds[k]
        slot_row = slots[e, maps.corners[k]]
        for l in range(maps.pointer[e], maps.pointer[e + 1]):
            slot = slot_row[maps.corners[l]]
            if slot >= 0:
                b, w, col = maps.rows[l], v * maps.values[l], 3 * maps.kinds[l]
                block = out[slot]
                block[row, col] += w * K[a, b]
                block[row, col + 1] += w * K[a, SECOND + b]
                block[row, col + 2] += w * K[a, THIRD + b]
                block[row + 1, col] += w * K[b, SECOND + a]
                block[row + 1, col + 1] += w * K[SECOND + a, SECOND + b]
                block[row + 1, col + 2] += w * K[SECOND + a, THIRD + b]
                block[row + 2, col] += w * K[b, THIRD + a]
                block[row + 2, col + 1] += w * K[SECOND + b, THIRD + a]
                block[row + 2, col + 2] += w * K[THIRD + a, THIRD + b]


@compiled(**OPTIONS)
def add_local(elements, matrices, maps, slots, out):
    """Adds symmetric matrices (m, 48, 48) of elements (m,), component by component, to the upper blocks out."""
    for k in range(elements.shape[0]):
        scatter_tangent(elements[k], maps, slots, matrices[k], out)


@compiled(**OPTIONS)
def mass(start, stop, order, shape, shapes, maps, slots, out):
    """Adds the classes' mass matrices (n_shapes, 16, 16), the same for the three components."""
    K = np.zeros((LOCAL, LOCAL))
    for index in range(start, stop):
        e = order[index]
        for i in range(0, LOCAL, FUNCTIONS):
            for a in range(FUNCTIONS):
                for b in range(FUNCTIONS):
                    K[i + a, i + b] = shapes[shape[e], a, b]
        scatter_tangent(e, maps, slots, K, out)
