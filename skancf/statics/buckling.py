"""Linear buckling: the load factors at which an undeformed structure loses its stiffness."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from skancf.assembly.system import System
from skancf.errors import InputError
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.solution import Solution
from skancf.statics.causes import require_support
from skancf.statics.modes import checked_count, free_directions, moved_along

# A load factor that is so many times the smallest one of either sign is the rounding of an infinite one.
NEVER = 1e9


@dataclass(frozen=True)
class BucklingResult:
    """Outcome of :func:`buckling`.

    Attributes
    ----------
    load_factors : (m,) array
        In the order of their size; fewer than were asked where no more exist.
    shapes : (m, n_dofs) array
        Buckling modes with phi . K phi = 1, zero along prescribed coordinates.
    linear : Solution
        The linear answer to the whole load, of which the stresses were used.
    message : str
        That no load factor buckles the structure, if none does.
    """

    load_factors: np.ndarray
    shapes: np.ndarray
    linear: Solution
    message: str = ""

    def shape(self, i: int, size: float | None = None) -> Solution:
        """The undeformed structure moved along mode ``i``; ``size`` is the largest displacement of a node (m)."""
        start = Solution(self.linear.system, self.linear.system.undeformed.copy(), load_factor=0.0)
        return moved_along(start, self.shapes[i], size)


def buckling(
    system: System, n: int = 4, *, signs: str = "positive", tolerance: float = 1e-10, backend: str = "auto"
) -> BucklingResult:
    r"""Load factors :math:`\lambda` with :math:`(K_0 + \lambda K_\sigma)\,\phi = 0`.

    :math:`K_0` is the tangent of the undeformed state, and :math:`K_\sigma` the change of it by the stresses, and by the loads'
    own stiffness, of the linear answer to the whole load. It is exact where the structure hardly moves before it buckles;
    :func:`trace` finds the load in general. Solved as :math:`-K_\sigma \phi = \lambda^{-1} K_0 \phi` by Lanczos' method.

    Parameters
    ----------
    n : int
        Number of load factors.
    signs : {"positive", "both"}
        With "both" the loads may also act the other way; then the smallest in size come first.
    tolerance : float
        Relative accuracy.

    Raises
    ------
    InputError
        When a rigid motion is free, or nothing loads the structure.
    SingularMatrix
        When some part is a mechanism.
    """
    if signs not in ("positive", "both"):
        raise InputError(f"signs = {signs!r}: choose 'positive' or 'both'")
    n = checked_count(n, system.constraints)
    require_support(system)
    start, constraints = system.undeformed, system.constraints
    moved = system.prescribed()
    if not (system.external_force(start).any() or moved.any()):
        raise InputError("no buckling: nothing loads the structure; give a load or a prescribed displacement")
    stiffness = system.tangent(start, factor=0.0)
    with DirectSolver(system.pattern, constraints, backend) as solver:
        solver.factor(stiffness)
        answer = solver.solve(system.external_force(start) - stiffness @ moved, refinements=2) + moved
        stressed = system.tangent(start, system.stresses(start, answer), factor=1.0)
        geometric = stressed + (-1.0) * stiffness
        inverse, shapes = _pencil(solver, stiffness, geometric, constraints, n, signs, tolerance)
    largest = np.abs(inverse).max(initial=0.0)
    keep = np.abs(inverse) * NEVER > largest
    keep &= (inverse > 0) if signs == "positive" else True
    order = np.argsort(-np.abs(inverse[keep]))[:n]
    message = "" if keep.any() else "no load factor of that sign buckles this structure; the load only stiffens it"
    return BucklingResult(
        1.0 / inverse[keep][order], shapes[keep][order], Solution(system, start + answer, linear=True), message
    )


def _pencil(
    solver: DirectSolver, stiffness: BlockMatrix, geometric: BlockMatrix, constraints: Constraints, n: int, signs: str,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Inverse load factors, largest of the wanted sign and the largest in size, with their shapes (m, n_dofs)."""

    def projected(matrix: BlockMatrix, sign: float) -> LinearOperator:
        return LinearOperator(
            matrix.shape, matvec=lambda v: sign * constraints.free_part(matrix @ constraints.free_part(v)), dtype=np.float64
        )

    load, elastic = projected(geometric, -1.0), projected(stiffness, 1.0)
    if 2 * (n + 1) >= constraints.n_free:
        return _dense(stiffness, geometric, constraints)
    start = solver.solve(np.random.default_rng(0).standard_normal(stiffness.shape[0]))
    found = []
    for which, k in (("LM", n if signs == "both" else 1), ("LA", n)):
        if which == "LA" and signs == "both":
            break
        values, vectors = eigsh(
            load, k=k, M=elastic, Minv=LinearOperator(load.shape, matvec=solver.solve, dtype=np.float64), which=which,
            v0=start, tol=tolerance, ncv=min(constraints.n_free, max(2 * k + 1, 30)),
        )  # fmt: skip
        found.append((values, constraints_free(constraints, vectors.T)))
    if len(found) == 1:
        return found[0]
    (reference, shape), (values, shapes) = found
    # The largest of the other sign is kept for comparison only.
    if reference[0] < 0:
        return np.append(values, reference), np.vstack([shapes, shape])
    return values, shapes


def constraints_free(constraints: Constraints, vectors: np.ndarray) -> np.ndarray:
    """Each row of ``vectors`` on the free coordinates."""
    return np.array([constraints.free_part(v) for v in vectors])


def _dense(
    stiffness: BlockMatrix, geometric: BlockMatrix, constraints: Constraints
) -> tuple[np.ndarray, np.ndarray]:
    """For so few coordinates that Lanczos' method has no room: the same, with full matrices."""
    free = free_directions(constraints)
    elastic, load = (free @ matrix.to_scipy() @ free.T for matrix in (stiffness, geometric))
    root = np.linalg.cholesky(elastic)
    values, vectors = np.linalg.eigh(-np.linalg.solve(root, np.linalg.solve(root, load).T))
    return values, np.linalg.solve(root.T, vectors).T @ free
