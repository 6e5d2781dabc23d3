"""The softest motions of a matrix against a mass, by inverse iteration."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skancf.errors import SingularMatrix
from skancf.linear.matrix import BlockMatrix
from skancf.tolerances import DEPENDENT

# The shift that makes a singular tangent regular, relative to the smallest ratio of stiffness to mass on the diagonal: far
# above rounding, and no larger than the lowest eigenvalue on meshes of up to a hundred elements along a side.
SHIFT = 1e-6


def factor_shifted(solver: Any, stiffness: BlockMatrix, mass: BlockMatrix) -> float:
    """Factor K, or K + s M where K is singular, by a direct solver or one with conditions; the shift -s.

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
    system: Any, solver: Any, tangent: Any, count: int, iterations: int,
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
    kept = sizes > DEPENDENT
    frame = (basis[:, kept] / np.sqrt(sizes[kept])) / np.sqrt(heavy.diagonal())[:, None]
    values, parts = np.linalg.eigh(frame.T @ stiff @ frame)
    return values, (frame @ parts).T
