"""The fingerprint of a run: what it was asked for, as arrays by name, written with it and compared before it goes on.

Those of one dimension or none are settings, others are products of large arrays with random vectors.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any

import numpy as np

from skancf.dynamics.named_state import flat
from skancf.dynamics.run import Run, Settings
from skancf.history import Case
from skancf.showing import in_full
from skancf.system.system import System
from skancf.tolerances import ABOVE_ZERO, SAME_VALUE
from skancf.version import __version__

VECTORS = 4
"""Products with this number of random vectors tell one array from another."""
TIMES, MOMENTS = 9, 257
"""Times at which forces, and functions of time, are compared."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")

Fingerprint = dict[str, np.ndarray]


def difference(fingerprint: Fingerprint, other: Fingerprint) -> str | None:
    """The first difference from what another run was asked for, in words, settings first; None if they agree."""
    for name in sorted(fingerprint, key=lambda name: fingerprint[name].ndim):
        value, known, title = fingerprint[name], other.get(name), name.replace("_", " ")
        if value.ndim < 2:
            here, there = (None if array is None else array.tolist() for array in (value, known))
            if here != there:
                return f"its run has {title} = {_short(there)}, this one {_short(here)}"
        elif known is None or known.shape != value.shape:
            return f"its run has another {title}"
        else:
            apart, size = np.abs(known - value), np.nanmax(np.abs([known, value]), initial=0.0)
            if not ((apart <= SAME_VALUE * size) | (np.isnan(known) & np.isnan(value))).all():
                part = np.nanmax(apart, initial=0.0) / max(size, ABOVE_ZERO)
                return f"its run has another {title}, by {part:.1e} of it"
    return None


def fingerprint_of(run: Run, names: Iterable[str], every: int) -> Fingerprint:
    """What makes a run what it is; ``names`` are those of its records."""
    settings = run.settings
    more = {"backend": run.solver.linear.description, "outputs": run.recorder.outputs, "record": sorted(names),
            "every": every, "version": __version__}  # fmt: skip
    own = {field.name: _said(getattr(settings, field.name)) for field in fields(Settings)}
    start = {"start": _products(run.now.q), "start_velocity": _products(run.now.v)}
    return fingerprint_of_problem(run.system, settings.begin, settings.end) | flat(own | more) | start


def fingerprint_of_problem(system: System, begin: float, end: float) -> Fingerprint:
    """The part of it that is the problem, its mesh and its theory, from ``begin`` to ``end``.

    Terms are seen by the sums of their forces on a state that is moved, at some times.
    """
    geometry, problem, at = system.geometry, system.problem, system.undeformed
    thickness = system.assembly.section.at(geometry.integration.local).thickness
    said = {"theory": geometry.theory, "material": problem.material, "damping": problem.damping}
    moved = at + 1e-3 * np.abs(at).max() * np.cos(np.arange(at.size))
    cases = [Case(time=time) for time in np.linspace(begin, end, TIMES).tolist()]
    moments = np.linspace(begin, end, MOMENTS).tolist()
    given = [*system.prescription.histories(), *system.loads.histories()]
    functions = [function for function in given if function is not None]
    arrays: dict[str, Any] = {
        "mesh": geometry.mesh.p, "elements": geometry.mesh.t, "surface": at, "supports": system.constraints.fixed,
        "support_motion": _at(system.prescribed, cases), "stiffness": system.internal_force(moved),
        "terms": _at(lambda case: system.others.force(moved, moved, case), cases),
        "mass": system.mass @ moved, "viscous_damping": 0 * at if system.viscous is None else system.viscous @ moved,
        "loads": _at(lambda case: system.applied_force(moved, case, moved), cases),
        "temperature": _at(lambda case: _or_zero(system.shell.initial_stress_force(moved, case), at), cases),
        "conditions": _at(lambda case: system.conditions.value(moved, case), cases),
        "impulses": np.array([np.append(impulse, time) for time, impulse in system.loads.impulses()]),
        **{f"function_of_time_{k}": _at(function, moments) for k, function in enumerate(functions, 1)},
    }  # fmt: skip
    if isinstance(thickness, np.ndarray):
        arrays["thickness"] = thickness.ravel()
    else:
        said["thickness"] = thickness
    return flat({name: _said(value) for name, value in said.items()}) | {
        name: _products(values) for name, values in arrays.items()}  # fmt: skip


def _or_zero(value: np.ndarray | None, like: np.ndarray) -> np.ndarray:
    return np.zeros_like(like) if value is None else value


def _at(function: Callable[[Any], Any], moments: list[Any]) -> np.ndarray:
    """Values at some times; nan where it has no value: that is found out when the run gets there."""
    out = [_tried(function, moment) for moment in moments]
    n = max(values.size for values in out)
    return np.array([values if values.size == n else np.full(n, np.nan) for values in out])


def _tried(function: Callable[[Any], Any], moment: Any) -> np.ndarray:
    try:
        return np.ravel(np.asarray(function(moment), dtype=float))
    except Exception:  # whatever a user's function raises, and it will do so again
        return np.empty(0)


def _products(values: np.ndarray) -> np.ndarray:
    rows = np.atleast_2d(np.asarray(values, dtype=float))
    return rows @ np.random.default_rng(0).standard_normal((rows.shape[-1], VECTORS))


def _said(value: Any) -> Any:
    """A number or a text as it is, anything else as a text without addresses."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, (int, float, str)):
        return value
    text = in_full(value)
    if ADDRESS.search(text) and hasattr(value, "__dict__") and not callable(value):
        text = f"{type(value).__qualname__}({vars(value)})"  # an object without a repr of its own
    return ADDRESS.sub("", text)


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) < 120 else text[:116] + " ..."
