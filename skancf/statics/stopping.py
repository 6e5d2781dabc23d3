"""When a Newton iteration may end: measures that cannot grow with an iteration that goes astray."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skancf.history import Case
from skancf.linear import BlockMatrix, SkewSolver
from skancf.showing import short
from skancf.tolerances import HELD_FORCE, RIGID, ROUNDED_COORDINATE


def work(change: np.ndarray, force: np.ndarray) -> float:
    """|change . force|; infinite or NaN where it does not fit a float, without a warning."""
    with np.errstate(over="ignore", invalid="ignore"):
        return abs(float(change @ force))


@dataclass(frozen=True)
class Constraint:
    """The equation row . q + factor * load_factor = value, which makes the load factor an unknown.

    Corrections are measured against the distance from ``origin``, the state from which the step started.
    """

    row: np.ndarray
    factor: float
    value: float
    origin: np.ndarray

    __repr__ = short

    def correction(self, q: np.ndarray, load_factor: float, along: np.ndarray) -> float:
        """Change of the load factor that meets the equation, q moving by ``along`` with it; infinite where none does."""
        gap = self.value - float(self.row @ q) - self.factor * load_factor
        slope = float(self.row @ along) + self.factor
        return gap / slope if slope else np.inf


@dataclass(frozen=True)
class Pull:
    r"""A pretension that holds a state back: the force :math:`\sigma G (q - q_a)` of an anchor :math:`q_a`.

    Attributes
    ----------
    strength : float
        :math:`\sigma`, a strain where G is the geometric stiffness of a unit dilation.
    metric : BlockMatrix
        G, positive semidefinite.
    anchor : (n_dofs,) array
    """

    strength: float
    metric: BlockMatrix
    anchor: np.ndarray

    __repr__ = short

    def force(self, q: np.ndarray) -> np.ndarray:
        return self.strength * (self.metric @ (q - self.anchor))

    def energy(self, q: np.ndarray) -> float:
        return 0.5 * float((q - self.anchor) @ self.force(q))


def moves(constraints: Any, force: np.ndarray) -> bool:
    """Does a force (n_dofs,) act on anything that supports do not hold, apart from rounding?"""
    free = constraints.free_part(force)
    return bool(free @ free > HELD_FORCE * (force @ force))


def is_rigid(energy: float, sizes: np.ndarray, way: np.ndarray, part: float = RIGID) -> bool:
    """Is a strain energy no more than the rounding of a way, given the absolute diagonal of the stiffness against it?"""
    return bool(energy <= part * float(sizes @ (way * way)))


def stored(system: Any, q: np.ndarray, case: Case) -> float:
    """Strain energy, never negative, by which energies are judged (J): that of the shell, and the sizes of what energies of
    other terms, which may be of any sign, have changed by."""
    if not hasattr(system, "others"):
        return float(system.strain_energy(q, case))
    return float(system.shell.energy(q, case) + system.others.turnover(system.undeformed, q, case))


class Verdict(NamedTuple):
    """On a correction: is it the last one, the energy that is rounding, and that with which it was compared.

    ``bound`` is the energy norm up to which rounding leaves the answer open, relative to that of the strain; zero where the
    asked tolerance was met. ``rigid`` says that the way has no strain.
    """

    last: bool
    floor: float
    bound: float = 0.0
    rigid: bool = False


class ConvergenceTest:
    r"""Assesses the corrections of one solve.

    With the residual's work on a correction, :math:`e_k = |R \cdot \delta q|`, the last one is that for which

    .. math:: e_k \le \text{rtol}^2 S, \qquad S = \min(\max_j e_j,\; 2 U(q + \delta q) + 2 U(q_0)),

    up to rounding. U is the strain energy, never negative; the largest :math:`e_j` alone grows with an iteration that goes
    astray, and the work of the loads vanishes where a strip has rolled up. The correction must be small too,
    :math:`\delta q \cdot M \delta q \le \text{rtol}\, w \cdot M w` with the way w from the start: the error of Newton's
    method is then about rtol of the way. Energy and mass are asked for once the first test alone holds.

    A constraint makes the load factor an unknown, and the tangent may be nearly singular: the energy is then that of the
    correction that meets both equations, that of the whole way counts too, and the correction is measured by the tangent's
    absolute diagonal, because a motion without stiffness has no energy.

    Parameters
    ----------
    system : StaticSystem
    origin : (n_dofs,) array
        Where the way began.
    rtol : float
    pull : Pull, optional
        A solve on the way, of which only the first test is asked.
    constraint : Constraint, optional
    """

    def __init__(
        self, system: Any, origin: np.ndarray, rtol: float, pull: Pull | None = None, constraint: Constraint | None = None
    ) -> None:
        self.system, self.origin, self.rtol, self.pull, self.constraint = system, origin, rtol, pull, constraint
        self._at_origin: float | None = None

    def assess(
        self, tangent: SkewSolver, energies: list[float], q: np.ndarray, change: np.ndarray, load_factor: float
    ) -> Verdict:
        """The last of ``energies`` belongs to ``change``, which leads from ``q`` to equilibrium at ``load_factor``."""
        sizes = np.abs(tangent.matrix.diagonal())
        floor = ROUNDED_COORDINATE**2 * float(sizes @ (q * q))
        energy, largest = energies[-1], max(energies)
        way = q + change - self.origin
        if self.constraint:
            largest = max(largest, work(way, tangent.multiply(way)))
        within = self.rtol**2 * largest
        if not (energy <= within + floor and (self.constraint or len(energies) > 1 or energy <= floor)):
            return Verdict(False, floor)
        scale = self._scale(q + change, load_factor)
        if self.constraint:
            near = float(sizes @ change**2) <= self.rtol * float(sizes @ way**2) + floor
            return Verdict(energy <= self.rtol**2 * min(largest, scale) + floor and near, floor)
        if energy <= floor:
            met = energy <= self.rtol**2 * scale
            bound = 0.0 if met or not scale else float(np.sqrt(floor / scale))
            return Verdict(True, floor, bound, is_rigid(scale, sizes, way))
        return Verdict(energy <= self.rtol**2 * min(largest, scale) + floor and self._is_small(change, way), floor)

    def _scale(self, q: np.ndarray, load_factor: float) -> float:
        """Twice the strain energies of a state and of the start, and that of the pull; infinite where none is known."""
        if not hasattr(self.system, "strain_energy"):
            return np.inf
        case = Case(load_factor)
        if self._at_origin is None:
            self._at_origin = stored(self.system, self.origin, case)
        with np.errstate(over="ignore", invalid="ignore"):
            scale = 2 * (stored(self.system, q, case) + self._at_origin + (self.pull.energy(q) if self.pull else 0.0))
        return scale if np.isfinite(scale) else 0.0

    def _is_small(self, change: np.ndarray, way: np.ndarray) -> bool:
        if self.pull:
            return True
        mass = self.system.mass
        return bool(change @ (mass @ change) <= self.rtol * float(way @ (mass @ way)))
