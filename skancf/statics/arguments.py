"""Arguments of solvers for states of rest, checked before any work."""

from typing import Any

from skancf.arguments import flag, system_like, whole
from skancf.errors import InputError, positive
from skancf.linear import check_backend
from skancf.solution import Solution
from skancf.states import solution_of
from skancf.system.system import System


def check_arguments(
    system: Any, backend: Any, *, start: Any = None, rtol: Any = 1.0, counts: dict[str, Any] | None = None, **flags: Any
) -> Solution | None:
    """The state to start from, if one is given; InputError for what is no system, solver, state of the system, tolerance,
    whole number or truth value.

    Parameters
    ----------
    counts : mapping from name to number
        Whole numbers of at least one.
    **flags
        True or False.
    """
    system_like(system)
    check_backend(backend)
    state = None if start is None else state_on_mesh(system, start)
    positive("rtol", rtol)
    for name, value in (counts or {}).items():
        whole(name, value, floats=True)
    for name, value in flags.items():
        flag(name, value)
    return state


def state_on_mesh(system: System, given: Any, name: str = "start") -> Solution:
    """A state of a system; InputError for one of another mesh or another theory, and for what is no state."""
    start = solution_of(name, given)
    if start.system.mesh is not system.mesh:
        raise InputError(f"{name} belongs to another mesh; nodal coordinates have a meaning only on their own one")
    if start.system.geometry.theory.nodal_vectors != system.geometry.theory.nodal_vectors:
        raise InputError(
            f"{name} is a state of theory {start.system.geometry.theory.name!r}; its nodal vectors are others "
            f"than those of {system.geometry.theory.name!r}"
        )
    return start
