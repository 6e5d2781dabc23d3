"""Arguments of solvers for states of rest, checked before any work."""

from typing import Any

from skancf.arguments import flag, system_like, whole
from skancf.errors import positive
from skancf.linear import check_backend
from skancf.solution import require_same_mesh


def check_arguments(
    system: Any, backend: Any, *, start: Any = None, rtol: Any = 1.0, counts: dict[str, Any] | None = None, **flags: Any
) -> None:
    """InputError for what is no system, solver, state of the system, tolerance, whole number or truth value.

    Parameters
    ----------
    counts : mapping from name to number
        Whole numbers of at least one.
    **flags
        True or False.
    """
    system_like(system)
    check_backend(backend)
    if start is not None:
        require_same_mesh(system, start)
    positive("rtol", rtol)
    for name, value in (counts or {}).items():
        whole(name, value, floats=True)
    for name, value in flags.items():
        flag(name, value)
