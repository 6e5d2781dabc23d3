"""What a program shows of itself to be compared. Only the standard library, since every program's environment reads it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Variant:
    """One way to run a program: an element, a solver, a kind of mesh.

    Attributes
    ----------
    label : str
        As it stands in charts and tables.
    theory : str
        ``"thin"``, ``"small"`` or ``"thick"``: with which reference values it is compared; see :class:`Quantity`.
    sizes : mapping
        For each scene that it runs, the finenesses in the order of growing cost; what a size means is up to the program.
    cannot : mapping
        For each scene that it does not run, the reason; scenes in which its theory has no limit say so themselves.
    """

    label: str
    theory: str
    sizes: Mapping[str, Sequence[float]]
    cannot: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """``values`` by the names of the scene's quantities, ``dofs`` the coordinates that are solved for, ``note`` steps and
    iterations."""

    values: Mapping[str, Any]
    dofs: int
    note: str = ""


@dataclass(frozen=True)
class Program:
    """A program with its variants.

    ``run(scene, variant, size)`` builds the model, solves it and returns the outcome; it raises when it fails. ``prepare()``
    imports the program, and ``version()`` tells which it is: neither is timed. ``environment`` is the folder below
    ``peers/`` that it runs in, or None for that of this project.
    """

    name: str
    variants: Mapping[str, Variant]
    prepare: Callable[[], None]
    version: Callable[[], str]
    run: Callable[[Any, str, float], Outcome]
    environment: str | None = None
