"""What a run in time leaves behind."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skancf.arguments import function
from skancf.checks import Check
from skancf.dynamics.interpolation import StateInterpolation
from skancf.dynamics.ledger import Ledger
from skancf.dynamics.pulls import Pulls
from skancf.equality import by_value
from skancf.errors import DidNotConverge, InputError, number, shown
from skancf.functions import measured
from skancf.layout.layout import vectors
from skancf.rows import Rows
from skancf.showing import counted, in_a_notebook, in_brackets, looked_at, passed, span, summary
from skancf.solution import Solution
from skancf.solving import Status
from skancf.system.probe import probe
from skancf.system.system import System
from skancf.tabular import Column, Columns, Tabular, of_objects, spread


@dataclass(frozen=True)
class Step:
    """One attempted step.

    Its end and length (s), relative error and energy without a source (see :class:`~skancf.dynamics.steps.Attempt`), Newton
    iterations, factorisations, unknowns, accepted or not.
    """

    time: float
    dt: float
    error: float
    iterations: int
    factorisations: int
    accepted: bool
    imbalance: float = 0.0
    n_dofs: int = 0


@by_value
@dataclass(frozen=True)
class Segment:
    """A part of a run on one mesh and without a jump of velocities: states (n, n_dofs) at times (n,), arrays or, of runs
    that do not fit into memory, :class:`~skancf.rows.Rows` of a file.

    ``outputs`` (n,) says which of them are at output times; the others are its ends. ``pulls`` are the multipliers of
    conditions, at every step.
    """

    system: System
    times: np.ndarray
    q: np.ndarray | Rows
    v: np.ndarray | Rows
    outputs: np.ndarray
    pulls: Pulls | None = None

    __repr__ = in_brackets

    @summary
    def __str__(self) -> str:
        n = counted(len(self.times), "state")
        return f"Segment: {n}, {span(self.times[0], self.times[-1], 's')}, {self.system}"

    def at(self, time: float) -> Solution:
        """The state at a time, between the states here by :class:`~skancf.dynamics.interpolation.StateInterpolation`."""
        k = max(int(np.searchsorted(self.times, time, side="right")) - 1, 0)
        if self.times[k] >= time or k == len(self.times) - 1:
            return self.solution(time, self.q[k], self.v[k])
        interpolation = StateInterpolation(self.system.layout, self.system.constraints)
        q, v = interpolation.cubic(time, self.times[k : k + 2], self.q[k : k + 2], self.v[k : k + 2])
        return self.solution(time, q, v)

    def solution(self, time: float, q: np.ndarray, v: np.ndarray) -> Solution:
        """A state with the multipliers of its time."""
        return Solution(self.system, q, v, time, multipliers=None if self.pulls is None else self.pulls.at(time))


@by_value
@dataclass(frozen=True)
class Motion(Tabular):
    """States over time, as far as the run came; as a table its output times, see :class:`~skancf.tabular.Tabular`.

    Attributes
    ----------
    segments : tuple of Segment
        Parts of the run, each on one mesh.
    steps : tuple of Step
        Every attempted step.
    ledger : Ledger
        Energies, work, dissipation and momenta at the end of every accepted step; at output times:
        :meth:`output_ledger`.
    records : dict of name to (times, values)
        The quantities asked for, at every accepted step.
    checks : tuple of Check
        Of the balances of energy and momenta, of the loads' impulses and of what the rule took out.
    error : (n,) array or None
        Estimated error at the output times (m), a mass-weighted root mean square of positions, if ``check`` was asked for.
    seconds : float
        Wall time, of all processes that a restarted run has taken.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.01, rtol=1e-2, outputs=11, progress=False)
    >>> state = motion.at(0.005)  # a Solution
    >>> print(motion.ok, len(motion.times), f"{1000 * state.displacement((1.0, 0.05))[2]:.2f} mm")
    True 11 0.12 mm
    """

    segments: tuple[Segment, ...]
    steps: tuple[Step, ...]
    ledger: Ledger
    records: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    status: Status = Status.FINISHED
    message: str = ""
    seconds: float = 0.0
    checks: tuple[Check, ...] = ()
    error: np.ndarray | None = None

    __repr__, _repr_html_, view = in_brackets, in_a_notebook, looked_at

    @summary
    def __str__(self) -> str:
        begin, end = self.segments[0].times[0], self.segments[-1].times[-1]
        n = sum(int(np.count_nonzero(part.outputs)) for part in self.segments)
        accepted = sum(step.accepted for step in self.steps)
        on = f"{self.segments[-1].system}" + (f" at the end of {len(self.segments)} parts" if len(self.segments) > 1 else "")
        steps = f"{counted(n, 'output')}, {counted(accepted, 'step')} computed in {self.seconds:.3g} s"
        return f"Motion: {self.status.value}, {span(begin, end, 's')}, {on}, {steps}{passed(self.checks)}"

    @property
    def ok(self) -> bool:
        """Whether the end was reached, with momenta in balance."""
        return self.status.ok

    @property
    def iterations(self) -> int:
        """Newton iterations, those of rejected steps included."""
        return sum(step.iterations for step in self.steps)

    def unwrap(self) -> "Motion":
        """The motion, or :class:`~skancf.DidNotConverge` if it did not reach its end."""
        if not self.ok:
            raise DidNotConverge(self.message)
        return self

    def _table(self) -> dict[str, Column]:
        ledger = self.output_ledger()
        largest = [float(np.linalg.norm(state.displacements, axis=0).max()) for state in self.states]
        return {
            "time": (self.times, "s"), "largest_displacement": (largest, "m"), "kinetic": (ledger.kinetic, "J"),
            "strain": (ledger.strain, "J"), "potential": (ledger.potential, "J"),
            **({} if self.error is None else {"error": (self.error, "m")}),
        }  # fmt: skip

    @property
    def record_table(self) -> Columns:
        """The recorded quantities at every accepted step, each component a column; their units are those of the caller.

        Raises
        ------
        InputError
            Where nothing was recorded.
        """
        if not self.records:
            raise InputError("record_table: this motion has no records; ask simulate for some, as in "
                             "record={'tip': lambda state: state.displacement((1, 0.5))}")  # fmt: skip
        times = next(iter(self.records.values()))[0]
        table = {"time": (times, "s")}
        for name, (_, values) in self.records.items():
            table |= spread(name, values, "")
        return Columns({name: values for name, (values, _) in table.items()}, {"time": "s"})

    @property
    def step_table(self) -> Columns:
        """Every attempted step."""
        return of_objects(self.steps, time="s", dt="s", error="", iterations="", factorisations="", accepted="",
                          imbalance="", n_dofs="")  # fmt: skip

    @property
    def times(self) -> np.ndarray:
        """Output times (s), (n,)."""
        return np.concatenate([part.times[part.outputs] for part in self.segments])

    @property
    def system(self) -> System:
        """The system of the run; for a run on several meshes, whose states have each their own, an error."""
        if any(part.system is not self.segments[0].system for part in self.segments):
            raise InputError("this motion has states on several meshes, each with its own system and nodal coordinates; "
                             "take them from motion.states, or motion.at(time)")  # fmt: skip
        return self.segments[0].system

    @property
    def q(self) -> np.ndarray:
        """Nodal coordinates at the output times, (n, n_dofs), of a run on one mesh."""
        return self._joined("q")

    @property
    def v(self) -> np.ndarray:
        """Their rates, (n, n_dofs)."""
        return self._joined("v")

    def _joined(self, name: str) -> np.ndarray:
        n = self.system.n_dofs
        return np.concatenate([getattr(part, name)[part.outputs].reshape(-1, n) for part in self.segments])

    def _as_solution(self) -> Solution:
        last = self.segments[-1].times[-1]
        raise InputError(f"a motion has a state at each time; give one of them, as motion.at({last:.4g})")

    def at(self, time: float) -> Solution:
        """State at any time, by cubic interpolation between output times; after the event where one is at that time.

        What vibrates between two output times is lost: ask for as many ``outputs`` as the motion needs.
        """
        t, first, last = number("time", time), self.segments[0].times[0], self.segments[-1].times[-1]
        if not first <= t <= last:
            raise InputError(f"time = {t} s: the motion is known from {first} to {last} s")
        return next(part for part in reversed(self.segments) if part.times[0] <= t).at(t)

    @property
    def states(self) -> Iterator[Solution]:
        """The states at the output times, each with its own system."""
        for part in self.segments:
            for k in np.flatnonzero(part.outputs):
                yield part.solution(float(part.times[k]), part.q[k].copy(), part.v[k].copy())

    def output_ledger(self) -> Ledger:
        """The ledger at the output times."""
        return self.ledger.at(self.times)

    def displacement(self, at: Any, z: float = 0.0) -> np.ndarray:
        """Displacement at the output times: of a point (2,) of the parameter plane (n, 3), of points (m, 2) (n, m, 3)."""
        if number("z", z):
            return np.array([state.displacement(at, z) for state in self.states])
        parts = []
        for part in self.segments:
            point = probe(part.system, at)
            changes = (part.q[k] - part.system.undeformed for k in np.flatnonzero(part.outputs))
            moved = np.array([point @ vectors(change) for change in changes]).reshape(-1, point.shape[0], 3)
            parts.append(moved[:, 0] if np.ndim(at) == 1 else moved)
        return np.concatenate(parts)

    def history(self, quantity: Callable[[Solution], Any]) -> np.ndarray:
        """A quantity of each state at the output times, (n, ...)."""
        function("quantity", quantity, "a function of a Solution")
        values = [measured("quantity", quantity, state) for state in self.states]
        if len({np.shape(value) for value in values}) > 1:
            raise InputError(f"quantity: it returned {shown(values[0])} and {shown(values[-1])}; let it give numbers, or "
                             "arrays of one shape")  # fmt: skip
        return np.array(values)
