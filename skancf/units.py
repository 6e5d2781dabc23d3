"""Names of units, and what numbers are in them: for tables and labels, never for the computation."""

import re
from dataclasses import dataclass, replace

from skancf.arguments import text
from skancf.errors import InputError, shown
from skancf.showing import short
from skancf.tabular import Columns, Tabular
from skancf.tolerances import SAME_UNIT

SIZES: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "stress": {
        "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6, "bar": 1e5, "psi": 6894.757293168361,
        "ksi": 6894757.293168361,
    },
    "energy": {"J": 1.0, "mJ": 1e-3, "kJ": 1e3, "MJ": 1e6, "N mm": 1e-3, "kN m": 1e3},
}  # fmt: skip
"""In SI."""
KINDS = {"m": "length", "N": "force", "s": "time", "Pa": "stress", "J": "energy"}
"""Units of the columns of results, and what they are units of; others have no size to change."""


@dataclass(frozen=True)
class Units:
    r"""Units in which tables and labels show numbers.

    A problem may be stated in any consistent units: the library computes with its numbers as they are, and calls them m, N,
    s and Pa. This says what they are (``stated``), and in which units to show them; it changes columns and labels alone.

    Parameters
    ----------
    length, force, time, stress, energy : str, optional
        Units to show, such as ``"mm"``, ``"kN"``, ``"ms"``, ``"MPa"``, ``"J"``. Default: those of the problem.
    stated : (3,) tuple of str
        Units of length, force and time in which the problem is stated: ``("mm", "N", "s")`` for mm, N, s, and so MPa, with
        masses in tonnes.

    Raises
    ------
    InputError
        For a name that is not known.

    Examples
    --------
    A problem in SI, shown in other units:

    >>> units = sk.Units(length="mm", force="kN", stress="MPa")
    >>> units.of("Pa"), units.of("m"), units.of("N/m")
    ((1e-06, 'MPa'), (1000.0, 'mm'), (1e-06, 'kN/mm'))

    A problem in N and mm, whose numbers are what they are:

    >>> sk.Units(stated=("mm", "N", "s")).of("Pa")
    (1.0, 'MPa')
    """

    length: str | None = None
    force: str | None = None
    time: str | None = None
    stress: str | None = None
    energy: str | None = None
    stated: tuple[str, str, str] = ("m", "N", "s")

    __repr__ = short

    def __post_init__(self) -> None:
        if not (isinstance(self.stated, tuple | list) and len(self.stated) == 3):
            raise InputError(f"stated = {shown(self.stated)}: give units of length, force and time, as in ('mm', 'N', 's')")
        object.__setattr__(self, "stated", tuple(self.stated))
        for kind, unit in zip(("length", "force", "time"), self.stated, strict=True):
            _check("stated", kind, unit)
        for kind in SIZES:
            if getattr(self, kind) is not None:
                _check(kind, kind, getattr(self, kind))

    def of(self, unit: str) -> tuple[float, str]:
        """Factor and name that show numbers of a column with a unit of SI, such as ``"N/m"``, in these units.

        Raises
        ------
        InputError
            For what is no text.
        """
        text("unit", unit)
        factor, out, sign = 1.0, "", 1
        for token in re.split(r"([ /])", unit):
            if token in (" ", "/"):
                sign = sign if token == " " else -1
                out += token
                continue
            name, power = re.fullmatch(r"(.*?)(\d*)", token).groups()  # type: ignore[union-attr]
            size, shown_as = self._one(name)
            factor *= size ** (sign * int(power or 1))
            out += shown_as + power
        return factor, out

    def _one(self, name: str) -> tuple[float, str]:
        if name == "Hz":
            return SIZES["time"]["s"] / SIZES["time"][self.stated[2]], "Hz"
        if name not in KINDS:
            return 1.0, name
        kind = KINDS[name]
        size = self._stated(kind)
        chosen = getattr(self, kind) or self._name(kind, size)
        return (size / SIZES[kind][chosen] if chosen in SIZES[kind] else 1.0), chosen

    def _stated(self, kind: str) -> float:
        """What a unit of the problem is in SI."""
        L, F, T = (SIZES[of][unit] for of, unit in zip(("length", "force", "time"), self.stated, strict=True))
        return {"length": L, "force": F, "time": T, "stress": F / L**2, "energy": F * L}[kind]

    def _name(self, kind: str, size: float) -> str:
        """The problem's own unit by its usual name, or made of those of force and length."""
        if kind in ("length", "force", "time"):
            return self.stated[("length", "force", "time").index(kind)]
        L, F, _ = self.stated
        usual = (name for name, known in SIZES[kind].items() if abs(known - size) <= SAME_UNIT * size)
        return next(usual, f"{F}/{L}2" if kind == "stress" else f"{F} {L}")

    def table(self, table: Tabular) -> Columns:
        """A table whose columns are in these units.

        Parameters
        ----------
        table : Tabular
            Any result that is a table.

        Raises
        ------
        InputError
            For what is none.

        Examples
        --------
        >>> history = sk.output.Columns({"time": [0.0, 0.1], "u3": [0.0, 2e-3]}, {"time": "s", "u3": "m"})
        >>> shown = sk.Units(length="mm").table(history)
        >>> shown.columns["u3"].tolist(), shown.units["u3"]
        ([0.0, 2.0], 'mm')
        """
        if not isinstance(table, Tabular):
            raise InputError(f"table = {shown(table)}: give a result that is a table, one with to_dataframe()")
        changed = {name: self.of(unit) for name, unit in table.units.items()}
        columns = {name: column if changed[name][0] == 1.0 else changed[name][0] * column
                   for name, column in table.columns.items()}  # fmt: skip
        return Columns(columns, {name: unit for name, (_, unit) in changed.items()})

    def with_stress(self, largest: float) -> "Units":
        """The same, stresses with a prefix that shows values up to ``largest``, in stated units, in few digits, if none was
        chosen."""
        if self.stress is not None:
            return self
        size = largest * self._stated("stress")
        name = next((name for name in ("GPa", "MPa", "kPa") if size >= SIZES["stress"][name]), "Pa")
        return replace(self, stress=name)


def _check(name: str, kind: str, unit: str) -> None:
    if not isinstance(unit, str) or unit not in SIZES[kind]:
        raise InputError(f"{name} = {shown(unit)}: is no unit of {kind} that is known; there are {', '.join(SIZES[kind])}")
