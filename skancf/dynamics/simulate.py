"""Motion of a system: what a user asks, checked and handed to the loop."""

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skancf.arguments import choice, function, having, mapping, whole
from skancf.atomic import AnyPath
from skancf.dynamics.checkpoint import Checkpoint, Writer
from skancf.dynamics.energy_momentum import EnergyMomentum
from skancf.dynamics.fingerprint import fingerprint_of
from skancf.dynamics.initial import Velocity, initial_velocity
from skancf.dynamics.motion import Motion
from skancf.dynamics.motion_checks import warn_of
from skancf.dynamics.named_state import flat, nested
from skancf.dynamics.prescribed import RATE_STEP, prescribed_rate
from skancf.dynamics.recorder import Quantity, Recorder
from skancf.dynamics.rule import Rule
from skancf.dynamics.run import MeshPolicy, Run, Settings
from skancf.dynamics.steps import EnergyBalance, FixedStep, LocalError, StepControl
from skancf.dynamics.trapezoidal import Trapezoidal
from skancf.errors import InputError, finite, positive, shown
from skancf.history import Case, check_covers
from skancf.memory import require_much
from skancf.progress import Bar, ShowProgress, check_progress
from skancf.solution import Solution
from skancf.solving import Status
from skancf.states import StateLike
from skancf.statics.arguments import check_arguments
from skancf.system.system import System
from skancf.thinness import warn_if_mass_is_off
from skancf.tolerances import ONE_PLACE


def simulate(
    system: System,
    t_end: float,
    *,
    rtol: float = 1e-3,
    dt: float | None = None,
    steps: StepControl | None = None,
    rule: Rule | None = None,
    rho_inf: float | None = None,
    outputs: int | str | Sequence[float] = 201,
    record: Mapping[str, Quantity] | None = None,
    velocity: Velocity = None,
    start: StateLike | None = None,
    balance: float | str | None = "auto",
    follow: MeshPolicy | None = None,
    checkpoint: Checkpoint | AnyPath | None = None,
    resume: bool = False,
    newton_rtol: float | None = None,
    backend: str = "auto",
    check: bool = False,
    progress: ShowProgress = True,
) -> Motion:
    """Motion from the undeformed state at rest, or from ``start``.

    Parameters
    ----------
    t_end : float
        Length of the run (s).
    rtol : float
        Asked accuracy: errors of the steps add up to this part of the largest displacement by the end of the run, so that a
        longer run takes shorter steps; see :class:`LocalError`.
    dt : float, optional
        Fixed step (s) instead.
    steps
        Any other step control; overrides ``dt`` and ``rtol``.
    rule
        A rule of integration; default :class:`EnergyMomentum`.
    rho_inf : float, optional
        Short for ``rule=EnergyMomentum(rho_inf)``: spectral radius at infinite frequency, default 0.8; 1 keeps energy, 1/3
        damps most.
    outputs : int, times or "steps"
        Number of equidistant output times, or the times: states inside of steps are interpolated in a frame that turns with
        the body. ``"steps"``: the end of every step.
    record : mapping of name to function of a Solution, optional
        Quantities kept at every accepted step.
    velocity : RigidVelocity, function, or (n_dofs,) array, optional
        Initial velocity: of a rigid body; of the surface, a function of the parameters (x, y) that returns (3, ...); or
        rates of the nodal coordinates. Supports and conditions overrule it: the run begins with the nearest rates, in the
        norm of the mass, that keep them, and says so where they are others. Default: that of ``start``, or rest.
    balance : float, "auto" or None
        Largest part of the energy, and of the momenta, that may come or go without a source: a run whose energy leaves this
        tolerance stops, and one whose momenta left it has not finished. ``"auto"``: 1e-3 for :class:`EnergyMomentum`, 0.1
        for other rules. None: do not look.
    follow
        Meshes that follow the motion, see :class:`~skancf.Follow`.
    checkpoint : Checkpoint or folder, optional
        Write the run to a folder while it goes on: see :class:`Checkpoint`.
    resume : bool
        Go on with the run in that folder, to the same bytes as without a stop; begin it where the folder has none. The
        problem and all settings must be those it was begun with.
    newton_rtol : float, optional
        Newton's method ends when the energy of its correction is less than this squared times the largest kinetic energy
        so far, or the step's first correction. Default: that of the rule.
    check : bool
        Run again with steps of twice the length (four times ``rtol``), for a third to a half of the time more, and estimate
        the error by the difference: ``motion.error``.
    progress : bool or callable
        A bar, nothing, or a function that is told of each step; see :class:`~skancf.Progress`.

    Returns
    -------
    Motion
        A run that fails or is interrupted returns what it has, with its status and reason.

    Raises
    ------
    InputError
        For times, tolerances or velocities that cannot be used, a start that does not meet the conditions of the system, and
        with conditions for :class:`Trapezoidal`.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> system = strip.on(sk.meshes.uniform(strip.surface, 4, 1), "kirchhoff")
    >>> motion = sk.simulate(system, 0.01, rtol=1e-2, outputs=11, progress=False)
    >>> print(motion.status.value, motion.displacement((1.0, 0.05)).shape)
    finished (11, 3)
    """
    start = check_arguments(system, backend, start=start, resume=resume, check=check)
    check_progress(progress)
    t_end = positive("t_end", t_end, "s")
    _check(system, record, follow, rule)
    newton_rtol = None if newton_rtol is None else positive("newton_rtol", newton_rtol)
    rule = _rule(rule, rho_inf)
    balance = _balance(balance, rule)
    control = _control(steps, dt, rtol, rule)
    doubled = _doubled(control, follow) if check else None
    warn_if_mass_is_off(system)
    begin = 0.0 if start is None or start.time is None else start.time
    check_covers(system.histories(), begin, begin + t_end)
    times = output_times(outputs, begin, begin + t_end, system.n_dofs)
    _check_number_of_steps(control, t_end, system)
    q = system.undeformed.copy() if start is None else start.q.copy()
    v = _initial_velocity(system, velocity, start, begin, t_end)
    settings = Settings(rule, control, begin, begin + t_end, newton_rtol, balance, follow, backend)
    began, remembered = clock.perf_counter(), flat(system.terms.state())
    # A state that has a time is the one after what happened then.
    struck = start is not None and start.time is not None
    with Bar("dynamics", t_end, progress) as bar:
        run = Run(system, settings, Recorder(times, record or {}), q, v, struck)
        try:
            status, message, seconds = _go(run, bar, checkpoint, resume)
        finally:
            run.close()
    motion = run.motion(status, message)
    if doubled is not None and motion.ok:
        system.terms.restore(nested(remembered, system.terms.state()))
        with Bar("dynamics, steps twice as long", t_end, progress) as bar:
            again = Run(system, replace(settings, control=doubled), Recorder(motion.times, {}), q, v, struck)
            try:
                again.go(bar)
            finally:
                again.close()
        motion = replace(motion, error=_difference(motion, again) / ORDER)
    warn_of(motion)
    return replace(motion, seconds=clock.perf_counter() - began if seconds is None else seconds)


ORDER = 3
"""The error of a rule of order two is a third of what a step of twice the length changes."""


def _doubled(control: Any, follow: Any) -> StepControl:
    """The control whose steps are twice as long."""
    if follow is not None:
        raise InputError("check = True and follow: two runs have states on different meshes; compare a quantity of both, or "
                         "run without follow")  # fmt: skip
    if isinstance(control, LocalError):
        return replace(control, rtol=4 * control.rtol, atol=4 * control.atol, largest=2 * control.largest)
    if isinstance(control, FixedStep):
        return replace(control, dt=2 * control.dt)
    raise InputError(f"check = True and steps = {shown(control)}: steps of LocalError and FixedStep alone can be "
                     "doubled")  # fmt: skip


def _difference(motion: Motion, again: Run) -> np.ndarray:
    """Mass-weighted root mean squares at the output times; not a number where the second run did not come."""
    other = again.motion(Status.FINISHED, "")
    n = len(other.times)
    out = np.full(len(motion.times), np.nan)
    out[:n] = [again.measure.size(one - two) for one, two in zip(motion.q[:n], other.q, strict=True)]
    return out


def _go(run: Run, bar: Bar, checkpoint: Checkpoint | AnyPath | None, resume: bool) -> tuple[Status, str, float | None]:
    """The run, written to a folder if it is asked for, with the wall time of all its processes."""
    if checkpoint is None:
        if resume:
            raise InputError("resume = True: from which folder? Give it, as in checkpoint='run'")
        return *run.go(bar), None
    checkpoint = checkpoint if isinstance(checkpoint, Checkpoint) else Checkpoint(checkpoint)
    writer = Writer(checkpoint, run, fingerprint_of(run, run.recorder.quantities, checkpoint.every), resume)
    try:
        if writer.finished:
            return Status.FINISHED, "", writer.seconds
        status, message = run.go(bar, writer.after_step, lambda: writer.write(run, finished=True))
        if not status.ok:
            writer.stopped(run, status, message)
        return status, message, writer.seconds
    finally:
        writer.close()


def _balance(balance: float | str | None, rule: Rule) -> float | None:
    if isinstance(balance, str):
        choice("balance", balance, ("auto",))
        return rule.balance
    return None if balance is None else positive("balance", balance)


def _check(system: System, record: Any, follow: Any, rule: Any) -> None:
    _require_mass(system)
    if isinstance(rule, Trapezoidal) and system.conditions:
        names = ", ".join(map(repr, system.conditions.names))
        raise InputError(f"rule = Trapezoidal() cannot take conditions, and this system has {names}: its multipliers "
                         "would alternate from step to step and grow; those of the other rules do not")  # fmt: skip
    if follow is not None:
        having("follow", follow, ("change", "check"), "a policy of meshes, for example sk.Follow(rtol=0.2)")
        follow.check(system)
    if record is not None:
        mapping("record", record, "names and functions of a Solution, as in record={'tip': f}")
    for name, quantity in (record or {}).items():
        function(f"record[{name!r}]", quantity, "a function of a Solution")


def _control(steps: Any, dt: float | None, rtol: float, rule: Rule) -> StepControl:
    if steps is not None:
        having("steps", steps, ("first", "accepts", "next_step", "smallest"),
               "a step control, for example LocalError(1e-3), or a length as dt")  # fmt: skip
    positive("rtol", rtol)
    control: StepControl = steps or (FixedStep(dt) if dt is not None else LocalError(rtol))
    if isinstance(control, EnergyBalance) and isinstance(rule, EnergyMomentum):
        raise InputError("steps=EnergyBalance(...) with rule=EnergyMomentum(): this rule balances at any step, right or "
                         "wrong; control the steps by LocalError")  # fmt: skip
    return control


KEPT = 300
"""Bytes that a run keeps of each step, at least; measured."""


def _check_number_of_steps(control: Any, t_end: float, system: System) -> None:
    """Refuse a run of which what is kept of each step will not fit into memory."""
    longest = min(getattr(control, name, np.inf) for name in (["dt"] if isinstance(control, FixedStep) else ["largest"]))
    n = int(t_end / longest)
    kept = KEPT + (16 * system.conditions.n if system.conditions else 0)
    require_much(kept * n, f"t_end = {t_end} s in steps of {longest} s", f"what is kept of {n:.3g} steps",
                 "take longer steps, or a shorter run")  # fmt: skip


def _rule(rule: Rule | None, rho_inf: float | None) -> Rule:
    if rule is None:
        return EnergyMomentum() if rho_inf is None else EnergyMomentum(rho_inf)
    if rho_inf is not None:
        raise InputError(f"rho_inf = {rho_inf} and rule = {shown(rule)}: rho_inf is short for a rule; give one of them")
    if not isinstance(rule, Rule):
        raise InputError(f"rule = {shown(rule)}: give a rule of integration, for example GeneralizedAlpha(0.8)")
    return rule


def _require_mass(system: System) -> None:
    """InputError where an unknown that is free has no inertia; of the shell all have."""
    layout, free = system.layout, ~system.constraints.fixed
    none = free & (layout.blocks(system.mass.diagonal()) <= 0)
    own = none[system.geometry.n_nodes :]
    if own.any():
        name = layout.name_of(system.geometry.n_nodes + int(np.argmax(own.any(axis=1))))
        raise InputError(f"part {name!r} has unknowns without inertia, which do not move by an equation of motion: let its "
                         "term add a mass (add_mass), or hold them (held)")  # fmt: skip


def output_times(outputs: int | str | Sequence[float], begin: float, end: float, n_dofs: int = 12) -> np.ndarray | None:
    """The output times of a run; None for the end of every step."""
    if isinstance(outputs, str):
        choice("outputs", outputs, ("steps",))
        return None
    if isinstance(outputs, int | float | np.integer | np.floating):
        n = whole("outputs", outputs, least=2)
        require_much(16 * n * n_dofs, f"outputs = {n}", f"to keep states of {n_dofs} unknowns", "ask for fewer")
        return np.linspace(begin, end, n)
    times = finite("outputs", outputs)
    require_much(16 * times.size * n_dofs, f"outputs = {times.size} times", f"to keep states of {n_dofs} unknowns",
                 "ask for fewer")  # fmt: skip
    if times.ndim != 1 or len(times) < 1 or (np.diff(times) <= 0).any() or times[0] < begin or times[-1] > end:
        raise InputError(f"outputs: give ascending times between {begin} and {end} s")
    return times


def _initial_velocity(system: System, velocity: Velocity, start: Solution | None, begin: float, t_end: float) -> np.ndarray:
    """The given velocity along free directions, the rate of the prescribed motion along the others."""
    moved = system.prescribed(Case(time=begin))
    at = system.undeformed if start is None else start.q
    jump = np.abs(system.constraints.fixed_part(at - system.undeformed) - moved).max(initial=0.0)
    if jump > ONE_PLACE * np.abs(system.undeformed).max():
        raise InputError(f"a prescribed displacement jumps by {jump:.3g} at the start, t = {begin}; give it a history that "
                         "begins with the present state, as in history=lambda t: min(1.0, t / 0.1)")  # fmt: skip
    if missed := system.conditions.worst(at, Case(time=begin)):
        raise InputError(f"the start at t = {begin} does not meet the conditions: {missed}. Begin with a state that does, "
                         "as the end of a step, and let what depends on time begin there, with a history that is zero at "
                         "first")  # fmt: skip
    rate = prescribed_rate(system, begin, RATE_STEP * t_end)
    if velocity is None and start is not None:
        velocity = start.velocity
    return system.constraints.free_part(initial_velocity(system, at, velocity)) + rate
