r"""Newton's method with the mixed-integration-point tangent.

The tangent is taken with the stresses extrapolated linearly along the last step,
:math:`\sigma_{j+1} = C(\varepsilon(q_j) + B(q_j)\,\delta q_j)`, instead of those of the present state; the residual is the
exact one (Magisano, Leonetti and Garcea, 2017). With a :class:`Constraint` the load factor is an unknown too.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.equality import by_value
from skancf.errors import DidNotConverge
from skancf.linear import DirectSolver
from skancf.showing import short
from skancf.solving import End, Status, iterate
from skancf.statics.conditioned import tangents_of
from skancf.statics.corrections import StaticSystem, Tangents, none
from skancf.statics.stopping import Constraint, ConvergenceTest, Pull, moves

logger = logging.getLogger(__name__)


@by_value
@dataclass(frozen=True)
class NewtonResult:
    """Outcome of one solve.

    ``residual_norms`` are energy norms of the residual, sqrt(R . K^-1 R), relative to the largest one met; with a
    constraint they belong to the correction that meets both equations. ``along`` is then the derivative of q with respect
    to the load factor. ``bound`` is the part of the energy norm that rounding leaves open, where that ended the solve.
    ``multipliers`` are those of the conditions, (n,), and ``pulled`` their derivative with respect to the load factor.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> load_factor, attempt = sk.solve(system).attempts[0]
    >>> print(load_factor, attempt.status.value, attempt.iterations)
    1.0 converged 4
    """

    q: np.ndarray
    status: Status
    residual_norms: tuple[float, ...]
    negative_pivots: int = 0
    message: str = ""
    load_factor: float = 1.0
    along: np.ndarray | None = None
    bound: float = 0.0
    multipliers: np.ndarray = field(default_factory=none)
    pulled: np.ndarray = field(default_factory=none)

    __repr__ = short

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
    multipliers: np.ndarray | None = None,
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
    multipliers : (n,) array, optional
        First guess of those of the conditions. Default: zero.

    Examples
    --------
    >>> from skancf.linear import DirectSolver
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> solver = DirectSolver(system.pattern, system.constraints)
    >>> found = sk.statics.newton(system, system.undeformed, solver)
    >>> print(found.status.value, found.iterations)
    converged 4
    """
    tangents = tangents_of(system, solver, mixed, stresses, pull, constraint)
    begin = constraint.origin if constraint else q if origin is None else origin
    criterion = _StopCriterion(tangents, ConvergenceTest(system, begin, rtol, pull, constraint), farthest, watch)
    found = iterate(tangents.unknowns(q, multipliers, load_factor), tangents, criterion, max_steps, logger)
    energies = [energy for energy in found.energies if np.isfinite(energy)]
    largest = max(energies, default=1.0) or 1.0
    norms = tuple(float(np.sqrt(energy / largest)) for energy in energies)
    lost = found.status is Status.NOT_FINITE and not found.message
    message = refusal(system) or _where(system, found.residual) if lost else found.message
    pivots = solver.negative_pivots if energies and found.status is not Status.SINGULAR else 0
    lam, bound, n = float(found.x[-1]), criterion.bound, tangents.n
    message = message or criterion.unmet if not found.ok else message
    return NewtonResult(found.x[:n], found.status, norms, pivots, message, lam, tangents.along, bound, found.x[n:-1],
                        tangents.pulled)  # fmt: skip


@dataclass
class _StopCriterion:
    """When equilibrium is reached, and when an iteration is given up; ``bound`` is what rounding then leaves open, and
    ``unmet`` says which condition is not met."""

    tangents: Tangents
    stop: ConvergenceTest
    farthest: float
    watch: Callable[[int, float], None] | None
    bound: float = 0.0
    unmet: str = ""

    def assess(self, x: np.ndarray, change: np.ndarray, energies: list[float]) -> End | None:
        """How it ends with a correction."""
        tangents, energy, count = self.tangents, energies[-1], len(energies)
        n = tangents.n
        if self.watch:
            self.watch(count - 1, float(np.sqrt(energy / max(energies))) if energy else 0.0)
        if not np.isfinite(energy):
            return Status.NOT_FINITE, _where(tangents.system, change[:n])
        if count == 1 and self.farthest < np.inf and not tangents.moved.any():
            turn = largest_turn(tangents.system, change[:n])
            if turn > self.farthest:
                return Status.TOO_FAR, FAR.format(turn, self.farthest)
        verdict = self.stop.assess(tangents.tangent, energies, x[:n], change[:n], float(x[-1] + change[-1]))
        if verdict.last and tangents.conditions and (unmet := tangents.unmet(x + change)):
            self.unmet = unmet
        elif verdict.last:
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
    assembly = getattr(getattr(system, "shell", None), "assembly", None)
    said: str | None = assembly.refusal() if assembly else None
    return said


def _where(system: StaticSystem, values: np.ndarray) -> str:
    node = int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf))) // system.pattern.block
    place = ", ".join(f"{x:.4g}" for x in system.pattern.coordinates[:, node])
    return f"first at the node that was at ({place})"
