"""What a run was asked for, in a form that is written beside it and compared before it goes on."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import numpy as np

from skancf.dynamics.run import Run, Settings
from skancf.history import Case
from skancf.system.system import System
from skancf.version import __version__

CLOSE = 1e-9
"""Arrays of one problem differ by rounding at most."""
VECTORS = 4
"""Products with so many random vectors tell one array from another."""
TIMES, MOMENTS = 9, 257
"""Times at which forces, and functions of time, are compared."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


@dataclass(frozen=True)
class Asked:
    """Settings that can be written as text, and arrays by their shape and their products with random vectors."""

    settings: dict[str, Any]
    shapes: dict[str, list[int]]
    arrays: dict[str, np.ndarray]

    def difference(self, other: "Asked") -> str | None:
        """The first difference from what another run was asked for, in words; None if there is none."""
        for name, value in self.settings.items():
            if other.settings.get(name) != value:
                return f"its run has {_name(name)} = {_short(other.settings.get(name))}, this one {_short(value)}"
        for name, value in self.arrays.items():
            known = other.arrays.get(name)
            if known is None or other.shapes.get(name) != self.shapes[name] or known.shape != value.shape:
                return f"its run has another {_name(name)}"
            apart, size = np.abs(known - value), np.nanmax(np.abs([known, value]), initial=0.0)
            if not ((apart <= CLOSE * size) | (np.isnan(known) & np.isnan(value))).all():
                part = np.nanmax(apart, initial=0.0) / max(size, 1e-300)
                return f"its run has another {_name(name)}, by {part:.1e} of it"
        return None


def asked_of(run: Run, names: Iterable[str], every: int) -> Asked:
    """What makes a run what it is; ``names`` are those of its records."""
    settings, system = run.settings, run.system
    text = {field.name: plain(getattr(settings, field.name)) for field in fields(Settings)}
    text |= {"backend": run.solver.linear.description, "outputs": run.recorder.asked, "record": sorted(names),
             "every": every, "version": __version__}  # fmt: skip
    problem = asked_problem(system, settings.begin, settings.end)
    start = {"start": run.state.q, "start_velocity": run.state.v}
    shapes = {name: list(values.shape) for name, values in start.items()}
    arrays = {name: _products(values) for name, values in start.items()}
    return Asked(problem.settings | text, problem.shapes | shapes, problem.arrays | arrays)


def asked_problem(system: System, begin: float, end: float) -> Asked:
    """The part of it that is the problem, its mesh and its theory, from ``begin`` to ``end``."""
    geometry, problem, at = system.geometry, system.problem, system.undeformed
    text = {"theory": plain(geometry.theory), "thickness": plain(problem.section.thickness),
            "material": plain(problem.material), "damping": plain(problem.damping)}  # fmt: skip
    moved = at + 1e-3 * np.abs(at).max() * np.cos(np.arange(at.size))
    times, moments = np.linspace(begin, end, TIMES), np.linspace(begin, end, MOMENTS)
    given = [*system.prescription.histories(), *system.loads.histories()]
    functions = [partial(_raveled, function) for function in given if function is not None]
    none = np.zeros(at.size)
    arrays = {
        "mesh": geometry.mesh.p, "elements": geometry.mesh.t, "surface": at, "supports": system.constraints.fixed,
        "support_motion": _at(lambda t: system.prescribed(Case(time=t)), times), "stiffness": system.internal_force(moved),
        "mass": system.mass @ moved, "viscous_damping": none if system.viscous is None else system.viscous @ moved,
        "loads": _at(lambda t: system.applied_force(moved, Case(time=t)), times),
        "temperature": _at(lambda t: _or(system.shell.held_back_force(moved, Case(time=t)), none), times),
        "impulses": np.array([np.append(impulse, time) for time, impulse in system.loads.impulses()]),
        **{f"function_of_time_{k}": _at(function, moments) for k, function in enumerate(functions, 1)},
    }  # fmt: skip
    shapes = {name: list(np.shape(values)) for name, values in arrays.items()}
    return Asked(text, shapes, {name: _products(values) for name, values in arrays.items()})


def _or(value: np.ndarray | None, none: np.ndarray) -> np.ndarray:
    return none if value is None else value


def _raveled(function: Callable[[float], Any], time: float) -> np.ndarray:
    return np.ravel(function(time))


def _at(function: Callable[[float], Any], times: np.ndarray) -> np.ndarray:
    """Values at times; nan where there is none: that is found out when the run gets there."""
    out = [_tried(function, time) for time in times.tolist()]
    n = max(values.size for values in out)
    return np.array([values if values.size == n else np.full(n, np.nan) for values in out])


def _tried(function: Callable[[float], Any], time: float) -> np.ndarray:
    try:
        return np.asarray(function(time), dtype=float)
    except Exception:  # whatever a user's function raises, and it will do so again
        return np.empty(0)


def _products(values: np.ndarray) -> np.ndarray:
    rows = np.atleast_2d(np.asarray(values, dtype=float))
    return rows @ np.random.default_rng(0).standard_normal((rows.shape[-1], VECTORS))


def plain(value: Any) -> Any:
    """A number or a text as it is, anything else as a text without addresses."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, (int, float, str)):
        return value
    text = repr(value)
    if ADDRESS.search(text) and hasattr(value, "__dict__") and not callable(value):
        text = f"{type(value).__qualname__}({vars(value)})"  # an object without a repr of its own
    return ADDRESS.sub("", text)


def _name(name: str) -> str:
    return name.replace("_", " ")


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) < 120 else text[:116] + " ..."
