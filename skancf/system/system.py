"""What solvers know: sums of terms over a layout of unknowns, and which of these are held."""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem

from skancf.conditions.sums import Conditions
from skancf.history import FULL, Case
from skancf.layout import skfem_bridge
from skancf.layout.layout import Layout
from skancf.linear import BlockMatrix, Constraints
from skancf.showing import in_brackets, system_in_words
from skancf.system.inertia import Inertia
from skancf.system.rebuild import Rebuilt
from skancf.system.unstressed import ByStrains, unstressed
from skancf.terms.blocks import Blocks, SkewBlocks, coupled
from skancf.terms.protocols import Assembly, Prescription
from skancf.terms.shell import Shell, total
from skancf.terms.sums import Loads, Terms
from skancf.terms.term import Term


class System(Rebuilt):
    """Residual, tangent and mass of a problem on a mesh.

    Unknowns are one vector q of 12 per block, see :class:`~skancf.layout.layout.Layout`: at a node r, r_x, r_y and r_z
    (`full`) or r_xy (`kirchhoff`), three components each.

    Parameters
    ----------
    layout : Layout
    shell : Shell
    terms : sequence of Term
        The others, loads among them.
    constraints : Constraints
    prescription : Prescription
    problem : Problem
    conditions : Conditions

    Attributes
    ----------
    undeformed : (n_dofs,) array
    blocks : callable
        Makes a sum, :class:`~skancf.terms.blocks.Blocks`, to which terms add their matrices.
    terms : Terms
        All of them, the shell first.
    loads : Loads
        Those that act from outside.
    others : Terms
        Those of the structure, but for the shell: springs, foundations, the user's own.
    choice
        With ``theory="auto"``: which theory was taken, the modelling error of the thin one, and why.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(system.n_dofs, system.mesh.nelements)
    588 36
    """

    __repr__, __str__ = in_brackets, system_in_words

    def __init__(
        self, layout: Layout, shell: Shell, terms: Sequence[Term], constraints: Constraints, prescription: Prescription,
        problem: Any, conditions: Conditions,
    ):  # fmt: skip
        self.layout, self.shell, self.problem = layout, shell, problem
        self.constraints, self.prescription, self.conditions = constraints, prescription, conditions
        self.undeformed = layout.undeformed.ravel()
        self.pattern, known = coupled([term.couples() for term in (shell, *terms, *conditions)], layout)
        self.blocks = partial(Blocks, self.pattern, known)
        self.terms = Terms([shell, *terms], layout.n_dofs, self.blocks)
        self.loads = Loads([term for term in terms if term.load], layout.n_dofs, self.blocks)
        self.others = Terms([term for term in terms if not term.load], layout.n_dofs, self.blocks)
        for term in self.terms:
            term.bind(self.blocks())

    @property
    def n_dofs(self) -> int:
        return self.layout.n_dofs

    @property
    def assembly(self) -> Assembly:
        """The theory on the mesh."""
        return self.shell.assembly

    @property
    def geometry(self) -> Any:
        """The mesh on the surface."""
        return self.shell.geometry

    @property
    def mesh(self) -> Any:
        return self.geometry.mesh

    def internal_force(self, q: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """Force of the structure, (n_dofs,): the derivative of its energy without that of free strains."""
        force = self.shell.internal_force(q, case)
        return force + self.others.force(q, v, case) if self.others else force

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """Those of the shell, see :meth:`~skancf.terms.shell.Shell.stresses`."""
        return self.shell.stresses(q, change, case)

    def tangent(
        self, q: np.ndarray, case: Case = FULL, stresses: np.ndarray | None = None, stiffer: float = 1.0,
        v: np.ndarray | None = None,
    ) -> BlockMatrix:  # fmt: skip
        """Symmetric part of the derivative of the residual; mixed where ``stresses`` are not those of q. The law counts
        ``stiffer`` times, as that of a material with damping does over a step."""
        blocks = self.blocks()
        self.shell.add_tangent(q, v, case, blocks, stresses, stiffer)
        self.terms.add_tangents(q, v, case, blocks, first=1)
        return blocks.matrix()

    def skew(self, q: np.ndarray, case: Case = FULL, v: np.ndarray | None = None) -> sp.csr_matrix | None:
        """Skew part of the derivative of the residual, which follower loads have at free edges; None without one."""
        blocks = SkewBlocks(self.pattern)
        self.terms.add_tangents(q, v, case, blocks, first=1)
        return blocks.skew_matrix()

    def stiffness(self) -> BlockMatrix:
        """Tangent of the undeformed state without stresses of the shell, see :mod:`skancf.system.unstressed`."""
        return self._stiffness

    @cached_property
    def _stiffness(self) -> BlockMatrix:
        return BlockMatrix(self.pattern, unstressed(self).values, ByStrains(self.shell, self.undeformed, self.foundation))

    @cached_property
    def foundation(self) -> BlockMatrix | None:
        """Tangent of :attr:`others` in the undeformed state, that of springs; None where it is zero."""
        return self.others.tangent(self.undeformed)

    def external_force(self, q: np.ndarray, case: Case = FULL) -> np.ndarray:
        """Loads and the forces of initial stresses, (n_dofs,)."""
        applied, initial = self.applied_force(q, case), self.shell.initial_stress_force(q, case)
        return applied if initial is None else applied + initial

    def applied_force(self, q: np.ndarray, case: Case = FULL, v: np.ndarray | None = None) -> np.ndarray:
        """Loads without those of temperature, which do no work on the body from outside: (n_dofs,)."""
        return self.loads.applied(q, v, case)

    def prescribed(self, case: Case = FULL) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,)."""
        return self.prescription.values(case)

    def histories(self) -> list[Any]:
        """The functions of time of terms and prescribed motions, and the paths of loads that move, each once."""
        every = self.terms.histories() + self.conditions.histories() + self.prescription.histories()
        return list({id(history): history for history in every if history is not None}.values())

    def strain_energy(self, q: np.ndarray, case: Case = FULL) -> float:
        """Energy of the structure (J): see :meth:`~skancf.terms.shell.Shell.energy`, and that of other terms."""
        return self.shell.energy(q, case) + self.others.energy(q, case)

    @cached_property
    def mass(self) -> BlockMatrix:
        """The constant mass matrix."""
        blocks = self.blocks()
        for term in self.terms:
            term.add_mass(blocks)
        return blocks.matrix()

    @cached_property
    def inertia(self) -> Inertia:
        """Sums with it: momenta, and the mass of everything."""
        return Inertia(self.mass, self.layout)

    @cached_property
    def viscous(self) -> BlockMatrix | None:
        r"""Forces in proportion to velocities, :math:`\alpha M` and the dashpots (N s/m); None without any."""
        damping = self.problem.damping
        of_mass = None if damping is None or not damping.mass else float(damping.mass) * self.mass
        blocks = self.blocks()
        for term in self.terms:
            term.add_viscous(blocks)
        return total([None if blocks.is_zero else blocks.matrix(), of_mass])

    def kinetic_energy(self, v: np.ndarray) -> float:
        """Half of v . M v (J)."""
        return 0.5 * float(v @ (self.mass @ v))

    def momenta(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Linear and angular momentum, (2, 3), see :meth:`skancf.system.inertia.Inertia.momenta`."""
        return self.inertia.momenta(q, v)

    def basis(self, intorder: int = 7, *, facets: Any = None, thickness: float | None = None) -> skfem.AbstractBasis:
        """A basis of scikit-fem, see :func:`skancf.layout.skfem_bridge.basis_on`: the deformed surface in a state q is
        ``system.basis().interpolate(system.to_mesh @ q)``."""
        return skfem_bridge.basis_on(self.geometry, intorder, facets, thickness)

    @cached_property
    def to_mesh(self) -> sp.csr_matrix:
        r"""T, from the unknowns to the degrees of freedom of :meth:`basis`, (12 n_mesh_nodes, n_dofs): a form's force f and
        stiffness K on the basis are :math:`T^T f` and :math:`T^T K T` here."""
        return skfem_bridge.unknowns_to_mesh(self.geometry, self.layout, self.shell.name)
