"""States between two times: the body moves and turns as a whole, and deforms along with it."""

import numpy as np

from skancf.dynamics.state import State
from skancf.dynamics.turning import nodal_frames
from skancf.layout.layout import Layout
from skancf.linear import Constraints
from skancf.tolerances import ROUNDED_PROJECTION
from skancf.vectors import rotation, rotation_vector, sum_of_cross


class StateInterpolation:
    r"""States between others, in a frame that moves and turns with the body.

    .. math:: r(t) = c(t) + R(t)\,x(t), \qquad R(t) = \exp(\psi(t) \times),

    with the mean c of the nodes' positions and the mean rotation :math:`\psi` of their frames since the first state, those
    that supports hold, so that these are met, or all where none is held. A body that turns as a whole is then not stretched
    on the way, as it would be by polynomials of r.
    """

    def __init__(self, layout: Layout, constraints: Constraints):
        held, self.layout = np.trace(constraints.of_vectors(), axis1=2, axis2=3), layout
        self.places = _or_all((held[:, 0] > 3 - ROUNDED_PROJECTION) & layout.moves, layout.moves)
        self.turning = _or_all((held[:, 1:3] > 2 - ROUNDED_PROJECTION).all(axis=1) & layout.moves, layout.moves)

    def cubic(self, t: float, times: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at a time between two, cubic in that frame.

        Parameters
        ----------
        t : float
            Time (s).
        times : (2,) array
        q, v : (2, n_dofs) arrays
            Nodal coordinates and rates at both.
        """
        dt = float(times[1] - times[0])
        s, spin = (t - float(times[0])) / dt, self._turns(q)[1] / dt
        centres, arms = self._split(q)
        speeds, rates = self._split(v)
        back = rotation(-spin * dt).T
        arms[1], rates[1] = arms[1] @ back, rates[1] @ back
        rates -= np.cross(spin, arms)
        (c, of_c), (x, of_x) = _cubic(s, dt, centres, speeds), _cubic(s, dt, arms, rates)
        of_x += np.cross(spin, x)
        turned = rotation(spin * s * dt).T
        return self._joined(c, x @ turned), self._joined(of_c, of_x @ turned)

    def inside(self, t: float, start: State, end: State) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates inside of a step.

        Rates hold vibrations that the step does not resolve, which would stretch a cubic: where the state before the step
        is known, positions are a parabola through three states, and rates a straight line. In a first step the parabola
        begins with the rates at its start.
        """
        s, past = (t - start.time) / end.dt, start.dt / end.dt
        if start.before is None or not past:
            states, weights = np.array([start.q, end.q]), np.array([1 - s * s, s * s])
        else:
            states = np.array([start.q, end.q, start.before])
            weights = np.array([(1 - s) * (s + past) / past, s * (s + past) / (1 + past), s * (s - 1) / (past * (past + 1))])
        (centres, arms), turns = self._split(states), self._turns(states)
        speeds, rates = self._split(np.array([start.v, end.v]))
        arms = np.array([x @ rotation(-turn).T for x, turn in zip(arms, turns, strict=True)])
        rates[1] = rates[1] @ rotation(-turns[1]).T
        c, x, psi = (np.tensordot(weights, of, 1) for of in (centres, arms, turns))
        of_c, of_x = ((1 - s) * of[0] + s * of[1] for of in (speeds, rates))
        if len(states) == 2:
            spin = _spin(arms[0][self.turning], rates[0][self.turning])
            more = (s - s * s) * end.dt
            c, psi, x = c + more * speeds[0], psi + more * spin, x + more * (rates[0] - np.cross(spin, arms[0]))
        turned = rotation(psi).T
        return self._joined(c, x @ turned), self._joined(of_c, of_x @ turned)

    def _split(self, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means of positions (n, 3), and nodal vectors (n, n_nodes, 4, 3) with positions less them."""
        nodal = vectors.reshape(len(vectors), *self.layout.shape).copy()
        centres = nodal[:, self.places, 0].mean(axis=1)
        nodal[:, self.layout.moving, 0] -= centres[:, None]
        return centres, nodal

    def _joined(self, centre: np.ndarray, nodal: np.ndarray) -> np.ndarray:
        nodal[self.layout.moving, 0] += centre
        return nodal.ravel()

    def _turns(self, q: np.ndarray) -> np.ndarray:
        """The rotations that fit those of the nodal frames from the first of some states to each best, vectors (n, 3)."""
        frames = [nodal_frames(state)[self.turning] for state in q]
        left, _, right = np.linalg.svd([np.einsum("nik,njk->ij", each, frames[0]) for each in frames])
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        return np.array([rotation_vector(R) for R in left @ right])


def _or_all(blocks: np.ndarray, every: np.ndarray) -> np.ndarray:
    return blocks if blocks.any() else every


def _spin(arms: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """The angular velocity that fits the rates of nodal vectors best, (3,)."""
    x = np.reshape(arms, (-1, 3))
    return np.asarray(np.linalg.pinv(np.sum(x * x) * np.eye(3) - x.T @ x, hermitian=True) @ sum_of_cross(arms, rates))


def _cubic(s: float, dt: float, values: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hermite's cubic, and its rate, at the part s of an interval with values (2, ...) and rates (2, ...) at its ends."""
    value = ((1 - s) ** 2 * (1 + 2 * s), s**2 * (3 - 2 * s), s * (1 - s) ** 2 * dt, s**2 * (s - 1) * dt)
    slope = (6 * s * (s - 1) / dt, 6 * s * (1 - s) / dt, (1 - s) * (1 - 3 * s), s * (3 * s - 2))
    at, of = (w[0] * values[0] + w[1] * values[1] + w[2] * rates[0] + w[3] * rates[1] for w in (value, slope))
    return at, of
