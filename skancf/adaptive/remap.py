r"""States in motion on another mesh of the same tree: what is carried over, and what is put right afterwards.

Positions and velocities are interpolated; of what that loses on coarser elements, velocities keep the projection in the mass
norm. Then three things are put right. Equal positions have another strain energy on another mesh, because membrane strains
are assumed element by element: much more, where a thin plate bends far. One step by the elastic tangent,

.. math:: (K + \sigma M)\, \delta q = f_{ext} - f_{int}(q) - M a,

leads towards the internal forces that belong to the accelerations a there were, so that these do not jump. The smallest
correction of the velocity gives back both momenta; and where the energy rose, what deforms becomes slower.
"""

import logging
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType

import numpy as np

from skancf.adaptive.interpolation import Interpolation, is_finer, require_one_tree
from skancf.adaptive.momenta import Momenta
from skancf.adaptive.on_conditions import Mass, closed, floats, kept
from skancf.arguments import SYSTEM, flag, instance
from skancf.dynamics.prescribed import RATE_STEP, prescribed_rate
from skancf.equality import by_value
from skancf.errors import SingularMatrix, vector
from skancf.linear import DirectSolver, check_backend
from skancf.showing import short
from skancf.solution import Solution
from skancf.solving import End, Status, iterate
from skancf.states import StateLike, solution_of
from skancf.statics.conditioned import factored_about, solved
from skancf.statics.stopping import work
from skancf.system.linearised import Exact
from skancf.system.system import System
from skancf.tolerances import ROUNDED_PRODUCT

logger = logging.getLogger(__name__)

STEPS, ENOUGH = 3, 1e-2
"""Steps towards the internal forces, at most, and the excess of strain energy over the energy where they end."""


@by_value
@dataclass(frozen=True)
class RemapChange:
    """What a change of mesh did to a state.

    Attributes
    ----------
    strain_energy, kinetic_energy : (2,) array
        Before and after (J). The energy of loads is not counted.
    momenta : (2, 2, 3) array
        Before and after: linear (N s), and angular about the origin (N m s).
    factor : float
        By which the deforming part of the velocity was multiplied.
    raised : float
        What the energy rose (J). After settling only where stopping all that deforms was not enough: then rather keep the
        finer mesh.
    moved : float
        How far the centre of mass moved (m).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> tree = sk.meshes.quadtree(system.mesh, strip.surface)
    >>> change = sk.remap(sk.solve_linear(strip.on(tree, "kirchhoff")), strip.on(tree.refined(), "kirchhoff")).change
    >>> print(change.strain_energy.shape)
    (2,)
    """

    strain_energy: np.ndarray
    kinetic_energy: np.ndarray
    momenta: np.ndarray
    factor: float
    raised: float
    moved: float

    __repr__ = short

    @property
    def energy(self) -> float:
        """Change of the sum of both energies (J)."""
        return float(np.diff(self.strain_energy + self.kinetic_energy)[0])

    @property
    def momentum(self) -> np.ndarray:
        """Sizes of the changes of both momenta, (2,)."""
        return np.asarray(np.linalg.norm(self.momenta[1] - self.momenta[0], axis=1))


@by_value
@dataclass(frozen=True)
class Remapped:
    """Nodal coordinates on the new mesh, their rates and accelerations (None where none were given), and the change.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> tree = sk.meshes.quadtree(system.mesh, strip.surface)
    >>> found = sk.remap(sk.solve_linear(strip.on(tree, "kirchhoff")), strip.on(tree.refined(), "kirchhoff"))
    >>> print(found.v is None, found.change.strain_energy.shape)
    True (2,)
    """

    q: np.ndarray
    v: np.ndarray | None
    a: np.ndarray | None
    change: RemapChange

    __repr__ = short


def remap(
    state: StateLike,
    system: System,
    acceleration: np.ndarray | None = None,
    *,
    settle: bool = True,
    backend: str = "auto",
) -> Remapped:
    """A state in motion on another mesh of the same quadtree, with the same theory.

    Parameters
    ----------
    state : Solution, or a result that stands for one
        At the time of the change. Without a velocity only positions are carried over.
    system : System
        The same problem on the other mesh.
    acceleration : (n_dofs,) array, optional
        Carried over as the velocity is, without its corrections: linearly.
    settle : bool
        Settle the internal forces, and let the energy not rise. Without it positions and velocities are the same functions
        on a finer mesh, in theory `kirchhoff`, and their strain energy is what it then is.

    Raises
    ------
    InputError
        For meshes that do not grow from one coarse mesh, and for another theory.

    Notes
    -----
    A body without supports and springs keeps its centre of mass, and any body its momenta, as far as its supports let it; on
    curved surfaces on finer meshes too, whose areas are others.

    Supports hold what they prescribe. Rates are those of the prescription, plus what those of the old nodes differed from
    it: the velocities of an integrator are not quite that rate, and go on as they were.

    Conditions are met on the new mesh, whose rows may be others: positions and velocities are the nearest in the mass norm
    that meet them.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> tree = sk.meshes.quadtree(system.mesh, strip.surface)
    >>> state = sk.solve_linear(strip.on(tree, "kirchhoff"))
    >>> found = sk.remap(state, strip.on(tree.refined(), "kirchhoff"))
    >>> print(found.q.shape, found.v is None)
    (324,) True
    """
    state = solution_of("state", state)
    instance("system", system, System, SYSTEM)
    check_backend(backend)
    flag("settle", settle)
    if acceleration is not None:
        acceleration = vector("acceleration", acceleration, state.system.n_dofs)
    require_one_tree(state.system.geometry, system.geometry)
    with _Passage(state, system, backend) as passage:
        q = passage.settled() if settle else passage.start
        a = None if acceleration is None else passage.rates(acceleration)
        factor, v = 1.0, None
        if state.velocity is not None:
            mass = passage.mass_at(q)
            now = Momenta(system, q, mass.solve)
            before = now.rigid(state.system.layout, state.q) @ (state.system.mass @ state.velocity)
            v = now.corrected(kept(mass, q, passage.velocity(), state.time), before)
            if settle:
                v, factor = now.slowed(v, passage.energy - passage.strain_energy(system, q))
        return Remapped(q, v, a, passage.change(q, v, factor))


class _Passage:
    """From one mesh to another; a context manager, which gives the memory of factors back.

    Attributes
    ----------
    start : (n_new_dofs,) array
        Interpolated positions.
    energy : float
        Of the state (J).
    """

    def __init__(self, state: Solution, system: System, backend: str):
        self.state, self.old, self.new, self.backend = state, state.system, system, backend
        self.there = Interpolation.of(self.old, system)
        finer = is_finer(system.mesh.leaves, self.old.mesh.leaves)
        self.back = None if finer else Interpolation.of(system, self.old)
        wanted = system.undeformed + system.prescribed(state.case)
        at_nodes = self.there.positions(state.q)
        self._taken = at_nodes + system.constraints.fixed_part(wanted - at_nodes)
        self._lost = None if self.back is None else self._significant(state.q - self.back.positions(self._taken), state.q)
        self.start = closed(system, self._centred(), state.case, backend)
        self.old_mass, self.new_mass = Mass(self.old, state.q, backend), Mass(system, self.start, backend)
        self._masses = [self.old_mass, self.new_mass]
        self._strain = self.strain_energy(self.old, state.q)
        self.energy = self._strain + state.kinetic_energy

    def __enter__(self) -> "_Passage":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for mass in self._masses:
            mass.close()

    def mass_at(self, q: np.ndarray) -> Mass:
        """That of the new mesh at q, where its conditions are."""
        if not self.new.conditions:
            return self.new_mass
        self._masses.append(Mass(self.new, q, self.backend))
        return self._masses[-1]

    @staticmethod
    def _significant(lost: np.ndarray, whole: np.ndarray) -> np.ndarray:
        """What was lost, or exactly nothing."""
        return lost if np.abs(lost).max() > ROUNDED_PRODUCT * np.abs(whole).max() else np.zeros_like(lost)

    def _centred(self) -> np.ndarray:
        """The positions of the nodes, of a free body with the centre of mass of what was lost."""
        return self._taken if self._lost is None else self._taken + self.mean(self.old, self._lost)

    @cached_property
    def _floats(self) -> bool:
        """Whether nothing holds the body where it is."""
        return floats(self.new)

    def mean(self, system: System, change: np.ndarray) -> np.ndarray:
        """The translation that moves the centre of mass of a free body as a change does on a system, (n_new_dofs,)."""
        layout = self.new.layout
        out = np.zeros_like(layout.undeformed)
        if self._floats:
            moment, mass = _moments(system, change)
            out[layout.moving, 0] = moment / mass
        return out.ravel()

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Interpolated rates, and of what they lose the projection in the mass norm."""
        there = self.there.rates(self.state.q, v)
        held = self.there.field(self.old.constraints.fixed_part(v))
        out = self.new.constraints.free_part(there) + self.new.constraints.fixed_part(held)
        if self.back is None:
            return out
        lost = self._significant(v - self.back.rates(self._taken, out), v)
        return out + self.new_mass.solve(self.back.transposed(self.old.mass @ lost)) if lost.any() else out

    def velocity(self) -> np.ndarray:
        """The rates of the state, those of the prescription apart at prescribed coordinates."""
        v, (before, after) = self.state.velocity, (_rate(s, self.state.time) for s in (self.old, self.new))
        assert v is not None
        out = self.rates(v)
        if before.any() or after.any():
            out = out + after - self.new.constraints.fixed_part(self.there.field(before))
        return out

    def settled(self) -> np.ndarray:
        """The positions after a step towards the internal forces that belong to the accelerations; more, where one leaves
        much more energy than there was."""
        old, new, state, q = self.old, self.new, self.state, self.start
        excess = self.excess(q)
        if not self._is_settled(excess):
            accelerations = self.rates(self.old_mass.solve(self.net_force(old, state.q)))
            inertia = new.mass @ accelerations
            with DirectSolver(new.pattern, new.constraints, self.backend) as solver:
                found = iterate(q, _Settling(self, inertia, solver), _Excess(self, excess), STEPS, logger)
            if found.status is Status.SINGULAR:
                raise SingularMatrix(found.message)
            q = closed(new, found.x, state.case, self.backend)
        return q

    def _is_settled(self, excess: float) -> bool:
        """Was nothing lost on coarser elements, or is the strain energy the same?"""
        lost_nothing = self._lost is not None and not self._lost.any()
        return lost_nothing or abs(excess) <= ROUNDED_PRODUCT * self.energy

    def net_force(self, system: System, q: np.ndarray) -> np.ndarray:
        return system.external_force(q, self.state.case) - system.internal_force(q, None, self.state.case)

    def excess(self, q: np.ndarray) -> float:
        """Strain energy on the new mesh beyond that of the state (J)."""
        return self.strain_energy(self.new, q) - self._strain

    def strain_energy(self, system: System, q: np.ndarray) -> float:
        return system.strain_energy(q, self.state.case)

    def change(self, q: np.ndarray, v: np.ndarray | None, factor: float) -> RemapChange:
        state, still = self.state, Solution(self.new, q, v)
        strain = np.array([self._strain, self.strain_energy(self.new, q)])
        kinetic = np.array([state.kinetic_energy, still.kinetic_energy])
        rise = float(np.diff(strain + kinetic)[0])
        centres = [moment / mass for moment, mass in (_moments(self.old, state.q), _moments(self.new, q))]
        return RemapChange(
            strain, kinetic, np.stack([state.momenta, still.momenta]), factor,
            rise if rise > ROUNDED_PRODUCT * self.energy else 0.0, float(np.linalg.norm(centres[1] - centres[0])),
        )  # fmt: skip


@dataclass(frozen=True)
class _Settling:
    """Steps towards the internal forces that belong to given forces of inertia, by the elastic tangent of each state."""

    passage: _Passage
    inertia: np.ndarray
    solver: DirectSolver

    __repr__ = short

    def residual(self, q: np.ndarray) -> np.ndarray:
        new = self.passage.new
        return new.constraints.free_part(self.passage.net_force(new, q) - self.inertia)

    def correction(self, q: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        new = self.passage.new
        if not residual.any():
            return residual, 0.0
        elastic = Exact(new).elastic(q)
        mass = new.mass.diagonal()  # a pole has a vector without any
        direction = new.constraints.free_part(np.divide(residual, mass, out=np.zeros_like(mass), where=mass > 0))
        squared_frequency = float(direction @ (elastic @ direction)) / (2 * new.kinetic_energy(direction))
        matrix = elastic + new.geometry.theory.softest * squared_frequency * new.mass
        tangent = factored_about(new, self.solver, matrix, None, q)
        values = new.conditions.value(q, self.passage.state.case)
        step, _, _ = solved(tangent, residual, -values)  # the multipliers come anew from each residual
        return step - self.passage.mean(new, step), work(step, residual)

    def step(self, q: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        return q + change


@dataclass
class _Excess:
    """Ends where a step does not bring the strain energy nearer to that of the state, or brings it near enough."""

    passage: _Passage
    excess: float

    def assess(self, q: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        left = self.passage.excess(q + change)
        if not abs(left) < abs(self.excess):
            return Status.DIVERGED, ""
        self.excess = left
        return (Status.CONVERGED, "") if left <= ENOUGH * self.passage.energy else None


def _rate(system: System, time: float | None) -> np.ndarray:
    """The rate of the prescribed coordinates, (n_dofs,)."""
    return np.zeros(system.n_dofs) if time is None else prescribed_rate(system, time, RATE_STEP * max(1.0, abs(time)))


def _moments(system: System, q: np.ndarray) -> tuple[np.ndarray, float]:
    """Mass times the place of its centre (3,), and the mass."""
    return system.inertia.centre(q), system.inertia.total
