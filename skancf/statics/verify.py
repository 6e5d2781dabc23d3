"""Checks of an equilibrium by its exact tangent, its residual and the balance of the whole body."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from skancf.checks import Check
from skancf.conditions.solver import conditions_in
from skancf.errors import SingularMatrix
from skancf.history import Case
from skancf.linear import DirectSolver
from skancf.showing import short
from skancf.statics.conditioned import solved, tangent_at
from skancf.statics.corrections import none
from skancf.statics.stopping import is_rigid, moves, stored, work
from skancf.system.linearised import Exact, Linearised
from skancf.tolerances import BALANCED, CONDITION_MET, RIGID, RIGID_PRODUCT, ROUNDED_COORDINATE, SHARPEST
from skancf.vectors import sum_of_cross

ADVICE = "Ask for a smaller rtol, or look for a load that is lost in rounding."
TIMES = 10.0
"""A residual above this multiple of the asked tolerance fails."""
POLISHES = 3


@dataclass(frozen=True)
class Measured:
    """A number that must not exceed its limit; up to ``rounding``, it may be that of the nodal coordinates."""

    name: str
    value: float
    limit: float
    rounding: float


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
    multipliers : (n,) array
        Of the conditions, corrected likewise.
    """

    q: np.ndarray
    measured: tuple[Measured, ...]
    negative_pivots: int
    multipliers: np.ndarray = field(default_factory=none)

    __repr__ = short

    @property
    def unmet(self) -> list[Measured]:
        """The numbers that do not meet their limits; rounding may explain them."""
        return unmet(self.measured)


def unmet(measured: tuple[Measured, ...]) -> list[Measured]:
    """Those above their limits, and those that are no numbers."""
    return [one for one in measured if not one.value <= one.limit]


def checks_of(measured: tuple[Measured, ...]) -> tuple[Check, ...]:
    """As the user sees them."""
    return tuple([Check(m.name, m.value, max(m.limit, m.rounding), ADVICE) for m in measured])


def verify(system: Any, solver: DirectSolver, found: Any, *, rtol: float, origin: np.ndarray) -> Verified:
    """Check an equilibrium that Newton's method found; where it fails, correct it a little by its exact tangent and check
    again.

    ``origin`` is where its way began.
    """
    q, load_factor, multipliers = found.q, found.load_factor, found.multipliers
    try:
        tangent = tangent_at(system, q, load_factor, solver, multipliers=multipliers)
    except SingularMatrix as singular:
        return Verified(q, (Measured(f"tangent at the answer, {singular}", np.inf, 0.0, 0.0),), 0, multipliers)
    sizes, pivots = np.abs(tangent.matrix.diagonal()), solver.negative_pivots
    for polish in range(POLISHES + 1):
        balance = Balance.of_state(system, q, load_factor, origin, multipliers)
        correction, more, energy = solved(tangent, -balance.free, -balance.values)
        measured = (_residual(balance, energy, sizes, rtol), *balance.measured(sizes))
        if polish == POLISHES or not unmet(measured):
            break
        q, multipliers = q + correction, multipliers + more
    return Verified(q, measured, pivots, multipliers)


def _residual(balance: "Balance", energy: float, sizes: np.ndarray, rtol: float) -> Measured:
    """The residual in the energy norm of the exact tangent, relative to that of the strain."""
    counts = balance.energy > 0 and not balance.is_at_rest(sizes)
    rounding = ROUNDED_COORDINATE * float(np.sqrt(sizes @ balance.moved**2 / balance.energy)) if counts else 0.0
    norm = float(np.sqrt(energy / balance.energy)) if counts else 0.0
    return Measured("residual in the energy norm, of that of the strain", norm, max(TIMES * rtol, SHARPEST), rounding)


@dataclass(frozen=True)
class Balance:
    """Forces of a state: internal ones, loads, and what supports carry.

    Attributes
    ----------
    place : (n_dofs,) array
        Nodal coordinates at which forces have their arms: of the state; of a small-deflection answer the undeformed ones.
    moved : (n_dofs,) array
        Numbers of whose rounding that of the internal forces is made: the coordinates, or a small change of them.
    way : (n_dofs,) array
        From where the state began.
    internal, loads : (n_dofs,) array
    energy : float
        Twice the strain energies of the state and of the beginning of its way (J).
    pushed : bool
        Supports move.
    others : (n_dofs,) array or None
        Of the internal forces, those that the shell does not have: of other terms and of conditions.
    values : (n,) array
        Those of the conditions.
    """

    system: Any
    place: np.ndarray
    moved: np.ndarray
    way: np.ndarray
    internal: np.ndarray
    loads: np.ndarray
    energy: float
    pushed: bool
    others: np.ndarray | None
    values: np.ndarray = field(default_factory=none)

    __repr__ = short

    @classmethod
    def of_state(
        cls, system: Any, q: np.ndarray, load_factor: float, origin: np.ndarray, multipliers: np.ndarray | None = None
    ) -> "Balance":
        energy = stored(system, q, Case(load_factor))
        # Nothing is stored at rest and cold.
        if (origin != system.undeformed).any() or system.shell.heats:
            energy += stored(system, origin, Case(load_factor))
        loads, pushed = load_factor * system.external_force(q), bool(system.prescribed().any())
        case = Case(load_factor)
        others = system.others.force(q, None, case) if system.others else None
        internal = system.internal_force(q, None, case)
        found = cls(system, q, q, q - origin, internal, loads, 2 * energy, pushed, others)
        if not conditions_in(system):
            return found
        model = Exact(system)
        return found.held_by(model.conditions_force(q, multipliers), model.conditions_value(q, case))

    def held_by(self, force: np.ndarray, values: np.ndarray) -> "Balance":
        """The same with the forces (n_dofs,) of conditions, and the values of these."""
        others = force if self.others is None else self.others + force
        return replace(self, internal=self.internal + force, others=others, values=values)

    @classmethod
    def of_small_change(
        cls, system: Any, change: np.ndarray, load_factor: float, multipliers: np.ndarray | None = None
    ) -> "Balance":
        model, case, pushed = Linearised(system), Case(load_factor), bool(system.prescribed().any())
        internal, loads = model.internal_force(change, None, case), model.external_force(change, case)
        others = model.others_force(change, None, case) if system.others else None
        energy = float(internal @ change)
        found = cls(system, system.undeformed, change, change, internal, loads, energy, pushed, others)
        if not conditions_in(system):
            return found
        return found.held_by(model.conditions_force(change, multipliers), model.conditions_value(change, case))

    @cached_property
    def free(self) -> np.ndarray:
        """Residual on the free coordinates."""
        return np.asarray(self.system.constraints.free_part(self.internal - self.loads))

    def measured(self, sizes: np.ndarray) -> tuple[Measured, ...]:
        """Balance of the whole body, given the absolute diagonal of a tangent, by which rounding is judged."""
        noise, way = ROUNDED_COORDINATE * sizes * self.moved, self.way
        held: tuple[Measured, ...] = ()
        if self.values.size:
            missed = self.system.conditions.missed(self.values)
            held = (Measured("values of conditions, of their scales", missed, CONDITION_MET, 0.0),)
        drive, lever = self.drive
        force, moment = self.left()
        terms = self.energy + float(np.abs(self.internal) @ np.abs(way))
        if not (drive and terms) or self.is_at_rest(sizes):
            return held
        lost = float(np.sqrt(noise @ noise)) / drive
        lost_work = float(np.sqrt((noise * way) @ (noise * way))) / terms
        return (
            *held,
            Measured("sum of loads and reactions, of the loads", force / drive, BALANCED, lost),
            Measured("sum of moments of loads and reactions, of the loads", moment / (drive * lever), BALANCED, lost),
            Measured("work of the residual on the way, of the forces'", work(self.free, way) / terms, BALANCED, lost_work),
        )

    def is_at_rest(self, sizes: np.ndarray) -> bool:
        """Whether only rounding is left to be balanced: no load acts on what is free, no support strains the body."""
        if self.acted:
            return False
        part = RIGID_PRODUCT if self.moved is self.way else RIGID
        return not self.pushed or is_rigid(self.energy, sizes, self.way, part)

    @cached_property
    def acted(self) -> bool:
        """Whether a load acts on anything that supports do not hold."""
        return moves(self.system.constraints, self.loads)

    @cached_property
    def drive(self) -> tuple[float, float]:
        """Size of the forces that drive the body (N), and a lever for moments (m): the extent of the body.

        The sum of the magnitudes of nodal loads, moments over the extent; of the reactions where nothing but supports moves.
        """
        layout = self.system.layout
        nodal, positions = layout.nodal(self.place), layout.positions(self.place)
        lever = float((positions.max(axis=0) - positions.min(axis=0)).max())
        forces = self.internal - self.loads - self.free if self.pushed else self.loads
        sizes, arms = (np.sqrt(v * v @ np.ones(3)) for v in (layout.nodal(forces), nodal))
        arms[layout.moving, 0] = lever
        return float(np.vdot(sizes, arms)) / lever, lever

    def left(self) -> tuple[float, float]:
        """Force and moment about the first node that loads, supports and springs leave over, (N, N m).

        Sums over the whole body, to which internal forces do not contribute.
        """
        # Loads and reactions are what internal forces leave of the residual on the free coordinates.
        layout, total = self.system.layout, self.internal - self.free
        if self.others is not None:
            total = total - self.others
        nodal = layout.arms(self.place, layout.nodal(self.place)[0, 0].copy())
        force, moment = layout.positions(total).sum(axis=0), sum_of_cross(nodal, total)
        return float(np.sqrt(force @ force)), float(np.sqrt(moment @ moment))
