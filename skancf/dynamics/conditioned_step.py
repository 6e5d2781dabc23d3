r"""Newton's method in one step with conditions: unknowns are the increment and the multipliers, (n_dofs + n,).

.. math:: R(u) + \bar G(u)^T \lambda = 0, \qquad g(q_n + u) = 0

with the residual R of the rule and the gradient with which it lets multipliers act. Factors are those of the tangent with
:math:`G^T P G`, see :mod:`skancf.linear.conditioned`, and turn with the nodes.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, gmres

from skancf.dynamics.step_newton import (
    DIFFERENCE,
    INNER,
    VECTORS,
    Equations,
    KeptFactors,
    StepCriterion,
    StepTangents,
)
from skancf.history import Case
from skancf.linear import BlockMatrix, ConditionedSolver
from skancf.linear.conditioned import STIFFNESS
from skancf.solving import End, Status
from skancf.tolerances import ABOVE_ZERO

PASSES = 2
"""Of the solve with conditions in a correction."""


@dataclass(frozen=True)
class ConditionedEquations(Equations):
    """Those of a step with conditions, for x, the increment and the multipliers."""

    @property
    def n(self) -> int:
        """Coordinates of the increment."""
        return self.system.n_dofs

    def end(self, x: np.ndarray) -> np.ndarray:
        return self.start.q + x[: self.n]

    def tangent_at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return super().tangent_at(x[: self.n])

    def gradients(self, x: np.ndarray) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """That with which multipliers act, and that of the conditions at the end."""
        conditions, end = self.system.conditions, self.end(x)
        return self.rule.gradient(conditions, x[: self.n], self.start, self.dt), conditions.gradient(end)

    def values(self, x: np.ndarray) -> np.ndarray:
        """g at the end of the step."""
        return self.system.conditions.value(self.end(x), self.case)

    @property
    def case(self) -> Case:
        """The end of the step."""
        return Case(time=self.start.time + self.dt)

    def force(self, x: np.ndarray) -> np.ndarray:
        """That of the conditions, on the left side of the equations, (n_dofs,)."""
        gradient = self.rule.gradient(self.system.conditions, x[: self.n], self.start, self.dt)
        return np.asarray(gradient.T @ x[self.n :])

    def residual(self, x: np.ndarray) -> np.ndarray:
        """That of the equations of motion, then g."""
        return np.concatenate([super().residual(x[: self.n]) + self.force(x), self.values(x)])

    def tangent(self, x: np.ndarray, before: np.ndarray, step: np.ndarray) -> BlockMatrix:
        """With the curvature of the conditions."""
        u, n, system = x[: self.n], self.n, self.system
        tangent = super().tangent(u, before[:n], step[:n])
        blocks = system.blocks()
        at = self.rule.at_stage(u, self.start, self.dt)[0]
        system.conditions.add_curvature(at, self.rule.stage * x[n:], blocks)
        return tangent if blocks.is_zero else tangent + blocks.matrix()


class ConditionedFactors(KeptFactors):
    """Factors of a step's tangent with conditions; gradients are those of the present iteration, turned back.

    Attributes
    ----------
    gradients : pair of (n, n_dofs) sparse arrays
        With which multipliers act, and of the conditions at the end of the step.
    """

    gradients: tuple[sp.csr_matrix, sp.csr_matrix]
    held: ConditionedSolver
    matrix: BlockMatrix

    def __init__(self, conditions: Any, *options: Any) -> None:
        super().__init__(*options)
        self.conditions = conditions

    def factor(self, matrix: BlockMatrix, q: np.ndarray) -> None:
        held = ConditionedSolver(self.linear, self.conditions.gradient(q))
        super().factor(held.condensed(matrix), q)
        self.held, self.matrix = held, matrix

    @property
    def sizes(self) -> np.ndarray:
        """Force (n,) that moves each row by its scale, if every nodal vector moved by itself."""
        return self.held.stiffness / STIFFNESS * self.conditions.scales

    def metric(self, x: np.ndarray) -> np.ndarray:
        """A positive matrix times a correction of increments and multipliers: its energy."""
        n = self.matrix.shape[0]
        of_u = self._turned(self.columns, self.matrix @ self._turned(self.columns.swapaxes(1, 2), x[:n]))
        compliance = np.divide(STIFFNESS, self.held.stiffness, out=np.zeros(len(x) - n), where=~self.held.held)
        return np.concatenate([of_u, compliance * x[n:]])

    def solve(self, force: np.ndarray) -> tuple[np.ndarray, float]:
        """The correction (n_dofs + n,) of both, and the energy of its increment."""
        n, held, (now, end), back = self.matrix.shape[0], self.held, self.gradients, self.rows.swapaxes(1, 2)
        rhs, values = self._turned(back, force[:n]), np.where(held.held, 0.0, force[n:])
        x, multipliers, left, open_rows = np.zeros(n), np.zeros(len(values)), rhs, values
        product = x
        for k in range(PASSES):
            if k:
                left = rhs - product - self._turned(back, now.T @ multipliers)
                open_rows = np.where(held.held, 0.0, values - end @ self._turned(self.columns, x))
            change = self.linear.solve(left + held.free.T @ (held.stiffness * open_rows), refinements=0)
            x = x + change
            multipliers = multipliers + held.stiffness * (held.free @ change - open_rows)
            product = self.matrix @ x
        return np.concatenate([self._turned(self.columns, x), multipliers]), abs(float(x @ product))


class ConditionedTangents(StepTangents):
    """Corrections of increments and multipliers.

    Attributes
    ----------
    left : pair of (n,) arrays
        Values of the conditions before the last correction, and what it leaves of them, to first order.
    """

    equations: ConditionedEquations
    factors: ConditionedFactors
    left: tuple[np.ndarray, np.ndarray]

    def correction(self, u: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        n, gradients = self.equations.n, self.equations.gradients(u)
        self.factors.gradients = gradients
        change, energy = super().correction(u, residual)
        self.left = residual[n:], residual[n:] + gradients[1] @ change[:n]
        return change, energy

    def _accelerated(self, change: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """In a norm of both, in which multipliers count by what they would move."""
        return self.history.step(change, -self.factors.metric(change))

    def _with_skew_part(self, change: np.ndarray, residual: np.ndarray, u: np.ndarray) -> np.ndarray:
        if self.equations.rule.symmetric:
            return change
        n = self.equations.n
        sizes = np.concatenate([self.equations.system.layout.scales.ravel(), self.factors.sizes])
        sizes[sizes == 0] = 1.0
        scaled, act = change / sizes, self.factors.gradients[0].T

        def product(x: np.ndarray) -> np.ndarray:
            size, way = DIFFERENCE / max(float(np.abs(x[:n]).max()), ABOVE_ZERO), sizes * x
            along = np.concatenate([way[:n], np.zeros(len(x) - n)])
            change = (self.residual(u + size * along) - residual) / size
            change[:n] += act @ way[n:]
            return self.factors.solve(change)[0] / sizes

        operator = LinearOperator((u.size, u.size), matvec=product, dtype=np.float64)
        return sizes * np.asarray(gmres(operator, scaled, x0=scaled, rtol=INNER, atol=0.0, restart=VECTORS, maxiter=1)[0])


class ConditionedCriterion(StepCriterion):
    """Ends where a correction is small and the conditions are met before it and after it."""

    tangents: ConditionedTangents

    def assess(self, u: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        end = super().assess(u, change, energies)
        conditions = self.tangents.factors.conditions
        if end and end[0] is Status.CONVERGED and not all(conditions.met(values) for values in self.tangents.left):
            return None
        return end
