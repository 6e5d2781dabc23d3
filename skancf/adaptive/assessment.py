"""Is an adaptive answer within the validity of its theory?"""

import numpy as np

from skancf.adaptive.theory_error import TheoryError
from skancf.errors import warn
from skancf.solution import Solution
from skancf.statics.validity import THICK, warn_if_loose, warn_if_thick


def assess(state: Solution, left_out: TheoryError | None, is_static: bool) -> None:
    """Warnings where the thin theory leaves out much of the number, or, where that cannot be told, of the energy of an
    equilibrium; and where single elements of one move in ways of their own."""
    if left_out is not None and not np.isnan(left_out.value):
        if abs(left_out.value) > 0 and not abs(left_out.share) <= THICK:
            warn(
                f"theory 'kirchhoff' leaves out transverse shear, which would change the value by {left_out.value:.2g}, "
                f"{100 * left_out.share:.2g} % of it (over {100 * THICK:.0f} %): take theory 'full', or let "
                "theory='auto' choose"
            )
    elif is_static:
        warn_if_thick(state)
    if is_static:
        warn_if_loose(state)
