"""Fields, stresses, energies and reactions of one state of a system."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.assembly.system import System
from skancf.elements.reference import CORNERS
from skancf.errors import InputError, finite, number
from skancf.theories.full import covariant_to_local, position_table

STRESSES = ("S11", "S22", "S33", "S23", "S13", "S12")


@dataclass(frozen=True)
class Solution:
    """One state: nodal coordinates with their system.

    Attributes
    ----------
    system : System
    q : (n_dofs,) array
        Nodal coordinates.
    velocity : (n_dofs,) array or None
        Their rates, in dynamics.
    time : float or None
    load_factor : float
        Factor of all loads, in statics.
    linear : bool
        A small-deflection answer, in equilibrium with the tangent of the undeformed state.
    """

    system: System
    q: np.ndarray
    velocity: np.ndarray | None = None
    time: float | None = None
    load_factor: float = 1.0
    linear: bool = False

    @property
    def displacements(self) -> np.ndarray:
        """Displacements of the nodes, (3, n_nodes) (m)."""
        return (self.q - self.system.undeformed).reshape(-1, 4, 3)[:, 0].T

    def displacement(self, at: Any, z: float = 0.0) -> np.ndarray:
        """Displacement at points of the parameter plane, (2,) or (n, 2), at depth z: (3,) or (n, 3)."""
        return at_points(self.system, self.q - self.system.undeformed, at, self._depth(z))

    def position(self, at: Any, z: float = 0.0) -> np.ndarray:
        """Position in space of points of the parameter plane, (2,) or (n, 2), at depth z: (3,) or (n, 3)."""
        return at_points(self.system, self.q, at, self._depth(z))

    def strains(self, points: np.ndarray, z: float = 0.0) -> np.ndarray:
        """Green-Lagrange strain in the local frame at points (2, n) of every element and depth z: (n_elements, n, 6).

        Order 11, 22, 33, 23, 13, 12, shear strains doubled.
        """
        geometry = self.system.geometry
        theory = geometry.theory
        change = theory.strains(geometry.local(self.q.reshape(-1, 4, 3)), points) - theory.strains(
            geometry.undeformed_local, points
        )
        jets = theory.jets(geometry.undeformed_local, points)
        to_local, _ = covariant_to_local(jets, geometry.tangents(points), np.array([self._depth(z)]))
        return np.einsum("vken,ekn->env", to_local[0], change, optimize=True)

    def stresses(self, points: np.ndarray, z: float = 0.0) -> np.ndarray:
        """Second Piola-Kirchhoff stress in the local frame at points (2, n) of every element: (n_elements, n, 6) (Pa).

        The law is that of the layer at z, of the lower one at an interface.
        """
        section = self.system.problem.section
        return self.strains(points, z) @ section.stiffness[section.layer_at(z)]

    def nodal_stresses(self, z: float = 0.0) -> np.ndarray:
        """Second Piola-Kirchhoff stress at the nodes, averaged over the elements that meet there: (n_nodes, 6) (Pa)."""
        geometry = self.system.geometry
        out = np.zeros((geometry.n_nodes, 6))
        np.add.at(out, geometry.nodes, self.stresses(CORNERS.T, z))
        return out / np.bincount(geometry.nodes.ravel(), minlength=geometry.n_nodes)[:, None]

    @property
    def strain_energy(self) -> float:
        """Strain energy (J)."""
        return self.system.strain_energy(self.q)

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy (J); zero in statics."""
        if self.velocity is None:
            return 0.0
        return 0.5 * float(self.velocity @ (self.system.mass @ self.velocity))

    def reactions(self, where: Any = None) -> np.ndarray:
        """Sum of the support forces (3,) (N) in a state of rest, at a place or everywhere.

        Raises
        ------
        InputError
            For a state that moves: its supports also carry inertia.
        """
        if self.velocity is not None and np.any(self.velocity):
            raise InputError("reactions: this state moves, and its supports also carry inertia; reactions are for statics")
        system = self.system
        if self.linear:
            start = system.undeformed
            residual = system.tangent(start) @ (self.q - start) - system.external_force(start)
        else:
            residual = system.internal_force(self.q) - self.load_factor * system.external_force(self.q, self.time)
        forces = system.constraints.fixed_part(residual).reshape(-1, 4, 3)[:, 0]
        return forces.sum(axis=0) if where is None else forces[system.geometry.nodes_on(where)].sum(axis=0)

    def _depth(self, z: float) -> float:
        if number("z", z):
            self.system.problem.section.layer_at(z)
        return float(z)


def require_same_mesh(system: System, start: Solution) -> None:
    """InputError for a state that was computed on another mesh."""
    if start.system.mesh is not system.mesh:
        raise InputError("start belongs to another mesh; nodal coordinates have a meaning only on their own one")


def at_points(system: System, q: np.ndarray, at: Any, z: float = 0.0) -> np.ndarray:
    """Values of a nodal vector's field at points of the parameter plane, (2,) or (n, 2): (3,) or (n, 3)."""
    out = probe(system, at, z) @ q.reshape(-1, 3)
    return out[0] if np.ndim(at) == 1 else out


def probe(system: System, at: Any, z: float = 0.0) -> sp.csr_matrix:
    """Weights (n, 4 n_nodes) that make values at points of the parameter plane, (2,) or (n, 2), of nodal vectors."""
    geometry, rows = system.geometry, []
    for place in np.atleast_2d(finite("at", at)):
        element, local = geometry.locate(place)
        r, d = position_table(local[:, None])[:, :, 0]
        weights = np.zeros((1, 16, 3))
        weights[0, :, 0] = r + z * d
        rows.append(sp.csr_matrix(geometry.nodal(weights, np.array([element]))[:, :, 0].reshape(1, -1)))
    return sp.vstack(rows).tocsr()
