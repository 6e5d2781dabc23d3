"""Elements that folded.

An element folded where its area vanishes at an integration point, or where the normals at two of them enclose an angle that
is more than 120 degrees larger than that of the undeformed ones. A whole element that is upside down is not folded:
rotations are of any size.
"""

import numpy as np

from skancf.layout.geometry import Geometry
from skancf.tolerances import LOST_AREA, VANISHED
from skancf.vectors import cross

TURNED = 2 * np.pi / 3
"""Growth of the angle between two normals of one element beyond which it is folded."""


def first_fold(geometry: Geometry, q: np.ndarray) -> tuple[int, np.ndarray] | None:
    """The first element that folded at nodal coordinates (n_nodes, 4, 3), and its undeformed place; None without one."""
    jets = [geometry.jets(geometry.local(nodal))[:2] for nodal in (q, geometry.undeformed)]
    now, before = (cross(pair[0], pair[1]) for pair in jets)
    whole = ((now**2).sum(axis=0) > LOST_AREA**2 * (before**2).sum(axis=0)).all(axis=1)
    whole[whole] = (_angles(now[:, whole]) - _angles(before[:, whole]) < TURNED).all(axis=(1, 2))
    wrong = np.flatnonzero(~whole)
    if not wrong.size:
        return None
    place = geometry.parameters(np.array([[0.5], [0.5]]), wrong[:1])[:, :, 0]
    return int(wrong[0]), geometry.surface.position(*place)[:, 0]


def _angles(normals: np.ndarray) -> np.ndarray:
    """Angles between the vectors of each element at its points: (3, m, n) -> (m, n, n)."""
    units = normals / np.linalg.norm(normals, axis=0)
    return np.asarray(np.arccos(np.clip(np.einsum("iep,ieq->epq", units, units), -1.0, 1.0)))


def largest_turn(geometry: Geometry, change: np.ndarray) -> float:
    """Largest change of a slope, r_x or r_y of a node, relative to the slope's undeformed length; change (n, 4, 3)."""
    lengths = np.sqrt((geometry.undeformed[:, 1:3] ** 2).sum(axis=2))
    with np.errstate(over="ignore"):
        turns = np.sqrt((change[:, 1:3] ** 2).sum(axis=2))
    held = lengths > VANISHED * lengths.max()
    return float((turns[held] / lengths[held]).max())
