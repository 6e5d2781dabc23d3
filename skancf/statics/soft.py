"""The softest motion of an equilibrium: what becomes singular at limit points and bifurcations."""

from typing import NamedTuple

import numpy as np

from skancf.errors import SingularMatrix
from skancf.linear import DirectSolver, SkewSolver
from skancf.statics.newton import System, factored

INVERSE_ITERATIONS = 12


class Mode(NamedTuple):
    """The eigenvalue nearest to zero of a tangent against the mass, its mode, and the number of negative ones.

    ``share`` is the part of the load's compliance F . K^-1 F that this mode has; it tells a limit point from a bifurcation.
    """

    eigenvalue: float
    shape: np.ndarray | None
    negative: int
    compliance: float = np.inf
    share: float = 1.0


def softest_mode(
    system: System, solver: DirectSolver, q: np.ndarray, load_factor: float, without_work: bool = False
) -> Mode:
    r"""Softest mode by inverse iteration.

    ``without_work`` keeps to motions x with x . F = 0: their tangent is regular at a limit point. With K u = F they are the
    K-projection :math:`x - (x \cdot F / u \cdot F)\,u`, and have one negative eigenvalue less where u . F < 0.
    """
    try:
        tangent = factored(system, q, load_factor, solver)
    except SingularMatrix:
        return Mode(0.0, None, 0)
    with np.errstate(over="ignore", invalid="ignore"):
        return _inverse_iteration(system, solver, q, tangent, without_work)


def _inverse_iteration(
    system: System, solver: DirectSolver, q: np.ndarray, tangent: SkewSolver, without_work: bool
) -> Mode:
    load = system.external_force(q) - tangent.multiply(system.prescribed())
    soft = solver.solve(load)
    x = system.constraints.free_part(np.random.default_rng(0).standard_normal(q.size))
    for _ in range(INVERSE_ITERATIONS):
        x = solver.solve(system.mass @ x)
        if without_work:
            x = x - (x @ load) / (soft @ load) * soft
        x /= np.sqrt(x @ (system.mass @ x))
    eigenvalue, compliance = float(x @ (tangent.matrix @ x)), float(soft @ load)
    share = float((x @ load) ** 2 / (eigenvalue * compliance)) if eigenvalue and compliance else 1.0
    negative = solver.negative_pivots - (without_work and compliance < 0)
    return Mode(eigenvalue, x, negative, compliance, share)
