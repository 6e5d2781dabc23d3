r"""What a form sees of a surface: the fields ``w``, by name.

Small letters are of the deformed surface, capitals of the undeformed one; the arrays have the components first and then
elements and points, as those of scikit-fem. The fields come from the vectors of the theory at a point, its *jet*: r, r_x,
r_y and r_xx, r_xy, r_yy in theory `kirchhoff`, or the director d, d_x, d_y in theory `full`. Everything else is a formula of
them, computed where a form asks for it; what a form never reads is never differentiated.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from skancf.errors import InputError
from skancf.history import Case
from skancf.vectors import cross

THIN = ("r", "r_x", "r_y", "r_xx", "r_xy", "r_yy")
THICK = ("r", "r_x", "r_y", "d", "d_x", "d_y")
VELOCITY = "v"
"""Of the surface, besides the jet."""
Jet = Mapping[str, np.ndarray]


class Vector(np.ndarray):
    """A vector field as scikit-fem's: the value (3, ...), with ``grad`` (3, 2, ...), ``hess`` (3, 2, 2, ...) in theory
    `kirchhoff`, and the director ``d`` in theory `full`. What is computed with it is an ordinary array."""

    _part: Callable[[str], np.ndarray] | None
    _name: str

    @classmethod
    def of(cls, part: Callable[[str], np.ndarray], name: str) -> "Vector":
        out = part(name).view(cls)
        out._part, out._name = part, name
        return out

    def __array_finalize__(self, made_of: Any) -> None:
        self._part, self._name = None, ""

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return np.asarray(array)[()] if return_scalar else np.asarray(array)

    def __getitem__(self, key: Any) -> Any:
        return np.asarray(self)[key]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise UnknownField(f"{name}: a vector field has grad, hess (theory 'kirchhoff') and d (theory 'full') alone; the "
                           "fields are those of w, the last argument of a form")  # fmt: skip

    @property
    def grad(self) -> np.ndarray:
        return np.stack([self._derivative("_x"), self._derivative("_y")], axis=1)

    @property
    def hess(self) -> np.ndarray:
        xx, xy, yy = (self._derivative(each) for each in ("_xx", "_xy", "_yy"))
        return np.stack([np.stack([xx, xy], axis=1), np.stack([xy, yy], axis=1)], axis=1)

    @property
    def d(self) -> "Vector":
        if self._part is None or self._name != "r":
            raise AttributeError("only the position and its variations have a director d")
        return Vector.of(self._part, "d")

    def _derivative(self, which: str) -> np.ndarray:
        if self._part is None:
            raise AttributeError("what was computed from a field has no derivatives; take grad or hess of the field itself")
        return self._part(self._name + which)


class UnknownField(InputError, AttributeError):
    """A name that ``w`` does not have."""


def _size(v: np.ndarray) -> np.ndarray:
    """Its length; np.abs would not be analytic."""
    return np.asarray(np.sqrt((v * v).sum(axis=0)))


def _dots(first: list[np.ndarray], second: list[np.ndarray]) -> np.ndarray:
    return np.stack([np.stack([(one * two).sum(axis=0) for two in second]) for one in first])


def _normal(w: "Fields") -> np.ndarray:
    m = cross(w.part("r_x"), w.part("r_y"))
    return m / _size(m)


def _metric(w: "Fields") -> np.ndarray:
    slopes = [w.part("r_x"), w.part("r_y")]
    return _dots(slopes, slopes)


def _curvature(w: "Fields") -> np.ndarray:
    xx, xy, yy = (np.asarray((w.part(f"r_{each}") * w.n).sum(axis=0)) for each in ("xx", "xy", "yy"))
    return np.stack([np.stack([xx, xy]), np.stack([xy, yy])])


def _det(a: np.ndarray) -> np.ndarray:
    return np.asarray(a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0])


def _mean(w: "Fields") -> np.ndarray:
    a, b = w.a, w.b
    return np.asarray((a[1, 1] * b[0, 0] + a[0, 0] * b[1, 1] - 2 * a[0, 1] * b[0, 1]) / (2 * _det(a)))


def _along(w: "Fields") -> np.ndarray:
    way = w.given["along"]
    return w.part("r_x") * way[0] + w.part("r_y") * way[1]


FORMULAS: dict[str, Callable[["Fields"], np.ndarray]] = {
    "r": lambda w: Vector.of(w.part, "r"),
    "d": lambda w: Vector.of(w.part, "d"),
    "u": lambda w: w.part("r") - w.undeformed.part("r"),
    "n": _normal,
    "da": lambda w: _size(cross(w.part("r_x"), w.part("r_y"))),
    "J": lambda w: w.da / w.dA,
    "a": _metric,
    "b": _curvature,
    "H": _mean,
    "K": lambda w: _det(w.b) / _det(w.a),
}
ON_EDGES: dict[str, Callable[["Fields"], np.ndarray]] = {
    "s": lambda w: _along(w) / _size(_along(w)),
    "nu": lambda w: cross(w.s, w.n),
    "stretch": lambda w: _size(_along(w)) / _size(_along(w.undeformed)),
}
UNDEFORMED = {"X": "r", "D": "d", "N": "n", "dA": "da", "A": "a", "B": "b",
              **{f"X_{each}": f"r_{each}" for each in ("x", "y", "xx", "xy", "yy")}, "D_x": "d_x", "D_y": "d_y"}  # fmt: skip
CURVED = {"b", "B", "H", "K"}
"""What needs second derivatives."""
DIRECTORS = {"d", "d_x", "d_y", "D", "D_x", "D_y"}


class Fields(Mapping[str, Any]):
    """The fields at points, by attribute or by name.

    Attributes
    ----------
    used : set of str
        Vectors of the jet that were read.
    """

    def __init__(self, jet: Jet, undeformed: "Fields | None", given: Mapping[str, Any], case: Case) -> None:
        self.jet, self.given, self.case = jet, given, case
        self.undeformed: Fields = self if undeformed is None else undeformed
        self.used: set[str] = set()
        self._made: dict[str, Any] = {}

    def part(self, name: str) -> np.ndarray:
        """A vector of the jet."""
        if name not in self.jet:
            raise self._unknown(name)
        self.used.add(name)
        return self.jet[name]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name]

    def __getitem__(self, name: str) -> Any:
        if name not in self._made:
            value = self._value(name)
            if name in ("time", "factor"):
                return value
            self._made[name] = value
        return self._made[name]

    def _value(self, name: str) -> Any:
        if name not in self.names():
            raise self._unknown(name)
        if name in UNDEFORMED:
            return self.undeformed[UNDEFORMED[name]]
        if name == "x":
            return self.given["x"]
        if name == VELOCITY:
            self.used.add(name)
            return self.jet.get(name, np.zeros_like(self.jet["r"]))
        if name == "factor":
            return self.case.factor
        if name == "time":
            return self.case.time or 0.0
        formula = FORMULAS.get(name) or ON_EDGES.get(name)
        return self.part(name) if formula is None else formula(self)

    def names(self) -> list[str]:
        """All there are here."""
        thin = "r_xx" in self.jet
        of_edges = ON_EDGES if "along" in self.given else {}
        known = {"x", "time", "factor", VELOCITY, *self.jet, *FORMULAS, *UNDEFORMED, *of_edges}
        missing = DIRECTORS if thin else CURVED | {name for name in known if name[2:] in ("xx", "xy", "yy")}
        return sorted(known - missing)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __len__(self) -> int:
        return len(self.names())

    def _unknown(self, name: str) -> UnknownField:
        hint = ""
        if "r_xx" not in self.jet and (name in CURVED or name[2:] in ("xx", "xy", "yy")):
            hint = " (curvature needs theory 'kirchhoff', whose element is C1)"
        elif name in DIRECTORS:
            hint = " (theory 'full' has a director)"
        elif name in ON_EDGES:
            hint = " (edges have it: give where, such as where='left')"
        elif name == "y":
            hint = " (the parameters are x, y = w.x)"
        return UnknownField(f"w.{name}: there is no such field{hint}; w has {', '.join(self.names())}")
