"""What solvers know: sums of terms over a layout of unknowns, and which of these are held."""

from collections.abc import Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem

from skancf.history import FULL, Case, check_cover
from skancf.kernels.constants import BLOCK
from skancf.layout import skfem_bridge
from skancf.layout.layout import Layout
from skancf.linear import BlockMatrix, BlockPattern, Constraints
from skancf.system import dilation, rigid
from skancf.system.unstressed import ByStrains
from skancf.terms.blocks import Blocks, SkewBlocks
from skancf.terms.load import Loads
from skancf.terms.protocols import Assembly, Prescription
from skancf.terms.shell import Shell, total
from skancf.terms.term import Term
from skancf.vectors import sum_of_cross


class System:
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

    Attributes
    ----------
    undeformed : (n_dofs,) array
    loads : Loads
        The terms that act from outside.
    others : tuple of Term
        Those of the structure, but for the shell.
    choice
        With ``theory="auto"``: which theory was taken, the modelling error of the thin one, and why.
    """

    choice: Any = None

    def __init__(
        self, layout: Layout, shell: Shell, terms: Sequence[Term], constraints: Constraints, prescription: Prescription,
        problem: Any,
    ):  # fmt: skip
        self.layout, self.shell, self.problem = layout, shell, problem
        self.constraints, self.prescription = constraints, prescription
        self.undeformed = layout.undeformed.ravel()
        self.terms = (shell, *terms)
        self.loads = Loads([term for term in terms if term.load], layout.n_dofs)
        self.others = tuple(term for term in terms if not term.load)
        cells = {id(each): each for each in (term.couples() for term in self.terms) if each.size}
        graph = tuple(each.T for each in cells.values())
        self.pattern = BlockPattern.from_cells(graph, layout.n_blocks, BLOCK, layout.places.T)
        self._known = {key: (each, self.pattern.slots(each.T)) for key, each in cells.items()}
        for term in self.terms:
            term.bind(self.blocks())

    def blocks(self) -> Blocks:
        """A sum to which terms add their matrices."""
        return Blocks(self.pattern, self._known)

    @property
    def n_dofs(self) -> int:
        """Unknowns, prescribed ones included."""
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
        """The mesh in the parameter plane."""
        return self.geometry.mesh

    def internal_force(self, q: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """Force of the structure, (n_dofs,): the derivative of its energy without that of free strains."""
        force = self.shell.internal_force(q)
        return force + self.others_force(q, v, case) if self.others else force

    def others_force(self, q: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """The part of it that the shell does not have: springs, foundations, terms of the user's own."""
        return sum((term.force(q, v, case) for term in self.others), np.zeros(self.n_dofs))

    def others_between(self, q0: np.ndarray, q1: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        """The same between two states, so that it does the work of the energy where terms know how."""
        out = np.zeros(self.n_dofs)
        for term in self.others:
            between = term.between(q0, q1, case)
            out += term.force(0.5 * (q0 + q1), v, case) if between is None else between
        return out

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        """Stresses at the integration points with their weights, extrapolated linearly along ``change``.

        Shape (n_elements, n_strains, n_points). Those of a temperature change are not subtracted.
        """
        return self.shell.stresses(q, change)

    def tangent(
        self, q: np.ndarray, case: Case = FULL, stresses: np.ndarray | None = None, stiffer: float = 1.0,
        v: np.ndarray | None = None,
    ) -> BlockMatrix:  # fmt: skip
        """Symmetric part of the derivative of the residual.

        Stresses other than those of q give the mixed tangent of Newton's method. The law counts ``stiffer`` times, as that
        of a material with damping does over a step.
        """
        blocks = self.blocks()
        self.shell.add_tangent(q, v, case, blocks, stresses, stiffer)
        if stiffer != 1:
            blocks.values *= stiffer
        for term in self.terms[1:]:
            term.add_tangent(q, v, case, blocks)
        return blocks.matrix()

    def skew(self, q: np.ndarray, case: Case = FULL, v: np.ndarray | None = None) -> sp.csr_matrix | None:
        """Skew part of the derivative of the residual, which follower loads have at free edges; None if there is none."""
        blocks = SkewBlocks(self.pattern)
        for term in self.terms[1:]:
            term.add_tangent(q, v, case, blocks)
        return blocks.skew_matrix()

    def stiffness(self) -> BlockMatrix:
        """Tangent of the undeformed and unloaded state, without stresses of the shell.

        The computed strains of that state are rounding, 1e-16; as a prestress they would count against the bending of a
        plate of thickness t and side a with the factor (a / t)^2. Products with it are made of the strains of each element,
        see :mod:`skancf.system.unstressed`.
        """
        return self._stiffness

    @cached_property
    def _stiffness(self) -> BlockMatrix:
        return BlockMatrix(self.pattern, self._unstressed().values, ByStrains(self.shell, self.undeformed, self.foundation))

    def plain_stiffness(self) -> BlockMatrix:
        """The same with membrane strains as they are, not assumed ones: an upper bound that locks on coarse meshes."""
        return self._unstressed(plain=True)

    def _unstressed(self, plain: bool = False) -> BlockMatrix:
        blocks = self.blocks()
        self.shell.add_stiffness(blocks, plain)
        return blocks.matrix() if self.foundation is None else blocks.matrix() + self.foundation

    @cached_property
    def foundation(self) -> BlockMatrix | None:
        """Tangent of the structure's terms but for the shell in the undeformed state, that of springs; None without any."""
        return self.others_tangent(self.undeformed)

    def others_tangent(self, q: np.ndarray, case: Case = FULL) -> BlockMatrix | None:
        """Derivative of :meth:`others_force`, its symmetric part; None where it is zero."""
        blocks = self.blocks()
        for term in self.others:
            term.add_tangent(q, None, case, blocks)
        return None if blocks.is_zero else blocks.matrix()

    @cached_property
    def pretension(self) -> BlockMatrix:
        r"""Geometric stiffness G of a uniform dilation by one, a pretension that nothing but motion feels.

        Positive semidefinite, zero for translations; of a flat isotropic plate
        :math:`x \cdot G x = E h / (1 - \nu) \int |\nabla x|^2`. With a strain as its factor it counts against any
        membrane stiffness, whatever the unit, density and law.
        """
        return dilation.pretension(self)

    def external_force(self, q: np.ndarray, case: Case = FULL) -> np.ndarray:
        """Loads and the forces of held back free strains, (n_dofs,)."""
        applied, held = self.applied_force(q, case), self.shell.held_back_force(q, case)
        return applied if held is None else applied + held

    def applied_force(self, q: np.ndarray, case: Case = FULL, v: np.ndarray | None = None) -> np.ndarray:
        """Loads without those of temperature, which do no work on the body from outside: (n_dofs,)."""
        return self.loads.applied(q, v, case)

    def prescribed(self, case: Case = FULL) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,)."""
        return self.prescription.values(case)

    def histories(self) -> list[Any]:
        """The functions of time of terms and prescribed motions, and the paths of loads that move, each once."""
        every = chain(*[term.histories() for term in self.terms], self.prescription.histories())
        return list({id(history): history for history in every if history is not None}.values())

    def check_histories(self, begin: float, end: float) -> None:
        """InputError where a load or a prescribed motion has a table that does not cover the times of a run (s)."""
        for history in self.histories():
            check_cover(history, begin, end)

    def strain_energy(self, q: np.ndarray, case: Case = FULL) -> float:
        """Energy of the structure (J): of the shell, see :meth:`~skancf.terms.shell.Shell.energy`, springs and foundations,
        and of other terms that have one."""
        return self.shell.energy(q, case) + sum((term.energy(q, case) or 0.0 for term in self.others), 0.0)

    @cached_property
    def mass(self) -> BlockMatrix:
        """The constant mass matrix."""
        blocks = self.blocks()
        for term in self.terms:
            term.add_mass(blocks)
        return blocks.matrix()

    @cached_property
    def viscous(self) -> BlockMatrix | None:
        r"""Forces in proportion to velocities, :math:`\alpha M` and the dashpots (N s/m); None without any.

        The force on the body is -(viscous @ v); damping of the material is :attr:`retardation`.
        """
        damping = self.problem.damping
        of_mass = None if damping is None or not damping.mass else float(damping.mass) * self.mass
        blocks = self.blocks()
        for term in self.terms:
            term.add_viscous(blocks)
        return total([None if blocks.is_zero else blocks.matrix(), of_mass])

    @property
    def retardation(self) -> float:
        r"""Factor :math:`\beta` of the strain rate in the stress, :math:`C (\varepsilon + \beta \dot\varepsilon)` (s)."""
        return self.shell.retardation

    def net_force(self, q: np.ndarray, v: np.ndarray, case: Case) -> np.ndarray:
        """External less internal force and damping, (n_dofs,): what is left for inertia and supports."""
        force = self.external_force(q, case) - self.internal_force(q, v, case) - self.shell.retarding_force(q, v)
        return force if self.viscous is None else force - self.viscous @ v

    @cached_property
    def shares(self) -> np.ndarray:
        """What the mass makes of a unit translation at the vectors of the blocks, (n_blocks, 4) (kg); at positions their sum
        is the mass of everything."""
        ones = np.zeros_like(self.layout.undeformed)
        ones[self.layout.moving, 0, 0] = 1.0
        return np.asarray(self.layout.nodal(self.mass @ ones.ravel())[:, :, 0])

    @property
    def total_mass(self) -> float:
        """Mass of everything (kg)."""
        return float(self.shares[self.layout.moving, 0].sum())

    def kinetic_energy(self, v: np.ndarray) -> float:
        """Half of v . M v (J)."""
        return 0.5 * float(v @ (self.mass @ v))

    def momenta(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        r"""Linear momentum (N s) and angular momentum about the origin (N m s), (2, 3).

        What M v does on a translation and on a spin of everything: with the vectors :math:`q_i, (M v)_i` of all blocks,
        :math:`\sum_i (M v)_i` over positions, and :math:`\sum_i q_i \times (M v)_i` over all.
        """
        flow, nodal = self.layout.nodal(self.mass @ v), self.layout.nodal(q)
        return np.stack([self.layout.positions(flow).sum(axis=0), sum_of_cross(nodal, flow)])

    def reached(self, q: np.ndarray, v: np.ndarray, case: Case) -> None:
        """Tell terms that a step was accepted."""
        for term in self.terms:
            term.reached(q, v, case)

    def state(self) -> dict[str, Any]:
        """What terms remember between steps, by their numbers."""
        return {str(k): term.state() for k, term in enumerate(self.terms)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to what :meth:`state` gave."""
        for k, term in enumerate(self.terms):
            term.restore(state[str(k)])

    def free_rigid_motions(self) -> list[str]:
        """Rigid motions that no support and no spring holds, in words."""
        return rigid.free_rigid_motions(self)

    def largest_turn(self, change: np.ndarray) -> float:
        """Largest change of a slope, r_x or r_y of a node, relative to the slope's undeformed length."""
        return dilation.largest_turn(self.geometry, self.shell.nodal(change))

    # --- scikit-fem -------------------------------------------------------------------------------------------------

    def basis(self, intorder: int = 7, *, facets: Any = None, thickness: float | None = None) -> skfem.AbstractBasis:
        """A basis of scikit-fem on the mesh with this theory's element, for forms of one's own.

        ``system.basis().interpolate(system.to_mesh @ q)`` is the deformed surface in the state q: the position, its
        derivatives ``grad`` with respect to x and y, and in theory `kirchhoff` ``hess``.

        Parameters
        ----------
        intorder : int
            Order of the polynomials in x and in y that the quadrature integrates exactly; 7 is that of the library's own.
        facets
            A place on the boundary, such as ``"left"``: the basis is one of these edges.
        thickness : float, optional
            In theory `full`: the basis is one of the volume, of :math:`r + z d`, and ``grad`` has the derivative with
            respect to z, too.

        Raises
        ------
        InputError
            For an order that is no whole number, a place without an edge, and a thickness where there is no depth.
        """
        return skfem_bridge.basis_on(self.geometry, intorder, facets, thickness)

    @cached_property
    def to_mesh(self) -> sp.csr_matrix:
        r"""T, from the nodal coordinates to the degrees of freedom of :meth:`basis`, (12 n_mesh_nodes, n_dofs).

        The identity on open meshes without hanging nodes. A form's force f and stiffness K on the basis are
        :math:`T^T f` and :math:`T^T K T` here.
        """
        return skfem_bridge.unknowns_to_mesh(self.geometry, self.layout, self.shell.name)

    # ----------------------------------------------------------------------------------------------------------------

    def folded(self, q: np.ndarray) -> tuple[int, np.ndarray] | None:
        """The first element that folded, and its undeformed place; None without one: see :mod:`skancf.layout.folds`."""
        return dilation.first_fold(self.geometry, self.shell.nodal(q))
