"""A problem on a mesh with a theory: what solvers know."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from skancf.assembly import kernels, tangent_kernel
from skancf.assembly.geometry import Geometry
from skancf.assembly.residual_kernel import residual
from skancf.assembly.schedule import Schedule
from skancf.assembly.sections import Sections
from skancf.errors import InputError
from skancf.linear import BlockMatrix, BlockPattern, Constraints
from skancf.theories.full import D1, D2, N_IN_PLANE, R1, R2, D, jet_table, position_table


class Loading(Protocol):
    """A load on a given mesh."""

    def force(self, q: np.ndarray, time: float | None) -> np.ndarray:
        """External force (n_nodes, 4, 3) in the configuration q at a time; None means its full amplitude."""

    def stiffness(self, q: np.ndarray, time: float | None) -> tuple[np.ndarray, np.ndarray] | None:
        """Nodes (m,) and symmetric blocks (m, 12, 12) of minus the force's derivative; None for a dead load."""


class Prescription(Protocol):
    """Prescribed coordinates in time."""

    def values(self, time: float | None) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,), zero along free directions."""


class System:
    """Residual, tangent and mass of a problem on a mesh.

    Nodal coordinates are one vector q of 12 per node: r, r_x, r_y, r_z, three components each.

    Attributes
    ----------
    geometry, sections
        What it was made of.
    undeformed : (n_dofs,) array
    constraints : Constraints
    """

    def __init__(
        self,
        geometry: Geometry,
        sections: Sections,
        constraints: Constraints,
        prescription: Prescription,
        loads: Sequence[Loading],
        problem: Any,
    ):
        self.geometry, self.sections = geometry, sections
        self.constraints, self.prescription, self.loads, self.problem = constraints, prescription, loads, problem
        self.undeformed = geometry.undeformed.ravel()
        self.pattern = BlockPattern.from_cells(
            geometry.nodes.T, geometry.n_nodes, 12, geometry.surface.position(*geometry.points)
        )
        self._slots = self.pattern.slots(geometry.nodes.T)
        self._schedule = Schedule(geometry.nodes, geometry.points)
        self._rule = _rule(geometry, sections)
        self._elements = kernels.Elements(
            geometry.nodes, geometry.pointer, geometry.rows, geometry.cols // 4, geometry.cols % 4, geometry.values,
            sections.shape, sections.reference, sections.law, sections.sampled,
        )  # fmt: skip

    @property
    def n_dofs(self) -> int:
        """Nodal coordinates, prescribed ones included."""
        return self.undeformed.size

    @property
    def mesh(self) -> Any:
        """The mesh in the parameter plane."""
        return self.geometry.mesh

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        """Derivative of the strain energy, (n_dofs,)."""
        out = np.zeros_like(self.geometry.undeformed)
        self._schedule.run(residual, self._nodal(q), self._rule, self._elements, out)
        return out.ravel()

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        """Stresses at the integration points with their weights, extrapolated linearly along ``change``.

        Shape (n_elements, n_strains, n_points).
        """
        return self._strains_and_stresses(q, change, keep_strains=False)[1]

    def _strains_and_stresses(
        self, q: np.ndarray, change: np.ndarray | None, keep_strains: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        shape = (self.geometry.n_elements, *self.sections.reference.shape[1:])
        strains, out = np.empty(shape if keep_strains else (0, 0, 0)), np.empty(shape)
        change = np.zeros(self.n_dofs) if change is None else change
        self._schedule.run(
            kernels.stresses, self._nodal(q), self._nodal(change), self._rule, self._elements, strains, out
        )
        return strains, out

    def tangent(
        self, q: np.ndarray, stresses: np.ndarray | None = None, time: float | None = None, factor: float = 1.0
    ) -> BlockMatrix:
        """Derivative of the residual; ``stresses`` other than those of q give the mixed tangent of Newton's method."""
        if stresses is None:
            stresses = self.stresses(q)
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        self._schedule.run(
            tangent_kernel.tangent, self._nodal(q), stresses, self._rule, self._elements, self._slots, out
        )
        for load in self.loads:
            blocks = load.stiffness(q.reshape(-1, 4, 3), time)
            if blocks is not None:
                out[self.pattern.diagonal_slots[blocks[0]]] += factor * blocks[1]
        return BlockMatrix(self.pattern, out)

    def external_force(self, q: np.ndarray, time: float | None = None) -> np.ndarray:
        """Loads at a time, (n_dofs,); without a time at their full amplitude."""
        total = np.zeros_like(self.geometry.undeformed)
        for load in self.loads:
            total += load.force(q.reshape(-1, 4, 3), time)
        return total.ravel()

    def prescribed(self, time: float | None = None) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,)."""
        return self.prescription.values(time)

    def strain_energy(self, q: np.ndarray) -> float:
        """Half of stress times strain, integrated."""
        strains, stresses = self._strains_and_stresses(q, None, keep_strains=True)
        return 0.5 * float(np.vdot(strains, stresses))

    @cached_property
    def mass(self) -> BlockMatrix:
        """The constant mass matrix, with the rotary part of r_z."""
        r, d = position_table(self.geometry.theory.quadrature[0])
        m0, m1, m2 = np.moveaxis(self.sections.moments, 1, 0)
        shapes = (
            np.einsum("ap,bp,sp->sab", r, r, m0)
            + np.einsum("ap,bp,sp->sab", r, d, m1)
            + np.einsum("ap,bp,sp->sab", d, r, m1)
            + np.einsum("ap,bp,sp->sab", d, d, m2)
        )
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        self._schedule.run(tangent_kernel.mass, shapes, self._elements, self._slots, out)
        return BlockMatrix(self.pattern, out)

    def _nodal(self, q: np.ndarray) -> np.ndarray:
        if np.size(q) != self.n_dofs:
            raise InputError(f"a vector of {np.size(q)} nodal coordinates; this system has {self.n_dofs}, 12 per node")
        return np.ascontiguousarray(q, dtype=float).reshape(-1, 4, 3)


def _rule(geometry: Geometry, sections: Sections) -> kernels.Rule:
    theory = geometry.theory
    inside, sampled = jet_table(theory.quadrature[0]), jet_table(theory.samples)
    interpolation, rows = theory.sampling()
    position = np.ascontiguousarray(inside[[R1, R2], :12].swapaxes(0, 1))
    director = np.ascontiguousarray(inside[[D1, D2], 12:].swapaxes(0, 1))
    k, l = sections.pairs.T
    return kernels.Rule(
        position=position,
        director=director,
        position_twice=np.tile(position, 2),
        director_twice=np.tile(director, 2),
        position_columns=np.ascontiguousarray(position.reshape(12, -1).T),
        director_columns=np.ascontiguousarray(director.reshape(4, -1).T),
        sample_position=np.ascontiguousarray(sampled[[R1, R2], :12].transpose(0, 2, 1)),
        sample_director=np.ascontiguousarray(sampled[[D1, D2, D], 12:].transpose(0, 2, 1)),
        interpolation=interpolation,
        plain=not theory.assumed,
        sample_rows=rows,
        pairs=sections.pairs,
        coupled=bool(((k < N_IN_PLANE) & (l >= N_IN_PLANE)).any()),
    )
