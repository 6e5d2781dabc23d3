"""Undeformed elements sorted into classes of equal shape, with what each class needs: strains, law, mass."""

from dataclasses import dataclass
from typing import cast

import numpy as np

from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.memory import require_shapes
from skancf.showing import short
from skancf.terms.shells.classes import classes, key_of, rounding_of
from skancf.theories.full.theory import N_IN_PLANE, R1, R2, TERMS, Full, local_frame, section_stiffness
from skancf.tolerances import ROUNDED_VALUE
from skancf.vectors import cross


@dataclass(frozen=True)
class Sections:
    """Per class of equal undeformed elements; weights of the integration points are included.

    Attributes
    ----------
    shape : (n_elements,) int array
        Class of each element.
    reference : (n_shapes, n_strains, n_points) array
        Undeformed strains.
    pairs : (n_pairs, 2) int array
        Entries k <= l of the law that are not zero in some class.
    law : (n_shapes, n_pairs, n_points) array
        Those entries.
    sampled : (n_shapes, n_rows, n_rows) array
        Law of the assumed strains at their sampling points: interpolation^T D interpolation.
    moments : (n_shapes, 3, n_points) array
        Integrals of the density times 1, z, z^2 through the thickness with det F.
    areas : (n_shapes, n_points) array
        Area of the mid-surface.
    """

    shape: np.ndarray
    reference: np.ndarray
    pairs: np.ndarray
    law: np.ndarray
    sampled: np.ndarray
    moments: np.ndarray
    areas: np.ndarray

    __repr__ = short


def build_sections(geometry: Geometry, section: Section | SectionsOnMesh) -> Sections:
    """The classes of a mesh; equal means equal to rounding in undeformed strains, frame, and section."""
    theory = cast(Full, geometry.theory)
    points, weights = theory.quadrature
    key, rounding = _shape_key(geometry)
    representative, shape = classes(np.hstack([key, *key_of(section, points)]), rounding)
    require_shapes(len(representative), theory.bytes_per_shape, theory.name)
    local = geometry.undeformed_local[representative]
    jets = theory.jets(local, points)
    first = geometry.tangents(points, representative)
    full, moments = section_stiffness(jets, first, section.at(points, representative), theory.n_thickness)
    full = full * weights[:, None, None]
    k, l = np.nonzero(np.triu(np.abs(full).max(axis=(0, 1)) > ROUNDED_VALUE * _scale(full)))
    return Sections(
        shape=shape,
        reference=np.ascontiguousarray(theory.strains(local, points)),
        pairs=np.stack([k, l], axis=1),
        law=np.ascontiguousarray(np.moveaxis(full[:, :, k, l], 1, 2)),
        sampled=_sampled_law(theory, full),
        moments=np.moveaxis(moments * weights, 0, 1),
        areas=np.sqrt((cross(jets[0], jets[1]) ** 2).sum(axis=0)) * weights,
    )


def _sampled_law(theory: Full, full: np.ndarray) -> np.ndarray:
    if not theory.assumed:
        return np.empty((0, 0, 0))  # the plain element's law stays with its points
    interpolation, rows = theory.sampling()
    strains, samples = rows.T
    weights = interpolation[strains, samples]
    laws = full[:, :, N_IN_PLANE + strains[:, None], N_IN_PLANE + strains]
    return np.ascontiguousarray(np.einsum("rp,eprq,qp->erq", weights, laws, weights, optimize=True))


def _scale(full: np.ndarray) -> np.ndarray:
    """Scale of each entry, so that strains of different dimension compare: sqrt(D_kk D_ll)."""
    diagonal = np.sqrt(np.abs(np.einsum("epkk->epk", full)).max(axis=(0, 1)))
    return np.outer(diagonal, diagonal)


def _shape_key(geometry: Geometry) -> tuple[np.ndarray, float]:
    """What tells undeformed elements apart, (n_elements, n), free of units, and the rounding it is known to.

    The logarithms of the element's two lengths, its undeformed strains in terms of them, and its frame.
    """
    local, (points, _) = geometry.undeformed_local, geometry.theory.quadrature
    jets = geometry.theory.jets(local, points)
    lengths = np.sqrt((jets[[R1, R2]] ** 2).sum(axis=1)).max(axis=-1)
    scale = np.ones((5, len(local)))
    scale[[R1, R2]] = lengths
    strains = geometry.theory.strains(local, points)
    for k, a, b in {k: (k, a, b) for k, a, b in TERMS.tolist()}.values():
        strains[:, k] /= (scale[a] * scale[b])[:, None]
    frame = local_frame(jets, geometry.tangents(points))
    angles = np.einsum("fiep,jiep->efjp", frame[:2], jets[[R1, R2]]) / lengths.T[:, None, :, None]
    key = np.hstack([np.log(lengths).T, strains.reshape(len(local), -1), angles.reshape(len(local), -1)])
    return key, rounding_of(geometry.undeformed, lengths)
