"""Undeformed thin elements sorted into classes of equal shape, with what each class needs."""

from dataclasses import dataclass

import numpy as np

from skancf.layout.geometry import Geometry
from skancf.layout.zones import SectionsOnMesh
from skancf.materials import Section
from skancf.materials.curved import CurvedSection
from skancf.memory import require_shapes
from skancf.showing import short
from skancf.terms.shells.classes import classes, key_of, rounding_of
from skancf.theories.kirchhoff.point import DOUBLED, dot, strain
from skancf.theories.kirchhoff.theory import covariant_to_local, local_frame, rest_factors
from skancf.tolerances import ROUNDED_VALUE


@dataclass(frozen=True)
class ThinSections:
    """Per class of equal undeformed elements; weights of the integration points are included.

    Attributes
    ----------
    shape : (n_elements,) int array
        Class of each element.
    points : (n_shapes,) int array
        Kind of its integration points.
    reference : (n_shapes, 6 or 9, n_points) array
        Undeformed strains; where some elements have points of their own, then the membrane strains at the Gauss points,
        which their assumed strains are made of.
    pairs : (n_pairs, 2) int array
        Entries k <= l of the law of the covariant strains that are not zero in some class.
    law : (n_shapes, n_pairs, n_points) array
        Those entries.
    assumed : (n_shapes,) int array
        Number of the projection of the membrane strains: 0 where they are taken as they are, or one more than the kind of
        points.
    rest : (n_shapes, 3) array
        Roots of the factors of the rest of the membrane strains.
    turn : (n_shapes, 6, 6, n_points) array
        From covariant strains to those in the local frame.
    curvature : (n_shapes, n_points, 3) array
        Components 11, 22, 12 in the local frame (1/m).
    moments : (n_shapes, 2, n_points) array
        Integrals of the density times 1, z through the thickness.
    areas : (n_shapes, n_points) array
        Area of the mid-surface.
    """

    shape: np.ndarray
    points: np.ndarray
    reference: np.ndarray
    pairs: np.ndarray
    law: np.ndarray
    assumed: np.ndarray
    rest: np.ndarray
    turn: np.ndarray
    curvature: np.ndarray
    moments: np.ndarray
    areas: np.ndarray

    __repr__ = short


def build_thin_sections(geometry: Geometry, section: Section | SectionsOnMesh) -> ThinSections:
    """The classes of a mesh; equal means equal to rounding in undeformed strains, frame, and section.

    Raises
    ------
    InputError
        Where layers are past a centre of curvature.
    """
    theory, integration = geometry.theory, geometry.integration
    # Covariant strains grow with the distance from a pole and its square, which the assumed ones next to it cannot.
    at_pole = geometry.at_poles
    plain = at_pole if theory.assumed else np.ones_like(at_pole)
    key, rounding = _shape_key(geometry)
    representative, shape = classes(
        np.hstack([key, plain[:, None], integration.kinds[:, None], *key_of(section, integration.local)]), rounding
    )
    require_shapes(len(representative), theory.bytes_per_shape, theory.name)
    vectors, kinds = geometry.undeformed_local[representative], integration.kinds[representative]
    jets = integration.gathered(lambda points, shapes: theory.jets(vectors[shapes], points), kinds, axis=2)
    tangents = geometry.tangents(integration.of(kinds), representative)
    turn, area = covariant_to_local(jets, tangents, geometry.side[representative])
    areas = area * integration.weights[kinds]
    turns, curvature = turn.transpose(2, 3, 0, 1), local_curvature(jets, turn)
    curved = CurvedSection(section.at(integration.of(kinds), representative))
    curved.check(curvature)
    in_frame = curved.section.abd() if curved.centred else curved.law(curvature)
    law = (turns.swapaxes(2, 3) @ in_frame @ turns * areas[:, :, None, None]).transpose(0, 2, 3, 1)
    scale = np.sqrt(np.abs(np.einsum("ekkp->ekp", law)).max(axis=(0, 2)))
    k, l = np.nonzero(np.triu(np.abs(law).max(axis=(0, 3)) > ROUNDED_VALUE * np.outer(scale, scale)))
    whole = jets if integration.shared else theory.jets(vectors, theory.quadrature[0])
    sampled = [] if integration.shared else [np.where(kinds[:, None] > 0, strain(whole)[:3], 0.0)]
    return ThinSections(
        shape=shape,
        points=kinds,
        reference=np.ascontiguousarray(np.moveaxis(np.concatenate([strain(jets), *sampled]), 0, 1)),
        pairs=np.stack([k, l], axis=1),
        law=np.ascontiguousarray(law[:, k, l]),
        assumed=np.where(plain[representative], 0, 1 + kinds),
        rest=rest_factors(whole, np.atleast_1d(curved.section.bending_thickness).mean(axis=-1)),
        turn=np.ascontiguousarray(np.moveaxis(turn, 2, 0)),
        curvature=curvature,
        moments=curved.masses(curvature).swapaxes(0, 1) * areas[:, None],
        areas=areas,
    )


def local_curvature(jets: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Curvature 11, 22, 12 of undeformed jets (5, 3, ...) in the local frame, where turn (6, 6, ...) leads: (..., 3)."""
    doubled = -np.einsum("kl...,l...->...k", turn[3:, 3:], strain(jets)[3:])
    return np.asarray(doubled / DOUBLED)


def _shape_key(geometry: Geometry) -> tuple[np.ndarray, float]:
    """What tells undeformed elements apart, (n_elements, n), free of units, and the rounding it is known to.

    The logarithms of the element's two lengths, its metric and curvature in terms of them, and its frame.
    """
    points = geometry.theory.quadrature[0]
    jets = geometry.theory.jets(geometry.undeformed_local, points)
    lengths = np.sqrt((jets[:2] ** 2).sum(axis=1)).max(axis=-1)
    strains = np.moveaxis(strain(jets), 0, 1)
    scale = np.stack([lengths[0] ** 2, lengths[1] ** 2, lengths[0] * lengths[1]], axis=1)[:, :, None]
    strains[:, :3] /= scale
    strains[:, 3:] *= lengths.max(axis=0)[:, None, None] / scale
    frame = local_frame(jets, geometry.tangents(points), geometry.side)
    angles = np.stack([[dot(e, jets[a]) / lengths[a][:, None] for a in range(2)] for e in frame[:2]])
    n = len(strains)
    parts = [np.log(lengths).T, strains.reshape(n, -1), np.moveaxis(angles, 2, 0).reshape(n, -1), geometry.side[:, None]]
    return np.hstack(parts), rounding_of(geometry.undeformed, lengths)
