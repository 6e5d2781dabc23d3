"""Newton's method in one step: its equations, factors that are kept as long as they converge, and when it ends."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from skancf.dynamics.acceleration import Anderson
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.dynamics.turning import TurningFactors
from skancf.history import Case
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.showing import short
from skancf.solving import End, Status
from skancf.system.system import System
from skancf.tolerances import ABOVE_ZERO, ROUNDED_COORDINATE, STALLED_ENERGY

SLOW = 0.5
"""Factors of an earlier step are given up where a correction is not this much smaller than the one before."""
STALLED = 0.5
"""Where corrections are no more than this smaller, and tiny, rounding is what is left of them."""
DIVERGED = 1e6
"""Times the energy of the first correction, at which an iteration is given up."""
DIFFERENCE = 1e-7
"""Change of coordinates, in sizes of the body, over which the residual is differenced."""
INNER, VECTORS = 0.1, 4
"""How far, and with how many vectors, GMRES goes in each iteration."""


class Effort(IntEnum):
    """How often a step factors its tangent: never, at first and where the iteration becomes slow, or at each iteration."""

    KEEP = 0
    ANEW = 1
    EACH = 2


@dataclass(frozen=True)
class Equations:
    """Those of a step of length ``dt`` from a state, by a rule, for the increment u."""

    system: System
    rule: Rule
    start: State
    dt: float

    __repr__ = short

    def end(self, u: np.ndarray) -> np.ndarray:
        """Nodal coordinates at the end of the step, (n_dofs,)."""
        return self.start.q + u

    def tangent_at(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See :meth:`Rule.tangent_at`."""
        return self.rule.tangent_at(u, self.start)

    def residual(self, u: np.ndarray) -> np.ndarray:
        """Inertia, damping and internal force less the loads."""
        rule, system, start, dt = self.rule, self.system, self.start, self.dt
        out = system.mass @ rule.acceleration(u, start, dt) + rule.internal_force(system, u, start, dt)
        if system.viscous is not None:
            out += system.viscous @ rule.rate(u, start, dt)
        at, time = rule.at_stage(u, start, dt)
        return out - system.applied_force(at, Case(time=time), rule.rate(u, start, dt))

    def tangent(self, u: np.ndarray, before: np.ndarray, step: np.ndarray) -> BlockMatrix:
        """The symmetric part of its derivative, with stresses extrapolated from an increment along a ``step``."""
        rule, system, start, dt = self.rule, self.system, self.start, self.dt
        tangent = rule.stiffness(system, u, start, dt, rule.stresses(system, before, start, dt, step))
        values = tangent.values
        values += rule.mass_factor(dt) * system.mass.values
        if system.viscous is not None:
            values += rule.damping_factor(dt) * system.viscous.values
        at, time = rule.at_stage(u, start, dt)
        damping = system.terms.damping(at, rule.rate(u, start, dt), Case(time=time))
        if damping is not None:
            values += rule.damping_factor(dt) * damping.values
        return BlockMatrix(tangent.pattern, values)


class KeptFactors(TurningFactors):
    """Factors of a step's tangent for later steps.

    Attributes
    ----------
    dt : float
        Length of the step they belong to (s); zero without any.
    rounding : float
        The energy that rounding of the coordinates puts into a correction (J).
    """

    def __init__(self, linear: DirectSolver, constraints: Constraints, moves: np.ndarray) -> None:
        super().__init__(linear, constraints, moves)
        self.dt = self.rounding = 0.0

    def of(self, equations: Equations, u: np.ndarray, before: np.ndarray, step: np.ndarray) -> None:
        """Factor :meth:`Equations.tangent`."""
        tangent = equations.tangent(u, before, step)
        self.factor(tangent, equations.tangent_at(u)[0])
        self.dt = equations.dt
        self.rounding = ROUNDED_COORDINATE**2 * float(np.abs(tangent.diagonal()) @ equations.end(u) ** 2)


class StepTangents:
    """Corrections with kept factors, or with new ones as often as an effort says.

    Attributes
    ----------
    fresh, slow : bool
        Of the last correction: by new factors; or one that kept factors did not make small enough.
    factorisations : int
    """

    def __init__(
        self, equations: Equations, factors: KeptFactors, effort: Effort, before: np.ndarray, step: np.ndarray
    ) -> None:
        """``before`` and ``step``: an increment, and what leads from it to the first guess."""
        self.equations, self.factors, self.effort, self.before, self._step = equations, factors, effort, before, step
        self.history, self.factorisations, self.last = Anderson(), 0, np.inf
        self.first, self.fresh, self.slow = True, False, False

    def residual(self, u: np.ndarray) -> np.ndarray:
        return self.equations.residual(u)

    def correction(self, u: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        effort, first, was_fresh = self.effort, self.first, self.fresh
        self.first, change, energy = False, np.empty(0), np.inf
        if effort is Effort.KEEP and first:
            self.factors.turn_to(*self.equations.tangent_at(u))
        if effort is Effort.KEEP or (effort is Effort.ANEW and not first):
            change, energy = self.factors.solve(-residual)
        self.slow = energy > SLOW**2 * self.last
        self.fresh = effort is Effort.EACH or (effort is Effort.ANEW and (first or (self.slow and not was_fresh)))
        if self.fresh:
            self.factors.of(self.equations, u, self.before, self._step)
            self.factorisations += 1
            self.history.restart()
            change, energy = self.factors.solve(-residual)
        self.last = energy
        return change, energy

    def step(self, u: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        """With kept factors accelerated, with new ones corrected by what they leave out."""
        each = self.effort is Effort.EACH
        self._step = self._with_skew_part(change, residual, u) if each else self._accelerated(change, residual)
        self.before = u
        return u + self._step

    def _accelerated(self, change: np.ndarray, residual: np.ndarray) -> np.ndarray:
        return self.history.step(change, residual)

    def _with_skew_part(self, change: np.ndarray, residual: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The correction of the whole tangent, by GMRES on differences of the residual, preconditioned by the factors.

        In coordinates without units, whose norm means something.
        """
        if self.equations.rule.symmetric:
            return change
        sizes = self.equations.system.layout.scales.ravel()
        scaled = change / sizes

        def product(x: np.ndarray) -> np.ndarray:
            size = DIFFERENCE / max(float(np.abs(x).max()), ABOVE_ZERO)
            return self.factors.solve((self.residual(u + size * sizes * x) - residual) / size)[0] / sizes

        operator = LinearOperator((u.size, u.size), matvec=product, dtype=np.float64)
        return sizes * np.asarray(gmres(operator, scaled, x0=scaled, rtol=INNER, atol=0.0, restart=VECTORS, maxiter=1)[0])


@dataclass(frozen=True)
class StepCriterion:
    """Ends where a correction is small: its scale is the energy of the motion, or of the first one, which cannot grow."""

    tangents: StepTangents
    rtol: float
    motion: float

    def assess(self, u: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        energy, first = energies[-1], next((e for e in energies if e), 0.0)
        last, scale = energies[-2] if len(energies) > 1 else np.inf, max(self.motion, first)
        if not energy <= DIVERGED * first:
            return Status.DIVERGED, "corrections that grow"
        small = energy <= self.rtol**2 * scale + self.tangents.factors.rounding
        if small or STALLED * last < energy < STALLED_ENERGY * scale:
            return Status.CONVERGED, ""
        if self.tangents.slow and not self.tangents.fresh:
            return Status.DIVERGED, "no convergence with factors of an earlier iteration"
        return None
