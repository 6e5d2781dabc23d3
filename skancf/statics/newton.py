r"""Newton's method with the mixed-integration-point tangent.

The tangent is taken with the stresses extrapolated linearly along the last step,
:math:`\sigma_{j+1} = C(\varepsilon(q_j) + B(q_j)\,\delta q_j)`, instead of those of the present state; the residual is the
exact one (Magisano, Leonetti and Garcea, 2017). With a :class:`Constraint` the load factor is an unknown too.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from skancf.errors import DidNotConverge
from skancf.history import FULL, Case
from skancf.linear import BlockMatrix, BlockPattern, Constraints, DirectSolver, SkewSolver
from skancf.solving import End, Status, iterate
from skancf.statics.stopping import Constraint, ConvergenceTest, Pull, moves, work


class StaticSystem(Protocol):
    """All that statics knows of a model.

    A model may also have ``strain_energy(q, case)``, by which the end of a solve is judged; ``skew(q, case)``, the
    skew-symmetric part of its tangent as a sparse matrix or None; ``others``, sums over terms beside a shell; a ``layout``,
    by which it knows rigid motions; and a ``shell``, which knows how far slopes turn and which elements folded.
    """

    constraints: Constraints
    undeformed: np.ndarray
    pattern: BlockPattern

    @property
    def mass(self) -> BlockMatrix: ...
    def internal_force(self, q: np.ndarray) -> np.ndarray: ...
    def external_force(self, q: np.ndarray, case: Case = FULL) -> np.ndarray: ...
    def stresses(self, q: np.ndarray, change: np.ndarray | None = None) -> np.ndarray: ...
    def tangent(
        self, q: np.ndarray, case: Case = FULL, stresses: np.ndarray | None = None
    ) -> BlockMatrix: ...
    def prescribed(self, case: Case = FULL) -> np.ndarray: ...


@dataclass(frozen=True)
class NewtonResult:
    """Outcome of one solve.

    ``residual_norms`` are energy norms of the residual, sqrt(R . K^-1 R), relative to the largest one met; with a
    constraint they belong to the correction that meets both equations. ``along`` is then the derivative of q with respect
    to the load factor. ``bound`` is the part of the energy norm that rounding leaves open, where that ended the solve.
    """

    q: np.ndarray
    status: Status
    residual_norms: tuple[float, ...]
    negative_pivots: int = 0
    message: str = ""
    load_factor: float = 1.0
    along: np.ndarray | None = None
    bound: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether it is an equilibrium."""
        return self.status.ok

    @property
    def iterations(self) -> int:
        return len(self.residual_norms)

    def unwrap(self) -> np.ndarray:
        """q, or :class:`~skancf.DidNotConverge`."""
        if not self.ok:
            tail = ", ".join(f"{r:.1e}" for r in self.residual_norms[-3:])
            raise DidNotConverge(f"newton: {self.status.value}; residual ... {tail}. {self.message}", self.residual_norms)
        return self.q


# A mixed solve that converges loses energy from its third iteration on. One that gains so much in an iteration has left its
# way: half of the load takes fewer iterations than waiting for it to return.
GIVEN_UP = 10.0
# The plain method may gain much more before it converges: this is over its first iteration.
GROWN = 1e8
# An answer that rounding leaves open by more than this part of its energy norm is not called converged.
OPEN = 1e-2
LOST = "rounding of the nodal coordinates leaves up to {:.1e} of the energy norm open"
FAR = "the first correction turns a slope by {:.2g} of its length, more than the {:.2g} from which a solve is worth trying"


def skew_part(system: Any, q: np.ndarray, load_factor: float) -> sp.csr_matrix | None:
    """Skew-symmetric part of the tangent at (q, load factor); None if there is none."""
    hook: Any = getattr(system, "skew", None)
    return hook(q, Case(load_factor)) if hook and (load_factor or getattr(system, "others", None)) else None


def factored(
    system: StaticSystem, q: np.ndarray, load_factor: float, solver: DirectSolver, stresses: np.ndarray | None = None,
    pull: Pull | None = None,
) -> SkewSolver:  # fmt: skip
    """The tangent at (q, load factor), with ``stresses`` and that of a ``pull`` if given, and its solver.

    Raises
    ------
    SingularMatrix
    """
    matrix = system.tangent(q, Case(load_factor), stresses)
    if pull:
        matrix = matrix + pull.strength * pull.metric
    solver.factor(matrix)
    return SkewSolver(matrix, skew_part(system, q, load_factor), solver)


def along_load(system: StaticSystem, q: np.ndarray, tangent: SkewSolver) -> np.ndarray:
    """Derivative of q with respect to the load factor."""
    force, moved = system.external_force(q), system.prescribed()
    return tangent.solve(force - tangent.multiply(moved) if moved.any() else force) + moved


def newton(
    system: StaticSystem,
    q: np.ndarray,
    solver: DirectSolver,
    *,
    load_factor: float = 1.0,
    rtol: float = 1e-7,
    max_steps: int = 30,
    mixed: bool = True,
    watch: Callable[[int, float], None] | None = None,
    constraint: Constraint | None = None,
    stresses: np.ndarray | None = None,
    origin: np.ndarray | None = None,
    pull: Pull | None = None,
    farthest: float = np.inf,
) -> NewtonResult:
    """Equilibrium under ``load_factor`` times the loads and prescribed displacements, from a first guess.

    When it may end, and by which energies, says :class:`~skancf.statics.stopping.ConvergenceTest`.

    Parameters
    ----------
    q : (n_dofs,) array
        First guess.
    load_factor : float
        With a constraint, the first guess of it.
    mixed : bool
        Mixed-integration-point tangent; False is the plain method.
    watch : callable, optional
        Called with the step's number and the relative norm.
    constraint : Constraint, optional
    stresses : array, optional
        Those of the first tangent, extrapolated to the guess from an equilibrium; otherwise those of the guess.
    origin : (n_dofs,) array, optional
        Where the way began by which corrections are measured. Default: the first guess.
    pull : Pull, optional
        A pretension that holds the state back.
    farthest : float
        Give up after a first correction that turns a slope by more than this, relative to its length.
    """
    tangents = _Tangents(system, solver, mixed, stresses, pull, constraint)
    begin = constraint.origin if constraint else q if origin is None else origin
    criterion = _StopCriterion(tangents, ConvergenceTest(system, begin, rtol, pull, constraint), farthest, watch)
    found = iterate(np.append(q, load_factor), tangents, criterion, max_steps)
    energies = [energy for energy in found.energies if np.isfinite(energy)]
    largest = max(energies, default=1.0) or 1.0
    norms = tuple(float(np.sqrt(energy / largest)) for energy in energies)
    lost = found.status is Status.NOT_FINITE and not found.message
    message = refusal(system) or _where(system, found.residual) if lost else found.message
    pivots = solver.negative_pivots if energies and found.status is not Status.SINGULAR else 0
    lam, bound = float(found.x[-1]), criterion.bound
    return NewtonResult(found.x[:-1], found.status, norms, pivots, message, lam, tangents.along, bound)


class _Tangents:
    """The tangent of every state: the mixed one, of stresses extrapolated along the last step, or the plain one.

    The unknowns are q and the load factor, which only a constraint changes.
    """

    tangent: SkewSolver
    force: np.ndarray
    moved: np.ndarray

    def __init__(
        self, system: StaticSystem, solver: DirectSolver, mixed: bool, stresses: np.ndarray | None, pull: Pull | None,
        constraint: Constraint | None,
    ) -> None:  # fmt: skip
        self.system, self.solver, self.mixed, self.stresses = system, solver, mixed, stresses
        self.pull, self.constraint, self.prescribed = pull, constraint, system.prescribed()
        self.along: np.ndarray | None = None

    def residual(self, x: np.ndarray) -> np.ndarray:
        q, load_factor = x[:-1], float(x[-1])
        self.force = load_factor * self.system.external_force(q)
        residual = self.system.internal_force(q) - self.force
        return residual + self.pull.force(q) if self.pull else residual

    def correction(self, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, float]:
        """By the work of the residual; with a constraint by that of the tangent on the correction."""
        q, load_factor, system = x[:-1], float(x[-1]), self.system
        self.tangent = tangent = factored(system, q, load_factor, self.solver, self.stresses, self.pull)
        self.moved = moved = system.constraints.fixed_part(system.undeformed + load_factor * self.prescribed - q)
        rhs = -(residual + tangent.multiply(moved)) if moved.any() else -residual
        free = tangent.solve(rhs)
        if self.constraint is None:
            return np.append(free + moved, 0.0), work(free, rhs)
        self.along = along = along_load(system, q, tangent)
        change = free + moved
        more = self.constraint.correction(q + change, load_factor, along)
        change = change + more * along if np.isfinite(more) else np.full_like(q, np.inf)
        return np.append(change, more), work(change, tangent.multiply(change))

    def step(self, x: np.ndarray, residual: np.ndarray, change: np.ndarray) -> np.ndarray:
        self.stresses = self.system.stresses(x[:-1], change[:-1]) if self.mixed else None
        return x + change


@dataclass
class _StopCriterion:
    """When equilibrium is reached, and when an iteration is given up; ``bound`` is what rounding then leaves open."""

    tangents: _Tangents
    stop: ConvergenceTest
    farthest: float
    watch: Callable[[int, float], None] | None
    bound: float = 0.0

    def assess(self, x: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        """How it ends with a correction."""
        tangents, energy, count = self.tangents, energies[-1], len(energies)
        if self.watch:
            self.watch(count - 1, float(np.sqrt(energy / max(energies))) if energy else 0.0)
        if not np.isfinite(energy):
            return Status.NOT_FINITE, _where(tangents.system, change[:-1])
        if count == 1 and self.farthest < np.inf and not tangents.moved.any():
            turn = largest_turn(tangents.system, change[:-1])
            if turn > self.farthest:
                return Status.TOO_FAR, FAR.format(turn, self.farthest)
        verdict = self.stop.assess(tangents.tangent, energies, x[:-1], change[:-1], float(x[-1] + change[-1]))
        if verdict.last:
            moves_free = moves(tangents.system.constraints, tangents.force)
            relevant = moves_free or (tangents.prescribed.any() and not verdict.rigid)
            self.bound = lost = verdict.bound if relevant else 0.0
            return Status.ROUNDING if lost > OPEN else Status.CONVERGED, LOST.format(lost) if lost else ""
        grew = count > 3 and energy > (GIVEN_UP * energies[-2] if tangents.mixed else GROWN * energies[0]) + verdict.floor
        return (Status.DIVERGED, "") if grew else None


def largest_turn(system: Any, change: np.ndarray) -> float:
    """Largest change of a slope, relative to its undeformed length; zero for models without slopes."""
    shell = getattr(system, "shell", None)
    return shell.largest_turn(change) if shell else 0.0


def refusal(system: Any) -> str | None:
    """Where and why a law had no stress for the last state; None where it had, and for models without one."""
    shell = getattr(system, "shell", None)
    said: str | None = shell.assembly.refusal() if shell else None
    return said


def _where(system: StaticSystem, values: np.ndarray) -> str:
    node = int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf))) // system.pattern.block
    place = ", ".join(f"{x:.4g}" for x in system.pattern.coordinates[:, node])
    return f"first at the node that was at ({place})"
