"""Loads as terms: what acts on the nodes of a plate, at its place in a layout."""

from typing import Any

import numpy as np

from skancf.history import Case
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
        if self.acting.follows:
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
