"""Where Newton's method begins in a step: the body advanced as a rigid one, and what it deforms along with it."""

import numpy as np

from skancf.dynamics.state import State
from skancf.system.system import System
from skancf.tolerances import ROUNDED_PRODUCT
from skancf.vectors import cross_matrix, rotation, sum_of_cross


def advanced(system: System, start: State, dt: float, easy: bool) -> tuple[np.ndarray, np.ndarray]:
    r"""Increment of the nodal coordinates over a step, (n_dofs,), from rates and accelerations, and its rigid part.

    Velocities :math:`\dot c + \omega \times (r - c)` with the momenta of v, and accelerations with those of a, are rigid:
    the body advances and turns by :math:`\Delta t\,\omega + \tfrac12 \Delta t^2 \dot\omega`. The rest of the velocities
    deforms it.

    Parameters
    ----------
    easy : bool
        Whether steps resolve the motion, so that the rest of the accelerations counts as well; that of what they do not
        resolve spoils a guess.
    """
    layout, mass, total, moving = system.layout, system.mass, system.inertia.total, system.layout.moving
    centre = system.inertia.centre(start.q) / total
    arms = layout.arms(start.q, centre)
    of_arms, of_v, of_a = (layout.nodal(mass @ x) for x in (arms.ravel(), start.v, start.a))
    second = np.einsum("ngi,ngj->ij", arms, of_arms)
    inverse = np.linalg.pinv(np.trace(second) * np.eye(3) - second, rcond=ROUNDED_PRODUCT, hermitian=True)
    velocity, spin = of_v[moving, 0].sum(axis=0) / total, inverse @ sum_of_cross(arms, of_v)
    centripetal = cross_matrix(spin) @ cross_matrix(spin)
    acceleration = of_a[moving, 0].sum(axis=0) / total
    turning = inverse @ sum_of_cross(arms, of_a - of_arms @ centripetal.T)
    rest = layout.nodal(start.v) - np.cross(spin, arms)
    rest[moving, 0] -= velocity
    deformed = arms + dt * rest
    if easy:
        rest_of_a = layout.nodal(start.a) - arms @ centripetal.T - np.cross(turning, arms) - 2 * np.cross(spin, rest)
        rest_of_a[moving, 0] -= acceleration
        deformed += 0.5 * dt**2 * rest_of_a
    turned = rotation(dt * (spin + 0.5 * dt * turning)).T
    moved = centre + dt * velocity + 0.5 * dt**2 * acceleration
    ends = np.stack([deformed, arms]) @ turned
    ends[:, moving, 0] += moved
    increment, rigid = ends.reshape(2, -1) - start.q
    return increment, rigid
