r"""Tangents with a skew-symmetric part, as loads that follow the surface have them.

Only the symmetric part K is factored. (K + S) x = b is solved by GMRES on :math:`(1 + K^{-1} S)\,x = K^{-1} b`; where S is
small against K, a few products are enough.
"""

from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from skancf.errors import SingularMatrix
from skancf.linear.matrix import BlockMatrix
from skancf.linear.solver import DirectSolver
from skancf.tolerances import GMRES_RTOL

# Rounding of ill-conditioned factors may stop the iteration earlier; a correction of Newton's method does with this.
POOR = 1e-4
VECTORS = 60


def _size(v: np.ndarray) -> float:
    return float(np.sqrt(v @ v))


class SkewSolver:
    """Solves (K + S) x = b on the free coordinates with the factors of K.

    Parameters
    ----------
    matrix : BlockMatrix
        K.
    skew : sparse matrix (n, n) or None
        S; without it this is the direct solver.
    solver : DirectSolver
        Holds the factors of K.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> stiffness = system.tangent(system.undeformed)
    >>> with sk.linear.DirectSolver(system.pattern, system.constraints) as solver:
    ...     solver.factor(stiffness)
    ...     x = sk.linear.SkewSolver(stiffness, None, solver).solve(np.ones(system.n_dofs))
    >>> print(x.shape)
    (588,)
    """

    def __init__(self, matrix: BlockMatrix, skew: Any, solver: DirectSolver) -> None:
        self.matrix, self.skew, self.direct = matrix, skew, solver

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """(K + S) x, shape (n,)."""
        product = self.matrix @ x
        return product if self.skew is None else product + self.skew @ x

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """x on the free coordinates, zero on the prescribed ones, shape (n,).

        Raises
        ------
        SingularMatrix
            Where the iteration does not converge: the skew part is then as large as the symmetric one.
        """
        first = self.direct.solve(rhs)
        if self.skew is None or not np.isfinite(first).all() or not first.any():
            return first
        operator = LinearOperator(self.matrix.shape, matvec=lambda x: x + self.direct.solve(self.skew @ x), dtype=np.float64)
        x, failed = gmres(operator, first, x0=first, rtol=GMRES_RTOL, atol=0.0, restart=VECTORS, maxiter=2)
        if failed and not _size(operator @ x - first) <= POOR * _size(first):
            raise SingularMatrix(
                f"{2 * VECTORS} iterations did not solve for the skew part of the loads' stiffness; it is as large as the "
                "structure's own stiffness: take a shorter step, or look for a part that the loads blow away"
            )
        return x
