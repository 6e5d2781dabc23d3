"""Strategies for small motions: free bodies and held ones, with loads over time, velocities, damping, and every rule."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

import skancf as sk
from fuzz import bodies, conditions
from fuzz.assessment import stated
from fuzz.bodies import among
from fuzz.case import Case
from fuzz.cases import UNITS, Frame, _proper
from fuzz.shapes import extent, open_sides
from fuzz.transforms import in_frame, in_units


@dataclass(frozen=True)
class Moving:
    """A motion: times in periods of the slowest mode, the velocity in sizes of the body in such a period."""

    case: Case
    rule: Any
    periods: float
    steps: int
    velocity: tuple[float, float, float] | None
    spin: tuple[float, float, float]
    history: str
    frame: Frame = Frame(np.eye(3), np.zeros(3))  # noqa: RUF009
    units: tuple[float, float] = (1.0, 1.0)
    damping: tuple[float, float] | None = None


HISTORIES = {
    "always": lambda T: None,
    "ramp": lambda T: sk.Ramp(0.4 * T, 0.1 * T),
    "sine": lambda T: sk.Pulse(0.5 * T, 0.2 * T),
    "triangle": lambda T: sk.Pulse(0.3 * T, shape="triangle"),
    "rectangle": lambda T: sk.Pulse(0.25 * T, 0.4 * T, "rectangle"),
    "table": lambda T: sk.Table([0.0, 0.3 * T, T], [0.0, 1.0, -0.5]),
}  # fmt: skip
RULES = among(
    sk.EnergyMomentum(), sk.EnergyMomentum(), sk.EnergyMomentum(1 / 3), sk.EnergyMomentum(1.0), sk.GeneralizedAlpha(),
    sk.ImplicitMidpoint(), sk.Trapezoidal(),
)  # fmt: skip
KEEPING = among(sk.EnergyMomentum(), sk.EnergyMomentum(1 / 3), sk.EnergyMomentum(0.6), sk.EnergyMomentum(1.0))
NONE = (0.0, 0.0, 0.0)


STEPS = among(6, 12)


@st.composite
def motions(
    draw: Any, rules: Any = RULES, free: bool | None = None, loads: bool = True, spin: bool = True, steps: Any = STEPS
) -> Moving:
    """A body of up to 2 x 2 elements, more around; loads bend it by a hundredth of its thickness to twice that."""
    surface = draw(st.one_of(*[bodies.SURFACES[n] for n in ("rectangle", "parallelogram", "cylinder", "annulus", "saddle")]))
    section = draw(bodies.sections(among(10.0, 30.0, 100.0)))
    mesh = draw(bodies.meshes(surface, plain=True, most=2))
    held = not (draw(st.booleans()) if free is None else free)
    side = draw(among(*open_sides(surface)))
    supports = [draw(among(sk.Clamp(side), sk.SimpleSupport("boundary"), sk.Clamp("boundary")))] if held else []
    size = draw(among(1e-2, 0.3))
    acting = draw(st.lists(conditions.loads(surface, section, size, conditions.DEAD), min_size=1, max_size=2))
    damping = draw(among(None, None, (0.1, 0.0), (0.0, 0.02)))
    still = held or (loads and draw(st.booleans()))
    v, w = among((1.0, 0.0, 0.5), NONE, (-0.3, 2.0, 0.1)), among((0.5, 0.0, 0.0), (0.3, -1.0, 2.0), (0.0, 0.0, 4.0))
    problem = sk.Problem(surface, section.thickness, section.material, supports, acting if loads else [])
    return Moving(
        Case(problem, mesh, draw(among("kirchhoff", "full"))), draw(rules), draw(among(0.1, 0.6, 1.5)), draw(steps),
        (draw(v) if not held else (0.0, 0.0, 0.02)) if not still or not loads else None,
        draw(w) if spin and not held and not still else NONE, draw(among(*HISTORIES)), damping=damping,
    )  # fmt: skip


def at_rest(moving: Moving) -> Moving:
    """The same without a velocity at the start."""
    return replace(moving, velocity=None, spin=NONE)


@st.composite
def restated(draw: Any, what: str) -> Moving:
    """A motion and another frame, proper or mirrored, or other units."""
    motion = draw(motions(steps=among(6)))
    if what == "units":
        return replace(motion, units=draw(UNITS.filter(lambda u: u != (1.0, 1.0))))
    turn = _proper(draw(st.integers(0, 20)))
    if draw(st.booleans()):
        turn = turn @ np.diag([1.0, 1.0, -1.0])
    size = extent(motion.case.problem.surface)
    return replace(motion, frame=Frame(turn, size * np.array(draw(among(NONE, (1.0, -2.0, 0.5))))))


def period_of(moving: Moving) -> float:
    """Of the slowest mode that deforms the body as it is stated first (s)."""
    with stated():
        found = sk.modes(replace(moving.case, problem=replace(moving.case.problem, loads=[])).system(), 7)
    elastic = found.omega[found.omega > 1e-3 * found.omega[-1]]
    return float(2 * np.pi / elastic[0])


def prepared(moving: Moving, period: float, factor: float = 1.0, there: bool = False) -> tuple[Any, dict[str, Any]]:
    """System and options of ``simulate``; ``there``: in the other frame and units, ``factor``: of the loads."""
    t_end = moving.periods * period
    history = HISTORIES[moving.history](t_end)
    loads = [_scaled(load, factor) for load in moving.case.problem.loads]
    if history is not None:
        loads = [replace(load, history=history) if hasattr(load, "history") else load for load in loads]
    damping = None
    if moving.damping:
        damping = sk.Damping(mass=moving.damping[0] / period, stiffness=moving.damping[1] * period)
    case = replace(moving.case, problem=replace(moving.case.problem, loads=loads, damping=damping))
    size = extent(case.problem.surface)
    v, w, about = (np.array(x, float) for x in (moving.velocity or NONE, moving.spin, NONE))
    v, w = v * size / period, w / period
    if there:
        (turn, shift), (length, force) = moving.frame, moving.units
        case = in_frame(case, turn, shift) if (length, force) == (1.0, 1.0) else in_units(case, length, force)
        v, w, about = length * (turn @ v), np.linalg.det(turn) * (turn @ w), length * (turn @ about + shift)
    velocity = sk.RigidVelocity(tuple(v.tolist()), tuple(w.tolist()), tuple(about.tolist())) if moving.velocity else None
    with stated():
        system = case.system()
    return system, {"t_end": t_end, "rule": moving.rule, "velocity": velocity}


def _scaled(load: Any, factor: float) -> Any:
    for name in ("force", "moment", "acceleration"):
        if hasattr(load, name):
            return replace(load, **{name: tuple((factor * np.array(getattr(load, name))).tolist())})
    raise TypeError(f"{load}: say here what it is proportional to")
