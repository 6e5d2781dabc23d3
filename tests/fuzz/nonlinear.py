"""What holds for answers of nonlinear statics that say they have converged."""

from typing import Any

import numpy as np
from hypothesis import assume

import skancf as sk
from fuzz.assessment import EPS, bounded, nodal, nothing, rounding, seen, sizes, stated, stored
from fuzz.case import Case
from skancf.linear import DirectSolver
from skancf.solving import Status
from skancf.statics import StaticResult
from skancf.statics.corrections import factored

BALANCED = 1e-6
"""Of the larger of the sums of the magnitudes of nodal loads and of reactions: a user sees six digits of a reaction."""


def answered(case: Case, **options: Any) -> StaticResult:
    """A result, whatever its status; errors other than a refusal are findings."""
    with stated():
        result = sk.solve(options.pop("system", None) or case.system(), **options)
    seen[f"status: {result.status.value}"] += 1
    return result


def honest(case: Case) -> None:
    """Converged means balanced, at rest, and stable unless said otherwise; what is not converged says why."""
    result = answered(case)
    found = result.solution
    assert np.isfinite(found.q).all() and np.isfinite(found.strain_energy), "a result that is not finite"
    assert all(isinstance(check, sk.Check) for check in getattr(result, "checks", ())), "checks that are none"
    if result.status is not Status.CONVERGED:
        assert result.message, f"{result.status} without a word"
        return
    assert found.load_factor == 1.0, "converged elsewhere"
    assert result.negative_pivots == 0 or "not stable" in result.message, "an unstable equilibrium without a word"
    balanced(found)
    at_rest(found)


def balanced(found: sk.Solution) -> None:
    """Reactions, those of springs included, and loads have no resultant."""
    system = found.system
    loads = system.external_force(found.q) * found.load_factor
    residual = system.internal_force(found.q) - loads
    reactions = nodal(system.constraints.fixed_part(residual))[:, 0]
    # Moments, and temperature that is free to strain, have no forces to compare with but couples over the body's size.
    arms = nodal(system.undeformed) - nodal(system.undeformed)[:, :1].mean(axis=0) * [[1], [0], [0], [0]]
    couples = sizes(np.cross(arms, nodal(loads)).reshape(-1, 3)) / float(np.linalg.norm(arms[:, 0], axis=1).max())
    size = max(sizes(nodal(loads)[:, 0]), sizes(reactions), couples)
    rest = found.reactions() + nodal(loads)[:, 0].sum(axis=0)
    # Loads that do no work, such as a moment about the normal of a clamped edge, leave but the rounding of coordinates.
    noise = abs(system.stiffness().to_scipy()) @ stored(found)
    bounded("reactions and loads", float(np.linalg.norm(rest)), BALANCED * size + float(np.linalg.norm(noise)))


def at_rest(found: sk.Solution, rtol: float = 1e-7) -> None:
    r"""The correction that a fresh, exact tangent still asks for, in the norm of energy,
    :math:`\sqrt{R \cdot K^{-1} R} \le 10\,\text{rtol}\,\sqrt{2 U}`: Newton's measure with a digit in hand."""
    system, factor = found.system, found.load_factor
    residual = system.internal_force(found.q) - factor * system.external_force(found.q)
    free = system.constraints.free_part(residual)
    with DirectSolver(system.pattern, system.constraints) as solver:
        try:
            tangent = factored(system, found.q, factor, solver)
            left = float(np.sqrt(abs(free @ tangent.solve(free))))
        except sk.SingularMatrix:
            seen["singular at the end"] += 1
            return
    # Heated bodies that are free to expand have no energy in the end.
    energy = found.strain_energy + factor**2 * system.shell.thermal_energy()
    # Loads on what is held leave a body at rest, but for the rounding of its coordinates.
    unknown = float(np.sqrt(nothing(found)))
    bounded("residual in the norm of energy", left, 10 * rtol * float(np.sqrt(2 * abs(energy))) + unknown)


def restart(case: Case) -> None:
    """From the equilibrium under half the load the same state is reached as at once."""
    system = _system(case)
    whole, half = answered(case, system=system), answered(case, system=system, load_factor=0.5)
    assume(_stable(whole) and _stable(half))
    again = answered(case, system=system, start=half.solution)
    assume(_stable(again))
    one, two = whole.solution.displacements, again.solution.displacements
    error = 1e-5 + rounding(whole.solution)
    lost = 10 * float(stored(whole.solution).max())
    bounded("a restart's displacements", float(np.abs(one - two).max()), error * float(np.abs(one).max()) + lost)


def _system(case: Case) -> Any:
    with stated():
        return case.system()


def _stable(result: StaticResult) -> bool:
    """Converged without having buckled or snapped, after which there may be several stable states."""
    return result.status is Status.CONVERGED and result.negative_pivots == 0 and not result.message


SMALL = 0.005
"""Displacements over the thickness at which terms of the second order are less than a per cent."""


def small_loads(case: Case) -> None:
    """Small loads: what is not linear falls with the square of the load."""
    system = _system(case)
    with stated():
        linear = sk.solve_linear(system)
    straight = linear.displacements
    size, noise = float(np.abs(straight).max()), rounding(linear)
    assume(size > 0 and noise < 1e-8)
    thickness = float(np.ptp(case.problem.section.z))
    rest = []
    for part in (1.0, 0.5):
        factor = part * SMALL * thickness / size
        result = answered(case, system=system, load_factor=factor, rtol=1e-10)
        assume(_stable(result))
        rest.append(float(np.abs(result.solution.displacements - factor * straight).max()))
    # The strains of positions are rounded, and Newton's method ends 1e-10 away.
    floor = (1e-8 + 1e3 * noise) * SMALL * thickness + EPS * 1e3 * float(np.abs(nodal(system.undeformed)[:, 0]).max())
    bounded("part that is not linear", rest[0], 0.5 * SMALL * thickness)
    bounded("what half the load leaves of it", rest[1], 0.3 * rest[0] + floor)
