"""Why an equilibrium was not reached, and the way out."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from skancf.errors import InputError, SingularMatrix
from skancf.linear import DirectSolver
from skancf.solution import Solution
from skancf.solving import Status
from skancf.statics.conditioned import tangent_at
from skancf.statics.contradictions import contradiction_ahead, require_no_contradiction
from skancf.statics.corrections import StaticSystem
from skancf.statics.critical import CriticalMode, critical_mode, turning_estimate
from skancf.statics.newton import NewtonResult
from skancf.system.rigid import free_rigid_motions

# Stiffness against the load relative to that at the start (Bergan's current stiffness parameter) that counts as soft.
SOFT = 0.3
# A limit point that is predicted, or a contradiction of conditions, this much farther than the failed step reached, in units
# of that step, is the cause.
NEAR = 10.0


def require_support(system: StaticSystem) -> None:
    """InputError where a rigid motion is free, of a model that knows what a rigid motion is, and where conditions contradict
    each other."""
    free = free_rigid_motions(system) if hasattr(system, "layout") else []
    if free:
        raise InputError(f"no equilibrium: the supports leave free {', '.join(free)}; add supports that hold them")
    if hasattr(system, "layout") and len(system.layout.parts) > 1:
        _require_resistance(system)
    require_no_contradiction(system)


def _require_resistance(system: Any) -> None:
    """InputError where nothing resists an unknown of a part besides the plate in the undeformed state."""
    layout = system.layout
    loose = ~system.constraints.fixed & (layout.blocks(system.stiffness().diagonal()) == 0)
    for part in layout.parts[1:]:
        blocks = np.flatnonzero(loose[layout.part(part.name)].any(axis=1))
        if blocks.size:
            raise InputError(f"no equilibrium: nothing resists unknowns of part {part.name!r}, in its block {blocks[0]} for "
                             "one; let its term have a stiffness there, or hold them (held)")  # fmt: skip


def diagnose(
    system: StaticSystem, solver: DirectSolver, path: Sequence[Solution], wanted: float, failed: NewtonResult,
    ahead: Callable[[], float | None],
) -> tuple[Status, str]:  # fmt: skip
    """Status and message for load steps that ended: the equilibria so far, and the last solve that failed.

    ``wanted`` is the load factor that the failed solve was to reach; ``ahead`` looks for a limit point of the load by
    following the path a little.
    """
    tail = ", ".join(f"{r:.1e}" for r in failed.residual_norms[-3:])
    begin = (
        f"statics stopped at load factor {path[-1].load_factor:.6g}: {failed.status.value} on the way to {wanted:.6g}"
        f"{', ' + failed.message if failed.message else ''}; last residuals {tail or 'none'}. "
    )
    found = _contradiction(system, path[-1], wanted) or _folded(system, failed.q) or _mechanism(system, solver)
    status, reason = found or _singular(system, solver, path, wanted, failed)
    lost = failed.status is Status.NOT_FINITE
    if status is Status.STEP_TOO_SMALL and not lost and (limit := ahead()) is not None:
        status, reason = Status.LIMIT_POINT, limit_point(limit)
    return status, f"{begin}{reason} The last equilibrium is kept."


def _contradiction(system: StaticSystem, last: Solution, wanted: float) -> tuple[Status, str] | None:
    """Conditions that cannot be met in the solve that failed, or in a few more steps like that."""
    to = last.load_factor + NEAR * (wanted - last.load_factor)
    said = contradiction_ahead(system, last.q, last.load_factor, to)
    return (Status.CONTRADICTORY, said) if said else None


def _folded(system: StaticSystem, q: np.ndarray) -> tuple[Status, str] | None:
    shell: Any = getattr(system, "shell", None)
    with np.errstate(over="ignore", invalid="ignore"):
        found = shell.folded(q) if shell and np.isfinite(q).all() else None
    if found is None:
        return None
    element, place = found
    where = ", ".join(f"{x:.4g}" for x in np.ravel(place))
    return Status.FOLDED, (
        f"Element {element} at ({where}) folded in that solve: take a shorter step, or a finer mesh there."
    )


def _mechanism(system: StaticSystem, solver: DirectSolver) -> tuple[Status, str] | None:
    try:
        tangent_at(system, system.undeformed, 0.0, solver)
    except SingularMatrix as singular:
        return Status.MECHANISM, f"Even the undeformed structure is a mechanism: {singular}."
    return None


def _singular(
    system: StaticSystem, solver: DirectSolver, path: Sequence[Solution], wanted: float, failed: NewtonResult
) -> tuple[Status, str]:
    """A limit point or a bifurcation by the critical mode of the last equilibrium, or neither."""
    last = path[-1]
    first, now = (critical_mode(system, solver, state) for state in (path[0], last))
    limit = _limit_estimate(system, solver, path, now)
    near = abs(limit - last.load_factor) <= NEAR * abs(wanted - last.load_factor)
    if near and first.compliance < SOFT * abs(now.compliance) and now.share > 0.5:
        return Status.LIMIT_POINT, limit_point(limit)
    softened = abs(now.eigenvalue) < SOFT * abs(first.eigenvalue)
    if failed.status is Status.SINGULAR and softened and len(path) > 1:
        return Status.BIFURCATION, (
            "The tangent gets singular in a motion on which the load does no work, so branches cross here: a small "
            "disturbing load leads onto the branch that the structure takes, trace(system, ArcLength()) follows the path."
        )
    return Status.STEP_TOO_SMALL, (
        "The structure is not near a limit point: allow smaller steps or more iterations, or take a finer mesh where it "
        "bends most."
    )


def limit_point(load_factor: float) -> str:
    """What a limit point means, and the way out."""
    return (
        f"The load has a limit point near {load_factor:.6g}, where the structure gives way: follow the path beyond it with "
        "solve(system, follow=True) or trace(system, ArcLength()). A mesh too coarse for its bending has limit points of "
        "its own: where none is expected, take a finer mesh."
    )


def _limit_estimate(system: StaticSystem, solver: DirectSolver, path: Sequence[Solution], now: CriticalMode) -> float:
    """Load factor of the limit point, by the stiffness against the load at the last two equilibria."""
    if len(path) < 2 or not np.isfinite(now.compliance):
        return np.inf
    before = critical_mode(system, solver, path[-2])
    if not (before.compliance and now.compliance):  # loads that do no work
        return np.inf
    return turning_estimate((path[-2].load_factor, path[-1].load_factor), (1.0 / before.compliance, 1.0 / now.compliance))
