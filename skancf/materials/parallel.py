r"""Parallel surfaces: lengths, areas, strains and curvatures at a height above a curved surface.

Curvatures b are components 11, 22, 12 in the local frame of the undeformed surface, (..., 3) (1/m), negative where it is
bulged towards the normal. A height z is one number, or one for each place, (...). Lengths there are :math:`\mu = 1 - z b`
times those of the surface, so that, linear in strain and curvature change, and exact for normals that stay normal and keep
their length,

.. math::
    \varepsilon(z) = \mu^{-1} \bigl( \varepsilon + z \kappa - \tfrac12 z^2 (b \kappa + \kappa b) - z^2 b \varepsilon b \bigr)
    \mu^{-1}, \qquad \kappa(z) = \mu^{-1} \bigl( \kappa - z (b \kappa + \kappa b) - 2 z b \varepsilon b \bigr) \mu^{-1}.
"""

from typing import Any

import numpy as np

TRACE = np.array([1.0, 1.0, 0.0])


def sums(b: np.ndarray) -> np.ndarray:
    r"""From a strain X in the order 11, 22, 12 (doubled) to :math:`b X + X b`: curvatures (..., 3) to (..., 3, 3)."""
    one, two, both = np.moveaxis(b, -1, 0)
    o = np.zeros_like(one)
    return _matrix([[2 * one, o, both], [o, 2 * two, both], [2 * both, 2 * both, one + two]])


def between(m: np.ndarray) -> np.ndarray:
    """From a strain X to m X m with symmetric m, components 11, 22, 12 (..., 3): (..., 3, 3)."""
    one, two, both = np.moveaxis(m, -1, 0)
    return _matrix([
        [one**2, both**2, one * both],
        [both**2, two**2, two * both],
        [2 * one * both, 2 * two * both, one * two + both**2],
    ])  # fmt: skip


def _matrix(rows: list[list[np.ndarray]]) -> np.ndarray:
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def determinant(b: np.ndarray) -> np.ndarray:
    """Gaussian curvature, (...)."""
    return np.asarray(b[..., 0] * b[..., 1] - b[..., 2] ** 2)


def principal_curvatures(b: np.ndarray) -> np.ndarray:
    """The smaller and the larger one, (2, ...)."""
    mean = (b @ TRACE) / 2
    deviation = np.sqrt(np.maximum(mean**2 - determinant(b), 0.0))
    return np.stack([mean - deviation, mean + deviation])


def area_at(b: np.ndarray, z: Any) -> np.ndarray:
    """Area at a height per area of the reference surface, det(1 - z b): (...)."""
    return np.asarray(1 - z * (b @ TRACE) + z * z * determinant(b))


def curvature_at(b: np.ndarray, z: Any) -> np.ndarray:
    """Curvature of the parallel surface at a height, (..., 3)."""
    return np.asarray((b - (z * determinant(b))[..., None] * TRACE) / area_at(b, z)[..., None])


def strains_at(b: np.ndarray, z: Any) -> np.ndarray:
    """From strain and curvature change of the surface to those of the parallel one at a height: (..., 6, 6)."""
    z = np.asarray(z)[..., None]
    inverse = between((TRACE - z * ((b @ TRACE)[..., None] * TRACE - b)) / area_at(b, z[..., 0])[..., None])
    z = z[..., None]
    both, inner = sums(b), between(b)
    top = np.concatenate([np.eye(3) - z * z * inner, z * np.eye(3) - z * z / 2 * both], axis=-1)
    bottom = np.concatenate([-2 * z * inner, np.eye(3) - z * both], axis=-1)
    return np.concatenate([inverse @ top, inverse @ bottom], axis=-2)
