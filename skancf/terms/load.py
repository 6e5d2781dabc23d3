"""Loads as terms: what acts on the nodes of a plate, at its place in a layout; and all of a system together."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from skancf.history import FULL, Case
from skancf.layout.singularities import Singularity
from skancf.terms.shell import Shell
from skancf.terms.term import Term


class LoadTerm(Term):
    """A load of :class:`skancf.loads.acting.Acting` on a shell."""

    load = True

    def __init__(self, acting: Any, shell: Shell) -> None:
        self.acting, self.shell = acting, shell

    def force(self, q: np.ndarray, v: np.ndarray | None, case: Case) -> np.ndarray:
        return -self.shell.flat(self.acting.force(self.shell.nodal(q), case))

    def add_tangent(self, q: np.ndarray, v: np.ndarray | None, case: Case, blocks: Any) -> None:
        self.acting.add_stiffness(self.shell.nodal(q), case, self.shell.on_elements(blocks))

    def energy(self, q: np.ndarray, case: Case) -> float | None:
        """The potential energy of weight; other loads have none that is booked."""
        weight = self.acting.weight()
        if weight is None:
            return None
        return -case.factor * float(self.shell.flat(weight) @ (q - self.shell.layout.undeformed.ravel()))

    def histories(self) -> list[Any]:
        return list(self.acting.histories())

    def singularities(self, case: Case) -> list[Singularity]:
        found: list[Singularity] = self.acting.singularities(case)
        return found

    def places(self, case: Case) -> np.ndarray:
        return np.asarray(self.acting.places(case))

    def impulse(self) -> tuple[float, np.ndarray] | None:
        found = self.acting.impulse(self.shell.geometry.undeformed)
        return None if found is None else (found[0], self.shell.flat(found[1]))


class Loads(Sequence[Term]):
    """The terms of a system that act from outside."""

    def __init__(self, terms: Sequence[Term], n_dofs: int) -> None:
        self._terms, self.n_dofs = tuple(terms), n_dofs

    def __len__(self) -> int:
        return len(self._terms)

    def __getitem__(self, k: Any) -> Any:
        return self._terms[k]

    def __iter__(self) -> Iterator[Term]:
        return iter(self._terms)

    def applied(self, q: np.ndarray, v: np.ndarray | None, case: Case, potential: bool | None = None) -> np.ndarray:
        """Forces on the body, (n_dofs,): of all, of those that have a potential energy, or of those that have none."""
        out = np.zeros(self.n_dofs)
        for term in self._terms:
            if potential is None or potential == (term.energy(q, case) is not None):
                out -= term.force(q, v, case)
        return out

    def energy(self, q: np.ndarray, case: Case) -> float:
        """Potential energy of those that have one (J)."""
        return sum((term.energy(q, case) or 0.0 for term in self._terms), 0.0)

    def places(self, case: Case = FULL) -> np.ndarray:
        """Points (2, n) of the parameter plane where loads at points and along lines act, moving ones too."""
        return np.hstack([np.empty((2, 0)), *[term.places(case) for term in self._terms]])

    def impulses(self) -> list[tuple[float, np.ndarray]]:
        """Times, ascending, and the impulses (n_dofs,) that act then, those of equal times together (N s)."""
        out: dict[float, np.ndarray] = {}
        for time, impulse in filter(None, (term.impulse() for term in self._terms)):
            out[time] = out.get(time, 0.0) + impulse
        return sorted(out.items(), key=lambda item: item[0])

    def histories(self) -> list[Any]:
        """Functions of time, and the paths of loads that move."""
        return [history for term in self._terms for history in term.histories()]
