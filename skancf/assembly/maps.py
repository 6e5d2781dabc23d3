"""How the local vectors of each element come from the nodal coordinates, as triples for the compiled kernels."""

import numpy as np
import skfem

from skancf.assembly.local import Maps
from skancf.theories import Theory


def local_maps(
    mesh: skfem.MeshQuad, jacobian: np.ndarray, theory: Theory, mix: np.ndarray, nodes: np.ndarray
) -> Maps:
    """The triples of all elements; slopes go through the nodal Jacobian, r and d are taken as they are."""
    n = mesh.t.shape[1]
    own = np.zeros((n, 4, 4, 4))  # element, corner, local vector, nodal vector
    own[:, :, 0, 0] = own[:, :, 3, 3] = 1
    own[:, :, 1:3, 1:3] = jacobian.transpose(3, 2, 1, 0)
    if theory.twist:
        own[:, :, 3, 3] = (jacobian[0, 0] * jacobian[1, 1] + jacobian[0, 1] * jacobian[1, 0]).T
    size = np.abs(jacobian).max(axis=(0, 1, 2))
    own[np.abs(own) < 1e-14 * np.minimum(size, size**2 if theory.twist else 1.0)[:, None, None, None]] = 0
    own = own @ mix[mesh.t.T]
    element, corner, vector, kind = np.nonzero(own)
    pointer = np.concatenate([[0], np.cumsum(np.bincount(element, minlength=n))])
    rows = theory.rows[corner, vector].astype(np.int32)
    return Maps(
        nodes, pointer, rows, corner.astype(np.int32), kind.astype(np.int32), own[element, corner, vector, kind]
    )
