"""Is an answer within the depth of its theory?"""

import warnings
from typing import Any

import numpy as np

from skancf.errors import OutOfDepth, warn
from skancf.solution import Solution

THICK = 0.05
"""From this share of shear energy on, a thin answer comes with a warning."""


def warn_without_time(system: Any) -> None:
    """A warning for each support that is a function of time alone, which statics takes at rest."""
    for hint in getattr(getattr(system, "prescription", None), "without_time", ()):
        warn(hint)


def warn_if_thick(solution: Solution, elements: np.ndarray | None = None) -> Solution:
    """The solution; with a warning where theory `kirchhoff` leaves out more than a twentieth of the strain energy, in some
    elements (a mask) or in all."""
    share = solution.shear_share_of(elements) if hasattr(solution.system, "geometry") else 0.0
    if share > THICK:
        warnings.warn(
            f"theory 'kirchhoff' leaves out transverse shear, which would change the strain energy by {100 * share:.2g} % "
            f"here (over {100 * THICK:.0f} %): take theory 'full', or let theory='auto' choose",
            OutOfDepth,
            stacklevel=3,
        )
    return solution
