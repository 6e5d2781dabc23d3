"""How the local vectors of each element come from the nodal coordinates, as triples for the compiled kernels."""

import numpy as np
import skfem

from skancf.kernels.constants import FOURTH, R_X, R
from skancf.kernels.gather import Maps
from skancf.layout.hanging import Hanging
from skancf.layout.ties import Ties
from skancf.theories import Theory
from skancf.tolerances import ROUNDED_SUM


def local_maps(mesh: skfem.MeshQuad, jacobian: np.ndarray, theory: Theory, ties: Ties, hanging: Hanging) -> Maps:
    """The triples of all elements; slopes go through the nodal Jacobian, r and d are taken as they are.

    Where a corner hangs, the element's node is the far end of the larger edge. Its near end is the element's own.
    """
    n = mesh.t.shape[1]
    own = np.zeros((n, 4, 4, 4))  # element, corner, local vector, vector at the mesh node
    own[:, :, R, R] = 1
    own[:, :, R_X:FOURTH, R_X:FOURTH] = jacobian.transpose(3, 2, 1, 0)
    own[:, :, FOURTH, FOURTH] = theory.fourth_factor(jacobian).T
    size = np.abs(jacobian).max(axis=(0, 1, 2))
    least = np.minimum(size, theory.fourth_factor(np.multiply.outer(np.eye(2), size)))
    own[np.abs(own) < ROUNDED_SUM * least[:, None, None, None]] = 0
    corners = mesh.t.T.copy()  # the mesh node whose node is the element's there
    element, corner, near, parts = _hanging_corners(mesh, hanging, ties.mix, own, corners)
    own = own @ ties.mix[corners]
    own[element, corner] = parts[1]
    index, a, vector, kind = np.nonzero(own)
    k, more_vector, more_kind = np.nonzero(parts[0])
    elements = np.concatenate([index, element[k]])
    rows = theory.rows[np.concatenate([a, corner[k]]), np.concatenate([vector, more_vector])]
    values = np.concatenate([own[index, a, vector, kind], parts[0][k, more_vector, more_kind]])
    columns, kinds = np.concatenate([a, near[k]]), np.concatenate([kind, more_kind])
    order = np.argsort(elements, kind="stable") if len(k) else slice(None)
    nodes = np.ascontiguousarray(ties.node_of[corners], dtype=np.int32)
    pointer = np.concatenate([[0], np.cumsum(np.bincount(elements, minlength=n))])
    return Maps(
        nodes, pointer, rows[order].astype(np.int32), columns[order].astype(np.int32), kinds[order].astype(np.int32),
        values[order],
    )  # fmt: skip


def _hanging_corners(
    mesh: skfem.MeshQuad, hanging: Hanging, mix: np.ndarray, own: np.ndarray, corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Elements and corners (m,) that hang, the corner at the near end, and the maps from the nodal vectors of the near and
    the far end to the local ones, (2, m, 4, 4); writes the far ends into ``corners``."""
    number = np.full(mesh.p.shape[1], -1)
    number[hanging.nodes] = np.arange(len(hanging.nodes))
    element, corner = np.nonzero(number[corners] >= 0)
    h = number[corners[element, corner]]
    beside = np.stack([(corner + 1) % 4, (corner + 3) % 4])
    candidates = corners[element, beside]
    # One neighbouring corner is an end of the larger edge.
    is_end = (candidates[:, None] == hanging.ends[:, h]).any(axis=1)
    near = np.where(is_end[0], beside[0], beside[1])
    far_end = (corners[element, near] == hanging.ends[0, h]).astype(int)
    corners[element, corner] = hanging.ends[far_end, h]
    local = own[element, corner]
    ends = ((1 - far_end), far_end)
    return element, corner, near, np.stack([local @ hanging.weights[k, h] @ mix[hanging.ends[k, h]] for k in ends])
