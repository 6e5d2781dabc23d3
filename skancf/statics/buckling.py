"""Linear buckling: the load factors at which an undeformed structure loses its stiffness."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator

from skancf.arguments import choice
from skancf.assembly.system import System
from skancf.errors import InputError
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.solution import Solution
from skancf.statics.asked import check_asked
from skancf.statics.causes import require_support
from skancf.statics.modes import check_tolerance, checked_count, free_directions, lanczos, moved_along, nth
from skancf.statics.tangents import linear_tangent, warn_if_skew

# A load factor that is so many times the smallest one of either sign counts as infinite.
NEVER = 1e4
# Membrane strains as they are may ask for this much more of the load before a mesh is called too coarse.
COARSE = 0.15


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
        That no load factor buckles the structure, if none does; or that the mesh is too coarse for a mode, where assumed
        membrane strains (theory `kirchhoff`) and those as they are do not agree in it.
    """

    load_factors: np.ndarray
    shapes: np.ndarray
    linear: Solution
    message: str = ""

    def shape(self, i: int, size: float | None = None) -> Solution:
        """The undeformed structure moved along mode ``i``; ``size`` is the largest displacement of a node (m)."""
        start = Solution(self.linear.system, self.linear.system.undeformed.copy(), load_factor=0.0)
        return moved_along(start, nth(self.shapes, i), size)


def buckling(
    system: System, n: int = 4, *, signs: str = "positive", tolerance: float = 1e-10, backend: str = "auto"
) -> BucklingResult:
    r"""Load factors :math:`\lambda` with :math:`(K_0 + \lambda K_\sigma)\,\phi = 0`.

    :math:`K_0` is the tangent of the undeformed state, and :math:`K_\sigma` the change of it by the stresses of the linear
    answer to the whole load, and by the loads' own stiffness. It is exact where the structure hardly moves before it
    buckles; :func:`trace` finds the load in general. Lanczos' method solves
    :math:`-K_\sigma \phi = \lambda^{-1} K_0 \phi`.

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

    Warns
    -----
    OutOfDepth
        Where loads follow a free edge: only the symmetric part of their stiffness is taken, and flutter is not found.
    """
    check_asked(system, backend)
    check_tolerance(tolerance)
    choice("signs", signs, ("positive", "both"))
    n = checked_count(n, system.constraints)
    require_support(system)
    start, constraints = system.undeformed, system.constraints
    moved = system.prescribed()
    if not (system.external_force(start).any() or moved.any()):
        raise InputError("no buckling: nothing loads the structure; give a load or a prescribed displacement")
    stiffness = system.stiffness()
    warn_if_skew(system, stiffness, start, 1.0)
    with DirectSolver(system.pattern, constraints, backend) as solver:
        solver.factor(stiffness)
        answer = solver.solve(system.external_force(start) - stiffness @ moved, refinements=2) + moved
        if not answer.any():
            raise InputError("no buckling: the supports take the whole load, nothing is strained; free the edges it acts on")
        geometric = linear_tangent(system, answer) + (-1.0) * stiffness
        pencil = _Pencil(solver, stiffness, geometric, constraints, tolerance)
        inverse, shapes = pencil.positive(n) if signs == "positive" else pencil.largest(n)
    order = np.argsort(-np.abs(inverse))[:n]
    message = "no positive load factor buckles this structure; the load only stiffens it"
    if order.size:
        message = _coarse(system, stiffness, shapes[order])
    return BucklingResult(1.0 / inverse[order], shapes[order], Solution(system, start + answer, linear=True), message)


def _coarse(system: System, stiffness: BlockMatrix, shapes: np.ndarray) -> str:
    """That the mesh is too coarse for some shapes: assumed membrane strains and those as they are do not agree in them."""
    hook = getattr(system, "plain_stiffness", None)
    if hook is None:
        return ""
    plain = hook()
    ratios = np.array([float(x @ (plain @ x)) / float(x @ (stiffness @ x)) for x in shapes])
    if ratios.max() < 1 + COARSE:
        return ""
    worst = int(np.argmax(ratios))
    return (
        f"the mesh is too coarse for the waves of mode {worst}: with membrane strains as they are it would need "
        f"{ratios[worst]:.3g} times the load; the truth lies between, take a finer mesh"
    )


class _Pencil:
    """Inverse load factors and their shapes: eigenpairs of minus the geometric stiffness against the elastic one."""

    def __init__(
        self, solver: DirectSolver, stiffness: BlockMatrix, geometric: BlockMatrix, constraints: Constraints,
        tolerance: float,
    ) -> None:  # fmt: skip
        self.solver, self.stiffness, self.geometric = solver, stiffness, geometric
        self.constraints, self.tolerance = constraints, tolerance

    def largest(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """The n largest in size."""
        return self._lanczos(n, "LM")

    def positive(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """The n largest, or as many as are positive."""
        reference = 1.0 / np.abs(self.largest(1)[0][0])
        # Sylvester: each load factor between 0 and this one makes one eigenvalue of the sum negative.
        self.solver.factor(self.stiffness + (NEVER * float(reference)) * self.geometric)
        exist = self.solver.negative_pivots
        self.solver.factor(self.stiffness)
        if not exist:
            return np.zeros(0), np.zeros((0, self.stiffness.shape[0]))
        return self._lanczos(min(n, exist), "LA")

    def _lanczos(self, n: int, which: str) -> tuple[np.ndarray, np.ndarray]:
        if 2 * n >= self.constraints.n_free:
            values, shapes = _dense(self.stiffness, self.geometric, self.constraints)
            best = np.argsort(-values if which == "LA" else -np.abs(values))[:n]
            return values[best], shapes[best]
        shape = self.stiffness.shape
        start = self.solver.solve(np.random.default_rng(0).standard_normal(shape[0]))
        values, vectors = lanczos(
            self._projected(self.geometric, -1.0), k=n, M=self._projected(self.stiffness, 1.0), which=which, v0=start,
            Minv=LinearOperator(shape, matvec=self.solver.solve, dtype=np.float64), tol=self.tolerance,
            ncv=min(self.constraints.n_free, max(2 * n + 1, 30)),
        )  # fmt: skip
        return values, np.array([self.constraints.free_part(v) for v in vectors])

    def _projected(self, matrix: BlockMatrix, sign: float) -> LinearOperator:
        keep = self.constraints.free_part
        return LinearOperator(matrix.shape, matvec=lambda v: sign * keep(matrix @ keep(v)), dtype=np.float64)


def _dense(
    stiffness: BlockMatrix, geometric: BlockMatrix, constraints: Constraints
) -> tuple[np.ndarray, np.ndarray]:
    """For so few coordinates that Lanczos' method has no room: the same, with full matrices."""
    free = free_directions(constraints)
    elastic, load = (free @ matrix.to_scipy() @ free.T for matrix in (stiffness, geometric))
    values, vectors = eigh(-load, elastic)
    return values, vectors.T @ free
