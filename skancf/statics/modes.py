"""Small free vibrations about an equilibrium."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from skancf.assembly.system import System
from skancf.errors import InputError, SingularMatrix, positive
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.solution import Solution, require_same_mesh

# The shift that makes a free structure regular, relative to the smallest ratio of stiffness to mass on the diagonal: far
# above rounding, and no larger than the lowest frequency on meshes of up to a hundred elements along a side.
SHIFT = 1e-6
# An eigenvalue that is no larger than so many roundings of the terms of which it is the sum is zero.
ROUNDING = 64 * np.finfo(float).eps


@dataclass(frozen=True)
class Modes:
    r"""Outcome of :func:`modes`, in ascending order.

    Attributes
    ----------
    eigenvalues : (n,) array
        :math:`\omega^2` (1/s2). Negative where the equilibrium is not stable, zero for ``n_rigid`` motions without stiffness.
    shapes : (n, n_dofs) array
        Of unit modal mass, :math:`\phi^T M \phi = 1`, zero along prescribed coordinates.
    n_rigid : int
        Motions of which the stiffness is zero to rounding: rigid motions of a free structure, or a mechanism.
    n_unstable : int
        Negative eigenvalues.
    state : Solution
        The equilibrium.
    """

    eigenvalues: np.ndarray
    shapes: np.ndarray
    n_rigid: int
    n_unstable: int
    state: Solution

    @property
    def omega(self) -> np.ndarray:
        r"""Angular frequencies (rad/s), (n,); for an unstable motion, minus its rate of growth :math:`\sqrt{-\omega^2}`."""
        return np.sign(self.eigenvalues) * np.sqrt(np.abs(self.eigenvalues))

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies (Hz), (n,); negative as in ``omega``."""
        return self.omega / (2 * np.pi)

    def shape(self, i: int, size: float | None = None) -> Solution:
        """The equilibrium moved along mode ``i``, for pictures; ``size`` is the largest displacement of a node (m)."""
        return moved_along(self.state, self.shapes[i], size)


def modes(
    system: System, n: int = 6, *, state: Solution | None = None, tolerance: float = 1e-10, backend: str = "auto"
) -> Modes:
    r"""The lowest eigenfrequencies, :math:`K \phi = \omega^2 M \phi` with the tangent K of the undeformed state or of ``state``.

    Lanczos' method on :math:`(K - \sigma M)^{-1} M`, with :math:`\sigma = 0`, or a small negative number where K is singular.

    Parameters
    ----------
    n : int
        Number of modes.
    state : Solution, optional
        An equilibrium, of which the stresses and the loads' stiffness enter: prestressed vibration.
    tolerance : float
        Relative accuracy of the eigenvalues.

    Raises
    ------
    InputError
        For more modes than free coordinates.
    """
    if state is not None:
        require_same_mesh(system, state)
    state = state or Solution(system, system.undeformed.copy(), load_factor=0.0)
    n = checked_count(n, system.constraints)
    stiffness, mass = system.tangent(state.q, factor=state.load_factor), system.mass
    with DirectSolver(system.pattern, system.constraints, backend) as solver:
        shift, unstable = _factor(solver, stiffness, mass)
        wanted = n
        while True:
            wanted = min(max(wanted, n, unstable), system.constraints.n_free)
            values, shapes = _lanczos(solver, mass, system.constraints, wanted, shift, tolerance)
            if np.count_nonzero(values < 0) >= unstable or wanted == system.constraints.n_free:
                break
            wanted *= 2  # those nearest to zero came first: some of the unstable ones are farther
    values = np.array([phi @ (stiffness @ phi) for phi in shapes])
    size = BlockMatrix(stiffness.pattern, np.abs(stiffness.values))
    noise = ROUNDING * np.array([np.abs(phi) @ (size @ np.abs(phi)) for phi in shapes])
    rigid = np.abs(values) <= noise
    values[rigid] = 0.0
    order = np.argsort(values, kind="stable")[:n]
    return Modes(
        values[order], shapes[order], int(np.count_nonzero(rigid)), int(np.count_nonzero(values < 0)), state
    )


def _factor(solver: DirectSolver, stiffness: BlockMatrix, mass: BlockMatrix) -> tuple[float, int]:
    """Factor K, or K - shift M where K is singular: the shift and the number of eigenvalues below it."""
    try:
        solver.factor(stiffness)
        shift = 0.0
    except SingularMatrix:
        k, m = np.abs(stiffness.diagonal()), mass.diagonal()
        shift = -SHIFT * float((k[k > 0] / m[k > 0]).min())
        solver.factor(stiffness + (-shift) * mass)
    return shift, solver.negative_pivots


def _lanczos(
    solver: DirectSolver, mass: BlockMatrix, constraints: Constraints, n: int, shift: float, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues nearest to the shift and their shapes (n, n_dofs), of unit modal mass."""

    def with_mass(v: np.ndarray) -> np.ndarray:
        return constraints.free_part(mass @ constraints.free_part(v))

    shape = mass.shape
    if 2 * n >= constraints.n_free:
        return _dense(solver.solve, with_mass, constraints, n, shift)
    start = solver.solve(with_mass(np.random.default_rng(0).standard_normal(shape[0])))
    inverse = LinearOperator(shape, matvec=solver.solve, dtype=np.float64)
    weight = LinearOperator(shape, matvec=with_mass, dtype=np.float64)
    # In shift-and-invert mode the first operator is not used.
    values, vectors = eigsh(
        weight, k=n, M=weight, sigma=shift, OPinv=inverse, v0=start, tol=tolerance,
        ncv=min(constraints.n_free, max(2 * n + 1, 20)),
    )  # fmt: skip
    return values, np.array([normalised(constraints.free_part(v), with_mass) for v in vectors.T])


def _dense(
    solve: Callable[[np.ndarray], np.ndarray], with_mass: Callable[[np.ndarray], np.ndarray], constraints: Constraints,
    n: int, shift: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """For so many modes of so few coordinates that Lanczos' method has no room: the same, with full matrices."""
    free = free_directions(constraints)
    mass = np.array([free @ with_mass(v) for v in free])
    root = np.linalg.cholesky((mass + mass.T) / 2)
    flexibility = np.array([free @ solve(v) for v in free])
    inverse, vectors = np.linalg.eigh(root.T @ (flexibility + flexibility.T) / 2 @ root)
    near = np.argsort(-np.abs(inverse))[:n]
    shapes = np.linalg.solve(root.T, vectors[:, near]).T @ free
    return shift + 1.0 / inverse[near], np.array([normalised(v, with_mass) for v in shapes])


def checked_count(n: int, constraints: Constraints) -> int:
    """n as a whole number from one to the number of free coordinates, or InputError."""
    positive("n", n)
    if int(n) != n or n > constraints.n_free:
        raise InputError(f"n = {n}: give a whole number of modes, at most the {constraints.n_free} free coordinates")
    return int(n)


def free_directions(constraints: Constraints) -> np.ndarray:
    """Unit vectors along the free coordinates, (n_free, n_dofs)."""
    numbers = np.flatnonzero(~constraints.fixed.ravel())
    return np.array([constraints.from_frame(e) for e in np.eye(constraints.fixed.size)[numbers]])


def normalised(v: np.ndarray, with_mass: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """v of unit modal mass, its largest entry positive."""
    return v / np.sqrt(v @ with_mass(v)) * np.sign(v[np.argmax(np.abs(v))])


def moved_along(state: Solution, mode: np.ndarray, size: float | None) -> Solution:
    """A state moved along a mode until its nodes moved by ``size`` at most; by default a tenth of the structure's extent."""
    r = state.system.undeformed.reshape(-1, 4, 3)[:, 0]
    size = 0.1 * float(np.linalg.norm(np.ptp(r, axis=0))) if size is None else positive("size", size, "m")
    largest = float(np.linalg.norm(mode.reshape(-1, 4, 3)[:, 0], axis=1).max())
    return Solution(state.system, state.q + size / largest * mode, load_factor=state.load_factor)
