"""Is an answer within the validity of its theory?"""

from typing import Any

import numpy as np

from skancf.errors import warn
from skancf.solution import Solution
from skancf.tolerances import SAME_VALUE

THICK = 0.05
"""From this share of shear energy on, a thin answer comes with a warning."""

LOOSE = 0.05
"""From this share of energy in strains that are left out on, one more than a tenth off was the rule in measurements."""

MOVING = 0.05
"""Of the structure's own stiffness: that of loads which change with the displacement."""


def warn_if_loose(solution: Solution) -> Solution:
    """The solution; with a warning where more than a twentieth of its energy is in membrane strains that theory `kirchhoff`
    leaves out of the assumed ones, in motions of single elements."""
    share = solution.rest_share if hasattr(solution.system, "geometry") else 0.0
    if share > LOOSE:
        warn(
            f"{100 * share:.2g} % of the strain energy (over {100 * LOOSE:.0f} %) is in membrane strains that the assumed "
            "ones of theory 'kirchhoff' leave out, and that hardly count on this mesh: single elements may move many times "
            "too far. Take a finer mesh, above all around supports and forces at points, or Kirchhoff(assumed=False)",
        )
    return solution


def warn_if_loads_move(solution: Solution) -> Solution:
    """A small-deflection answer; with a warning where the loads change along it, as those of water that collects in a dent,
    so much that they would stiffen or soften the structure by more than a twentieth."""
    system, change = solution.system, solution.change
    moved = system.loads.tangent(system.undeformed, solution.case)
    if moved is not None and change.any():
        way, stiffness = change / np.abs(change).max(), system.stiffness()
        resists = float(way @ (stiffness @ way))
        rigid = resists <= SAME_VALUE * float(np.abs(stiffness.diagonal()) @ way**2)
        share = 0.0 if rigid else -float(way @ (moved @ way)) / resists
        if abs(share) > MOVING:
            warn(
                f"small deflections take the loads as they are undeformed; along this answer they would change by "
                f"{100 * abs(share):.2g} % of what resists it (over {100 * MOVING:.0f} %): sk.solve counts that"
            )
    return solution


def warn_without_time(system: Any) -> None:
    """A warning for each support that is a function of time alone, which statics takes at rest."""
    for hint in getattr(getattr(system, "prescription", None), "without_time", ()):
        warn(hint)


def warn_if_thick(solution: Solution, elements: np.ndarray | None = None) -> Solution:
    """The solution; with a warning where theory `kirchhoff` leaves out more than a twentieth of the strain energy, in some
    elements (a mask) or in all."""
    share = solution.shear_share_of(elements) if hasattr(solution.system, "geometry") else 0.0
    if share > THICK:
        warn(
            f"theory 'kirchhoff' leaves out transverse shear, which would change the strain energy by {100 * share:.2g} % "
            f"here (over {100 * THICK:.0f} %): take theory 'full', or let theory='auto' choose",
        )
    return solution
