"""What holds for small-deflection answers."""

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import assume

import skancf as sk
from fuzz.assessment import EPS, bounded, change_of, nodal, nothing, rounding, sizes, solved, stored
from fuzz.case import Case
from fuzz.resultants import resultant
from skancf.statics.linear import small_change

UP = (0.0, 0.0, 1.0)
CLOSE = 1e-9
"""Two sums of the same numbers in another order, with some thousand terms and three digits in hand."""


def supporting(solution: sk.Solution) -> np.ndarray:
    """Forces of the supports that hold coordinates, (n_dofs,): what is left of K u - f there."""
    system = solution.system
    rest = system.stiffness() @ (change_of(solution)) - system.external_force(system.undeformed)
    return system.constraints.fixed_part(rest)


def noise(solution: sk.Solution) -> np.ndarray:
    """Rounding of the nodal forces K u, of which each is a sum of terms that may be much larger: (n_dofs,)."""
    lost = 300 * EPS * np.abs(change_of(solution)) + stored(solution)
    return np.asarray(abs(solution.system.stiffness().to_scipy()) @ lost)


def balance(case: Case) -> None:
    """Reactions and loads have no resultant, and the loads are those that were asked for."""
    found = solved(case)
    system = found.system
    loads = nodal(system.external_force(system.undeformed))[:, 0]
    reactions = nodal(supporting(found))[:, 0]
    rest = np.linalg.norm(found.reactions() + loads.sum(axis=0))
    bounded("reactions and loads", float(rest), CLOSE * (sizes(loads) + sizes(reactions)) + sizes(nodal(noise(found))[:, 0]))
    asked, error = resultant(case, system.mesh)
    bounded("loads and what was asked", float(np.linalg.norm(loads.sum(axis=0) - asked)), error + CLOSE * sizes(loads))


def moments(case: Case) -> None:
    """Nor have they a moment: under a small spin every nodal vector v turns by w x v, and the strains do no work on that."""
    found = solved(case)
    system, start = found.system, nodal(found.system.undeformed)
    acting = supporting(found) + system.external_force(system.undeformed)
    if system.foundation is not None:
        acting -= system.foundation @ (change_of(found))
    centre = start[:, 0].mean(axis=0)
    arms = start.copy()
    arms[:, 0] -= centre
    parts = np.cross(arms, nodal(acting)).reshape(-1, 3)
    rounded = float(np.abs(arms).ravel() @ noise(found))
    bounded("moment of reactions and loads", float(np.linalg.norm(parts.sum(axis=0))), CLOSE * sizes(parts) + rounded)


def clapeyron(case: Case) -> None:
    r"""The strain energy is half the work of loads and of prescribed displacements,

    .. math:: U = \tfrac12 (f - f_T) \cdot u + \tfrac12 R \cdot u_p + U_T, \qquad f = f_{applied} + f_T,

    where free strains that are held back have the forces f_T and the energy U_T.
    """
    found = solved(case)
    system, change = found.system, change_of(found)
    initial = system.shell.initial_stress_force(system.undeformed, sk.Case())
    initial = np.zeros(system.n_dofs) if initial is None else initial
    parts = [
        0.5 * float(system.applied_force(system.undeformed) @ change), -0.5 * float(initial @ change),
        0.5 * float(supporting(found) @ system.prescribed()), system.shell.thermal_energy(),
    ]  # fmt: skip
    # The energy of the free strains held back is a difference of these two.
    size = sum(map(abs, parts)) + abs(found.strain_energy)
    bounded("energy less half the work", abs(found.strain_energy - sum(parts)), (CLOSE + rounding(found)) * size)
    assert found.strain_energy >= -(CLOSE + rounding(found)) * size, "negative strain energy"


def reciprocity(pair: tuple[Case, Any]) -> None:
    """Betti: one load does as much work on the other's displacements as the other on its own."""
    case, other = pair
    one, two = solved(case), solved(case.with_loads(other))
    forces = [s.system.external_force(s.system.undeformed) for s in (one, two)]
    works = [float(f @ (change_of(s))) for f, s in zip(forces, (two, one), strict=True)]
    own = [float(f @ (change_of(s))) for f, s in zip(forces, (one, two), strict=True)]
    # By Cauchy and Schwarz neither work is larger than this mean of their own.
    size = float(np.sqrt(abs(own[0] * own[1])))
    unknown = [stored(s) + 300 * EPS * np.abs(change_of(s)).max() for s in (two, one)]
    lost = sum(float(np.abs(f) @ u) for f, u in zip(forces, unknown, strict=True))
    bounded("difference of works", abs(works[0] - works[1]), (CLOSE + rounding(one) + rounding(two)) * size + lost)


def superposition(case: Case) -> None:
    """Loads together do what they do one by one, and twice as large twice as much."""
    together = solved(case)
    change = change_of(together)
    alone = [solved(case.with_loads(load)) for load in case.problem.loads]
    rest = solved(case.with_loads())
    parts = [change_of(found) for found in (*alone, rest)]
    total = sum(parts[:-1]) - (len(alone) - 1) * parts[-1]
    _same_energy(together, change, total, [*alone, rest])
    system = together.system
    doubled = small_change(system) * 2
    _same_energy(together, 2 * change, doubled, [together])


def _same_energy(of: sk.Solution, one: np.ndarray, two: np.ndarray, parts: list[sk.Solution]) -> None:
    """Two changes are equal in the norm of the strain energy, of which ``parts`` are a measure."""
    matrix = of.system.stiffness()
    norm = [float(np.sqrt(abs(v @ (matrix @ v)))) for v in (one - two, one, *map(change_of, parts))]
    lost = stored(of)
    unknown = 2 * len(parts) * float(np.sqrt(lost @ (abs(matrix.to_scipy()) @ lost)))
    error = max(rounding(part) for part in (of, *parts))
    bounded("sum of parts", norm[0], (1e-8 + error) * sum(norm[1:]) + unknown)


def nested(case: Case) -> None:
    """Conforming functions on a refined mesh hold those of the coarse one: dead loads do not do less work there."""
    # The tilt along an edge is held at nodes; where the edge itself is not, more nodes hold more.
    assume(not any(isinstance(s, sk.Roller) and s.kind == "hard" and s.direction != UP for s in case.problem.supports))
    coarse, fine = solved(case), solved(replace(case, mesh=case.mesh.halved()))
    error = CLOSE + rounding(coarse) + rounding(fine)
    bound = error * abs(fine.strain_energy) + nothing(coarse) + nothing(fine)
    bounded("energy lost on the finer mesh", coarse.strain_energy - fine.strain_energy, bound)
