"""From a problem and a mesh to the terms of a system."""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from skancf.arguments import having
from skancf.conditions.closing import close_gaps
from skancf.conditions.own import conditions_of
from skancf.errors import InputError, OutOfDepth, shown
from skancf.functions import Noted, is_ours
from skancf.history import FULL
from skancf.layout.constrain import constrain
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout, Part
from skancf.loads.acting import Acting
from skancf.system.rebuild import Bare
from skancf.system.system import System
from skancf.terms.load import LoadTerm
from skancf.terms.own import part_of, term_of
from skancf.terms.protocols import Assembly
from skancf.terms.shell import Shell
from skancf.terms.shell_at_points import ShellAtPoints
from skancf.terms.shells.assemble import assemble
from skancf.terms.springs import Dashpots, Springs
from skancf.terms.term import Term

PLATE = "plate"
"""Name of the part of a layout that is the mesh of a problem."""


def build(problem: Any, geometry: Geometry) -> System:
    """The system of a problem on a mesh: its layout, its terms, and what supports hold."""
    close_gaps(problem.conditions, geometry)
    assembly = assemble(geometry, problem.section)
    own = [part for part in (part_of(addition, geometry) for addition in problem.terms) if part is not None]
    layout = Layout([Part(PLATE, geometry.undeformed, geometry.scales, geometry.undeformed[:, 0]), *own])
    acting = [_acting(load, assembly) for load in problem.loads]
    heats = [load for load in acting if load.initial_stresses(FULL) is not None]
    retardation = 0.0 if problem.damping is None else float(problem.damping.stiffness)
    shell = (Shell if assembly.linear else ShellAtPoints)(assembly, layout, PLATE, heats, retardation)
    springs, dashpots = (_matrices(name, problem.supports, assembly) for name in ("springs", "dashpots"))
    terms: list[Term] = [Springs(springs, shell)] if springs else []
    terms += [Dashpots(dashpots, shell)] if dashpots else []
    terms += [term_of(addition, shell, layout) for addition in problem.terms]
    terms += [LoadTerm(load, shell) for load in acting]
    constraints, prescription = constrain(geometry, problem.supports, layout)
    conditions = conditions_of(problem.conditions, shell, layout)
    system = System(layout, shell, terms, constraints, prescription, problem, conditions)
    system.rebuilt = rebuilt
    return system


def rebuilt(problem: Any, mesh: Any, theory: Any, state: Mapping[str, Any], choice: Any) -> System:
    """A system as it was, of what :class:`~skancf.system.rebuild.Rebuilt` gives; what was warned of then is not said
    again."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OutOfDepth)
        system = build(problem, Geometry(mesh.made() if isinstance(mesh, Bare) else mesh, problem.surface, theory))
    system.terms.restore(dict(state))
    system.choice = choice
    return system


def _acting(load: Any, assembly: Assembly) -> Any:
    """What a load is on a mesh; checked where the load does not come from this library."""
    if is_ours(load):
        return load.on(assembly)
    with Noted("load.on"):
        acting = load.on(assembly)
    having(f"load.on of {shown(load)}", acting, [name for name in vars(Acting) if not name.startswith("_")],
           "what acts on the mesh, of a class that is derived from skancf.loads.acting.Acting")  # fmt: skip
    start, shape = assembly.geometry.undeformed, assembly.sections.reference.shape[1:]
    with Noted("load.force or load.initial_stresses"):
        force, stresses = acting.force(start.copy(), FULL), acting.initial_stresses(FULL)
    _check_values(f"force of the load {shown(load)}", force, start.shape)
    if stresses is not None:
        _check_values(f"initial_stresses of the load {shown(load)}", stresses, (assembly.geometry.n_elements, *shape))
    return acting


def _check_values(name: str, values: Any, shape: tuple[int, ...]) -> None:
    array = np.asarray(values)
    if array.shape != shape or array.dtype.kind not in "fiu" or not np.isfinite(array).all():
        raise InputError(f"{name} in the undeformed state = {shown(values)}, of shape {array.shape}; give finite numbers of "
                         f"shape {shape}")  # fmt: skip


def _matrices(name: str, supports: Sequence[Any], assembly: Assembly) -> list[tuple[np.ndarray, np.ndarray]]:
    """Elements and matrices of springs or dashpots of all supports."""
    out = []
    for support in supports:
        with Noted(f"support.{name}", but=(Exception,) * is_ours(support)):
            out += [(np.asarray(elements), np.asarray(each)) for elements, each in getattr(support, name)(assembly)]
    return out
