"""The softest motions of an equilibrium: what becomes singular at limit points and bifurcations."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from skancf.errors import SingularMatrix
from skancf.linear import BlockMatrix, DirectSolver, SkewSolver
from skancf.statics.newton import System

INVERSE_ITERATIONS = 12
# The shift that makes a singular tangent regular, relative to the smallest ratio of stiffness to mass on the diagonal: far
# above rounding, and no larger than the lowest eigenvalue on meshes of up to a hundred elements along a side.
SHIFT = 1e-6


class Mode(NamedTuple):
    """The eigenvalue nearest to zero of a tangent against the mass, its mode, and the number of negative ones.

    ``share`` is the part of the load's compliance F . K^-1 F that this mode has; it tells a limit point from a bifurcation.
    """

    eigenvalue: float
    shape: np.ndarray
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
    tangent = SkewSolver(system.tangent(q, factor=load_factor), None, solver)
    factor_shifted(solver, tangent.matrix, system.mass)
    with np.errstate(over="ignore", invalid="ignore"):
        return _softest(system, solver, q, tangent, without_work)


def turning_estimate(values: tuple[float, float], rates: tuple[float, float]) -> float:
    """Where a quantity turns back, of which two values and their rates of change along the path are known.

    Near its extremum the square of the rate falls linearly with the value. Infinite where it does not fall.
    """
    if not rates[1]:
        return values[1]
    fall = (rates[0] / rates[1]) ** 2 - 1
    return values[1] + (values[1] - values[0]) / fall if fall > 0 else np.inf


def factor_shifted(solver: DirectSolver, stiffness: BlockMatrix, mass: BlockMatrix) -> float:
    """Factor K, or K + s M where K is singular; the shift -s.

    Raises
    ------
    SingularMatrix
        Where some motion has no stiffness and no mass.
    """
    try:
        solver.factor(stiffness)
        return 0.0
    except SingularMatrix:
        k, m = np.abs(stiffness.diagonal()), mass.diagonal()
        if not k.any():
            raise
        shift = SHIFT * float((k[k > 0] / m[k > 0]).min())
        solver.factor(stiffness + shift * mass)
        return -shift


def soft_motions(
    system: System, solver: DirectSolver, tangent: Any, count: int, iterations: int,
    keep: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The eigenvalues nearest to zero of a tangent against the mass, (m,), and their motions (m, n_dofs), m <= ``count``.

    By inverse iteration of a few motions at once, with factors that the solver has; ``keep`` projects on a part of them.
    """
    rng, mass = np.random.default_rng(0), system.mass
    motions = np.array([system.constraints.free_part(rng.standard_normal(system.undeformed.size)) for _ in range(count)])
    for _ in range(iterations):
        found = np.array([keep(solver.solve(mass @ x)) for x in motions])
        stiff, heavy = (found @ np.array([form @ x for x in found]).T for form in (tangent, mass))
        values, parts = _ritz(stiff, heavy)
        motions = parts @ found
    return values, motions


def _ritz(stiff: np.ndarray, heavy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and rows of eigenvectors of a small pair; nearly dependent motions are dropped."""
    sizes, basis = np.linalg.eigh(heavy / np.sqrt(np.outer(heavy.diagonal(), heavy.diagonal())))
    kept = sizes > 1e-10
    frame = (basis[:, kept] / np.sqrt(sizes[kept])) / np.sqrt(heavy.diagonal())[:, None]
    values, parts = np.linalg.eigh(frame.T @ stiff @ frame)
    return values, (frame @ parts).T


def _softest(system: System, solver: DirectSolver, q: np.ndarray, tangent: SkewSolver, without_work: bool) -> Mode:
    load = system.external_force(q) - tangent.multiply(system.prescribed())
    soft = solver.solve(load)

    def workless(x: np.ndarray) -> np.ndarray:
        return x - (x @ load) / (soft @ load) * soft

    keep = workless if without_work else np.asarray
    values, motions = soft_motions(system, solver, tangent.matrix, 1, INVERSE_ITERATIONS, keep)
    eigenvalue, x, compliance = float(values[0]), motions[0], float(soft @ load)
    share = float((x @ load) ** 2 / (eigenvalue * compliance)) if eigenvalue and compliance else 1.0
    negative = solver.negative_pivots - (without_work and compliance < 0)
    return Mode(eigenvalue, x, negative, compliance, share)
