"""A problem on a mesh with a theory: what solvers know."""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem

from skancf.errors import InputError
from skancf.history import check_cover
from skancf.kernels import gather
from skancf.kernels.schedule import Schedule
from skancf.layout import skfem_bridge
from skancf.layout.constrain import free_rigid_motions
from skancf.layout.folds import first_fold
from skancf.layout.geometry import Geometry
from skancf.linear import BlockMatrix, BlockPattern, Constraints, DirectSolver
from skancf.materials import Section
from skancf.system import dilation
from skancf.system.unstressed import ByStrains, derivative
from skancf.terms.protocols import Assembly, Loading, Prescription
from skancf.terms.shells.full import FullAssembly
from skancf.terms.shells.kirchhoff import ThinAssembly
from skancf.vectors import sum_of_cross

ASSEMBLIES: dict[str, type] = {"full": FullAssembly, "kirchhoff": ThinAssembly}


class System:
    """Residual, tangent and mass of a problem on a mesh.

    Nodal coordinates are one vector q of 12 per node: r, r_x, r_y and r_z (`full`) or r_xy (`kirchhoff`), three components
    each.

    Attributes
    ----------
    assembly : Assembly
    geometry : Geometry
    undeformed : (n_dofs,) array
    constraints : Constraints
    choice
        With ``theory="auto"``: which theory was taken, the modelling error of the thin one, and why.
    """

    choice: Any = None

    def __init__(
        self,
        assembly: Assembly,
        constraints: Constraints,
        prescription: Prescription,
        loads: Sequence[Loading],
        elastic: Sequence[tuple[np.ndarray, np.ndarray]],
        dashpots: Sequence[tuple[np.ndarray, np.ndarray]],
        problem: Any,
    ):
        self.assembly, self.geometry = assembly, assembly.geometry
        self.constraints, self.prescription, self.loads, self.problem = constraints, prescription, loads, problem
        geometry = self.geometry
        self.undeformed = geometry.undeformed.ravel()
        self.pattern = BlockPattern.from_cells(geometry.nodes.T, geometry.n_nodes, 12, geometry.undeformed[:, 0].T)
        self._slots = self.pattern.slots(geometry.nodes.T)
        self.foundation = self._gathered(elastic) if elastic else None
        self._dashpots = dashpots

    @property
    def n_dofs(self) -> int:
        """Nodal coordinates, prescribed ones included."""
        return self.undeformed.size

    @property
    def mesh(self) -> Any:
        """The mesh in the parameter plane."""
        return self.geometry.mesh

    def free_rigid_motions(self) -> list[str]:
        """Rigid motions that no support and no spring holds, in words."""
        return free_rigid_motions(self.geometry, self.constraints, self.foundation)

    def internal_force(self, q: np.ndarray) -> np.ndarray:
        """Derivative of the strain energy, springs and foundations included, (n_dofs,)."""
        return self._with_springs(self.assembly.internal_force(self._nodal(q)), q)

    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """:meth:`internal_force` with given stresses, those of :meth:`stresses`: (n_dofs,)."""
        return self._with_springs(self.assembly.force_of(self._nodal(q), stresses), q)

    def force_between(self, q0: np.ndarray, q1: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """The force f of given stresses, and of springs, between two states, (n_dofs,).

        With the mean of the stresses of both, f . (q1 - q0) is the change of the strain energy, to rounding, and f has no
        moment about the middle of the two: see :func:`skancf.theories.kirchhoff.point.discrete_gradient`.
        """
        force = self.assembly.force_between(self._nodal(q0), self._nodal(q1), stresses)
        return self._with_springs(force, 0.5 * (q0 + q1))

    def _with_springs(self, force: np.ndarray, q: np.ndarray) -> np.ndarray:
        return force.ravel() if self.foundation is None else force.ravel() + self.foundation @ (q - self.undeformed)

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray:
        """Stresses at the integration points with their weights, extrapolated linearly along ``change``.

        Shape (n_elements, n_strains, n_points). Those of a temperature change are not subtracted.
        """
        change = None if change is None else self._nodal(change)
        return self.assembly.stresses(self._nodal(q), change, keep_strains=False)[1]

    def tangent(
        self, q: np.ndarray, stresses: np.ndarray | None = None, time: float | None = None, factor: float = 1.0,
        stiffer: float = 1.0,
    ) -> BlockMatrix:  # fmt: skip
        """Symmetric part of the derivative of the residual.

        Stresses other than those of q give the mixed tangent of Newton's method. The law counts ``stiffer`` times, as that
        of a material with damping does over a step.
        """
        if stresses is None:
            stresses = self.stresses(q)
        held = self.held_back(time)
        stresses = stresses if held is None else stresses - factor * held
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        self.assembly.tangent(self._nodal(q), stresses if stiffer == 1 else stresses / stiffer, self._slots, out)
        if stiffer != 1:
            out *= stiffer
        nodal = q.reshape(-1, 4, 3)
        for load in self.loads:
            load.add_stiffness(nodal, time, factor, self._slots, out)
        if self.foundation is not None:
            out += self.foundation.values
        return BlockMatrix(self.pattern, out)

    def stiffness(self) -> BlockMatrix:
        """Tangent of the undeformed and unloaded state, without stresses.

        The computed strains of that state are rounding, 1e-16; as a prestress they would count against the bending of a
        plate of thickness t and side a with the factor (a / t)^2. Products with it are made of the strains of each element,
        see :mod:`skancf.system.unstressed`.
        """
        return self._stiffness

    @cached_property
    def _stiffness(self) -> BlockMatrix:
        by_strains = ByStrains(self.assembly, self.geometry.undeformed, self.foundation)
        return BlockMatrix(self.pattern, self._unstressed().values, by_strains)

    def plain_stiffness(self) -> BlockMatrix:
        """The same with membrane strains as they are, not assumed ones: an upper bound that locks on coarse meshes."""
        return self._unstressed(plain=True)

    @cached_property
    def pretension(self) -> BlockMatrix:
        r"""Geometric stiffness G of a uniform dilation by one, a pretension that nothing but motion feels.

        Positive semidefinite, zero for translations; of a flat isotropic plate
        :math:`x \cdot G x = E h / (1 - \nu) \int |\nabla x|^2`. With a strain as its factor it counts against any
        membrane stiffness, whatever the unit, density and law.
        """
        return dilation.pretension(self)

    def largest_turn(self, change: np.ndarray) -> float:
        """Largest change of a slope, r_x or r_y of a node, relative to the slope's undeformed length."""
        return dilation.largest_turn(self.geometry, self._nodal(change))

    def _unstressed(self, plain: bool = False) -> BlockMatrix:
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        none = np.zeros_like(self.stresses(self.undeformed))
        self.assembly.tangent(self.geometry.undeformed, none, self._slots, out, plain)
        return BlockMatrix(self.pattern, out if self.foundation is None else out + self.foundation.values)

    def skew(self, q: np.ndarray, time: float | None = None, factor: float = 1.0) -> sp.csr_matrix | None:
        """Skew part of the derivative of the residual, which follower loads have at free edges; None if there is none."""
        found = [part for part in (load.skew(q.reshape(-1, 4, 3), time) for load in self.loads) if part is not None]
        sum_of_parts = total(self._sparse(*part) for part in found)
        return factor * sum_of_parts if sum_of_parts is not None and sum_of_parts.nnz else None

    def external_force(self, q: np.ndarray, time: float | None = None) -> np.ndarray:
        """Loads at a time and the forces of held back free strains, (n_dofs,); without a time at their full amplitude."""
        applied, held = self.applied_force(q, time), self.held_back_force(q, time)
        return applied if held is None else applied + held

    def held_back_force(self, q: np.ndarray, time: float | None = None) -> np.ndarray | None:
        """Forces of held back free strains at a time, (n_dofs,); None without any."""
        held = self.held_back(time)
        return None if held is None else self.assembly.force_of(self._nodal(q), held).ravel()

    def applied_force(self, q: np.ndarray, time: float | None = None) -> np.ndarray:
        """Loads at a time without those of temperature, which do no work on the body from outside: (n_dofs,)."""
        nodal = self._nodal(q)
        return sum((load.force(nodal, time) for load in self.loads), np.zeros_like(nodal)).ravel()

    def load_places(self, time: float | None = None) -> np.ndarray:
        """Points (2, n) of the parameter plane where loads at points and along lines act at a time, moving ones too."""
        return np.hstack([np.empty((2, 0)), *[load.places(time) for load in self.loads]])

    def impulses(self) -> list[tuple[float, np.ndarray]]:
        """Times, ascending, and the impulses (n_dofs,) that act then, those of equal times together (N s)."""
        out: dict[float, np.ndarray] = {}
        for time, nodal in filter(None, (load.impulse(self.geometry.undeformed) for load in self.loads)):
            out[time] = out.get(time, 0.0) + nodal.ravel()
        return sorted(out.items(), key=lambda item: item[0])

    def held_back(self, time: float | None) -> np.ndarray | None:
        """Stresses of held back free strains at a time, as :meth:`stresses` has them; None without any."""
        return total(load.initial_stresses(time) for load in self.loads)

    def temperature(self, points: np.ndarray, time: float | None = None) -> np.ndarray | None:
        """Temperature change T0 and T1 at local points (2, n) of every element, (2, n_elements, n); None without one."""
        return total(load.temperature(points, time) for load in self.loads)

    def couple(self, time: float | None = None) -> np.ndarray | None:
        """Dead forces per area times the height above the surface where they act, (3,) (N/m); None where they act on it."""
        return total(load.couple(time) for load in self.loads)

    @cached_property
    def weight(self) -> np.ndarray:
        """Nodal forces of constant gravity, (n_dofs,): its potential energy (J) is -weight @ (q - undeformed).

        Without gravity, with a function of time, and on a section whose centre of mass is off the thin surface, where the
        force turns with the normals, it is zero.
        """
        found = total(load.weight() for load in self.loads)
        return np.zeros(self.n_dofs) if found is None else found.ravel()

    def section_forces(
        self, q: np.ndarray, points: np.ndarray, factor: float = 1.0, time: float | None = None
    ) -> np.ndarray:
        """N and M in the local frame at local points (2, n) of every element, (n_elements, 6, n); the temperature change
        counts with ``factor``."""
        heat = self.temperature(points, time)
        return self.assembly.section_forces(self._nodal(q), points, None if heat is None else factor * heat)

    def prescribed(self, time: float | None = None) -> np.ndarray:
        """Change of the prescribed coordinates from the undeformed state, (n_dofs,)."""
        return self.prescription.values(time)

    def histories(self) -> list[Any]:
        """The functions of time of loads and prescribed motions, and the paths of loads that move, each once."""
        every = chain.from_iterable([*[load.histories() for load in self.loads], self.prescription.histories()])
        return list({id(history): history for history in every if history is not None}.values())

    def check_histories(self, begin: float, end: float) -> None:
        """InputError where a load or a prescribed motion has a table that does not cover the times of a run (s)."""
        for history in self.histories():
            check_cover(history, begin, end)

    def knots(self) -> list[float]:
        """Times, ascending, at which the functions of time of loads and prescribed motions begin, end or bend (s)."""
        return sorted({float(t) for history in self.histories() for t in getattr(history, "knots", ())})

    def strain_energy(self, q: np.ndarray, factor: float = 1.0, time: float | None = None) -> float:
        r"""Half of stress times elastic strain, integrated, and the energy of springs and foundations (J).

        .. math:: \tfrac12 \int (\varepsilon - \lambda \varepsilon_T) \cdot C (\varepsilon - \lambda \varepsilon_T)

        with the free strain of the temperature change at a time, and its ``factor``.
        """
        strains, stresses = self.assembly.stresses(self._nodal(q), None, keep_strains=True)
        energy, held = 0.5 * float(np.vdot(strains, stresses)), self.held_back(time)
        if held is not None:
            energy += factor**2 * self.thermal_energy(time) - factor * float(np.vdot(held, strains))
        if self.foundation is not None:
            change = q - self.undeformed
            energy += 0.5 * float(change @ (self.foundation @ change))
        return energy

    def linear_energy(self, change: np.ndarray, factor: float = 1.0, time: float | None = None) -> float:
        """:meth:`strain_energy` of a small change (n_dofs,) from the undeformed state."""
        energy, force = self.stiffness().energy(change), self.held_back_force(self.undeformed, time)
        if force is None:
            return energy
        return energy + factor**2 * self.thermal_energy(time) - factor * float(force @ change)

    def thermal_energy(self, time: float | None = None) -> float:
        """Strain energy of the undeformed state under the temperature change at a time (J), the largest it can cause."""
        heat = self.temperature(self.geometry.theory.quadrature[0], time)
        return 0.0 if heat is None else self.assembly.thermal_energy(*heat)

    def linearised(self, quantity: Callable[[np.ndarray], np.ndarray], change: np.ndarray) -> np.ndarray:
        """A quantity of the nodal coordinates to first order in a change from the undeformed state, see :meth:`rate`."""
        return np.asarray(quantity(self.undeformed) + self.rate(quantity, change))

    def rate(self, quantity: Callable[[np.ndarray], np.ndarray], change: np.ndarray) -> np.ndarray:
        """The derivative of a quantity of the nodal coordinates along a change from the undeformed state, by
        :func:`skancf.system.unstressed.derivative`: the quantity must be one of complex coordinates too."""
        return derivative(quantity, self.undeformed, change)

    def linear_change(self, backend: str = "auto") -> np.ndarray:
        """Small-deflection answer, (n_dofs,): one solve with the tangent of the undeformed state."""
        start, matrix = self.undeformed, self.stiffness()
        with DirectSolver(self.pattern, self.constraints, backend) as solver:
            solver.factor(matrix)
            moved = self.prescribed()
            answer = solver.solve(self.external_force(start) - matrix @ moved) + moved
            solver.warn_if_lost()
            return answer

    @cached_property
    def mass(self) -> BlockMatrix:
        """The constant mass matrix; in theory `full` with the rotary part of r_z."""
        return self.gathered_mass(self.assembly.sections.shape, self.assembly.mass_shapes)

    @cached_property
    def viscous(self) -> BlockMatrix | None:
        r"""Forces in proportion to velocities, :math:`\alpha M` and the dashpots (N s/m); None without any.

        The force on the body is -(viscous @ v); damping of the material is :attr:`retardation`.
        """
        damping = self.problem.damping
        parts = [self._gathered(self._dashpots)] if self._dashpots else []
        if damping is not None and damping.mass:
            parts.append(float(damping.mass) * self.mass)
        return sum(parts[1:], parts[0]) if parts else None

    @property
    def retardation(self) -> float:
        r"""Factor :math:`\beta` of the strain rate in the stress, :math:`C (\varepsilon + \beta \dot\varepsilon)` (s)."""
        return 0.0 if self.problem.damping is None else float(self.problem.damping.stiffness)

    def retarding_force(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        r"""Internal force of the strain rate, of the stresses :math:`C \beta \dot\varepsilon`, (n_dofs,)."""
        if not self.retardation:
            return np.zeros(self.n_dofs)
        stresses = self.stresses(q, self.retardation * v) - self.stresses(q)
        return self.assembly.force_of(self._nodal(q), stresses).ravel()

    def net_force(self, q: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
        """External less internal force and damping at a time, (n_dofs,): what is left for inertia and supports."""
        force = self.external_force(q, time) - self.internal_force(q) - self.retarding_force(q, v)
        return force if self.viscous is None else force - self.viscous @ v

    @cached_property
    def shares(self) -> np.ndarray:
        """What the mass makes of a unit translation at the vectors of the nodes, (n_nodes, 4) (kg); at positions their sum
        is the mass of the body."""
        ones = np.zeros((self.n_dofs // 12, 4, 3))
        ones[:, 0, 0] = 1.0
        return np.asarray((self.mass @ ones.ravel()).reshape(-1, 4, 3)[:, :, 0])

    def kinetic_energy(self, v: np.ndarray) -> float:
        """Half of v . M v (J)."""
        return 0.5 * float(v @ (self.mass @ v))

    def momenta(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        r"""Linear momentum (N s) and angular momentum about the origin (N m s), (2, 3).

        What M v does on a translation and on a spin of the whole body: with the vectors :math:`q_i, (M v)_i` of all nodes,
        :math:`\sum_i (M v)_i` over positions, and :math:`\sum_i q_i \times (M v)_i` over positions and slopes.
        """
        of_vectors, nodal = (self.mass @ v).reshape(-1, 4, 3), self._nodal(q)
        return np.stack([of_vectors[:, 0].sum(axis=0), sum_of_cross(nodal, of_vectors)])

    def gathered_mass(self, shape: np.ndarray, shapes: np.ndarray) -> BlockMatrix:
        """The mass matrix of elements whose local vectors have the matrices ``shapes[shape]``, (n_elements, 16, 16)."""
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        self.assembly.schedule.run(gather.mass, shape, shapes, self.geometry.maps, self._slots, out)
        return BlockMatrix(self.pattern, out)

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
        return skfem_bridge.unknowns_to_mesh(self.geometry)

    # ----------------------------------------------------------------------------------------------------------------

    def folded(self, q: np.ndarray) -> tuple[int, np.ndarray] | None:
        """The first element that folded, and its undeformed place; None without one: see :mod:`skancf.layout.folds`."""
        return first_fold(self.geometry, self._nodal(q))

    def _gathered(self, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> BlockMatrix:
        out = np.zeros((self.pattern.n_blocks, 12, 12))
        for elements, matrices in parts:
            self._add(elements, matrices, out)
        return BlockMatrix(self.pattern, out)

    def _add(self, elements: np.ndarray, matrices: np.ndarray, out: np.ndarray) -> None:
        gather.add_local(np.asarray(elements, np.int32), matrices, self.geometry.maps, self._slots, out)

    def _sparse(self, elements: np.ndarray, matrices: np.ndarray) -> sp.csr_matrix:
        """Matrices (m, 48, 48) of local vectors, component by component, in nodal coordinates."""
        m, geometry = len(elements), self.geometry
        maps = np.stack([geometry.dense_map(e) for e in elements])
        split = matrices.reshape(m, 3, 16, 3, 16)
        blocks = maps.swapaxes(1, 2)[:, None, None] @ split.transpose(0, 1, 3, 2, 4) @ maps[:, None, None]
        blocks = blocks.transpose(0, 3, 1, 4, 2).reshape(m, 48, 48)
        places = (12 * geometry.nodes[elements][:, :, None].astype(int) + np.arange(12)).reshape(m, 48)
        rows, columns = np.repeat(places, 48, axis=1).ravel(), np.tile(places, (1, 48)).ravel()
        return sp.coo_matrix((blocks.ravel(), (rows, columns)), shape=self.pattern.shape).tocsr()

    def _nodal(self, q: np.ndarray) -> np.ndarray:
        if np.size(q) != self.n_dofs:
            raise InputError(f"a vector of {np.size(q)} nodal coordinates; this system has {self.n_dofs}, 12 per node")
        return np.ascontiguousarray(q, dtype=complex if np.iscomplexobj(q) else float).reshape(-1, 4, 3)


def total(parts: Iterable[Any]) -> Any:
    """Sum of the parts that are there; None if none is."""
    found = [part for part in parts if part is not None]
    return sum(found[1:], found[0]) if found else None


def assemble(geometry: Geometry, section: Section) -> Assembly:
    """The assembly of the geometry's theory."""
    schedule = Schedule(geometry.nodes, geometry.mesh.p[:, geometry.mesh.t].mean(axis=1))
    made: Assembly = ASSEMBLIES[geometry.theory.name](geometry, section, schedule)
    return made
