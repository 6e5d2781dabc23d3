"""The loop in time: integrator, step control and output are objects beside it."""

import time as clock
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from skancf.assembly.system import System
from skancf.dynamics.generalized_alpha import GeneralizedAlpha
from skancf.dynamics.motion import Motion, MotionStatus, Step, hermite
from skancf.dynamics.step_solver import StepSolver
from skancf.dynamics.steps import FixedStep, LocalError
from skancf.errors import InputError, finite, positive
from skancf.progress import Progress
from skancf.solution import Solution, require_same_mesh
from skancf.thinness import warn_if_mass_is_off

Quantity = Callable[[Solution], Any]


def simulate(
    system: System,
    t_end: float,
    *,
    dt: float | None = None,
    rtol: float = 1e-4,
    steps: FixedStep | LocalError | None = None,
    rho_inf: float = 0.8,
    outputs: int | Sequence[float] = 201,
    record: Mapping[str, Quantity] | None = None,
    velocity: np.ndarray | None = None,
    start: Solution | None = None,
    newton_rtol: float = 1e-5,
    backend: str = "auto",
    progress: bool = True,
) -> Motion:
    """Motion from the undeformed state at rest, or from ``start``, by the generalised-alpha rule.

    Parameters
    ----------
    t_end : float
        Length of the run (s).
    dt : float, optional
        Fixed step. Without it steps follow the local error.
    rtol : float
        Tolerance of a step's local error, relative to displacement plus thickness: see :class:`LocalError`.
    steps
        Any other step control; overrides ``dt`` and ``rtol``.
    rho_inf : float
        Spectral radius at infinite frequency: 1 damps nothing, 0 most.
    outputs : int or times
        Number of equidistant output times, or the times. States between steps are interpolated with cubics.
    record : mapping of name to function of a Solution, optional
        Quantities kept at every accepted step.
    velocity : (n_dofs,) array, optional
        Initial velocity of the nodal coordinates.
    newton_rtol : float
        Newton's method ends when the energy of its correction is less than this squared times the largest kinetic energy
        so far, or the step's first correction.
    progress : bool
        Show a progress bar.

    Returns
    -------
    Motion
        A run that fails or is interrupted returns what it has, with its status and reason.

    Raises
    ------
    InputError
        For times, tolerances or velocities that cannot be used.
    """
    t_end = positive("t_end", t_end, "s")
    positive("newton_rtol", newton_rtol)
    for name, quantity in (record or {}).items():
        if not callable(quantity):
            raise InputError(f"record[{name!r}] = {quantity!r}: give a function of a Solution")
    if start is not None:
        require_same_mesh(system, start)
    warn_if_mass_is_off(system)
    begin = 0.0 if start is None or start.time is None else start.time
    times = _output_times(outputs, begin, begin + t_end)
    control = steps or (FixedStep(dt) if dt is not None else LocalError(rtol))
    q = system.undeformed.copy() if start is None else start.q.copy()
    v = _initial_velocity(system, velocity, start, begin, t_end)
    began = clock.perf_counter()
    with Progress("dynamics", t_end, shown=progress) as bar:
        run = _Run(system, GeneralizedAlpha(rho_inf), control, times, record or {}, newton_rtol, backend)
        status, message = run.go(q, v, begin, begin + t_end, bar)
    n = len(run.saved_q)
    return Motion(
        system, times[:n] if status is MotionStatus.FINISHED else np.array(run.saved_times),
        np.array(run.saved_q), np.array(run.saved_v), tuple(run.steps),
        {name: (np.array(run.record_times), np.array(values)) for name, values in run.values.items()},
        status, message, clock.perf_counter() - began,
    )  # fmt: skip


def _output_times(outputs: int | Sequence[float], begin: float, end: float) -> np.ndarray:
    if isinstance(outputs, (int, np.integer)):
        if outputs < 2:
            raise InputError(f"outputs = {outputs}: give at least 2 output times")
        return np.linspace(begin, end, int(outputs))
    times = finite("outputs", outputs)
    if times.ndim != 1 or len(times) < 1 or (np.diff(times) <= 0).any() or times[0] < begin or times[-1] > end:
        raise InputError(f"outputs: give ascending times between {begin} and {end} s")
    return times


def _initial_velocity(
    system: System, velocity: np.ndarray | None, start: Solution | None, begin: float, t_end: float
) -> np.ndarray:
    """The given velocity along free directions, the rate of the prescribed motion along the others."""
    moved = system.prescribed(begin)
    at = system.undeformed if start is None else start.q
    jump = np.abs(system.constraints.fixed_part(at - system.undeformed) - moved).max(initial=0.0)
    if jump > 1e-9 * np.abs(system.undeformed).max():
        raise InputError(f"a prescribed displacement jumps by {jump:.3g} at the start, t = {begin}; give it a history that "
                         "begins with the present state, as in history=lambda t: min(1.0, t / 0.1)")  # fmt: skip
    moment = 1e-7 * t_end
    rate = (system.prescribed(begin + moment) - moved) / moment
    if velocity is None:
        velocity = np.zeros(system.n_dofs) if start is None or start.velocity is None else start.velocity
    v = finite("velocity", velocity).ravel()
    if v.size != system.n_dofs:
        raise InputError(f"velocity has {v.size} entries; the system has {system.n_dofs} nodal coordinates")
    return system.constraints.free_part(v) + rate


class _Run:
    """State of one run; everything it keeps is usable whenever it stops."""

    def __init__(
        self, system: System, rule: GeneralizedAlpha, control: FixedStep | LocalError, times: np.ndarray,
        record: Mapping[str, Quantity], newton_rtol: float, backend: str,
    ):  # fmt: skip
        self.system, self.rule, self.control, self.times, self.record = system, rule, control, times, record
        self.solver = StepSolver(system, rule, newton_rtol, backend)
        self.saved_times: list[float] = []
        self.saved_q: list[np.ndarray] = []
        self.saved_v: list[np.ndarray] = []
        self.steps: list[Step] = []
        self.record_times: list[float] = []
        self.values: dict[str, list[Any]] = {name: [] for name in record}
        translation = np.zeros((system.n_dofs // 12, 4, 3))
        translation[:, 0, 0] = 1
        mass = np.abs((system.mass @ translation.ravel()).reshape(-1, 4, 3)[:, 0, 0])
        self.weights = mass / mass.sum()

    def size(self, u: np.ndarray) -> float:
        """Mass-weighted root mean square of positions."""
        r = u.reshape(-1, 4, 3)[:, 0]
        return float(np.sqrt(self.weights @ (r * r).sum(axis=1)))

    def go(self, q: np.ndarray, v: np.ndarray, begin: float, end: float, bar: Progress) -> tuple[MotionStatus, str]:
        try:
            return self._go(q, v, begin, end, bar)
        except KeyboardInterrupt:
            return MotionStatus.INTERRUPTED, f"interrupted from the keyboard at t = {self._reached(begin):.6g} s"
        except Exception as error:  # whatever a load, a record or the machine raises, what was computed is kept
            if not self.steps:
                raise
            return MotionStatus.FAILED, f"stopped at t = {self._reached(begin):.6g} s, what was computed is kept: {error!r}"
        finally:
            self.solver.close()

    def _go(self, q: np.ndarray, v: np.ndarray, begin: float, end: float, bar: Progress) -> tuple[MotionStatus, str]:
        a = self.solver.initial_acceleration(q, v, begin)
        thickness = self.system.problem.section.thickness
        guess = np.sqrt(2e-3 * thickness / max(self.size(a), 1e-300))
        dt = self.control.first(min(float(guess), (end - begin) / 20))
        shortest = dt * self.control.smallest
        t, largest = begin, thickness
        self._keep(t, q, v)
        self._save_until(t, t, q, q, v, v)
        while t < end - 1e-12 * (end - begin):
            step = min(dt, end - t)
            outcome = self.solver.step(q, v, a, t, step)
            error = np.inf
            if outcome.converged:
                error = self.size(self.rule.local_error(outcome.a - a, step)) / largest
            accepted = outcome.converged and self.control.accepts(error)
            self.steps.append(Step(t + step, step, error, outcome.iterations, outcome.factorisations, accepted))
            if accepted:
                self._save_until(t, t + step, q, outcome.q, v, outcome.v)
                t, q, v, a = t + step, outcome.q, outcome.v, outcome.a
                largest = max(largest, thickness + self.size(q - self.system.undeformed))
                self._keep(t, q, v)
            dt = self.control.next_step(dt if step < dt and accepted else step, error) if outcome.converged else step / 2
            bar.at(t - begin, f"t = {t:.4g} s, step {dt:.2g} s, {outcome.iterations} iterations")
            if dt < shortest:
                reason = outcome.message if not outcome.converged else f"local error {error:.1e}"
                return MotionStatus.STEP_TOO_SMALL, (
                    f"the run stopped at t = {t:.6g} s: its step fell to {dt:.1e} s ({reason}); "
                    "what was computed is kept. Look for a mechanism, an element that folds, or a load that jumps."
                )
        return MotionStatus.FINISHED, ""

    def _reached(self, begin: float) -> float:
        return max((step.time for step in self.steps if step.accepted), default=begin)

    def _keep(self, t: float, q: np.ndarray, v: np.ndarray) -> None:
        self.record_times.append(t)
        for name, quantity in self.record.items():
            self.values[name].append(quantity(Solution(self.system, q, v, t)))

    def _save_until(
        self, t0: float, t1: float, q0: np.ndarray, q1: np.ndarray, v0: np.ndarray, v1: np.ndarray
    ) -> None:
        """Save the states at the output times up to t1."""
        slack = 1e-9 * (self.times[-1] - self.times[0] + 1e-300)
        while len(self.saved_times) < len(self.times) and self.times[len(self.saved_times)] <= t1 + slack:
            t = float(self.times[len(self.saved_times)])
            q, v = (q1, v1) if t >= t1 - slack else hermite(t, np.array([t0, t1]), np.array([q0, q1]), np.array([v0, v1]))
            self.saved_times.append(t)
            self.saved_q.append(q)
            self.saved_v.append(v)
