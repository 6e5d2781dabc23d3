"""What a scene is: data, and numbers with their reference values. Only the standard library: every program reads it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt

Value = float | Sequence[float]


@dataclass(frozen=True)
class Quantity:
    """A number, or a series over the scene's times, that every program is asked for.

    ``reference`` and ``uncertainty`` (relative to the scale) by theory: ``"thin"`` (curvature per undeformed length and
    Green strain of the mid-surface), ``"small"`` (thin, strains so small that measures do not differ) or ``"thick"``; a
    theory that is not named is compared with the thin one. ``scale`` is what errors are relative to; if None, the root mean
    square of the reference.
    """

    text: str
    unit: str
    reference: Mapping[str, Value]
    uncertainty: Mapping[str, float]
    source: str
    scale: float | None = None

    def error(self, value: Value, theory: str) -> float:
        """Root mean square of the difference from the reference, over the scale; infinite for what is not finite."""
        got, wanted = _series(value), _series(self.reference.get(theory, self.reference["thin"]))
        if len(got) != len(wanted):
            raise ValueError(f"{self.text}: {len(got)} values, the reference has {len(wanted)}")
        if not all(isfinite(v) for v in got):
            return float("inf")
        return root_mean_square([a - b for a, b in zip(got, wanted, strict=True)]) / (self.scale or root_mean_square(wanted))


@dataclass(frozen=True)
class Scene:
    """A problem stated once: ``data`` in SI or consistent units, ``quantities`` by name, ``times`` (s) of series."""

    name: str
    title: str
    text: str
    data: Mapping[str, float]
    quantities: Mapping[str, Quantity]
    times: tuple[float, ...] = ()
    limitless: tuple[str, ...] = ()
    """Theories in which the numbers have no limit as meshes are refined."""

    def error(self, values: Mapping[str, Value], theory: str) -> float:
        """The largest relative error of the quantities."""
        missing = sorted(set(self.quantities) - set(values))
        if missing:
            raise ValueError(f"{self.name}: no value for {missing}")
        return max(q.error(values[name], theory) for name, q in self.quantities.items())

    def own(self, theory: str) -> bool:
        """Are there reference values of this very theory?"""
        return all(theory in q.reference for q in self.quantities.values())

    def uncertainty(self, theory: str) -> float:
        """Of the reference values, relative like the errors; for a theory without its own it is not known, so infinite."""
        return max(q.uncertainty[theory] for q in self.quantities.values()) if self.own(theory) else float("inf")


def _series(value: Value) -> list[float]:
    return [float(v) for v in value] if isinstance(value, Sequence) else [float(value)]


def root_mean_square(values: Sequence[float]) -> float:
    return sqrt(sum(v * v for v in values) / len(values))
