"""How objects show themselves: in one line at a prompt, and with a picture in a notebook.

Inputs show the call that makes them, with their defaults left out. Results show what a person wants to know of them. Arrays,
functions and long lists are told in a few words, and nothing is computed that takes longer than looking through an array. An
object that is not whole, as in a debugger or after an exception in its constructor, shows what it has.
"""

import importlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from math import isfinite
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

import numpy as np

FEW = 6
"""Numbers of an array, and items of a list, that are all shown."""
LONG, WHOLE = 240, 960
"""Characters of one field, and of a whole object, before the rest is left out."""
NOTEBOOK, VIEWER = "skancf.output.notebook", "skancf.output.viewer"
"""They draw, so they are of the last room, and are loaded when a notebook or the user first asks for that."""


def short(self: Any) -> str:
    """A dataclass or named tuple as the call that makes it, without fields that have their defaults; a ``__repr__``."""
    shown = [f"{name}={brief(value)}" for name, value in _parts(self)]
    return _cut(f"{type(self).__name__}({', '.join(shown)})", WHOLE)


def _parts(self: Any) -> Iterator[tuple[str, Any]]:
    """Names and values of fields that are there and have no default."""
    if isinstance(self, tuple):
        yield from zip(getattr(self, "_fields", ()), self, strict=False)
    for part in fields(self) if is_dataclass(self) else ():
        value = getattr(self, part.name, MISSING) if part.init and part.repr else MISSING
        if value is not MISSING and not _is_default(value, part):
            yield part.name, value


def _is_default(value: Any, part: Any) -> bool:
    default = part.default_factory() if part.default_factory is not MISSING else part.default
    return value is default or (type(value) is type(default) and isinstance(value, bool | int | float | str | tuple)
                                and repr(value) == repr(default))  # fmt: skip


def in_full(value: Any) -> str:
    """A value as Python that makes it again, nothing left out, where its parts allow that; ``repr`` is shorter."""
    if is_dataclass(value) and not isinstance(value, type):
        parts = [f"{part.name}={in_full(getattr(value, part.name))}" for part in fields(value) if part.repr]
        return f"{type(value).__qualname__}({', '.join(parts)})"
    if type(value) in (list, tuple):
        ends, items = ("[]" if type(value) is list else "()"), [in_full(item) for item in value]
        return ends[0] + ", ".join(items) + ("," if type(value) is tuple and len(value) == 1 else "") + ends[1]
    return repr(value)


def brief(value: Any) -> str:
    """A value in a few words, on one line."""
    try:
        return _cut(" ".join(_brief(value).split()))
    except Exception:  # of an object that is not whole, or of the user's own class
        return f"<{type(value).__name__}>"


def _brief(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return repr(value.tolist()) if value.size <= FEW else f"<array of shape {value.shape}>"
    if isinstance(value, FunctionType | MethodType | BuiltinFunctionType):
        return f"<function {value.__name__}>"
    if type(value) in (list, tuple):
        items = [brief(item) for item in value[:FEW]]
        if len(value) > FEW:
            items.append(f"... {len(value) - FEW} more")
        ends = "[]" if type(value) is list else "()"
        return ends[0] + ", ".join(items) + ("," if type(value) is tuple and len(value) == 1 else "") + ends[1]
    if isinstance(value, Mapping) and len(value) > FEW:
        return f"<{len(value)} entries: {', '.join(map(str, list(value)[:FEW]))}, ...>"
    if hasattr(value, "nnz") and hasattr(value, "shape"):
        return f"<sparse matrix of shape {value.shape}, {value.nnz} entries>"
    if hasattr(value, "nelements") and hasattr(value, "nvertices"):
        return f"<{type(value).__name__}: {value.nelements} elements, {value.nvertices} nodes>"
    return repr(value)


def _cut(text: str, most: int = LONG) -> str:
    return text if len(text) <= most else f"{text[: most - 4]} ..."


def summary(method: Callable[[Any], str]) -> Callable[[Any], str]:
    """Decorates a ``__str__`` that says what a person wants to know; an object that is not whole shows its fields."""

    @wraps(method)
    def words(self: Any) -> str:
        try:
            return method(self)
        except Exception:
            return short(self)

    return words


def in_brackets(self: Any) -> str:
    """What ``str`` says, with the name of the class; a ``__repr__``."""
    said, name = str(self), type(self).__name__
    if said.startswith(f"{name}("):
        return said
    return f"<{said}>" if said.startswith(name) else f"<{name}: {said}>"


def listed(self: Any) -> str:
    """The first items of a sequence with a class of its own; a ``__repr__``."""
    return f"{type(self).__name__}({brief(tuple(self))})"


def in_a_notebook(self: Any) -> str | None:
    """A table and a picture, as a page of HTML; a ``_repr_html_``. None, and a notebook shows the line, where that fails."""
    try:
        page: str = importlib.import_module(NOTEBOOK).page(self)
    except Exception:
        return None
    return page


def looked_at(self: Any, **options: Any) -> Any:
    """Look at it in a window, or in a notebook on a page: see :func:`skancf.output.view`."""
    return importlib.import_module(VIEWER).view(self, **options)


# --- words that several results use ------------------------------------------------------------------------------------


def counted(n: int, what: str, many: str = "") -> str:
    """``1 node``, ``3 nodes``."""
    return f"{n} {what if n == 1 else many or what + 's'}"


def some(values: Any, unit: str = "") -> str:
    """The first numbers of a row."""
    row = np.asarray(values).ravel()
    said = ", ".join(f"{value:.5g}" for value in row[:FEW])
    return f"{said}{' ' + unit if unit and row.size else ''}" + (f", ... ({row.size})" if row.size > FEW else "")


def passed(checks: Any) -> str:
    """How many checks passed, and the names of those that did not; nothing without checks."""
    failed = [check.name for check in checks if not check.passed]
    if not checks:
        return ""
    if not failed:
        return f"; checks: {len(checks)} passed"
    return f"; checks: {len(checks) - len(failed)} of {len(checks)} passed, FAILED: {', '.join(failed)}"


def span(low: float, high: float, unit: str = "") -> str:
    """``0 to 0.5 s``."""
    return f"{low:.4g} to {high:.4g}{' ' + unit if unit else ''}" if isfinite(low + high) else "unknown"


@summary
def system_in_words(self: Any) -> str:
    """Theory, mesh and unknowns of a system."""
    mesh = self.mesh
    sizes = [(mesh.nelements, "element"), (mesh.nvertices, "node"), (self.n_dofs, "unknown")]
    return ", ".join([f"theory {self.geometry.theory.name}", *(counted(n, what) for n, what in sizes)])


@summary
def state_in_words(self: Any) -> str:
    """A state, after the name of its class."""
    return f"{type(self).__name__}: {of_state(self)}"


def of_state(state: Any) -> str:
    """What a person wants to know of a state."""
    parts = [str(state.system)]
    if state.time is not None:
        parts.append(f"t = {state.time:.4g} s")
    if state.load_factor != 1:
        parts.append(f"load factor {state.load_factor:.5g}")
    parts += ["small deflections"] * state.linear + [state.note] * bool(state.note)
    return ", ".join([*parts, f"largest displacement {largest_displacement(state)}"])


def largest_displacement(state: Any) -> str:
    """Of the nodes of the mesh, and where that is."""
    moved = np.linalg.norm(state.displacements, axis=0)
    k = int(np.argmax(moved))
    return f"{moved[k]:.4g} at ({', '.join(f'{x:.4g}' for x in state.system.mesh.p[:, k])})"
