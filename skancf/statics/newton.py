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

from skancf.errors import DidNotConverge, SingularMatrix
from skancf.history import FULL, Case
from skancf.linear import BlockMatrix, BlockPattern, Constraints, DirectSolver, SkewSolver
from skancf.solving import Status
from skancf.statics.stopping import Constraint, Pull, StopRule, moves, work


class System(Protocol):
    """All that statics knows of a model.

    A model may also have ``strain_energy(q, case)``, by which the end of a solve is judged; ``largest_turn(change)``, the
    largest change of a slope; ``pretension``, the stiffness of a uniform dilation; ``skew(q, case)``, the
    skew-symmetric part of its tangent as a sparse matrix or None; ``folded(q)``, the number and the place of an element that
    folded or None; ``foundation``, its springs as a matrix or None; ``plain_stiffness()``, that of the undeformed state with
    membrane strains as they are; and ``free_rigid_motions()``, those that nothing holds, in words.
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
# An answer that rounding leaves open by more than this part of its energy norm is not called converged.
OPEN = 1e-2
LOST = "rounding of the nodal coordinates leaves up to {:.1e} of the energy norm open"
FAR = "the first correction turns a slope by {:.2g} of its length, more than the {:.2g} from which a solve is worth trying"


def skew_part(system: System, q: np.ndarray, load_factor: float) -> sp.csr_matrix | None:
    """Skew-symmetric part of the tangent at (q, load factor); None if there is none."""
    hook: Any = getattr(system, "skew", None)
    return hook(q, Case(load_factor)) if hook and load_factor else None


def factored(
    system: System, q: np.ndarray, load_factor: float, solver: DirectSolver, stresses: np.ndarray | None = None,
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


def along_load(system: System, q: np.ndarray, tangent: SkewSolver) -> np.ndarray:
    """Derivative of q with respect to the load factor."""
    force, moved = system.external_force(q), system.prescribed()
    return tangent.solve(force - tangent.multiply(moved) if moved.any() else force) + moved


def newton(
    system: System,
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

    When it may end, and by which energies that is judged, says :class:`~skancf.statics.stopping.StopRule`.

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
    prescribed = system.prescribed()
    begin = q if origin is None else origin
    rule = StopRule(system, constraint.origin if constraint else begin, rtol, pull, constraint)
    energies: list[float] = []
    along: np.ndarray | None = None

    def result(status: Status, message: str = "", bound: float = 0.0) -> NewtonResult:
        largest = max(energies, default=1.0) or 1.0
        norms = tuple(float(np.sqrt(e / largest)) for e in energies)
        pivots = solver.negative_pivots if energies and status is not Status.SINGULAR else 0
        return NewtonResult(q, status, norms, pivots, message, load_factor, along, bound)

    for step in range(max_steps):
        force = load_factor * system.external_force(q)
        residual = system.internal_force(q) - force
        if pull:
            residual = residual + pull.force(q)
        if not np.isfinite(residual).all():
            return result(Status.NOT_FINITE, _where(system, residual))
        try:
            tangent = factored(system, q, load_factor, solver, stresses, pull)
            moved = system.constraints.fixed_part(system.undeformed + load_factor * prescribed - q)
            rhs = -(residual + tangent.multiply(moved)) if moved.any() else -residual
            free = tangent.solve(rhs)
            along = along_load(system, q, tangent) if constraint else None
        except SingularMatrix as singular:
            return result(Status.SINGULAR, str(singular))
        change, more = free + moved, 0.0
        if constraint and along is not None:
            more = constraint.correction(q + change, load_factor, along)
            change = change + more * along if np.isfinite(more) else np.full_like(q, np.inf)
        energies.append(work(change, tangent.multiply(change)) if constraint else work(free, rhs))
        if watch:
            watch(step, float(np.sqrt(energies[-1] / max(energies))) if energies[-1] else 0.0)
        if not np.isfinite(energies[-1]):
            energies.pop()
            return result(Status.NOT_FINITE, _where(system, change))
        if step == 0 and farthest < np.inf and not moved.any() and (turn := largest_turn(system, change)) > farthest:
            return result(Status.TOO_FAR, FAR.format(turn, farthest))
        verdict = rule.judge(tangent, energies, q, change, load_factor + more)
        if verdict.last:
            q, load_factor = q + change, load_factor + more
            asked = moves(system.constraints, force) or (prescribed.any() and not verdict.rigid)
            lost = verdict.bound if asked else 0.0
            return result(Status.ROUNDING if lost > OPEN else Status.CONVERGED, LOST.format(lost) if lost else "", lost)
        if step > 2 and energies[-1] > (GIVEN_UP if mixed else 1e8) * energies[-2 if mixed else 0] + verdict.floor:
            return result(Status.DIVERGED)
        stresses = system.stresses(q, change) if mixed else None
        q, load_factor = q + change, load_factor + more
    return result(Status.STEPS_SPENT)


def largest_turn(system: Any, change: np.ndarray) -> float:
    """Largest change of a slope, relative to its undeformed length; zero for models without slopes."""
    hook = getattr(system, "largest_turn", None)
    return hook(change) if hook else 0.0


def _where(system: System, values: np.ndarray) -> str:
    node = int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf))) // system.pattern.block
    place = ", ".join(f"{x:.4g}" for x in system.pattern.coordinates[:, node])
    return f"first at the node that was at ({place})"
