"""Classes of undeformed elements that are equal to rounding, so that what they share is kept once."""

import numpy as np

from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.tolerances import EPS

# Keys that differ by less than this many times the rounding of the nodes' positions are equal.
ROUNDINGS = 16


def classes(key: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    """One element of each class, and each element's class, from a key (n_elements, n) known to a rounding."""
    known: dict[bytes, int] = {}
    shape = np.array([known.setdefault(row.tobytes(), len(known)) for row in np.round(key, 7) + 0.0], dtype=np.int32)
    representative = np.unique(shape, return_index=True)[1]
    apart = np.flatnonzero(np.abs(key - key[representative][shape]).max(axis=1) > ROUNDINGS * rounding)
    shape[apart] = len(representative) + np.arange(len(apart))
    return np.concatenate([representative, apart]), shape


def key_of(section: Section | SectionsOnMesh, points: np.ndarray) -> list[np.ndarray]:
    """What tells elements apart by their sections at local points, none or (n_elements, n)."""
    return [] if isinstance(section, Section) else [section.key(points)]


def rounding_of(undeformed: np.ndarray, lengths: np.ndarray) -> float:
    """What rounding of positions (n_nodes, 4, 3) does to shapes of elements with these lengths, relative."""
    reach = np.abs(undeformed[:, 0]).max()
    return float(EPS * max(1.0, reach / lengths.min()))
