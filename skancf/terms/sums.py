"""Terms of one kind together: those of the structure besides the shell, and the loads."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from skancf.history import FULL, Case, no_case
from skancf.linear import BlockMatrix
from skancf.terms.blocks import Blocks, SkewBlocks
from skancf.terms.term import Term


class Terms(Sequence[Term]):
    """Sums over some terms of a system, whose ``blocks()`` is a new sum of matrices."""

    def __init__(self, terms: Sequence[Term], n_dofs: int, blocks: Callable[[], Blocks]) -> None:
        self._terms, self.n_dofs, self._blocks = tuple(terms), n_dofs, blocks

    def __len__(self) -> int:
        return len(self._terms)

    def __getitem__(self, k: Any) -> Any:
        return self._terms[k]

    def __iter__(self) -> Iterator[Term]:
        return iter(self._terms)

    def force(self, q: np.ndarray, v: np.ndarray | None = None, case: Case = FULL) -> np.ndarray:
        """On the left side of the equations, (n_dofs,)."""
        if not isinstance(case, Case):
            raise no_case(case)
        return sum((term.force(q, v, case) for term in self._terms), np.zeros(self.n_dofs))

    def between(self, q0: np.ndarray, q1: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        """The same between two states, so that it does the work of the energy where terms know how; elsewhere in the
        middle."""
        out = np.zeros(self.n_dofs)
        for term in self._terms:
            between = term.between(q0, q1, case)
            out += term.force(0.5 * (q0 + q1), v, case) if between is None else between
        return out

    def tangent(self, q: np.ndarray, case: Case = FULL) -> BlockMatrix | None:
        """Derivative of :meth:`force`, its symmetric part; None where it is zero."""
        blocks = self._blocks()
        self.add_tangents(q, None, case, blocks)
        return None if blocks.is_zero else blocks.matrix()

    def skew(self, q: np.ndarray, case: Case = FULL) -> sp.csr_matrix | None:
        """Its skew part; None where it is zero."""
        blocks = SkewBlocks(self._blocks().pattern)
        self.add_tangents(q, None, case, blocks)
        return blocks.skew_matrix()

    def add_tangents(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Blocks, first: int = 0) -> None:
        """Add those of all from the ``first`` one on."""
        if not isinstance(case, Case):
            raise no_case(case)
        for term in self._terms[first:]:
            term.add_tangent(q, v, case, blocks)

    def damping(self, q: np.ndarray, v: np.ndarray, case: Case) -> BlockMatrix | None:
        """Derivative of :meth:`force` with respect to v, its symmetric part, without constant matrices; None where it is
        zero."""
        blocks = self._blocks()
        for term in self._terms:
            term.add_damping(q, v, case, blocks)
        return None if blocks.is_zero else blocks.matrix()

    def energy(self, q: np.ndarray, case: Case = FULL) -> float:
        """Of those that have one (J)."""
        if not isinstance(case, Case):
            raise no_case(case)
        return sum((term.energy(q, case) or 0.0 for term in self._terms), 0.0)

    def turnover(self, q0: np.ndarray, q: np.ndarray, case: Case) -> float:
        """Sum of the sizes of what their energies change by between two states (J)."""
        pairs = ((term.energy(q, case), term.energy(q0, case)) for term in self._terms)
        return sum((abs(now - before) for now, before in pairs if now is not None and before is not None), 0.0)

    def reached(self, q: np.ndarray, v: np.ndarray, case: Case) -> None:
        """Tell them that a step was accepted."""
        for term in self._terms:
            term.reached(q, v, case)

    def state(self) -> dict[str, Any]:
        """What they remember between steps, by their numbers."""
        return {str(k): term.state() for k, term in enumerate(self._terms)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to what :meth:`state` gave."""
        for k, term in enumerate(self._terms):
            term.restore(state[str(k)])

    def histories(self) -> list[Any]:
        """Functions of time, and the paths of loads that move."""
        return [history for term in self._terms for history in term.histories()]


class Loads(Terms):
    """The terms of a system that act from outside."""

    def applied(
        self, q: np.ndarray, v: np.ndarray | None = None, case: Case = FULL, potential: bool | None = None
    ) -> np.ndarray:
        """Forces on the body, (n_dofs,): of all, of those that have a potential energy, or of those that have none."""
        if not isinstance(case, Case):
            raise no_case(case)
        out = np.zeros(self.n_dofs)
        for term in self._terms:
            if potential is None or potential == (term.energy(q, case) is not None):
                out -= term.force(q, v, case)
        return out

    def places(self, case: Case = FULL) -> np.ndarray:
        """Points (2, n) of the parameter plane where loads at points and along lines act, moving ones too."""
        return np.hstack([np.empty((2, 0)), *[term.places(case) for term in self._terms]])

    def impulses(self) -> list[tuple[float, np.ndarray]]:
        """Times, ascending, and the impulses (n_dofs,) that act then, those of equal times together (N s)."""
        out: dict[float, np.ndarray] = {}
        for time, impulse in filter(None, (term.impulse() for term in self._terms)):
            out[time] = out.get(time, 0.0) + impulse
        return sorted(out.items(), key=lambda item: item[0])
