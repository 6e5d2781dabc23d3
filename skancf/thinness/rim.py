"""Where on its rim a plate lets its directors tilt, and near which points the thin theory means nothing."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skancf.history import FULL, Case
from skancf.kernels.constants import R_X, R_Y, R
from skancf.layout.singularities import Singularity, beside_each_other, nodes_at
from skancf.showing import short
from skancf.surfaces import normal
from skancf.system.regularity import facets_of, singularities
from skancf.system.system import System
from skancf.tolerances import ONE_DIRECTION

FREE, MIRROR, SUPPORTED, CLAMPED = range(4)
"""Kinds of edges: one for a rotation about the edge that is held, and two for a deflection that is."""
COUPLED = 0.05
"""D16 over the root of D11 D66 from which on it counts."""
MORE = np.radians(2.0)
"""By how much the angle of a corner has to be larger than one without a singularity."""


@dataclass(frozen=True)
class Rim:
    """The boundary of a system by how it is held.

    Attributes
    ----------
    system : System
    facets : (m,) int array
    held : (n_nodes, 4) bool array
        Nodal vectors whose part along the undeformed normal is prescribed.
    kinds : (m,) int array
        :data:`FREE`, :data:`MIRROR`, :data:`SUPPORTED` or :data:`CLAMPED`: what both ends of a facet hold. A mirror is a
        symmetry, or a guided edge.
    found : list of Singularity
        What supports, loads and other terms say.

    Examples
    --------
    >>> from skancf.thinness.rim import rim_of
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> rim = rim_of(system)
    >>> print(rim.facets.shape[-1])
    24
    """

    system: System
    facets: np.ndarray
    held: np.ndarray
    kinds: np.ndarray
    found: list[Singularity]

    __repr__ = short

    @property
    def tilting(self) -> np.ndarray:
        """Facets along which directors tilt freely: free and elastic edges, and soft supports, (k,).

        The thin nodes do not know it of a support, which says that it holds the tilt.
        """
        held = facets_of(self.found, "tilt")
        return np.asarray(self.facets[((self.kinds == FREE) | (self.kinds == SUPPORTED)) & ~np.isin(self.facets, held)])

    @property
    def strong(self) -> np.ndarray:
        """Positions (3, k) of points about which the energy of the thin theory's shear forces has no limit.

        Those are corners, and forces, moments and supports at single points.
        """
        geometry = self.system.geometry
        loads = [each.alone for each in self.found if each.pushes("force") or each.pushes("moment")]
        nodes = geometry.points[:, self._corners | self._single]
        return np.asarray(geometry.surface.position(*np.hstack([nodes, *loads])))

    @cached_property
    def _angles(self) -> np.ndarray:
        """Of the material about each node, in space (rad), (n_nodes,)."""
        geometry = self.system.geometry
        corners, slopes = geometry.mesh.p[:, geometry.mesh.t], np.stack(geometry.surface.derivatives(*geometry.mesh.p))
        one, two = (
            np.einsum("dce,dice->ice", np.roll(corners, shift, axis=1) - corners, slopes[:, :, geometry.mesh.t])
            for shift in (-1, 1)
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            cosines = (one * two).sum(axis=0) / np.linalg.norm(one, axis=0) / np.linalg.norm(two, axis=0)
        nodes = geometry.ties.node_of[geometry.mesh.t]
        own = nodes >= 0  # hanging nodes are no corners
        return np.bincount(nodes[own], np.arccos(np.clip(cosines, -1, 1))[own], minlength=geometry.n_nodes)

    @property
    def _corners(self) -> np.ndarray:
        """Nodes of the boundary where it is singular, (n_nodes,).

        By the largest angle that is not (Williams 1952): 180 degrees between edges of one kind, 90 where one is supported
        and not all, or all and the boundary turns, none between a clamped and a free edge. A mirror doubles the angle. Where
        bending along an edge twists the plate, right angles between supports are what larger ones are without that.
        """
        n = self.system.geometry.n_nodes
        ends = self.system.geometry.ends(self.facets)
        counts = np.stack([np.bincount(ends[:, self.kinds == kind].ravel(), minlength=n) for kind in range(4)])
        free, _, supported, clamped = counts > 0
        angles = self._angles * np.where(counts[MIRROR] == 1, 2, 1)
        turns = np.abs(angles - np.pi) > MORE
        mixed = free.astype(int) + supported + clamped > 1
        out = turns & (angles > np.pi + MORE)
        out |= supported & (mixed | turns) & (angles > (0 if self._couples else np.pi / 2 + MORE))
        out |= clamped & free
        return out & (counts.sum(axis=0) > 0) & (counts[MIRROR] < 2)

    @property
    def _couples(self) -> bool:
        """Does the section couple bending and twisting along its axes?"""
        D = [section.abd()[3:, 3:] for section in self.system.assembly.section.samples()]
        return any(bool((d[:2, 2] ** 2 > COUPLED**2 * d[2, 2] * d.diagonal()[:2]).any()) for d in D)

    @property
    def _single(self) -> np.ndarray:
        """Nodes held or sprung on their own, (n_nodes,), but not the free corners of up to 90 degrees that only rest: there
        the thin theory carries the force by its twisting moment."""
        geometry = self.system.geometry
        out = np.zeros(geometry.n_nodes, dtype=bool)
        for each in self.found:
            if each.holds and each.at_rest and each.alone.size:
                nodes = nodes_at(geometry, each.alone)
                out[nodes[~beside_each_other(geometry, nodes)]] = True
        on_edges = np.isin(np.arange(geometry.n_nodes), geometry.ends(self.facets[self.kinds >= SUPPORTED]))
        resting = ~self.held[:, R_X] & (self._angles < np.pi / 2 + MORE)
        return out & ~on_edges & ~resting


def rim_of(system: System, case: Case = FULL) -> Rim:
    """The rim of a system, by its constraints, and by what its supports and loads say."""
    geometry, facets = system.geometry, system.geometry.boundary
    with np.errstate(invalid="ignore", divide="ignore"):
        n = np.nan_to_num(normal(geometry.surface, *geometry.points).T)  # none at a pole
    held = np.einsum("na,nkab,nb->nk", n, system.constraints.of_vectors()[: len(n)], n) > 1 - ONE_DIRECTION
    ends, (x, y) = geometry.ends(facets), np.abs(geometry.facet_directions(facets))
    across = np.where(y > x, R_X, R_Y)
    deflection, rotation = ((held[ends, kind] & (ends >= 0)).all(axis=0) for kind in (R, across))
    return Rim(system, facets, held, 2 * deflection + rotation, singularities(system, case))
