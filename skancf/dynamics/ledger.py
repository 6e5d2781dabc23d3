r"""The ledger of a run: energies, work, dissipation and momenta, and whether they balance.

.. math:: T + U + V = (T + U + V)_0 + W - D - D_h + R

with the kinetic, strain and potential energy T, U and V (of weight without a history), the work W of all other loads, of
supports and conditions that move, of impulses and of temperature, the energy D that damping takes, D_h that the rule takes
out of what the steps do not resolve (its numerical dissipation), and the change R by changes of the mesh. What is left over
is the error of the integration: what a rule gains or loses on top of that.
Momenta change by the impulses of loads, supports, conditions, springs and damping.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from skancf.dynamics.forces import net_force
from skancf.dynamics.log import Log
from skancf.dynamics.rule import Rule
from skancf.dynamics.state import State
from skancf.equality import by_value
from skancf.errors import InputError, finite
from skancf.history import Case
from skancf.showing import counted, in_a_notebook, in_brackets, short, span, summary
from skancf.system.system import System
from skancf.tabular import Column, Columns, Tabular, of_objects, spread
from skancf.tolerances import ABOVE_ZERO
from skancf.vectors import sum_of_cross


@dataclass(frozen=True)
class MeshEvent:
    """A change of the mesh: time (s), elements before and after, what it did to the energies (J) and momenta.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> mesh = sk.meshes.quadtree(sk.meshes.uniform(strip.surface, 4, 1), strip.surface)
    >>> system = strip.on(mesh, "kirchhoff")
    >>> motion = sk.simulate(system, 0.002, rtol=0.1, follow=sk.Follow(every=2), progress=False)
    >>> print(all(event.after > 0 for event in motion.ledger.events))
    True
    """

    time: float
    before: int
    after: int
    strain: float
    kinetic: float
    linear: float
    angular: float
    again: bool = False
    """Whether the run went back to here, because the motion had outrun the fine part of the mesh."""

    __repr__ = short


@by_value
@dataclass(frozen=True)
class Ledger(Tabular):
    """The ledger at times (n,), a table; energies in J, momenta (n, 3) in N s and, about the origin, N m s.

    Attributes
    ----------
    times, kinetic, strain, potential, work, dissipation, numerical, remeshing : (n,) arrays
        ``work``, ``dissipation``, ``numerical`` (dissipation of the rule) and ``remeshing`` are sums from the start.
    linear, angular : (n, 3) arrays
    linear_impulse, angular_impulse : (n, 3) arrays
        Of loads, supports, conditions, springs and damping from outside, from the start.
    events : tuple of MeshEvent

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> ledger = sk.simulate(system, 0.01, rtol=1e-2, progress=False).ledger
    >>> print(abs(ledger.balance).max() < 1e-3 * abs(ledger.work).max())
    True
    """

    times: np.ndarray
    kinetic: np.ndarray
    strain: np.ndarray
    potential: np.ndarray
    work: np.ndarray
    dissipation: np.ndarray
    numerical: np.ndarray
    remeshing: np.ndarray
    linear: np.ndarray
    angular: np.ndarray
    linear_impulse: np.ndarray
    angular_impulse: np.ndarray
    events: tuple[MeshEvent, ...] = ()

    __repr__, _repr_html_ = in_brackets, in_a_notebook

    @summary
    def __str__(self) -> str:
        last = {name: getattr(self, name)[-1] for name in ("kinetic", "strain", "potential", "work")}
        said = ", ".join(f"{name} {value:.4g}" for name, value in last.items())
        when = f"{counted(len(self.times), 'row')}, {span(self.times[0], self.times[-1], 's')}"
        return f"Ledger: {when}, at the end {said}, without a source {self.balance[-1]:.2g} J"

    @property
    def energy(self) -> np.ndarray:
        """Kinetic, strain and potential energy together, (n,)."""
        return self.kinetic + self.strain + self.potential

    @property
    def balance(self) -> np.ndarray:
        """Energy that has no source since the first of the times: of the integration itself (J), (n,)."""
        left = without_source(vars(self))
        return np.asarray(left - left[0])

    @property
    def turnover(self) -> np.ndarray:
        """The largest amount of any of the energies and their sums so far (J), (n,): what a balance is compared with."""
        return np.asarray(np.maximum.accumulate(np.abs([getattr(self, name) for name in AMOUNTS]).max(axis=0)))

    @property
    def momentum_balance(self) -> np.ndarray:
        """Linear and angular momentum that have no source since the first of the times, (n, 2, 3)."""
        left = np.stack([self.linear - self.linear_impulse, self.angular - self.angular_impulse], axis=1)
        return np.asarray(left - left[0])

    def at(self, times: Any) -> "Ledger":
        """The ledger at other times, linear between those of the steps, so that what balances there balances here."""
        wanted = np.atleast_1d(finite("times", times))
        if wanted.ndim != 1 or not wanted.size:
            raise InputError(f"times of shape {wanted.shape}: give one time, or some in a row")
        if wanted.min() < self.times[0] or wanted.max() > self.times[-1]:
            raise InputError(f"times from {wanted.min()} to {wanted.max()} s: the ledger is from {self.times[0]} to "
                             f"{self.times[-1]} s")  # fmt: skip
        columns = {name: _interpolated(wanted, self.times, getattr(self, name)) for name in COLUMNS}
        return Ledger(wanted, **columns, events=self.events)

    def _table(self) -> dict[str, Column]:
        out: dict[str, Column] = {"time": (self.times, "s")}
        for name in COLUMNS:
            out |= spread(name, getattr(self, name), "N m s" if "angular" in name else "N s" if "linear" in name else "J")
        return out | {"balance": (self.balance, "J")}

    def table(self) -> dict[str, np.ndarray]:
        """Columns of numbers with names, as :func:`skancf.output.save_table` writes them: those of ``columns``."""
        return self.columns

    @property
    def event_table(self) -> Columns:
        """The changes of the mesh."""
        return of_objects(self.events, time="s", before="", after="", strain="J", kinetic="J", linear="N s",
                          angular="N m s", again="")  # fmt: skip


COLUMNS = tuple(field.name for field in fields(Ledger) if field.name not in ("times", "events"))
AMOUNTS = ("kinetic", "strain", "potential", "work", "dissipation")
SUMS = ("work", "dissipation", "numerical", "remeshing", "linear_impulse", "angular_impulse")


def without_source(ledger: Mapping[str, Any]) -> Any:
    """Energy less all that came in and went, of the columns of a ledger or of a row; what it changes by has no source."""
    energy = ledger["kinetic"] + ledger["strain"] + ledger["potential"]
    return energy - ledger["work"] + ledger["dissipation"] + ledger["numerical"] - ledger["remeshing"]


def _interpolated(wanted: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    if values.ndim == 1:
        return np.interp(wanted, times, values)
    return np.stack([np.interp(wanted, times, column) for column in values.T], axis=1)


@dataclass(frozen=True)
class Forces:
    """Nodal forces on the body at one time of a step, (n_dofs,): loads but weight, supports, springs, viscous ones from
    outside, damping of the material, and conditions, with their multipliers (n,)."""

    time: float
    loads: np.ndarray
    supports: np.ndarray
    springs: np.ndarray
    viscous: np.ndarray
    material: np.ndarray
    conditions: np.ndarray
    multipliers: np.ndarray

    __repr__ = short

    def at(self, time: float, before: "Forces") -> "Forces":
        """Linear through those of the step before."""
        if self.time == before.time or self.time == time:
            return self
        s = (time - self.time) / (self.time - before.time)
        return Forces(time, *((1 + s) * getattr(self, k) - s * getattr(before, k) for k in KINDS))


KINDS = tuple(field.name for field in fields(Forces) if field.name != "time")


class LedgerRecorder:
    """Keeps the ledger of a run, step by step."""

    def __init__(self) -> None:
        self.rows, self.events = Log(), Log(MeshEvent)
        self.logs = {"ledger": self.rows, "events": self.events}
        self.sums: dict[str, Any] = {name: np.zeros(3) if "impulse" in name else 0.0 for name in SUMS}
        self.turnover = 0.0

    def begin(self, system: System, state: State) -> None:
        """The first row."""
        self.before = forces_at_rest(system, state)
        self._write(system, state)

    def state(self) -> dict[str, Any]:
        """What the next row needs to know of those before."""
        return {"turnover": self.turnover, "sums": self.sums, "before": vars(self.before)}

    def restore(self, state: dict[str, Any]) -> None:
        self.turnover, self.sums, self.before = state["turnover"], state["sums"], Forces(**state["before"])

    def as_ledger(self) -> Ledger:
        columns = {name: np.array([row[name] for row in self.rows]) for name in ("time", *COLUMNS)}
        return Ledger(columns.pop("time"), **columns, events=tuple(self.events))

    def _write(self, system: System, state: State) -> None:
        linear, angular = system.momenta(state.q, state.v)
        case = Case(time=state.time)
        row = {
            "time": state.time, "kinetic": system.kinetic_energy(state.v), "strain": system.strain_energy(state.q, case),
            "potential": system.loads.energy(state.q, case), "linear": linear, "angular": angular,
            **self.sums,
        }  # fmt: skip
        self.rows.append(row)
        self.turnover = max(self.turnover, *(abs(row[name]) for name in AMOUNTS))

    @property
    def most_strain(self) -> float:
        """The largest strain energy so far (J)."""
        return float(max(row["strain"] for row in self.rows))

    @property
    def left(self) -> float:
        """Energy without a source so far (J)."""
        return float(without_source(self.rows[-1]) - without_source(self.rows[0]))

    @property
    def imbalance(self) -> float:
        """Energy without a source so far, relative to the largest amount of any (signed)."""
        return self.left / max(self.turnover, ABOVE_ZERO)

    def step(self, system: System, rule: Rule, start: State, u: np.ndarray, end: State, residual: Any) -> None:
        """Enter a step; ``residual()`` is that of the step's equations at its solution."""
        dt = end.dt
        forces = self._forces(system, rule, start, u, end, residual)
        middle = forces.at(start.time + 0.5 * dt, self.before)
        self.before = forces
        q, case = start.q + 0.5 * u, Case(time=start.time + 0.5 * dt)
        weight = system.loads.applied(q, None, case, potential=True)
        total = middle.loads + middle.supports + middle.springs + middle.viscous + middle.conditions + weight
        self._add(
            work=float((middle.loads + middle.supports) @ u) + heat(system, start, end)
            + driven(system, middle.multipliers, start, end),
            dissipation=-float((middle.viscous + middle.material) @ u),
            numerical=_numerical(system, rule, start, u, dt),
            linear_impulse=dt * _sum_of_forces(system, total),
            angular_impulse=dt * sum_of_cross(q, total),
        )  # fmt: skip
        self._write(system, end)

    def _forces(self, system: System, rule: Rule, start: State, u: np.ndarray, end: State, residual: Any) -> Forces:
        dt, (at, time) = end.dt, rule.at_stage(u, start, end.dt)
        case, v = Case(time=time), rule.rate(u, start, dt)
        supports, springs, viscous, material, conditions = np.zeros((5, u.size))
        if system.constraints.fixed.any():
            supports = system.constraints.fixed_part(residual())
        if system.others:
            springs = -rule.others_force(system, u, start, dt)
        if system.viscous is not None:
            viscous = -(system.viscous @ v)
        if system.shell.retardation:
            stresses = rule.viscous_stresses(system, u, start, dt)
            material = -rule.force_of(system.shell, u, start, dt, stresses)
        if system.conditions:
            conditions = -(rule.gradient(system.conditions, u, start, dt).T @ end.multipliers)
        loads, working = system.loads.applied(at, v, case, potential=False), _working(system, at, v, case)
        return Forces(time, loads + working, supports, springs - working, viscous, material, conditions, end.multipliers)

    def jump(self, system: System, before: State, after: State) -> None:
        """Enter an impulse: its work is that on the mean of the rates, and so is that of the supports."""
        change = system.mass @ (after.v - before.v)
        self._add(
            work=float(change @ (0.5 * (before.v + after.v))), linear_impulse=_sum_of_forces(system, change),
            angular_impulse=sum_of_cross(after.q, change),
        )  # fmt: skip
        self.before = forces_at_rest(system, after)
        self._write(system, after)

    def remeshed(self, event: MeshEvent, system: System, state: State) -> None:
        """Enter a change of the mesh."""
        first = self.rows[-1]
        self.before = forces_at_rest(system, state)
        self._write(system, state)
        last = self.rows[-1]
        changed = sum(last[name] - first[name] for name in ("kinetic", "strain", "potential"))
        self._add(remeshing=changed, linear_impulse=last["linear"] - first["linear"],
                  angular_impulse=last["angular"] - first["angular"])  # fmt: skip
        last.update(self.sums)
        self.events.append(event)

    def _add(self, **amounts: Any) -> None:
        self.sums = {name: value + amounts.get(name, 0.0) for name, value in self.sums.items()}


def _numerical(system: System, rule: Rule, start: State, u: np.ndarray, dt: float) -> float:
    """Energy that the rule takes out of what a step does not resolve (J)."""
    stresses = rule.numerical_stresses(system, u, start, dt)
    return 0.0 if stresses is None else float(rule.force_of(system.shell, u, start, dt, stresses) @ u)


def _sum_of_forces(system: System, force: np.ndarray) -> np.ndarray:
    return np.asarray(system.layout.positions(force).sum(axis=0))


def _working(system: System, q: np.ndarray, v: np.ndarray, case: Case) -> np.ndarray:
    """Forces on the body of terms of the structure that have no energy, whose work is booked as that of loads."""
    forces = (term.force(q, v, case) for term in system.others if term.energy(q, case) is None)
    return -sum(forces, np.zeros(q.size))


def forces_at_rest(system: System, state: State) -> Forces:
    """The forces of a state between two steps."""
    q, v, case = state.q, state.v, Case(time=state.time)
    loads, working = system.loads.applied(q, v, case, potential=False), _working(system, q, v, case)
    supports, viscous, conditions = np.zeros((3, q.size))
    springs = -system.others.force(q, v, case) - working
    if system.viscous is not None:
        viscous = -(system.viscous @ v)
    material = -system.shell.retarding_force(q, v)
    if system.conditions:
        conditions = -system.conditions.force(q, state.multipliers)
    if system.constraints.fixed.any():
        supports = system.constraints.fixed_part(system.mass @ state.a - net_force(system, q, v, case) - conditions)
    return Forces(state.time, loads + working, supports, springs, viscous, material, conditions, state.multipliers)


def driven(system: System, multipliers: np.ndarray, start: State, end: State) -> float:
    r"""Work of conditions that change with time, :math:`\lambda \cdot (g(q, t_1) - g(q, t_0))`; others do none."""
    if not system.conditions:
        return 0.0
    before, after = (system.conditions.value(end.q, Case(time=state.time)) for state in (start, end))
    return float(multipliers @ (after - before))


def heat(system: System, start: State, end: State) -> float:
    """Change of the strain energy with the temperature, and of other energies with time, the mean of that at both ends."""
    timed = [term for term in system.others if term.timed]
    if not (system.shell.heats or timed):
        return 0.0
    at = [Case(time=start.time), Case(time=end.time)]
    values = [system.shell.energy(s.q, at[1]) - system.shell.energy(s.q, at[0]) for s in (start, end)]
    values += [(term.energy(s.q, at[1]) or 0.0) - (term.energy(s.q, at[0]) or 0.0) for term in timed for s in (start, end)]
    return 0.5 * sum(values)
