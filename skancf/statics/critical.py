"""Critical modes of an equilibrium: what becomes singular at limit points and bifurcations."""

from typing import Any, NamedTuple

import numpy as np

from skancf.conditions.solver import curved, solver_at
from skancf.history import Case
from skancf.linear import BlockMatrix, DirectSolver, factor_shifted, soft_motions
from skancf.showing import short
from skancf.statics.corrections import StaticSystem, load_rate

INVERSE_ITERATIONS = 12


class CriticalMode(NamedTuple):
    """The eigenvalue nearest to zero of a tangent against the mass, its mode, and the number of negative ones.

    ``share`` is the part of the load's compliance F . K^-1 F that this mode has; it tells a limit point from a bifurcation.
    """

    eigenvalue: float
    shape: np.ndarray
    negative: int
    compliance: float = np.inf
    share: float = 1.0

    def __repr__(self) -> str:
        return short(self)


def critical_mode(system: StaticSystem, solver: DirectSolver, state: Any, without_work: bool = False) -> CriticalMode:
    r"""The critical mode of a state or point of a path, that nearest to having no stiffness, by inverse iteration.

    ``without_work`` keeps to motions x with x . F = 0: their tangent is regular at a limit point. With K u = F they are the
    K-projection :math:`x - (x \cdot F / u \cdot F)\,u`, and have one negative eigenvalue less where u . F < 0.
    """
    q, held = state.q, solver_at(system, solver, state.q)
    matrix = curved(system, system.tangent(q, Case(state.load_factor)), q, state.multipliers)
    factor_shifted(held, matrix, system.mass)
    with np.errstate(over="ignore", invalid="ignore"):
        return _critical(system, held, state, matrix, without_work)


def turning_estimate(values: tuple[float, float], rates: tuple[float, float]) -> float:
    """Where a quantity turns back, of which two values and their rates of change along the path are known.

    Near its extremum the square of the rate falls linearly with the value. Infinite where it does not fall.
    """
    if not rates[1]:
        return values[1]
    fall = (rates[0] / rates[1]) ** 2 - 1
    return values[1] + (values[1] - values[0]) / fall if fall > 0 else np.inf


def _critical(system: StaticSystem, solver: Any, state: Any, matrix: BlockMatrix, without_work: bool) -> CriticalMode:
    load = load_rate(system, state.q, state.load_factor) - matrix @ system.prescribed()
    soft = solver.solve(load)

    def workless(x: np.ndarray) -> np.ndarray:
        return x - (x @ load) / (soft @ load) * soft

    # Where a condition alone moves the structure there is no work to keep to.
    keep = workless if without_work and soft @ load else np.asarray
    values, motions = soft_motions(system, solver, matrix, 1, INVERSE_ITERATIONS, keep)
    eigenvalue, x, compliance = float(values[0]), motions[0], float(soft @ load)
    share = float((x @ load) ** 2 / (eigenvalue * compliance)) if eigenvalue and compliance else 1.0
    negative = solver.negative_pivots - (without_work and compliance < 0)
    return CriticalMode(eigenvalue, x, negative, compliance, share)
