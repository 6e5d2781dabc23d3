r"""Relaxation at the full load: equilibria reached with a pretension that is then released.

From a state :math:`q_n` the mixed Newton iteration solves

.. math:: f(q) - \lambda F(q) + \sigma G (q - q_n) = 0

for :math:`q_{n+1}`, and :math:`\sigma` falls to zero. G is the geometric stiffness of a uniform dilation by one, so that
:math:`\sigma` is a strain: larger than the largest compression of the surface, it makes every membrane tangent definite.
Each step is one of implicit Euler of a gradient flow. The energy falls in it, so the flow ends in the stable state that
lies downhill of where it began; without inertia it does not run past a near one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.conditions.solver import curved, solver_at
from skancf.history import Case
from skancf.linear import BlockMatrix, DirectSolver, factor_shifted, soft_motions
from skancf.showing import short
from skancf.statics.conditioned import tangent_at
from skancf.statics.corrections import StaticSystem, internal_force
from skancf.statics.newton import NewtonResult, largest_turn
from skancf.statics.stopping import Pull, work
from skancf.statics.tangents import is_skew
from skancf.system.dilation import pretension
from skancf.tolerances import ALIKE

BUDGET = 600
"""Newton iterations in one relaxation; coarse meshes of pinched shells take 320."""
INNER_RTOL, INNER_STEPS = 3e-2, 10
PUSHED, CIRCLING = 400, 150
"""The same from a pushed state, and where the loads have no potential there, so that no energy need fall."""
PUSHES = 3
STRONGEST = 1e4
"""A pull this many times as strong as the first one, or as a strain, holds what no pull can hold: the relaxation ends."""
PUSH, HALVINGS = 1e-2, 10
"""Of the size of the body, along the motion in which an equilibrium is not stable; halved where that leads uphill."""
CANDIDATES, INVERSE_ITERATIONS = 4, 8


@dataclass
class Letting:
    """How strong the next pull is, by how the last step went: the policy of a relaxation.

    An easy step, of two iterations, divides it by eight; one of more than six doubles it; a failed one, or one that ended
    where the tangent is not definite even with the pull, multiplies it by four. After a failure two steps stay above twice
    the pull that failed. A step that went uphill, to a state that is not stable, has failed too: under a weak pull such a
    state attracts.
    """

    strength: float
    failed: float = 0.0
    waiting: int = 0
    calm: int = 0

    def after(self, iterations: int, went: bool, definite: bool) -> None:
        """Take note of a step, and whether it was taken; ``calm`` counts easy ones in a row."""
        if not went:
            self.failed, self.waiting, self.calm = self.strength, 2, 0
            self.strength *= 4.0
            return
        if not definite:
            self.strength, self.calm = 4.0 * self.strength, 0
            return
        self.calm = self.calm + 1 if iterations <= 2 else 0
        following = self.strength / {0: 8.0, 1: 8.0, 2: 8.0, 3: 2.0, 4: 1.0, 5: 1.0, 6: 1.0}.get(iterations, 0.5)
        if self.waiting and following < 2 * self.failed:
            following = min(self.strength, 2 * self.failed)
            self.waiting -= 1
        self.strength = following


@dataclass
class _Flow:
    """Where a relaxation is: what it began from, the state that is held, and what it met."""

    begin: np.ndarray
    q: np.ndarray
    letting: Letting
    reference: float
    calm_enough: int
    unstable: NewtonResult | None = None
    pushes: int = 0

    __repr__ = short


class Relaxation:
    """Relaxations of one system under one load.

    Parameters
    ----------
    solve : callable
        Newton's method on the system with a solver: ``solve(q, load_factor, **options)``; whoever gives it keeps account of
        the attempts.
    """

    def __init__(
        self, system: StaticSystem, solver: DirectSolver, load_factor: float, solve: Callable[..., NewtonResult]
    ) -> None:
        self.system, self.solver, self.load_factor, self.solve = system, solver, load_factor, solve
        self.metric: BlockMatrix = pretension(system)
        self._flow: _Flow | None = None

    def from_state(self, q: np.ndarray, origin: np.ndarray, budget: int = BUDGET) -> NewtonResult | None:
        """The stable equilibrium downhill of a state; one that is not stable if nothing else is found, or None.

        ``origin`` is where the way began by which the last solve is measured. From the same state again it goes on where it
        ended.
        """
        if self._flow is None or self._flow.begin is not q:
            reference, first = self._first_strength(q)
            self._flow = _Flow(q, q, Letting(first), reference, calm_enough=2)
        return self._go(self._flow, origin, budget)

    def from_unstable(self, found: NewtonResult, origin: np.ndarray, budget: int = BUDGET) -> NewtonResult | None:
        """The same from an equilibrium that is not stable, pushed along its softest motion."""
        pushed = self._pushed(found)
        reference, first = self._first_strength(pushed)
        budget = min(budget, PUSHED if self.has_potential(pushed) else CIRCLING)
        return self._go(_Flow(pushed, pushed, Letting(first), reference, calm_enough=5), origin, budget)

    def _go(self, flow: _Flow, origin: np.ndarray, budget: int) -> NewtonResult | None:
        used, letting = 0, flow.letting
        strongest = STRONGEST * max(1.0, flow.reference)
        while used < budget and letting.strength < strongest and flow.pushes <= PUSHES:
            pull = Pull(letting.strength, self.metric, flow.q)
            held = self.solve(flow.q, self.load_factor, pull=pull, rtol=INNER_RTOL, max_steps=INNER_STEPS)
            used += held.iterations
            # Without a potential pivots do not tell, until they are what keeps the flow from an end.
            definite = not held.negative_pivots or not (flow.unstable or self.has_potential(held.q))
            went = held.ok and (definite or self.rise(flow.q, held.q) < 0)
            flow.q = held.q if went else flow.q
            letting.after(held.iterations, went, definite)
            if letting.calm < flow.calm_enough:
                continue
            free = self.solve(flow.q, self.load_factor, origin=origin)
            used, letting.calm = used + free.iterations, -1
            if not free.ok:
                continue
            if not free.negative_pivots:
                return free
            flow.unstable, flow.calm_enough = flow.unstable or free, 5
            # Far from the state that was held, Newton's method went back uphill: the flow goes on from where it is.
            if self._far(free.q - flow.q) < 1.0:
                flow.pushes += 1
                flow.q, letting.strength = self._pushed(free), max(letting.strength, flow.reference)
        return flow.unstable

    def has_potential(self, q: np.ndarray) -> bool:
        """Whether the tangent of a state is symmetric."""
        return not is_skew(self.system, self.system.tangent(q, Case(self.load_factor)), q, self.load_factor)

    def _first_strength(self, q: np.ndarray) -> tuple[float, float]:
        """The stiffness against the load, relative to G, of the way that the load begins; and that times its turn, so that
        the first step turns slopes by less than one."""
        system, factor = self.system, self.load_factor
        unstressed = np.zeros_like(system.stresses(q))
        tangent = tangent_at(system, q, factor, self.solver, unstressed)
        moved = system.constraints.fixed_part(system.undeformed + factor * system.prescribed() - q)
        residual = factor * system.external_force(q) - internal_force(system, q, factor)
        way = tangent.solve(residual - tangent.multiply(moved)) + moved
        stiff, dilated = work(way, tangent.multiply(way)), work(way, self.metric @ way)
        reference = stiff / dilated if dilated else 1.0
        return reference, reference * max(1.0, largest_turn(system, way))

    def _pushed(self, found: NewtonResult) -> np.ndarray:
        q, shape = found.q, downhill(self.system, self.solver, found)
        shape = shape / self._far(shape)
        for _ in range(HALVINGS):
            if self.rise(q, q + shape) < 0:
                break
            shape = shape / 2
        return q + shape

    def rise(self, q: np.ndarray, to: np.ndarray) -> float:
        """Change of the strain energy less the work of the loads, of which the mean of both ends acts on the way."""
        system: Any = self.system
        factor = self.load_factor
        stored = system.strain_energy(to, Case(factor)) - system.strain_energy(q, Case(factor))
        force = 0.5 * factor * (system.external_force(q) + system.external_force(to))
        return float(stored - force @ (to - q))

    def _far(self, change: np.ndarray) -> float:
        """Largest displacement in a change, over that of a push."""
        layout: Any = self.system.layout  # type: ignore[attr-defined]
        positions = layout.positions(self.system.undeformed)
        push = PUSH * float(np.linalg.norm(np.ptp(positions, axis=0)))
        return float(np.abs(layout.positions(change)).max()) / push


def downhill(system: Any, solver: DirectSolver, found: Any) -> np.ndarray:
    """The motion, of a few soft ones, against which the tangent of a state is least stiff per mass: (n_dofs,).

    Of its two directions the one in which the first of its largest components is positive: the same on every machine.
    """
    q, held = found.q, solver_at(system, solver, found.q)
    matrix = curved(system, system.tangent(q, Case(found.load_factor)), q, found.multipliers)
    factor_shifted(held, matrix, system.mass)
    values, motions = soft_motions(system, held, matrix, CANDIDATES, INVERSE_ITERATIONS)
    motion = motions[int(np.argmin(values))]
    sizes = np.abs(motion)
    return np.asarray(motion * np.sign(motion[np.argmax(sizes > (1 - ALIKE) * sizes.max())]))
