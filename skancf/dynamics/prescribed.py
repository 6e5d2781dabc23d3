"""Rates and accelerations of prescribed coordinates: differences of their values over a short moment."""

import numpy as np

from skancf.errors import InputError
from skancf.history import Case
from skancf.system.system import System

RATE_STEP = 1e-7
"""Of a time: over it prescribed coordinates are differenced for their rate. Rounding, 1e-16 over it, is smaller than the
error of the difference."""


def prescribed_rate(system: System, time: float, moment: float) -> np.ndarray:
    """The rate at a time, (n_dofs,), forwards over ``moment`` (s); backwards where a table ends."""
    now = system.prescribed(Case(time=time))
    try:
        return (system.prescribed(Case(time=time + moment)) - now) / moment
    except InputError:
        return (now - system.prescribed(Case(time=time - moment))) / moment


def prescribed_acceleration(system: System, time: float, moment: float) -> np.ndarray:
    """The acceleration at a time, (n_dofs,), over twice ``moment`` (s); backwards where it is negative."""
    now, soon, later = (system.prescribed(Case(time=time + k * moment)) for k in range(3))
    return (later - 2 * soon + now) / moment**2
