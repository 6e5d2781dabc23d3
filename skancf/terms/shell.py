"""The plate or shell as a term: strain energy, inertia and free strains of one part of a layout."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.history import FULL, Case
from skancf.kernels import gather
from skancf.kernels.constants import VECTORS
from skancf.layout.folds import first_fold, largest_turn
from skancf.layout.layout import Layout
from skancf.terms.blocks import Blocks, OnElements
from skancf.terms.protocols import Assembly
from skancf.terms.term import Term


class Shell(Term):
    """A theory on a mesh, at its place in a layout.

    Parameters
    ----------
    assembly : Assembly
    layout : Layout
    name : str
        Of its part.
    heats : sequence
        Temperature changes, loads with ``initial_stresses`` and ``temperature``.
    retardation : float
        Factor of the strain rate in the stress (s).

    Attributes
    ----------
    nodal, flat : callable
        Its vectors (n_nodes, 4, 3) of all unknowns (n_dofs,), and such forces of those on its nodes.
    """

    def __init__(
        self, assembly: Assembly, layout: Layout, name: str = "plate", heats: Sequence[Any] = (), retardation: float = 0.0
    ):  # fmt: skip
        self.assembly, self.layout, self.name, self.heats = assembly, layout, name, tuple(heats)
        self.geometry, self.retardation = assembly.geometry, retardation
        self.cells = self.geometry.nodes + layout.part(name).start
        self.nodal, self.flat = partial(layout.nodal, name=name), partial(layout.flat, name=name)

    at_points = False
    """Whether the law is one of points, which is not linear, see :mod:`skancf.terms.shell_at_points`."""

    @property
    def heated(self) -> bool:
        """Whether heat is inside the law, so that forces are not linear in it."""
        return False

    def at(self, case: Case) -> Assembly:
        """The assembly with the temperature of a case, where it is inside the law."""
        return self.assembly

    def on_elements(self, blocks: Any) -> OnElements:
        """Where matrices of its elements are added."""
        return OnElements(blocks, self.cells, self.geometry, self.assembly.schedule)

    def position_rows(self, elements: np.ndarray, local: np.ndarray) -> sp.csr_matrix:
        """Weights (n, 4 n_blocks) of all vectors of the layout that make mid-surface positions at local points (n, 2) of
        elements (n,)."""
        return self.in_layout(self.geometry.position_rows(elements, local))

    def in_layout(self, rows: sp.csr_matrix) -> sp.csr_matrix:
        """Weights (n, 4 n_blocks) of all vectors of the layout, of those (n, 4 n_nodes) of its own."""
        columns = rows.indices + VECTORS * self.layout.part(self.name).start
        return sp.csr_matrix((rows.data, columns, rows.indptr), shape=(rows.shape[0], VECTORS * self.layout.n_blocks))

    def couples(self) -> np.ndarray:
        return self.cells

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        force, initial = self.internal_force(q, case), self.initial_stress_force(q, case)
        return force if initial is None else force - initial

    def internal_force(self, q: np.ndarray, case: Case = FULL) -> np.ndarray:
        """Derivative of the strain energy without free strains, (n_dofs,); with those that are inside a law."""
        return self.flat(self.at(case).internal_force(self.nodal(q)))

    def stresses(self, q: np.ndarray, change: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """Stresses (n_elements, n_strains, n_points) with the weights, extrapolated linearly along ``change``.

        Those of free strains are not subtracted, but for those inside a law.
        """
        change = None if change is None else self.nodal(change)
        return self.at(case).stresses(self.nodal(q), change, keep_strains=False)[1]

    def stresses_with_rate(self, q: np.ndarray, change: np.ndarray | None, rate: np.ndarray, case: Case) -> np.ndarray:
        r"""The same with those of damping, :math:`C \beta \dot\varepsilon`, of rates (n_dofs,)."""
        viscous = self.retardation * rate
        return self.stresses(q, viscous if change is None else change + viscous, case)

    def load_rate(self, q: np.ndarray, load_factor: float) -> np.ndarray | None:
        """Derivative by the load factor of forces that are not linear in it, (n_dofs,); None without any."""
        return None

    def small_stresses(self, q: np.ndarray) -> np.ndarray:
        """Those by the law of small strain."""
        return self.assembly.small_stresses(self.nodal(q))

    def exact_work(self, q0: np.ndarray, q1: np.ndarray, start: Case = FULL, end: Case = FULL) -> np.ndarray | None:
        """Stresses on top of the mean of those of two states, that make it do the work of the energy; None where it does."""
        return self.assembly.exact_work(self.nodal(q0), self.nodal(q1))

    def force_of(self, q: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces (n_dofs,) that do the work of given stresses."""
        return self.flat(self.assembly.force_of(self.nodal(q), stresses))

    def force_between(self, q0: np.ndarray, q1: np.ndarray, stresses: np.ndarray) -> np.ndarray:
        """Forces (n_dofs,) of given stresses between two states, see :meth:`skancf.system.System.force_between`."""
        return self.flat(self.assembly.force_between(self.nodal(q0), self.nodal(q1), stresses))

    def add_tangent(
        self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any, stresses: np.ndarray | None = None,
        stiffer: float = 1.0,
    ) -> None:  # fmt: skip
        """The tangent with given stresses, or those of q; the law counts ``stiffer`` times."""
        if blocks.skew:
            return
        stresses = self.stresses(q, None, case) if stresses is None else stresses
        initial = self.initial_stresses(case)
        stresses = stresses if initial is None else stresses - initial
        stresses = stresses if stiffer == 1 else stresses / stiffer
        self.assembly.tangent(self.nodal(q), stresses, blocks.slots_of(self.cells), blocks.values)
        if stiffer != 1:
            blocks.values *= stiffer

    def add_stiffness(self, blocks: Blocks, plain: bool = False) -> None:
        """The tangent of the undeformed state without stresses; ``plain``: with membrane strains as they are."""
        nodal = self.nodal(self.layout.undeformed.ravel())
        none = np.zeros((self.geometry.n_elements, *self.assembly.sections.reference.shape[1:]))
        self.assembly.tangent(nodal, none, blocks.slots_of(self.cells), blocks.values, plain)

    def energy(self, q: np.ndarray, case: Case = FULL) -> float:
        r"""Half of stress times elastic strain, integrated (J).

        .. math:: \tfrac12 \int (\varepsilon - \lambda \varepsilon_T) \cdot C (\varepsilon - \lambda \varepsilon_T)

        with the free strain of the temperature change of a case, and its factor.
        """
        initial = self.initial_stresses(case)
        thermal = 0.0 if initial is None else self.thermal_energy(case)
        return self.assembly.strain_energy(self.nodal(q), initial, thermal)

    def add_mass(self, blocks: Blocks) -> None:
        """The constant mass matrix; in theory `full` with the rotary part of r_z."""
        self.add_gathered(self.assembly.sections.shape, self.assembly.mass_shapes, blocks)

    def add_gathered(self, shape: np.ndarray, shapes: np.ndarray, blocks: Blocks) -> None:
        """The mass matrix of elements whose local vectors have the matrices ``shapes[shape]``, (n_elements, 16, 16)."""
        self.on_elements(blocks).run(gather.mass, shape, shapes, self.geometry.maps)

    def initial_stresses(self, case: Case, small: bool = False) -> np.ndarray | None:
        """Initial stresses, those that would hold free strains back, as :meth:`stresses` has them; None without any.

        Of free strains inside a law only in answers to first order, ``small``.
        """
        return total(heat.initial_stresses(case) for heat in self.heats)

    def initial_stress_force(self, q: np.ndarray, case: Case, small: bool = False) -> np.ndarray | None:
        """Forces of the initial stresses, (n_dofs,); None without any."""
        initial = self.initial_stresses(case, small)
        return None if initial is None else self.force_of(q, initial)

    def temperature(self, points: np.ndarray, case: Case, elements: np.ndarray | None = None) -> np.ndarray | None:
        """Temperature change T0 and T1 at local points (2, n) of every element, or of some, (2, m, n); None without one."""
        everywhere = total(heat.temperature(points, case) for heat in self.heats)
        return everywhere if everywhere is None or elements is None else everywhere[:, elements]

    def thermal_energy(self, case: Case = FULL) -> float:
        """Strain energy of the undeformed state under the temperature change of a case (J), the largest it can cause."""
        if not self.heats:
            return 0.0
        at_full = Case(time=case.time)
        return case.factor**2 * self.assembly.thermal_energy(lambda points: np.asarray(self.temperature(points, at_full)))

    def section_forces(
        self, q: np.ndarray, points: np.ndarray, case: Case = FULL, small: bool = False, elements: np.ndarray | None = None
    ) -> np.ndarray:
        """N and M in the local frame at local points (2, n) of every element, or of some, (m, 6, n), see
        :meth:`skancf.terms.protocols.Assembly.section_forces`."""
        heat = self.temperature(points, case, elements)
        return self.assembly.section_forces(self.nodal(q), points, heat, small=small, elements=elements)

    def largest_turn(self, change: np.ndarray) -> float:
        """Largest change of a slope, r_x or r_y of a node, relative to the slope's undeformed length."""
        return largest_turn(self.geometry, self.nodal(change))

    def folded(self, q: np.ndarray) -> tuple[int, np.ndarray] | None:
        """The first element that folded, and its undeformed place; None without one: see :mod:`skancf.layout.folds`."""
        return first_fold(self.geometry, self.nodal(q))

    def retarding_force(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        r"""Internal force of the strain rate, of the stresses :math:`C \beta \dot\varepsilon`, (n_dofs,)."""
        if not self.retardation:
            return np.zeros(self.layout.n_dofs)
        return self.force_of(q, self.stresses(q, self.retardation * v) - self.stresses(q))


def total(parts: Any) -> Any:
    """Sum of the parts that are there; None if none is."""
    found = [part for part in parts if part is not None]
    return sum(found[1:], found[0]) if found else None


def is_heated(system: Any) -> bool:
    """Whether heat is inside the law of a system, so that forces are not linear in the load factor."""
    return bool(getattr(getattr(system, "shell", None), "heated", False))
