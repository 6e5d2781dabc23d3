"""Edges that meet but for the interpolation of the surface: made to meet before strains are measured from there.

Two meshes interpolate a curved edge differently, by the fourth power of the element size. In an undeformed state that is not
closed, a condition would close the gap with stress, or the gap would turn with the body.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.kernels.constants import AXES
from skancf.layout.geometry import Geometry
from skancf.layout.layout import vectors
from skancf.tolerances import ROUNDED_PLACE


def close_gaps(joints: Sequence[Any], geometry: Geometry) -> None:
    """Move the undeformed nodal vectors of a mesh by as little as closes the gaps of joints, see :meth:`Joint.gap`.

    With the sizes s in which coordinates count, the change of least norm, :math:`S^2 C^T (C S^2 C^T)^+ C q_0`.
    """
    gaps = [gap for gap in (joint.gap(geometry) for joint in joints) if gap is not None]
    if not gaps:
        return
    rows = sp.vstack(gaps, format="csr")
    missing = rows @ vectors(geometry.undeformed)
    extent = np.ptp(geometry.undeformed[:, 0], axis=0).max()
    if np.abs(missing).max(initial=0.0) <= ROUNDED_PLACE * extent:
        return
    sizes = sp.diags(geometry.scales[:, ::AXES].ravel())
    scaled = (rows @ sizes).tocsr()
    back = np.linalg.lstsq((scaled @ scaled.T).toarray(), missing, rcond=None)[0]
    geometry.undeformed -= (sizes @ (scaled.T @ back)).reshape(geometry.undeformed.shape)
