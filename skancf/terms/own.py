"""Terms and parts of a user's own, looked at when a system is made: what is wrong with one is told by its name, before any
work."""

from typing import Any

import numpy as np

from skancf.arguments import having
from skancf.errors import InputError, shown
from skancf.functions import Noted, is_ours
from skancf.history import FULL
from skancf.layout.geometry import Geometry
from skancf.layout.layout import Layout, Part
from skancf.terms.term import Addition, Term

NAMES = [name for name in vars(Term) if not name.startswith("_")]


def part_of(addition: Addition, geometry: Geometry) -> Part | None:
    """The unknowns of an addition on a mesh.

    Raises
    ------
    InputError
        For what is no part, and for a nodal one that has not one block for each node.
    """
    with Noted("terms.part"):
        part = addition.part(geometry)
    if part is None:
        return None
    if not isinstance(part, Part):
        raise InputError(f"part() of {shown(addition)} returned {shown(part)}; return a skancf.layout.layout.Part, or None "
                         "where its terms have no unknowns of their own")  # fmt: skip
    if part.nodal and len(part) != geometry.n_nodes:
        raise InputError(f"part {part.name!r} is nodal and has {len(part)} blocks: give one for each of the "
                         f"{geometry.n_nodes} nodes of geometry, or nodal=False")  # fmt: skip
    return part


def term_of(addition: Addition, shell: Any, layout: Layout) -> Term:
    """The term of an addition on a layout, asked once in the undeformed state where it does not come from this library.

    Raises
    ------
    InputError
        For what is no term, cells that are no blocks of the layout, a force or an energy of another shape or not finite
        there, and invalid functions of time. What the term itself raises passes through with a note.
    """
    with Noted("terms.on"):
        term: Term = addition.on(shell, layout)
    if is_ours(term):
        return term
    name = f"the term of {shown(addition)}"
    having(name, term, NAMES, "one term from on(), of a class that is derived from skancf.terms.Term")
    if getattr(type(term), "force", None) is Term.force:
        raise InputError(f"{name}, a {type(term).__name__}, has no force: write force(self, q, v, case), which returns "
                         f"{layout.n_dofs} numbers")  # fmt: skip
    q = layout.undeformed.ravel().copy()
    q.flags.writeable = False  # a term that writes into what it is given is stopped here
    with Noted("terms: couples() of a term"):
        cells = term.couples()
    check_cells(cells, layout)
    with Noted("terms: force, energy, histories or impulse of a term"):
        force, energy, histories, impulse = term.force(q, None, FULL), term.energy(q, FULL), term.histories(), term.impulse()
    check_force(force, layout.n_dofs)
    check_energy(energy)
    if not isinstance(histories, list | tuple) or not all(each is None or callable(each) for each in histories):
        raise InputError(f"histories() of {name}: {shown(histories)}; return a list of functions of time, or of None")
    if impulse is not None and not (isinstance(impulse, tuple) and len(impulse) == 2):
        raise InputError(f"impulse() of {name}: {shown(impulse)}; return a time and {layout.n_dofs} numbers, or None")
    return term


def check_cells(cells: Any, layout: Layout) -> None:
    """InputError for cells (m, n) that are no whole numbers, or name blocks that the layout has not."""
    if not isinstance(cells, np.ndarray) or cells.ndim != 2 or cells.dtype.kind not in "iu":
        raise InputError(f"couples(): {shown(cells)}; give an array (m, n) of whole numbers, a row for each cell")
    outside = cells[(cells < 0) | (cells >= layout.n_blocks)]
    if outside.size:
        raise InputError(f"couples(): block {outside[0]} does not exist; the layout has blocks 0 to {layout.n_blocks - 1}, "
                         f"in parts {', '.join(repr(part.name) for part in layout.parts)}")  # fmt: skip


def check_force(force: Any, n: int) -> None:
    """InputError for what are not n finite real numbers."""
    array = np.asarray(force)
    if array.shape != (n,) or array.dtype.kind not in "fiu" or not np.isfinite(array).all():
        raise InputError(f"force: {shown(force)}, of shape {array.shape}; give {n} finite numbers, one for each unknown")


def check_energy(energy: Any) -> None:
    """InputError for what is neither None nor one finite real number."""
    if energy is None:
        return
    array = np.asarray(energy)
    if array.ndim or array.dtype.kind not in "fiu" or not np.isfinite(array):
        raise InputError(f"energy: {shown(energy)}; give one finite number, or None where there is no potential")
