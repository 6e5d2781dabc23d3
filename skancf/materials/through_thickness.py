r"""A section of a law at points: integrals through the thickness at large strain, where normals stay normal.

With strain :math:`\varepsilon` and curvature change :math:`\kappa` of the surface in an orthonormal frame of the undeformed
one, whose curvatures are B, the metric of the deformed surface is :math:`a = 1 + 2 \varepsilon` and its curvatures are
:math:`b = B - \kappa`. At the height z lengths of the undeformed surface are :math:`\mu = 1 - z B` times those at z = 0, and

.. math::
    C(z) = \mu^{-1} (a - 2 z b + z^2 b a^{-1} b) \mu^{-1}
         = 1 + \mu^{-1} \bigl( 2 (\varepsilon + z \kappa) + z^2 (b a^{-1} b - B B) \bigr) \mu^{-1},

which is exact for normals that keep their length. Energy, forces and moments, and stiffness per area of the surface are

.. math::
    W = \int \psi(C(z)) \det \mu \, dz, \qquad N = \partial W / \partial \varepsilon, \quad M = \partial W / \partial \kappa,
    \qquad \partial (N, M) / \partial (\varepsilon, \kappa).

With :math:`m = a^{-1} b` and :math:`\hat S = \mu^{-1} S \mu^{-1} \det \mu`,

.. math::
    N = \int \hat S - z^2 m \hat S m^T dz, \qquad
    M = \int z \hat S - \tfrac12 z^2 (\hat S m^T + m \hat S) dz,

and the part of the stiffness that the stress has is :math:`\int z^2 \hat S dz : Y^T a^{-1} Y` with
:math:`Y = \delta \kappa + 2 \, \delta \varepsilon \, m`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.materials.free_stretch import FreeStretch, free_stretch
from skancf.materials.point_law import PointLaw
from skancf.materials.section import Section
from skancf.materials.thickness_kernels import deformations, resultants
from skancf.showing import short

POINTS = 3
"""Gauss points through the thickness: in bending of rubber to a radius of five thicknesses they are 0.004 % off, and normals
that keep their length 0.2 % (docs/decisions/0026)."""


@dataclass(frozen=True)
class SectionResponse:
    """What a section of a law at points says of n places.

    Attributes
    ----------
    energy : (n,) array
        Per area of the undeformed surface (J/m2).
    forces : (6, n) array
        N (N/m), then M (N), each in the order 11, 22, 12.
    stiffness : (21, n) array
        Derivative of the forces by the strains, entries k <= l row by row: 11 with all six, 22 with the last five, ...
    stretch33 : (n_heights, n) array
        C33 at each height.
    code : (n_heights, n) int array
        As of :class:`~skancf.materials.PointResponse`; where it is not 0, all else of that place is not a number.
    history : (n_history, n_heights, n) array

    Examples
    --------
    >>> from skancf.materials.through_thickness import heights, through_thickness
    >>> rubber = sk.NeoHooke(shear=0.4e6, density=1000.0)
    >>> sheet = sk.Problem(sk.Rectangle(1.0, 1.0), 0.002, rubber)
    >>> response = through_thickness(rubber, *heights(sheet.section), *np.zeros((3, 3, 1)))
    >>> print(response.energy, response.forces.shape)
    [0.] (6, 1)
    """

    energy: np.ndarray
    forces: np.ndarray
    stiffness: np.ndarray
    stretch33: np.ndarray
    code: np.ndarray
    history: np.ndarray

    __repr__ = short

    @property
    def first_failure(self) -> tuple[int, int, int] | None:
        """Index of the first place that the law has no stress for, of the height there, and the code."""
        if not self.code.any():
            return None
        place = int(np.argmax(self.code.any(axis=0)))
        height = int(np.argmax(self.code[:, place] != 0))
        return place, height, int(self.code[height, place])


def heights(section: Section, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points of a section, (n_heights,) (m), and their weights (m); of sections at n places (n_heights, n)."""
    z, w, _ = section.points(points)
    if section.places is None:
        return z, w
    n = z.shape[-1]
    return np.moveaxis(z, -1, 0).reshape(n, -1), np.moveaxis(w, -1, 0).reshape(n, -1)


def through_thickness(
    law: PointLaw, z: np.ndarray, weights: np.ndarray, eps: np.ndarray, kappa: np.ndarray, curvature: np.ndarray,
    guess: np.ndarray | None = None, history: np.ndarray | None = None, free: FreeStretch | None = None,
) -> SectionResponse:  # fmt: skip
    r"""Energy, forces and stiffness per area of the undeformed surface.

    Parameters
    ----------
    law : PointLaw
    z, weights : (n_heights,) or (n_heights, n) arrays
        Heights above the surface and their weights (m), of :func:`heights`.
    eps : (3, n) array
        Membrane strain, Green's, 11, 22, 12 (doubled).
    kappa : (3, n) array
        Change of curvature, the same order (doubled) (1/m).
    curvature : (3, n) array
        Of the undeformed surface, components 11, 22, 12 of :math:`R_{,ab} \cdot N` (1/m).
    guess : (n_heights, n) array, optional
        Of C33.
    history : (n_history, n_heights, n) array, optional
    free : FreeStretch, optional
        Stretch without stress of all points, the heights one after the other.

    Returns
    -------
    SectionResponse

    Examples
    --------
    >>> from skancf.materials.through_thickness import heights, through_thickness
    >>> rubber = sk.NeoHooke(shear=0.4e6, density=1000.0)
    >>> sheet = sk.Problem(sk.Rectangle(1.0, 1.0), 0.002, rubber)
    >>> stretched = np.array([[0.5 * (1.1**2 - 1)], [0.0], [0.0]])
    >>> flat = np.zeros((3, 1))
    >>> response = through_thickness(rubber, *heights(sheet.section), stretched, flat, flat)
    >>> print(f"{response.forces[0, 0]:.1f} N/m")
    253.6 N/m
    """
    n = eps.shape[1]
    eps, kappa, curvature = (np.ascontiguousarray(each) for each in (eps, kappa, curvature))
    z, weights = (np.ascontiguousarray(_columns(each)) for each in (z, weights))
    C = np.empty((3, len(z) * n))
    deformations(z, eps, kappa, curvature, C)
    start = None if guess is None else np.ascontiguousarray(guess).reshape(-1)
    past = None if history is None else np.ascontiguousarray(history).reshape(len(history), -1)
    if free is not None:
        start = None if start is None else start / free.across
    found = law.respond(C, start, past) if free is None else free.respond(law.respond, C, start, past)
    energy, forces, full = np.empty(n), np.empty((6, n)), np.empty((21, n))
    resultants(z, weights, eps, kappa, curvature, found.energy, found.stress, found.stiffness, energy, forces, full)
    shape = (len(z), n)
    return SectionResponse(energy, forces, full, found.stretch33.reshape(shape), found.code.reshape(shape),
                           found.history.reshape(-1, *shape))  # fmt: skip


def heated_through_thickness(
    law: PointLaw, z: np.ndarray, weights: np.ndarray, eps: np.ndarray, kappa: np.ndarray, curvature: np.ndarray,
    middle: np.ndarray, gradient: np.ndarray,
) -> SectionResponse:  # fmt: skip
    r"""The same under a temperature change T0 + z T1, (n,) each (K, K/m), with which the law expands freely.

    Normals grow with T0, by the stretch :math:`\beta = 1 + \alpha_{33} T_0`, and lengths are measured in it:

    .. math::
        W = \beta^3 \, \hat W \Bigl( \frac{\varepsilon - (\beta^2 - 1) / 2}{\beta^2},
        \frac{\kappa + (\beta - 1) B}{\beta} \Bigr)

    with a section :math:`\hat W` whose points have the free stretch :math:`(1 + \alpha T) / \beta`. So a shell that expands
    by the same everywhere has no stress, whatever its curvature, and a flat one none where it bends freely with T1.
    """
    grown, eps, kappa = _in_grown_lengths(law, eps, kappa, curvature, middle)
    change = (middle + _columns(z) * gradient).reshape(-1)
    free = free_stretch(law.thermal_strain(), change, plane=True, over=np.tile(grown, len(z)))
    found = through_thickness(law, z, weights, eps, kappa, curvature, free=free)
    powers = np.array([1, 1, 1, 2, 2, 2])
    of_pairs = np.array([powers[k] + powers[l] - 3 for k in range(6) for l in range(k, 6)])
    return replace(
        found, energy=grown**3 * found.energy, forces=grown ** powers[:, None] * found.forces,
        stiffness=grown ** of_pairs[:, None] * found.stiffness, stretch33=grown**2 * found.stretch33,
    )  # fmt: skip


def _in_grown_lengths(
    law: PointLaw, eps: np.ndarray, kappa: np.ndarray, curvature: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    r"""The free stretch :math:`\beta` of normals, and strain and curvature change with lengths measured in it."""
    grown = 1 + law.thermal_strain()[2] * middle
    eps = (eps - 0.5 * (grown - 1) * (grown + 1) * np.array([[1.0], [1.0], [0.0]])) / grown**2
    return grown, eps, (kappa + (grown - 1) * curvature * [[1.0], [1.0], [2.0]]) / grown


def deformation_at(
    law: Any, z: Any, eps: np.ndarray, kappa: np.ndarray, curvature: np.ndarray, middle: np.ndarray | None
) -> np.ndarray:
    """C11, C22, C12 (3, n) at a height, or one for each place, of strains as those of :func:`through_thickness`, with T0
    (n,) or without heat."""
    C, grown = np.empty((3, eps.shape[1])), np.ones(1)
    if middle is not None:
        grown, eps, kappa = _in_grown_lengths(law, eps, kappa, curvature, middle)
    parts = (np.ascontiguousarray(part) for part in (eps, kappa, curvature))
    deformations(np.array(z, dtype=float).reshape(1, -1), *parts, C)
    return C if middle is None else C * grown**2


def _columns(z: np.ndarray) -> np.ndarray:
    """Heights of all places as those of each, (n_heights, 1)."""
    return z if z.ndim > 1 else z[:, None]


def require_one_side(z: np.ndarray, curvature: np.ndarray) -> None:
    """InputError where the section reaches beyond a centre of curvature."""
    for h in (z.min(), z.max()):
        area = (1 - h * curvature[0]) * (1 - h * curvature[1]) - (h * curvature[2]) ** 2
        if not (area > 0).all() or not (1 - h * curvature[0] > 0).all():
            raise InputError(f"thickness: at the height {h:.6g} m the section is past a centre of curvature of the surface")
