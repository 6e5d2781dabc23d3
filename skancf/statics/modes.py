"""Small free vibrations about an equilibrium."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

from skancf.arguments import whole
from skancf.assembly.system import System
from skancf.errors import DidNotConverge, InputError, number, positive
from skancf.linear import BlockMatrix, Constraints, DirectSolver
from skancf.memory import require_much
from skancf.solution import Solution, require_same_mesh
from skancf.statics.asked import check_asked
from skancf.statics.soft import factor_shifted
from skancf.statics.tangents import state_tangent, warn_if_skew
from skancf.thinness import warn_if_mass_is_off

# Two eigenvalues that differ less than this, relatively, are not told apart when they are counted.
SEPARATION = 1e-6
# An eigenvalue that is no larger than so many roundings of the terms of which it is the sum is zero: rigid motions of free
# plates, L/h from 10 to 10^4, have up to 1500, their softest elastic one a million and more.
ROUNDING = 1e4 * np.finfo(float).eps


@dataclass(frozen=True)
class Modes:
    r"""Outcome of :func:`modes`, in ascending order.

    Attributes
    ----------
    eigenvalues : (n,) array
        :math:`\omega^2` (1/s2). Negative where the equilibrium is not stable, zero for motions without stiffness.
    shapes : (n, n_dofs) array
        Of unit modal mass, :math:`\phi^T M \phi = 1`, zero along prescribed coordinates.
    n_rigid : int
        Motions of which the stiffness is zero to rounding: rigid motions of a free structure, or a mechanism.
    n_unstable : int
        Negative eigenvalues, all of them even if more than n.
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
        return moved_along(self.state, nth(self.shapes, i), size)


def modes(
    system: System, n: int = 6, *, state: Solution | None = None, tolerance: float = 1e-10, backend: str = "auto"
) -> Modes:
    r"""Lowest frequencies, :math:`K \phi = \omega^2 M \phi`, K being the tangent of the undeformed state or ``state``.

    Lanczos' method on :math:`(K - \sigma M)^{-1} M`, with :math:`\sigma = 0`, or a small negative number where K is
    singular; Sylvester's law of inertia shows that no eigenvalue is missing.

    Parameters
    ----------
    n : int
        Number of modes.
    state : Solution, optional
        An equilibrium, of which the stresses and the loads' stiffness enter: prestressed vibration. About a linear answer
        K is that of :func:`buckling`, of the undeformed place with the first-order stresses.
    tolerance : float
        Relative accuracy of the eigenvalues.

    Raises
    ------
    InputError
        For more modes than free coordinates.

    Warns
    -----
    OutOfDepth
        Where loads follow a free edge: only the symmetric part of K is taken, and flutter is not found.
    """
    check_asked(system, backend)
    if state is not None:
        require_same_mesh(system, state, "state")
    check_tolerance(tolerance)
    warn_if_mass_is_off(system)
    n = checked_count(n, system.constraints)
    stiffness = state_tangent(system, state)
    state = state or Solution(system, system.undeformed.copy(), load_factor=0.0)
    warn_if_skew(system, stiffness, system.undeformed if state.linear else state.q, state.load_factor)
    with DirectSolver(system.pattern, system.constraints, backend) as solver:
        values, shapes = _Spectrum(solver, stiffness, system.mass, system.constraints, tolerance).lowest(n)
    order = np.argsort(values, kind="stable")[:n]
    return Modes(values[order], shapes[order], int((values == 0).sum()), int((values < 0).sum()), state)


class _Spectrum:
    """Eigenpairs of K against M."""

    def __init__(
        self, solver: DirectSolver, stiffness: BlockMatrix, mass: BlockMatrix, constraints: Constraints, tolerance: float
    ) -> None:
        self.solver, self.stiffness, self.mass, self.constraints = solver, stiffness, mass, constraints
        self.tolerance = tolerance

    def lowest(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """At least the n lowest; values (m,) and shapes (m, n_dofs) in no order.

        Lanczos' method may pass over one of several equal eigenvalues, or a negative one far from the shift. By Sylvester's
        law the pivots of K - s M count those below s, and what is missing is looked for beside what was found.
        """
        if 2 * (n + 1) >= self.constraints.n_free:
            return self._clean(self._dense())
        shift = factor_shifted(self.solver, self.stiffness, self.mass)
        shapes = np.zeros((0, self.mass.shape[0]))
        missing = n
        while missing and len(shapes) + missing < self.constraints.n_free:
            shapes = np.vstack([shapes, self._lanczos(missing + 1, shift, shapes)])
            values, shapes = self._clean(shapes)
            top = values.max() - SEPARATION * abs(values.max())
            missing = 0
            if values.max() != 0:
                self.solver.factor(self.stiffness + (-float(top)) * self.mass)
                missing = max(0, self.solver.negative_pivots - int((values < top).sum()))
            if missing:
                self.solver.factor(self.stiffness + (-shift) * self.mass)
        return values, shapes

    def _lanczos(self, n: int, shift: float, known: np.ndarray) -> np.ndarray:
        """Shapes (n, n_dofs) of the eigenvalues nearest to the shift, beside the known ones."""

        def apart(v: np.ndarray) -> np.ndarray:
            return v - known.T @ (known @ self.with_mass(v))

        start = self.with_mass(np.random.default_rng(len(known)).standard_normal(self.mass.shape[0]))
        weight = LinearOperator(self.mass.shape, matvec=self.with_mass, dtype=np.float64)
        # In shift-and-invert mode the first operator is not used.
        return lanczos(
            weight, k=n, M=weight, sigma=shift, v0=apart(self.solver.solve(start)), tol=self.tolerance,
            OPinv=LinearOperator(self.mass.shape, matvec=lambda v: apart(self.solver.solve(v)), dtype=np.float64),
            ncv=min(self.constraints.n_free, max(2 * n + 1, 20)),
        )[1]  # fmt: skip

    def _dense(self) -> np.ndarray:
        """All, for so many modes of so few coordinates that Lanczos' method has no room."""
        free = free_directions(self.constraints)
        stiffness, mass = (free @ matrix.to_scipy() @ free.T for matrix in (self.stiffness, self.mass))
        return eigh(stiffness, mass)[1].T @ free

    def _clean(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values, zero where they are rounding, and shapes of unit modal mass on the free coordinates."""
        shapes = np.array([self._normalised(self.constraints.free_part(v)) for v in shapes])
        sizes = BlockMatrix(self.stiffness.pattern, np.abs(self.stiffness.values))
        values = np.array([v @ (self.stiffness @ v) for v in shapes])
        noise = ROUNDING * np.array([np.abs(v) @ (sizes @ np.abs(v)) for v in shapes])
        return np.where(np.abs(values) <= noise, 0.0, values), shapes

    def _normalised(self, v: np.ndarray) -> np.ndarray:
        return v / np.sqrt(v @ self.with_mass(v)) * np.sign(v[np.argmax(np.abs(v))])

    def with_mass(self, v: np.ndarray) -> np.ndarray:
        return self.constraints.free_part(self.mass @ self.constraints.free_part(v))


def lanczos(matrix: LinearOperator, **options: Any) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (k,) and eigenvectors (k, n) by scipy's ``eigsh``, or :class:`~skancf.DidNotConverge`."""
    try:
        values, vectors = eigsh(matrix, **options)
    except ArpackNoConvergence as none:
        raise DidNotConverge(
            f"Lanczos' method found {len(none.eigenvalues)} of {options['k']} eigenvalues; ask for fewer, or allow a larger "
            f"tolerance than {options['tol']}"
        ) from none
    except ArpackError as broken:
        raise DidNotConverge(f"Lanczos' method broke down ({broken}): stiffness or mass is zero to rounding, or too large; "
                             "give the problem in units in which its numbers are of moderate size") from broken  # fmt: skip
    return values, vectors.T


def nth(shapes: np.ndarray, i: int) -> np.ndarray:
    """One of some shapes; from the last one on where i is negative."""
    if not -len(shapes) <= whole("i", i, least=-len(shapes)) < len(shapes):
        raise InputError(f"i = {i}: there are {len(shapes)} modes, numbered from 0; ask for more by n")
    return np.asarray(shapes[int(i)])


def checked_count(n: int, constraints: Constraints) -> int:
    """n as a whole number from one to the number of free coordinates, or InputError."""
    n = whole("n", n, floats=True)
    if n > constraints.n_free:
        raise InputError(f"n = {n}: give a whole number of modes, at most the {constraints.n_free} free coordinates")
    # Lanczos' method keeps two vectors for each mode and one more; without room for it all are found.
    each = 3 * constraints.fixed.size if 2 * (n + 1) < constraints.n_free else 4 * constraints.n_free
    require_much(8 * n * each, f"n = {n} modes of {constraints.fixed.size} unknowns", "their shapes", "ask for fewer")
    return n


def check_tolerance(tolerance: float) -> None:
    """InputError for what is no relative accuracy of eigenvalues, from zero (rounding) to less than one."""
    if not 0 <= number("tolerance", tolerance) < 1:
        raise InputError(f"tolerance = {tolerance}: give the relative accuracy of the eigenvalues, less than one")


def free_directions(constraints: Constraints) -> np.ndarray:
    """Unit vectors along the free coordinates, (n_free, n_dofs)."""
    numbers = np.flatnonzero(~constraints.fixed.ravel())
    return np.array([constraints.from_frame(e) for e in np.eye(constraints.fixed.size)[numbers]])


def moved_along(state: Solution, mode: np.ndarray, size: float | None) -> Solution:
    """A state moved along a mode until its nodes moved by ``size`` at most; by default a tenth of the structure's extent."""
    r = state.system.undeformed.reshape(-1, 4, 3)[:, 0]
    size = 0.1 * float(np.linalg.norm(np.ptp(r, axis=0))) if size is None else positive("size", size, "m")
    largest = float(np.linalg.norm(mode.reshape(-1, 4, 3)[:, 0], axis=1).max())
    return Solution(state.system, state.q + size / largest * mode, load_factor=state.load_factor)
