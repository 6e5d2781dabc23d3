"""What is left for inertia and supports."""

import numpy as np

from skancf.history import Case
from skancf.system.system import System


def net_force(system: System, q: np.ndarray, v: np.ndarray, case: Case) -> np.ndarray:
    """External less internal force and damping, (n_dofs,)."""
    force = system.external_force(q, case) - system.internal_force(q, v, case) - system.shell.retarding_force(q, v)
    return force if system.viscous is None else force - system.viscous @ v
