r"""Multipliers of conditions over time.

A rule lets them act at one time of each step, and meets the conditions at its end. Rates then keep them but for a part of
second order whose sign changes from step to step, and multipliers have one of first order, which the mean of two steps is
free of. So they are given at the ends of steps, between those of the steps before and after, and are of second order there.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skancf.equality import by_value
from skancf.showing import short


@by_value
@dataclass(frozen=True, eq=False)
class Pulls:
    """Multipliers along a part of a run, whose first row belongs to the state at its begin.

    Attributes
    ----------
    ends : (m,) array
        Times between steps (s).
    acting : (m,) array
        Times at which the multipliers act, in the step that ends then.
    values : (m, n) array
    """

    ends: np.ndarray
    acting: np.ndarray
    values: np.ndarray

    __repr__ = short

    def at(self, time: float) -> np.ndarray:
        """Multipliers (n,) at a time, linear between the ends of steps."""
        return _between(np.array([time]), self.ends, self.at_ends)[0]

    @cached_property
    def at_ends(self) -> np.ndarray:
        """Multipliers at the ends of steps, (m, n); the last ones go on as those before changed."""
        found, last = _between(self.ends, self.acting, self.values), len(self.ends) - 1
        if self.ends[last] > self.acting[last]:
            times, values = (self.ends, found) if last > 1 else (self.acting, self.values)
            k = last - 1 if last > 1 else last
            slope = (values[k] - values[k - 1]) / (times[k] - times[k - 1])
            found[last] = values[k] + (self.ends[last] - times[k]) * slope
        return found


def _between(wanted: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (k, n) at wanted times, linear between those (m, n) at times (m,)."""
    if len(times) == 1:
        return np.repeat(values, len(wanted), axis=0)
    k = np.clip(np.searchsorted(times, wanted, side="right") - 1, 0, len(times) - 2)
    s = np.clip((wanted - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0)[:, None]
    return np.asarray((1 - s) * values[k] + s * values[k + 1])
