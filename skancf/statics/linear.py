"""Small deflections: one solve with the tangent of the undeformed state."""

import numpy as np

from skancf.conditions.solver import conditions_in, solver_at
from skancf.errors import DidNotConverge, warn
from skancf.history import Case
from skancf.linear import DirectSolver, SkewSolver
from skancf.solution import Solution
from skancf.statics.arguments import check_arguments
from skancf.statics.diagnosis import require_support
from skancf.statics.newton import OPEN
from skancf.statics.validity import warn_if_loads_move, warn_if_loose, warn_if_thick, warn_without_time
from skancf.statics.verify import Balance, unmet
from skancf.system.linearised import Linearised
from skancf.system.system import System

OPEN_LINEAR = (
    "the linear answer lost digits: {} is {:.1e}, more than {:.0e}. Elements may be too small, or too thin for their "
    "length: take a coarser mesh, or look for a support that hardly holds"
)


def solve_linear(system: System, *, backend: str = "auto") -> Solution:
    """Small-deflection answer: one solve with the tangent of the undeformed state.

    Raises
    ------
    InputError
        When a rigid motion is free.
    DidNotConverge
        Where rounding leaves loads and reactions out of balance by more than a hundredth.

    Warns
    -----
    OutOfDepth
        Where they are out of balance by more than a millionth, where the answer is out of the depth of its theory or of
        its mesh, and where loads that depend on the displacement, such as water that collects in a dent, would change by
        more than a twentieth of the structure's resistance: they count as they are undeformed.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> solution = sk.solve_linear(system)
    >>> print(f"{1000 * solution.displacement((1.0, 0.05))[2]:.3f} mm")  # F L^3 / 3 E I
    1.905 mm
    """
    check_arguments(system, backend)
    require_support(system)
    warn_without_time(system)
    solution = small_deflection(system, backend=backend)
    warn_if_thick(solution)
    warn_if_loads_move(solution)
    return warn_if_loose(solution)


def small_deflection(system: System, load_factor: float = 1.0, *, backend: str = "auto") -> Solution:
    """:func:`solve_linear` for a system that is known to be supported, without a judgement of its theory."""
    change, multipliers = small_answer(system, backend, load_factor)
    if not np.isfinite(change).all():
        raise DidNotConverge("the linear answer is not finite")
    sizes = np.abs(system.stiffness().diagonal())
    lost = unmet(Balance.of_small_change(system, change, load_factor, multipliers).measured(sizes))
    if lost:
        worst = max(lost, key=lambda one: one.value)
        message = OPEN_LINEAR.format(worst.name, worst.value, worst.limit)
        if worst.value > OPEN:
            raise DidNotConverge(message)
        warn(message)
    return Solution.of(Linearised(system), change, load_factor, multipliers)


def small_change(system: System, backend: str = "auto", load_factor: float = 1.0) -> np.ndarray:
    """The change of the undeformed state under so much of the load, (n_dofs,)."""
    return small_answer(system, backend, load_factor)[0]


def small_answer(system: System, backend: str = "auto", load_factor: float = 1.0) -> tuple[np.ndarray, np.ndarray | None]:
    """The same, and the multipliers (n,) of conditions; None without any."""
    with DirectSolver(system.pattern, system.constraints, backend) as solver:
        return answer_by(system, solver, load_factor)


def answer_by(system: System, solver: DirectSolver, load_factor: float = 1.0) -> tuple[np.ndarray, np.ndarray | None]:
    """The same by a solver, which then has the factors of the stiffness, or of what is condensed from it."""
    if conditions_in(system):
        return change_with_conditions(system, solver, load_factor)
    solver.factor(system.stiffness())
    return change_by(system, solver, load_factor), None


def change_by(system: System, solver: DirectSolver, load_factor: float = 1.0) -> np.ndarray:
    """The change by a solver that has the factors of the stiffness. Forces that the structure's own terms have at rest count
    whole."""
    model, case = Linearised(system), Case(load_factor)
    moved = model.held(load_factor)
    tangent = SkewSolver(system.stiffness(), model.skew(moved), solver)
    change = tangent.solve(model.external_force(moved, case) - model.internal_force(moved, None, case)) + moved
    solver.warn_if_lost()
    return change


def change_with_conditions(system: System, solver: DirectSolver, load_factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """The change (n_dofs,) and the multipliers (n,) of conditions, by a solver that gets condensed factors."""
    model, case = Linearised(system), Case(load_factor)
    moved = model.held(load_factor)
    held = solver_at(system, solver, system.undeformed).factor(system.stiffness(), model.skew(moved))
    rhs = model.external_force(moved, case) - model.internal_force(moved, None, case)
    change, multipliers = held.solve_both(rhs, -model.conditions_value(moved, case))
    held.warn_if_lost()
    return change + moved, multipliers
