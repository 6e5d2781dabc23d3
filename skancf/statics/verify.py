"""Checks of an equilibrium by its exact tangent, its residual and the balance of the whole body."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skancf.checks import Check
from skancf.errors import SingularMatrix
from skancf.linear import DirectSolver
from skancf.statics.newton import factored
from skancf.statics.stopping import ROUNDING, work
from skancf.vectors import sum_of_cross

ADVICE = "Ask for a smaller rtol, or look for a load that is lost in rounding."
BALANCE = 1e-6
"""Largest sum of forces or moments that is left over, relative to what drives the body."""
TIMES, LEAST = 10.0, 1e-7
"""A residual of so many times the asked tolerance fails; a smaller tolerance than the second is not checked."""
POLISHES = 3


@dataclass(frozen=True)
class Measured:
    """A number that must not exceed its limit; up to ``rounding``, it may be that of the nodal coordinates."""

    name: str
    value: float
    limit: float
    rounding: float

    @property
    def met(self) -> bool:
        return self.value <= self.limit


@dataclass(frozen=True)
class Verified:
    """A state after its checks.

    Attributes
    ----------
    q : (n_dofs,) array
        As it was, or after corrections by the exact tangent that it needed to pass.
    measured : tuple of Measured
    negative_pivots : int
        Of the exact tangent there.
    """

    q: np.ndarray
    measured: tuple[Measured, ...]
    negative_pivots: int

    @property
    def bound(self) -> float:
        """What rounding leaves open of a number that meets its limit only up to rounding; zero where all meet it."""
        return max((measured.rounding for measured in self.measured if not measured.met), default=0.0)


def checks_of(measured: tuple[Measured, ...]) -> tuple[Check, ...]:
    """As the user sees them."""
    return tuple([Check(m.name, m.value, max(m.limit, m.rounding), ADVICE) for m in measured])


def verify(
    system: Any, solver: DirectSolver, q: np.ndarray, load_factor: float, *, rtol: float, origin: np.ndarray
) -> Verified:
    """Check an equilibrium; where it fails, correct it a little by its exact tangent and check again.

    ``origin`` is where its way began.
    """
    try:
        tangent = factored(system, q, load_factor, solver)
    except SingularMatrix as singular:
        return Verified(q, (Measured(f"tangent at the answer, {singular}", np.inf, 0.0, 0.0),), 0)
    sizes, pivots = np.abs(tangent.matrix.diagonal()), solver.negative_pivots
    for polish in range(POLISHES + 1):
        balance = Balance(system, q, load_factor, origin)
        correction = tangent.solve(-balance.free)
        measured = (_residual(balance, correction, sizes, rtol), *balance.measured(sizes))
        if polish == POLISHES or all(one.met for one in measured):
            break
        q = q + correction
    return Verified(q, measured, pivots)


def _residual(balance: "Balance", correction: np.ndarray, sizes: np.ndarray, rtol: float) -> Measured:
    """The residual in the energy norm of the exact tangent, relative to that of the strain."""
    counts = balance.energy > 0 and balance.driven
    rounding = ROUNDING * float(np.sqrt(sizes @ balance.q**2 / balance.energy)) if counts else 0.0
    norm = float(np.sqrt(work(correction, balance.free) / balance.energy)) if counts else 0.0
    return Measured("residual in the energy norm, of that of the strain", norm, max(TIMES * rtol, LEAST), rounding)


class Balance:
    """Forces of a state: internal ones, loads, and what supports carry.

    Attributes
    ----------
    free : (n_dofs,) array
        Residual on the free coordinates.
    driven : bool
        Whether anything but the start moves the body: loads, or prescribed displacements.
    energy : float
        Twice the strain energies of the state and of the origin of its way (J).
    """

    def __init__(self, system: Any, q: np.ndarray, load_factor: float, origin: np.ndarray) -> None:
        self.system, self.q, self.way = system, q, q - origin
        # At rest and cold there is none.
        begins = (origin != system.undeformed).any() or system.held_back(None) is not None
        self.energy = 2 * float(system.strain_energy(q, load_factor))
        if begins:
            self.energy += 2 * float(system.strain_energy(origin, load_factor))
        self.loads = load_factor * system.external_force(q)
        self.internal = system.internal_force(q)
        residual = self.internal - self.loads
        self.free = system.constraints.free_part(residual)
        self.reactions = residual - self.free
        self.moved = bool(system.prescribed().any())
        self.driven = bool(self.loads.any()) or self.moved

    def measured(self, sizes: np.ndarray) -> tuple[Measured, ...]:
        """Balance of the whole body, given the absolute diagonal of a tangent, by which rounding is judged."""
        noise, way = ROUNDING * sizes * self.q, self.way
        drive, lever = self.drive
        force, moment = self.left()
        terms = self.energy + float(np.abs(self.internal) @ np.abs(way))
        if not (drive and terms):
            return ()
        lost = float(np.sqrt(noise @ noise)) / drive
        lost_work = float(np.sqrt((noise * way) @ (noise * way))) / terms
        return (
            Measured("sum of loads and reactions, of the loads", force / drive, BALANCE, lost),
            Measured("sum of moments of loads and reactions, of the loads", moment / (drive * lever), BALANCE, lost),
            Measured("work of the residual on the way, of the forces'", work(self.free, way) / terms, BALANCE, lost_work),
        )

    @property
    def drive(self) -> tuple[float, float]:
        """Size of the forces that drive the body (N), and a lever for moments (m): the extent of the body.

        The sum of the magnitudes of nodal loads, moments over the extent; of the reactions where nothing but supports moves.
        """
        nodal = self.q.reshape(-1, 4, 3)
        lever = float((nodal[:, 0].max(axis=0) - nodal[:, 0].min(axis=0)).max())
        forces = self.reactions if self.moved else self.loads
        sizes, arms = (np.sqrt(v * v @ np.ones(3)) for v in (forces.reshape(-1, 4, 3), nodal))
        arms[:, 0] = lever
        return float(np.vdot(sizes, arms)) / lever, lever

    def left(self) -> tuple[float, float]:
        """Force and moment about the first node that loads, supports and springs leave over, (N, N m).

        Sums over the whole body, to which internal forces do not contribute.
        """
        system, nodal = self.system, self.q.reshape(-1, 4, 3).copy()
        total = self.loads + self.reactions
        if system.foundation is not None:
            total = total - system.foundation @ (self.q - system.undeformed)
        nodal[:, 0] -= nodal[0, 0].copy()
        force, moment = total.reshape(-1, 4, 3)[:, 0].sum(axis=0), sum_of_cross(nodal, total)
        return float(np.sqrt(force @ force)), float(np.sqrt(moment @ moment))
