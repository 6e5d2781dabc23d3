"""State between two steps."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.showing import short

NONE = np.empty(0)
"""Multipliers where there are no conditions."""


@dataclass(frozen=True)
class State:
    """Nodal coordinates with their rate and acceleration at a time.

    ``dt`` is the length of the step that led here, 0 at the start, and ``jerk`` the third derivative over it, if the rule
    needs it; ``before`` are the coordinates at the start of that step, None at the start of the run, after a jump and after
    a change of the mesh; ``multipliers`` (n,) are those of conditions, in the step that led here, at the time ``acting``;
    ``cache`` is what a rule computes once for a state.
    """

    time: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    dt: float = 0.0
    jerk: np.ndarray | None = None
    before: np.ndarray | None = None
    multipliers: np.ndarray = field(default_factory=lambda: NONE)
    acting: float = 0.0
    cache: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    __repr__ = short

    def state(self) -> dict[str, Any]:
        """All of it but what is computed again."""
        return {name: value for name, value in vars(self).items() if name != "cache"}
