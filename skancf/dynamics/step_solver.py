"""One implicit step: Newton's method that keeps its factors as long as they converge."""

from dataclasses import dataclass

import numpy as np

from skancf.assembly.system import System
from skancf.dynamics.generalized_alpha import GeneralizedAlpha
from skancf.errors import SingularMatrix
from skancf.linear import BlockMatrix, DirectSolver
from skancf.statics.newton import ROUNDING, work

MAX_ITERATIONS = 20
SLOW = 0.25
"""Factors of an earlier step are renewed when a correction is not this much smaller than the one before."""


@dataclass(frozen=True)
class StepOutcome:
    """State at the end of a step, if it converged."""

    converged: bool
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    iterations: int
    factorisations: int
    message: str = ""


class StepSolver:
    """Solves the steps of a run; keeps matrix, factors and the step they belong to."""

    def __init__(self, system: System, rule: GeneralizedAlpha, rtol: float, backend: str):
        self.system, self.rule, self.rtol = system, rule, rtol
        self.linear = DirectSolver(system.pattern, system.constraints, backend)
        self.factored_dt = 0.0
        self.energy = 0.0
        self.rounding = 0.0

    def close(self) -> None:
        self.linear.close()

    def initial_acceleration(self, q: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
        """M a = external - internal force, on the free coordinates."""
        self.linear.factor(self.system.mass)
        self.factored_dt = 0.0
        self.energy = 0.5 * float(v @ (self.system.mass @ v))
        return self.linear.solve(self.system.external_force(q, time) - self.system.internal_force(q))

    def step(self, q: np.ndarray, v: np.ndarray, a: np.ndarray, t: float, dt: float) -> StepOutcome:
        """One step of length dt from (q, v, a) at t."""
        rule, system, mass = self.rule, self.system, self.system.mass
        t_alpha = t + (1 - rule.alpha_f) * dt
        target = system.undeformed + system.prescribed(t + dt)
        q1 = q + dt * v + 0.5 * dt**2 * a
        q1 = q1 + system.constraints.fixed_part(target - q1)
        factorisations, last, largest, message = 0, np.inf, 0.0, ""
        renew = self.factored_dt != dt
        for iteration in range(1, MAX_ITERATIONS + 1):
            a1 = rule.acceleration(q1, q, v, a, dt)
            middle = rule.alpha_f * q + (1 - rule.alpha_f) * q1
            residual = (
                mass @ ((1 - rule.alpha_m) * a1 + rule.alpha_m * a)
                + system.internal_force(middle)
                - system.external_force(middle, t_alpha)
            )
            if not np.isfinite(residual).all():
                message = f"values that are not finite {self._place(residual)}"
                break
            if renew:
                try:
                    self._factor(middle, t_alpha, dt)
                except SingularMatrix as singular:
                    message = str(singular)
                    break
                factorisations += 1
            change = -self.linear.solve(residual, refinements=0)
            energy = work(change, residual)
            if not np.isfinite(energy):
                message = f"values that are not finite {self._place(residual)}"
                break
            fresh, renew = renew, False
            largest = max(largest, energy)
            if energy <= self.rtol**2 * max(self.energy, largest) + self.rounding:
                q1 = q1 + change
                return self._finish(q1, q, v, a, dt, iteration, factorisations)
            if energy > SLOW**2 * last and not fresh:
                renew = True
            elif iteration > 4 and energy > 100 * last:
                message = f"Newton's method diverged {self._place(residual)}"
                break
            q1, last = q1 + change, energy
        else:
            message = f"no convergence in {MAX_ITERATIONS} iterations {self._place(residual)}"
        self.factored_dt = 0.0
        return StepOutcome(False, q, v, a, iteration, factorisations, message)

    def _finish(
        self, q1: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float, iterations: int, factorisations: int
    ) -> StepOutcome:
        a1 = self.rule.acceleration(q1, q, v, a, dt)
        v1 = self.rule.velocity(a1, v, a, dt)
        self.energy = max(self.energy, 0.5 * float(v1 @ (self.system.mass @ v1)))
        return StepOutcome(True, q1, v1, a1, iterations, factorisations)

    def _factor(self, middle: np.ndarray, time: float, dt: float) -> None:
        tangent = self.system.tangent(middle, time=time)
        values = tangent.values
        values *= self.rule.stiffness_factor
        values += self.rule.mass_factor(dt) * self.system.mass.values
        self.linear.factor(BlockMatrix(tangent.pattern, values))
        self.factored_dt = dt
        # The energy that rounding of the coordinates puts into a correction.
        self.rounding = ROUNDING**2 * float(np.abs(tangent.diagonal()) @ (middle * middle))

    def _place(self, residual: np.ndarray) -> str:
        """Where in the plate the residual is largest."""
        sizes = np.nan_to_num(np.abs(residual), nan=np.inf).reshape(-1, 12).max(axis=1)
        x, y = self.system.geometry.points[:, int(np.argmax(sizes))]
        return f"near the node at (x, y) = ({x:.4g}, {y:.4g})"
