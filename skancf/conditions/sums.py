"""All conditions of a system together."""

from collections.abc import Iterator, Sequence
from itertools import count, pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.conditions.condition import Condition
from skancf.history import FULL, Case
from skancf.terms.blocks import Blocks
from skancf.tolerances import CONDITION_MET


class Conditions(Sequence[Condition]):
    """Some conditions one after another; false without any.

    Attributes
    ----------
    n : int
        Rows of all.
    names : tuple of str
        Of the conditions, each different.
    scales : (n,) array
        The size in which each row counts.
    """

    def __init__(self, conditions: Sequence[Condition], n_dofs: int) -> None:
        self._conditions, self.n_dofs = tuple(conditions), n_dofs
        self.names = _different([each.name for each in conditions])
        ends = np.cumsum([0, *(each.n for each in conditions)]).tolist()
        self.n, self._slices = ends[-1], [slice(a, b) for a, b in pairwise(ends)]
        self.scales = np.concatenate([np.zeros(0), *(each.scales for each in conditions)])

    def __len__(self) -> int:
        return len(self._conditions)

    def __getitem__(self, k: Any) -> Any:
        return self._conditions[k]

    def __iter__(self) -> Iterator[Condition]:
        return iter(self._conditions)

    def value(self, q: np.ndarray, case: Case = FULL) -> np.ndarray:
        """g, (n,)."""
        return np.concatenate([np.zeros(0), *(each.value(q, case) for each in self)])

    def gradient(self, q: np.ndarray) -> sp.csr_matrix:
        """G, (n, n_dofs)."""
        return self._stacked([each.gradient(q) for each in self])

    def between(self, q0: np.ndarray, q1: np.ndarray) -> sp.csr_matrix:
        r"""Exact discrete gradient, :math:`g(q_1) - g(q_0) = \bar G (q_1 - q_0)`, (n, n_dofs)."""
        return self._stacked([each.between(q0, q1) for each in self])

    def force(self, q: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
        r""":math:`G^T \lambda`, on the left side of the equations, (n_dofs,)."""
        return np.asarray(self.gradient(q).T @ multipliers)

    def forces_of(self, q: np.ndarray, multipliers: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
        """The same of each condition, by its name."""
        for name, each, part in zip(self.names, self, self._slices, strict=True):
            yield name, np.asarray(each.gradient(q).T @ multipliers[part])

    def add_curvature(self, q: np.ndarray, multipliers: np.ndarray, blocks: Blocks) -> None:
        """Add the derivative of :meth:`force` with respect to q."""
        for each, part in zip(self, self._slices, strict=True):
            each.add_curvature(q, multipliers[part], blocks)

    def missed(self, values: np.ndarray) -> float:
        """How far values of g are from zero: the largest in units of its scale."""
        return float((np.abs(values) / self.scales).max(initial=0.0))

    def met(self, values: np.ndarray) -> bool:
        """Whether values of g are zero but for what Newton's method and rounding leave."""
        return self.missed(values) <= CONDITION_MET

    def worst(self, q: np.ndarray, case: Case = FULL) -> str:
        """Which condition a state does not meet, and by how much, in words; nothing where it meets all."""
        values = self.value(q, case)
        if self.met(values):
            return ""
        row = int(np.argmax(np.abs(values) / self.scales))
        return f"{self.words(row)} is off by {values[row]:.3g}, which is {self.missed(values):.1e} of its scale"

    def words(self, row: int) -> str:
        """What a row is, with the name of its condition."""
        k = self._place(row)
        return f"condition {self.names[k]!r}, {self[k].rows()[row - self._slices[k].start]},"

    def owner(self, row: int) -> str:
        """The name of the condition that a row belongs to."""
        return self.names[self._place(row)]

    def named(self, multipliers: np.ndarray) -> dict[str, Any]:
        """The forces of each condition by its name, see :meth:`Condition.forces`."""
        parts = zip(self.names, self, self._slices, strict=True)
        return {name: each.forces(multipliers[part]) for name, each, part in parts}

    def resultant(self, name: str, direction: np.ndarray | None) -> np.ndarray:
        """Weights (n,) of all multipliers that make the force of one condition, see :meth:`Condition.resultant`."""
        k, out = self.names.index(name), np.zeros(self.n)
        out[self._slices[k]] = self[k].resultant(direction)
        return out

    def carried(self, multipliers: np.ndarray, onto: "Conditions") -> np.ndarray:
        """Multipliers (n,) for the same conditions on another mesh, (onto.n,)."""
        pairs = zip(self, onto, self._slices, strict=True)
        return np.concatenate([np.zeros(0), *(one.carried(multipliers[part], other) for one, other, part in pairs)])

    def histories(self) -> list[Any]:
        """Functions of time."""
        return [history for each in self for history in each.histories()]

    def _place(self, row: int) -> int:
        return next(k for k, part in enumerate(self._slices) if part.start <= row < part.stop)

    def _stacked(self, parts: list[sp.csr_matrix]) -> sp.csr_matrix:
        return sp.vstack([sp.csr_matrix((0, self.n_dofs)), *parts], format="csr")


def _different(names: list[str]) -> tuple[str, ...]:
    """Names with a number where several are equal."""
    taken, out = set(names), []
    for name in names:
        numbered = (f"{name} {k}" for k in count(1))
        out.append(name if names.count(name) == 1 else next(each for each in numbered if each not in taken))
        taken.add(out[-1])
    return tuple(out)
